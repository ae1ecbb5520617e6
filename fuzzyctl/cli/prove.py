"""`fuzzyctl prove`: the guarantees of rule files, proved for all inputs or refuted by a point."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import click

from fuzzyctl.cli.common import (
    DONE,
    FAILED,
    FORMAT,
    QUIET,
    STDIN,
    UNDECIDED,
    answers_with_diagnostics,
    end_of_range,
    show,
    timeout_option,
)
from fuzzyctl.cli.loading import Choice, chooses, open_systems
from fuzzyctl.cli.progress import progress
from fuzzyctl.cli.streams import say, write_json
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.analysis.verdicts import Verdict
    from fuzzyctl.model.system import FuzzySystem

Proofs = list[tuple[str, "FuzzySystem", "list[Verdict]"]]


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@chooses
@timeout_option(10.0, "How long one guarantee may take.")
@FORMAT
@QUIET
@answers_with_diagnostics
def prove(files: tuple[str, ...], choice: Choice, timeout: float, form: str) -> int:
    """Prove the guarantees of rule files: their 'require' lines.

    Each one is proved for all inputs, refuted by a point that is evaluated, or left undecided with what would decide
    it. Exit code 1 if one is refuted or a file has mistakes, 3 if one is undecided.

    \b
    fuzzyctl prove rules/*.fz
    fuzzyctl prove rules/ais_reaction.fz --set k_s=0.6
    """
    proofs: Proofs = []
    mistakes: list[Diagnostic] = []
    tell = say if form == "text" else None
    try:
        for file in dict.fromkeys(files):
            try:
                systems = _systems(file, choice)
            except DiagnosticError as error:
                mistakes.extend(error.diagnostics)
                continue
            for system in systems:
                proofs.append((STDIN if file == "-" else file, system, []))
                _prove_all(*proofs[-1], timeout, tell)
    except KeyboardInterrupt:
        show(mistakes)
        say(f"interrupted{': ' if proofs else ''}{_summary(proofs)}", err=True)
        sys.exit(FAILED)
    if form == "json":
        write_json(_as_data(proofs, mistakes))
    else:
        if proofs:
            say(_summary(proofs))
        show(mistakes)
    kinds = {type(v).__name__ for _, _, verdicts in proofs for v in verdicts}
    if mistakes or "Refuted" in kinds:
        return FAILED
    return UNDECIDED if "Undecided" in kinds else DONE


def _systems(file: str, choice: Choice) -> tuple[FuzzySystem, ...]:
    """Return the systems of a file, or the one named; undecided coverage is printed.

    Raises:
        DiagnosticError: With the mistakes of the file.
    """
    from fuzzyctl.analysis.coverage import coverage

    opened = open_systems(file, choice)
    uncovered = opened.file.reported(d for system in opened.systems for d in coverage.diagnostics(system))
    errors = [d for d in uncovered if d.severity == "error"]
    if errors:
        raise DiagnosticError(errors)
    show(uncovered)
    return opened.systems


def _prove_all(
    file: str, system: FuzzySystem, verdicts: list[Verdict], timeout: float, tell: Callable[[str], None] | None
) -> None:
    """Prove the guarantees of a system; tell of each as soon as it is settled."""
    from fuzzyctl.analysis.prove import Prover

    if tell is not None and not system.guarantees:
        tell(f"{file}: {system.name}: no guarantees")
    prover = Prover(system, timeout=timeout)
    for guarantee in system.guarantees:
        with progress() as told:
            prover.progress = None if told is None else _of_boxes(told)
            verdict = prover.verdict(guarantee)
        verdicts.append(verdict)
        if tell is not None:
            tell("\n".join(_lines(file, verdict)))


def _of_boxes(told: Callable[[str], None]) -> Callable[[str, int, int], None]:
    """Return what a prover calls to tell how far it is."""
    return lambda claim, settled, open_: told(f"{claim}: {settled:,} boxes settled, {open_:,} open")


def _lines(file: str, verdict: Verdict) -> Iterator[str]:
    place = str(verdict.span).rpartition(":")[0] if verdict.span is not None else file
    yield f"{place}: {_word(verdict)}: {verdict.claim}"
    yield from (f"    {line}" for line in _details(verdict))


def _word(verdict: Verdict) -> str:
    return type(verdict).__name__.lower()


def _summary(proofs: Proofs) -> str:
    """Return the numbers of guarantees that are proved, refuted, undecided, and not examined."""
    count = Counter(_word(v) for _, _, verdicts in proofs for v in verdicts)
    count["left"] = sum(len(system.guarantees) - len(verdicts) for _, system, verdicts in proofs)
    words = ("proved", "refuted", "undecided", "left")
    return ", ".join(f"{count[word]} {word}" for word in words if count[word] or word == "proved")


def _details(verdict: Verdict) -> Iterator[str]:
    from fuzzyctl.analysis.verdicts import Proved, Refuted

    if isinstance(verdict, Proved):
        if verdict.note:
            yield verdict.note
    elif isinstance(verdict, Refuted):
        yield str(verdict.witness)
    else:
        yield verdict.reason
        for box in verdict.boxes[:3]:
            yield "open: " + ", ".join(f"{n} {'=' if s.lower == s.upper else 'in'} {s}" for n, s in box.items())
        if verdict.remaining > len(verdict.boxes[:3]) > 0:
            yield f"and {verdict.remaining - len(verdict.boxes[:3])} more"


def _as_data(proofs: Proofs, mistakes: Sequence[Diagnostic]) -> dict[str, Any]:
    systems = [
        {
            "file": file,
            "system": s.name,
            "semantics": s.method.semantics.profile,
            "guarantees": [_verdict_data(v) for v in verdicts],
        }
        for file, s, verdicts in proofs
    ]
    return {"systems": systems, "diagnostics": [d.as_dict() for d in mistakes]}


def _verdict_data(verdict: Verdict) -> dict[str, Any]:
    from fuzzyctl.analysis.verdicts import Proved, Refuted

    data: dict[str, Any] = {
        "claim": verdict.claim,
        "line": verdict.span.line if verdict.span is not None else None,
        "verdict": _word(verdict),
    }
    if isinstance(verdict, Proved):
        return data | {"note": verdict.note or None}
    if isinstance(verdict, Refuted):
        w = verdict.witness
        return data | {
            "witness": {"point": w.point, "other": w.other, "values": {n: end_of_range(v) for n, v in w.sides}}
        }
    boxes = [{n: [end_of_range(s.lower), end_of_range(s.upper)] for n, s in box.items()} for box in verdict.boxes]
    return data | {"reason": verdict.reason, "boxes": boxes, "remaining": verdict.remaining}
