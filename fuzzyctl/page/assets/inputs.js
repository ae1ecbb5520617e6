// Sliders with a field for the number beside each, and the numbers that come out.

/** The controls of systems and controllers by name, which the time of a run moves. */
const controlled = new Map();
/** Moves the controls to the time of the run that is shown. */
let followAgain = () => {};

/** What runs on the page give to the inputs of a block, for each of its calls. */
const callsOf = (block) => facts.sections.filter((s) => s.kind === "loop").flatMap((s) => s.inputs ?? []).filter((c) => c.block === block);

/** Round ends of a slider around values, with room to move beyond them. */
function roundEnds(values) {
    const low = Math.min(...values), high = Math.max(...values), span = high - low || Math.abs(high) || 1, step = roundStep(2 * span, 20);
    return [Math.floor((low - span / 2) / step + 1e-9), Math.ceil((high + span / 2) / step - 1e-9)].map((k) => Number((k * step).toPrecision(12)));
}

/** Values without the least and the greatest of them, of a run that diverges, and the first one. */
function usual(values) {
    const sorted = [...values].sort((a, b) => a - b), out = Math.floor(0.02 * values.length);
    return [...values.slice(0, 1), ...sorted.slice(out, values.length - out)];
}

/** The ends of an input's slider: its range; where that has no end, what runs give to it, without one −1 and 1. */
function sliderEnds(input, given) {
    const [low, high] = given.length ? roundEnds(given) : [-1, 1], { lower, upper } = input;
    return [lower ?? (upper === null || low < upper ? low : upper - 1), upper ?? (lower === null || high > lower ? high : lower + 1)];
}

/** Points of a grid between ends, and some more of them, the nearest to a start first; no grid of many inputs. */
function nearestFirst(start, ends, more) {
    const count = start.length, side = Math.floor(2000 ** (1 / count)), spans = ends.map(([low, high]) => high - low);
    const grid = Array.from({ length: count < 5 ? side ** count : 0 }, (_, j) =>
        ends.map(([low], k) => low + (spans[k] * (Math.floor(j / side ** k) % side)) / (side - 1)));
    return [...more, ...grid].map((point) => ({ point, far: Math.hypot(...point.map((v, k) => (v - start[k]) / spans[k])) }))
        .sort((a, b) => a.far - b.far).map(({ point }) => point);
}

/** Fields for the ends of a slider of an input whose range has none. */
function endFields(block, input, ends, changed) {
    const fields = ["lower", "upper"].map((name, k) => {
        const field = element("input", { type: "number", step: "any", value: ends[k], disabled: input[name] !== null, "aria-label": `${called(input)}, ${name} end of the slider` });
        field.addEventListener("input", () => {
            const typed = field.valueAsNumber, fits = k ? typed > ends[0] : typed < ends[1];
            field.setAttribute("aria-invalid", String(!fits));
            if (fits) {
                ends[k] = typed;
                settings.set(`ends of ${block}, ${input.name}`, [...ends]);
                changed();
            }
        });
        return field;
    });
    return element("span", { className: "ends" }, "slider from ", fields[0], " to ", fields[1]);
}

/** One row: a name, a slider, a field; `refresh` shows its number. */
function inputRow(block, input, ends, read, write) {
    const id = identifier(), isOpen = input.lower === null || input.upper === null;
    const note = element("span", { className: "note", id: `${id}-note` });
    const slider = element("input", { type: "range", step: "any", "aria-label": `${withUnit(input)}, slider` });
    const field = element("input", { type: "number", step: "any", id, "aria-describedby": note.id });
    function refresh(typed = false) {
        const value = read(), [low, high] = ends, beyond = value < low || value > high;
        Object.assign(slider, { min: low, max: high });
        slider.value = Number.isNaN(value) ? low : value;
        if (!typed) {
            field.value = Number.isNaN(value) ? "" : value;
        }
        const tail = input.extrapolate || !("extrapolate" in input) ? "beyond the range" : "counts as the end of the range";
        note.textContent = Number.isNaN(value) ? "no number" : isOpen ? "" : beyond ? tail : `${shown(low)} to ${shown(high)}`;
        note.classList.toggle("warning", Number.isNaN(value) || (beyond && !isOpen));
    }
    slider.addEventListener("input", () => write(slider.valueAsNumber));
    field.addEventListener("input", () => write(field.valueAsNumber, true));
    refresh();
    const name = element("div", { className: "name" }, element("label", { for: id }, withUnit(input)), note);
    return { row: element("div", { className: "control" }, name, slider, field, ...(isOpen ? [endFields(block, input, ends, refresh)] : [])), refresh };
}

/** Controls for inputs of a block; `moved` is called after each change. They begin at a point, or where the first run on the page does. */
function inputControls(block, inputs, moved, point = {}) {
    const kept = settings.get(`inputs of ${block}`) ?? {}, calls = callsOf(block), names = [...new Set(calls.map((c) => c.call))];
    const given = inputs.map((_, k) => usual(calls.flatMap((c) => c.values[k] ?? []).filter(Number.isFinite)));
    const ends = inputs.map((input, k) => [...(settings.get(`ends of ${block}, ${input.name}`) ?? sliderEnds(input, given[k]))]);
    const values = inputs.map((input, k) => {
        const [low, high] = ends[k], own = kept[input.name], isOpen = input.lower === null || input.upper === null;
        if (own >= (input.lower ?? -Infinity) && own <= (input.upper ?? Infinity)) {
            return own;
        }
        return point[input.name] ?? calls[0]?.values[k]?.[0] ?? input.start ?? (isOpen ? low / 4 + (3 * high) / 4 : low / 2 + high / 2);
    });
    let followed = names[0];
    function changed() {
        settings.set(`inputs of ${block}`, Object.fromEntries(inputs.map((i, k) => [i.name, values[k]])));
        moved();
    }
    const rows = inputs.map((input, k) => inputRow(block, input, ends[k], () => values[k], (value, typed) => {
        values[k] = value;
        rows[k].refresh(typed);
        changed();
    }));
    const chooser = names.length > 1 ? [choice("follows the call of", names, 0, (k) => {
        followed = names[k];
        followAgain();
    })] : [];
    function place(changes) {
        for (const [k, value] of changes) {
            values[k] = value;
            rows[k].refresh();
        }
    }
    return {
        values,
        form: element("fieldset", {}, element("legend", {}, "Inputs"), ...rows.map((r) => r.row), ...chooser),
        set(changes) {
            place(changes);
            changed();
        },
        /** Begins at the nearest point that has a value, of a grid and of `more`, unless the point was set or none has one. */
        begin(hasValue, more = () => []) {
            if (Object.keys({ ...kept, ...point }).length === 0 && !hasValue(values)) {
                place(nearestFirst(values, ends, more()).find(hasValue)?.entries() ?? []);
            }
        },
        /** Moves to values by name. */
        go(point) {
            this.set(inputs.flatMap(({ name }, k) => (name in point ? [[k, point[name]]] : [])));
        },
        /** Takes what a run gives to the chosen call at a sample; nothing where it has no such call. */
        follow(given, sample) {
            const own = given.find((c) => c.block === block && c.call === followed);
            if (own) {
                this.set(own.values.map((v, k) => [k, v[sample] ?? NaN]));
            }
        },
    };
}

/** The numbers of some outputs, which screen readers read after each change. */
function outputNumbers(outputs) {
    const cells = outputs.map(() => element("output", { className: "number" }));
    const message = element("p", { className: "warning" });
    const rows = outputs.map((o, k) => element("p", {}, `${called(o)} `, cells[k], o.unit ? ` ${o.unit}` : ""));
    const box = element("div", { className: `outputs${outputs.length > 4 ? " many" : ""}`, "aria-live": "polite", role: "status" }, ...rows, message);
    return {
        box,
        show(values, text = "") {
            cells.forEach((cell, k) => {
                cell.textContent = shown(values[k], outputs.length > 4 ? 6 : 9);
                cell.dataset.value = String(values[k]);
            });
            message.textContent = text;
        },
    };
}

const pushButton = (text, act) => element("button", { type: "button", onclick: act }, text);

/** A choice among names. */
function choice(label, names, chosen, changed) {
    const id = identifier();
    const list = element("select", { id }, ...names.map((name, k) => element("option", { value: k, selected: k === chosen }, name)));
    list.addEventListener("change", () => changed(Number(list.value)));
    return element("span", { className: "choice" }, element("label", { for: id }, label), list);
}
