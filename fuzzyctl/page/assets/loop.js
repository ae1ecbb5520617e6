// A run of a loop, computed before: its signals over time, and their values at the time of a slider, which also moves the
// inputs of the controllers and systems of the page.

function loopSection(loop) {
    if (loop.refused || loop.t.length === 0) {
        const why = loop.refused || loop.stopped;
        return { parts: [element("section", { className: "wide" }, element("p", { className: "warning" }, `There is no run: ${why}`))], begin() {} };
    }
    const { t, panels } = loop, id = identifier();
    let k = 0;
    const pictures = panels.map((panel) => picture(120, `${panel.label} over the time`, (context, width, height) => {
        const a = axes(context, [64, 8, width - 76, height - 30], [t[0], t.at(-1)], endsOf([...panel.values, ...(panel.reference ?? [])]));
        a.frame();
        a.ends();
        const points = (values) => values.map((v, n) => [t[n], v]);
        if (panel.reference) {
            a.line(points(panel.reference), color("note"), 1.2, { dashed: true });
        }
        a.line(points(panel.values), lineColor(0), 1.5, { stepped: panel.held });
        a.line([[t[k], a.bottom], [t[k], a.top]], color("text"), 1);
        if (panel.values[k] !== null) {
            a.dot(t[k], panel.values[k], lineColor(1));
        }
    }));
    const slider = element("input", { type: "range", id, min: 0, max: t.length - 1, step: 1, value: 0 });
    const time = element("output", { className: "number" }), cells = panels.map(() => element("output", { className: "number" }));
    function show() {
        k = slider.valueAsNumber;
        time.textContent = `${shown(t[k])} s`;
        slider.setAttribute("aria-valuetext", time.textContent);
        panels.forEach((p, n) => (cells[n].textContent = shown(p.values[k]) + (p.reference ? `, reference ${shown(p.reference[k])}` : "")));
        pictures.forEach((p) => p.again());
    }
    slider.addEventListener("input", () => {
        show();
        for (const { block, values } of loop.inputs) {
            controlled.get(block)?.set(values.map((v, n) => [n, v[k] ?? NaN]));
        }
    });
    const bar = element("div", { className: "control" }, element("label", { for: id }, `time of ${loop.name}`), slider, time);
    const parts = [
        element("section", {}, element("div", { "aria-live": "polite" }, tableOf("Signals", [], panels.map((p, n) => [p.label, cells[n]])))),
        element("section", { className: "wide" }, element("h3", {}, "Signals over the time"),
            ...pictures.flatMap((p, n) => [element("h4", {}, panels[n].label), p])),
        element("section", {}, element("h3", {}, "Measures"), ...(loop.stopped ? [element("p", { className: "warning" }, loop.stopped)] : []),
            ...(loop.note ? [element("p", { className: "note" }, loop.note)] : []),
            ...(loop.measures.length ? [tableOf("Measures", [], loop.measures)] : []), ...verdictList(loop.verdicts),
            element("details", {}, element("summary", {}, "About the run"), tableOf("Facts", [], loop.facts))),
    ];
    return { parts, begin: show, bar };
}
