// Drives the studio in Chromium, and measures it: npm --prefix apps/studio/test ci && npm --prefix apps/studio/test start
//
// PYTHON is a Python that has fuzzyctl (default: python3), CHROMIUM a Chromium (default: /usr/bin/chromium), PICTURES a
// folder for pictures of the window (default: none are kept). The studio has been built: see ../build.mjs.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

const HERE = dirname(fileURLToPath(import.meta.url));
const ROOT = join(HERE, "..", "..", "..");
const PYTHON = process.env.PYTHON ?? "python3";
const EDITS = 100;
const KEYS = 21;
/** What CPython says of texts, with numpy: code, line and message of each diagnostic. */
const EXPECTED = `
import json, sys
from pathlib import Path
from fuzzyctl.analysis.check import check_source
from fuzzyctl.diagnostics.source import SourceText
found = [check_source(SourceText("/files/tipper.fz", text), folder=Path("."))[1] for text in json.load(sys.stdin)]
print(json.dumps([[[d.code, d.span.line if d.span else 0, d.message] for d in own] for own in found]))
`;

const tipper = readFileSync(join(ROOT, "rules", "tipper.fz"), "utf8");
const profile = mkdtempSync(join(tmpdir(), "fuzzyctl-studio-"));
const server = spawn(PYTHON, ["-m", "fuzzyctl", "studio", "--no-browser", join(ROOT, "rules", "smc.fz")], { cwd: ROOT });
const results = [];
let browser;

function check(name, value, limit) {
  const holds = limit === undefined || value <= limit;
  results.push(holds);
  console.log(`${holds ? "ok  " : "MISS"} ${name}: ${value}${limit === undefined ? "" : ` (at most ${limit})`}`);
}

const shown = (page) => page.evaluate(() => document.body.dataset.shown);
const mistakes = (page) => page.locator("#mistakes li button:first-child").allTextContents();

/** Puts a text in, and returns the milliseconds until all of it is painted. */
function put(page, text) {
  return page.evaluate(async (insert) => {
    const before = Number(document.body.dataset.shown);
    const start = performance.now();
    studio.view.dispatch({ changes: { from: 0, to: studio.view.state.doc.length, insert } });
    while (!(Number(document.body.dataset.shown) > before)) await new Promise((resolve) => setTimeout(resolve, 1));
    for (let k = 0; k < 2; k += 1) await new Promise(requestAnimationFrame); // what was drawn is painted
    return performance.now() - start;
  }, text);
}

/** Waits until a function of the page holds; playwright's own way needs `eval`, which the page forbids. */
async function until(page, holds, argument, seconds = 60) {
  for (const end = Date.now() + seconds * 1000; !(await page.evaluate(holds, argument)); ) {
    assert.ok(Date.now() < end, `${holds} does not hold after ${seconds} s`);
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}

async function opened(context, address) {
  const page = context.pages()[0] ?? (await context.newPage());
  const outside = [];
  page.on("console", (m) => m.type() === "error" && outside.push(`console: ${m.text()}`));
  page.on("pageerror", (e) => outside.push(`error: ${e}`));
  page.on("request", (r) => new URL(r.url()).origin === new URL(address).origin || r.url().startsWith("data:") || r.url().startsWith("about:") || outside.push(r.url()));
  const start = Date.now();
  await page.goto(address);
  await until(page, () => document.body.dataset.shown !== undefined, null, 120);
  return { page, outside, seconds: (Date.now() - start) / 1000 };
}

/** Returns texts, each one edit from the one before; every tenth is the whole file again. */
function edited() {
  let seed = 1;
  const random = (n) => (seed = (seed * 48271) % 2147483647) % n;
  const texts = [];
  let text = tipper;
  while (texts.length < EDITS) {
    const place = random(text.length);
    const letters = ["", "x", " ", "7", "=", "\n", "é", "]"][random(8)];
    text = texts.length % 10 === 9 ? tipper : text.slice(0, place) + letters + text.slice(place + random(3));
    texts.push(text);
  }
  return texts;
}

async function picture(page, name) {
  if (!process.env.PICTURES) return;
  mkdirSync(process.env.PICTURES, { recursive: true });
  await page.screenshot({ path: join(process.env.PICTURES, `${name}.png`) });
}

async function drive(address) {
  const launch = () => chromium.launchPersistentContext(profile, {
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run", "--disable-dev-shm-usage"],
    viewport: { width: 1500, height: 950 },
    acceptDownloads: true,
  });
  browser = await launch();
  const cold = await opened(browser, address);
  check("cold start [s]", cold.seconds, 12);
  assert.equal(await cold.page.locator("#name").textContent(), "smc.fz");
  await browser.close();
  browser = await launch();
  const { page, outside, seconds } = await opened(browser, address.split("#")[0]);
  check("warm start [s]", seconds, 4);
  await picture(page, "light");

  const texts = edited();
  const expected = JSON.parse(execFileSync(PYTHON, ["-c", EXPECTED], { input: JSON.stringify(texts), encoding: "utf8", cwd: join(ROOT, "rules") }));
  let wrong = 0;
  for (const [k, text] of texts.entries()) {
    await put(page, text);
    const found = await mistakes(page);
    const wanted = expected[k].map(([code, line, message]) => [`[${code}]: ${message}`, line ? `line ${line}: ` : ""]);
    const same = found.length === wanted.length && wanted.every(([end, start]) => found.some((f) => f.startsWith(start) && f.endsWith(end)));
    if (!same) {
      wrong += 1;
      console.log(found, wanted);
    }
  }
  check(`wrong sets of diagnostics of ${EDITS}`, wrong, 0);
  check("with errors among them", expected.filter((e) => e.length).length);

  const times = [];
  for (let k = 0; k < KEYS; k += 1) times.push(await put(page, tipper.replace("in [0, 10]", `in [0, ${10 + k / 10}]`)));
  times.sort((a, b) => a - b);
  check("key to new surface, median [ms]", Math.round(times[(KEYS - 1) / 2]), 100);

  // Mistakes: the last picture stays, and says so; the repair puts it right.
  await put(page, tipper.replace("good", "gud"));
  await picture(page, "mistakes");
  assert.ok(await page.locator("#frames.stale iframe").count() === 1);
  assert.match(await page.locator("#stale").textContent(), /has errors/);

  await page.locator("#mistakes button.fix").first().click();
  await until(page, () => document.getElementById("count").textContent === "No mistakes");

  // Names that inject.
  await put(page, tipper.replace(/^system tipper.*$/m, 'system tipper "</script><img src=x onerror=alert(1)>"'));
  assert.deepEqual(await mistakes(page), []);
  page.on("dialog", () => assert.fail("a name was executed"));
  await put(page, `system a\n${"<img src=x onerror=alert(1)>"}\n`);
  assert.equal(await page.locator("#mistakes img").count(), 0);

  // Completion, hover and layout.
  await put(page, tipper);
  const proposed = await page.evaluate((offset) => studio.engine.ask({ method: "complete", file: "/files/t.fz", text: studio.view.state.doc.toString(), offset }), tipper.indexOf("triangle"));
  assert.ok(proposed.items.length > 0);

  // The link carries the text.
  await put(page, `${tipper}# é µ 𝑥\n`);
  await page.locator("#share").click();
  await until(page, () => location.hash.includes("text="));
  const copy = await browser.newPage();
  await copy.goto(page.url());
  await until(copy, () => globalThis.studio?.view.state.doc.toString().includes("𝑥"));
  await copy.close();

  // Files.
  for (const [format, count] of [["fz", 1], ["page", 1], ["c", 2], ["javascript", 1], ["python", 1], ["st", 1]]) {
    const saved = [];
    const listen = (download) => saved.push(download.suggestedFilename());
    page.on("download", listen);
    await page.locator("#save").selectOption(format);
    for (let k = 0; saved.length < count && k < 400; k += 1) await page.waitForTimeout(50);
    page.off("download", listen);
    assert.equal(saved.length, count, `${format}: ${await page.locator("#status").textContent()}`);
  }

  // Examples that use other files.
  for (const name of ["fcafsmc_law.fz", "ball_and_beam.fz"]) {
    const before = await shown(page);
    await page.locator("#examples").selectOption({ label: name });
    await until(page, (n) => Number(document.body.dataset.shown) > n, Number(before));
    assert.deepEqual(await mistakes(page), [], name);
  }
  await picture(page, "controllers");
  await page.emulateMedia({ colorScheme: "dark" });
  await put(page, tipper);
  await picture(page, "dark");

  // What takes too long is stopped, the tab lives, and the next text is shown.
  await page.evaluate(() => {
    studio.engine.limit = 300;
    const names = "abcdefghi".split("").map((n) => `input ${n} in [0, 1]\n  terms lo mid hi\n`).join("");
    const rules = Array.from({ length: 3000 }, (_, k) => `if ${"abcdefghi".split("").map((n, i) => `${n} is ${["lo", "mid", "hi"][Math.floor(k / 3 ** i) % 3]}`).join(" and ")} then y is ${k % 2 ? "p" : "q"}\n`).join("");
    const insert = `system large\n${names}output y in [0, 1]\n  terms p=0 q=1\ndefuzzifier center_average\n${rules}`;
    studio.view.dispatch({ changes: { from: 0, to: studio.view.state.doc.length, insert } });
  });
  await until(page, () => document.getElementById("stale").textContent.includes("takes too long"));
  await picture(page, "stopped");
  await page.evaluate(() => (studio.engine.limit = 15_000));
  await until(page, () => document.body.dataset.state === "ready");
  await put(page, tipper);
  assert.deepEqual(await mistakes(page), []);
  assert.equal(await page.locator("#stale").textContent(), "");

  // Accessibility: axe-core in both colour schemes, with mistakes.
  await put(page, tipper.replace("good", "gud"));
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme });
    await page.evaluate(readFileSync(join(HERE, "node_modules", "axe-core", "axe.min.js"), "utf8"));
    const { violations } = await page.evaluate(() => axe.run(document, { iframes: false }));
    for (const v of violations) console.log(v.id, v.help, v.nodes.map((n) => n.html.slice(0, 200)));
    check(`violations of axe-core, ${colorScheme}`, violations.length, 0);
  }
  // Keyboard: Tab leaves the text.
  await page.locator(".cm-content").focus();
  await page.keyboard.press("Tab");
  assert.equal(await page.evaluate(() => document.activeElement.classList.contains("cm-content")), false);
  check("requests elsewhere and errors of the console", outside.length, 0);
  for (const line of outside) console.log("  ", line);
}

try {
  const lines = createInterface({ input: server.stdout });
  server.stderr.pipe(process.stderr);
  const address = await new Promise((resolve, reject) => {
    lines.once("line", (line) => resolve(line.replace("the studio: ", "")));
    server.once("exit", () => reject(new Error("the server does not start")));
  });
  await drive(address);
} finally {
  await browser?.close();
  server.kill("SIGINT");
  rmSync(profile, { recursive: true, force: true });
}
process.exitCode = results.every(Boolean) ? 0 : 1;
