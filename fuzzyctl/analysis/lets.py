"""Enclosures of lets over all inputs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.interval.scalar import ANYTHING, Interval, enclose
from fuzzyctl.kernels.plan.build import CallPlan, LetPlan, Plan


def enclosed(flat: Plan) -> dict[str, Interval]:
    """Enclose the inputs as consequents see them, and the lets, by name."""
    box = {i.name: ANYTHING if i.extrapolate else (i.lower, i.upper) for i in flat.inputs}
    for let in flat.lets:
        for call in let.calls:
            box[call.name] = _called(call, [enclose(a, box) for a in call.arguments])
        box[let.name] = enclose(let.value, box)
    return box


def narrowed(flat: Plan) -> Plan:
    """Return a plan whose lets have no wider ranges than they need: it computes the same."""
    box = enclosed(flat)
    return replace(flat, lets=tuple(_narrowed(let, box[let.name]) for let in flat.lets))


def without_idle(flat: Plan) -> Plan:
    """Return a plan without its lets where no rule reads one and all have a value everywhere: it computes the same."""
    others = len(flat.inputs) + len(flat.outputs)
    if any(d.variable >= others for d in flat.degrees) or any(let.calls for let in flat.lets):
        return flat
    box = enclosed(flat)
    return flat if any(box[let.name] == ANYTHING for let in flat.lets) else replace(flat, lets=())


def _narrowed(let: LetPlan, ends: Interval) -> LetPlan:
    lower, upper = max(let.lower, ends[0]), min(let.upper, ends[1])
    known = math.isfinite(let.lower) and lower < upper
    return replace(let, lower=lower, upper=upper) if known else let


def _called(call: CallPlan, arguments: Sequence[Interval]) -> Interval:
    """Enclose an output of another system for enclosed arguments."""
    # Only systems that call others need arrays here.
    import numpy as np

    from fuzzyctl.kernels.interval.program import Interpreter
    from fuzzyctl.kernels.interval.vector import constant

    program = inference.evaluation(call.system)
    given = dict(zip(program.arguments, (constant(*ends) for ends in arguments), strict=True))
    with np.errstate(all="ignore"):
        (found,) = Interpreter(given).run(program, [call.output])
    return (float(found.lo), float(found.hi)) if found.lo <= found.hi else ANYTHING
