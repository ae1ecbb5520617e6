"""Settings that explain a difference: those of the second system are put into the first, one by one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.comparison.differences import Difference, Place, Progress, at_point, at_points, common_points, pairing
from fuzzyctl.comparison.settings import defuzzifier_settings, described, otherwise_text, settings
from fuzzyctl.diagnostics.diagnostic import FuzzyctlError
from fuzzyctl.expr import ExprError
from fuzzyctl.formats.fz import activation_text, block_text
from fuzzyctl.model.method import KNOBS, Activation, Defuzzifier, Method
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable

Put = Callable[[FuzzySystem], FuzzySystem]

#: Words of rule files whose fields are called otherwise.
_FIELDS: Final = {"and": "conjunction", "or": "disjunction"}

#: Settings that a rule block may have, by their words in rule files.
_OF_BLOCKS: Final = {**_FIELDS, "implication": "implication", "activation": "activation"}

#: Settings that outputs do not have.
_OF_THE_SYSTEM: Final = ("and", "or", "activation", *KNOBS)


@dataclass(frozen=True)
class Part:
    """A setting, or a group of things, that two systems have in different ways.

    Args:
        name: Its name in messages.
        before: How the first system has it.
        after: How the second one does.
        put: Returns a system that has it as the second one.
        last: Whether it is for where no other part goes alone.
    """

    name: str
    before: str
    after: str
    put: Put
    last: bool = False


def parts(a: FuzzySystem, b: FuzzySystem, inputs: list[int], outputs: list[int]) -> Iterator[Part]:
    """Yield the parts that differ: settings one by one; variables, rules and params as wholes.

    Args:
        a: The first system.
        b: The second one.
        inputs: For each input of the first its position in the second.
        outputs: The same for outputs.
    """
    before, after = settings(a.method), settings(b.method)
    for name in before:
        if before[name] != after[name] and name in _OF_THE_SYSTEM:
            yield Part(name, before[name], after[name], partial(_set_setting, name, b.method))
    for i, j in enumerate(outputs):
        yield from _output_parts(a, b, i, j)
    for i, j in enumerate(inputs):
        if _fuzzy(a.inputs[i]) != _fuzzy(b.inputs[j]):
            put = partial(_set_variable, "inputs", i, b.inputs[j])
            yield Part(f"range and terms of {a.inputs[i].name}", "", "", put)
    for name in ("params", "hedges"):
        if getattr(a, name) != getattr(b, name):
            yield Part(name, "", "", partial(_set_field, name, getattr(b, name)))
    yield from _block_parts(a, b)
    if _ruled(a) != _ruled(b) and not _differ_in_methods_only(a, b):
        yield Part("rules", "", "", partial(_set_field, "blocks", b.blocks))
    if _ruled(a) != _ruled(b) and (inputs == sorted(inputs) or not _is_linear(b)):
        # Where terms were renamed, variables and rules go together only.
        yield Part("variables and rules", "", "", partial(_set_structure, b, inputs, outputs), last=True)


def _ruled(system: FuzzySystem) -> tuple[Any, ...]:
    """Return rules with the rule blocks that they belong to, and what these say but for their names."""
    blocks = tuple(block_text(replace(b, name="")) for b in system.rule_blocks)
    return system.rules, blocks, tuple(m.block for m in system.rule_methods)


def _differ_in_methods_only(a: FuzzySystem, b: FuzzySystem) -> bool:
    """Return whether the same rules differ in methods only, which `_block_parts` and settings of the system name."""
    if a.rules != b.rules:
        return False
    if [m.block for m in a.rule_methods] == [m.block for m in b.rule_methods]:
        return True
    if any(m.activation.compares for m in b.rule_methods):
        return False  # there it counts which rules make a block
    usual = (b.method.conjunction, b.method.disjunction, None, b.method.activation)
    by_block: dict[int, set[tuple[Any, ...]]] = {-1: {usual}}
    for rule_method, m in zip(a.rule_methods, b.rule_methods, strict=True):
        by_block.setdefault(rule_method.block, set()).add((m.conjunction, m.disjunction, m.implication, m.activation))
    return all(len(methods) == 1 for methods in by_block.values())


def _block_parts(a: FuzzySystem, b: FuzzySystem) -> Iterator[Part]:
    """Yield the methods that a rule block of the first system has and its rules have not in the second.

    Where the rules themselves differ it is unknown which of them are the block's; those of the second system have a
    method then if all have the same.
    """
    for k, block in enumerate(a.rule_blocks):
        rules = [r for r, m in enumerate(a.rule_methods) if m.block == k]
        theirs = [b.rule_methods[r] for r in rules] if a.rules == b.rules else b.rule_methods
        for word, field in _OF_BLOCKS.items():
            before, after = getattr(a.rule_methods[rules[0]], field), {getattr(m, field) for m in theirs}
            if len(after) == 1 and after != {before}:
                (other,) = after
                texts = _method_text(before), _method_text(other)
                yield Part(f"{word} of rules {block.name}", *texts, partial(_set_block, k, field, other))


def _method_text(value: str | Activation | None) -> str:
    if value is None:
        return "that of the output"
    return activation_text(value) if isinstance(value, Activation) else value


def _set_block(position: int, field: str, value: Any, system: FuzzySystem) -> FuzzySystem:
    block = system.rule_blocks[position]
    changed = replace(block, **{field: value})
    return replace(system, blocks=tuple(changed if b is block else b for b in system.blocks))


def _output_parts(a: FuzzySystem, b: FuzzySystem, i: int, j: int) -> Iterator[Part]:
    """Yield the settings that differ for an output: its own or those of the system."""
    output, other = a.outputs[i], b.outputs[j]
    of = f" of {output.name}" if len(a.outputs) > 1 else ""
    if _fuzzy(output) != _fuzzy(other):
        yield Part(f"range and terms of {output.name}", "", "", partial(_set_variable, "outputs", i, other))
    for field in ("implication", "aggregation"):
        first = getattr(output, field) or getattr(a.method, field)
        second = getattr(other, field) or getattr(b.method, field)
        if first != second:
            yield Part(f"{field}{of}", first, second, partial(_set_at, "outputs", i, {field: second}))
    if output.clamped != other.clamped:
        yield Part(
            f"clamp{of}",
            str(output.clamped),
            str(other.clamped),
            partial(_set_at, "outputs", i, {"clamped": other.clamped}),
        )
    if output.otherwise != other.otherwise:
        texts = otherwise_text(output.otherwise) or "nothing", otherwise_text(other.otherwise) or "nothing"
        yield Part(f"else{of}", *texts, partial(_set_at, "outputs", i, {"otherwise": other.otherwise}))
    yield from _defuzzifier_parts(
        output.defuzzifier or a.method.defuzzifier, other.defuzzifier or b.method.defuzzifier, i, of
    )


def _defuzzifier_parts(first: Defuzzifier, second: Defuzzifier, position: int, of: str) -> Iterator[Part]:
    if first.kind != second.kind or (first.resolution is None) != (second.resolution is None):
        put = partial(_set_at, "outputs", position, {"defuzzifier": second})
        yield Part(f"defuzzifier{of}", described(first), described(second), put)
        return
    before, after = defuzzifier_settings(first), defuzzifier_settings(second)
    for name in before:
        if before[name] != after[name]:
            put = partial(_set_in_defuzzifier, position, name, getattr(second, name))
            yield Part(f"{name}{of}", before[name], after[name], put)


def _fuzzy(v: LinguisticVariable) -> tuple[Any, ...]:
    """Return the parts of a variable that change numbers, without names."""
    return (v.lower, v.upper, tuple((t.name, t.membership) for t in v.terms), getattr(v, "extrapolate", None))


def _set_setting(name: str, method: Method, system: FuzzySystem) -> FuzzySystem:
    current, field = system.method, _FIELDS.get(name, name)
    if hasattr(current, field):
        changed = replace(current, **{field: getattr(method, field)})
    else:
        changed = replace(current, semantics=replace(current.semantics, **{name: getattr(method.semantics, name)}))
    return replace(system, method=changed)


def _set_field(field: str, value: Any, system: FuzzySystem) -> FuzzySystem:
    return replace(system, **{field: value})


def _set_variable(field: str, position: int, other: LinguisticVariable, system: FuzzySystem) -> FuzzySystem:
    variable = getattr(system, field)[position]
    names = (name for name in ("lower", "upper", "terms", "extrapolate") if hasattr(variable, name))
    return _set_at(field, position, {name: getattr(other, name) for name in names}, system)


def _set_at(field: str, position: int, update: dict[str, Any], system: FuzzySystem) -> FuzzySystem:
    """Change fields of one input or output."""
    variables = list(getattr(system, field))
    variables[position] = replace(variables[position], **update)
    return _set_field(field, tuple(variables), system)


def _is_linear(system: FuzzySystem) -> bool:
    """Return whether consequents have coefficients in the order of the inputs."""
    terms = [t.membership for o in system.outputs for t in o.terms]
    terms += [c.term for rule in system.rules for c in rule.consequents if not isinstance(c.term, str)]
    return any(m.kind == "linear" for m in terms)


def _set_structure(b: FuzzySystem, inputs: list[int], order: list[int], system: FuzzySystem) -> FuzzySystem:
    """Keep the settings of a system, and take all else from another, in the order of the first."""
    fields = ("implication", "aggregation", "defuzzifier", "otherwise", "clamped")
    outputs = tuple(
        replace(b.outputs[j], **{name: getattr(output, name) for name in fields})
        for output, j in zip(system.outputs, order, strict=True)
    )
    return replace(b, method=system.method, inputs=tuple(b.inputs[j] for j in inputs), outputs=outputs)


def _set_in_defuzzifier(position: int, field: str, value: Any, system: FuzzySystem) -> FuzzySystem:
    defuzzifier = system.outputs[position].defuzzifier or system.method.defuzzifier
    return _set_at("outputs", position, {"defuzzifier": replace(defuzzifier, **{field: value})}, system)


if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

#: What is left of a difference counts as nothing below this part of it: rounding of two ways to compute.
NOTHING: Final = 1e-9

#: Up to this part of the range of an output, or of its values, a difference is rounding, which has no cause.
ROUNDING: Final = 1e-14

#: Points that a mean difference is explained at.
SAMPLE: Final = 256

#: Part of a mean difference that may be left once the causes of the largest one are gone; more has other causes.
ELSEWHERE: Final = 0.1

#: Distance of a system from its target; infinite if unknown.
Distance = Callable[[FuzzySystem], float]


@dataclass(frozen=True)
class Cause:
    """A setting that both systems have in different ways.

    Args:
        name: The setting, or what else it is, such as `terms of food`.
        before: How the first system has it.
        after: How the second one does.
        explains: Part of the difference that is gone once the first system has it as the second does, after the causes
            before it in the list; may be negative where two causes work against each other.
    """

    name: str
    before: str
    after: str
    explains: float


@dataclass(frozen=True)
class Explanation:
    """The causes of a difference, the largest first.

    Args:
        largest: Causes of the largest difference; empty if there is no difference.
        mean: Those of the mean difference, where it is no more than partly explained by the causes of the largest.
        gap: Settings that each resolve a point where only one of both systems has a value.
        rounding: Whether the largest difference is no more than rounding, which has no cause.
    """

    largest: tuple[Cause, ...] = ()
    mean: tuple[Cause, ...] = ()
    gap: tuple[Cause, ...] = ()
    rounding: bool = False


def explanation(
    a: FuzzySystem, b: FuzzySystem, difference: Difference, *, progress: Progress | None = None
) -> Explanation:
    """Explain a difference: settings of the second system are put into the first, each time the one that helps most.

    Args:
        a: The first system.
        b: The second one.
        difference: What `differences` found for one output.
        progress: Called now and then.
    """
    _, outputs = pairing(a, b)
    output = [o.name for o in a.outputs].index(difference.output)
    gap = () if difference.gap is None else _resolving(a, b, difference.gap, output)
    if difference.largest <= ROUNDING * _scale(a, difference, output):
        return Explanation(gap=gap, rounding=difference.largest > 0.0)
    place = Place(difference.point, difference.first, difference.second)
    if not math.isfinite(difference.largest):
        # A gap that is the only difference is explained once.
        return Explanation(gap=gap) if difference.gap else Explanation(_resolving(a, b, place, output)[:1])
    point, target = [difference.point[v.name] for v in a.inputs], difference.second

    def reported(distance: Distance) -> Distance:
        """Tell of each try."""

        def far(system: FuzzySystem) -> float:
            if progress is not None:
                progress(f"looking for what explains {difference.output}")
            return distance(system)

        return far

    largest, changed = _greedy(a, b, reported(lambda system: abs(at_point(system, point, output) - target)))
    mean = reported(_mean_distance(a, b, output, outputs[output]))
    start = mean(a)
    if not 0.0 < start < math.inf or mean(changed) <= ELSEWHERE * start:
        return Explanation(largest, gap=gap)
    return Explanation(largest, _greedy(a, b, mean)[0], gap)


def _scale(system: FuzzySystem, difference: Difference, output: int) -> float:
    """Return how large an output is: the width of its range, or of its values, the larger one."""
    declared = system.outputs[output]
    values = (system.number(declared.lower), system.number(declared.upper), difference.first, difference.second)
    return max((abs(v) for v in values if math.isfinite(v)), default=0.0)


def causes(a: FuzzySystem, b: FuzzySystem, difference: Difference) -> tuple[Cause, ...]:
    """Return the causes of the largest difference; where only one system has a value, of that."""
    explained = explanation(a, b, difference)
    return explained.largest or explained.gap


def _greedy(a: FuzzySystem, b: FuzzySystem, distance: Distance) -> tuple[tuple[Cause, ...], FuzzySystem]:
    """Put parts of the second system into the first, the best first, until the distance is gone or no part helps.

    Returns:
        The parts with their shares, and the first system with them.
    """
    chain: list[Cause] = []
    left, current, start = list(parts(a, b, *pairing(a, b))), a, distance(a)
    far = start
    while left and far > NOTHING * start:
        tried = [(part, *_with(current, part, distance)) for part in left]
        # A part that changes nothing, or gives no value, is not a cause.
        working = [
            (part.last, d, k) for k, (part, s, d) in enumerate(tried) if s is not None and d != far and math.isfinite(d)
        ]
        if not working:
            break  # the rest takes several parts at once
        *_, best = min(working)
        part, system, new = tried[best]
        assert system is not None
        chain.append(Cause(part.name, part.before, part.after, (far - new) / start))
        left.remove(part)
        current, far = system, new
    return tuple(chain), current


def _with(system: FuzzySystem, part: Part, distance: Distance) -> tuple[FuzzySystem | None, float]:
    """Return the system with one part of the other and its distance; None where the part does not go without others."""
    try:
        changed = part.put(system)
        return changed, distance(changed)
    except (FuzzyctlError, ExprError):
        return None, math.inf


def _mean_distance(a: FuzzySystem, b: FuzzySystem, output: int, other: int) -> Distance:
    """Return the mean distance of a system from the second one, over points where both have a value at first."""
    import numpy as np

    inputs, _ = pairing(a, b)
    points = common_points(a, b, inputs, SAMPLE, 0)
    first = at_points(a, points, output)
    target = at_points(b, points[:, np.argsort(inputs)], other)
    both = np.isfinite(first) & np.isfinite(target)
    points, target = points[both], target[both]

    def mean(system: FuzzySystem) -> float:
        return float(np.abs(at_points(system, points, output) - target).mean()) if len(points) else math.inf

    return mean


def _resolving(a: FuzzySystem, b: FuzzySystem, place: Place, output: int) -> tuple[Cause, ...]:
    """Return the parts that each make both systems finite at a point, or neither."""
    point = [place.point[v.name] for v in a.inputs]

    def differs(system: FuzzySystem) -> float:
        value = at_point(system, point, output)
        same = math.isfinite(value) == math.isfinite(place.second) and math.isnan(value) == math.isnan(place.second)
        return 0.0 if same else 1.0

    tried = [(part, _with(a, part, differs)[1]) for part in parts(a, b, *pairing(a, b))]
    working = [part for part, left in tried if left == 0.0]
    single = [part for part in working if not part.last] or working
    return tuple(Cause(p.name, p.before, p.after, 1.0) for p in single)
