// The studio: a text on the left, what fuzzyctl says of it below, the page of its systems on the right.
import { button, offer } from "./dialog.js";
import { drafts, isChanged, isLost, keep, remove } from "./drafts.js";
import { editor, mark, repairText, shownMarkdown } from "./editor.js";
import { Engine } from "./engine.js";
import { link, linked } from "./link.js";
import { Picture } from "./picture.js";

const at = (id) => document.getElementById(id);
const status = (text) => (at("status").textContent = text);
let name = "untitled.fz";
/** Texts that the text may use, by name. */
let files = {};
/** Most bytes of a file that is opened. */
const LARGEST = 5e6;
/** Names of files of other tools, which are opened as rule files. */
const FOREIGN = /\.(fis|fll|fcl|fml)$/i;
/** Milliseconds until a picture that is not complete is said to be an older one. */
const PATIENCE = 500;
/** Milliseconds that the text stays the same before its loops are run and its claims proved. */
const PAUSE = 300;
/** Whether the picture is still that of the file before. */
let fresh = true;
/** The diagnostics that are shown. */
let known = [];
/** The runs that are shown. */
let runs = [];
/** The text as it was opened or saved last. */
let base = "";
/** What the draft of the text is kept under. */
let key = "";
/** Most milliseconds of runs of loops, and of proofs of a block. */
const LONGEST = 30_000;
/** Counts texts, so that no answer is shown that is about an older one. */
let version = 0;

const engine = new Engine((state, detail) => {
  document.body.dataset.state = state;
  if (state === "starting") status("starting fuzzyctl …");
  if (state === "ready") status("ready");
  if (state === "failed") status(`fuzzyctl does not start: ${detail}`);
  if (state === "stopped") {
    status(`stopped: ${detail}; fuzzyctl starts again, and the next change of the text is checked`);
    unchecked("The picture is not that of the text, which takes too long.");
  }
});
/** What runs loops and proves claims, apart, so that keys never wait for it; it starts when it is first asked. */
let slow = null;
const shown = new Picture(at("frames"), (nonce) => ask("frame", { nonce }));
const { view, begin, kept, resumed } = editor(at("editor"), (method, more) => ask(method, more), () => {
  version += 1;
  if (engine.ready) status("");
  check();
  remember();
}, () => here());

function ask(method, more = {}) {
  return engine.ask({ method, file: `/files/${name}`, text: view.state.doc.toString().toWellFormed(), ...more });
}

function askSlow(method, more = {}) {
  slow ??= new Engine((state, detail) => {
    document.body.dataset.slow = state;
    if (state === "failed") status(`runs and proofs: fuzzyctl does not start: ${detail}`);
  }, LONGEST);
  if (slow.files !== files) slow.place(files);
  return slow.ask({ method, file: `/files/${name}`, text: view.state.doc.toString().toWellFormed(), ...more });
}

async function check() {
  const own = version;
  const checked = ask("check");
  const drawn = ask("picture"); // which the worker begins while the mistakes are shown here
  const found = await checked;
  if (!found || own !== version) return;
  if (found.refused) return unchecked(`The text is not checked: ${found.refused}`);
  show((known = found.diagnostics));
  if (found.diagnostics.some((d) => d.stops)) stale("The text has errors: this is the picture before them.");
  else await picture(own, await drawn);
  // What a test waits for.
  if (own === version) document.body.dataset.shown = String(own);
}

// -- mistakes

function show(diagnostics) {
  const repair = repairs();
  mark(view, diagnostics, repair);
  at("mistakes").replaceChildren(...diagnostics.map((d) => entry(d, repair)));
  const errors = diagnostics.filter((d) => d.severity === "error").length;
  const others = diagnostics.length - errors;
  const texts = [[errors, "error"], [others, "other remark"]].filter(([n]) => n).map(([n, what]) => `${n} ${what}${n > 1 ? "s" : ""}`);
  at("count").textContent = texts.join(", ") || "No mistakes";
}

/** Shows the verdicts that proofs have added to the diagnostics of the text. */
function add(diagnostics) {
  known = [...known, ...diagnostics].sort((a, b) => a.from - b.from);
  if (diagnostics.length) show(known);
}

/** Shows that nothing is known of the text, and why. */
function unchecked(why) {
  show([]);
  at("count").textContent = "Not checked";
  stale(why);
}

function entry(d, repair) {
  const item = document.createElement("li");
  const place = button(`${d.line ? `line ${d.line}: ` : d.place ? `${d.place}: ` : ""}${d.severity}[${d.code}]: ${d.message}`, () => {
    view.dispatch({ selection: { anchor: Math.min(d.from, view.state.doc.length) }, scrollIntoView: true });
    view.focus();
  });
  place.className = d.severity;
  const facts = document.createElement("p");
  facts.className = "facts";
  const missing = d.code === "FZ218" ? ["'Open' takes the files that the text uses, too"] : [];
  facts.textContent = [...d.facts, ...(d.help ? [`help: ${d.help}`] : []), ...missing].join("\n");
  item.append(place, facts);
  if (d.fix.length) {
    const fix = button(repairText(view, d), () => repair(d.fix));
    fix.className = "fix";
    item.append(fix);
  }
  if (d.point) {
    const lead = button("Go to the counterexample", () => shown.go(d.block, d.point));
    lead.className = "fix";
    item.append(lead);
  }
  return item;
}

/** Returns what puts edits in, unless the text has changed since they were made. */
function repairs() {
  const own = version;
  return (edits) => {
    if (own !== version) return status("the text has changed since; its mistakes are found again");
    view.dispatch({ changes: edits.map(({ from, to, text }) => ({ from, to, insert: text })), userEvent: "input.repair" });
    view.focus();
  };
}

// -- the picture

function stale(why) {
  at("frames").classList.toggle("stale", shown.has && why !== "");
  at("stale").textContent = shown.has || why === "" ? why : `There is no picture yet. ${why}`;
}

async function picture(own, found) {
  if (!found || own !== version) return;
  if (found.refused) return stale(`This is not the picture of the text: ${found.refused}`);
  const slow = setTimeout(() => stale("The picture of the text is being computed; this is the one before."), PATIENCE);
  const before = runs.filter((r) => found.loops.includes(r.name)).map((r) => ({ ...r, note: "This run is that of the text before." }));
  const failed = await shown.show({ ...together(found, before), fresh });
  clearTimeout(slow);
  if (failed === "" && own === version) fresh = false;
  if (own !== version || failed === null) return;
  stale(failed);
  setTimeout(() => own === version && afterwards(own, found), PAUSE);
}

/** Runs the loops of a text that has stayed the same for a moment, then proves what is open, and shows both. */
async function afterwards(own, found) {
  const again = async (done) => {
    const failed = own === version ? await shown.show(together(found, runs)) : null;
    if (own !== version || failed === null) return;
    stale(failed);
    document.body.dataset[done] = String(own); // what a test waits for
  };
  if (found.loops.length === 0) runs = [];
  else {
    const done = await askSlow("runs");
    if (own !== version) return;
    const refused = done ? done.refused : `it took more than ${slow.limit / 1000} s and was stopped; 'fuzzyctl simulate' runs it`;
    runs = done?.sections ?? found.loops.map((loop) => ({ kind: "loop", name: loop, title: "", source: "", refused }));
    await again("ran");
  }
  let proved = 0;
  for (const [block, section] of found.facts.sections.entries()) {
    if (section.kind === "system" && !section.verdicts.some(([word]) => word === "undecided")) continue;
    const done = await askSlow("proofs", { block });
    if (own !== version) return;
    const why = done?.refused ?? `it took more than ${slow.limit / 1000} s and was stopped; 'fuzzyctl prove' takes more time`;
    add(done?.diagnostics ?? []);
    Object.assign(section, done?.verdicts ? done : { verdicts: [["undecided", "what is claimed", why]] });
    proved += 1;
  }
  if (proved > 0) await again("proved");
  else document.body.dataset.proved = String(own);
}

const together = ({ facts, script }, sections) => ({ facts: { ...facts, sections: [...facts.sections, ...sections] }, script });

// -- texts in and out

/** Opens a text, with the changes that were made to it before. */
function open(title, text, others = {}) {
  const own = fileName(title).slice(-100) || "untitled.fz", state = begin(text), before = state.doc.toString();
  const draft = drafts().find(([, d]) => d.name === own && d.base === before);
  if (draft) resume(draft, others);
  else put(own, before, others, state);
}

/** Shows the state of a text, which no other text is undone in. */
function put(own, before, others, state) {
  [name, base, files, key, runs, fresh] = [own, before, others, crypto.randomUUID(), [], true];
  version += 1;
  engine.place(files);
  at("name").textContent = name;
  document.title = `${name} - fuzzyctl studio`;
  view.setState(state);
  if (engine.ready) status("");
  check();
}

/** Goes on with a draft, under a key of this page: another one may be going on with it, too. */
function resume([old, draft], others = {}) {
  let state, lost = "";
  try {
    state = resumed(draft.state);
  } catch (error) {
    [state, lost] = [begin(draft.state.doc), `, without its undo, which cannot be read: ${error.message}`];
  }
  put(draft.name, draft.base, { ...draft.files, ...others }, state);
  remove(old);
  remember();
  if (isChanged(draft)) status(`the draft of ${name} is open${lost}; 'Examples and drafts' removes it`);
}

/** Keeps the text as a draft. */
function remember() {
  const line = keep(key, { name, base, files, state: kept(), time: Date.now() });
  if (line && view.state.doc.toString() !== base) status(line);
}

/** Takes a draft away, and shows its file as it was opened, if it is the text that is shown. */
function discard(old, draft) {
  remove(old);
  if (old === key) put(draft.name, draft.base, draft.files, begin(draft.base));
  status(`the draft of ${draft.name} is removed`);
}

addEventListener("beforeunload", (event) => isLost() && event.preventDefault());

/** Returns a name without what no file name has, or what is not seen in one. */
const fileName = (text) => text.toWellFormed().replace(/[/\\]|\p{C}/gu, "_");

/** Takes files: opens the rule file that no other one uses; where the text uses them all, they are what it reads. */
async function drop(list) {
  const texts = {};
  for (const file of list) {
    const own = fileName(file.name);
    if (file.size > LARGEST) return status(`${own} is not opened: it has ${file.size} bytes, more than ${LARGEST}`);
    try {
      texts[own] = new TextDecoder("utf-8", { fatal: true }).decode(await file.arrayBuffer());
    } catch (error) {
      return status(`${own} is not opened: ${error instanceof TypeError ? "it is not text in UTF-8" : error.message}`);
    }
  }
  const notes = [];
  for (const own of Object.keys(texts).filter((n) => FOREIGN.test(n))) {
    const found = await engine.ask({ method: "convert", file: `/files/${own}`, text: texts[own] });
    if (!found || found.refused) return status(`${own} is not opened: ${found?.refused ?? "it took too long and was stopped"}`);
    if (found.name in texts) return status(`${own} is not opened: ${found.name} is among the files, too`);
    delete texts[own];
    texts[found.name] = found.text;
    notes.push(`${found.name} is made of ${[own, ...found.notes].join("; ")}`);
  }
  const uses = (text, n) => text.includes(`"${n}"`);
  const free = Object.keys(texts).filter((n) => n.endsWith(".fz") && !uses(view.state.doc.toString(), n));
  const main = free.find((n) => !free.some((other) => other !== n && uses(texts[other], n))) ?? free[0];
  if (!main) {
    engine.place((files = { ...files, ...texts }));
    version += 1;
    await check();
    return status(`the text may use ${Object.keys(texts).join(", ")}`);
  }
  open(main, texts[main], { ...files, ...texts });
  if (notes.length) status(notes.join("; "));
}

function save(file, text) {
  const anchor = document.createElement("a");
  anchor.href = URL.createObjectURL(new Blob([text], { type: "application/octet-stream" }));
  anchor.download = file;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 10_000);
}

/** Saves files one after the other: browsers drop one of two that are saved at once. */
async function saveAll(list) {
  for (const { file, content } of list) {
    save(file, content);
    await new Promise((resolve) => setTimeout(resolve, 300));
  }
}

/** Formats that the text is saved in, by what they are called. */
const FORMATS = [["rule file (.fz)", "fz"], ["page (.html)", "page"], ["C", "c"], ["JavaScript", "javascript"], ["Python", "python"], ["Structured Text", "st"]];

/** Offers formats, and the pictures of the page, each as it stands there: its axes, its turn, the point. */
async function offerToSave() {
  const old = at("frames").classList.contains("stale");
  const all = old ? [] : (await shown.files("names")).map(({ file }) => file);
  const both = (files) => [["SVG", () => savePictures("svg", files)], ["PNG", () => savePictures("png", files)]];
  const pictures = all.map((file) => [file, both([file])]);
  if (all.length > 1) pictures.push(["all of them", both(all)]);
  offer("Save", [["Files", FORMATS.map(([text, format]) => [text, () => saveAs(format)])], ["Pictures", pictures]], old ? note("No pictures: the one on the page is not that of the text.") : null);
}

function note(text) {
  const found = document.createElement("p");
  found.className = "note";
  found.textContent = text;
  return found;
}

async function saveAs(format) {
  if (format === "fz") {
    save(name, (base = view.state.doc.toString()));
    status(`saved ${name}`);
    return remember();
  }
  if (format === "page") status("the page is made, with runs and proofs …");
  const found = await (format === "page" ? askSlow("page") : ask("export", { target: format }));
  if (!found || found.refused) return status(`nothing is saved: ${found?.refused ?? "it took too long and was stopped"}`);
  const written = found.files ?? { [`${name.replace(/\.fz$/, "")}.html`]: found.html };
  await saveAll(Object.entries(written).map(([file, content]) => ({ file, content })));
  const left = found.left_out?.length ? `; left out: ${found.left_out.join("; ")}` : "";
  status(`saved ${Object.keys(written).join(", ")}${left}`);
}

async function savePictures(format, wanted) {
  const found = await shown.files(format, wanted);
  if (found.length === 0) return status("nothing is saved: the picture is another one by now");
  await saveAll(found);
  status(`saved ${found.map((f) => f.file).join(", ")}`);
}

at("open").onchange = async (event) => {
  await drop(event.target.files);
  event.target.value = "";
};
at("save").onclick = offerToSave;
at("format").onclick = async () => {
  const own = version;
  const found = await ask("format");
  if (!found || own !== version) return;
  if (found.refused) return status(found.refused);
  if (found.text !== view.state.doc.toString()) view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: found.text } });
};
at("here").onclick = here;

/** Shows what stands at the cursor, and offers what can be changed there: repairs, and what fuzzyctl can write. */
async function here() {
  const own = version, offset = view.state.selection.main.head;
  const [known, found] = await Promise.all([ask("hover", { offset }), ask("actions", { offset })]);
  if (!found || own !== version) return;
  if (found.refused) return status(found.refused);
  const lead = known?.markdown ? shownMarkdown(known.markdown) : null;
  if (!lead && found.actions.length === 0) return status("nothing is known at the cursor: it stands on no word of the text, and on no mistake with a repair");
  const repair = repairs();
  offer("At the cursor", [["Changes", found.actions.map(({ title, edits }) => [title, () => repair(edits)])]], lead);
}

at("share").onclick = async () => {
  let url;
  try {
    url = await link(name, view.state.doc.toString().toWellFormed(), files);
  } catch (error) {
    return status(`there is no link: ${error.message}`);
  }
  history.replaceState(null, "", url);
  base = view.state.doc.toString();
  remember();
  const copied = await navigator.clipboard.writeText(url).then(() => true, () => false);
  status(copied ? `the link is copied, ${url.length} characters` : "the link stands in the address bar");
};
addEventListener("dragover", (event) => {
  event.preventDefault();
  document.body.classList.add("dropping");
});
addEventListener("dragleave", () => document.body.classList.remove("dropping"));
addEventListener("drop", async (event) => {
  event.preventDefault();
  document.body.classList.remove("dropping");
  if (event.dataTransfer.files.length) await drop(event.dataTransfer.files);
}, { capture: true });

/** Returns the first title of a text, or its first line. */
const titleOf = (text) => /^(?:system|controller|plant|loop)\s+\S+\s+"([^"]+)"/m.exec(text)?.[1] ?? text.split("\n")[0].replace(/^#\s*/, "");

async function start() {
  const examples = await (await fetch("examples.json")).json();
  const groups = Object.entries(Object.groupBy(examples, (e) => e.group));
  const shipped = groups.map(([group, own]) => [group, own.map((e) => [`${e.name}: ${titleOf(e.text)}`, () => open(e.name, e.text, e.files)])]);
  at("examples").onclick = () => offer("Examples and drafts", [["Drafts", drafts().filter(([, d]) => isChanged(d)).map(choices)], ...shipped]);
  const tipper = examples.find((e) => e.name === "tipper.fz"), [last] = drafts();
  if (await follow()) return;
  const line = at("status").textContent;
  if (last) resume(last);
  else open(tipper.name, tipper.text, tipper.files);
  if (line.startsWith("the link")) status(line);
}

/** Returns what can be done with a draft. */
const choices = ([old, draft]) => [`${draft.name}, ${new Date(draft.time).toLocaleString()}`, [["Open", () => resume([old, draft])], ["Remove", () => discard(old, draft)]]];

/** Opens the text of the address, if it has one, and returns whether it has. */
async function follow() {
  try {
    const found = await linked(location.hash);
    if (found) open(found.name, found.text, found.files);
    return found !== null;
  } catch (error) {
    status(`the link holds no text that can be read: ${error.message}`);
    return false;
  }
}
addEventListener("hashchange", follow);
await start();
// For tests.
globalThis.studio = { view, engine, picture: shown, slow: () => slow };
