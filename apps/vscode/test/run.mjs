// Installs the packed extension into code-server, a VS Code behind a web page, and drives it with Chromium.
//
//   npm --prefix apps/vscode ci --ignore-scripts && npm --prefix apps/vscode run package
//   npm --prefix apps/vscode/test run setup && npm --prefix apps/vscode/test start
//
// PYTHON is a Python that has fuzzyctl and the extra lsp (default: python3), CHROMIUM a Chromium (default:
// /usr/bin/chromium), PICTURES a folder for pictures of the window (default: none are kept), LIMIT the seconds that one
// step may take (default: 90). It exits with 1 for a check that failed, and with 77 where VS Code or Chromium do not start.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

const HERE = dirname(fileURLToPath(import.meta.url));
const VSIX = join(HERE, "..", "fuzzyctl.vsix");
// The server of VS Code itself: code-server's own entry needs modules that are compiled at installation.
const CODE_SERVER = join(HERE, "node_modules", "code-server", "lib", "vscode", "out", "server-main.js");
const PYTHON = process.env.PYTHON ?? "python3";
const PICTURES = process.env.PICTURES;
/** A step that takes longer has failed; nothing depends on how fast the machine is below that. */
const LIMIT = Number(process.env.LIMIT ?? 90);
/** Exit code where the machine cannot run the test. */
const CANNOT = 77;

const TEXT = `system tip "Tip for a meal"
defuzzifier center_average

input service in [0, 10]
  terms poor good
input food "<i>Food</i> & $x$" in [0, 10]
  terms bad fine great
output tip in [0, 20]
  terms small=0 large=20

table tip = service x food
         bad    fine   great
  poor | small  small  large
  good | small  large  large

require tip >= 0
`;

const SETTINGS = { "workbench.startupEditor": "none", "editor.minimap.enabled": false };
const INSIDE = { ...SETTINGS, "fuzzyctl.python": "${workspaceFolder}/.venv/bin/python" };
const folder = mkdtempSync(join(tmpdir(), "fuzzyctl-vscode-"));
const work = join(folder, "work");
const started = Date.now();
let browser;
let server;
let page;

function step(text) {
  console.log(`${((Date.now() - started) / 1000).toFixed(1).padStart(6)} s  ${text}`);
}

async function picture(name) {
  if (PICTURES !== undefined) {
    mkdirSync(PICTURES, { recursive: true });
    await page.screenshot({ path: join(PICTURES, `${name}.png`) });
  }
}

function freePort() {
  return new Promise((resolve) => {
    const socket = createServer().listen(0, "127.0.0.1", () => {
      const { port } = socket.address();
      socket.close(() => resolve(port));
    });
  });
}

/** Wait until something holds, and fail with what was seen last. */
async function until(what, look) {
  const end = Date.now() + LIMIT * 1000;
  let last;
  while (Date.now() < end) {
    try {
      last = await look();
      if (last) {
        return last;
      }
    } catch (error) {
      last = error;
    }
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
  throw new Error(`not within ${LIMIT} s: ${what}; last: ${last}`);
}

function set(settings) {
  writeFileSync(join(work, ".vscode", "settings.json"), JSON.stringify(settings));
}

function prepare() {
  mkdirSync(join(work, ".vscode"), { recursive: true });
  writeFileSync(join(work, "tip.fz"), TEXT);
  set(INSIDE);
}

class Cannot extends Error {}

/** What the machine must be able to do before anything is tested. */
async function needed(what, act) {
  try {
    return await act();
  } catch (error) {
    throw new Cannot(`${what}: ${error instanceof Error ? error.message : error}`);
  }
}

async function startCodeServer() {
  const common = ["--server-data-dir", join(folder, "data"), "--extensions-dir", join(folder, "extensions")];
  const env = { ...process.env, HOME: folder, XDG_CONFIG_HOME: folder, VSCODE_IPC_HOOK_CLI: "" };
  await needed("code-server does not start", () => execFileSync(process.execPath, [CODE_SERVER, "--version"], { env }));
  execFileSync(process.execPath, [CODE_SERVER, ...common, "--install-extension", VSIX], { env, stdio: "pipe" });
  step("the packed extension is installed");
  const port = await freePort();
  const words = ["--host", "127.0.0.1", "--port", `${port}`, "--without-connection-token", "--telemetry-level", "off"];
  server = spawn(process.execPath, [CODE_SERVER, ...common, ...words, "--disable-workspace-trust"], { env, stdio: "pipe" });
  let said = "";
  for (const stream of [server.stdout, server.stderr]) {
    stream.on("data", (data) => (said += data));
  }
  const listens = async () => (await fetch(`http://127.0.0.1:${port}/version`)).ok;
  await needed("code-server", () => until("it listens", listens).catch((e) => { throw new Error(`${e.message}; ${said}`); }));
  return `http://127.0.0.1:${port}/?folder=${encodeURIComponent(work)}`;
}

async function command(name) {
  await page.keyboard.press("F1");
  await page.locator(".quick-input-widget input").fill(`>${name}`);
  await page.locator(".quick-input-list .monaco-list-row", { hasText: name }).first().click();
}

async function goTo(line, column) {
  await page.keyboard.press("Control+g");
  await page.locator(".quick-input-widget input").fill(`:${line},${column}`);
  await page.keyboard.press("Enter");
}

/** The page inside the two frames of the pane. */
function pane() {
  return page.frameLocator("iframe.webview.ready").frameLocator("iframe#active-frame");
}

/** The address of a picture, which is a new one whenever the picture is. */
const shown = async (id) => {
  const address = await pane().locator(`#${id}`).getAttribute("src", { timeout: 1000 });
  return address?.startsWith("blob:") && address;
};
/** The address of a picture once its description has some words. */
const described = async (id, words) => {
  const has = async () => (await pane().locator(`#${id}`).getAttribute("alt", { timeout: 1000 })).includes(words);
  await until(`'${id}' has '${words}'`, has);
  return shown(id);
};
const changed = (id, before) => until(`'${id}' changes`, async () => {
  const now = await shown(id);
  return now && now !== before && now;
});
/** The process of the language server; undefined where there is none. */
function languageServer() {
  const lines = execFileSync("ps", ["-Ao", "pid,args"], { encoding: "utf8" }).split("\n");
  const line = lines.find((l) => l.includes(`${work}/.venv/`) && l.endsWith(" -m fuzzyctl lsp"));
  return line === undefined ? undefined : Number(line.trim().split(/\s+/)[0]);
}

const squiggles = () => page.locator(".squiggly-error").count();
const text = () => readFileSync(join(work, "tip.fz"), "utf8");

async function drive(address) {
  browser = await needed("Chromium does not start", () => chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"],
  }));
  page = await browser.newPage({ viewport: { width: 1500, height: 900 } });
  page.setDefaultTimeout(LIMIT * 1000);
  await page.goto(address);
  await page.locator(".monaco-workbench").waitFor();
  await page.locator(".explorer-folders-view .monaco-list-row", { hasText: "tip.fz" }).dblclick();
  await page.locator(".view-lines", { hasText: "defuzzifier" }).waitFor();
  step("the file is open");

  // Without a Python that has fuzzyctl there is a message with buttons.
  const message = page.locator(".notification-list-item", { hasText: "No Python with fuzzyctl" });
  await message.waitFor();
  assert.match(await message.innerText(), /work.\.venv.bin.python' is not there/);
  for (const button of ["Set the Python", "Copy the pip command", "Try again"]) {
    assert.equal(await message.getByRole("button", { name: button }).count(), 1, button);
  }
  await picture("1-no-python");
  step("without a Python: a message with buttons");
  const prefix = execFileSync(PYTHON, ["-c", "import sys; print(sys.prefix)"], { encoding: "utf8" }).trim();
  symlinkSync(prefix, join(work, ".venv"));
  await message.getByRole("button", { name: "Try again" }).click();

  // Colours come from the grammar: a keyword does not look like a name.
  const color = (word) => page.locator(".view-line span span", { hasText: new RegExp(`^${word}$`) }).first()
    .evaluate((span) => getComputedStyle(span).color);
  assert.notEqual(await color("system"), await color("tip"));

  await page.locator(".view-line", { hasText: "small" }).first().click();
  await command("fuzzyctl: Show the surface beside");
  const first = await until("the surface is drawn", () => shown("surface"));
  await page.locator(".tab", { hasText: "tip: tip" }).waitFor();
  await picture("2-surface");
  step("the preview shows the surface");

  // A mistake: squiggle, a stale picture, a quick fix that repairs it.
  await page.locator(".view-line", { hasText: "good" }).last().click();
  await goTo(14, 17);
  await page.keyboard.press("Control+d");
  await page.keyboard.type("lagre");
  await until("a squiggle", squiggles);
  step("a mistake has a squiggle");
  await until("the preview is marked", async () => (await pane().locator("#message").innerText()).includes("Not up to date"));
  await picture("3-mistake");
  step("the preview is marked as not up to date");
  await page.keyboard.press("Control+.");
  const fix = page.locator(".action-widget .monaco-list-row.action", { hasText: "large" }).first();
  await fix.waitFor();
  await picture("4-quick-fix");
  await page.keyboard.press("Enter");
  await until("no squiggle", async () => (await squiggles()) === 0);
  await page.keyboard.press("Control+s");
  await until("the repaired text is saved", () => text() === TEXT);
  step("the quick fix repairs it");
  await until("the mark is gone", async () => (await pane().locator("#message").innerText()) === "");

  // A lens proves, and what came out stands beside the text.
  await page.locator(".codelens-decoration a", { hasText: "✓ proved" }).click();
  await page.locator(".view-line", { hasText: /^tip.fz:16:.proved:.tip.>=.0$/ }).waitFor();
  await picture("5-prove");
  const tab = page.locator(".tab", { hasText: "prove tip" });
  await tab.click({ button: "middle" });
  await tab.waitFor({ state: "detached" });
  await page.locator(".view-line", { hasText: "good" }).last().click();
  step("a lens shows what is proved");

  // Another term gives another surface.
  await goTo(14, 17);
  const before = await described("surface", "service is good and food is fine then tip is large");
  await page.keyboard.press("Control+d");
  await page.keyboard.type("small");
  const after = await described("surface", "service is good and food is fine then tip is small");
  assert.equal(new Set([first, before, after]).size, 3);
  await picture("5-edited");
  step("an edit changes the surface");

  // A click into the map selects the cell of its strongest rule, and shows the rules there.
  const surface = await pane().locator("#surface").boundingBox();
  await page.mouse.click(surface.x + 0.5 * surface.width, surface.y + 0.8 * surface.height);
  await until("the cell of poor and bad is selected", async () =>
    (await page.locator(".active-line-number").innerText()) === "13" && (await page.locator(".selected-text").count()) > 0);
  const map = await described("surface", "service is poor and food is bad");
  const atClick = await described("rules", "Rules that act at service = 0.");
  await picture("6-click");
  step("a click into the map selects a cell and shows the rules");
  await pane().locator("#value-food").fill("9");
  const atNine = await described("rules", "food = 9");
  assert.notEqual(atNine, atClick);
  assert.equal(await shown("surface"), map, "a slider draws the map again");
  assert.equal(await pane().locator("#inputs span").last().innerText(), "<i>Food</i> & $x$");
  await picture("7-slider");
  step("a slider changes the rules");

  // The other way: the cursor in a cell marks its region, and moves the point into it.
  await page.locator(".view-line", { hasText: "require" }).click();
  await goTo(14, 10);
  const light = await described("surface", "service is good and food is bad");
  await described("rules", "service = 10, food = 0");
  assert.deepEqual(await pane().locator("#inputs output").allInnerTexts(), ["10", "0"]);
  await picture("8-cell");
  step("the cursor in a cell marks its region and moves the point there");

  // Light, dark and high contrast: the lines and texts of the pictures are as light as those of the theme.
  let dark;
  for (const [theme, kind] of [
    ["Default Dark Modern", "vscode-dark"],
    ["Default High Contrast", "vscode-high-contrast"],
    ["Default High Contrast Light", "vscode-high-contrast-light"],
  ]) {
    set({ ...INSIDE, "workbench.colorTheme": theme });
    await pane().locator(`body.${kind}`).waitFor();
    const isLight = kind.endsWith("light");
    dark = await (isLight ? changed("surface", dark) : changed("surface", light));
    const filter = await pane().locator("#terms").evaluate((image) => getComputedStyle(image).filter);
    assert.equal(filter === "none", isLight, theme);
    await picture(`9-${kind}`);
    step(`the pane suits ${theme}`);
  }
  set(INSIDE);

  // A command starts the server again, and so do a change of the setting, without which `.venv` is found, and a crash.
  await page.locator(".view-line", { hasText: "require" }).click();
  for (const [restart, what] of [
    [() => command("fuzzyctl: Restart the language server"), "a restart"],
    [() => set(SETTINGS), "a change of the setting"],
    [() => process.kill(languageServer(), "SIGKILL"), "a crash"],
  ]) {
    const before = languageServer();
    await restart();
    await until("there is another server", () => ![before, undefined].includes(languageServer()));
    await goTo(16, 13);
    await page.keyboard.type("x");
    await until("the server answers again", squiggles);
    await page.keyboard.press("Backspace");
    await until("no squiggle", async () => (await squiggles()) === 0);
    step(`after ${what} the server answers`);
  }

  // What is refuted leads to the counterexample.
  await goTo(16, 17);
  await page.keyboard.type("+2");
  const why = page.locator(".codelens-decoration a", { hasText: "refuted at" });
  const [, ...counterexample] = (await why.innerText()).match(/service = (\S+), food = ([^:]+):/);
  await why.click();
  await described("rules", `service = ${counterexample[0]}, food = ${counterexample[1]}`);
  await picture("10-why");
  step("a lens leads to the counterexample");

  // A snippet.
  await goTo(17, 1);
  await page.keyboard.type("requ");
  await page.keyboard.press("Control+Space");
  await page.locator(".suggest-widget .monaco-list-row", { hasText: "Guarantee" }).click();
  await page.locator(".view-line", { hasText: /^require.output.>=.0$/ }).waitFor();
  await picture("11-snippet");
  step("a snippet is inserted");

  // None inside of a line, where the server offers what fits.
  await page.keyboard.press("Escape");
  await page.keyboard.press("End");
  await page.keyboard.press("Enter");
  await page.keyboard.type("if service is p");
  await page.keyboard.press("Control+Space");
  await page.locator(".suggest-widget .monaco-list-row", { hasText: "poor" }).first().waitFor();
  assert.equal(await page.locator(".suggest-widget .monaco-list-row", { hasText: "Plant" }).count(), 0);
  step("no snippet inside a rule");
}

try {
  assert(existsSync(VSIX), `${VSIX} is not there: npm --prefix apps/vscode run package`);
  assert(existsSync(CODE_SERVER), "code-server is not there: npm --prefix apps/vscode/test run setup");
  prepare();
  await drive(await startCodeServer());
  step("done");
} catch (error) {
  if (page !== undefined) {
    await picture("failed");
  }
  console.error(error instanceof Cannot ? error.message : error);
  process.exitCode = error instanceof Cannot ? CANNOT : 1;
} finally {
  await browser?.close();
  server?.kill();
  rmSync(folder, { recursive: true, force: true, maxRetries: 5, retryDelay: 200 });
}
