"""Conversion between formats, with a report of losses and of the difference of the outputs."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from fuzzyctl.comparison.differences import POINTS, Difference, Progress, differences
from fuzzyctl.comparison.explanation import Explanation, explanation
from fuzzyctl.convert.python_module import module_text
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, UnknownNameError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.common.blocks import without_repeated_outputs
from fuzzyctl.formats.common.identifiers import with_identifiers
from fuzzyctl.formats.common.losses import cannot
from fuzzyctl.formats.fz import dumps
from fuzzyctl.formats.registry import FORMATS, Loss
from fuzzyctl.loading.load import examine
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold
from fuzzyctl.support import arguments

#: Formats of a system, besides the formats of other tools; Markdown and Python are not read back.
OWN: Final = {"fz": ".fz", "python": ".py", "markdown": ".md"}

#: Part of an output's range by which rounding may change its numbers.
TOLERANCE: Final = 1e-9

#: All targets with their usual suffixes.
TARGETS: Final[dict[str, tuple[str, ...]]] = {
    **{name: (suffix,) for name, suffix in OWN.items()},
    **{name: f.suffixes for name, f in FORMATS.items()},
}

#: Part of an output's range by which a file may be off and is written with a report all the same.
SLIGHT: Final = 1e-3


@dataclass(frozen=True)
class Conversion:
    """A system in another format, and what became of it.

    Args:
        target: The format, a key of `TARGETS`.
        text: The file.
        losses: The parts that the format cannot express; `Loss.exact` if no number changes.
        read_back: The system that the text is read as; None for formats that are not read back.
        differences: Between the original and the system read back, one for each output; empty for formats that are not.
        explanations: The explanation of each.
        slight: Whether no output changes by more than `SLIGHT` of its range, within the ranges of the inputs.
    """

    target: str
    text: str
    losses: tuple[Loss, ...]
    read_back: FuzzySystem | None
    differences: tuple[Difference, ...]
    explanations: tuple[Explanation, ...]
    slight: bool = False

    @property
    def lossy(self) -> tuple[Loss, ...]:
        """The losses that change numbers."""
        return tuple(loss for loss in self.losses if not loss.exact)


def convert(system: FuzzySystem, target: str, *, points: int = POINTS, progress: Progress | None = None) -> Conversion:
    """Write a system in another format, read it back, and compare the numbers of both.

    Args:
        system: The system.
        target: A key of `TARGETS`: fz, fll, fis, fcl, fml, python or markdown.
        points: How many points to compare.
        progress: Called now and then during a long comparison.

    Raises:
        UnknownNameError: For no such format.
        DiagnosticError: For a system that the format cannot hold at all.
        ArgumentError: For anything but a FuzzySystem.
    """
    arguments.instance("the system", FuzzySystem, "a FuzzySystem", system)
    if target not in TARGETS:
        raise UnknownNameError("format", target, list(TARGETS))
    text, losses = written(system, target)
    if target in ("python", "markdown"):
        return Conversion(target, text, tuple(losses), None, (), ())
    back = _read_back(system, text, target)
    gaps = _compared(system, back, target, points, progress)
    if not any(not loss.exact for loss in losses):
        losses = [*losses, *_unexplained(system, gaps)]
    explained = tuple(explanation(system, back, d, progress=progress) for d in gaps)
    holds = any(isinstance(o.otherwise, Hold) for o in system.outputs)  # which points apart from each other do not show
    widths = [system.number(o.upper) - system.number(o.lower) for o in system.outputs]
    slight = not holds and all(d.within(SLIGHT * w) for d, w in zip(gaps, widths, strict=True))
    return Conversion(target, text, tuple(losses), back, gaps, explained, slight)


def _compared(
    system: FuzzySystem, back: FuzzySystem, target: str, points: int, progress: Progress | None
) -> tuple[Difference, ...]:
    """Return the differences to the system that is read back.

    Raises:
        DiagnosticError: For what is not computed as the format has it, as where that has no samples for maxima.
    """
    try:
        return differences(system, back, points=points, progress=progress)
    except DiagnosticError as error:
        if any(d.place.startswith(back.path) for d in error.diagnostics):
            raise _refused_there(system, target, error.diagnostics) from None
        raise


def left_out(diagnostics: Iterable[Diagnostic]) -> tuple[Loss, ...]:
    """Return what reading a file left out because it is switched off there, so that no format can get it."""
    reports = [d for d in diagnostics if d.code == "FZ611"]
    return tuple(
        Loss(f"line {d.span.line}" if d.span else "the file", "left out", d.message, exact=True) for d in reports
    )


def _unexplained(system: FuzzySystem, differences: tuple[Difference, ...]) -> list[Loss]:
    """Return what changed although the writer knows of nothing that would: no file is to be other than it says."""
    losses = []
    for d in differences:
        output = system.output(d.output)
        span = abs(system.number(output.upper) - system.number(output.lower))
        if d.gap is not None:
            why = f"only one of both has a value at {d.one_sided:,} of {d.points:,} points, see below"
            losses.append(Loss(f"output '{d.output}'", "whether it has a value", why))
        if d.valued and (math.isinf(d.largest) or d.largest > TOLERANCE * max(span, abs(d.first))):
            losses.append(Loss(f"output '{d.output}'", "its numbers", f"they differ by {d.largest:.3g}, see below"))
    return losses


def written(system: FuzzySystem, target: str) -> tuple[str, list[Loss]]:
    """Return a system as a text, with the losses."""
    reasons = _formulas(system) if target in FORMATS else []
    if target == "python":
        reasons += [f"a call of system '{c.name}'" for c in system.called]
    if reasons:
        raise cannot(system, TARGETS[target][0], reasons)
    if target in FORMATS:
        return FORMATS[target].write(system)
    if target == "markdown":
        from fuzzyctl.convert.markdown import page_text

        return page_text(system, {}), []
    named, losses = with_identifiers(without_repeated_outputs(system))
    if target != "python":
        return dumps(named), losses
    try:
        return module_text(named), losses
    except DiagnosticError as error:
        raise _refused_there(system, target, error.diagnostics) from None


def _formulas(system: FuzzySystem) -> list[str]:
    """Return the lets of a system and its outputs that are formulas, which no other tool has."""
    names = [f"let '{v.name}'" for v in system.lets]
    return names + [f"output '{o.name}', which is a formula" for o in system.outputs if o.value is not None]


def _refused_there(system: FuzzySystem, target: str, diagnostics: Iterable[Diagnostic]) -> DiagnosticError:
    """Return the error for a system that is invalid in the target format, located in the source text."""
    return cannot(system, TARGETS[target][0], [d.message for d in diagnostics if d.severity == "error"])


def _read_back(system: FuzzySystem, text: str, target: str) -> FuzzySystem:
    """Return the system that a written text is read as.

    Raises:
        DiagnosticError: For one that cannot be read, as where the format wants a rule for each output.
    """
    back, diagnostics = examine(SourceText(f"converted{TARGETS[target][0]}", text))
    if back is None:
        raise _refused_there(system, target, diagnostics)
    return back
