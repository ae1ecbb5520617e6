// The text: CodeMirror with colours, completion, hovers and repairs, all answered by fuzzyctl in the worker.
import { acceptCompletion, autocompletion, closeBrackets, completionKeymap, snippet } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyField, historyKeymap } from "@codemirror/commands";
import { HighlightStyle, syntaxHighlighting } from "@codemirror/language";
import { lintGutter, lintKeymap, setDiagnostics } from "@codemirror/lint";
import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import { EditorState } from "@codemirror/state";
import { drawSelection, EditorView, highlightActiveLine, hoverTooltip, keymap, lineNumbers } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import { fz } from "./grammar.js";

const colours = HighlightStyle.define([
  { tag: tags.comment, color: "light-dark(#56616b, #9aa7b3)" },
  { tag: tags.keyword, color: "light-dark(#7a2a8c, #d9a0e8)" },
  { tag: tags.string, color: "light-dark(#1f6b2e, #8fd49a)" },
  { tag: [tags.number, tags.atom], color: "light-dark(#8a4500, #f0b070)" },
  { tag: tags.function(tags.variableName), color: "light-dark(#005a9c, #78b7f0)" },
  { tag: tags.definition(tags.variableName), fontWeight: "600" },
]);
const theme = EditorView.theme({
  "&": { backgroundColor: "var(--back)", color: "var(--ink)", fontSize: "14px" },
  ".cm-content": { caretColor: "var(--ink)", fontFamily: "ui-monospace, monospace" },
  ".cm-cursor": { borderLeftColor: "var(--ink)" },
  ".cm-gutters": { backgroundColor: "var(--bar)", color: "var(--ink)", border: "0" },
  ".cm-activeLine": { backgroundColor: "color-mix(in srgb, var(--blue) 8%, transparent)" },
  ".cm-tooltip": { backgroundColor: "var(--bar)", color: "var(--ink)", border: "1px solid var(--line)" },
});
const KINDS = { keyword: "keyword", term: "enum", param: "constant", function: "function", system: "namespace", hedge: "keyword" };

/** What is kept of a text beside itself. */
const KEPT = { history: historyField };

/**
 * Returns an editor: its view, `begin`, which makes the state of a text, and `kept` and `resumed`, which make data of the
 * state that is shown, with its history, and a state of such data.
 * @param parent Its element.
 * @param ask Asks fuzzyctl about the text: a method and what it takes; a promise of the answer, null for none.
 * @param changed Hears of each new text.
 * @param here Shows what stands at the cursor.
 */
export function editor(parent, ask, changed, here) {
  const complete = async (context) => {
    const found = await ask("complete", { offset: context.pos });
    if (!found?.items?.length || (!context.explicit && found.from === found.to)) return null;
    const options = found.items.map((item, k) => ({
      label: item.label,
      detail: item.detail,
      info: item.what || undefined,
      type: KINDS[item.kind] ?? "variable",
      boost: -k / found.items.length,
      apply: item.snippet ? snippet(item.snippet) : undefined,
    }));
    return { from: found.from, to: found.to, options, validFor: /^[\p{L}\p{N}_]*$/u };
  };
  const hover = hoverTooltip(async (view, pos) => {
    const found = await ask("hover", { offset: pos });
    return found?.markdown ? { pos: found.from, end: found.to, above: true, create: () => ({ dom: shownMarkdown(found.markdown) }) } : null;
  });
  const extensions = [
    lineNumbers(),
    lintGutter(),
    history(),
    drawSelection(),
    highlightActiveLine(),
    highlightSelectionMatches(),
    closeBrackets(),
    fz,
    syntaxHighlighting(colours),
    theme,
    autocompletion({ override: [complete] }),
    hover,
    // Tab leaves the text, so that the keyboard reaches the rest of the page.
    keymap.of([{ key: "Mod-Enter", run: acceptCompletion }, { key: "Mod-.", run: () => (here(), true) }, ...completionKeymap, ...lintKeymap, ...searchKeymap, ...historyKeymap, ...defaultKeymap]),
    EditorView.contentAttributes.of({ "aria-label": "Rule file", spellcheck: "false" }),
    EditorView.updateListener.of((update) => update.docChanged && changed()),
  ];
  const begin = (doc) => EditorState.create({ doc, extensions });
  const view = new EditorView({ parent, state: begin("") });
  view.scrollDOM.tabIndex = 0; // the keyboard scrolls it
  return { view, begin, kept: () => view.state.toJSON(KEPT), resumed: (data) => EditorState.fromJSON(data, { extensions }, KEPT) };
}

/** Returns what a repair does: what is replaced, where that is short, and else what the diagnostic advises. */
export function repairText(view, { fix, title }) {
  const [{ from, to, text }] = fix, before = view.state.sliceDoc(from, to);
  if (fix.length > 1 || before.length + text.length > 60 || /\n/.test(before + text)) return `Repair: ${title}`;
  return before === "" ? `Repair: insert '${text}'` : text === "" ? `Repair: remove '${before}'` : `Repair: replace '${before}' by '${text}'`;
}

/** Shows diagnostics in the text; `repair` puts a repair in. */
export function mark(view, diagnostics, repair) {
  const length = view.state.doc.length;
  const marks = diagnostics.map((d) => ({
    from: Math.min(d.from, length),
    to: Math.min(d.to, length),
    severity: d.severity,
    message: [d.message, ...d.facts, ...(d.help ? [`help: ${d.help}`] : [])].join("\n"),
    source: d.code,
    actions: d.fix.length ? [{ name: repairText(view, d), apply: () => repair(d.fix) }] : [],
  }));
  view.dispatch(setDiagnostics(view.state, marks.sort((a, b) => a.from - b.from)));
}

/** Returns a text in Markdown as elements: paragraphs, blocks of code, pictures that stand in the text. */
export function shownMarkdown(markdown) {
  const box = document.createElement("div");
  box.className = "cm-hover";
  for (const part of markdown.split("\n\n")) {
    const code = /^```\w*\n([^]*)\n```$/.exec(part);
    const picture = /^!\[([^\]]*)\]\((data:image\/svg\+xml;base64,[\w+/=]+)\)$/.exec(part);
    const element = document.createElement(code ? "pre" : picture ? "img" : "p");
    if (picture) Object.assign(element, { alt: picture[1], src: picture[2] });
    else element.textContent = code ? code[1] : part.replaceAll("`", "").replaceAll("**", "");
    box.append(element);
  }
  return box;
}
