"""What verdicts look like in a notebook: the claim, what was found, and the witness."""

from __future__ import annotations

from typing import Any

from fuzzyctl.analysis.verdicts import Refuted, Undecided, Verdict, Verdicts
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.display.markup import Markup, lines, page, pairs, paragraph, table


def html(shown: Verdict | Verdicts) -> str:
    """Return one verdict with its witness, or a table of several."""
    if isinstance(shown, Verdicts):
        verdicts = [(word(v), v.claim, _found(v)) for v in shown]
        width = 3 if any(found for _, _, found in verdicts) else 2
        header = ("verdict", "claim", "found")[:width]
        return page(counted(len(shown), "guarantee"), table("", header, [row[:width] for row in verdicts]))
    parts: list[Markup] = [paragraph(_note(shown), "note")]
    if isinstance(shown, Refuted):
        parts.append(_witness(shown))
    if isinstance(shown, Undecided):
        names = list(dict.fromkeys(name for box in shown.boxes for name in box))
        rows = [[str(k + 1), *(str(box.get(n, "")) for n in names)] for k, box in enumerate(shown.boxes)]
        parts.append(table("Open boxes", ("box", *names), rows))
    return page(f"{word(shown)}: {shown.claim}", *parts)


def word(verdict: Verdict) -> str:
    """Return the verdict in one word."""
    return type(verdict).__name__.lower()


def _note(verdict: Verdict) -> str:
    if isinstance(verdict, Undecided):
        return verdict.reason + (f"; {verdict.remaining} boxes remain" if verdict.remaining else "")
    return verdict.note


def _found(verdict: Verdict) -> Any:
    if isinstance(verdict, Refuted):
        return lines(filter(None, (str(verdict.witness), verdict.note)))
    return _note(verdict)


def _witness(verdict: Refuted) -> Markup:
    witness = verdict.witness
    points = [p for p in (witness.point, witness.other) if p is not None]
    rows = [(name, *(repr(p.get(name, "")) for p in points)) for name in witness.point]
    header = ("input", "value", "other value")[: 1 + len(points)]
    sides = pairs("Values there", {side: f"{value:.12g}" for side, value in witness.sides})
    return Markup("\n".join((table("Witness", header, rows), sides)))
