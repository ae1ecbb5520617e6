// A run of a loop, computed before: its signals over time, and their values at the time of a slider, which also moves the
// inputs of the controllers and systems of the page.

function loopSection(loop) {
    if (loop.refused || loop.t.length === 0) {
        const why = loop.refused || loop.stopped;
        return { parts: [element("section", { className: "wide" }, element("p", { className: "warning" }, `There is no run: ${why}`))], begin() {} };
    }
    const { t, panels } = loop, id = identifier();
    const plot = new PanelPlot({
        title: `loop ${loop.name}`, x: "t [s]", columns: 1, height: 110,
        series: [{ name: "signal", colour: lineColor(0), dash: "" }, ...(panels.some((p) => p.reference) ? [{ name: "reference", colour: "", dash: "5 4" }] : [])],
        panels: panels.map(({ label, held, values, reference, y, whole, note }) => ({
            label, title: "", x: [t[0], Math.max(t.at(-1), t[0] + 1e-9)], y: y ?? endsOf([...values, ...(reference ?? [])]), whole, note,
            lines: [...(reference ? [{ series: 1, x: t, y: reference }] : []), { series: 0, x: t, y: values, stepped: held }],
        })),
    });
    const slider = element("input", { type: "range", id, min: 0, max: t.length - 1, step: 1, value: 0 });
    const time = element("output", { className: "number" }), cells = panels.map(() => element("output", { className: "number" }));
    function show() {
        const k = slider.valueAsNumber;
        time.textContent = `${shown(t[k])} s`;
        slider.setAttribute("aria-valuetext", time.textContent);
        panels.forEach((p, n) => (cells[n].textContent = shown(p.values[k]) + (p.reference ? `, reference ${shown(p.reference[k])}` : "")));
        plot.mark(t[k]);
    }
    slider.addEventListener("input", () => {
        show();
        for (const { block, values } of loop.inputs) {
            controlled.get(block)?.set(values.map((v, n) => [n, v[slider.valueAsNumber] ?? NaN]));
        }
    });
    const bar = element("div", { className: "control" }, element("label", { for: id }, `time of ${loop.name}`), slider, time);
    const parts = [
        element("section", {}, element("div", { "aria-live": "polite" }, tableOf("Signals", [], panels.map((p, n) => [p.label, cells[n]])))),
        element("section", { className: "wide" }, element("h3", {}, "Signals over the time"), plot.box),
        element("section", {}, element("h3", {}, "Measures"), ...(loop.stopped ? [element("p", { className: "warning" }, loop.stopped)] : []),
            ...(loop.note ? [element("p", { className: "note" }, loop.note)] : []),
            ...(loop.measures.length ? [tableOf("Measures", [], loop.measures)] : []), ...verdictList(loop.verdicts),
            element("details", {}, element("summary", {}, "About the run"), tableOf("Facts", [], loop.facts))),
    ];
    return { parts, begin: show, bar };
}
