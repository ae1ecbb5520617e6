// Opens the pages of a folder in Chromium: node run.mjs FOLDER, which pages.py has filled.
//
// No message in the console, no request, no violation that axe-core finds, the numbers of the kernel at 40 points of each
// block, a value at the begin, remarks that are folded below the blocks, nothing beside a window of 400 pixels, inputs that follow the time of a run, no script from names;
// on paper the light colours and nothing folded; at most 300 kB of a rule file, and 300 ms to the first paint: the best of some tries counts, as other programs only add to it. CHROMIUM is a Chromium (default: /usr/bin/chromium), PICTURES a folder for pictures (default: none).
// It exits with 1 for a check that failed, and with 77 where Chromium does not start.
import { mkdirSync, readFileSync, readdirSync, statSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const FOLDER = resolve(process.argv[2]), PICTURES = process.env.PICTURES, TOLERANCE = 1e-12;
const LARGEST = 300_000, PAINTED = 300, TRIES = 6, PHONE = 400;
const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const expected = JSON.parse(readFileSync(join(FOLDER, "expected.json"), "utf8").replace(/\bNaN\b|-?\bInfinity\b/g, "null"));
const failures = [];
const args = ["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-background-networking", "--no-first-run"];

/** Move the sliders of the k-th block to each point, make a step of a controller, and return what stands there. */
function moved([k, points]) {
    const block = document.querySelectorAll("article")[k], buttons = [...block.querySelectorAll("button")], step = buttons.find((b) => b.textContent === "Step");
    const fields = [...block.querySelectorAll(".control > input[type=number]")], numbers = [...block.querySelectorAll(".outputs output")];
    buttons.find((b) => b.textContent === "Begin anew")?.click();
    return points.map((point) => {
        fields.forEach((field, n) => {
            field.value = point[n];
            field.dispatchEvent(new Event("input"));
        });
        step?.click();
        return numbers.map((n) => n.dataset.value);
    });
}

/** Move the time of each run to its middle; return the inputs of blocks that do not follow. */
function followed() {
    const sections = JSON.parse(document.getElementById("facts").textContent).sections ?? [], blocks = sections.map((s) => s.name);
    const slider = document.querySelector(".times input[type=range]"), choice = document.querySelector(".times select");
    const choose = (list, k) => {
        list.value = k;
        list.dispatchEvent(new Event("change"));
    };
    return sections.filter((s) => s.kind === "loop").flatMap((loop, n) => {
        if (choice !== null) {
            choose(choice, n);
        }
        slider.value = slider.max / 2;
        slider.dispatchEvent(new Event("input"));
        return loop.inputs.flatMap(({ block, call, values }) => {
            const form = document.querySelectorAll("article")[blocks.indexOf(block)].querySelector("fieldset"), calls = form.querySelector("select");
            if (calls !== null) {
                choose(calls, [...calls.options].findIndex((o) => o.textContent === call));
            }
            const shown = [...form.querySelectorAll(".control > input[type=number]")];
            return values.flatMap((v, i) => (v[slider.valueAsNumber] === shown[i].valueAsNumber ? [] : [`${block} ${i} of ${call}`]));
        });
    });
}

/** What is wrong with the remarks, whose link has the keyboard; nothing without remarks. */
function remarked() {
    const link = document.querySelector("nav a[href='#remarks']"), list = document.querySelector("#remarks details"), said = document.querySelector("#remarks summary")?.textContent;
    const wanted = JSON.parse(document.getElementById("facts").textContent).diagnostics?.length ?? 0;
    if (!wanted) {
        return list === null ? [] : ["remarks on nothing"];
    }
    const last = [...document.querySelectorAll("article")].at(-1).getBoundingClientRect(), isFolded = !list.open;
    const isBelow = list.getBoundingClientRect().top >= last.bottom, counts = said.match(/\d+/g).map(Number);
    link.click();
    return [[isFolded, "unfolded at the begin"], [isBelow, "not below the blocks"], [list.open, "not unfolded by the link"],
        [counts.reduce((a, b) => a + b) === wanted, `${said}, not ${wanted}`], [list.querySelectorAll("li").length === wanted, "not all there"]]
        .flatMap(([holds, text]) => (holds ? [] : [`remarks: ${text}`]));
}

/** What is wrong with the page between the events of printing, and after them. */
function onPaper() {
    const state = () => [getComputedStyle(document.body).color, document.querySelectorAll("details:not([open])").length], before = state();
    dispatchEvent(new Event("beforeprint"));
    const [ink, folded] = state();
    dispatchEvent(new Event("afterprint"));
    return [[ink === "rgb(26, 26, 26)", `${ink} on paper`], [folded === 0, `${folded} folded on paper`], [String(state()) === String(before), "another page after printing"]]
        .flatMap(([holds, text]) => (holds ? [] : [text]));
}

const painted = (page) => page.evaluate(() => performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? Infinity);

/** Asks until a predicate holds: `waitForFunction` evaluates a string, which the policy of the report forbids. */
async function becomes(page, predicate, given) {
    for (let k = 0; k < 200; k++) {
        if (await page.evaluate(predicate, given)) {
            return true;
        }
        await page.waitForTimeout(50);
    }
    return false;
}

async function look(browser, name, scheme) {
    const context = await browser.newContext({ viewport: { width: 1300, height: 900 }, colorScheme: scheme });
    const page = await context.newPage(), fail = (text) => failures.push(`${name}, ${scheme}: ${text}`);
    page.on("console", (message) => fail(`console: ${message.text()}`));
    page.on("pageerror", (error) => fail(`error: ${error.message}`));
    page.on("request", (request) => request.url().startsWith("file:") || fail(`request: ${request.url()}`));
    await page.goto(pathToFileURL(join(FOLDER, name)).href);
    await page.locator("body[data-ready]").waitFor();
    if (await page.locator("main img, main script, main [onload], main [onerror]").count()) {
        fail("a name became markup");
    }
    if (PICTURES !== undefined) {
        mkdirSync(PICTURES, { recursive: true });
        await becomes(page, () => ![...document.querySelectorAll("[aria-live]")].some((e) => e.textContent.startsWith("Computing")));
        await page.screenshot({ path: join(PICTURES, `${name}-${scheme}.png`), fullPage: true });
    }
    for (const output of await page.locator(".outputs output").all()) {
        const value = await output.getAttribute("data-value");
        Number.isFinite(Number(value)) || fail(`it begins with ${value}`);
    }
    for (const text of [...await page.evaluate(onPaper), ...await page.evaluate(remarked)]) {
        fail(text);
    }
    if (scheme === "light") {
        for (const [k, asked] of expected[name].entries()) {
            const found = await page.evaluate(moved, [k, asked.map(([point]) => point)]);
            found.forEach((texts, n) => texts.forEach((text, o) => {
                const value = Number(text), wanted = asked[n][1][o];
                if (!(wanted === null ? !Number.isFinite(value) : Math.abs(value - wanted) <= TOLERANCE * Math.max(1, Math.abs(wanted)))) {
                    fail(`${text} is not ${wanted} at ${asked[n][0]}`);
                }
            }));
        }
        (await page.evaluate(followed)).forEach((input) => fail(`input ${input} does not follow the time of the run`));
        const size = statSync(join(FOLDER, name)).size;
        if (expected[name].length && size > LARGEST) {
            fail(`${size} bytes, more than ${LARGEST}`);
        }
    }
    for (const button of await page.getByRole("button", { name: "10 steps" }).all()) {
        await button.click();
    }
    await page.evaluate(`(() => { ${AXE} })()`);
    const { violations } = await page.evaluate(() => window.axe.run());
    violations.forEach((v) => fail(`axe: ${v.id}: ${v.nodes[0].html.slice(0, 200)}`));
    let paint = await painted(page);
    for (let k = 1; k < TRIES && paint > PAINTED; k++) {
        await page.reload();
        await page.locator("body[data-ready]").waitFor();
        paint = Math.min(paint, await painted(page));
    }
    if (paint > PAINTED) {
        fail(`first paint after ${Math.round(paint)} ms, more than ${PAINTED}`);
    }
    if (scheme === "dark") {
        await page.setViewportSize({ width: PHONE, height: 900 });
        // Pictures take their new width in one of the next frames.
        if (!await becomes(page, (most) => document.documentElement.scrollWidth <= most, PHONE)) {
            fail(`wider than a window of ${PHONE} pixels`);
        }
    }
    await page.emulateMedia({ media: "print" });
    const places = await page.evaluate(() => [...document.querySelectorAll(".side, .times")].map((e) => getComputedStyle(e).position));
    places.includes("sticky") && fail("on paper a bar lies over the text");
    await context.close();
    const points = expected[name].reduce((sum, asked) => sum + asked.length, 0);
    console.log(`${name}, ${scheme}: ${points} points, first paint after ${Math.round(paint)} ms`);
}

let browser;
try {
    browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args });
} catch (error) {
    console.error(error.message);
    process.exit(77);
}
for (const name of readdirSync(FOLDER).filter((n) => n.endsWith(".html")).sort()) {
    for (const scheme of ["light", "dark"]) {
        await look(browser, name, scheme);
    }
}
await browser.close();
failures.forEach((failure) => console.error(failure));
process.exitCode = failures.length ? 1 : 0;
