"""Requests of an editor about one document or all files: tokens, hints, lights, actions, layout, names."""

from __future__ import annotations

import asyncio
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, Final

from lsprotocol import types as lsp

from fuzzyctl.diagnostics.fixes import Replacement
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.editor import actions, hover, lights
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.session import SYMBOL_KINDS, FuzzyServer, diagnostics_of, uri_of
from fuzzyctl.editor.symbols import Symbol
from fuzzyctl.editor.words import called
from fuzzyctl.lang.highlight import CLAUSES
from fuzzyctl.lang.lines import LogicalLine
from fuzzyctl.lang.lines import Token as Piece
from fuzzyctl.lang.lines import tokens as pieces
from fuzzyctl.records import dataclass
from fuzzyctl.resolve.settings import SETTINGS

#: Longest message that is shown, in characters, and most seconds that a command may take.
_MESSAGE: Final = 2000
_SECONDS: Final = 120.0


#: Kinds of tokens by their names in the protocol; a token's number there is its position here.
KINDS: Final = (
    "namespace", "class", "function", "property", "variable", "parameter", "enumMember",
    "keyword", "comment", "string", "number",
)  # fmt: skip
MODIFIERS: Final = ("declaration", "readonly")

_OF_SYMBOLS: Final = {
    "system": "namespace",
    "loop": "namespace",
    "rules": "namespace",
    "controller": "class",
    "plant": "class",
    "hedge": "function",
    "function": "function",
    "state": "property",
    "input": "parameter",
    "term": "enumMember",
}
#: Kinds of tokens that need no names to be known, by their kinds in texts.
_ALWAYS: Final = {"comment": "comment", "text": "string", "number": "number"}
_WORDS: Final = frozenset(CLAUSES)


@dataclass(frozen=True)
class Token:
    """A word, a number, a text or a comment.

    Args:
        span: Its location, on one line.
        kind: One of `KINDS`.
        modifiers: Some of `MODIFIERS`.
    """

    span: Span
    kind: str
    modifiers: tuple[str, ...] = ()


def tokens(document: Document, start: int = 0, end: int | None = None) -> Iterator[Token]:
    """Yield the tokens of a range of offsets in the order of the text; words of unknown meaning are left out."""
    text, source = document.text, document.source
    names = {span.start: (span, s) for span, s in document.symbols.uses if span.source.name == source.name}
    lines = iter([*document.lines, LogicalLine(len(text), len(text), "", "blank", "")])
    line, following = next(lines), None
    for piece in pieces(text, start, end):
        while following is None or following.start <= piece.start:
            line, following = following or line, next(lines, None)
            if following is None:
                break
        kind = _ALWAYS.get(piece.kind, "")
        if piece.kind == "name" and piece.start in names:
            yield _named(*names[piece.start])
        elif kind := kind or (_word(text, line, piece) if piece.kind == "name" else ""):
            yield Token(Span(source, piece.start, piece.end), kind)


def _named(span: Span, symbol: Symbol) -> Token:
    modifiers = []
    if span == symbol.span:
        modifiers.append("declaration")
    if symbol.kind in ("param", "term"):
        modifiers.append("readonly")
    return Token(span, _OF_SYMBOLS.get(symbol.kind, "variable"), tuple(modifiers))


def _word(text: str, line: LogicalLine, piece: Piece) -> str:
    """Return the meaning of a word that is not a name; an empty text for an unknown one."""
    word = piece.text
    begins = not text[line.start : piece.start].strip()
    if begins and word == line.word and line.kind in ("statement", "block_statement"):
        return "keyword"
    if text[piece.end : piece.end + 8].lstrip(" \t").startswith("(") and word in called(line.in_block):
        return "function"
    if word in _WORDS or (word == "x" and line.word == "table"):
        return "keyword"
    return "enumMember" if line.word in SETTINGS and word in SETTINGS[line.word] else ""


def _semantic_tokens(ls: FuzzyServer, params: lsp.SemanticTokensParams) -> lsp.SemanticTokens:
    document = ls.document(params.text_document.uri)
    return lsp.SemanticTokens(data=_encoded(ls, tokens(document)))


def _tokens_of_range(ls: FuzzyServer, params: lsp.SemanticTokensRangeParams) -> lsp.SemanticTokens:
    document = ls.document(params.text_document.uri)
    start, end = ls.offset(document, params.range.start), ls.offset(document, params.range.end)
    source = document.source
    start = source.line_start(source.line_of(start))
    return lsp.SemanticTokens(data=_encoded(ls, tokens(document, start, end)))


def _encoded(ls: FuzzyServer, found: Iterable[Token]) -> list[int]:
    """Return tokens as the protocol has them: five numbers each, lines and columns from the token before."""
    data: list[int] = []
    line = column = 0
    for token in found:
        at = ls.position(token.span.source, token.span.start)
        text = token.span.text
        length = len(text) if text.isascii() else ls.units(text)
        bits = sum(1 << MODIFIERS.index(m) for m in token.modifiers)
        column = at.character - column if at.line == line else at.character
        data += [at.line - line, column, length, KINDS.index(token.kind), bits]
        line, column = at.line, at.character
    return data


def _hints(ls: FuzzyServer, params: lsp.InlayHintParams) -> list[lsp.InlayHint]:
    document = ls.document(params.text_document.uri)
    start, end = ls.offset(document, params.range.start), ls.offset(document, params.range.end)
    return [
        lsp.InlayHint(
            position=ls.position(document.source, hint.offset),
            label=hint.text,
            tooltip=hint.what,
            padding_left=not hint.text.startswith("@"),
        )
        for hint in hover.hints(document, start, end)
    ]


def _lenses(ls: FuzzyServer, params: lsp.CodeLensParams) -> list[lsp.CodeLens]:
    uri = params.text_document.uri
    document = ls.document(uri)
    return [
        lsp.CodeLens(ls.range(lens.span), lsp.Command(lens.title, lens.command, arguments=_arguments(uri, lens)))
        for lens in lights.lenses(document)
    ]


def _arguments(uri: str, lens: lights.Lens) -> list[Any]:
    return [uri, lens.block, dict(lens.point)]


def _diagnostics(ls: FuzzyServer, params: lsp.DocumentDiagnosticParams) -> lsp.RelatedFullDocumentDiagnosticReport:
    """Answer with all that is known; a client without refresh is sent diagnostics instead."""
    document = ls.document(params.text_document.uri)
    if ls.knows.pulls and not ls.knows.refreshes_diagnostics:
        return lsp.RelatedFullDocumentDiagnosticReport(items=[])
    items = ls.diagnostics(document, proved="proved" in document.__dict__)
    return lsp.RelatedFullDocumentDiagnosticReport(items=items)


def _workspace_symbols(ls: FuzzyServer, params: lsp.WorkspaceSymbolParams) -> list[lsp.WorkspaceSymbol]:
    symbols = ls.files.symbols(ls.folders, params.query, ls.opened)
    return [
        lsp.WorkspaceSymbol(
            location=ls.location(symbol.span),
            name=symbol.name,
            kind=SYMBOL_KINDS.get(symbol.kind, lsp.SymbolKind.Variable),
            container_name=symbol.owner.name if symbol.owner is not None else None,
        )
        for symbol in symbols
    ]


def _range_formatting(ls: FuzzyServer, params: lsp.DocumentRangeFormattingParams) -> list[lsp.TextEdit]:
    document = ls.document(params.text_document.uri)
    start, end = params.range.start, params.range.end
    last = end.line + (end.character > 0 or end.line == start.line)
    return _text_edits(ls, actions.laid_out(document.source, start.line + 1, last))


def _on_type_formatting(ls: FuzzyServer, params: lsp.DocumentOnTypeFormattingParams) -> list[lsp.TextEdit]:
    document = ls.document(params.text_document.uri)
    return _text_edits(ls, actions.typed(document, ls.offset(document, params.position), params.ch))


def _text_edits(ls: FuzzyServer, changes: Iterable[Replacement]) -> list[lsp.TextEdit]:
    return [lsp.TextEdit(ls.range(c.span), c.text) for c in changes]


def _actions(ls: FuzzyServer, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
    document = ls.document(params.text_document.uri)
    first, last = ls.offset(document, params.range.start), ls.offset(document, params.range.end)
    items = []
    for d in actions.repairs(diagnostics_of(document, proved="proved" in vars(document)), first, last):
        assert d.fix is not None
        items.append(
            lsp.CodeAction(
                title=actions.repair_title(d),
                kind=lsp.CodeActionKind.QuickFix,
                diagnostics=[ls.diagnostic(d)],
                is_preferred=d.fix.applicability == "sure",
                edit=lsp.WorkspaceEdit(changes=ls.edits(d.fix.replacements)),
            )
        )
    for action in actions.actions(document, first):
        kind = lsp.CodeActionKind.RefactorRewrite if action.rewrites else lsp.CodeActionKind.Refactor
        changes = {params.text_document.uri: _text_edits(ls, action.replacements)}
        items.append(lsp.CodeAction(title=action.title, kind=kind, edit=lsp.WorkspaceEdit(changes=changes)))
    return items


# -- commands


@cache
def _pictures() -> tempfile.TemporaryDirectory[str]:
    """Return the folder of pictures, which is removed when the server ends."""
    return tempfile.TemporaryDirectory(prefix="fuzzyctl-")


def _command(name: str) -> Any:
    async def run(
        ls: FuzzyServer, uri: str, block: str = "", point: Mapping[str, Any] | None = None, *quiet: bool
    ) -> dict[str, Any]:
        document = ls.document(uri)
        picture = str(Path(_pictures().name) / f"{block or 'surface'}.svg")
        given = lights.arguments(name, block, point or {}, picture)
        code, text = await _printed(given, document.text, document.folder)
        found = {"exit": code, "text": text, "picture": ""}
        if name == lights.SURFACE and code == 0:
            found["picture"] = picture
            if ls.knows.shows_documents and not any(quiet):
                await ls.window_show_document_async(lsp.ShowDocumentParams(uri_of(picture), external=True))
        elif not any(quiet):
            kind = lsp.MessageType.Info if code == 0 else lsp.MessageType.Warning
            ls.window_show_message(lsp.ShowMessageParams(kind, text[:_MESSAGE]))
        return found

    return run


async def _printed(arguments: Iterable[str], text: str, folder: Path | None) -> tuple[int, str]:
    """Return exit code and output of a command of fuzzyctl, which reads a text from its standard input."""
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "fuzzyctl", *arguments),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
        cwd=folder if folder is not None and folder.is_dir() else None,
    )
    try:
        output, _ = await asyncio.wait_for(process.communicate(text.encode("utf-8", "replace")), _SECONDS)
    except TimeoutError:
        process.kill()
        await process.wait()
        return 1, f"the command took longer than {_SECONDS:g} s"
    return process.returncode or 0, output.decode("utf-8", "replace")


_LEGEND: Final = lsp.SemanticTokensLegend(list(KINDS), list(MODIFIERS))

#: Each method with its answer and its options.
FEATURES: Final[tuple[tuple[str, Any, Any], ...]] = (
    (lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, _semantic_tokens, _LEGEND),
    (lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_RANGE, _tokens_of_range, _LEGEND),
    (lsp.TEXT_DOCUMENT_INLAY_HINT, _hints, None),
    (lsp.TEXT_DOCUMENT_CODE_LENS, _lenses, lsp.CodeLensOptions(resolve_provider=False)),
    (
        lsp.TEXT_DOCUMENT_DIAGNOSTIC,
        _diagnostics,
        lsp.DiagnosticOptions(inter_file_dependencies=True, workspace_diagnostics=False, identifier="fuzzyctl"),
    ),
    (lsp.WORKSPACE_SYMBOL, _workspace_symbols, None),
    (lsp.TEXT_DOCUMENT_RANGE_FORMATTING, _range_formatting, None),
    (
        lsp.TEXT_DOCUMENT_ON_TYPE_FORMATTING,
        _on_type_formatting,
        lsp.DocumentOnTypeFormattingOptions(first_trigger_character="|", more_trigger_character=["\n"]),
    ),
    (
        lsp.TEXT_DOCUMENT_CODE_ACTION,
        _actions,
        lsp.CodeActionOptions(
            code_action_kinds=[
                lsp.CodeActionKind.QuickFix,
                lsp.CodeActionKind.Refactor,
                lsp.CodeActionKind.RefactorRewrite,
            ]
        ),
    ),
)
#: Each command with its function, whose arguments are an address, a block and a point.
COMMANDS: Final[dict[str, Any]] = {name: _command(name) for name in lights.COMMANDS}
