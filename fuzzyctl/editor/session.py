"""State of the language server: the documents that are open, each in its last version, and their proofs.

Diagnostics come in two tiers: names and syntax at once, what needs a proof once the text has rested. A check that a
newer version of its text has overtaken is not published, and its proofs stop.
"""

from __future__ import annotations

import asyncio
import gc
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final
from urllib.parse import unquote

from lsprotocol import types as lsp
from pygls import uris
from pygls.lsp.server import LanguageServer
from pygls.workspace import TextDocument

import fuzzyctl
from fuzzyctl.diagnostics.diagnostic import CODES, Diagnostic, DiagnosticError, first_of
from fuzzyctl.diagnostics.fixes import Replacement
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.editor import lights
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.lights import Light
from fuzzyctl.editor.protocol import Protocol, is_of_client, log_in_lines
from fuzzyctl.editor.symbols import Symbol
from fuzzyctl.support.files import MAX_BYTES, is_below, read_source

#: Seconds that a text rests before it is checked, in which a burst of changes arrives, and before its proofs begin.
BREATH: Final = 0.001
REST: Final = 0.1
#: Most diagnostics of a text that are sent: editors show no more, and take seconds for ten thousands.
MOST_SENT: Final = 1000

_SEVERITIES: Final = {
    "error": lsp.DiagnosticSeverity.Error,
    "warning": lsp.DiagnosticSeverity.Warning,
    "hint": lsp.DiagnosticSeverity.Hint,
}
#: The range of diagnostics on a whole text.
_NOWHERE: Final = lsp.Range(lsp.Position(0, 0), lsp.Position(0, 0))
#: The kinds of symbols in outlines.
SYMBOL_KINDS: Final = {
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


@dataclass(frozen=True)
class Abilities:
    """The capabilities of the client beyond those of all."""

    snippets: bool = False
    pulls: bool = False
    refreshes_diagnostics: bool = False
    refreshes_hints: bool = False
    refreshes_lenses: bool = False
    shows_documents: bool = False
    relates: bool = False
    tags: bool = False


class FuzzyServer(LanguageServer):
    """The documents that are open, each in its last version."""

    def __init__(self) -> None:
        super().__init__("fuzzyctl", fuzzyctl.__version__, protocol_cls=Protocol)
        log_in_lines()
        self._documents: dict[str, tuple[int | None, Document]] = {}
        self._proofs: dict[str, asyncio.Task[None]] = {}
        # One after the other: two proofs at once take the processor from the answers.
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="proofs")
        self.files = Workspace()
        self._proofs_ended = 0
        settle_collector()

    @property
    def knows(self) -> Abilities:
        """The capabilities of the client."""
        caps = self.client_capabilities
        text, workspace, window = caps.text_document, caps.workspace, caps.window
        item = text.completion.completion_item if text and text.completion else None
        published = text.publish_diagnostics if text else None
        return Abilities(
            snippets=bool(item and item.snippet_support),
            pulls=bool(text and text.diagnostic),
            refreshes_diagnostics=bool(workspace and workspace.diagnostics and workspace.diagnostics.refresh_support),
            refreshes_hints=bool(workspace and workspace.inlay_hint and workspace.inlay_hint.refresh_support),
            refreshes_lenses=bool(workspace and workspace.code_lens and workspace.code_lens.refresh_support),
            shows_documents=bool(window and window.show_document and window.show_document.support),
            relates=bool(published and published.related_information),
            tags=bool(published and published.tag_support),
        )

    @property
    def opened(self) -> dict[str, Document]:
        """The documents that are open and stand for files, by absolute path."""
        paths = {text.uri: path_of(text.uri) for text in self.workspace.text_documents.values()}
        return {os.path.abspath(path): self.document(uri) for uri, path in paths.items() if path is not None}

    @property
    def folders(self) -> list[Path]:
        """The folders that are open."""
        folders = [path_of(uri) for uri in self.workspace.folders] or [self.workspace.root_path]
        return [Path(folder) for folder in folders if folder]

    @property
    def others(self) -> list[Document]:
        """The documents that are open, and the rule files of the folders."""
        return list(self.files.documents(self.folders, self.opened))

    def report_server_error(self, error: Exception, source: Any) -> None:
        """Show a message for a mistake of the server; one of a client is answered and logged."""
        if not is_of_client(error):
            super().report_server_error(error, source)

    def document(self, uri: str) -> Document:
        """Return the text of a document as it is now; an empty one for a text that is too large to be read."""
        text = self._open_text(uri)
        if text is None:
            return self._closed_document(uri)
        version, document = self._documents.get(uri, (None, None))
        if document is None or version != text.version:
            path = path_of(uri)
            content = text.source
            is_large = len(content) > MAX_BYTES
            source = SourceText(path if path is not None else uri, "" if is_large else content)
            folder = Path(path).parent if path is not None else None
            document = Document(source, folder, self._buffers(uri), len(content) if is_large else 0)
            self._documents[uri] = (text.version, document)
        return document

    def _open_text(self, uri: str) -> TextDocument | None:
        """Return the text that the client has opened under an address."""
        text: TextDocument | None = self.workspace.text_documents.get(unquote(uri))
        return text

    def _closed_document(self, uri: str) -> Document:
        """Return a document that the client has not opened: a file below an open folder, else an empty text."""
        path = path_of(uri)
        if path is not None and any(is_below(path, folder) for folder in self.folders):
            with suppress(DiagnosticError):
                return Document(read_source(path, only_regular=True), Path(path).parent, self._buffers(uri))
        return Document(SourceText(uri, ""))

    def _buffers(self, uri: str) -> dict[str, str]:
        """Return the texts of the other open documents by path."""
        buffers = {}
        for text in self.workspace.text_documents.values():
            path = path_of(text.uri)
            if text.uri != uri and path is not None:
                buffers[os.path.abspath(path)] = text.source
        return buffers

    def position(self, source: SourceText, offset: int) -> lsp.Position:
        """Return an offset as line and column of the client's units."""
        offset = min(max(offset, 0), len(source.text))
        line = source.line_of(offset)
        before = source.text[source.line_start(line) : offset]
        character = len(before) if before.isascii() else self.units(before)
        return lsp.Position(line - 1, character)

    def units(self, text: str) -> int:
        """Return the length of a text in the client's units."""
        return int(self.workspace.position_codec.client_num_units(text))

    def range(self, span: Span) -> lsp.Range:
        """Return a location in the client's units."""
        return lsp.Range(self.position(span.source, span.start), self.position(span.source, max(span.start, span.end)))

    def location(self, span: Span) -> lsp.Location:
        """Return a location with its file."""
        return lsp.Location(uri_of(span.source.name), self.range(span))

    def offset(self, document: Document, position: lsp.Position) -> int:
        """Return the offset of a position; the end of its line, or of the text, for one beyond."""
        source = document.source
        if position.line >= source.line_count:
            return len(document.text)
        line = source.line_text(position.line + 1)
        at = lsp.Position(0, position.character)
        inside = self.workspace.position_codec.position_from_client_units([line], at).character
        return source.line_start(position.line + 1) + (len(line) if position.character > self.units(line) else inside)

    def edits(self, replacements: Iterable[Replacement]) -> dict[str, list[lsp.TextEdit]]:
        """Return replacements by document."""
        edits: dict[str, list[lsp.TextEdit]] = {}
        for r in replacements:
            edits.setdefault(uri_of(r.span.source.name), []).append(lsp.TextEdit(self.range(r.span), r.text))
        return edits

    # -- diagnostics

    def is_newest(self, uri: str, document: Document) -> bool:
        """Whether a document is the last version of its text."""
        return self._documents.get(uri, (None, None))[1] is document

    def publish(self, uri: str, document: Document, *, proved: bool) -> None:
        """Show the findings on one version of a document; a client that pulls diagnostics gets a refresh."""
        version, newest = self._documents.get(uri, (None, None))
        if newest is not document:
            return
        knows = self.knows
        if not (knows.pulls and knows.refreshes_diagnostics):
            diagnostics = self.diagnostics(document, proved=proved)
            self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, diagnostics, version))
        elif proved:
            self.workspace_diagnostic_refresh(None)
        if proved and knows.refreshes_lenses:
            self.workspace_code_lens_refresh(None)
        if proved and knows.refreshes_hints:
            self.workspace_inlay_hint_refresh(None)

    def diagnostics(self, document: Document, *, proved: bool) -> list[lsp.Diagnostic]:
        """Return the diagnostics of a document, and with proofs those of the lights of its guarantees."""
        diagnostics = [
            d
            for d in diagnostics_of(document, proved=proved)
            if d.span is None or d.span.source.name == document.source.name
        ]
        by_line = {light.span.start: light for light in lights.lights(document)} if proved else {}
        items = [
            self.diagnostic(d, by_line.get(d.span.start) if d.span is not None else None)
            for d in first_of(diagnostics, MOST_SENT)
        ]
        if len(diagnostics) > MOST_SENT:
            more = f"{len(diagnostics) - MOST_SENT} more diagnostics are not shown"
            items.append(lsp.Diagnostic(_NOWHERE, more, lsp.DiagnosticSeverity.Information, source="fuzzyctl"))
        reported = {d.span.start for d in diagnostics if d.code == "FZ402" and d.span is not None}
        return [*items, *(self._of_light(x) for at, x in by_line.items() if at not in reported and _is_shown(x))]

    def diagnostic(self, d: Diagnostic, light: Light | None = None) -> lsp.Diagnostic:
        """Return a diagnostic with its facts, its help and the places that explain it."""
        knows, notes = self.knows, d.notes
        text = [d.message, *d.facts, *([f"help: {d.help}"] if d.help else [])]
        related = [lsp.DiagnosticRelatedInformation(self.location(n.span), n.message) for n in notes]
        if not knows.relates:
            text += [f"line {n.span.line}: {n.message}" for n in notes]
        is_refuted = d.code == "FZ402" and light is not None and bool(light.point)
        if is_refuted and light is not None:
            related.append(self._counterexample(light))
        is_unused = "is not used" in CODES[d.code]
        return lsp.Diagnostic(
            range=self.range(d.span) if d.span is not None else _NOWHERE,
            message="\n".join(text),
            severity=_SEVERITIES[d.severity],
            code=d.code,
            source="fuzzyctl",
            related_information=(related or None) if knows.relates else None,
            tags=[lsp.DiagnosticTag.Unnecessary] if is_unused and knows.tags else None,
            data={"why": lights.point_text(light.point)} if is_refuted and light is not None else None,
        )

    def _of_light(self, light: Light) -> lsp.Diagnostic:
        """Return the verdict on a guarantee by proofs that take longer than a check."""
        is_refuted = light.state == "refuted"
        return lsp.Diagnostic(
            range=self.range(light.span),
            message="the guarantee does not hold\n" + light.text if is_refuted else f"the guarantee is {light.text}",
            severity=lsp.DiagnosticSeverity.Error if is_refuted else lsp.DiagnosticSeverity.Information,
            code="FZ402" if is_refuted else None,
            source="fuzzyctl",
            related_information=[self._counterexample(light)] if light.point and self.knows.relates else None,
            data={"why": lights.point_text(light.point)} if light.point and light.kind != "loop" else None,
        )

    def _counterexample(self, light: Light) -> lsp.DiagnosticRelatedInformation:
        return lsp.DiagnosticRelatedInformation(
            self.location(light.span), f"counterexample: {lights.point_text(light.point)}"
        )

    async def check(self, uri: str, *, others: bool = False) -> None:
        """Show mistakes of syntax and names of a document now, and findings that need a proof after a pause.

        Args:
            uri: The document.
            others: Whether documents that use it are checked again, too.
        """
        document = self.document(uri)
        running = self._proofs.pop(uri, None)
        if running is not None:
            running.cancel()
        await asyncio.sleep(BREATH)
        if not self.is_newest(uri, document) or self.document(uri) is not document:
            return
        self.publish(uri, document, proved=False)
        self._proofs[uri] = asyncio.create_task(self._prove(uri, document))
        if others and path_of(uri) is not None:
            await self.files_changed([uri])

    async def _prove(self, uri: str, document: Document) -> None:
        await asyncio.sleep(REST)
        loop = asyncio.get_running_loop()

        def stopped() -> bool:
            return not self.is_newest(uri, document)

        def check() -> bool:
            diagnostics_of(document, proved=not stopped())
            return lights.prove(document, lights.FIRST, stopped)

        try:
            is_open = await loop.run_in_executor(self._worker, check)
            self.publish(uri, document, proved=True)
            self._proofs_ended += 1
            if self._proofs_ended == 1:  # it imported the modules of proofs
                settle_collector()
            if is_open:
                await loop.run_in_executor(self._worker, lambda: lights.prove(document, lights.LAST, stopped))
                self.publish(uri, document, proved=True)
        except (lights.StoppedError, DiagnosticError):
            return

    async def files_changed(self, changed: Sequence[str]) -> None:
        """Check the open documents again that use files whose content is another one now."""
        paths = {os.path.abspath(p) for p in map(path_of, changed) if p is not None}
        for uri, (_, document) in list(self._documents.items()):
            if uri not in changed and not paths.isdisjoint(document.used):
                self._documents.pop(uri, None)
                if self._open_text(uri) is not None:
                    await self.check(uri)

    async def close(self, uri: str) -> None:
        """Forget a document and take its diagnostics away."""
        self._documents.pop(uri, None)
        running = self._proofs.pop(uri, None)
        if running is not None:
            running.cancel()
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))
        await self.files_changed([uri])


def settle_collector() -> None:
    """Leave all objects so far out of garbage collections, which otherwise delay answers by 50 ms."""
    gc.collect()
    gc.freeze()


def _is_shown(light: Light) -> bool:
    """Whether a light needs a diagnostic: proved and pending claims need none."""
    return light.state in ("refuted", "undecided")


def diagnostics_of(document: Document, *, proved: bool) -> list[Diagnostic]:
    """Return the diagnostics of a document, also of one that is too large to be read."""
    if document.characters:
        message = f"the text has {document.characters} characters, more than {MAX_BYTES}"
        return [Diagnostic("FZ003", message, Span(document.source, 0, 0), help="split the file")]
    try:
        return document.proved if proved else document.mistakes
    except DiagnosticError as error:
        return list(error.diagnostics)


def path_of(uri: str) -> str | None:
    """Return the path of a document by its address; None for one that no file has."""
    try:
        path = uris.to_fs_path(uri)
    except ValueError:  # of brackets that are no IP address
        return None
    return None if path is None or "\0" in path else path


def uri_of(name: str) -> str:
    """Return the address of a source by its name, which is a path or the address of a text that is not a file."""
    if "://" in name or name.startswith("untitled:"):
        return name
    return uris.from_fs_path(os.path.abspath(name)) or name


#: Most files that are looked into, and most names that are returned.
MAX_FILES: Final = 500
MAX_NAMES: Final = 300
#: Folders that hold copies of files.
_SKIPPED: Final = frozenset({"node_modules", "__pycache__"})


class Workspace:
    """Documents of files on disk, each read again when its time or size has changed."""

    def __init__(self) -> None:
        self._read: dict[Path, tuple[tuple[int, int], Document]] = {}

    def documents(self, folders: Iterable[Path], opened: Mapping[str, Document]) -> Iterator[Document]:
        """Yield the documents that are open, then those of the other files below some folders."""
        yield from opened.values()
        for path in rule_files(folders):
            if str(path) not in opened and (document := self._document(path)) is not None:
                yield document

    def symbols(self, folders: Iterable[Path], query: str, opened: Mapping[str, Document]) -> list[Symbol]:
        """Return the names that hold the letters of a query in their order, declared in files below some folders.

        Args:
            folders: The folders.
            query: Letters, case left out; empty for all names.
            opened: Documents that stand for files, by absolute path.
        """
        symbols = [
            symbol
            for document in self.documents(folders, opened)
            for symbol in document.symbols.all
            if symbol.span.source.name == document.source.name and matches(query, symbol.name)
        ]
        return sorted(symbols, key=lambda s: (len(s.name), s.name))[:MAX_NAMES]

    def _document(self, path: Path) -> Document | None:
        try:
            state = path.stat()
            stamp = (state.st_mtime_ns, state.st_size)
            known = self._read.get(path)
            if known is None or known[0] != stamp:
                known = (stamp, Document(read_source(path, only_regular=True), path.parent))
                self._read[path] = known
        except (OSError, DiagnosticError):  # it vanished, or is not text
            return None
        return known[1]


def rule_files(folders: Iterable[Path]) -> Iterator[Path]:
    """Yield the rule files below some folders, without hidden ones and links that lead elsewhere."""
    count = 0
    for top in folders:
        for folder, inside, names in os.walk(top):
            inside[:] = sorted(n for n in inside if n not in _SKIPPED and not n.startswith("."))
            for path in (os.path.abspath(os.path.join(folder, name)) for name in sorted(names)):
                if path.endswith(".fz") and is_below(path, top):
                    count += 1
                    if count > MAX_FILES:
                        return
                    yield Path(path)


def matches(query: str, name: str) -> bool:
    """Whether a name holds the letters of a query in their order."""
    letters = iter(name.lower())
    return all(letter in letters for letter in query.lower())
