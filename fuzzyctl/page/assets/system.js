// One system: everything at the point of its sliders.

/** The values of inputs and states by name that refute the first claim of a block that fails; nothing where all hold. */
const counterexample = (block) => block.verdicts.find(([, , , point]) => point)?.[3] ?? {};

/** Verdicts; a refuted one has a button that calls `go` with the point that shows it. */
function verdictList(verdicts, go) {
    if (verdicts.length === 0) {
        return [];
    }
    const marks = { proved: "✓", met: "✓", "kept by this run": "✓", refuted: "✗", "not met": "✗", broken: "✗" };
    const kinds = { "✓": "holds", "✗": "fails", "?": "undecided" };
    const leads = (point) => (point ? [" ", pushButton("go to the counterexample", () => go(point))] : []);
    const items = verdicts.map(([word, claim, note, point]) => element("li", {},
        element("strong", { className: kinds[marks[word] ?? "?"] }, `${marks[word] ?? "?"} ${word}: `),
        element("code", {}, claim), note ? ` (${note})` : "", ...leads(point)));
    return [element("ul", { className: "verdicts" }, ...items)];
}

/** What is proved of a block; without bounds it has been shown without proofs. */
function proofs(caption, block, go) {
    const bounds = block.bounds ? tableOf(caption, [], block.bounds) : element("p", { className: "note" }, "Not looked for here; 'fuzzyctl prove' and 'fuzzyctl prove --bounds' do.");
    return [element("h3", {}, "Proved"), bounds, ...verdictList(block.verdicts, go)];
}

/** For each rule two points near a start: the nearest with a degree of each of its terms, and with the highest one. */
function rulePoints(system, kernel, start) {
    const near = system.inputs.map((input, k) => [...input.corners, ...even(input)].sort((a, b) => Math.abs(a - start[k]) - Math.abs(b - start[k])).map((at) => [at, kernel.sets[input.variable](at)]));
    const best = (k, set, degree) => near[k].reduce((found, own) => (degree(own[1][set]) > degree(found[1][set]) ? own : found))[0];
    return system.rules.flatMap(({ parts }) => [Math.sign, (d) => d].map((degree) => system.inputs.map(({ name }, k) => {
        const part = parts.find((p) => p.variable === name);
        return part === undefined ? start[k] : best(k, part.set, degree);
    })));
}

function systemSection(system, kernel) {
    const start = () => (kernel.start === null ? null : kernel.start());
    let state = start();
    const copy = (own) => (own.consequent === undefined ? { ...own } : { ...own, consequent: [...own.consequent] });
    /** The outputs at some inputs; where no rule fires they have no value, and a text says so. */
    function evaluated(values, own = state === null ? null : copy(state)) {
        try {
            const result = kernel.evaluate(...values, ...(own === null ? [] : [own]));
            return { values: Array.isArray(result) ? result : [result], text: "" };
        } catch (error) {
            if (error.name !== "NoRuleFiresError") {
                throw error;
            }
            return { values: system.outputs.map(() => NaN), text: `No rule fires for '${error.output}'.` };
        }
    }
    const numbers = outputNumbers(system.outputs), viewer = ruleViewer(system, kernel), tables = system.tables.map(ruleTable);
    const terms = [...system.inputs, ...system.outputs].map((v) => (v.terms.length ? termsView(v, kernel.sets[v.variable]) : null));
    const controls = inputControls(system.name, system.inputs, moved, counterexample(system)), surface = surfaceView(system, evaluated, controls);
    controlled.set(system.name, controls);
    function moved() {
        const values = controls.values, missing = values.some(Number.isNaN), before = state === null ? null : copy(state);
        const found = evaluated(values, state);
        const rest = before === null ? [] : [before];
        const activity = missing ? [] : kernel.activity(...values, ...rest), functions = missing ? [] : kernel.values(...values);
        numbers.show(found.values, missing ? "An input has no number." : found.text);
        terms.forEach((t, k) => t?.show([...values, ...found.values][k]));
        tables.forEach((t) => t.show(activity.slice(system.degrees, system.degrees + system.rules.length)));
        viewer.show({ values, outputs: found.values, activity, numbers: functions, state: before });
        surface.update(found.values);
    }
    const about = tableOf("Facts", [], [...system.facts]);
    const side = [
        element("section", {}, controls.form, numbers.box),
        element("section", {}, ...proofs("Bounds of outputs, for all inputs", system, (point) => controls.go(point)),
            element("details", {}, element("summary", {}, "About the system"), about)),
    ];
    const own = [
        surface.box,
        element("section", {}, element("h3", {}, "Terms"),
            element("div", { className: "several small" }, ...terms.filter((t) => t !== null).map((t) => t.box))),
        element("section", {}, element("h3", {}, "Rules"), ...tables.map((t) => t.box), ...viewer.boxes),
    ];
    const hasValue = (values) => evaluated(values).values.every(Number.isFinite);
    return { side, main: own, begin() {
        controls.begin(hasValue, () => rulePoints(system, kernel, controls.values));
        moved();
    } };
}
