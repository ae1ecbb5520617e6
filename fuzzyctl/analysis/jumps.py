"""Jumps of an output: neighbouring floating-point inputs with a discontinuity between them.

They are looked for where terms jump, and where `else` takes over from the last rule; each is shown by evaluating it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from itertools import combinations, islice, pairwise, product
from typing import Any, Final

from fuzzyctl.analysis.coverage.box_search import Hole, Verdict
from fuzzyctl.analysis.degrees import breakpoints, cells, degree_in
from fuzzyctl.analysis.work import Work, compilation, evaluation
from fuzzyctl.diagnostics.diagnostic import Diagnostic, NoRuleFiresError
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Expr, to_text
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import InputPlan, OutputPlan, Plan, SetPlan
from fuzzyctl.kernels.program import scalar
from fuzzyctl.model.method import MAXIMA
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Output
from fuzzyctl.records import record

#: Jumps below this part of an output's range are not reported.
LEAST: Final = 1e-3
#: Most points of the other inputs while one input moves over a candidate.
MOST_POINTS: Final = 100
#: Most candidates looked at: values of inputs at which an output may jump.
MOST_CANDIDATES: Final = 100


@record(frozen=True)
class Jump:
    """A jump.

    Args:
        input: The input that is moved.
        at: Where.
        before, after: The output there and at a neighbouring number, or at both of them, the smaller one first.
        others: Values of the other inputs.
        count: At how many values of inputs the output jumps.
        silent: Whether no rule fires on one side.
    """

    input: str
    at: float
    before: float
    after: float
    others: dict[str, float]
    count: int
    silent: bool

    @property
    def size(self) -> float:
        """By how much the output changes."""
        return abs(self.after - self.before)


def diagnostics(
    system: FuzzySystem, flat: Plan, verdicts: dict[str, Verdict], work: Work | None = None
) -> list[Diagnostic]:
    """Report the largest jump of each output; maxima jump in every correct file, from one term to the next.

    Args:
        system: The system.
        flat: Its plan.
        verdicts: On the coverage of the outputs.
        work: The work that is allowed for all outputs.
    """
    search, result = _Evaluation(flat, Work() if work is None else work), []
    for output in system.outputs:
        if (output.defuzzifier or system.method.defuzzifier).kind in MAXIMA:
            continue
        jump = largest_jump(flat, output.name, verdicts[output.name], search)
        if jump is not None:
            result.append(_diagnostic(output, jump))
    return result


def largest_jump(flat: Plan, name: str, verdict: Verdict, search: _Evaluation | None = None) -> Jump | None:
    """Return the largest jump of an output that the search finds, None without one."""
    position = next(k for k, o in enumerate(flat.outputs) if o.name == name)
    output = flat.outputs[position]
    if flat.initial_state:
        return None  # it also depends on earlier values
    candidates = list(islice(_candidates(flat, output, isinstance(verdict, Hole)), MOST_CANDIDATES))
    if not candidates:
        return None
    search = _Evaluation(flat, Work()) if search is None else search
    value, result = search.of(position), []
    for position_of, x in candidates:
        if search.work.left <= 0.0:
            break
        jump = _at(flat, output, value, search.others(position_of), position_of, x)
        result.extend([jump] if jump is not None else [])
    if not result:
        return None
    best = max(result, key=lambda j: j.size)
    return Jump(best.input, best.at, best.before, best.after, best.others, len(result), best.silent)


def _candidates(flat: Plan, output: OutputPlan, has_hole: bool) -> Iterator[tuple[int, float]]:
    """Yield inputs and values at which an output may jump."""
    for i, variable in enumerate(flat.inputs):
        sets = [d.set for d in flat.degrees if d.variable == i]
        jumps = {a[0] for s in sets for a, b in pairwise(s.vertices) if a[0] == b[0] and a[1] != b[1]}
        jumps |= {x for s in sets if s.expression is not None for x in s.pieces}
        if has_hole and isinstance(output.otherwise, float) and not _leaves_a_gap(variable, sets):
            jumps |= set(breakpoints(variable, sets))
        yield from ((i, x) for x in sorted(jumps) if _is_within(variable, x))


def _is_within(variable: InputPlan, x: float) -> bool:
    """Return whether an output may jump at a value within the domain of the system.

    An input that is clamped has its ends, beyond which it is constant; one that extrapolates leaves its terms there.
    """
    if variable.extrapolate:
        return variable.lower < x < variable.upper
    return variable.lower <= x <= variable.upper


def _leaves_a_gap(variable: InputPlan, sets: Sequence[SetPlan]) -> bool:
    """Return whether no term of an input has a degree somewhere, which has another message."""
    return any(all(degree_in(s, cell.floats)[1] <= 0.0 for s in sets) for cell in cells(variable, sets))


class _Evaluation:
    """The outputs at points; NaN where one has no value, and everywhere when there is no work left."""

    def __init__(self, flat: Plan, work: Work) -> None:
        self.flat, self.work, self.units = flat, work, evaluation(flat)
        self._axes: dict[int, list[list[float]]] = {}

    def others(self, position: int) -> list[list[float]]:
        """Return the values that the other inputs have while one is moved."""
        if position not in self._axes:
            self._axes[position] = _others(self.flat, position)
        return self._axes[position]

    @cached_property
    def kernel(self) -> Callable[..., Any] | None:
        if not self.work.takes(compilation(self.flat)):
            return None
        program = inference.evaluation(self.flat)
        names = [i.name for i in self.flat.inputs]
        return scalar.compile_source(scalar.evaluation_source(program), program, names)

    def of(self, position: int) -> Callable[[Sequence[float]], float]:
        """Return one output as a function of a point."""

        def value(point: Sequence[float]) -> float:
            if self.kernel is None or not self.work.takes(1 + self.units):
                return math.nan
            try:
                result = self.kernel(*point)
            except NoRuleFiresError:
                return math.nan
            return float(result[position] if isinstance(result, tuple) else result)

        return value


def _at(
    flat: Plan,
    output: OutputPlan,
    value: Callable[[Sequence[float]], float],
    axes: Sequence[Sequence[float]],
    position: int,
    x: float,
) -> Jump | None:
    """Return the largest jump of an output at a value of one input."""
    variable, best = flat.inputs[position], None
    for others in islice(product(*axes), MOST_POINTS):
        sides = [math.nextafter(x, -math.inf), x, math.nextafter(x, math.inf)]
        row = [value([*others[:position], side, *others[position:]]) for side in sides]
        for a, b in combinations(row, 2):
            if abs(b - a) > max(LEAST * (output.upper - output.lower), 0.0 if best is None else best.size):
                at = dict(zip([v.name for v in flat.inputs if v is not variable], others, strict=True))
                best = Jump(variable.name, x, a, b, at, 1, output.otherwise in (a, b))
    return best


def _others(flat: Plan, position: int) -> list[list[float]]:
    """Return values of each other input: corners of its terms and middles between them, of many only some."""
    axes: list[list[float]] = []
    count = max(1, len(flat.inputs) - 1)
    most = max(2, round(MOST_POINTS ** (1.0 / count)))
    for i, variable in enumerate(flat.inputs):
        if i != position:
            corners = breakpoints(variable, [d.set for d in flat.degrees if d.variable == i])
            values = sorted({*corners, *(0.5 * a + 0.5 * b for a, b in pairwise(corners))})
            step = (len(values) - 1) / (most - 1)
            axes.append(values if len(values) <= most else [values[round(k * step)] for k in range(most)])
    return axes


def _diagnostic(output: Output, jump: Jump) -> Diagnostic:
    message = f"output '{output.name}' jumps by {jump.size:.4g} at {jump.input} = {jump.at:.6g}"
    where = f" for {', '.join(f'{n} = {v:.6g}' for n, v in jump.others.items())}" if jump.others else ""
    facts = [f"from {jump.before:.6g} to {jump.after:.6g}{where}"]
    if jump.silent and isinstance(output.otherwise, Expr):
        facts.append(f"no rule fires beyond, and 'else {to_text(output.otherwise)}' holds")
    elif jump.silent and isinstance(output.otherwise, str):
        facts.append(f"no rule fires beyond, and 'else {output.otherwise}' holds")
    else:
        facts.append(f"a term of '{jump.input}' jumps there")
    if jump.count > 1:
        facts.append(f"it jumps at {counted(jump.count, 'value')} in all; this is the largest jump found")
    help_text = "let terms overlap there; where the jump is meant, write 'allow FZ405'"
    return Diagnostic("FZ405", message, output.span, "hint", tuple(facts), help_text)
