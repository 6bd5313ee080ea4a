"use strict";
(() => {
  const read = (id) => JSON.parse(document.getElementById(id).textContent);
  const darkOf = read("colours");
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const narrow = matchMedia("(max-width: 700px)");
  const coarse = matchMedia("(pointer: coarse)");
  const PRINT_WIDTH = 680; // of A4 within its margins, in CSS pixels
  const plots = [...document.querySelectorAll(".plot")];
  const drawn = new Set();
  let printing = false;

  // What plots are drawn for. A plot says it when it is drawn, so that whoever looks can wait.
  const paper = () => (dark.matches && !printing ? "dark" : "light");

  // Colours stand under keys that end in "color"; labels never do.
  function recolour(value) {
    if (Array.isArray(value)) { value.forEach(recolour); return; }
    if (value === null || typeof value !== "object") return;
    for (const [key, entry] of Object.entries(value)) {
      if (typeof entry === "string" && key.endsWith("color")) value[key] = darkOf[entry] ?? entry;
      else if (key !== "x" && key !== "y") recolour(entry);
    }
  }

  function hiddenGroups(plot) {
    const off = plot.closest("figure").querySelectorAll('.legend [aria-pressed="false"]');
    return new Set([...off].map((button) => button.dataset.group));
  }

  function draw(plot) {
    const spec = read(plot.dataset.spec);
    const layout = narrow.matches && !printing && spec.narrow ? spec.narrow : spec.layout;
    const hidden = hiddenGroups(plot);
    for (const trace of spec.data) if (hidden.has(trace.legendgroup)) trace.visible = false;
    if (paper() === "dark") { recolour(spec.data); recolour(layout); }
    layout.showlegend = false; // the page has its own
    layout.autosize = true;
    if (printing) layout.width = PRINT_WIDTH;
    // A finger that drags scrolls the page; the bar has a button for zooming.
    layout.dragmode = coarse.matches ? false : "zoom";
    Plotly.react(plot, spec.data, layout, {
      responsive: true,
      scrollZoom: false,
      doubleClick: "reset",
      displaylogo: false,
      displayModeBar: coarse.matches ? true : "hover",
      // Nothing leaves the page: no button that uploads a figure.
      plotlyServerURL: "",
      modeBarButtons: [["toImage", "zoom2d", "pan2d", "resetScale2d"]],
      toImageButtonOptions: { format: "svg", filename: plot.dataset.name },
    });
    plot.style.minHeight = "";
    plot.dataset.drawn = paper(); // Plotly has drawn when it returns
    drawn.add(plot);
  }

  const redraw = () => drawn.forEach(draw);

  for (const plot of plots) plot.style.minHeight = plot.dataset.height + "px";
  if ("IntersectionObserver" in window) {
    const watcher = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        if (!entry.isIntersecting) continue;
        watcher.unobserve(entry.target);
        if (!drawn.has(entry.target)) draw(entry.target);
      }
    }, { rootMargin: "600px" });
    plots.forEach((plot) => watcher.observe(plot));
  } else {
    plots.forEach(draw);
  }
  dark.addEventListener("change", redraw);
  narrow.addEventListener("change", redraw);

  document.addEventListener("click", (event) => {
    const button = event.target.closest(".legend button");
    if (button) {
      button.setAttribute("aria-pressed", String(button.getAttribute("aria-pressed") !== "true"));
      draw(button.closest("figure").querySelector(".plot"));
    }
    const link = event.target.closest("nav.bar a");
    if (link) link.closest("details").open = false;
  });

  let opened = [];
  addEventListener("beforeprint", () => {
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
