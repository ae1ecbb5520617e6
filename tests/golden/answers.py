"""Answers of the language server as short texts: in one process, without a wire, for texts with marks.

A text has the marks ①, ②, ... where a cursor stands. Locations are LINE:COLUMN, from 1, up to the column behind.
"""

import itertools
import re
from base64 import b64decode
from difflib import SequenceMatcher

import pytest
from lsprotocol import types as lsp

from fuzzyctl.editor.server import server
from fuzzyctl.editor.session import lights

MARKS = "".join([*map(chr, range(0x2460, 0x2474)), *map(chr, range(0x3251, 0x3260))])
URI = "untitled:a.fz"
ABLE = lsp.ClientCapabilities(
    text_document=lsp.TextDocumentClientCapabilities(
        publish_diagnostics=lsp.PublishDiagnosticsClientCapabilities(related_information=True)
    )
)
OPTIONS = lsp.FormattingOptions(2, True)


class Case:
    """A text that is open in the server: its places are the positions of its marks, in their order."""

    version = 0

    def __init__(self, marked, argument="", folder=None, able=ABLE, folders=()):
        found = sorted(((m[0], m.start()) for m in re.finditer(f"[{MARKS}]", marked)), key=lambda f: MARKS.index(f[0]))
        self.text = re.sub(f"[{MARKS}]", "", marked)
        self.argument = argument
        self.uri = URI if folder is None else (folder / "a.fz").as_uri()
        offsets = [at - len(re.findall(f"[{MARKS}]", marked[:at])) for _, at in found]
        self.places = [lsp.Position(self.text.count("\n", 0, o), o - self.text.rfind("\n", 0, o) - 1) for o in offsets]
        self.document = lsp.TextDocumentIdentifier(self.uri)
        opened = [lsp.WorkspaceFolder(f.as_uri(), "f") for f in folders]
        list(server.protocol.lsp_initialize(lsp.InitializeParams(able, workspace_folders=opened)))
        self.put(self.uri, self.text)

    def put(self, uri, text):
        """Open a text in the server, or its next version."""
        Case.version += 1
        server.workspace.put_text_document(lsp.TextDocumentItem(uri, "fz", Case.version, text))
        return server.document(uri)

    @property
    def now(self):
        """The document as it is now."""
        return server.document(self.uri)

    def ask(self, method, params):
        return server.protocol.fm.features[method](params)

    def whole(self):
        return lsp.Range(lsp.Position(0, 0), lsp.Position(self.text.count("\n") + 1, 0))

    # -- short texts

    def range(self, r):
        end = f"{r.end.character + 1}" if r.start.line == r.end.line else f"{r.end.line + 1}:{r.end.character + 1}"
        return f"{r.start.line + 1}:{r.start.character + 1}-{end}"

    def inside(self, r):
        lines = self.text.split("\n")[r.start.line : r.end.line + 1]
        lines[-1] = lines[-1][: r.end.character]
        lines[0] = lines[0][r.start.character :]
        return " / ".join(line.strip() for line in lines)

    def after(self, edits):
        """Return the text after some edits, which the protocol applies all at once."""
        lines = self.text.split("\n")
        for e in sorted(edits, key=lambda e: (e.range.start.line, e.range.start.character), reverse=True):
            start, end = e.range.start, e.range.end
            head, tail = lines[start.line][: start.character], lines[end.line][end.character :]
            lines[start.line : end.line + 1] = (head + e.new_text + tail).split("\n")
        return "\n".join(lines)

    def changed(self, edits):
        """Return the lines that some edits change, as they are afterwards; `+` for one that is new."""
        before, after = self.text.split("\n"), self.after(edits).split("\n")
        found = []
        for kind, a, b, c, d in SequenceMatcher(None, before, after, autojunk=False).get_opcodes():
            if kind != "equal":
                found += [f"{k + 1} goes" for k in range(a + d - c, b)]
                found += [f"{a + k + 1 if a + k < b else '+'}|{line}" for k, line in enumerate(after[c:d])]
        return found or ["nothing"]


# -- answers at a place


def completion(case, at):
    found = case.ask("textDocument/completion", lsp.CompletionParams(case.document, at)).items
    begun = {case.inside(i.text_edit.range) for i in found} - {""}
    more = [f"+{len(found) - 9}"] if len(found) > 9 else []
    return [" ".join([*(f"{b}→" for b in begun), *(i.label for i in found[:9]), *more]) or "nothing"]


def hover(case, at):
    found = case.ask("textDocument/hover", lsp.HoverParams(case.document, at))
    if found is None:
        return ["nothing"]
    text = re.sub(r"\n?```(?:fz)?\n?", "", found.contents.value)
    text = re.sub(r"data:image/svg\+xml;base64,([^)]*)", lambda m: f"{b64decode(m[1]).count(b'polyline')} lines", text)
    return [f"{case.range(found.range)} {' / '.join(filter(None, text.split(chr(10))))}"]


def definition(case, at):
    found = case.ask("textDocument/definition", lsp.DefinitionParams(case.document, at))
    return ["nothing" if found is None else _location(case, found)]


def _location(case, found):
    file = "" if found.uri == case.uri else found.uri.rpartition("/")[2] + " "
    return file + (case.range(found.range) if file else f"{case.range(found.range)} {case.inside(found.range)}")


def references(case, at):
    context = lsp.ReferenceContext(case.argument != "uses")
    params = lsp.ReferenceParams(context=context, text_document=case.document, position=at)
    found = case.ask("textDocument/references", params)
    return [" ".join(f"{'' if f.uri == case.uri else 'elsewhere '}{case.range(f.range)}" for f in found) or "nothing"]


def highlight(case, at):
    found = case.ask("textDocument/documentHighlight", lsp.DocumentHighlightParams(case.document, at))
    return [" ".join(case.range(f.range) for f in found) or "nothing"]


def rename(case, at):
    from pygls.exceptions import JsonRpcException

    try:
        found = case.ask("textDocument/rename", lsp.RenameParams(case.document, at, case.argument))
    except JsonRpcException as error:
        return [f"refused: {error.message}"]
    return case.changed(found.changes.get(case.uri, []))


def signature(case, at):
    found = case.ask("textDocument/signatureHelp", lsp.SignatureHelpParams(case.document, at))
    if found is None:
        return ["nothing"]
    parameters = found.signatures[0].parameters
    name = found.signatures[0].label.partition("(")[0]
    shown = [f"[{p.label}]" if k == found.active_parameter else p.label for k, p in enumerate(parameters)]
    return [f"{name}({', '.join(shown)})"]


def selection(case, at):
    (found,) = case.ask("textDocument/selectionRange", lsp.SelectionRangeParams(case.document, [at]))
    ranges = []
    while found is not None:
        ranges.append(case.range(found.range))
        found = found.parent
    return [" < ".join(ranges)]


def actions(case, at):
    params = lsp.CodeActionParams(case.document, lsp.Range(at, at), lsp.CodeActionContext([]))
    found = []
    for action in case.ask("textDocument/codeAction", params):
        found.append(f"{action.kind.value}{', preferred' if action.is_preferred else ''}: {action.title}")
        found += [f"  {line}" for line in case.changed(action.edit.changes[case.uri])]
    return found or ["nothing"]


def typed(case, at):
    character = case.text.split("\n")[at.line][at.character - 1] if at.character else "\n"
    params = lsp.DocumentOnTypeFormattingParams(case.document, at, character, OPTIONS)
    return case.changed(case.ask("textDocument/onTypeFormatting", params))


# -- answers about a text


def prove(case):
    """Prove the guarantees; each look at the clock takes a millisecond, whatever else the machine does."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fuzzyctl.analysis.work.clock.now", itertools.count(step=0.001).__next__)
        lights.prove(case.now)


def diagnostics(case):
    prove(case)
    return _diagnostics(case, server.diagnostics(case.now, proved=True))


def pulled(case):
    found = case.ask("textDocument/diagnostic", lsp.DocumentDiagnosticParams(case.document))
    return [found.kind, *_diagnostics(case, found.items)]


def _diagnostics(case, found):
    lines = []
    for d in found:
        severity = d.severity.name.lower()
        lines.append(f"{case.range(d.range)} {severity} {d.code or ''}: {d.message.replace(chr(10), ' / ')}")
        lines += [f"  {_location(case, r.location)}: {r.message}" for r in d.related_information or ()]
    return lines


def symbols(case):
    def shown(found, depth=0):
        for s in found:
            yield f"{'  ' * depth}{s.kind.name} {s.name} {case.range(s.range)} at {case.range(s.selection_range)}"
            yield from shown(s.children, depth + 1)

    return list(shown(case.ask("textDocument/documentSymbol", lsp.DocumentSymbolParams(case.document))))


def workspace_symbols(case):
    found = case.ask("workspace/symbol", lsp.WorkspaceSymbolParams(case.argument.strip('"')))
    return [f"{s.kind.name} {s.name} {s.container_name or '-'} {_location(case, s.location)}" for s in found]


def semantic_tokens(case):
    found = case.ask("textDocument/semanticTokens/full", lsp.SemanticTokensParams(case.document)).data
    legend = server.protocol.server_capabilities.semantic_tokens_provider.legend
    lines, line, column = {}, 0, 0
    for down, right, length, kind, modifiers in zip(*[iter(found)] * 5, strict=True):
        line, column = line + down, right + (0 if down else column)
        bits = [m[0] for k, m in enumerate(legend.token_modifiers) if modifiers >> k & 1]
        word = case.text.split("\n")[line][column : column + length]
        lines.setdefault(line, []).append(f"{word}:{'.'.join([legend.token_types[kind], *bits])}")
    return [f"{k + 1} {'  '.join(words)}" for k, words in lines.items()]


def folding(case):
    found = case.ask("textDocument/foldingRange", lsp.FoldingRangeParams(case.document))
    return [" ".join(f"{f.start_line + 1}-{f.end_line + 1}" for f in found) or "nothing"]


def hints(case):
    if case.argument == "proved":
        prove(case)
    found = case.ask("textDocument/inlayHint", lsp.InlayHintParams(case.document, case.whole()))
    return [f"{h.position.line + 1}:{h.position.character + 1} {h.label} ({h.tooltip})" for h in found]


def lenses(case):
    if case.argument == "proved":
        prove(case)
    found = case.ask("textDocument/codeLens", lsp.CodeLensParams(case.document))
    lines = []
    for lens in found:
        _, block, point = lens.command.arguments
        name = lens.command.command.removeprefix("fuzzyctl.")
        lines.append(f"{lens.range.start.line + 1} {lens.command.title} → {name} {block} {point or ''}".rstrip())
    return lines


def formatted(text):
    """Return a text after the layout of an editor, which lays out broken texts, too."""
    case = Case(text)
    return case.after(case.ask("textDocument/formatting", lsp.DocumentFormattingParams(case.document, OPTIONS)))


def formatting(case):
    found = case.ask("textDocument/formatting", lsp.DocumentFormattingParams(case.document, OPTIONS))
    return case.changed(found)


def range_formatting(case):
    chosen = lsp.Range(*case.places[:2])
    return case.changed(
        case.ask("textDocument/rangeFormatting", lsp.DocumentRangeFormattingParams(case.document, chosen, OPTIONS))
    )


def links(case):
    found = case.ask("textDocument/documentLink", lsp.DocumentLinkParams(case.document))
    folder = case.uri.rpartition("/")[0] + "/"
    return [f"{case.range(f.range)} {f.target.removeprefix(folder)}" for f in found]


AT_PLACES = (completion, hover, definition, references, highlight, rename, signature, selection, actions, typed)
OF_TEXTS = (
    diagnostics, pulled, symbols, workspace_symbols, semantic_tokens, folding, hints, lenses, formatting,
    range_formatting, links,
)  # fmt: skip
