"""Values of what formulas may read at one point, as plain numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.expr import Expr, Name, names_in, replace_names
from fuzzyctl.kernels.backends.python import backend as python_backend
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import CallPlan, Plan
from fuzzyctl.kernels.program.scalar import scalar_function


def known_at(plan: Plan, point: Sequence[float]) -> dict[str, float]:
    """Return the inputs as consequents see them, and the lets, by name."""
    known = {
        i.name: x if i.extrapolate else min(max(x, i.lower), i.upper) for i, x in zip(plan.inputs, point, strict=True)
    }
    for let in plan.lets:
        for call in let.calls:
            known[call.name] = _called(call, [value_of(a, known) for a in call.arguments])
        known[let.name] = value_of(let.value, known)
    return known


def value_of(expr: Expr, known: Mapping[str, float]) -> float:
    """Return the value of an expression over known names."""
    names = list(dict.fromkeys(n.name for n in names_in(expr)))
    # Names of calls are no names of Python.
    places = {name: f"x{k}" for k, name in enumerate(names)}
    function = scalar_function(replace_names(expr, {n: Name(place) for n, place in places.items()}))
    return float(function(**{places[n]: known[n] for n in names}))


def _called(call: CallPlan, arguments: Sequence[float]) -> float:
    """Return an output of another system, NaN where it has none."""
    names = [i.name for i in call.system.inputs]
    program = inference.evaluation(call.system)
    function = python_backend.compile_source(python_backend.evaluation_source(program), program, names)
    try:
        found = function(*arguments)
    except NoRuleFiresError:
        return math.nan
    return float(found[call.output] if isinstance(found, tuple) else found)
