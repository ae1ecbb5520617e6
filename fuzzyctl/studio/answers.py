"""Answers of the studio's worker: each a function of a text, and of a place in it, to plain data.

The worker runs these functions in WebAssembly, where `arrays` stand for the part of numpy that they take. What takes
more of it is refused by name, never left out.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from fuzzyctl.analysis.prove import UNDIVIDED, quickly, refutation
from fuzzyctl.analysis.verdicts import Refuted, Undecided, Verdict
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.files import sources
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, FuzzyctlError
from fuzzyctl.diagnostics.fixes import Replacement
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.editor import actions, completion, hover
from fuzzyctl.editor.document import Document
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.loading.load import look_through
from fuzzyctl.model.block import Block
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.page.blocks import plain_loop_data, refused_loop_data
from fuzzyctl.page.document import Section, live_document, page_facts, page_script, page_title, unit_section
from fuzzyctl.page.document import document as page_of
from fuzzyctl.page.systems import proofs, verdict_row
from fuzzyctl.support.files import MAX_BYTES


def units(text: str, offset: int) -> int:
    """Return an offset in characters as one in units of UTF-16."""
    before = text[:offset]
    return len(before) if before.isascii() else len(before.encode("utf-16-le", "surrogatepass")) // 2


def characters(text: str, offset: int) -> int:
    """Return an offset in units of UTF-16 as one in characters: the nearest within the text, never inside one."""
    if text.isascii():
        return min(max(offset, 0), len(text))
    before = text.encode("utf-16-le", "surrogatepass")[: 2 * max(offset, 0)]
    return len(before.decode("utf-16-le", "ignore"))


def ends(span: Span) -> dict[str, int]:
    """Return the ends of a location in its text."""
    text = span.source.text
    return {"from": units(text, span.start), "to": units(text, max(span.start, span.end))}


def edits(replacements: Iterable[Replacement], file: str) -> list[dict[str, Any]]:
    """Return the replacements of one file."""
    return [{**ends(r.span), "text": r.text} for r in replacements if r.span.source.name == file]


_Data = dict[str, Any]


class NothingShownError(FuzzyctlError):
    """A text holds nothing that a page could show."""


def answer(request: str) -> str:
    """Answer a request.

    Args:
        request: JSON with `method`, a key of `METHODS`, `file`, the path of the text, `text`, and the arguments of the
            method, such as `offset`, in units of UTF-16.

    Returns:
        JSON: the result of the method, or `refused`, a line with the reason.
    """
    asked = json.loads(request)
    try:
        result = METHODS[asked["method"]](document(asked["file"], asked["text"]), asked)
    except ModuleNotFoundError as error:
        result = {"refused": f"this takes {error.name}, which the studio does not have; the program fuzzyctl does it"}
    except DiagnosticError as error:
        first, *others = error.diagnostics
        more = f", and {counted(len(others), 'more mistake')}" if others else ""
        result = {"refused": f"{first.severity}[{first.code}]: {first.message}{more}"}
    except FuzzyctlError as error:
        result = {"refused": str(error)}
    return json.dumps(result)


@lru_cache(maxsize=4)
def document(file: str, text: str) -> Document:
    """Return a text as a document; files that it uses are read from its folder.

    Raises:
        DiagnosticError: For a text that is too large.
    """
    if len(text) > MAX_BYTES:
        message = f"the text has {len(text)} characters, more than {MAX_BYTES}"
        raise DiagnosticError([Diagnostic("FZ003", message, file=file, help="split the file")])
    return Document(SourceText(file, text), Path(file).parent)


def _check(document: Document, _: _Data) -> _Data:
    """Return all diagnostics, and the blocks that can be shown and exported."""
    try:
        proved, blocks = document.proved, _blocks(document)
    except DiagnosticError as error:
        proved, blocks = list(error.diagnostics), []
    return {
        "diagnostics": [_diagnostic(d, document) for d in proved],
        "blocks": [{"name": b.name, "kind": b.kind} for b in blocks],
    }


def _blocks(document: Document) -> list[FuzzySystem | Controller]:
    return [*document.examined.systems, *document.examined.controllers]


def _diagnostic(d: Diagnostic, document: Document) -> _Data:
    """Return a diagnostic with its repair; one about a used file names it, and stands at the beginning."""
    source = document.source
    is_here = d.span is not None and d.span.source.name == source.name
    at = ends(d.span) if d.span is not None and is_here else {"from": 0, "to": 0}
    place = "" if is_here or d.span is None else str(d.span)
    line = d.span.line if d.span is not None and is_here else 0
    fix = [] if d.fix is None else edits(d.fix.replacements, source.name)
    title = actions.repair_title(d) if fix else ""
    data = {"code": d.code, "severity": d.severity, "message": d.message, "facts": d.explanations, "help": d.help}
    claim: _Data = {}
    if d.witness is not None and d.span is not None and is_here:
        claim = {"block": _block_of(d.span, document), "point": d.witness}
    return {**at, **data, "stops": d.stops, **claim, "place": place, "line": line, "fix": fix, "title": title}


def _block_of(claim: Span, document: Document) -> str:
    """Return the name of the block that makes a claim: the last one that begins before it."""
    spans = {b.name: b.span for b in _blocks(document) if b.span is not None and b.span.source == claim.source}
    return max((span.start, name) for name, span in spans.items() if span.start <= claim.start)[1]


def _complete(document: Document, asked: _Data) -> _Data:
    done = completion.complete(document, characters(document.text, asked["offset"]))
    items = [
        {"label": i.label, "kind": i.kind, "detail": i.detail, "what": i.what, "snippet": i.snippet} for i in done.items
    ]
    return {**ends(done.span), "items": items}


def _hover(document: Document, asked: _Data) -> _Data:
    text = hover.hover(document, characters(document.text, asked["offset"]))
    return {"markdown": ""} if text is None else {**ends(text.span), "markdown": text.markdown}


def _actions(document: Document, asked: _Data) -> _Data:
    """Return the actions at a place: repairs of its line, and completions, such as rows of a table."""
    offset, source = characters(document.text, asked["offset"]), document.source
    broken = actions.repairs(document.proved, *_line(document.text, offset))
    repairs = [(actions.repair_title(d), d.fix.replacements) for d in broken if d.fix is not None]
    repairs += [(a.title, a.replacements) for a in actions.actions(document, offset)]
    return {"actions": [{"title": title, "edits": edits(replacements, source.name)} for title, replacements in repairs]}


def _line(text: str, offset: int) -> tuple[int, int]:
    """Return the ends of the line that holds an offset."""
    end = text.find("\n", offset)
    return text.rfind("\n", 0, offset) + 1, len(text) if end < 0 else end


def _format(document: Document, _: _Data) -> _Data:
    return {"text": format_source(document.source)}


def _convert(document: Document, _: _Data) -> _Data:
    """Return a file of another tool as a rule file, with the losses and warnings in a line each."""
    from fuzzyctl.convert.convert import written  # the start does without

    examined = look_through(document.source)
    reported = examined.reported(examined.diagnostics)
    if any(d.severity == "error" for d in reported):
        raise DiagnosticError(reported)
    texts, notes = [], [f"{d.severity}[{d.code}]: {d.message}" for d in reported]
    for system in examined.systems:
        text, losses = written(system, "fz")
        texts.append(text)
        notes += [f"{loss.where}: {loss.what} ({loss.why})" for loss in losses]
    return {"name": f"{Path(document.source.name).stem}.fz", "text": "\n".join(texts), "notes": notes}


def _frame(_: Document, asked: _Data) -> _Data:
    """Return the page that pictures are shown on."""
    return {"html": live_document(asked["nonce"])}


def _picture(document: Document, _: _Data) -> _Data:
    """Return the data of the frame, without runs of loops."""
    _require_sound(document)
    sections = [_section(block, document) for block in _blocks(document)]
    facts = page_facts(_title(document), sections, document.proved)
    return {"facts": facts, "script": page_script(sections), "loops": [loop.name for loop in document.examined.loops]}


def _runs(document: Document, _: _Data) -> _Data:
    """Return the data of loops in the frame; the reason for one that is not run here."""
    _require_sound(document)
    return {"sections": list(_run_sections(document))}


def _run_sections(document: Document) -> Iterator[_Data]:
    from fuzzyctl.simulation.plain_run import MOST, PlainRunError, plain_run  # the start does without

    left = MOST
    for loop in document.examined.loops:
        try:
            run = plain_run(loop, left, record_calls=True)
        except PlainRunError as error:
            yield refused_loop_data(loop, f"{error}; 'fuzzyctl simulate' runs it")
        else:
            left -= run.operations
            yield plain_loop_data(run)


def _page(document: Document, _: _Data) -> _Data:
    """Return the page of all systems, controllers and loops."""
    _require_sound(document)
    sections = [_section(block, document, decided=True) for block in _blocks(document)]
    sections += map(Section, _run_sections(document))
    return {"html": page_of(_title(document), sections, document.proved)}


def _title(document: Document) -> str:
    """Return the title of the page of a text.

    Raises:
        NothingShownError: For a text without systems, controllers and loops.
    """
    blocks = [*_blocks(document), *document.examined.loops]
    if not blocks:
        raise NothingShownError("there is no system, no controller and no loop to show")
    return page_title([b.title or b.name for b in blocks], Path(document.source.name).stem)


def _section(block: FuzzySystem | Controller, document: Document, *, decided: bool = False) -> Section:
    """Return the section of a block; with `decided`, claims that quick methods leave open are decided."""
    verdicts, rows = block_proofs(block) if decided else (at_once(block), {})
    return unit_section(prepare(block, document.text, verdicts=verdicts), verdicts, rows)


def _proofs(document: Document, asked: _Data) -> _Data:
    """Return the verdicts that the page shows of a block, by its position, and the diagnostics that they add."""
    _require_sound(document)
    verdicts, rows = block_proofs(_blocks(document)[asked["block"]])
    reported = {d.span for d in document.proved if d.witness is not None}
    added = [refutation(v) for v in verdicts if isinstance(v, Refuted) and v.span not in reported]
    return {**rows, "diagnostics": [_diagnostic(d, document) for d in document.examined.reported(added)]}


def _export(document: Document, asked: _Data) -> _Data:
    """Return the files of all blocks in one language; why not, for a block that it cannot express."""
    _require_sound(document)
    files: dict[str, str] = {}
    refused = []
    for block in _blocks(document):
        try:
            # Without the self-tests, whose numbers take numpy.
            files |= sources(prepare(block, document.text, verdicts=quick(block)), asked["target"])
        except CodegenError as error:
            refused.append(f"'{block.name}': {error}")
    if not files:
        return {"refused": "; ".join(refused) or "there is no system and no controller to write"}
    return {"files": files, "left_out": refused}


def _require_sound(document: Document) -> None:
    """Refuse a text with errors other than failed claims.

    Raises:
        DiagnosticError: For one.
    """
    errors = [d for d in document.proved if d.stops]
    if errors:
        raise DiagnosticError(errors)


#: The methods of requests.
METHODS: Final[dict[str, Callable[[Document, _Data], _Data]]] = {
    "check": _check,
    "complete": _complete,
    "hover": _hover,
    "actions": _actions,
    "format": _format,
    "convert": _convert,
    "frame": _frame,
    "picture": _picture,
    "runs": _runs,
    "proofs": _proofs,
    "page": _page,
    "export": _export,
}


#: Seconds that all claims of a block may take together, and most that one of them may.
BLOCK_SECONDS: Final = 16.0
CLAIM_SECONDS: Final = 4.0

#: Why a claim is open until `block_proofs` has decided it.
FOLLOWS: Final = "it takes subdivision, which is under way"


def block_proofs(block: Block) -> tuple[list[Verdict], dict[str, list[list[Any]]]]:
    """Return the verdicts on the claims of a block, and rows that a page shows: of a controller bounds as well."""
    verdicts, rows = proofs(block, quick(block), CLAIM_SECONDS, bound_seconds=0.0, block_seconds=BLOCK_SECONDS)
    advised = list(map(_with_advice, verdicts))
    return advised, {**rows, "verdicts": list(map(verdict_row, advised))}


def quick(block: Any) -> list[Verdict]:
    """Return quick verdicts; none for a controller, as proofs of steps take numpy."""
    return [] if block.is_sampled else quickly(block)[0]


def at_once(block: Block) -> list[Verdict]:
    """Return quick verdicts; open ones say that subdivision follows."""
    return [
        replace(v, reason=FOLLOWS) if isinstance(v, Undecided) and v.reason == UNDIVIDED else v for v in quick(block)
    ]


def _with_advice(verdict: Verdict) -> Verdict:
    if isinstance(verdict, Undecided) and verdict.remaining:
        return replace(verdict, reason=f"{verdict.reason}; 'fuzzyctl prove' takes more time")
    return verdict
