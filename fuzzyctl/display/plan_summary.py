"""Text of `fuzzyctl show --plan`: the algorithm of a system and the reason for it."""

from __future__ import annotations

from typing import Any, Final

from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.compile import MOST_OPERATIONS, operations
from fuzzyctl.kernels.inference.defuzzify.defuzzify import closed_form
from fuzzyctl.kernels.plan.build import Plan, plan
from fuzzyctl.kernels.program.program import Accumulate, Assign, Between, Fold, Locate, Program
from fuzzyctl.model.method import DEFUZZIFIERS, MAXIMA, TSUKAMOTO
from fuzzyctl.model.system import FuzzySystem

#: The work of an algorithm, before the reason for it.
_BECAUSE: Final = {
    "interpolation": "looks up",
    "active": "averages over the rules that act:",
}


def planned(system: FuzzySystem, algorithm: str = "auto") -> dict[str, Any]:
    """Return the algorithm of a system, its reason, and the parts of its programs.

    Args:
        system: The system.
        algorithm: One of `kernels.algorithm.ALGORITHMS`.

    Raises:
        ArgumentError: For an algorithm that the system does not allow.
    """
    flat = plan(system)
    chosen = algorithm_of(flat, algorithm)
    count = operations(chosen.point)
    return {
        "system": system.name,
        "algorithm": chosen.name,
        "reason": chosen.reason,
        "inputs": len(flat.inputs),
        "degrees": len(flat.degrees),
        "firing_strengths": len(flat.strengths),
        "rules": len(flat.rules),
        "states": len(flat.initial_state),
        "outputs": [_output(flat, k) for k in range(len(flat.outputs))],
        "one_point": _program(chosen.point),
        "many_points": _program(chosen.many),
        "operations": count,
        "is_compiled": count <= MOST_OPERATIONS,
    }


def _output(flat: Plan, position: int) -> dict[str, Any]:
    output = flat.outputs[position]
    how = "average of the consequents of rules"
    if output.kind == "weighted_sum":
        how = "sum over the consequents of rules"
    elif output.kind in TSUKAMOTO:
        what = "where monotone consequents have the activations" if output.inverts else "degrees of the activations"
        how = f"{'sum' if output.sums else 'average'} of {what}"
    elif not output.over_rules:
        terms = [output.terms[e.term] for e in output.implied]
        exact = "in closed form" if output.kind in MAXIMA or closed_form(output, terms) else "by adaptive integrals"
        form = exact if output.resolution is None else f"of {output.resolution} samples"
        how = f"{DEFUZZIFIERS[output.kind].title} {form}"
    return {"name": output.name, "how": how, "reads": [flat.outputs[k].name for k in output.reads]}


def _program(program: Program) -> dict[str, int]:
    return {
        "assignments": sum(isinstance(s, Assign) for s in program.body),
        "lookups": sum(isinstance(s, Locate) for s in program.body),
        "loops": sum(isinstance(s, Accumulate | Fold | Between) for s in program.body),
        "table_numbers": sum(len(values) for _, values in program.tables),
    }


def plan_text(data: dict[str, Any]) -> str:
    """Return the same for people."""
    lines = [f"{data['system']}: {data['algorithm']}"]
    because = _BECAUSE.get(data["algorithm"], "evaluates all rules:")
    lines.append(f"  it {because} {data['reason']}")
    lines.append(
        f"  {data['rules']} rules, {data['firing_strengths']} distinct firing strengths of {data['degrees']} degrees"
    )
    for output in data["outputs"]:
        reads = f"; reads {', '.join(output['reads'])}" if output["reads"] else ""
        lines.append(f"  {output['name']}: {output['how']}{reads}")
    for key, what in (("one_point", "one point"), ("many_points", "many points")):
        parts = data[key]
        counts = [f"{count} {name.replace('_', ' ')}" for name, count in parts.items() if count]
        lines.append(f"  {what}: {', '.join(counts)}")
    if not data["is_compiled"]:
        lines.append(f"  {data['operations']:,} operations would take numba long: backend 'auto' takes numpy")
    return "\n".join(lines)
