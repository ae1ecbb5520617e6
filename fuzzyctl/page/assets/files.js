// Pictures as files: a context that writes SVG where canvases draw, and pixels.

/** Pixels of a name below a picture: across, and down. */
const WIDE = 120, TALL = 18;
const attribute = (text) => String(text).replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);
const rounded = (v) => Number(v.toFixed(2));

/** A context as canvases have it, as far as the pictures use it; its `text` is the SVG. */
function svgContext(width, height) {
    const parts = [], stack = [];
    let path = "", transform = "", dash = [];
    /** The attributes of a colour, which may be transparent. */
    function paint(kind, style) {
        const [, rgb, alpha] = /^rgba\((.*), ([\d.]+)\)$/.exec(style) ?? [null, null, 1], opacity = alpha * context.globalAlpha;
        return ` ${kind}="${attribute(rgb === null ? style : `rgb(${rgb})`)}"${opacity < 1 ? ` ${kind}-opacity="${opacity}"` : ""}`;
    }
    const add = (tag, own, inner = "") => parts.push(`<${tag}${own}${transform && ` transform="${transform.trim()}"`}>${inner}</${tag}>`);
    const to = (command, ...numbers) => (path += command + numbers.map(rounded).join(" "));
    const context = {
        fillStyle: "#000000", strokeStyle: "#000000", lineWidth: 1, globalAlpha: 1, textAlign: "start", textBaseline: "alphabetic",
        beginPath: () => (path = ""),
        moveTo: (x, y) => to("M", x, y),
        lineTo: (x, y) => to("L", x, y),
        closePath: () => to("Z"),
        /** A whole circle: no picture has another arc. */
        arc: (x, y, r) => to("M", x - r, y) + to("a", r, r, 0, 1, 0, 2 * r, 0) + to("a", r, r, 0, 1, 0, -2 * r, 0),
        setLineDash: (own) => (dash = own),
        fill: () => add("path", ` d="${path}"${paint("fill", context.fillStyle)}`),
        stroke() {
            const dashes = dash.length ? ` stroke-dasharray="${dash.join(" ")}"` : "";
            add("path", ` d="${path}" fill="none"${paint("stroke", context.strokeStyle)} stroke-width="${context.lineWidth}"${dashes}`);
        },
        fillRect: (x, y, w, h) => add("rect", ` x="${rounded(x)}" y="${rounded(y)}" width="${rounded(w)}" height="${rounded(h)}"${paint("fill", context.fillStyle)}`),
        drawImage: (image, x, y, w, h) => add("image", ` href="${image.toDataURL()}" x="${x}" y="${y}" width="${w}" height="${h}" preserveAspectRatio="none"`),
        fillText(text, x, y) {
            const anchor = { left: "start", center: "middle", right: "end" }[context.textAlign] ?? "start";
            const lower = { top: 0.8, middle: 0.35, bottom: -0.2 }[context.textBaseline] ?? 0;
            add("text", ` x="${rounded(x)}" y="${rounded(y)}" dy="${lower}em" text-anchor="${anchor}"${paint("fill", context.fillStyle)}`, attribute(text));
        },
        save: () => stack.push(transform),
        restore: () => (transform = stack.pop()),
        translate: (x, y) => (transform += ` translate(${rounded(x)} ${rounded(y)})`),
        rotate: (angle) => (transform += ` rotate(${rounded((angle * 180) / Math.PI)})`),
    };
    const text = () => `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" font-family="sans-serif" font-size="12">`
        + `<rect width="100%" height="100%" fill="${color("card")}"/>${parts.join("\n")}</svg>\n`;
    return { context, text };
}

/** A colour of the page as red, green and blue, whatever it is mixed of; null for none. */
function plain(style) {
    if (style === "none") {
        return null;
    }
    const context = element("canvas", { width: 1, height: 1 }).getContext("2d");
    context.fillStyle = style;
    context.fillRect(0, 0, 1, 1);
    const [red, green, blue, alpha] = context.getImageData(0, 0, 1, 1).data;
    return alpha ? `rgb(${red},${green},${blue})` : null;
}

/** Draws a table as it stands on the page: its cells, their colours and texts. */
function drawTable(table, context) {
    const whole = table.getBoundingClientRect();
    context.strokeStyle = color("line");
    context.lineWidth = 1;
    context.textAlign = "center";
    context.textBaseline = "middle";
    for (const cell of table.querySelectorAll("caption, th, td")) {
        const box = cell.getBoundingClientRect(), x = box.left - whole.left, y = box.top - whole.top;
        const style = getComputedStyle(cell), back = plain(style.backgroundColor);
        if (back) {
            context.fillStyle = back;
            context.fillRect(x, y, box.width, box.height);
        }
        if (cell.tagName !== "CAPTION") {
            context.beginPath();
            context.moveTo(x, y);
            for (const [right, down] of [[1, 0], [1, 1], [0, 1], [0, 0]]) {
                context.lineTo(x + right * box.width, y + down * box.height);
            }
            context.stroke();
        }
        context.fillStyle = plain(style.color);
        context.fillText([...cell.childNodes].map((n) => n.textContent).filter(Boolean).join("  "), x + box.width / 2, y + box.height / 2, box.width - 4);
    }
}

/** Names the lines of a panel beside its label where it has several, as the page does above all panels. */
function nameLines(copy, svg, width) {
    const names = svg.closest(".panels").previousElementSibling.children;
    const series = [...new Set([...svg.querySelectorAll(".line")].map((line) => Number(line.dataset.series)))].sort((a, b) => b - a);
    let right = width - RIGHT;
    for (const k of series.length > 1 ? series : []) {
        const text = names[k].textContent, left = right - 7 * text.length - 32, line = names[k].querySelector("line");
        drawn(copy, "text", { x: right, y: 14, "text-anchor": "end", "font-size": 12, fill: color("text") }, text);
        drawn(copy, "line", {
            x1: left, x2: left + 26, y1: 10, y2: 10, "stroke-width": 2, stroke: plain(getComputedStyle(line).stroke),
            "stroke-dasharray": line.getAttribute("stroke-dasharray"),
        });
        right = left - 14;
    }
}

/** A picture in SVG on the page as a text of its own, with the styles that it has there. */
function standalone(svg) {
    const copy = svg.cloneNode(true), from = [...svg.querySelectorAll("*")], { width, height } = svg.getBoundingClientRect();
    [...copy.querySelectorAll("*")].forEach((own, k) => {
        const style = getComputedStyle(from[k]);
        for (const name of ["fill", "stroke", "stroke-width", "stroke-dasharray", "fill-opacity", "stroke-opacity", "opacity", "font-size", "font-weight"]) {
            own.setAttribute(name, name === "fill" || name === "stroke" ? plain(style.getPropertyValue(name)) ?? "none" : style.getPropertyValue(name));
        }
    });
    nameLines(copy, svg, width);
    const back = drawn(copy, "rect", { width: "100%", height: "100%", fill: color("card") });
    copy.prepend(back);
    for (const [name, value] of Object.entries({ xmlns: SVG, width, height, viewBox: `0 0 ${width} ${height}`, "font-family": "sans-serif" })) {
        copy.setAttribute(name, value);
    }
    return new XMLSerializer().serializeToString(copy);
}

/** The pictures of a page by the names of their files. */
function picturesOf(page) {
    const found = new Map();
    for (const own of page.querySelectorAll("canvas[role=img], .panel svg, table.cells")) {
        const { width, height } = own.getBoundingClientRect(), block = facts.sections[Number(own.closest("article")?.id.replace("block", ""))];
        if (width === 0 || !block) {
            continue;
        }
        const label = own.getAttribute("aria-label") ?? `rule table ${own.caption.textContent}`;
        const text = label.replace(`loop ${block.name}, `, "").replace(/:.*| \[.*?\]/g, "").replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "");
        const name = own.dataset.file ?? `${block.name}-${text.toLowerCase()}`;
        let free = name;
        for (let k = 2; found.has(free); k += 1) {
            free = `${name}-${k}`;
        }
        const legend = [...own.closest(".terms")?.querySelectorAll("li") ?? []].map((li) => li.textContent.trim());
        const rows = Math.ceil(legend.length / Math.max(1, Math.floor(width / WIDE)));
        found.set(free, { own, width, height: height + rows * TALL, below: height, legend });
    }
    return found;
}

/** A picture as SVG. */
function svgOf(shown) {
    if (shown.own instanceof SVGElement) {
        return standalone(shown.own);
    }
    const { context, text } = svgContext(shown.width, shown.height);
    drawOn(shown, context);
    return text();
}

/** Draws a table, or what a canvas shows with the names of its lines below. */
function drawOn({ own, width, below, legend }, context) {
    if (!own.draw) {
        drawTable(own, context);
        return;
    }
    own.draw(context, width, below);
    context.textAlign = "left";
    context.textBaseline = "middle";
    const columns = Math.max(1, Math.floor(width / WIDE));
    legend.forEach((text, k) => {
        const x = 8 + (k % columns) * WIDE, y = below + Math.floor(k / columns) * TALL + TALL / 2;
        context.fillStyle = lineColor(k);
        context.fillRect(x, y - 5, 10, 10);
        context.fillStyle = color("text");
        context.fillText(text, x + 15, y, WIDE - 20);
    });
}

/** A picture as PNG, with twice the pixels. */
async function pngOf(shown) {
    const { own, width, height } = shown;
    const large = element("canvas", { width: 2 * width, height: 2 * height }), context = large.getContext("2d");
    context.scale(2, 2);
    if (own instanceof SVGElement) {
        const image = element("img", { src: `data:image/svg+xml,${encodeURIComponent(standalone(own))}` });
        await image.decode();
        context.drawImage(image, 0, 0, width, height);
    } else {
        context.fillStyle = color("card");
        context.fillRect(0, 0, width, height);
        context.font = FONT;
        drawOn(shown, context);
    }
    return new Promise((resolve) => large.toBlob(resolve));
}

/** Pictures of a page as files of a format, "svg" or "png", all or some by name; for "names" without what they hold. */
function filesOf(page, format, wanted) {
    const chosen = [...picturesOf(page)].filter(([name]) => wanted === null || wanted.includes(name));
    if (format === "names") {
        return Promise.resolve(chosen.map(([file]) => ({ file })));
    }
    return Promise.all(chosen.map(async ([name, shown]) => ({ file: `${name}.${format}`, content: await (format === "svg" ? svgOf(shown) : pngOf(shown)) })));
}
