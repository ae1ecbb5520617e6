"""Weak coverage: points where tails of smooth terms alone keep rules active, which the coverage check does not see."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Final

from fuzzyctl.analysis.coverage.fires import Silence, at
from fuzzyctl.analysis.work import SEARCH, SpentError, Work
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.fixes import Fix, Replacement
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Call, Compare, Name
from fuzzyctl.formulas import is_endless
from fuzzyctl.kernels.plan.build import Plan, plan
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Output

#: Activation of the strongest rule below which coverage is weak.
WEAK: Final = 0.1


def diagnostics(system: FuzzySystem, flat: Plan) -> Iterator[Diagnostic]:
    """Report outputs for which the strongest rule acts weakly somewhere within the ranges of the inputs."""
    kinds = {d.set.kind.split()[0] for d in flat.degrees if not d.set.vertices}
    if not any(map(is_endless, kinds)) or flat.initial_state:
        return
    claimed = dict(_claims(system))
    for output in system.outputs:
        if claimed.get(output.name, WEAK) >= WEAK and system.conclusions.get(output.name):
            with suppress(SpentError):
                yield from _weak(system, output, _clamped(flat), is_claimed=output.name in claimed)


def _clamped(flat: Plan) -> Plan:
    return replace(flat, inputs=tuple(replace(i, extrapolate=False) for i in flat.inputs))


def _claims(system: FuzzySystem) -> Iterator[tuple[str, float]]:
    """Yield outputs with the strength that is claimed of their rules."""
    for guarantee in system.guarantees:
        match guarantee.claim:
            case Compare(left=Call(function="total", arguments=(Name(name=name),)), right=strength):
                yield name, system.number(strength)


def _weak(system: FuzzySystem, output: Output, flat: Plan, *, is_claimed: bool) -> Iterator[Diagnostic]:
    from fuzzyctl.analysis.coverage.pattern_search import weakest_point

    # Work of its own: other checks keep theirs.
    silence = Silence(flat, output.name, Work(SEARCH))
    point = weakest_point(flat, silence, WEAK)
    if point is not None and system.method.conjunction != "min":
        # By products of many degrees of one half every activation is small; weak is a rule with a small degree.
        method = system.method.model_copy(update={"conjunction": "min"})
        least = _clamped(plan(system.model_copy(update={"method": method})))
        point = weakest_point(least, Silence(least, output.name, Work(SEARCH)), WEAK)
    if point is None:
        return
    activation = silence.activation(point)
    message = f"no rule for output '{output.name}' acts by more than {activation:.2g} at {at(flat, point)}"
    fact = "terms without an end, such as gaussian and bell, leave a little activation everywhere: tails decide there"
    claim = f"require total({output.name}) >= {WEAK:g}"
    help_text = "let a term of the inputs or a rule reach there"
    help_text += "" if is_claimed else f", and write the claim '{claim}'"
    fix = None if is_claimed else _written(system, output, claim)
    yield Diagnostic("FZ411", message, output.span, "warning", (fact,), help_text, fix=fix)


def _written(system: FuzzySystem, output: Output, claim: str) -> Fix | None:
    """Return the edit that writes a claim below the last rule or guarantee of the system."""
    if output.span is None:
        return None
    source = output.span.source
    spans = [part.span for part in (output, *system.rules, *system.guarantees)]
    last = max(s.end for s in spans if s is not None and s.source is source)
    end = last + len(source.text[last:].partition("\n")[0])
    return Fix((Replacement(Span(source, end, end), f"\n{claim}"),), "likely")
