"""Guarantee lights on `require` lines, and the code lenses above lines and blocks."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, Final, Literal

from fuzzyctl.analysis.bounds import output_bounds
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.editor.document import Document
from fuzzyctl.expr import Name, number_text
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.block import Block
from fuzzyctl.resolve.loops import STABLE

State = Literal["proved", "refuted", "undecided", "unknown"]

#: Seconds for one guarantee while others wait, and once all had their turn.
FIRST: Final = 0.3
LAST: Final = 10.0
#: Which verdict counts where several systems share a line.
_ORDER: Final = (Proved, Undecided, Refuted)
#: The text of a guarantee before any proof.
_OPEN: Final = Undecided("", "")


class StoppedError(Exception):
    """Raised within a proof whose text is no longer the newest."""


@dataclass(frozen=True)
class Light:
    """The verdict on one `require` line.

    Args:
        span: The line, without its comment.
        state: "unknown" until a proof of this text has ended, and for requirements on runs.
        text: The same in words, with the counterexample or what would decide it.
        block: Name of the system, controller or loop.
        kind: "system", "controller" or "loop".
        point: The counterexample.
        on_runs: Whether runs decide it, and no proof.
    """

    span: Span
    state: State
    text: str
    block: str = ""
    kind: str = "system"
    point: dict[str, float] = field(default_factory=dict)
    on_runs: bool = False


def lights(document: Document) -> list[Light]:
    """Return a light for each `require` line of a document, from the verdicts that it has so far."""
    rows, name, kind = [], "", "system"
    for s in document.tree.statements:
        if isinstance(s, sx.System | sx.Head):
            name, kind = s.name.text, "system" if isinstance(s, sx.System) else s.keyword.text
        elif isinstance(s, sx.Require) and s.span.source.name == document.source.name:
            light = _light(document, s.span, name, kind)
            is_stable = isinstance(s.claim, Name) and s.claim.name == STABLE
            is_proved = kind != "loop" or isinstance(s, sx.Always) or is_stable
            rows.append(light if is_proved else replace(light, text="judged by a run", on_runs=True))
    return rows


def _light(document: Document, span: Span, name: str, kind: str) -> Light:
    verdicts = [v for (at, _), v in list(document.verdicts.items()) if at == span.start]
    match max(verdicts, key=lambda v: _ORDER.index(type(v)), default=None):
        case Proved(note=note):
            return Light(span, "proved", f"proved{f': {note}' if note else ''}", name, kind)
        case Refuted(witness=witness, note=note):
            text = f"refuted {witness}{f' ({note})' if note else ''}"
            return Light(span, "refuted", text, name, kind, dict(witness.point))
        case Undecided(reason=reason):
            return Light(span, "undecided", f"undecided: {reason}", name, kind)
    if document.mistakes_stop_proofs:
        return Light(span, "unknown", "not proved: there are mistakes", name, kind)
    return Light(span, "unknown", "not proved yet", name, kind)


def prove(document: Document, seconds: float = FIRST, stopped: Callable[[], bool] = lambda: False) -> bool:
    """Prove the guarantees of a document that are not settled; `Document.verdicts` and `Document.bounds` follow.

    Args:
        document: The document.
        seconds: How long one guarantee may take.
        stopped: Whether a newer text makes the proofs idle; asked now and then.

    Returns:
        Whether some are undecided, which more time may change.

    Raises:
        StoppedError: When a newer text is there.
    """

    def progress(*_: object) -> None:
        if stopped():
            raise StoppedError

    if document.mistakes_stop_proofs:
        return False
    systems = document.examined.systems
    for block in (*systems, *document.examined.controllers, *document.examined.loops):
        with suppress(DiagnosticError):  # such as a system that cannot be planned, which a check reports
            for verdict in _verdicts(document, block, seconds, progress):
                if verdict.span is not None:
                    document.verdicts[verdict.span.start, block.name] = verdict
    for system in systems:
        if (system.name, system.outputs[0].name) not in document.bounds:
            with suppress(DiagnosticError):
                bounds = output_bounds(system).values()
                document.bounds.update({(system.name, b.name): (b.lo, b.hi) for b in bounds})
    return any(isinstance(v, Undecided) for v in document.verdicts.values())


def _verdicts(document: Document, block: Block, timeout: float, progress: Callable[..., None]) -> Iterator[Verdict]:
    from fuzzyctl.analysis.prove import prover_of

    def is_open(span: Span | None) -> bool:
        progress()
        if span is None or span.source.name != document.source.name:
            return False
        return isinstance(document.verdicts.get((span.start, block.name), _OPEN), Undecided)

    prover = prover_of(block, timeout, progress)
    yield from (prover.verdict(claim) for claim in prover.own if is_open(claim.span))


#: Names of the commands; each has a document and a block, `why` a point, too.
SURFACE, WHY, PROVE, SIMULATE = COMMANDS = tuple(f"fuzzyctl.{c}" for c in ("surface", "why", "prove", "simulate"))

_SIGNS: Final = {"proved": "✓", "refuted": "✗", "undecided": "?", "unknown": "…"}
_LONGEST: Final = 160


@dataclass(frozen=True)
class Lens:
    """A line of text above a location that runs a command when it is chosen.

    Args:
        span: The location.
        title: The text.
        command: One of `COMMANDS`.
        block: Name of the system, controller or loop.
        point: Values of inputs, for `why`.
    """

    span: Span
    title: str
    command: str
    block: str
    point: Mapping[str, float]


def lenses(document: Document) -> list[Lens]:
    """Return the lenses of a document, by location."""
    known = lights(document)
    claiming = {light.block for light in known if not light.on_runs}
    rows = [_of_light(light) for light in known]
    for _, _, head in document.symbols.scopes:
        if head is None or head.span.source.name != document.source.name:
            continue
        if head.kind == "system":
            rows.append(Lens(head.span, "surface", SURFACE, head.name, {}))
        if head.kind == "controller" or head.name in claiming:
            rows.append(Lens(head.span, "prove", PROVE, head.name, {}))
        if head.kind == "loop":
            rows.append(Lens(head.span, "simulate", SIMULATE, head.name, {}))
    return sorted(rows, key=lambda lens: lens.span.start)


def _of_light(light: Light) -> Lens:
    text = light.text if len(light.text) <= _LONGEST else light.text[: _LONGEST - 1] + "…"
    command = SIMULATE if light.on_runs else PROVE
    if light.state == "refuted" and light.kind == "system":
        command, text = WHY, f"{text} – why"
    return Lens(light.span, f"{_SIGNS[light.state]} {text}", command, light.block, light.point)


def point_text(point: Mapping[str, float]) -> str:
    """Return a point as `fuzzyctl why` takes it."""
    return " ".join(f"{name}={number_text(x)}" for name, x in point.items())


def arguments(command: str, block: str, point: Mapping[str, Any], picture: str) -> Sequence[str]:
    """Return the arguments of the command line for a lens; the text comes from standard input.

    Args:
        command: One of `COMMANDS`.
        block: Name of the system, controller or loop; empty where the file holds one.
        point: Values of inputs.
        picture: Path of the picture that `fuzzyctl.surface` writes.
    """
    chosen = ["--block", block] if block else []
    match command:
        case "fuzzyctl.surface":
            return ["plot-surface", "-", *chosen, "-o", os.fspath(picture)]
        case "fuzzyctl.why":
            return ["why", "-", *chosen, *(f"{n}={number_text(float(x))}" for n, x in point.items())]
        case "fuzzyctl.prove":
            return ["prove", "-", *chosen]
    return ["simulate", "-", *chosen]
