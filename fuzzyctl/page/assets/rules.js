// Terms with the degrees at the point, rule tables with the cells that act, and the rules with their sets cut.

const MOST_RULES = 12;

/** A degree or activation as people read it. */
const degreeText = (own) => (own > 0 && own < 5e-4 ? "< 0.001" : shown(own, 3));

/** The terms of a variable: curves, the value, and the degrees in a list. */
function termsView(variable, degreesAt) {
    const spikes = variable.terms.filter((t) => t.at !== null), xs = places(variable);
    let curves = null;
    let value = NaN, degrees = [];
    const ends = endsOf([variable.lower, variable.upper, ...spikes.map((t) => t.at)], 0);
    const numbers = variable.terms.map(() => element("data", { className: "number" }));
    const canvas = picture(110, `Terms of ${withUnit(variable)}`, (context, width, height) => {
        const a = axes(context, [8, 8, width - 16, height - 28], ends, [0, 1.05]);
        a.frame();
        curves ??= xs.map((v) => [v, degreesAt(v)]);
        variable.terms.forEach((term, k) => {
            if (term.at !== null) {
                a.line([[term.at, 0], [term.at, 1]], lineColor(k), 2);
            } else if (term.set !== null) {
                a.line(curves.map(([v, d]) => [v, d[term.set]]), lineColor(k));
            }
        });
        if (Number.isFinite(value)) {
            const held = Math.min(Math.max(value, ends[0]), ends[1]);
            a.line([[held, 0], [held, 1.05]], color("text"), 1, { dashed: true });
            variable.terms.forEach((term, k) => {
                if (term.set !== null && degrees[term.set] > 0) {
                    a.dot(held, degrees[term.set], lineColor(k));
                }
            });
        }
    });
    const items = variable.terms.map((term, k) => {
        const swatch = element("span", { className: "swatch", "aria-hidden": "true" });
        const fill = () => (swatch.style.background = lineColor(k));
        fill();
        redraws.push(fill);
        return element("li", { title: term.text }, swatch, `${term.name} `, numbers[k]);
    });
    const box = element("div", { className: "terms" }, element("h4", {}, withUnit(variable)), canvas, element("ul", {}, ...items));
    return {
        box,
        show(now) {
            value = now;
            const held = variable.extrapolate ? now : Math.min(Math.max(now, variable.lower), variable.upper);
            degrees = Number.isNaN(held) ? [] : degreesAt(held);
            variable.terms.forEach((term, k) => {
                const own = term.set === null ? undefined : degrees[term.set];
                numbers[k].textContent = own !== undefined ? degreeText(own) : term.at !== null ? `at ${shown(term.at, 4)}` : term.set === null ? `= ${term.text}` : "";
                numbers[k].value = own === undefined ? "" : String(own);
            });
            canvas.again();
        },
    };
}

/** A rule table whose cells are lit by the activation of their rules. */
function ruleTable(table) {
    const cells = [];
    const rows = table.cells.map((row, k) => element("tr", {},
        ...(table.rows === null ? [] : [element("th", { scope: "row" }, table.row_terms[k])]),
        ...row.map((cell) => {
            const made = element("td", {}, cell === null ? "" : cell.text);
            if (cell !== null) {
                const number = element("small", {});
                made.append(number);
                cells.push([made, number, cell.rule]);
            }
            return made;
        })));
    const corner = table.rows === null ? [] : [element("th", { scope: "col" }, `${table.rows} \\ ${table.columns}`)];
    const head = element("tr", {}, ...corner, ...table.column_terms.map((t) => element("th", { scope: "col" }, t)));
    const caption = `${table.outputs} by ${table.rows === null ? table.columns : `${table.rows} and ${table.columns}`}`;
    const made = element("table", { className: "cells" }, element("caption", {}, caption), element("thead", {}, head), element("tbody", {}, ...rows));
    return {
        box: element("div", { className: "scroll", tabIndex: 0, role: "group", "aria-label": caption }, made),
        show(activations) {
            for (const [cell, number, rule] of cells) {
                const own = activations[rule];
                cell.style.setProperty("--lit", `${Math.round(70 * Math.min(Math.max(own, 0), 1)) || 0}%`);
                cell.classList.toggle("lit", own > 0);
                number.textContent = own > 0 ? degreeText(own) : "";
            }
        },
    };
}

/** What consequents leave in each output: sets cut by their activations, numbers, and all of them together. */
function ruleViewer(system, kernel) {
    const offset = system.degrees + system.rules.length;
    // What rules read and what they set: one column each, an input or an output by its position.
    const isRead = (v) => system.rules.some((r) => r.parts.some((p) => p.variable === v.name));
    const columns = [...system.inputs.map((variable, input) => ({ variable, input })).filter((c) => isRead(c.variable)),
        ...system.outputs.map((variable, output) => ({ variable, output })).filter((c) => !c.variable.formula)];
    let acting = [], values = [], outputs = [], numbers = [], state = null;
    const list = element("tbody", {}), hidden = element("p", { className: "note" });
    const table = element("table", { className: "rules" }, element("caption", {}, "Rules that act, the highest activation first"),
        element("thead", {}, element("tr", {}, ...["rule", "activation", "text"].map((h) => element("th", { scope: "col" }, h)))), list);
    const curve = (variable, set) => places(variable).map((v) => [v, kernel.sets[variable.variable](v)[set]]);
    const value = (c) => (c.value !== undefined ? c.value : c.function !== undefined ? numbers[c.function] : c.state !== undefined ? state.consequent[c.state] : NaN);
    const effect = (activity, c) => activity[offset + c.effect];
    let activity = [];
    const cut = (c, points) => points.map(([v, d]) => [v, kernel.implications[c.implication](effect(activity, c), d)]);

    function draw(context, width, height) {
        const wide = (width - 60) / columns.length, tall = 52;
        const crisp = acting.flatMap((r) => system.rules[r].consequents.map((c) => [c.output, value(c)]));
        const together = system.outputs.map(() => null);
        context.textBaseline = "middle";
        columns.forEach(({ variable }, k) => {
            context.fillStyle = color("text");
            context.textAlign = "left";
            context.fillText(fitted(called(variable), wide - 12), 60 + k * wide + 4, 10);
        });
        [...acting.slice(0, MOST_RULES), null].forEach((r, row) => {
            const top = 22 + row * tall;
            context.fillStyle = color("text");
            context.textAlign = "right";
            context.textBaseline = "middle";
            context.fillText(r === null ? "together" : `rule ${r + 1}`, 54, top + tall / 2);
            columns.forEach(({ variable, input, output: o }, k) => {
                const beside = o === undefined ? [] : [...crisp.filter(([n]) => n === o).map(([, v]) => v), outputs[o]];
                const ends = endsOf([variable.lower, variable.upper, ...beside], 0);
                const a = axes(context, [60 + k * wide + 4, top + 2, wide - 12, tall - 8], ends, [0, 1.05]);
                a.frame(r === null);
                if (o === undefined) {
                    const held = Math.min(Math.max(values[input], ends[0]), ends[1]);
                    for (const part of r === null ? [] : system.rules[r].parts.filter((p) => p.variable === variable.name)) {
                        const points = curve(variable, part.set), degree = kernel.sets[variable.variable](held)[part.set];
                        a.area(points.map(([v, d]) => [v, Math.min(d, degree)]), lineColor(0));
                        a.line(points, lineColor(0));
                    }
                    a.line([[held, 0], [held, 1.05]], color("text"), 1, { dashed: true });
                    return;
                }
                const own = (r === null ? acting : [r]).flatMap((n) => system.rules[n].consequents.filter((c) => c.output === o));
                for (const c of own) {
                    if (c.set === undefined) {
                        a.line([[value(c), 0], [value(c), effect(activity, c)]], lineColor(1), 3);
                    } else if (r !== null) {
                        const points = curve(variable, c.set);
                        a.line(points, lineColor(1));
                        a.area(cut(c, points), lineColor(1), 0.4);
                    } else if (!variable.crisp) {
                        const implied = cut(c, curve(variable, c.set)), join = kernel.aggregations[o];
                        together[o] = together[o] === null ? implied : implied.map(([v, d], n) => [v, join(together[o][n][1], d)]);
                    }
                }
                if (r === null) {
                    if (together[o] !== null) {
                        a.area(together[o].map(([v, d]) => [v, Math.min(d, 1.05)]), lineColor(1), 0.5);
                    }
                    if (Number.isFinite(outputs[o])) {
                        a.line([[outputs[o], 0], [outputs[o], 1.05]], color("text"), 2);
                    }
                }
            });
        });
    }
    const canvas = picture(100, "Rule viewer", draw);
    return {
        boxes: [element("div", { className: "scroll", tabIndex: 0, role: "group", "aria-label": "Rules that act" }, table), hidden, canvas],
        show(now) {
            ({ values, outputs, activity, numbers, state } = now);
            const activations = activity.slice(system.degrees, offset);
            const acts = (r) => activations[r] > 0 || system.rules[r].consequents.some((c) => effect(activity, c) > 0);
            acting = system.rules.map((_, r) => r).filter(acts).sort((a, b) => activations[b] - activations[a] || a - b);
            list.replaceChildren(...acting.slice(0, MOST_RULES).map((r) => element("tr", {},
                element("th", { scope: "row" }, String(r + 1)), element("td", {}, degreeText(activations[r])), element("td", {}, system.rules[r].text))));
            const more = acting.length - MOST_RULES;
            hidden.textContent = `${acting.length} of ${system.rules.length} rules act${more > 0 ? `; ${more} of them are not drawn` : ""}.`;
            const rows = Math.min(acting.length, MOST_RULES) + 1;
            canvas.setAttribute("aria-label", `Rule viewer: ${acting.length} rules with their sets cut, and all together`);
            canvas.tall(40 + 52 * rows);
            canvas.again();
        },
    };
}
