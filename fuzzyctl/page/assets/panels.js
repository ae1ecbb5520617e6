// Panels of lines over each other as SVG: ticks, peaks cut off, zoom, names that hide lines, a mark at a time.

const SVG = "http://www.w3.org/2000/svg", LEFT = 62, RIGHT = 16, TOP = 22, BOTTOM = 36;
let clips = 0;

/** An element of SVG within another one. */
function drawn(parent, tag, attributes, text = null) {
    const made = document.createElementNS(SVG, tag);
    for (const [key, value] of Object.entries(attributes)) {
        made.setAttribute(key, value);
    }
    if (text !== null) {
        made.textContent = text;
    }
    parent.append(made);
    return made;
}

/** Numbers of an array, where null is none, or of the bytes of single precision in Base64. */
function numbersOf(data) {
    return typeof data === "string" ? new Float32Array(Uint8Array.from(atob(data), (c) => c.charCodeAt(0)).buffer) : Float64Array.from(data, (v) => v ?? NaN);
}

/** A round distance, 1, 2 or 5 by a power of ten, that divides a span in some parts at most. */
function roundStep(span, count) {
    const raw = span / count, power = 10 ** Math.floor(Math.log10(raw));
    return [1, 2, 5, 10].find((factor) => factor * power >= raw) * power;
}

/** Round values between two ends; of a logarithmic axis powers of ten. */
function ticks([low, high], count, isLog) {
    const found = [];
    if (isLog) {
        const step = Math.max(1, Math.ceil(Math.log10(high / low) / count));
        for (let k = Math.ceil(Math.log10(low)); k <= Math.log10(high); k += step) {
            found.push(10 ** k);
        }
        return found;
    }
    const step = roundStep(high - low, count);
    for (let k = Math.ceil(low / step); k * step <= high; k++) {
        found.push(k * step);
    }
    return found;
}

/** The value of lines that are the same everywhere, null for others: their axis has that one number. */
function constantOf(lines) {
    let found = null;
    for (const values of lines) {
        for (const v of values) {
            if (v !== null && Number.isFinite(v)) {
                found ??= v;
                if (v !== found) {
                    return null;
                }
            }
        }
    }
    return found;
}

/** A value beside an axis. */
function tickText(value, digits = 6) {
    const size = Math.abs(value);
    const text = size && (size < 1e-3 || size >= 1e5) ? value.toExponential(1).replace(/\.0(?=e)/, "") : shown(value, digits);
    return text.replace("-", "\u2212");
}

/** The function from values to pixels. */
function scale([low, high], start, end, isLog) {
    const of = isLog ? Math.log10 : (v) => v, a = of(low), span = of(high) - a;
    return (v) => start + ((of(v) - a) / span) * (end - start);
}

/** Where the nearest of some rising values stands. */
function nearest(sorted, value) {
    let low = 0, high = sorted.length - 1;
    while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (sorted[middle] < value) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return value - sorted[low] < sorted[high] - value ? low : high;
}

/** Pixels as SVG takes them, which has no exponents: what lies far outside of a picture lies outside. */
const pixels = (v) => Math.min(Math.max(v, -1e5), 1e5).toFixed(1);

/** The path of a line; what has no value leaves a gap. */
function track({ x: xs, y: ys, stepped }, x, y) {
    let text = "", before = null;
    for (let k = 0; k < xs.length; k++) {
        if (!Number.isFinite(xs[k]) || !Number.isFinite(ys[k])) {
            before = null;
            continue;
        }
        const [right, down] = [pixels(x(xs[k])), pixels(y(ys[k]))];
        text += before === null ? `M${right} ${down}` : stepped ? `L${right} ${before}L${right} ${down}` : `L${right} ${down}`;
        before = down;
    }
    return text;
}

class Panel {
    constructor(plot, data, parent) {
        Object.assign(this, { plot, data, view: null, isWhole: false, id: `clip-${clips++}` });
        this.lines = data.lines.map((line) => ({ ...line, x: numbersOf(line.x), y: numbersOf(line.y) }));
        this.constant = data.bands?.length ? null : constantOf(this.lines.map((line) => line.y));
        const label = [plot.data.title, data.label, data.title].filter(Boolean).join(", ");
        this.box = element("div", { className: "panel" });
        parent.append(this.box);
        this.svg = drawn(this.box, "svg", { role: "img", "aria-label": label, ...(data.about ? { "aria-description": data.about } : {}) });
        if (data.note) {
            this.cut();
        }
        this.svg.addEventListener("pointermove", (event) => this.move(event));
        this.svg.addEventListener("pointerdown", (event) => this.press(event));
        this.svg.addEventListener("pointerup", (event) => this.release(event));
        this.svg.addEventListener("pointerleave", () => plot.say(""));
        this.svg.addEventListener("dblclick", () => plot.zoom(null, null));
    }

    cut() {
        const button = element("button", { type: "button", "aria-pressed": "false" }, "Whole range");
        this.box.append(element("p", { className: "note" }, `${this.data.note} `, button));
        button.addEventListener("click", () => {
            this.isWhole = !this.isWhole;
            button.setAttribute("aria-pressed", String(this.isWhole));
            this.draw();
        });
    }

    /** Ends of both axes; a map has the same scale on both. */
    ends(width) {
        const { data, plot } = this;
        const x = plot.view ?? data.x, y = this.view ?? (this.isWhole ? data.whole : data.y);
        if (!plot.data.map) {
            return { x, y, height: plot.data.height ?? 210 };
        }
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
        svg.replaceChildren();
        svg.setAttribute("width", LEFT + width + RIGHT);
        svg.setAttribute("height", TOP + height + BOTTOM);
        drawn(drawn(svg, "clipPath", { id: this.id }), "rect", { x: LEFT, y: TOP, width, height });
        const inside = drawn(svg, "g", { "clip-path": `url(#${this.id})` });
        Object.assign(this, { xs, ys, width, height, inside, toX: x, toY: y });
        for (const [start, stop] of plot.data.windows ?? []) {
            drawn(inside, "rect", { class: "window", x: x(start), y: TOP, width: Math.max(1, x(stop) - x(start)), height });
        }
        for (const [start, stop] of plot.data.bars ?? []) {
            drawn(inside, "rect", { class: "bar", x: x(start), y: TOP, width: Math.max(1, x(stop) - x(start)), height: 4 });
        }
        for (const value of ticks(xs, width / 70, false)) {
            drawn(inside, "line", { class: "grid", x1: x(value), x2: x(value), y1: TOP, y2: TOP + height });
            drawn(svg, "text", { class: "tick", x: x(value), y: TOP + height + 14, "text-anchor": "middle" }, tickText(value));
        }
        for (const value of this.constant === null || plot.data.map ? ticks(ys, height / 32, data.log) : [this.constant]) {
            drawn(inside, "line", { class: "grid", x1: LEFT, x2: LEFT + width, y1: y(value), y2: y(value) });
            drawn(svg, "text", { class: "tick", x: LEFT - 5, y: y(value) + 4, "text-anchor": "end" }, tickText(value, 4));
        }
        const pixels = width / (xs[1] - xs[0]);
        for (const [cx, cy, radius, isBody] of data.circles ?? []) {
            drawn(inside, "circle", { class: isBody ? "body" : "reach", cx: x(cx), cy: y(cy), r: radius * pixels });
        }
        for (const band of (data.bands ?? []).filter((b) => !plot.hidden.has(b.series))) {
            drawn(inside, "path", { class: "band", d: outline(band, x, y), fill: themed(plot.data.series[band.series].colour) });
        }
        for (const line of this.lines.filter((l) => !plot.hidden.has(l.series))) {
            const series = plot.data.series[line.series];
            drawn(inside, "path", {
                class: "line", "data-series": line.series, d: track(line, x, y), stroke: themed(series.colour) || "currentColor",
                "stroke-dasharray": line.body ? "" : series.dash, "stroke-width": line.wide ? 3 : line.body ? 0.9 : 1.4, opacity: line.wide ? 0.45 : 1,
            });
        }
        drawn(svg, "rect", { class: "frame", x: LEFT, y: TOP, width, height });
        const head = drawn(svg, "text", { x: LEFT, y: 14, class: "label" }, [data.label, data.title].filter(Boolean).join(", "));
        if (data.about) {
            drawn(head, "title", {}, data.about);
        }
        drawn(svg, "text", { x: LEFT + width, y: TOP + height + 30, "text-anchor": "end", class: "tick" }, plot.data.x);
        this.marked = [];
        this.mark();
    }

    /** Marks the place of the plot along x, and the values of all lines there. */
    mark() {
        const { plot, inside, toX, toY } = this;
        if (plot.place === null || !inside) {
            return;
        }
        this.marked.forEach((one) => one.remove());
        const at = toX(plot.place);
        this.marked = [drawn(inside, "line", { class: "mark", x1: at, x2: at, y1: TOP, y2: TOP + this.height })];
        for (const line of this.lines.filter((l) => !plot.hidden.has(l.series))) {
            const value = line.y[nearest(line.x, plot.place)];
            if (Number.isFinite(value)) {
                this.marked.push(drawn(inside, "circle", { cx: at, cy: toY(value), r: 4, fill: themed(plot.data.series[line.series].colour) || "currentColor" }));
            }
        }
    }

    at(event) {
        const frame = this.svg.getBoundingClientRect();
        const right = (event.clientX - frame.left - LEFT) / this.width;
        const up = 1 - (event.clientY - frame.top - TOP) / this.height;
        const [a, b] = this.data.log ? this.ys.map(Math.log10) : this.ys, y = a + up * (b - a);
        return [this.xs[0] + right * (this.xs[1] - this.xs[0]), this.data.log ? 10 ** y : y];
    }

    move(event) {
        const [x, y] = this.at(event), { data, hidden } = this.plot;
        if (data.map) {
            this.plot.say(`x = ${x.toFixed(2)} m, y = ${y.toFixed(2)} m`);
            return;
        }
        const parts = this.lines
            .filter((line) => !line.wide && line.x.length && !hidden.has(line.series))
            .map((line) => `${data.series[line.series].name} ${tickText(Number(line.y[nearest(line.x, x)].toPrecision(4)))}`);
        this.plot.say(`${this.data.label} at ${x.toFixed(2)} s: ${parts.join(", ")}`);
    }

    press(event) {
        if (event.button === 0) {
            this.start = this.at(event);
        }
    }

    release(event) {
        const from = this.start, to = this.at(event);
        this.start = null;
        if (!from || Math.abs(to[0] - from[0]) < 0.02 * (this.xs[1] - this.xs[0])) {
            return;
        }
        const ordered = (k) => [Math.min(from[k], to[k]), Math.max(from[k], to[k])];
        this.plot.zoom(ordered(0), this.plot.data.map ? ordered(1) : null);
    }
}

/** The outline of a band whose bounds are constant over each stretch: along the upper bounds, and back along the lower ones. */
function outline({ t, low, high }, x, y) {
    const side = (values) => values.flatMap((v, k) => [[t[k], v], [t[k + 1], v]]);
    const points = [...side(high), ...side(low).reverse()];
    return `M${points.map(([a, b]) => `${x(a).toFixed(1)} ${y(b).toFixed(1)}`).join("L")}Z`;
}

/**
 * Panels of the same lines, below each other or in columns.
 *
 * `data` has `title`, `x` (the label below), `series` (`name`, `colour`, "" for that of the text, `dash`), `columns`, and
 * `panels` with `label`, `title`, `about` (what a pointer at the label says), `lines` (`series`, `x`, `y`, `wide`, `stepped`), the ends `x` and `y`, and where `note` says
 * what these cut off, `whole`; `bands` (`series`, `t`, the ends of stretches, `low`, `high`). `height` is that of a panel [pixels]; of a `map` both axes have one scale.
 */
class PanelPlot {
    constructor(data) {
        Object.assign(this, { data, view: null, place: null, hidden: new Set() });
        const legend = element("div", { className: "legend", role: "group", "aria-label": `Lines of ${data.title}` });
        data.series.forEach((series, k) => this.entry(legend, series, k));
        const grid = element("div", { className: "panels" });
        grid.style.setProperty("--columns", data.columns);
        this.panels = data.panels.map((panel) => new Panel(this, panel, grid));
        this.readout = element("p", { className: "readout" });
        this.say("");
        this.box = element("div", {}, legend, grid, this.readout);
        redraws.push(() => this.draw());
        new ResizeObserver(() => requestAnimationFrame(() => this.resize(grid.clientWidth))).observe(grid);
    }

    entry(legend, series, k) {
        const button = element("button", { type: "button", "aria-pressed": "true" });
        const sample = drawn(button, "svg", { width: 26, height: 8, "aria-hidden": "true" });
        const line = drawn(sample, "line", { x1: 0, x2: 26, y1: 4, y2: 4, "stroke-width": 2, "stroke-dasharray": series.dash });
        const paint = () => line.setAttribute("stroke", themed(series.colour) || "currentColor");
        paint();
        redraws.push(paint);
        button.append(element("span", {}, series.name));
        button.addEventListener("click", () => {
            if (!this.hidden.delete(k)) {
                this.hidden.add(k);
            }
            button.setAttribute("aria-pressed", String(!this.hidden.has(k)));
            this.draw();
        });
        legend.append(button);
    }

    say(text) {
        this.readout.textContent = text || "\u00a0";
    }

    zoom(x, y) {
        this.view = x;
        for (const panel of this.panels) {
            panel.view = y;
        }
        this.draw();
    }

    /** Marks a place along x in all panels. */
    mark(place) {
        this.place = place;
        this.panels.forEach((panel) => panel.mark());
    }

    /** What is drawn changes the height, which says nothing new. */
    resize(width) {
        if (width !== this.width) {
            this.width = width;
            this.draw();
        }
    }

    draw() {
        this.panels.forEach((panel) => panel.draw());
    }
}
