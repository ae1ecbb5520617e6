// A controller: its inputs, steps by hand, its state, and its outputs over the steps.

const KEPT = 400, FIRST = 50;

/** Outputs of a controller over its steps, a plot each. */
function stepPlots(outputs, history) {
    return outputs.map((output, k) => picture(110, `${withUnit(output)} over the time of the steps`, (context, width, height) => {
        const rows = history.rows.map((r) => [r.t, r.values[k]]), last = history.rows.at(-1), constant = constantOf([rows.map(([, v]) => v)]);
        if (last === undefined) {
            return;
        }
        const isKnown = constant !== null && output.lower !== null && output.upper !== null && constant >= output.lower && constant <= output.upper;
        const ends = isKnown ? endsOf([output.lower, output.upper]) : endsOf(rows.map(([, v]) => v));
        const a = axes(context, [56, 8, width - 68, height - 28], [rows[0][0], last.t + last.dt], ends);
        a.frame();
        a.heights(isKnown ? null : constant);
        a.line([...rows, [last.t + last.dt, last.values[k]]], lineColor(0), 1.5, { stepped: true });
        context.textAlign = "center";
        context.textBaseline = "top";
        context.fillText("t [s]", width / 2, height - 16);
    }));
}

function controllerSection(controller, kernel) {
    const time = { name: "dt", label: "time between steps", unit: "s", lower: 0.001, upper: 1, start: 0.01 };
    const named = controller.period === null ? [...controller.inputs, time] : controller.inputs;
    // Without a state an output is that of the inputs, and a step shows it.
    const controls = inputControls(controller.name, named, () => controller.state || step(1));
    controlled.set(controller.name, controls);
    const numbers = outputNumbers(controller.outputs), history = { count: 0, rows: [] };
    const count = element("p", { className: "note" }), states = element("div", {});
    let state = null;
    const canvases = stepPlots(controller.outputs, history);
    function show(text = "") {
        numbers.show(history.rows.at(-1)?.values ?? [], text);
        count.textContent = `Steps: ${history.count}${history.count > KEPT ? `, the last ${KEPT} are drawn` : ""}`;
        const rows = Object.entries(controller.states).map(([name, label]) =>
            [label, Array.isArray(state[name]) ? state[name].map((v) => shown(v)).join(", ") : shown(state[name])]);
        states.replaceChildren(...(rows.length ? [tableOf("State after the last step", [], rows)] : []));
        canvases.forEach((c) => c.again());
    }
    function step(times) {
        let text = "";
        for (let k = 0; k < times && !text; k++) {
            const before = history.rows.at(-1), dt = controller.period ?? controls.values.at(-1);
            try {
                const result = kernel.step(...(state === null ? [] : [state]), ...controls.values);
                const t = before === undefined ? 0 : before.t + (controller.period ?? dt);
                history.rows.push({ t, dt, values: Array.isArray(result) ? result : [result] });
                history.count++;
            } catch (error) {
                if (error.name !== "NoRuleFiresError") {
                    throw error;
                }
                text = `No rule fires for '${error.output}'; the state stays.`;
            }
            if (history.rows.length > KEPT) {
                history.rows.shift();
            }
        }
        show(text);
    }
    function reset() {
        state = kernel.start === null ? null : kernel.start();
        Object.assign(history, { count: 0, rows: [] });
        show();
    }
    /** Makes one step at the inputs and from the state of a counterexample. */
    controls.go = (point) => {
        const at = Object.entries(point);
        controls.set(at.map(([name, value]) => [named.findIndex((i) => i.name === name), value]).filter(([k]) => k >= 0));
        reset();
        for (const [name, value] of at.map(([n, v]) => [controller.members[n] ?? n, v])) {
            if (state !== null && name in state) {
                state[name] = value;
            }
        }
        step(1);
    };
    /** Whether the first step has outputs. */
    function hasValue(values) {
        try {
            return [kernel.step(...(kernel.start === null ? [] : [kernel.start()]), ...values)].flat().every(Number.isFinite);
        } catch (error) {
            if (error.name !== "NoRuleFiresError") {
                throw error;
            }
            return false;
        }
    }
    const period = controller.period === null ? "" : `A step is ${shown(controller.period)} s.`;
    const buttons = element("div", { className: "choices" }, pushButton("Step", () => step(1)), pushButton("10 steps", () => step(10)),
        pushButton("100 steps", () => step(100)), pushButton("Begin anew", reset));
    const plots = canvases.map((c, k) => element("div", {}, element("h4", {}, withUnit(controller.outputs[k])), c));
    const isSmall = controller.outputs.length > 4;
    const side = [element("section", {}, controls.form, buttons, element("p", { className: "note" }, period, " ", count), numbers.box)];
    const main = [
        element("section", {}, element("h3", {}, "Outputs over the steps"), element("div", { className: isSmall ? "several small" : "stack" }, ...plots)),
        element("div", { className: "pair" }, element("section", {}, ...proofs("Bounds of outputs and states, at every step", controller, (point) => controls.go(point))),
            ...(controller.facts.length || Object.keys(controller.states).length ? [element("section", {}, element("h3", {}, "State and params"), states,
                ...(controller.facts.length ? [tableOf("Params", [], controller.facts)] : []))] : [])),
    ];
    const first = counterexample(controller);
    return { side, main, begin: () => { Object.keys(first).length ? controls.go(first) : (controls.begin(hasValue), reset(), step(FIRST)); } };
}
