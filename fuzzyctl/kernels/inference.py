"""From a plan to programs: degrees, firing strengths, activations, outputs."""

from __future__ import annotations

from dataclasses import dataclass

from fuzzyctl.expr import ZERO, Binary, Compare, Expr, Logic, Name, Number, Where, replace_names
from fuzzyctl.kernels.defuzzify import Activation, defuzzify
from fuzzyctl.kernels.plan import InputPlan, OutputPlan, Plan, degree_name
from fuzzyctl.kernels.program import NAN, STATE, Builder, Item, Program, Refuse, any_nan, clip, times


@dataclass(frozen=True)
class _Front:
    """What all programs of a plan begin with: raw inputs and the activation of each rule."""

    builder: Builder
    raw: tuple[Name, ...]
    activations: tuple[Expr, ...]

    @property
    def nan(self) -> Expr:
        return any_nan(self.raw)


def evaluation(plan: Plan) -> Program:
    """Write the program that computes all outputs.

    Its results are NaN where an input is NaN.
    """
    front = _front(plan)
    builder = front.builder
    results = [_output(plan, front, o) for o in range(len(plan.outputs))]
    return _program(plan, builder, [Where(front.nan, NAN, builder.let(r)) for r in results])


def strengths(plan: Plan) -> Program:
    """Write the program that computes the normalised activation ξ_k of each entry of the adaptive state."""
    front = _front(plan)
    normalised = _normalised(plan, front)
    return _program(plan, front.builder, [Where(front.nan, NAN, xi) for xi in normalised], with_state=False)


def rates(plan: Plan) -> Program:
    """Write the program that computes dC_k/dt = rate · ξ_k, zero where C_k would leave the range of its output.

    The rate takes the raw inputs, ξ the clamped ones.
    """
    front = _front(plan)
    builder = front.builder
    raw = {i.name: x for i, x in zip(plan.inputs, front.raw, strict=True)}
    results: list[Expr] = []
    for s, ((o, _), xi) in enumerate(zip(plan.states, _normalised(plan, front), strict=True)):
        output = plan.outputs[o]
        assert output.rate is not None
        rate = builder.let(replace_names(output.rate, dict(raw)))
        # An infinite input times a rule that does not fire would be NaN.
        change = builder.let(Where(Compare(">", xi, ZERO), times(rate, xi), ZERO))
        results.append(Where(front.nan, NAN, Where(_leaves(output, Item(STATE, s), change), ZERO, change)))
    return _program(plan, builder, results)


def _leaves(output: OutputPlan, state: Expr, change: Expr) -> Expr:
    up = Logic("and", (Compare(">=", state, Number(output.upper)), Compare(">", change, ZERO)))
    down = Logic("and", (Compare("<=", state, Number(output.lower)), Compare("<", change, ZERO)))
    return Logic("or", (up, down))


def _program(plan: Plan, builder: Builder, results: list[Expr], *, with_state: bool = True) -> Program:
    return Program(
        arguments=tuple(_raw_name(i) for i in range(len(plan.inputs))),
        state=len(plan.states) if with_state else 0,
        tables=tuple(builder.tables.items()),
        body=tuple(builder.statements),
        results=tuple(results),
    )


def _raw_name(position: int) -> str:
    return f"x{position}"


def _front(plan: Plan) -> _Front:
    builder = Builder()
    raw = tuple(Name(_raw_name(i)) for i in range(len(plan.inputs)))
    clamped = [_clamped(builder, i, x) for i, x in zip(plan.inputs, raw, strict=True)]
    degrees = {degree_name(i): builder.let(d.set.degree(clamped[d.input])) for i, d in enumerate(plan.degrees)}
    fired = [builder.let(replace_names(s, degrees)) for s in plan.strengths]
    activations = tuple(
        builder.let(times(fired[r.strength], Number(r.weight))) if r.weight != 0.0 else ZERO for r in plan.rules
    )
    return _Front(builder, raw, activations)


def _clamped(builder: Builder, variable: InputPlan, x: Expr) -> Expr:
    return x if variable.extrapolate else builder.let(clip(x, variable.lower, variable.upper))


def _output(plan: Plan, front: _Front, position: int) -> Expr:
    output = plan.outputs[position]
    states = {k: s for s, (o, k) in enumerate(plan.states) if o == position}
    active = [
        Activation(front.activations[entry.rule], entry.term, states.get(k), plan.rules[entry.rule].weight)
        for k, entry in enumerate(output.implied)
    ]
    value, fires = defuzzify(front.builder, output, [a for a in active if a.strength != ZERO])
    if output.otherwise == "error":
        quiet = Logic("and", (Logic("not", (fires,)), Logic("not", (front.nan,))))
        front.builder.statements.append(Refuse(quiet, output.name))
    return value


def _normalised(plan: Plan, front: _Front) -> list[Expr]:
    """Return ξ of each state entry: activation over the sum of the activations of its output, 0 where none fires."""
    builder = front.builder
    normalised: list[Expr] = []
    for o, k in plan.states:
        own = [front.activations[entry.rule] for entry in plan.outputs[o].implied]
        total = builder.total(own)
        share = Where(Compare(">", total, ZERO), Binary("/", own[k], total), ZERO)
        normalised.append(builder.let(share) if own[k] != ZERO else ZERO)
    return normalised
