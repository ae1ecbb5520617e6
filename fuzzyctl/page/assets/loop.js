// A run of a loop, computed before: its signals over time, and their values at the time of a slider, which also moves the
// inputs of the controllers and systems of the page.

/** A line through its values at the times of the slider and the peaks between. */
function withPeaks(t, { values, peaks }) {
    const points = [...t.map((x, k) => [x, values[k]]), ...peaks[0].map((x, k) => [x, peaks[1][k]])].sort(([a], [b]) => a - b);
    return { x: points.map(([x]) => x), y: points.map(([, y]) => y) };
}

function loopSection(loop) {
    if (loop.refused || loop.t.length === 0) {
        const why = loop.refused || loop.stopped;
        return { side: [], main: [element("section", {}, element("p", { className: "warning" }, `There is no run: ${why}`))], begin() {} };
    }
    const { t, panels } = loop, bands = panels.some((p) => p.tube), references = panels.some((p) => p.reference);
    const series = [
        { name: "signal", colour: facts.colors[0], dash: "" }, ...(references ? [{ name: "reference", colour: "", dash: "5 4" }] : []),
        ...(bands ? [{ name: "all members, proved", colour: facts.colors[2], dash: "" }] : []),
    ];
    const plot = new PanelPlot({
        title: `loop ${loop.name}`, x: "t [s]", columns: panels.length > 5 ? 2 : 1, height: 110,
        series,
        panels: panels.map((p) => ({
            label: p.label, title: "", x: [t[0], Math.max(t.at(-1), t[0] + 1e-9)], y: p.y, whole: p.whole, note: p.note,
            bands: p.tube ? [{ series: series.length - 1, ...p.tube }] : [],
            lines: [...(p.reference ? [{ series: 1, ...withPeaks(t, p.reference) }] : []), { series: 0, ...withPeaks(t, p), stepped: p.held }],
        })),
    });
    const cells = panels.map(() => element("output", { className: "number" }));
    const now = element("caption", {}, "Signals");
    const signals = tableOf("Signals", [], panels.map((p, n) => [p.label, cells[n]]));
    signals.querySelector("caption").replaceWith(now);
    function show(k) {
        now.textContent = `Signals at ${shown(t[k])} s`;
        panels.forEach((p, n) => (cells[n].textContent = shown(p.values[k]) + (p.reference ? `, reference ${shown(p.reference.values[k])}` : "")));
        plot.mark(t[k]);
    }
    const side = [
        element("section", {}, element("div", { "aria-live": "polite" }, signals)),
        element("section", {}, element("h3", {}, "Results"), ...(loop.stopped ? [element("p", { className: "warning" }, loop.stopped)] : []),
            ...(loop.note ? [element("p", { className: "note" }, loop.note)] : []),
            ...(loop.measures.length ? [tableOf("Measures", [], loop.measures)] : []), ...verdictList(loop.verdicts),
            element("details", {}, element("summary", {}, "About the run"), tableOf("Facts", [], loop.facts))),
    ];
    const main = [element("section", {}, element("h3", {}, "Signals over time"), plot.box)];
    const run = { name: loop.name, t, move(k) {
        show(k);
        controlled.forEach((controls) => controls.follow(loop.inputs, k));
    } };
    return { side, main, begin: () => show(0), run };
}

/** The time of the runs at the lower edge of the window: one slider, and of several runs a choice. */
function timeBar(runs) {
    const id = identifier(), samples = runs.map(() => 0), time = element("output", { className: "number" });
    const slider = element("input", { type: "range", id, min: 0, step: 1, "aria-label": "time of the run" });
    let own = 0;
    function show() {
        Object.assign(slider, { max: runs[own].t.length - 1, value: samples[own] });
        time.textContent = `${shown(runs[own].t[samples[own]])} s`;
        slider.setAttribute("aria-valuetext", time.textContent);
    }
    function move() {
        show();
        runs[own].move(samples[own]);
    }
    slider.addEventListener("input", () => {
        samples[own] = slider.valueAsNumber;
        move();
    });
    followAgain = move;
    const name = runs.length > 1 ? choice("time of", runs.map((r) => r.name), 0, (k) => { own = k; move(); }) : element("label", { for: id }, `time of ${runs[0].name}`);
    show();
    return element("section", { className: "times", "aria-label": "Times of runs" }, element("div", { className: "control" }, name, slider, time));
}
