(() => {
  const read = (id) => document.getElementById(id).textContent;
  const looks = JSON.parse(read("looks"));
  const coarse = matchMedia("(pointer: coarse)");
  const PRINT_WIDTH = 680; // of A4 within its margins, in CSS pixels
  const plots = [...document.querySelectorAll(".plot")];
  const views = new Map();
  let printing = false;

  const figureOf = (node) => node.closest("figure");

  function viewOf(plot) {
    if (!views.has(plot)) {
      const spec = Chart.read(read(plot.dataset.spec));
      plot.view = { x: new Map(), y: new Map(), hidden: new Set(), spec };
      views.set(plot, plot.view);
    }
    return views.get(plot);
  }

  function draw(plot) {
    const view = viewOf(plot);
    const width = printing ? PRINT_WIDTH : Math.max(plot.clientWidth, 240);
    Chart.draw(plot, view.spec, looks, view, width);
    figureOf(plot).querySelector(".reset").hidden = !(view.x.size || view.y.size);
    plot.dataset.drawn = "yes";
  }

  const redraw = () => views.forEach((_, plot) => draw(plot));

  for (const plot of plots) plot.style.minHeight = "18rem";
  if ("IntersectionObserver" in window) {
    const watcher = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        if (!entry.isIntersecting) continue;
        watcher.unobserve(entry.target);
        if (!views.has(entry.target)) draw(entry.target);
      }
    }, { rootMargin: "600px" });
    plots.forEach((plot) => watcher.observe(plot));
  } else {
    plots.forEach(draw);
  }
  let wide = innerWidth;
  addEventListener("resize", () => {
    if (innerWidth === wide) return; // a phone's bars come and go
    wide = innerWidth;
    redraw();
  });

  // Values under the pointer, or where a finger has touched.
  function hideValues(plot) {
    plot.querySelector(".values")?.remove();
    plot.querySelector(".rule")?.remove();
  }

  function place(plot, event) {
    const box = plot.getBoundingClientRect();
    const scale = viewOf(plot).scale / box.width;
    return [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale];
  }

  function line(text, colour) {
    const made = document.createElement("div");
    if (colour !== undefined) made.className = `colour-${colour}`;
    made.textContent = text;
    return made;
  }

  function showValues(plot, event) {
    hideValues(plot);
    const view = viewOf(plot), [x, y] = place(plot, event);
    const panel = Chart.under(view, x, y);
    const found = panel && Chart.values(view, panel, x, y);
    if (!found) return;
    const box = document.createElement("div");
    box.className = "values";
    box.append(line(found.head), ...found.rows.map(([name, text]) => line(`${looks[name].name}: ${text}`, name)));
    plot.append(box);
    const left = found.at / (view.scale / plot.clientWidth);
    box.style.left = `${Math.max(0, Math.min(left + 12, plot.clientWidth - box.offsetWidth))}px`;
    box.style.top = `${(panel.top / view.scale) * plot.clientWidth}px`;
    const rule = document.createElementNS("http://www.w3.org/2000/svg", "path");
    rule.setAttribute("class", "rule");
    rule.setAttribute("d", `M${found.at} ${panel.top}V${panel.bottom}`);
    plot.querySelector("svg").append(rule);
  }

  const zooms = (plot, event) =>
    event.pointerType === "mouse" || figureOf(plot).querySelector(".zoom").getAttribute("aria-pressed") === "true";
  let drag = null;

  for (const plot of plots) {
    plot.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || !views.has(plot) || !zooms(plot, event)) return;
      const from = place(plot, event), panel = Chart.under(viewOf(plot), ...from);
      if (!panel) return;
      event.preventDefault();
      drag = { plot, panel, from };
      plot.setPointerCapture(event.pointerId);
    });
    plot.addEventListener("pointermove", (event) => {
      if (!views.has(plot)) return;
      if (drag?.plot !== plot) { if (event.pointerType === "mouse") showValues(plot, event); return; }
      hideValues(plot);
      const to = place(plot, event);
      const rule = document.createElementNS("http://www.w3.org/2000/svg", "path");
      rule.setAttribute("class", "rule");
      rule.setAttribute("d", `M${drag.from}H${to[0]}V${to[1]}H${drag.from[0]}Z`);
      plot.querySelector("svg").append(rule);
    });
    const release = (event) => {
      if (drag?.plot !== plot) return;
      const { panel, from } = drag, to = place(plot, event);
      drag = null;
      hideValues(plot);
      if (event.type === "pointercancel" || Math.max(...from.map((v, k) => Math.abs(v - to[k]))) <= Chart.DRAG) return;
      Chart.zoomTo(viewOf(plot), panel, from, to);
      draw(plot);
    };
    plot.addEventListener("pointerup", release);
    plot.addEventListener("pointercancel", release);
    plot.addEventListener("pointerleave", () => { if (!coarse.matches && drag?.plot !== plot) hideValues(plot); });
    plot.addEventListener("click", (event) => { if (views.has(plot) && event.pointerType !== "mouse") showValues(plot, event); });
    plot.addEventListener("dblclick", () => reset(plot));
  }

  function reset(plot) {
    const view = viewOf(plot);
    view.x.clear();
    view.y.clear();
    hideValues(plot);
    draw(plot);
  }

  function save(plot) {
    const view = viewOf(plot);
    const names = [...figureOf(plot).querySelectorAll(".legend > button")]
      .filter((button) => !view.hidden.has(Number(button.dataset.name)))
      .map((button) => ({
        text: button.textContent.trim(),
        sample: [...button.querySelector("svg").children],
        colour: getComputedStyle(button).getPropertyValue("--line").trim(),
      }));
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([Chart.picture(plot.querySelector("svg"), names)], { type: "image/svg+xml" }));
    link.download = `${plot.dataset.name}.svg`;
    link.click();
    URL.revokeObjectURL(link.href);
  }

  const pressed = (button) => {
    const now = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(now));
    return now;
  };

  // What a word means, beside it.
  function explain(term) {
    const open = document.querySelector(".meaning");
    open?.remove();
    if (!term || open?.of === term) return;
    const box = document.createElement("div");
    box.className = "meaning";
    box.setAttribute("role", "status");
    box.of = term;
    const entry = document.getElementById(term.hash.slice(1));
    const name = document.createElement("strong");
    name.textContent = entry.querySelector("dt").textContent;
    box.append(name, ` ${entry.querySelector("dd").textContent}`);
    document.body.append(box);
    const at = term.getBoundingClientRect(), page = document.documentElement.clientWidth;
    box.style.left = `${scrollX + Math.max(12, Math.min(at.left, page - box.offsetWidth - 12))}px`;
    box.style.top = `${scrollY + at.bottom + 6}px`;
  }

  document.addEventListener("click", (event) => {
    const term = event.target.closest("a.term");
    if (term) event.preventDefault();
    explain(term);
    const button = event.target.closest("figure button");
    if (button) {
      const plot = figureOf(button).querySelector(".plot");
      if (button.classList.contains("reset")) reset(plot);
      else if (button.classList.contains("save")) save(plot);
      else if (button.classList.contains("zoom")) plot.classList.toggle("zooming", pressed(button));
      else {
        viewOf(plot).hidden[pressed(button) ? "delete" : "add"](Number(button.dataset.name));
        draw(plot);
      }
    }
    const link = event.target.closest("nav.bar a");
    if (link) link.closest("details").open = false;
  });
  addEventListener("keydown", (event) => { if (event.key === "Escape") explain(null); });

  let opened = [];
  addEventListener("beforeprint", () => {
    explain(null);
    opened = [...document.querySelectorAll("main details:not([open])")];
    opened.forEach((details) => { details.open = true; });
    printing = true;
    plots.forEach(draw);
  });
  addEventListener("afterprint", () => {
    opened.forEach((details) => { details.open = false; });
    printing = false;
    redraw();
  });
})();
