"""The language server: requests of an editor, answered from documents, over standard input and output."""

from __future__ import annotations

import asyncio
from dataclasses import asdict, replace
from functools import partial
from typing import Any, Final

from lsprotocol import types as lsp

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.editor import completion, hover, navigation
from fuzzyctl.editor.preview import DRAWER, preview
from fuzzyctl.editor.protocol import RefusedError
from fuzzyctl.editor.requests import COMMANDS, FEATURES
from fuzzyctl.editor.session import SYMBOL_KINDS, FuzzyServer, uri_of
from fuzzyctl.lang.formatter import format_source

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

server = FuzzyServer()
_Params = Any


@server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
async def _opened(ls: FuzzyServer, params: lsp.DidOpenTextDocumentParams) -> None:
    await ls.check(params.text_document.uri, others=True)


@server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
async def _changed(ls: FuzzyServer, params: lsp.DidChangeTextDocumentParams) -> None:
    await ls.check(params.text_document.uri, others=True)


@server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
async def _closed(ls: FuzzyServer, params: lsp.DidCloseTextDocumentParams) -> None:
    await ls.close(params.text_document.uri)


@server.feature(lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES)
async def _files_changed(ls: FuzzyServer, params: lsp.DidChangeWatchedFilesParams) -> None:
    await ls.files_changed([change.uri for change in params.changes])


@server.feature(lsp.TEXT_DOCUMENT_COMPLETION, lsp.CompletionOptions(trigger_characters=[" ", ".", "|", "="]))
def _completion(ls: FuzzyServer, params: lsp.CompletionParams) -> lsp.CompletionList:
    document = ls.document(params.text_document.uri)
    done = completion.complete(document, ls.offset(document, params.position))
    place, snippets = ls.range(done.span), ls.knows.snippets
    items = [
        lsp.CompletionItem(
            label=item.label,
            kind=_ITEMS.get(item.kind, lsp.CompletionItemKind.Variable),
            detail=item.detail or None,
            documentation=item.what or None,
            sort_text=f"{k:04d}",
            text_edit=lsp.TextEdit(place, item.snippet if snippets and item.snippet else item.label),
            insert_text_format=lsp.InsertTextFormat.Snippet if snippets and item.snippet else None,
        )
        for k, item in enumerate(done.items)
    ]
    return lsp.CompletionList(is_incomplete=False, items=items)


@server.feature(lsp.TEXT_DOCUMENT_HOVER)
def _hover(ls: FuzzyServer, params: lsp.HoverParams) -> lsp.Hover | None:
    document = ls.document(params.text_document.uri)
    text = hover.hover(document, ls.offset(document, params.position))
    if text is None:
        return None
    return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, text.markdown), ls.range(text.span))


@server.feature(lsp.TEXT_DOCUMENT_SIGNATURE_HELP, lsp.SignatureHelpOptions(trigger_characters=["(", ","]))
def _signature(ls: FuzzyServer, params: lsp.SignatureHelpParams) -> lsp.SignatureHelp | None:
    document = ls.document(params.text_document.uri)
    call = completion.signature(document, ls.offset(document, params.position))
    if call is None:
        return None
    parameters = [lsp.ParameterInformation(p) for p in call.parameters]
    return lsp.SignatureHelp([lsp.SignatureInformation(call.form, call.what or None, parameters)], 0, call.active)


@server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
def _definition(ls: FuzzyServer, params: lsp.DefinitionParams) -> lsp.Location | None:
    document = ls.document(params.text_document.uri)
    span = navigation.definition(document, ls.offset(document, params.position))
    return ls.location(span) if span is not None else None


@server.feature(lsp.TEXT_DOCUMENT_REFERENCES)
def _references(ls: FuzzyServer, params: lsp.ReferenceParams) -> list[lsp.Location]:
    document = ls.document(params.text_document.uri)
    offset, declaration = ls.offset(document, params.position), params.context.include_declaration
    return [ls.location(s) for s in navigation.references(document, offset, declaration=declaration, others=ls.others)]


@server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT)
def _highlights(ls: FuzzyServer, params: lsp.DocumentHighlightParams) -> list[lsp.DocumentHighlight]:
    document = ls.document(params.text_document.uri)
    spans = navigation.references(document, ls.offset(document, params.position))
    return [lsp.DocumentHighlight(ls.range(s)) for s in spans if s.source.name == document.source.name]


@server.feature(lsp.TEXT_DOCUMENT_PREPARE_RENAME)
def _prepare_rename(ls: FuzzyServer, params: lsp.PrepareRenameParams) -> lsp.Range | None:
    document = ls.document(params.text_document.uri)
    name = navigation.symbol_at(document, ls.offset(document, params.position))
    return ls.range(name[0]) if name is not None else None


@server.feature(lsp.TEXT_DOCUMENT_RENAME, lsp.RenameOptions(prepare_provider=True))
def _rename(ls: FuzzyServer, params: lsp.RenameParams) -> lsp.WorkspaceEdit:
    document = ls.document(params.text_document.uri)
    try:
        changes = navigation.rename(document, ls.offset(document, params.position), params.new_name, ls.others)
    except navigation.RenameError as error:
        raise RefusedError(str(error)) from None
    return lsp.WorkspaceEdit(changes=ls.edits(changes))


@server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
def _symbols(ls: FuzzyServer, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
    document = ls.document(params.text_document.uri)

    def shown(entry: navigation.Entry) -> lsp.DocumentSymbol:
        symbol = entry.symbol
        return lsp.DocumentSymbol(
            name=symbol.name,
            detail=symbol.label or symbol.kind,
            kind=SYMBOL_KINDS.get(symbol.kind, lsp.SymbolKind.Variable),
            range=ls.range(symbol.whole),
            selection_range=ls.range(symbol.span),
            children=[shown(e) for e in entry.inside],
        )

    return [shown(e) for e in navigation.outline(document)]


@server.feature(lsp.TEXT_DOCUMENT_FOLDING_RANGE)
def _folds(ls: FuzzyServer, params: lsp.FoldingRangeParams) -> list[lsp.FoldingRange]:
    return [lsp.FoldingRange(a - 1, b - 1) for a, b in navigation.folds(ls.document(params.text_document.uri))]


@server.feature(lsp.TEXT_DOCUMENT_SELECTION_RANGE)
def _selections(ls: FuzzyServer, params: lsp.SelectionRangeParams) -> list[lsp.SelectionRange]:
    document = ls.document(params.text_document.uri)
    ranges = []
    for position in params.positions:
        outer: lsp.SelectionRange | None = None
        for span in reversed(navigation.selections(document, ls.offset(document, position))):
            outer = lsp.SelectionRange(ls.range(span), outer)
        assert outer is not None
        ranges.append(outer)
    return ranges


@server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_LINK)
def _links(ls: FuzzyServer, params: lsp.DocumentLinkParams) -> list[lsp.DocumentLink]:
    document = ls.document(params.text_document.uri)
    if document.folder is None:
        return []
    folder = document.folder
    return [lsp.DocumentLink(ls.range(s), uri_of(str(folder / name))) for s, name in navigation.links(document)]


@server.feature(lsp.TEXT_DOCUMENT_FORMATTING)
def _formatting(ls: FuzzyServer, params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
    document = ls.document(params.text_document.uri)
    text = format_source(document.source)
    if text == document.text:
        return []
    return [lsp.TextEdit(ls.range(Span(document.source, 0, len(document.text))), text)]


@server.feature("fuzzyctl/preview")
async def _preview(ls: FuzzyServer, params: _Params) -> dict[str, Any]:
    """Answer the request that docs/reference/language-server.md describes."""
    from pygls.exceptions import JsonRpcInvalidParams

    try:
        document = ls.document(params.textDocument.uri)
        offset = ls.offset(document, lsp.Position(int(params.position.line), int(params.position.character)))
        asked = getattr(params, "point", None)
        point = None if asked is None else {str(p.name): float(p.value) for p in asked}
    except (AttributeError, TypeError, ValueError) as error:
        raise JsonRpcInvalidParams(f"fuzzyctl/preview takes textDocument, position, point, pictures: {error}") from None
    draws, dark = getattr(params, "pictures", True) is not False, getattr(params, "dark", False) is True
    draw = partial(preview, document, offset, point, pictures=draws, dark=dark)
    pictures = await asyncio.get_running_loop().run_in_executor(DRAWER, draw)
    region = pictures.region
    answer = asdict(replace(pictures, rule=None, region=None))
    if region is not None:
        answer["region"] = asdict(replace(region, rule=None)) | {"rule": _range_of(ls, region.rule)}
    return answer | {"rule": _range_of(ls, pictures.rule)}


def _range_of(ls: FuzzyServer, span: Span | None) -> lsp.Range | None:
    return ls.range(span) if span is not None else None


for _method, _function, _options in FEATURES:
    server.feature(_method, _options)(_function)
for _name, _function in COMMANDS.items():
    server.command(_name)(_function)
