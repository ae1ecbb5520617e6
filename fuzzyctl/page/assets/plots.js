// Elements of the page and plots on canvases. Every text of a file goes through textContent.

let facts = JSON.parse(document.getElementById("facts").textContent);
const FONT = "12px system-ui, sans-serif";
const redraws = [], pictures = [];
/** Whether pictures are drawn: not before the first paint, which would wait for them. */
let isDrawn = false;
/** What people set on the page, such as the values of sliders, by name: a page of a new text begins with it. */
const settings = new Map();
/** Surfaces that are being computed, and what is called when the last one is done. */
const computing = new Set();
let settled = () => {};
let identifiers = 0;

/** An element with properties, attributes (names with "-" and role) and children; texts become text nodes. */
function element(tag, own = {}, ...children) {
    const made = document.createElement(tag);
    for (const [key, value] of Object.entries(own)) {
        if (key.includes("-") || key === "role" || key === "for" || key === "scope") {
            made.setAttribute(key, value);
        } else {
            made[key] = value;
        }
    }
    made.append(...children);
    return made;
}

const identifier = () => `e${++identifiers}`;

/** A number as people read it. */
function shown(value, digits = 6) {
    if (value === undefined) {
        return "none yet";
    }
    if (value === null || Number.isNaN(value)) {
        return "no value (NaN)";
    }
    return Number.isFinite(value) ? String(Number(value.toPrecision(digits))) : value > 0 ? "infinite" : "-infinite";
}

const called = (signal) => signal.label || signal.name;
const withUnit = (signal) => called(signal) + (signal.unit ? ` [${signal.unit}]` : "");
/** Colours of the page by name, until its scheme changes. */
const known = new Map();
function color(name) {
    if (!known.has(name)) {
        known.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
    }
    return known.get(name);
}
/** A colour of the palette as the page shows it: black is that of the text, in the dark the two blues change places. */
const themed = (own) => ({ "#000000": color("text"), "#0072B2": color("accent"), "#56B4E9": color("lit-color") })[own] ?? own;
/** The colour of the n-th line. */
const lineColor = (n) => themed(facts.colors[n % facts.colors.length]);

/** A canvas that draws again when its size or the colours of the page change. Its size is measured apart: each look costs a layout. */
function picture(height, label, draw) {
    const canvas = element("canvas", { role: "img", "aria-label": label });
    let size = [0, 0];
    canvas.draw = draw;
    canvas.tall = (own) => {
        canvas.style.height = `${own}px`;
        size[1] = own;
    };
    canvas.measure = () => (size = [canvas.clientWidth, canvas.clientHeight]);
    canvas.again = () => {
        const [width, own] = size, ratio = window.devicePixelRatio || 1;
        if (width === 0) {
            return;
        }
        canvas.width = Math.round(width * ratio);
        canvas.height = Math.round(own * ratio);
        const context = canvas.getContext("2d");
        context.scale(ratio, ratio);
        context.font = FONT;
        draw(context, width, own);
    };
    canvas.tall(height);
    pictures.push(canvas);
    redraws.push(canvas.again);
    new ResizeObserver(() => {
        const before = String(size);
        if (isDrawn && String(canvas.measure()) !== before) {
            canvas.again();
        }
    }).observe(canvas);
    return canvas;
}

let ruler = null;
/** A text that fits into a width [pixels], its end left out where it is longer. */
function fitted(text, width) {
    ruler ??= document.createElement("canvas").getContext("2d");
    ruler.font = FONT;
    if (ruler.measureText(text).width <= width) {
        return text;
    }
    let length = text.length;
    while (length > 1 && ruler.measureText(`${text.slice(0, length)}…`).width > width) {
        length--;
    }
    return `${text.slice(0, length)}…`;
}

/** Axes within a part of a canvas: functions from values to pixels, and lines of values. */
function axes(context, box, xEnds, yEnds) {
    const [left, top, width, height] = box;
    const x = (v) => left + (width * (v - xEnds[0])) / (xEnds[1] - xEnds[0]);
    const y = (v) => top + height - (height * (v - yEnds[0])) / (yEnds[1] - yEnds[0]);
    function path(points, stepped) {
        context.beginPath();
        let before = null;
        for (const [a, b] of points) {
            if (b === null || !Number.isFinite(b)) {
                before = null;
            } else if (before === null) {
                context.moveTo(x(a), (before = y(b)));
            } else {
                if (stepped) {
                    context.lineTo(x(a), before);
                }
                context.lineTo(x(a), (before = y(b)));
            }
        }
    }
    return {
        x, y, bottom: yEnds[0], top: yEnds[1],
        frame(ticks = true) {
            context.strokeStyle = color("line");
            context.lineWidth = 1;
            context.beginPath();
            context.moveTo(left, top);
            context.lineTo(left, top + height);
            context.lineTo(left + width, top + height);
            context.stroke();
            if (ticks) {
                context.fillStyle = color("note");
                context.textBaseline = "top";
                for (const [value, side] of [[xEnds[0], "left"], [xEnds[1], "right"]]) {
                    context.textAlign = side;
                    context.fillText(shown(value, 4), x(value), top + height + 4);
                }
            }
        },
        /** Round numbers along the vertical axis; one for a constant. */
        heights(constant = null) {
            context.textAlign = "right";
            context.textBaseline = "middle";
            for (const value of constant === null ? ticks(yEnds, height / 32, false) : [constant]) {
                context.globalAlpha = 0.35;
                context.strokeStyle = color("line");
                context.beginPath();
                context.moveTo(left, y(value));
                context.lineTo(left + width, y(value));
                context.stroke();
                context.globalAlpha = 1;
                context.fillStyle = color("note");
                context.fillText(tickText(value, 4), left - 5, y(value));
            }
        },
        line(points, style, width = 1.5, { dashed = false, stepped = false } = {}) {
            path(points, stepped);
            context.strokeStyle = style;
            context.lineWidth = width;
            context.setLineDash(dashed ? [5, 4] : []);
            context.stroke();
            context.setLineDash([]);
        },
        area(points, style, alpha = 0.3) {
            path([[points[0][0], yEnds[0]], ...points, [points.at(-1)[0], yEnds[0]]], false);
            context.globalAlpha = alpha;
            context.fillStyle = style;
            context.fill();
            context.globalAlpha = 1;
        },
        dot(a, b, style) {
            context.beginPath();
            context.arc(x(a), y(b), 4, 0, 2 * Math.PI);
            context.fillStyle = style;
            context.fill();
        },
    };
}

/** The ends of an axis that holds values, with room; around a constant some room as well. */
function endsOf(values, margin = 0.05) {
    let low = Infinity, high = -Infinity;
    for (const v of values) {
        if (v !== null && Number.isFinite(v)) {
            low = Math.min(low, v);
            high = Math.max(high, v);
        }
    }
    if (low > high) {
        return [0, 1];
    }
    const room = high > low ? (high - low) * margin : Math.abs(high) * 0.1 || 1;
    return [low - room, high + room];
}

const even = ({ lower, upper }) => Array.from({ length: 161 }, (_, k) => lower + ((upper - lower) * k) / 160);

/** Places along a range that show each corner of the sets, and both sides of each jump. */
function places(variable) {
    const { lower, upper, corners } = variable, width = upper - lower;
    const beside = corners.flatMap((c) => [c - 1e-7 * width, c, c + 1e-7 * width]);
    return [...even(variable), ...beside].filter((v) => v >= lower && v <= upper).sort((a, b) => a - b);
}

const viridis = [
    [68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141],
    [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37],
];
/** The colour of a part from 0 to 1, as red, green and blue. */
function heat(part) {
    const place = Math.min(Math.max(part, 0), 1) * (viridis.length - 1), k = Math.min(Math.floor(place), viridis.length - 2);
    return viridis[k].map((c, i) => Math.round(c + (viridis[k + 1][i] - c) * (place - k)));
}

/** A table with a caption; rows of texts or elements. */
function tableOf(caption, header, rows) {
    const table = element("table", {}, element("caption", {}, caption));
    if (header.length) {
        const cells = header.map((h) => element("th", { scope: "col" }, h));
        table.append(element("thead", {}, element("tr", {}, ...cells)));
    }
    const body = rows.map(([first, ...rest]) =>
        element("tr", {}, element("th", { scope: "row" }, first), ...rest.map((c) => element("td", {}, c))));
    table.append(element("tbody", {}, ...body));
    return element("div", { className: "scroll", tabIndex: 0, role: "group", "aria-label": caption }, table);
}

/** Draws all pictures again, in the colours and at the sizes that they have now. */
function redrawn() {
    known.clear();
    pictures.forEach((p) => p.measure());
    redraws.forEach((draw) => draw());
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redrawn);

/** Makes the page one for paper: light, as wide as a sheet, nothing folded; or again one for the screen. */
function onPaper(isPaper) {
    document.documentElement.classList.toggle("paper", isPaper);
    for (const own of document.querySelectorAll(isPaper ? "details:not([open])" : "details.unfolded")) {
        own.open = own.classList.toggle("unfolded", isPaper);
    }
    redrawn();
}
addEventListener("beforeprint", () => onPaper(true));
addEventListener("afterprint", () => onPaper(false));
