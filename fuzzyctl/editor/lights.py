"""Guarantee lights: what is proved of each `require` line of a document."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Final, Literal

from fuzzyctl.analysis.bounds import output_bounds
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.editor.document import Document
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.block import Block

State = Literal["proved", "refuted", "undecided", "unknown"]

#: Seconds for one guarantee while others wait, and once all had their turn.
FIRST: Final = 0.3
LAST: Final = 10.0
#: Which verdict counts where several systems share a line.
_ORDER: Final = (Proved, Undecided, Refuted)
#: What is said of a guarantee before any proof.
_OPEN: Final = Undecided("", "")


class StoppedError(Exception):
    """Raised within a proof whose text is no longer the newest."""


@dataclass(frozen=True)
class Light:
    """What is known of one `require` line.

    Args:
        span: The line, without its comment.
        state: "unknown" where no proof of this text has ended yet, and of claims about runs.
        text: The same in words, with the counterexample or what would decide it.
        block: Name of the system, controller or loop.
        kind: "system", "controller" or "loop".
        point: The counterexample.
    """

    span: Span
    state: State
    text: str
    block: str = ""
    kind: str = "system"
    point: dict[str, float] = field(default_factory=dict)


def lights(document: Document) -> list[Light]:
    """Return a light for each `require` line of a document, from the verdicts that it has so far."""
    found, name, kind = [], "", "system"
    for s in document.tree.statements:
        if isinstance(s, sx.System | sx.Head):
            name, kind = s.name.text, "system" if isinstance(s, sx.System) else s.keyword.text
        elif isinstance(s, sx.Require) and s.span.source.name == document.source.name:
            found.append(_light(document, s.span, name, kind))
    return found


def _light(document: Document, span: Span, name: str, kind: str) -> Light:
    found = [v for (at, _), v in list(document.verdicts.items()) if at == span.start]
    match max(found, key=lambda v: _ORDER.index(type(v)), default=None):
        case Proved(note=note):
            return Light(span, "proved", f"proved{f': {note}' if note else ''}", name, kind)
        case Refuted(witness=witness, note=note):
            text = f"refuted {witness}{f' ({note})' if note else ''}"
            return Light(span, "refuted", text, name, kind, dict(witness.point))
        case Undecided(reason=reason):
            return Light(span, "undecided", f"undecided: {reason}", name, kind)
    if kind == "loop":
        return Light(span, "unknown", "judged by a run", name, kind)
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
    for block in (*systems, *document.examined.controllers):
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
