"use strict";
// A figure as SVG: axes, lines, bands, bars, marks; zoom, values under a pointer, a picture.
const Chart = (() => {
  const SPACE = "http://www.w3.org/2000/svg";
  const ALONE = 290, STACKED = 180, SQUARE = 340, LEAST = 150; // heights of a panel in pixels
  const COLUMN = 220; // below such a width panels stand under each other
  const LETTER = 6.7, LINE = 17, SMALL = 12, BIG = 13; // of text, in pixels
  const PLAIN = 40; // points of a line whose ends stay off the edge of its panel
  const MARK_EVERY = 120; // pixels between marks of a longer one
  const APART = 16; // pixels between points that have a mark each
  const JAGGED = 3; // widths of a panel: on a longer line dashes are not to be seen
  const NEAR = 40; // pixels from the pointer to the values that it shows
  const MARGIN = 0.05; // part of what is drawn that an axis reaches beyond it
  const DRAG = 8, DRAG_Y = 24; // pixels that make a click a zoom, and one of both axes

  function add(parent, tag, attributes, text) {
    const made = document.createElementNS(SPACE, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    if (text !== undefined) made.textContent = text;
    parent?.append(made);
    return made;
  }

  // Numbers as benchmark/figures/chart.py tells them.
  function unpack(told) {
    if (Array.isArray(told)) return told;
    let sum = 0;
    return told.d.map((step) => {
      if (step === null) return null;
      const value = told.o + told.s * (sum += step);
      return told.log ? 10 ** value : value;
    });
  }

  function number(value, digits = 4) {
    if (value === 0) return "0";
    const size = Math.abs(value), sign = value < 0 ? "−" : "";
    if (size >= 1e-4 && size < 1e6) return sign + String(Number(size.toPrecision(digits)));
    const power = Math.floor(Math.log10(size) + 1e-9);
    const front = Number((size / 10 ** power).toPrecision(digits));
    const above = String(power).replace(/./g, (c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻");
    return `${sign}${front === 1 ? "" : front + "·"}10${above}`;
  }

  function plainTicks([low, high], count) {
    const rough = (high - low) / Math.max(count, 1);
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * ([1, 2, 5].find((part) => part * power >= rough) ?? 10);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k++) found.push(k * step);
    return found;
  }

  // Decades; within two of them 1, 2 and 5; and where those are too few, as on a plain axis.
  function logTicks([low, high], count) {
    const first = Math.floor(Math.log10(low)), last = Math.ceil(Math.log10(high));
    const within = (values) => values.filter((v) => v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9));
    const decades = Array.from({ length: last - first + 1 }, (_, k) => 10 ** (first + k));
    const seen = within(decades);
    if (seen.length > 2) return seen.filter((_, k) => k % Math.ceil(seen.length / count) === 0);
    const finer = within(decades.flatMap((d) => [d, 2 * d, 5 * d]));
    return finer.length > 2 ? finer : plainTicks([low, high], Math.min(count, 4));
  }

  const ticks = (range, log, count) => (log ? logTicks : plainTicks)(range, Math.max(3, Math.floor(count)));

  function scale([low, high], log, from, to) {
    const of = log ? Math.log10 : (v) => v;
    const a = of(low), b = of(high);
    return {
      at: (v) => from + ((of(v) - a) / (b - a)) * (to - from),
      back: (p) => { const v = a + ((p - from) / (to - from)) * (b - a); return log ? 10 ** v : v; },
    };
  }

  function wrapped(text, width) {
    const lines = [""];
    for (const word of text.split(" ")) {
      const longer = lines.at(-1) ? `${lines.at(-1)} ${word}` : word;
      if (longer.length * LETTER > width && lines.at(-1)) lines.push(word);
      else lines[lines.length - 1] = longer;
    }
    return text ? lines : [];
  }

  // Where panels stand at a width: their boxes, ranges and scales.
  function lay(spec, width, zoom) {
    const columns = width / spec.columns < COLUMN ? 1 : spec.columns;
    const narrow = columns < spec.columns ? 1 : 0;
    const gap = 26;
    const cell = (width - gap * (columns - 1)) / columns;
    const panels = spec.panels.map((panel, at) => ({
      ...panel,
      at,
      row: Math.floor(at / columns),
      column: at % columns,
      title: wrapped(panel.title, cell),
      above: wrapped(panel.y, cell),
      below: panel.labelled[narrow] ? wrapped(panel.x, cell - 46) : [],
      numbered: panel.labelled[narrow],
      range: [zoom.x.get(panel.shares) ?? panel.range[0], zoom.y.get(at) ?? panel.range[1]],
    }));
    const rows = Math.ceil(panels.length / columns);
    let top = 2;
    for (let row = 0; row < rows; row++) {
      const mine = panels.filter((panel) => panel.row === row);
      const head = LINE * Math.max(...mine.map((p) => p.title.length + p.above.length)) + 6;
      const foot = Math.max(...mine.map((p) => (p.numbered ? 22 + LINE * p.below.length : 6)));
      const square = (p) => ((cell - 46) * (p.range[1][1] - p.range[1][0])) / (p.range[0][1] - p.range[0][0]);
      const height = mine.some((p) => p.equal)
        ? Math.min(SQUARE, Math.max(LEAST, ...mine.map(square)))
        : rows === 1 ? ALONE : STACKED;
      for (const panel of mine) {
        panel.yTicks = ticks(panel.range[1], panel.logs[1], height / 34);
        const labels = panel.yTicks.map((v) => number(v).length * LETTER);
        panel.left = Math.max(30, ...labels) + 10;
        Object.assign(panel, { top: top + head, bottom: top + head + height });
      }
      top += head + height + foot + 14;
    }
    for (const panel of panels) {
      // Axes of one column begin at one place.
      const column = panels.filter((p) => p.column === panel.column);
      const start = panel.column * (cell + gap);
      panel.begin = start + Math.max(...column.map((p) => p.left));
      panel.end = start + cell - 8;
      panel.start = start;
      if (panel.equal) even(panel);
      panel.xs = scale(panel.range[0], panel.logs[0], panel.begin, panel.end);
      panel.ys = scale(panel.range[1], panel.logs[1], panel.bottom, panel.top);
      panel.xTicks = ticks(panel.range[0], panel.logs[0], (panel.end - panel.begin) / 60);
    }
    return { panels, height: top };
  }

  // One unit is as long on both axes.
  function even(panel) {
    const spans = panel.range.map(([low, high]) => high - low);
    const wide = Math.max(LEAST, ((panel.bottom - panel.top) * spans[0]) / spans[1]);
    panel.end = Math.min(panel.end, panel.begin + wide);
    const size = [panel.end - panel.begin, panel.bottom - panel.top];
    const unit = Math.max(...panel.range.map(([low, high], k) => (high - low) / size[k]));
    panel.range = panel.range.map(([low, high], k) => {
      const more = (unit * size[k] - (high - low)) / 2;
      return [low - more, high + more];
    });
    panel.yTicks = ticks(panel.range[1], false, size[1] / 34);
  }

  const short = (v) => Math.round(Math.max(-1e5, Math.min(1e5, v)) * 10) / 10;

  function axes(svg, panel) {
    const texts = [
      ...panel.title.map((text) => [text, BIG, "var(--ink)", 600]),
      ...panel.above.map((text) => [text, SMALL, "var(--muted)", 400]),
    ];
    texts.forEach(([text, size, fill, weight], k) => add(svg, "text", {
      x: panel.start, y: panel.top - 8 - LINE * (texts.length - 1 - k), fill,
      "font-size": size, "font-weight": weight,
    }, text));
    let grid = "";
    const label = { "font-size": SMALL, fill: "var(--muted)" };
    for (const v of panel.yTicks) {
      const y = short(panel.ys.at(v));
      grid += `M${panel.begin} ${y}H${panel.end}`;
      add(svg, "text", { ...label, x: panel.begin - 6, y: y + 4, "text-anchor": "end" }, number(v));
    }
    let last = -Infinity;
    for (const v of panel.xTicks) {
      const x = short(panel.xs.at(v));
      grid += `M${x} ${panel.bottom}V${panel.top}`;
      const half = (number(v).length * LETTER) / 2;
      if (!panel.numbered || x - half < last + 4) continue;
      last = x + half;
      add(svg, "text", { ...label, x, y: panel.bottom + 16, "text-anchor": "middle" }, number(v));
    }
    panel.below.forEach((text, k) => add(svg, "text", {
      ...label, x: (panel.begin + panel.end) / 2, y: panel.bottom + 34 + LINE * k, "text-anchor": "middle",
    }, text));
    add(svg, "path", { d: grid, stroke: "var(--grid)", fill: "none" });
    add(svg, "path", { d: `M${panel.begin} ${panel.top}V${panel.bottom}H${panel.end}`, stroke: "var(--muted)", "stroke-opacity": 0.6, fill: "none" });
  }

  // What a line is on its panel: its points in pixels, null in gaps.
  function points(line, panel) {
    const place = (values, s) => values.map((v) => (v === null ? null : short(s.at(v))));
    const found = { x: place(line.x, panel.xs), y: place(line.y, panel.ys) };
    for (const key of ["band", "bars"]) {
      if (line[key]) found[key] = line[key].map((values) => place(values, panel.ys));
    }
    return found;
  }

  function stretches(...curves) {
    const found = [];
    let open = null;
    curves[0].forEach((_, k) => {
      if (curves.some((c) => c[k] === null)) open = null;
      else if (open) open.push(k);
      else found.push((open = [k]));
    });
    return found;
  }

  function bandPath({ x, band: [low, high] }) {
    return stretches(x, low, high).map((part) => {
      const there = part.map((k) => `${x[k]} ${high[k]}`);
      const back = part.toReversed().map((k) => `${x[k]} ${low[k]}`);
      return `M${[...there, ...back].join("L")}Z`;
    }).join("");
  }

  function barPath({ x, y, bars: [low, high] }, bottom) {
    return x.map((at, k) => {
      if (at === null || y[k] === null) return "";
      const [from, to] = [low[k] ?? bottom, high[k] ?? y[k]];
      return from === to ? "" : `M${at - 3} ${to}h6m-3 0V${from}m-3 0h6`;
    }).join("");
  }

  function marked(at, line, share, panel) {
    const few = line.style === "points" || (panel.end - panel.begin) / at.x.length > APART;
    let gone = MARK_EVERY * (1 - share), before = null, length = 0;
    const marks = [];
    at.x.forEach((x, k) => {
      const y = at.y[k];
      if (x === null || y === null) { before = null; return; }
      if (before) {
        const step = Math.hypot(x - before[0], y - before[1]);
        length += step;
        gone += line.sorted ? x - before[0] : step;
      }
      before = [x, y];
      if (few || gone >= MARK_EVERY) { marks.push([x, y]); gone = few ? 0 : gone % MARK_EVERY; }
    });
    return { marks, jagged: length > JAGGED * (panel.end - panel.begin) };
  }

  function drawLine(group, line, panel, look, share) {
    const at = points(line, panel);
    const mine = add(group, "g", { class: `line colour-${line.name}`, "data-name": look.name });
    if (at.band) add(mine, "path", { d: bandPath(at), fill: "var(--line)", "fill-opacity": 0.16, stroke: "none" });
    const style = { fill: "none", stroke: "var(--line)", "stroke-width": look.mark ? 1.7 : 2 };
    if (at.bars) add(mine, "path", { ...style, d: barPath(at, panel.bottom), "stroke-width": 1.2 });
    const { marks, jagged } = marked(at, line, share, panel);
    if (line.style !== "points") {
      const parts = stretches(at.x, at.y);
      const d = parts.map((p) => `M${p.map((k) => `${at.x[k]} ${at.y[k]}`).join("L")}${p.length > 1 ? "" : "h.1"}`);
      const dash = line.style === "dashed" ? look.dashed : jagged ? "" : look.dash;
      add(mine, "path", { ...style, d: d.join(""), "stroke-linejoin": "round", "stroke-linecap": "butt", "stroke-dasharray": dash });
    }
    if (look.mark) {
      const d = marks.map(([x, y]) => `M${x} ${y}${look.mark}`).join("");
      add(mine, "path", { ...style, d, class: "marks", fill: look.filled ? "var(--line)" : "none", "stroke-width": 1.4 });
    }
  }

  // What a plot shows: `view` holds its zoom and the names that are hidden.
  function draw(plot, spec, looks, view, width) {
    const { panels, height } = lay(spec, width, view);
    const svg = add(null, "svg", { viewBox: `0 0 ${width} ${height}`, "font-family": "system-ui, 'Segoe UI', Roboto, Arial, sans-serif" });
    for (const panel of panels) {
      axes(svg, panel);
      const clip = `${plot.dataset.name}-${plot.id}-${panel.at}`;
      add(add(svg, "clipPath", { id: clip }), "rect", {
        x: panel.begin - 1, y: panel.top - 7, width: panel.end - panel.begin + 9, height: panel.bottom - panel.top + 14,
      });
      const group = add(svg, "g", { "clip-path": `url(#${clip})` });
      const shown = panel.lines.filter((line) => !view.hidden.has(line.name));
      shown.forEach((line, k) => drawLine(group, line, panel, looks[line.name], k / shown.length));
    }
    plot.querySelector("svg")?.remove();
    plot.prepend(svg);
    plot.style.minHeight = "";
    view.panels = panels;
    view.scale = width;
    return svg;
  }

  // From where to where axes reach. A panel whose lines all have one value says nothing about its
  // scale: it takes that of another panel with the same label, or else reaches from zero.
  function spread(curves, log) {
    let low = Infinity, high = -Infinity;
    for (const v of curves.flat()) {
      if (v === null || (log && v <= 0)) continue;
      low = Math.min(low, v);
      high = Math.max(high, v);
    }
    return low > high ? (log ? [1, 1] : [0, 0]) : [low, high];
  }

  const flat = ([low, high]) => high - low <= 1e-9 * Math.max(Math.abs(low), Math.abs(high));

  function padded([low, high], log, margin) {
    if (flat([low, high])) {
      if (log) return [low / 2, high * 2];
      return low === 0 ? [0, 1] : [Math.min(0, 2 * low), Math.max(0, 2 * high)];
    }
    if (log) return [low / (high / low) ** margin, high * (high / low) ** margin];
    return [low - margin * (high - low), high + margin * (high - low)];
  }

  function ranges(panels) {
    const ys = panels.map((p) => spread(p.lines.flatMap((l) => [l.y, ...(l.band ?? []), ...(l.bars ?? [])]), p.logs[1]));
    panels.forEach((panel, at) => {
      const alike = panels.findIndex((p, k) => p.y === panel.y && p.logs[1] === panel.logs[1] && !flat(ys[k]));
      const mine = flat(ys[at]) && alike >= 0 ? ys[alike] : ys[at];
      const sharing = panels.filter((p) => p.shares === panel.shares).flatMap((p) => p.lines);
      const marked = panel.equal || sharing.some((l) => l.style === "points" || l.x.length <= PLAIN);
      const xs = spread(sharing.map((l) => l.x), panel.logs[0]);
      panel.range = [padded(xs, panel.logs[0], marked ? MARGIN : 0), padded(mine, panel.logs[1], MARGIN)];
    });
  }

  function read(text) {
    const spec = JSON.parse(text);
    for (const line of spec.panels.flatMap((panel) => panel.lines)) {
      for (const key of ["x", "y"]) line[key] = unpack(line[key]);
      for (const key of ["band", "bars"]) if (line[key]) line[key] = line[key].map(unpack);
      line.sorted = line.x.every((x, k) => k === 0 || x === null || line.x[k - 1] === null || x >= line.x[k - 1]);
    }
    ranges(spec.panels);
    return spec;
  }

  // The panel under a point in pixels of a plot, and the values near it.
  const under = (view, x, y) => view.panels?.find((p) => x >= p.start && x <= p.end + 8 && y >= p.top - 8 && y <= p.bottom + 8);

  function nearest(line, panel, x, y) {
    let best = null;
    line.x.forEach((v, k) => {
      if (v === null || line.y[k] === null) return;
      const at = [panel.xs.at(v), panel.ys.at(line.y[k])];
      const away = line.sorted ? Math.abs(at[0] - x) + Math.abs(at[1] - y) * 1e-6 : Math.hypot(at[0] - x, at[1] - y);
      if (!best || away < best.away) best = { k, away, at };
    });
    return best;
  }

  function values(view, panel, x, y) {
    const found = panel.lines.filter((line) => !view.hidden.has(line.name))
      .map((line) => ({ line, ...nearest(line, panel, x, y) })).filter((f) => f.at && f.away < NEAR);
    if (!found.length) return null;
    const first = found.reduce((a, b) => (b.away < a.away ? b : a));
    return {
      head: `${panel.x}: ${number(first.line.x[first.k])}`,
      at: first.at[0],
      rows: found.filter((f) => Math.abs(f.at[0] - first.at[0]) < 6).map(({ line, k }) => {
        const y = number(line.y[k]);
        const ends = (line.band ?? line.bars)?.map((v) => (v[k] === null ? "–" : number(v[k])));
        return [line.name, ends && ends[0] !== ends[1] ? `${y} (${ends.join(" to ")})` : y];
      }),
    };
  }

  function zoomTo(view, panel, [x0, y0], [x1, y1]) {
    const inside = (v, low, high) => Math.max(low, Math.min(high, v));
    const xs = [x0, x1].map((v) => panel.xs.back(inside(v, panel.begin, panel.end))).sort((a, b) => a - b);
    const ys = [y0, y1].map((v) => panel.ys.back(inside(v, panel.top, panel.bottom))).sort((a, b) => a - b);
    if (Math.abs(x1 - x0) > DRAG || panel.equal) view.x.set(panel.shares, xs);
    if (Math.abs(y1 - y0) > DRAG_Y || panel.equal) view.y.set(panel.at, ys);
  }

  // The drawing as a file, with its colours in it and its legend below.
  function picture(svg, names) {
    const copy = svg.cloneNode(true);
    const originals = [...svg.querySelectorAll("*")];
    [...copy.querySelectorAll("*")].forEach((node, k) => {
      for (const key of ["fill", "stroke"]) {
        if (node.getAttribute(key)?.startsWith("var(")) node.setAttribute(key, getComputedStyle(originals[k])[key]);
      }
    });
    const [, , width, height] = copy.getAttribute("viewBox").split(" ").map(Number);
    const legend = add(copy, "g", { transform: `translate(0 ${height + 14})` });
    names.forEach(({ text, sample, colour }, k) => {
      const row = add(legend, "g", { transform: `translate(4 ${k * LINE})`, fill: "none", stroke: colour, "stroke-width": 1.7 });
      for (const node of sample) {
        const part = row.appendChild(node.cloneNode(true));
        if (part.getAttribute("class")) Object.entries({ fill: colour, "fill-opacity": part.classList.contains("band") ? 0.2 : 1 }).forEach((e) => part.setAttribute(...e));
      }
      add(row, "text", { x: 42, y: 11, "font-size": SMALL, fill: "#59626c", stroke: "none" }, text);
    });
    const tall = height + 24 + LINE * names.length;
    copy.setAttribute("viewBox", `0 0 ${width} ${tall}`);
    copy.setAttribute("width", width);
    copy.setAttribute("height", tall);
    return new XMLSerializer().serializeToString(copy);
  }

  return { draw, read, ticks, under, values, zoomTo, picture, DRAG };
})();
