"""The language server: requests of an editor, answered from documents, over standard input and output.

Diagnostics come in two tiers: names and syntax at once, what needs a proof once the text has rested. A check that a
newer version of its text has overtaken is not published.
"""

from __future__ import annotations

import asyncio
import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Final

from lsprotocol import types as lsp
from pygls import uris
from pygls.lsp.server import LanguageServer

import fuzzyctl
from fuzzyctl.diagnostics.diagnostic import CODES, Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.fixes import Replacement
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.editor import completion, hover, navigation, outline, signature
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.preview import DRAWER, preview
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.support.reading import MAX_BYTES

#: Seconds that a text rests before its proofs begin.
_REST: Final = 0.15

_SEVERITIES: Final = {
    "error": lsp.DiagnosticSeverity.Error,
    "warning": lsp.DiagnosticSeverity.Warning,
    "hint": lsp.DiagnosticSeverity.Hint,
}
_SYMBOLS: Final = {
    "system": lsp.SymbolKind.Module,
    "controller": lsp.SymbolKind.Class,
    "plant": lsp.SymbolKind.Class,
    "loop": lsp.SymbolKind.Namespace,
    "param": lsp.SymbolKind.Constant,
    "hedge": lsp.SymbolKind.Operator,
    "function": lsp.SymbolKind.Function,
    "term": lsp.SymbolKind.EnumMember,
    "rules": lsp.SymbolKind.Package,
    "block": lsp.SymbolKind.Object,
    "measure": lsp.SymbolKind.Event,
}
_ITEMS: Final = {
    "keyword": lsp.CompletionItemKind.Keyword,
    "term": lsp.CompletionItemKind.EnumMember,
    "param": lsp.CompletionItemKind.Constant,
    "value": lsp.CompletionItemKind.Value,
    "hedge": lsp.CompletionItemKind.Operator,
    "membership function": lsp.CompletionItemKind.Function,
    "function": lsp.CompletionItemKind.Function,
    "operator": lsp.CompletionItemKind.Function,
    "signal": lsp.CompletionItemKind.Function,
    "measure": lsp.CompletionItemKind.Function,
    "plant": lsp.CompletionItemKind.Function,
    "system": lsp.CompletionItemKind.Module,
    "controller": lsp.CompletionItemKind.Class,
}


class FuzzyServer(LanguageServer):
    """The documents that are open, each in its last version."""

    def __init__(self) -> None:
        super().__init__("fuzzyctl", fuzzyctl.__version__)
        self._documents: dict[str, tuple[int | None, Document]] = {}
        self._proofs: dict[str, asyncio.Task[None]] = {}
        # One after the other: two proofs at once take the processor from the answers.
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="proofs")

    def document(self, uri: str) -> Document:
        """Return the text of a document as it is now."""
        text = self.workspace.get_text_document(uri)
        version, document = self._documents.get(uri, (None, None))
        if document is None or version != text.version or document.text != text.source:
            path = uris.to_fs_path(uri)
            name = path if path is not None else uri
            folder = Path(path).parent if path is not None else None
            document = Document(SourceText(name, text.source), folder)
            self._documents[uri] = (text.version, document)
        return document

    def position(self, span_or_source: Span | SourceText, offset: int) -> lsp.Position:
        """Return an offset as line and column of the client's units."""
        source = span_or_source.source if isinstance(span_or_source, Span) else span_or_source
        offset = min(max(offset, 0), len(source.text))
        line = source.line_of(offset)
        character = source.column_of(offset) - 1
        lines = _lines(source)
        return self.workspace.position_codec.position_to_client_units(lines, lsp.Position(line - 1, character))

    def range(self, span: Span) -> lsp.Range:
        """Return a location in the client's units."""
        return lsp.Range(self.position(span, span.start), self.position(span, max(span.start, span.end)))

    def location(self, span: Span) -> lsp.Location:
        """Return a location with its file."""
        return lsp.Location(_uri(span.source.name), self.range(span))

    def offset(self, document: Document, position: lsp.Position) -> int:
        """Return the offset of a position; the end of its line, or of the text, for one beyond."""
        lines = _lines(document.source)
        if position.line >= len(lines):
            return len(document.text)
        inside = self.workspace.position_codec.position_from_client_units(lines, position)
        start = sum(len(line) for line in lines[: position.line])
        return start + min(inside.character, len(lines[position.line].rstrip("\r\n")))

    def edits(self, replacements: Iterable[Replacement]) -> dict[str, list[lsp.TextEdit]]:
        """Return replacements by document."""
        found: dict[str, list[lsp.TextEdit]] = {}
        for r in replacements:
            found.setdefault(_uri(r.span.source.name), []).append(lsp.TextEdit(self.range(r.span), r.text))
        return found

    # -- diagnostics

    def publish(self, uri: str, document: Document, found: Iterable[Diagnostic]) -> None:
        """Show the diagnostics of one version of a document."""
        version, newest = self._documents.get(uri, (None, document))
        if newest is not document:
            return
        own = [self.diagnostic(d) for d in found if d.span is None or d.span.source.name == document.source.name]
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, own, version))

    def diagnostic(self, d: Diagnostic) -> lsp.Diagnostic:
        """Return a diagnostic with its facts, its help and the places that explain it."""
        nowhere = lsp.Range(lsp.Position(0, 0), lsp.Position(0, 0))
        text = "\n".join([d.message, *d.facts, *([f"help: {d.help}"] if d.help else [])])
        related = [lsp.DiagnosticRelatedInformation(self.location(n.span), n.message) for n in d.notes]
        return lsp.Diagnostic(
            range=self.range(d.span) if d.span is not None else nowhere,
            message=text,
            severity=_SEVERITIES[d.severity],
            code=d.code,
            source="fuzzyctl",
            related_information=related or None,
            tags=[lsp.DiagnosticTag.Unnecessary] if "is used by nothing" in CODES[d.code] else None,
        )

    async def check(self, uri: str) -> None:
        """Show syntax and names of a document now, and what needs a proof once it has rested."""
        document = self.document(uri)
        self.publish(uri, document, _found(document, proved=False))
        running = self._proofs.pop(uri, None)
        if running is not None:
            running.cancel()
        self._proofs[uri] = asyncio.create_task(self._prove(uri, document))

    async def _prove(self, uri: str, document: Document) -> None:
        await asyncio.sleep(_REST)
        loop = asyncio.get_running_loop()
        found = await loop.run_in_executor(self._worker, lambda: _found(document, proved=True))
        self.publish(uri, document, found)

    def close(self, uri: str) -> None:
        """Forget a document and take its diagnostics away."""
        self._documents.pop(uri, None)
        running = self._proofs.pop(uri, None)
        if running is not None:
            running.cancel()
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))


def _found(document: Document, *, proved: bool) -> list[Diagnostic]:
    """Return the diagnostics of a document, also of one that is too large to be read."""
    if len(document.text) > MAX_BYTES:
        message = f"the text has {len(document.text)} characters, more than {MAX_BYTES}"
        return [Diagnostic("FZ003", message, Span(document.source, 0, 0), help="split the file")]
    try:
        return document.proved if proved else document.mistakes
    except DiagnosticError as error:
        return list(error.diagnostics)


def _lines(source: SourceText) -> list[str]:
    return source.text.split("\n") if "\n" not in source.text else [f"{line}\n" for line in source.text.split("\n")]


def _uri(name: str) -> str:
    if "://" in name or name.startswith("untitled:"):
        return name
    return uris.from_fs_path(os.path.abspath(name)) or name


server = FuzzyServer()
_Params = Any


@server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
async def _opened(ls: FuzzyServer, params: lsp.DidOpenTextDocumentParams) -> None:
    await ls.check(params.text_document.uri)


@server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
async def _changed(ls: FuzzyServer, params: lsp.DidChangeTextDocumentParams) -> None:
    await ls.check(params.text_document.uri)


@server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
def _closed(ls: FuzzyServer, params: lsp.DidCloseTextDocumentParams) -> None:
    ls.close(params.text_document.uri)


@server.feature(lsp.TEXT_DOCUMENT_COMPLETION, lsp.CompletionOptions(trigger_characters=[" ", ".", "|", "="]))
def _completion(ls: FuzzyServer, params: lsp.CompletionParams) -> lsp.CompletionList:
    document = ls.document(params.text_document.uri)
    done = completion.complete(document, ls.offset(document, params.position))
    place = ls.range(done.span)
    items = [
        lsp.CompletionItem(
            label=item.label,
            kind=_ITEMS.get(item.kind, lsp.CompletionItemKind.Variable),
            detail=item.detail or None,
            documentation=item.what or None,
            sort_text=f"{k:04d}",
            text_edit=lsp.TextEdit(place, item.label),
        )
        for k, item in enumerate(done.items)
    ]
    return lsp.CompletionList(is_incomplete=False, items=items)


@server.feature(lsp.TEXT_DOCUMENT_HOVER)
def _hover(ls: FuzzyServer, params: lsp.HoverParams) -> lsp.Hover | None:
    document = ls.document(params.text_document.uri)
    found = hover.hover(document, ls.offset(document, params.position))
    if found is None:
        return None
    return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, found.markdown), ls.range(found.span))


@server.feature(lsp.TEXT_DOCUMENT_SIGNATURE_HELP, lsp.SignatureHelpOptions(trigger_characters=["(", ","]))
def _signature(ls: FuzzyServer, params: lsp.SignatureHelpParams) -> lsp.SignatureHelp | None:
    document = ls.document(params.text_document.uri)
    found = signature.signature(document, ls.offset(document, params.position))
    if found is None:
        return None
    parameters = [lsp.ParameterInformation(p) for p in found.parameters]
    return lsp.SignatureHelp([lsp.SignatureInformation(found.form, found.what or None, parameters)], 0, found.active)


@server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
def _definition(ls: FuzzyServer, params: lsp.DefinitionParams) -> lsp.Location | None:
    document = ls.document(params.text_document.uri)
    found = navigation.definition(document, ls.offset(document, params.position))
    return ls.location(found) if found is not None else None


@server.feature(lsp.TEXT_DOCUMENT_REFERENCES)
def _references(ls: FuzzyServer, params: lsp.ReferenceParams) -> list[lsp.Location]:
    document = ls.document(params.text_document.uri)
    offset, declaration = ls.offset(document, params.position), params.context.include_declaration
    return [ls.location(s) for s in navigation.references(document, offset, declaration=declaration)]


@server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT)
def _highlights(ls: FuzzyServer, params: lsp.DocumentHighlightParams) -> list[lsp.DocumentHighlight]:
    document = ls.document(params.text_document.uri)
    found = navigation.references(document, ls.offset(document, params.position))
    return [lsp.DocumentHighlight(ls.range(s)) for s in found if s.source.name == document.source.name]


@server.feature(lsp.TEXT_DOCUMENT_PREPARE_RENAME)
def _prepare_rename(ls: FuzzyServer, params: lsp.PrepareRenameParams) -> lsp.Range | None:
    document = ls.document(params.text_document.uri)
    found = navigation.symbol_at(document, ls.offset(document, params.position))
    return ls.range(found[0]) if found is not None else None


@server.feature(lsp.TEXT_DOCUMENT_RENAME, lsp.RenameOptions(prepare_provider=True))
def _rename(ls: FuzzyServer, params: lsp.RenameParams) -> lsp.WorkspaceEdit:
    from pygls.exceptions import JsonRpcInvalidParams

    document = ls.document(params.text_document.uri)
    try:
        changes = navigation.rename(document, ls.offset(document, params.position), params.new_name)
    except navigation.RenameError as error:
        raise JsonRpcInvalidParams(str(error)) from None
    return lsp.WorkspaceEdit(changes=ls.edits(changes))


@server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
def _symbols(ls: FuzzyServer, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
    document = ls.document(params.text_document.uri)

    def shown(entry: outline.Entry) -> lsp.DocumentSymbol:
        symbol = entry.symbol
        return lsp.DocumentSymbol(
            name=symbol.name,
            detail=symbol.label or symbol.kind,
            kind=_SYMBOLS.get(symbol.kind, lsp.SymbolKind.Variable),
            range=ls.range(symbol.whole),
            selection_range=ls.range(symbol.span),
            children=[shown(e) for e in entry.inside],
        )

    return [shown(e) for e in outline.outline(document)]


@server.feature(lsp.TEXT_DOCUMENT_FOLDING_RANGE)
def _folds(ls: FuzzyServer, params: lsp.FoldingRangeParams) -> list[lsp.FoldingRange]:
    return [lsp.FoldingRange(a - 1, b - 1) for a, b in outline.folds(ls.document(params.text_document.uri))]


@server.feature(lsp.TEXT_DOCUMENT_SELECTION_RANGE)
def _selections(ls: FuzzyServer, params: lsp.SelectionRangeParams) -> list[lsp.SelectionRange]:
    document = ls.document(params.text_document.uri)
    found = []
    for position in params.positions:
        outer: lsp.SelectionRange | None = None
        for span in reversed(outline.selections(document, ls.offset(document, position))):
            outer = lsp.SelectionRange(ls.range(span), outer)
        assert outer is not None
        found.append(outer)
    return found


@server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_LINK)
def _links(ls: FuzzyServer, params: lsp.DocumentLinkParams) -> list[lsp.DocumentLink]:
    document = ls.document(params.text_document.uri)
    if document.folder is None:
        return []
    folder = document.folder
    return [lsp.DocumentLink(ls.range(s), _uri(str(folder / name))) for s, name in outline.links(document)]


@server.feature(lsp.TEXT_DOCUMENT_FORMATTING)
def _formatting(ls: FuzzyServer, params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
    document = ls.document(params.text_document.uri)
    text = format_source(document.source)
    if text == document.text:
        return []
    return [lsp.TextEdit(ls.range(Span(document.source, 0, len(document.text))), text)]


@server.feature(lsp.TEXT_DOCUMENT_CODE_ACTION, lsp.CodeActionOptions(code_action_kinds=[lsp.CodeActionKind.QuickFix]))
def _actions(ls: FuzzyServer, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
    document = ls.document(params.text_document.uri)
    first, last = ls.offset(document, params.range.start), ls.offset(document, params.range.end)
    actions = []
    for d in _found(document, proved=False):
        if d.fix is None or d.span is None:
            continue
        lines = [Span(d.span.source, r.span.start, r.span.end) for r in d.fix.replacements] + [d.span]
        if not any(s.start <= last and first <= max(s.end, s.start) for s in lines):
            continue
        actions.append(
            lsp.CodeAction(
                title=d.help.split("\n")[0] if d.help else f"repair: {d.message}",
                kind=lsp.CodeActionKind.QuickFix,
                diagnostics=[ls.diagnostic(d)],
                is_preferred=d.fix.applicability == "sure",
                edit=lsp.WorkspaceEdit(changes=ls.edits(d.fix.replacements)),
            )
        )
    return actions


@server.feature("fuzzyctl/preview")
async def _preview(ls: FuzzyServer, params: _Params) -> dict[str, Any]:
    """Answer `{textDocument, position, point}` with a `Preview`; `point` is a list of `{name, value}`, or null."""
    document = ls.document(params.textDocument.uri)
    offset = ls.offset(document, lsp.Position(params.position.line, params.position.character))
    asked = getattr(params, "point", None)
    point = None if asked is None else {p.name: float(p.value) for p in asked}
    found = await asyncio.get_running_loop().run_in_executor(DRAWER, preview, document, offset, point)
    return {**asdict(replace(found, rule=None)), "rule": ls.range(found.rule) if found.rule is not None else None}
