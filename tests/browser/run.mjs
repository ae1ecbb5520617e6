// Opens the pages of a folder in Chromium: node run.mjs FOLDER, which pages.py has filled.
//
// No message in the console, no request, no violation that axe-core finds, the numbers of the kernel at 40 points, no
// script from names. CHROMIUM is a Chromium (default: /usr/bin/chromium), PICTURES a folder for pictures (default: none).
// It exits with 1 for a check that failed, and with 77 where Chromium does not start.
import { mkdirSync, readFileSync, readdirSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const FOLDER = resolve(process.argv[2]), PICTURES = process.env.PICTURES, TOLERANCE = 1e-12;
const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const expected = JSON.parse(readFileSync(join(FOLDER, "expected.json"), "utf8").replace(/\bNaN\b/g, "null"));
const failures = [];
const args = ["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-background-networking", "--no-first-run"];

/** Move the sliders of the first block to each point, and return what stands there. */
function moved(points) {
    const block = document.querySelector("article");
    const fields = [...block.querySelectorAll(".control input[type=number]")], numbers = [...block.querySelectorAll(".outputs output")];
    return points.map((point) => {
        fields.forEach((field, k) => {
            field.value = point[k];
            field.dispatchEvent(new Event("input"));
        });
        return numbers.map((n) => n.dataset.value);
    });
}

async function look(browser, name, scheme) {
    const context = await browser.newContext({ viewport: { width: 1300, height: 900 }, colorScheme: scheme });
    const page = await context.newPage(), fail = (text) => failures.push(`${name}, ${scheme}: ${text}`);
    page.on("console", (message) => fail(`console: ${message.text()}`));
    page.on("pageerror", (error) => fail(`error: ${error.message}`));
    page.on("request", (request) => request.url().startsWith("file:") || fail(`request: ${request.url()}`));
    await page.goto(pathToFileURL(join(FOLDER, name)).href);
    await page.locator("body[data-ready]").waitFor();
    if (await page.locator("article img, article script, article svg").count()) {
        fail("a name became markup");
    }
    if (scheme === "light") {
        const asked = expected[name], found = asked.length ? await page.evaluate(moved, asked.map(([point]) => point)) : [];
        found.forEach((texts, k) => texts.forEach((text, o) => {
            const value = Number(text), wanted = asked[k][1][o];
            if (!(wanted === null ? Number.isNaN(value) : Math.abs(value - wanted) <= TOLERANCE * Math.max(1, Math.abs(wanted)))) {
                fail(`${text} is not ${wanted} at ${asked[k][0]}`);
            }
        }));
    }
    for (const button of await page.getByRole("button", { name: "10 steps" }).all()) {
        await button.click();
    }
    await page.evaluate(`(() => { ${AXE} })()`);
    const { violations } = await page.evaluate(() => window.axe.run());
    violations.forEach((v) => fail(`axe: ${v.id}: ${v.nodes[0].html.slice(0, 200)}`));
    if (PICTURES !== undefined) {
        mkdirSync(PICTURES, { recursive: true });
        await page.screenshot({ path: join(PICTURES, `${name}-${scheme}.png`), fullPage: true });
    }
    const paint = await page.evaluate(() => performance.getEntriesByName("first-contentful-paint")[0]?.startTime);
    await context.close();
    console.log(`${name}, ${scheme}: ${expected[name].length} points, first paint after ${Math.round(paint)} ms`);
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
