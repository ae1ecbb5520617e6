// Sliders with a field for the number beside each, and the numbers that come out.

/** The controls of systems and controllers by name, which the time of a run moves. */
const controlled = new Map();

/** Controls for inputs of a block; `moved` is called after each change. */
function inputControls(block, inputs, moved) {
    const kept = settings.get(`inputs of ${block}`) ?? {}, holds = (i) => kept[i.name] >= i.lower && kept[i.name] <= i.upper;
    const values = inputs.map((i) => (holds(i) ? kept[i.name] : 0.5 * i.lower + 0.5 * i.upper));
    const refreshes = [];
    function changed() {
        settings.set(`inputs of ${block}`, Object.fromEntries(inputs.map((i, k) => [i.name, values[k]])));
        moved();
    }
    const rows = inputs.map((input, k) => {
        const id = identifier(), note = element("span", { className: "note", id: `${id}-note` });
        const range = { min: input.lower, max: input.upper, step: "any" };
        const slider = element("input", { type: "range", ...range, "aria-label": `${withUnit(input)}, slider` });
        const field = element("input", { type: "number", step: "any", id, "aria-describedby": note.id });
        function refresh(typed = false) {
            const value = values[k];
            slider.value = Number.isNaN(value) ? input.lower : value;
            if (!typed) {
                field.value = Number.isNaN(value) ? "" : value;
            }
            const beyond = value < input.lower || value > input.upper;
            const tail = input.extrapolate || !("extrapolate" in input) ? "beyond the range" : "counts as the end of the range";
            note.textContent = Number.isNaN(value) ? "no number" : beyond ? tail : `${shown(input.lower)} to ${shown(input.upper)}`;
            note.classList.toggle("warning", beyond || Number.isNaN(value));
        }
        slider.addEventListener("input", () => { values[k] = slider.valueAsNumber; refresh(); changed(); });
        field.addEventListener("input", () => { values[k] = field.valueAsNumber; refresh(true); changed(); });
        refreshes.push(refresh);
        refresh();
        const label = element("label", { for: id }, withUnit(input));
        return element("div", { className: "control" }, label, slider, field, note);
    });
    return {
        values,
        form: element("fieldset", {}, element("legend", {}, "Inputs"), ...rows),
        set(changes) {
            for (const [k, value] of changes) {
                values[k] = value;
                refreshes[k]();
            }
            changed();
        },
    };
}

/** The numbers of some outputs, which screen readers read after each change. */
function outputNumbers(outputs) {
    const cells = outputs.map(() => element("output", { className: "number" }));
    const message = element("p", { className: "warning" });
    const rows = outputs.map((o, k) => element("p", {}, `${called(o)} `, cells[k], o.unit ? ` ${o.unit}` : ""));
    const box = element("div", { className: "outputs", "aria-live": "polite", role: "status" }, ...rows, message);
    return {
        box,
        show(values, text = "") {
            cells.forEach((cell, k) => {
                cell.textContent = shown(values[k], 9);
                cell.dataset.value = String(values[k]);
            });
            message.textContent = text;
        },
    };
}

/** A choice among names. */
function choice(label, names, chosen, changed) {
    const id = identifier();
    const list = element("select", { id }, ...names.map((name, k) => element("option", { value: k, selected: k === chosen }, name)));
    list.addEventListener("change", () => changed(Number(list.value)));
    return element("span", { className: "choice" }, element("label", { for: id }, label), list);
}
