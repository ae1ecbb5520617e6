// A controller: its inputs, steps by hand, its state, and its outputs over the steps.

const KEPT = 400;

function controllerSection(controller, kernel) {
    const named = controller.period === null ? [...controller.inputs, { name: "dt", label: "time between steps", unit: "s", lower: 0.001, upper: 1 }] : controller.inputs;
    const controls = inputControls(controller.name, named, () => {});
    controlled.set(controller.name, controls);
    const numbers = outputNumbers(controller.outputs);
    const count = element("p", { className: "note" }), states = element("div", {});
    let state, history;
    const canvases = controller.outputs.map((output, k) => picture(120, `${withUnit(output)} over the steps`, (context, width, height) => {
        const a = axes(context, [64, 8, width - 76, height - 30], [Math.max(0, history.first), Math.max(1, history.first + history.rows.length)],
            endsOf(history.rows.map((r) => r[k])));
        a.frame();
        a.ends();
        a.line(history.rows.map((r, n) => [history.first + n + 1, r[k]]), lineColor(k), 1.5, { stepped: true });
    }));
    function show(text = "") {
        numbers.show(history.rows.at(-1) ?? [], text);
        count.textContent = `Steps: ${history.first + history.rows.length}`;
        const rows = Object.entries(state ?? {}).map(([name, value]) =>
            [name, Array.isArray(value) ? value.map((v) => shown(v)).join(", ") : shown(value)]);
        states.replaceChildren(...(rows.length ? [tableOf("State", [], rows)] : []));
        canvases.forEach((c) => c.again());
    }
    function step(times) {
        let text = "";
        for (let k = 0; k < times && !text; k++) {
            try {
                const result = kernel.step(...(state === null ? [] : [state]), ...controls.values);
                history.rows.push(Array.isArray(result) ? result : [result]);
            } catch (error) {
                if (error.name !== "NoRuleFiresError") {
                    throw error;
                }
                text = `No rule fires for '${error.output}'; the state stays.`;
            }
            if (history.rows.length > KEPT) {
                history.rows.shift();
                history.first++;
            }
        }
        show(text);
    }
    function reset() {
        state = kernel.start === null ? null : kernel.start();
        history = { first: 0, rows: [] };
        show();
    }
    const button = (text, act) => {
        const made = element("button", { type: "button" }, text);
        made.addEventListener("click", act);
        return made;
    };
    const period = controller.period === null ? "" : `A step is ${shown(controller.period)} s.`;
    const buttons = element("div", { className: "choices" }, button("Step", () => step(1)), button("10 steps", () => step(10)),
        button("100 steps", () => step(100)), button("Begin anew", reset));
    state = kernel.start === null ? null : kernel.start();
    history = { first: 0, rows: [] };
    const parts = [
        element("section", {}, controls.form, buttons, element("p", { className: "note" }, period), numbers.box, count),
        element("section", { className: "wide" }, element("h3", {}, "Outputs"), ...canvases.flatMap((c, k) => [element("h4", {}, withUnit(controller.outputs[k])), c])),
        element("section", {}, element("h3", {}, "State"), states,
            ...(controller.facts.length ? [tableOf("Params", [], controller.facts)] : [])),
        element("section", {}, ...proofs("Bounds of outputs and states, at every step", controller)),
    ];
    return { parts, begin: reset };
}
