"use strict";
// Draws the plots of a report as SVG. Texts are set as text only, so that no name becomes markup.
(() => {
  const SVG = "http://www.w3.org/2000/svg";
  const LEFT = 62, RIGHT = 16, TOP = 22, BOTTOM = 36, HEIGHT = 210;

  function make(parent, name, attributes = {}, text = null) {
    const isDrawn = parent.namespaceURI === SVG || name === "svg";
    const made = isDrawn ? document.createElementNS(SVG, name) : document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== null) made.textContent = text;
    parent.append(made);
    return made;
  }

  function numbers(text) {
    return new Float32Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
  }

  // Round values between two ends; of a logarithmic axis powers of ten.
  function ticks([low, high], count, isLog) {
    const found = [];
    if (isLog) {
      const step = Math.max(1, Math.ceil(Math.log10(high / low) / count));
      for (let k = Math.ceil(Math.log10(low)); k <= Math.log10(high); k += step) found.push(10 ** k);
      return found;
    }
    const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].find((factor) => factor * power >= raw) * power;
    for (let k = Math.ceil(low / step); k * step <= high; k++) found.push(k * step);
    return found;
  }

  function shown(value) {
    const size = Math.abs(value);
    if (size && (size < 1e-3 || size >= 1e5)) return value.toExponential(1).replace(/\.0(?=e)/, "").replace("-", "\u2212");
    return String(Number(value.toPrecision(6))).replace("-", "\u2212");
  }

  // The function from values to pixels.
  function scale([low, high], start, end, isLog) {
    const of = isLog ? Math.log10 : (v) => v;
    const a = of(low), span = of(high) - a;
    return (v) => start + ((of(v) - a) / span) * (end - start);
  }

  function nearest(sorted, value) {
    let low = 0, high = sorted.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (sorted[middle] < value) low = middle; else high = middle;
    }
    return value - sorted[low] < sorted[high] - value ? low : high;
  }

  function track(line, x, y) {
    let text = "", isOpen = false;
    for (let k = 0; k < line.x.length; k++) {
      const isThere = Number.isFinite(line.y[k]) && Number.isFinite(line.x[k]);
      if (isThere) text += `${isOpen ? "L" : "M"}${x(line.x[k]).toFixed(1)} ${y(line.y[k]).toFixed(1)}`;
      isOpen = isThere;
    }
    return text;
  }

  let count = 0;

  class Panel {
    constructor(plot, data, parent) {
      Object.assign(this, { plot, data, view: null, isWhole: false, id: `clip-${count++}` });
      for (const line of data.lines) [line.x, line.y] = [numbers(line.x), numbers(line.y)];
      this.box = make(parent, "div", { class: "panel" });
      const label = [plot.data.title, data.label, data.title].filter(Boolean).join(", ");
      this.svg = make(this.box, "svg", { role: "img", "aria-label": label });
      if (data.note) this.cut();
      this.svg.addEventListener("pointermove", (event) => this.move(event));
      this.svg.addEventListener("pointerdown", (event) => this.press(event));
      this.svg.addEventListener("pointerup", (event) => this.release(event));
      this.svg.addEventListener("pointerleave", () => plot.say(""));
      this.svg.addEventListener("dblclick", () => plot.zoom(null, null));
    }

    cut() {
      const note = make(this.box, "p", { class: "note" }, `${this.data.note} `);
      const button = make(note, "button", { type: "button", "aria-pressed": "false" }, "Whole range");
      button.addEventListener("click", () => {
        this.isWhole = !this.isWhole;
        button.setAttribute("aria-pressed", String(this.isWhole));
        this.draw();
      });
    }

    // Ends of both axes; a map has the same scale on both.
    ends(width) {
      const { data, plot } = this;
      const x = plot.view ?? data.x, y = this.view ?? (this.isWhole ? data.whole : data.y);
      if (!plot.data.map) return { x, y, height: HEIGHT };
      const perPixel = (x[1] - x[0]) / width;
      const height = Math.min(560, Math.max(120, (y[1] - y[0]) / perPixel));
      const grow = Math.max(0, (y[1] - y[0]) / height / perPixel - 1) * (x[1] - x[0]) / 2;
      return { x: [x[0] - grow, x[1] + grow], y, height };
    }

    draw() {
      const { data, plot, svg } = this;
      const width = Math.max(120, this.box.clientWidth - LEFT - RIGHT);
      const { x: xs, y: ys, height } = this.ends(width);
      const x = scale(xs, LEFT, LEFT + width, false), y = scale(ys, TOP + height, TOP, data.log);
      Object.assign(this, { xs, ys, width, height });
      svg.replaceChildren();
      svg.setAttribute("width", LEFT + width + RIGHT);
      svg.setAttribute("height", TOP + height + BOTTOM);
      const clip = make(make(svg, "clipPath", { id: this.id }), "rect", { x: LEFT, y: TOP, width, height });
      const inside = make(svg, "g", { "clip-path": `url(#${this.id})` });
      for (const [start, stop] of plot.data.windows)
        make(inside, "rect", { class: "window", x: x(start), y: TOP, width: Math.max(1, x(stop) - x(start)), height });
      for (const value of ticks(xs, width / 70, false)) {
        make(inside, "line", { class: "grid", x1: x(value), x2: x(value), y1: TOP, y2: TOP + height });
        make(svg, "text", { class: "tick", x: x(value), y: TOP + height + 14, "text-anchor": "middle" }, shown(value));
      }
      for (const value of ticks(ys, height / 32, data.log)) {
        make(inside, "line", { class: "grid", x1: LEFT, x2: LEFT + width, y1: y(value), y2: y(value) });
        make(svg, "text", { class: "tick", x: LEFT - 5, y: y(value) + 4, "text-anchor": "end" }, shown(value));
      }
      const pixels = width / (xs[1] - xs[0]);
      for (const [cx, cy, radius, isBody] of data.circles ?? [])
        make(inside, "circle", { class: isBody ? "body" : "reach", cx: x(cx), cy: y(cy), r: radius * pixels });
      for (const line of data.lines) {
        const series = plot.data.series[line.series];
        if (!plot.hidden.has(line.series))
          make(inside, "path", {
            class: "line", d: track(line, x, y), stroke: series.colour || "currentColor", "stroke-dasharray": series.dash,
            "stroke-width": line.wide ? 3 : 1.4, opacity: line.wide ? 0.45 : 1,
          });
      }
      make(svg, "rect", { class: "frame", x: LEFT, y: TOP, width, height });
      make(svg, "text", { x: LEFT, y: 14, class: "label" }, [data.label, data.title].filter(Boolean).join(", "));
      make(svg, "text", { x: LEFT + width, y: TOP + height + 30, "text-anchor": "end", class: "tick" }, plot.data.x);
    }

    at(event) {
      const frame = this.svg.getBoundingClientRect();
      const right = (event.clientX - frame.left - LEFT) / this.width;
      const up = 1 - (event.clientY - frame.top - TOP) / this.height;
      const [a, b] = this.data.log ? this.ys.map(Math.log10) : this.ys;
      const y = a + up * (b - a);
      return [this.xs[0] + right * (this.xs[1] - this.xs[0]), this.data.log ? 10 ** y : y];
    }

    move(event) {
      const [x, y] = this.at(event);
      if (this.plot.data.map) return this.plot.say(`x = ${x.toFixed(2)} m, y = ${y.toFixed(2)} m`);
      const parts = this.data.lines
        .filter((line) => !line.wide && line.x.length && !this.plot.hidden.has(line.series))
        .map((line) => `${this.plot.data.series[line.series].name} ${shown(Number(line.y[nearest(line.x, x)].toPrecision(4)))}`);
      this.plot.say(`${this.data.label} at ${x.toFixed(2)} s: ${parts.join(", ")}`);
    }

    press(event) {
      if (event.button === 0) this.start = this.at(event);
    }

    release(event) {
      const [from, to] = [this.start, this.at(event)];
      this.start = null;
      if (!from || Math.abs(to[0] - from[0]) < 0.02 * (this.xs[1] - this.xs[0])) return;
      const ordered = (k) => [Math.min(from[k], to[k]), Math.max(from[k], to[k])];
      this.plot.zoom(ordered(0), this.plot.data.map ? ordered(1) : null);
    }
  }

  class Plot {
    constructor(data, parent) {
      Object.assign(this, { data, view: null, hidden: new Set() });
      const legend = make(parent, "div", { class: "legend", role: "group", "aria-label": `Lines of ${data.title}` });
      data.series.forEach((series, k) => this.entry(legend, series, k));
      const grid = make(parent, "div", { class: "panels", style: `--columns: ${data.columns}` });
      this.panels = data.panels.map((panel) => new Panel(this, panel, grid));
      this.readout = make(parent, "p", { class: "readout" });
      this.say("");
      new ResizeObserver(() => requestAnimationFrame(() => this.resize(grid.clientWidth))).observe(grid);
    }

    entry(legend, series, k) {
      const button = make(legend, "button", { type: "button", "aria-pressed": "true" });
      const sample = make(button, "svg", { width: 26, height: 8, "aria-hidden": "true" });
      make(sample, "line", {
        x1: 0, x2: 26, y1: 4, y2: 4, stroke: series.colour || "currentColor", "stroke-width": 2,
        "stroke-dasharray": series.dash,
      });
      make(button, "span", {}, series.name);
      button.addEventListener("click", () => {
        if (!this.hidden.delete(k)) this.hidden.add(k);
        button.setAttribute("aria-pressed", String(!this.hidden.has(k)));
        this.draw();
      });
    }

    say(text) {
      this.readout.textContent = text || "\u00a0";
    }

    zoom(x, y) {
      this.view = x;
      for (const panel of this.panels) panel.view = y;
      this.draw();
    }

    // What is drawn changes the height, which says nothing new.
    resize(width) {
      if (width !== this.width) this.draw();
      this.width = width;
    }

    draw() {
      for (const panel of this.panels) panel.draw();
    }
  }

  const all = JSON.parse(document.getElementById("plots").textContent);
  all.forEach((data, k) => new Plot(data, document.getElementById(`plot-${k}`)));
})();
