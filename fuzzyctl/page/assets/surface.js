// An output over one input or two: a curve, or a map and a surface that turns. Computed in slices, so that no tab freezes.

const SIDE = 41, CURVE = 401, SLICE = 12, PATIENCE = 8000;

function surfaceView(system, evaluated, controls) {
    const { inputs, outputs } = system, status = element("p", { className: "note", "aria-live": "polite" });
    const view = `surface of ${JSON.stringify([system.name, ...[inputs, outputs].map((own) => own.map((v) => v.name))])}`;
    let { x, y, z, turn, tilt } = settings.get(view) ?? { x: 0, y: inputs.length > 1 ? 1 : -1, z: 0, turn: 300, tilt: 30 };
    let key = "", generation = 0, grid = null, current = [];

    const axis = (input, k, n) => input.lower + ((input.upper - input.lower) * k) / (n - 1);
    function begin() {
        const own = ++generation, values = [...controls.values], began = performance.now();
        const columns = y < 0 ? CURVE : SIDE, rows = y < 0 ? 1 : SIDE;
        grid = { columns, rows, values: new Float64Array(columns * rows).fill(NaN), low: NaN, high: NaN };
        let k = 0;
        computing.add(begin);
        function slice() {
            if (own !== generation || !map.isConnected) {
                return;
            }
            const end = performance.now() + SLICE;
            for (; k < grid.values.length && performance.now() < end; k++) {
                values[x] = axis(inputs[x], k % columns, columns);
                if (y >= 0) {
                    values[y] = axis(inputs[y], Math.floor(k / columns), rows);
                }
                grid.values[k] = evaluated(values).values[z];
            }
            const done = k === grid.values.length, late = performance.now() - began > PATIENCE;
            if (done || late) {
                const finite = grid.values.filter(Number.isFinite);
                grid.low = finite.reduce((a, b) => Math.min(a, b), Infinity);
                grid.high = finite.reduce((a, b) => Math.max(a, b), -Infinity);
                const missing = grid.values.length - finite.length;
                status.textContent = finite.length === 0 ? "No point of the picture has a value."
                    : (done ? "" : "Too slow to compute whole, stopped. ") + (grid.low < grid.high ? `From ${shown(grid.low)} to ${shown(grid.high)} over the grid.` : `${shown(grid.low)} on the whole grid.`)
                    + (missing ? ` ${missing} points without a finite value are left out.` : "");
                redraw();
                computing.delete(begin);
                settled();
            } else {
                status.textContent = `Computing: ${Math.round((100 * k) / grid.values.length)} %`;
                setTimeout(slice);
            }
        }
        slice();
    }
    const ready = () => grid !== null && grid.low <= grid.high;
    const part = (v) => (grid.high > grid.low ? (v - grid.low) / (grid.high - grid.low) : 0.5);
    const held = (v, i) => Math.min(Math.max(v, i.lower), i.upper);

    function drawMap(context, width, height) {
        if (!ready()) {
            return;
        }
        const box = [56, 10, width - 120, height - 52];
        if (y < 0) {
            const a = axes(context, box, [inputs[x].lower, inputs[x].upper], endsOf([grid.low, grid.high]));
            a.frame();
            a.heights(constantOf([grid.values]));
            a.line(Array.from(grid.values, (v, k) => [axis(inputs[x], k, CURVE), v]), lineColor(0), 2);
            if (Number.isFinite(current[z])) {
                a.dot(held(controls.values[x], inputs[x]), current[z], lineColor(1));
            }
        } else {
            const image = new ImageData(SIDE, SIDE);
            grid.values.forEach((v, k) => {
                const place = 4 * ((SIDE - 1 - Math.floor(k / SIDE)) * SIDE + (k % SIDE));
                image.data.set(Number.isFinite(v) ? [...heat(part(v)), 255] : [128, 128, 128, 60], place);
            });
            const small = element("canvas", { width: SIDE, height: SIDE });
            small.getContext("2d").putImageData(image, 0, 0);
            context.drawImage(small, ...box);
            const a = axes(context, box, [inputs[x].lower, inputs[x].upper], [inputs[y].lower, inputs[y].upper]);
            a.frame();
            a.heights();
            const [cx, cy] = [a.x(held(controls.values[x], inputs[x])), a.y(held(controls.values[y], inputs[y]))];
            for (const [style, line] of [["#000000", 4], ["#ffffff", 2]]) {
                context.strokeStyle = style;
                context.lineWidth = line;
                context.beginPath();
                context.arc(cx, cy, 6, 0, 2 * Math.PI);
                context.stroke();
            }
            const [left, top, wide, tall] = box;
            for (let k = 0; k < tall; k++) {
                context.fillStyle = `rgb(${heat(1 - k / tall)})`;
                context.fillRect(left + wide + 10, top + k, 12, 1.5);
            }
            context.fillStyle = color("note");
            context.textAlign = "left";
            context.textBaseline = "middle";
            context.fillText(shown(grid.high, 3), left + wide + 26, top + 6);
            context.fillText(shown(grid.low, 3), left + wide + 26, top + tall - 6);
        }
        context.fillStyle = color("text");
        context.textBaseline = "bottom";
        context.textAlign = "center";
        context.fillText(fitted(withUnit(inputs[x]), box[2]), box[0] + box[2] / 2, height - 4);
        context.save();
        context.translate(12, box[1] + box[3] / 2);
        context.rotate(-Math.PI / 2);
        context.textBaseline = "middle";
        context.fillText(fitted(withUnit(y < 0 ? outputs[z] : inputs[y]), box[3]), 0, 0);
        context.restore();
    }

    function drawSurface(context, width, height) {
        if (!ready() || y < 0) {
            return;
        }
        const scale = Math.min((width - 110) / 2.83, height / 3.4), [s, c] = [Math.sin, Math.cos].map((f) => f((turn * Math.PI) / 180));
        const [st, ct] = [Math.sin, Math.cos].map((f) => f((tilt * Math.PI) / 180));
        const project = (a, b, h) => {
            const right = a * c - b * s, depth = a * s + b * c;
            return [width / 2 + scale * right, height / 2 - scale * (h * ct + depth * st), depth * ct - h * st];
        };
        const unit = (v, i) => (2 * (held(v, i) - i.lower)) / (i.upper - i.lower) - 1;
        const polygon = (corners) => {
            context.beginPath();
            corners.forEach(([a, b], k) => (k ? context.lineTo(a, b) : context.moveTo(a, b)));
            context.closePath();
        };
        context.strokeStyle = color("line");
        polygon([[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => project(a, b, -0.8)));
        context.stroke();
        const at = (k, j) => grid.values[j * SIDE + k], along = (k) => (2 * k) / (SIDE - 1) - 1, tall = (v) => 1.6 * part(v) - 0.8;
        const faces = [];
        for (let j = 0; j < SIDE - 1; j++) {
            for (let k = 0; k < SIDE - 1; k++) {
                const values = [at(k, j), at(k + 1, j), at(k + 1, j + 1), at(k, j + 1)];
                if (values.every(Number.isFinite)) {
                    const corners = [[k, j], [k + 1, j], [k + 1, j + 1], [k, j + 1]].map(([a, b], n) => project(along(a), along(b), tall(values[n])));
                    faces.push({ corners, depth: corners.reduce((sum, p) => sum + p[2], 0), value: values.reduce((a, b) => a + b) / 4 });
                }
            }
        }
        faces.sort((a, b) => b.depth - a.depth);
        context.lineWidth = 0.5;
        for (const face of faces) {
            polygon(face.corners);
            context.fillStyle = `rgb(${heat(part(face.value))})`;
            context.strokeStyle = "rgba(255, 255, 255, 0.25)";
            context.fill();
            context.stroke();
        }
        if (Number.isFinite(current[z])) {
            const [a, b] = [unit(controls.values[x], inputs[x]), unit(controls.values[y], inputs[y])];
            const [px, py] = project(a, b, tall(current[z])), [fx, fy] = project(a, b, -0.8);
            context.strokeStyle = color("text");
            context.lineWidth = 1;
            context.setLineDash([3, 3]);
            context.beginPath();
            context.moveTo(fx, fy);
            context.lineTo(px, py);
            context.stroke();
            context.setLineDash([]);
            context.fillStyle = lineColor(1);
            context.strokeStyle = "#ffffff";
            context.beginPath();
            context.arc(px, py, 5, 0, 2 * Math.PI);
            context.fill();
            context.stroke();
        }
        context.fillStyle = color("text");
        context.textAlign = "center";
        context.textBaseline = "middle";
        for (const [text, a, b] of [[called(inputs[x]), 0, -1.35], [called(inputs[y]), -1.35, 0]]) {
            // The name stands at the edge that is nearer.
            const near = project(a, b, -0.8)[2] < project(-a, -b, -0.8)[2] ? 1 : -1;
            const [px, py] = project(near * a, near * b, -0.8);
            context.fillText(fitted(text, 0.3 * width), px, py);
            context.fillStyle = color("note");
            const input = inputs[a === 0 ? x : y];
            for (const [end, value] of [[-0.75, input.lower], [0.75, input.upper]]) {
                const [qx, qy] = a === 0 ? project(end, 0.84 * near * b, -0.8) : project(0.84 * near * a, end, -0.8);
                context.fillText(tickText(value, 3), qx, qy);
            }
            context.fillStyle = color("text");
        }
        if (ct > 0.3) {
            // Heights stand at the corner on the left, which hides nothing.
            const left = [[-1, -1], [1, -1], [1, 1], [-1, 1]].reduce((p, q) => (project(...q, 0)[0] < project(...p, 0)[0] ? q : p));
            const [low, high] = [project(...left, -0.8), project(...left, 0.8)];
            context.strokeStyle = color("line");
            context.beginPath();
            context.moveTo(low[0], low[1]);
            context.lineTo(high[0], high[1]);
            context.stroke();
            context.textAlign = "right";
            context.fillStyle = color("note");
            for (const [[px, py], value] of [[low, grid.low], [high, grid.high]]) {
                context.fillText(tickText(value, 3), px - 4, py - 6);
            }
        }
    }

    const map = picture(290, "", drawMap), surface = picture(290, "", drawSurface);
    map.dataset.file = `${system.name}-map`;
    surface.dataset.file = `${system.name}-surface`;
    function redraw() {
        const over = y < 0 ? withUnit(inputs[x]) : `${withUnit(inputs[x])} and ${withUnit(inputs[y])}`;
        const text = `${withUnit(outputs[z])} over ${over}, at the point ${shown(current[z])}`;
        map.setAttribute("aria-label", `${y < 0 ? "Curve" : "Map"}: ${text}`);
        surface.setAttribute("aria-label", `Surface: ${text}`);
        settings.set(view, { x, y, z, turn, tilt });
        map.again();
        surface.again();
    }
    function update(values = current, force = false) {
        current = values;
        const now = JSON.stringify([x, y, z, controls.values.filter((_, k) => k !== x && k !== y)]);
        if (now !== key || force) {
            key = now;
            begin(); // which draws at its end
        } else {
            redraw();
        }
    }
    function choose(event) {
        if (event.buttons !== 1) {
            return;
        }
        const [left, top, width, height] = [56, 10, map.clientWidth - 120, map.clientHeight - 52], box = map.getBoundingClientRect();
        const place = (part, input) => held(input.lower + (input.upper - input.lower) * part, input);
        const changes = [[x, place((event.clientX - box.left - left) / width, inputs[x])]];
        if (y >= 0) {
            changes.push([y, place(1 - (event.clientY - box.top - top) / height, inputs[y])]);
        }
        controls.set(changes);
    }
    map.addEventListener("pointerdown", choose);
    map.addEventListener("pointermove", choose);
    const angle = (text, low, high, value, changed) => {
        const id = identifier(), slider = element("input", { type: "range", id, min: low, max: high, step: 1, value });
        slider.addEventListener("input", () => { changed(slider.valueAsNumber); redraw(); });
        return [element("span", { className: "choice" }, element("label", { for: id }, text), slider), slider];
    };
    const [turning, turnSlider] = angle("turn", 0, 360, turn, (v) => (turn = v));
    const [tilting, tiltSlider] = angle("tilt", 0, 90, tilt, (v) => (tilt = v));
    surface.addEventListener("pointermove", (event) => {
        if (event.buttons === 1) {
            turnSlider.value = turn = (turn + event.movementX + 360) % 360;
            tiltSlider.value = tilt = Math.min(Math.max(tilt + 0.5 * event.movementY, 0), 90);
            redraw();
        }
    });
    const names = inputs.map(called), choices = element("div", { className: "choices" });
    const turned = element("div", {}, surface, element("div", { className: "choices" }, turning, tilting));
    function fill() {
        const other = (k) => names.findIndex((_, n) => n !== k);
        choices.replaceChildren();
        if (names.length > 1) {
            choices.append(choice("across", names, x, (k) => { x = k; y = y === k ? other(k) : y; fill(); update(); }));
            choices.append(choice("up", [...names, "nothing: a curve"], y < 0 ? names.length : y, (k) => {
                y = k === names.length ? -1 : k;
                x = x === y ? other(y) : x;
                fill();
                update();
            }));
        }
        if (outputs.length > 1) {
            choices.append(choice("output", outputs.map(called), z, (k) => { z = k; update(); }));
        }
        turned.hidden = y < 0;
    }
    fill();
    const box = element("section", {}, element("h3", {}, names.length > 1 ? "Surface" : "Curve"), choices,
        element("div", { className: "pair" }, map, turned), status);
    return { box, update };
}
