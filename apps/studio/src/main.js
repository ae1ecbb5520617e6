// The studio: a text on the left, what fuzzyctl says of it below, the page of its systems on the right.
import { editor, mark } from "./editor.js";
import { Engine } from "./engine.js";
import { link, linked } from "./link.js";
import { Picture } from "./picture.js";

const at = (id) => document.getElementById(id);
const status = (text) => (at("status").textContent = text);
let name = "untitled.fz";
/** Texts that the text may use, by name. */
let files = {};
/** Milliseconds until a picture that is not complete is said to be an older one. */
const PATIENCE = 500;
/** Milliseconds that the text stays the same before its loops are run and its claims proved. */
const PAUSE = 300;
/** Whether the picture is still that of the file before. */
let fresh = true;
/** The runs that are shown. */
let runs = [];
/** Counts texts, so that no answer is shown that is about an older one. */
let version = 0;

const engine = new Engine((state, detail) => {
  document.body.dataset.state = state;
  if (state === "starting") status("starting fuzzyctl …");
  if (state === "ready") status("ready");
  if (state === "failed") status(`fuzzyctl does not start: ${detail}`);
  if (state === "stopped") {
    status(`stopped: ${detail}; fuzzyctl starts again, and the next change of the text is checked`);
    at("count").textContent = "Not checked";
    at("mistakes").replaceChildren();
    stale("The picture is not that of the text, which takes too long.");
  }
});
/** What runs loops and proves claims, apart, so that keys never wait for it; it starts when it is first asked. */
let slow = null;
const shown = new Picture(at("frames"), (nonce) => ask("frame", { nonce }));
const view = editor(at("editor"), (method, more) => ask(method, more), () => {
  version += 1;
  check();
}, () => changes());

function ask(method, more = {}) {
  return engine.ask({ method, file: `/files/${name}`, text: view.state.doc.toString().toWellFormed(), ...more });
}

function askSlow(method, more = {}) {
  slow ??= new Engine((state, detail) => {
    document.body.dataset.slow = state;
    if (state === "failed") status(`loops and proofs: fuzzyctl does not start: ${detail}`);
  });
  if (slow.files !== files) slow.place(files);
  return slow.ask({ method, file: `/files/${name}`, text: view.state.doc.toString().toWellFormed(), ...more });
}

async function check() {
  const own = version;
  const checked = ask("check");
  const drawn = ask("picture"); // which the worker begins while the mistakes are shown here
  const found = await checked;
  if (!found || own !== version) return;
  if (found.refused) return status(found.refused);
  show(found.diagnostics);
  if (found.diagnostics.some((d) => d.severity === "error")) stale("The text has errors: this is the picture before them.");
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
  status("");
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
  facts.textContent = [...d.facts, ...(d.help ? [`help: ${d.help}`] : [])].join("\n");
  item.append(place, facts);
  if (d.fix.length) {
    const fix = button(`Repair: ${d.title}`, () => repair(d.fix));
    fix.className = "fix";
    item.append(fix);
  }
  return item;
}

function button(text, click) {
  const found = document.createElement("button");
  found.type = "button";
  found.textContent = text;
  found.onclick = click;
  return found;
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
  if (found.loops.length > 0) {
    const done = await askSlow("runs");
    if (own !== version) return;
    const refused = done ? done.refused : `it took more than ${slow.limit / 1000} s and was stopped; 'fuzzyctl simulate' runs it`;
    runs = done?.sections ?? found.loops.map((loop) => ({ kind: "loop", name: loop, title: "", source: "", refused }));
    await again("ran");
  }
  for (const [block, section] of found.facts.sections.entries()) {
    if (section.kind === "system" && !section.verdicts.some(([word]) => word === "undecided")) continue;
    const done = await askSlow("proofs", { block });
    if (own !== version) return;
    const why = done?.refused ?? `it took more than ${slow.limit / 1000} s and was stopped; 'fuzzyctl prove' takes more time`;
    Object.assign(section, done?.verdicts ? done : { verdicts: [["undecided", "what is claimed", why]] });
  }
  await again("proved");
}

const together = ({ facts, script }, sections) => ({ facts: { ...facts, sections: [...facts.sections, ...sections] }, script });

// -- texts in and out

function open(title, text, others = {}) {
  name = title.replace(/[/\\\0]/g, "_").slice(-100) || "untitled.fz";
  files = others;
  runs = [];
  fresh = true;
  engine.place(files);
  at("name").textContent = name;
  document.title = `${name} - fuzzyctl studio`;
  view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: text }, selection: { anchor: 0 } });
}

async function drop(list) {
  const texts = {};
  for (const file of list) {
    if (file.size > 5e6) return status(`${file.name} has ${file.size} bytes, more than 5000000`);
    texts[file.name.replace(/[/\\\0]/g, "_")] = (await file.text()).replace(/^\ufeff/, "");
  }
  const main = Object.keys(texts).find((n) => n.endsWith(".fz"));
  if (!main) {
    engine.place((files = { ...files, ...texts }));
    version += 1;
    await check();
    return status(`the text may use ${Object.keys(texts).join(", ")}`);
  }
  open(main, texts[main], { ...files, ...texts });
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

async function saveAs(format) {
  if (format === "fz") return save(name, view.state.doc.toString());
  if (format === "picture") return offerPictures();
  if (format === "page") status("the page is made, with runs and proofs …");
  const found = await (format === "page" ? askSlow("page") : ask("export", { target: format }));
  if (!found || found.refused) return status(`nothing is saved: ${found?.refused ?? "it took too long and was stopped"}`);
  const written = found.files ?? { [`${name.replace(/\.fz$/, "")}.html`]: found.html };
  await saveAll(Object.entries(written).map(([file, content]) => ({ file, content })));
  const left = found.left_out?.length ? `; left out: ${found.left_out.join("; ")}` : "";
  status(`saved ${Object.keys(written).join(", ")}${left}`);
}

/** Offers the pictures of the page, each as it stands there: its axes, its turn, the point. */
async function offerPictures() {
  if (at("frames").classList.contains("stale")) return status("nothing is saved: the picture is not that of the text");
  const names = await shown.files("names");
  if (names.length === 0) return status("nothing is saved: there is no picture");
  const all = names.map(({ file }) => file);
  const row = (text, files) => {
    const item = document.createElement("li");
    item.append(text, ...["svg", "png"].map((format) => {
      const made = button(format.toUpperCase(), () => savePictures(format, files));
      made.setAttribute("aria-label", `${text} as ${format.toUpperCase()}`);
      return made;
    }));
    return item;
  };
  at("shown").replaceChildren(...all.map((file) => row(file, [file])), ...(all.length > 1 ? [row("all of them", all)] : []));
  at("pictures").showModal();
}

async function savePictures(format, wanted) {
  at("pictures").close();
  const found = await shown.files(format, wanted);
  await saveAll(found);
  status(`saved ${found.map((f) => f.file).join(", ")}`);
}

at("open").onchange = async (event) => {
  await drop(event.target.files);
  event.target.value = "";
};
at("save").onchange = async (event) => {
  const format = event.target.value;
  event.target.value = "";
  if (format) await saveAs(format);
};
at("format").onclick = async () => {
  const own = version;
  const found = await ask("format");
  if (!found || own !== version) return;
  if (found.refused) return status(found.refused);
  if (found.text !== view.state.doc.toString()) view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: found.text } });
};
at("change").onclick = changes;
for (const close of document.querySelectorAll("dialog .close")) close.onclick = () => close.closest("dialog").close();

/** Offers what can be changed at the cursor: repairs, and what fuzzyctl can write. */
async function changes() {
  const own = version;
  const found = await ask("actions", { offset: view.state.selection.main.head });
  if (!found || own !== version) return;
  if (found.refused) return status(found.refused);
  if (found.actions.length === 0) return status("nothing is offered at the cursor: it stands on no mistake with a repair, no table and no variable");
  const repair = repairs();
  at("offered").replaceChildren(...found.actions.map(({ title, edits }) => {
    const item = document.createElement("li");
    item.append(button(title, () => {
      at("changes").close();
      repair(edits);
    }));
    return item;
  }));
  at("changes").showModal();
}

at("share").onclick = async () => {
  let url;
  try {
    url = await link(name, view.state.doc.toString().toWellFormed(), files);
  } catch (error) {
    return status(`there is no link: ${error.message}`);
  }
  history.replaceState(null, "", url);
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

async function start() {
  const examples = await (await fetch("examples.json")).json();
  for (const group of new Set(examples.map((e) => e.group))) {
    const own = document.createElement("optgroup");
    own.label = group;
    own.append(...examples.flatMap((e, k) => (e.group === group ? [new Option(e.name, String(k))] : [])));
    at("examples").append(own);
  }
  at("examples").onchange = ({ target }) => {
    const chosen = examples[Number(target.value)];
    if (target.value !== "") open(chosen.name, chosen.text, chosen.files);
    target.value = "";
  };
  const tipper = examples.find((e) => e.name === "tipper.fz");
  open(tipper.name, tipper.text, tipper.files);
  await follow();
}

/** Opens the text of the address, if it has one. */
async function follow() {
  try {
    const found = await linked(location.hash);
    if (found) open(found.name, found.text, found.files);
  } catch (error) {
    status(`the link holds no text that can be read: ${error.message}`);
  }
}
addEventListener("hashchange", follow);
await start();
// For tests.
globalThis.studio = { view, engine, picture: shown };
