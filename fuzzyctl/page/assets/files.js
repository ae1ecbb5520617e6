// Pictures as files: a context that writes SVG where canvases draw, and pixels.

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

/** A canvas as a file of a format: SVG, or PNG with twice the pixels. */
async function fileOf(canvas, format) {
    const width = canvas.clientWidth, height = canvas.clientHeight, file = `${canvas.dataset.file}.${format}`;
    if (format === "svg") {
        const { context, text } = svgContext(width, height);
        canvas.draw(context, width, height);
        return { file, content: text() };
    }
    const large = element("canvas", { width: 2 * width, height: 2 * height }), context = large.getContext("2d");
    context.fillStyle = color("card");
    context.fillRect(0, 0, large.width, large.height);
    context.scale(2, 2);
    context.font = FONT;
    canvas.draw(context, width, height);
    return { file, content: await new Promise((resolve) => large.toBlob(resolve)) };
}

/** The pictures that have a name for files, as files. */
function filesOf(page, format) {
    const named = [...page.querySelectorAll("canvas[data-file]")].filter((canvas) => canvas.clientWidth > 0);
    return Promise.all(named.map((canvas) => fileOf(canvas, format)));
}
