"""Checks of the equations of controllers, plants and loops."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import listed
from fuzzyctl.expr import (
    CONSTANTS,
    DIVISION,
    REPAIRS,
    Call,
    Expr,
    ExprError,
    Keyword,
    Name,
    Number,
    evaluate,
    names_in,
    span_of,
    walk,
)
from fuzzyctl.model.block import FINITE, Bounds, Param, ParamCycleError, ParamValues
from fuzzyctl.model.checks.parameters import constants, quotients
from fuzzyctl.model.checks.terms import inside, outside_ranges
from fuzzyctl.model.controller import Definition, EquationBlock, Instance, Result, Signal
from fuzzyctl.model.forms import bound, pairs_of
from fuzzyctl.model.loop import MEASURES, SIGNALS, Loop
from fuzzyctl.model.plant import PLANT_FUNCTIONS, Plant
from fuzzyctl.model.shared_params import with_values
from fuzzyctl.model.system import FuzzySystem

#: Most samples of a run.
MOST_SAMPLES: Final = 10_000_000


def numbers(block: EquationBlock, params: ParamValues) -> Iterator[Diagnostic]:
    """Check the numbers of a block, as far as its params have values."""
    mistakes = list(_written_numbers(block, params))
    yield from mistakes
    reported = {d.span for d in mistakes}
    yield from (d for d in _constants(block, params) if d.span not in reported)


def numbers_of_all(block: EquationBlock) -> Iterator[Diagnostic]:
    """Check the numbers of a block, and those of the blocks inside it with the params that they have there.

    Numbers that follow from reported ones are not reported.
    """
    params = block.param_values
    mistakes = list(numbers(block, params))
    if not mistakes:
        mistakes = [d for _, inner, values in inside(block, params) for d in numbers_of_all(with_values(inner, values))]
    # A plant of one line has equations without a place.
    placed = [d if d.span else replace(d, span=block.span) for d in mistakes]
    yield from (d for k, d in enumerate(placed) if d not in placed[:k])


def _written_numbers(block: EquationBlock, params: ParamValues) -> Iterator[Diagnostic]:
    """Check params, ranges, starts and times."""
    for error in params.errors:
        if isinstance(error, ParamCycleError):
            yield Diagnostic("FZ308", error.message, error.span, help="give one of them a number")
        else:
            yield Diagnostic("FZ307", error.message, error.span, help=error.help)
    signals: tuple[Signal, ...] = (*block.inputs, *block.states, *block.outputs)
    ranges = [(s.name, s.bounds) for s in signals] + [(p.name, p.bounds) for p in block.params]
    for name, bounds in ranges:
        if bounds is not None:
            yield from _range(name, bounds, params)
    outside_range: set[str] = set()
    for param in block.params:
        mistakes = list(_within(f"param '{param.name}'", param.expression, param.bounds, params))
        outside_range |= {param.name} if mistakes else set()
        yield from mistakes
    for state in block.states:
        what = f"the start of state '{state.name}'"
        outside = list(_within(what, state.start, state.bounds, params))
        yield from outside or (_finite_start(what, state.start, params) if isinstance(block, Plant) else ())
    yield from _positive("the period", block.period, params, "write a time, such as: every 5 ms")
    for guarantee in block.guarantees:
        yield from _tolerance(guarantee.within, params)
    if isinstance(block, Plant):
        yield from _dead_times(block, params)
    for instance in block.instances:
        yield from _instance(instance, block.callee(instance), params, outside_range)
    if isinstance(block, Loop):
        yield from _run(block, params)
        yield from _functions(block, params)


def computed(expr: Expr, params: ParamValues) -> float | Diagnostic | None:
    """Return the value of an expression over params or its mistake, None where a param that it needs has none."""
    if params.lacks(expr):
        return None
    try:
        return evaluate(expr, params.values)
    except ExprError as error:
        return Diagnostic("FZ307", error.message, error.span, help=error.help)


def _constants(block: EquationBlock, params: ParamValues) -> Iterator[Diagnostic]:
    """Check the parts of expressions that have a value before a run, and quotients by 0."""
    lets = [Param(name=d.name, expression=d.value) for d in block.definitions]
    values = ParamValues([*block.params, *lets], partial=True)
    names = {*CONSTANTS, *values.values}
    systems = {s.name: s for s in block.systems}
    for _, expr, parameters in expressions(block):
        is_known = (names - parameters).__contains__
        for constant in constants(expr, is_known):
            value = computed(constant, values)
            yield from [value] if isinstance(value, Diagnostic) else []
        for quotient, divisor in quotients(expr, is_known):
            if computed(divisor, values) == 0.0:
                yield Diagnostic("FZ307", DIVISION, span_of(quotient), help=REPAIRS[DIVISION])
        for call in walk(expr) if systems else ():
            if isinstance(call, Call) and call.function in systems:
                yield from _called(call, systems[call.function], params)


def expressions(block: EquationBlock) -> Iterator[tuple[str, Expr, set[str]]]:
    """Yield the expressions of a block, each with the name that it defines and the parameters of its function.

    The name is that of a let or of a state; other expressions, such as those of outputs and claims, have none.
    """
    yield from (("", f.expression, set(f.parameters)) for f in block.functions)
    nameless = [a for i in block.instances for a in i.arguments] + [r.value for r in block.outputs]
    claims = block.guarantees
    if isinstance(block, Loop):
        nameless += [m.value for m in block.measures]
        claims = (*block.requirements, *block.guarantees)
    nameless += [e for c in claims for e in (c.claim, c.when) if e is not None]
    yield from ((d.name, d.value, set()) for d in (*block.definitions, *block.changes))
    yield from (("", expr, set()) for expr in nameless)


def _positive(what: str, expr: Expr | None, params: ParamValues, help_text: str) -> Iterator[Diagnostic]:
    value = None if expr is None else computed(expr, params)
    if isinstance(value, Diagnostic):
        yield value
    elif value is not None and expr is not None and not 0 < value < math.inf:
        why = "not positive" if value <= 0 else "not finite"
        yield Diagnostic("FZ302", f"{what} is {value:g} s, {why}", span_of(expr), help=help_text)


def _tolerance(expr: Expr | None, params: ParamValues) -> Iterator[Diagnostic]:
    value = None if expr is None else computed(expr, params)
    if isinstance(value, Diagnostic):
        yield value
    elif value is not None and expr is not None and not 0.0 <= value < math.inf:
        what = "infinite" if value > 0 else f"{value:g}, below 0"
        yield Diagnostic("FZ302", f"the tolerance is {what}", span_of(expr), help="write a small number >= 0")


def ends_of(bounds: Bounds, params: ParamValues) -> tuple[float, float] | None:
    """Return the ends of a range over params, None if one of them has no value."""
    low, high = (computed(e, params) for e in (bounds.lower, bounds.upper))
    return (low, high) if isinstance(low, float) and isinstance(high, float) else None


def _range(name: str, bounds: Bounds, params: ParamValues) -> Iterator[Diagnostic]:
    ends = ends_of(bounds, params)
    yield from (e for e in (computed(x, params) for x in (bounds.lower, bounds.upper)) if isinstance(e, Diagnostic))
    if ends is not None and not ends[0] < ends[1]:
        message = f"the range of '{name}' is empty: {ends[0]:g} is not below {ends[1]:g}"
        yield Diagnostic("FZ304", message, bounds.span, help="put the smaller end first")


def _within(what: str, expr: Expr, bounds: Bounds | None, params: ParamValues) -> Iterator[Diagnostic]:
    """Report a number outside of its range."""
    value = computed(expr, params)
    if isinstance(value, Diagnostic):
        if not what.startswith("param"):  # whose values are reported before
            yield value
    elif value is not None and bounds is not None:
        yield from outside(what, value, span_of(expr), bounds, params)


def outside(what: str, value: float, span: Span | None, bounds: Bounds, params: ParamValues) -> Iterator[Diagnostic]:
    """Report a value outside of a range whose ends are over params."""
    ends = ends_of(bounds, params)
    if ends is None or not ends[0] < ends[1]:
        return
    if not bounds.holds(value, *ends):
        yield _outside(what, value, span, bounds, bounds.text(*ends))


def _outside(what: str, value: float, span: Span | None, bounds: Bounds, shown: str) -> Diagnostic:
    written = shown if bounds.span is None else bounds.span.text
    facts = () if written == shown else (f"the range is {shown}",)
    elsewhere = bounds.span is not None and span is not None and bounds.span.line != span.line
    notes = (Note(bounds.span, "the range is declared here"),) if elsewhere and bounds.span is not None else ()
    help_text = "give a value in the range, or widen the range"
    message = f"{what} is {value:g}, outside of {written}"
    return Diagnostic("FZ302", message, span, facts=facts, help=help_text, notes=notes)


def _instance(
    instance: Instance, callee: EquationBlock, params: ParamValues, reported: set[str]
) -> Iterator[Diagnostic]:
    """Check the params that a block gets, and the params that follow from them, by their ranges.

    Calls that use reported params are not reported.
    """
    names = {p.name for p in callee.params}
    arguments = {a.name: a.value for a in instance.arguments if isinstance(a, Keyword) and a.name in names}
    arguments = {name: e for name, e in arguments.items() if not any(n.name in reported for n in names_in(e))}
    results = {name: computed(e, params) for name, e in arguments.items()}
    yield from (value for value in results.values() if isinstance(value, Diagnostic))
    numbers = {name: value for name, value in results.items() if isinstance(value, float)}
    written = callee.name.rpartition(".")[2]  # before it, if it became a separate one: see instance_params
    for name, value in numbers.items():
        if math.isinf(value):
            message = f"param '{name}' of '{written}' is infinite"
            yield Diagnostic("FZ307", message, span_of(arguments[name]) or instance.span, help=FINITE)
    for o in outside_ranges(callee, numbers) if numbers else ():
        what = f"{o.what} of '{written}'"
        place = next((span_of(e) for name, e in arguments.items() if o.what == f"param '{name}'"), instance.span)
        yield _outside(what, o.value, place, o.bounds, o.text)


def _called(call: Call, system: FuzzySystem, params: ParamValues) -> Iterator[Diagnostic]:
    """Check the params that a call of a system sets."""
    arguments = {a.name: a.value for a in call.arguments if isinstance(a, Keyword)}
    numbers = {name: value for name, e in arguments.items() if isinstance(value := computed(e, params), float)}
    inner = [replace(p, expression=Number(numbers[p.name])) if p.name in numbers else p for p in system.params]
    values = ParamValues(inner, partial=True)
    for param in inner:
        if param.name in numbers:
            value, place = numbers[param.name], span_of(arguments[param.name])
            what = f"param '{param.name}' of '{system.name}'"
            if math.isinf(value):
                yield Diagnostic("FZ307", f"{what} is infinite", place, help=FINITE)
            elif param.bounds is not None:
                yield from outside(what, value, place, param.bounds, values)


def _dead_times(plant: Plant, params: ParamValues) -> Iterator[Diagnostic]:
    items: list[Definition | Result] = [*plant.definitions, *plant.results, *plant.derivatives]
    for item in items:
        for call in walk(item.value):
            if not (isinstance(call, Call) and call.function in PLANT_FUNCTIONS):
                continue
            arguments = bound(PLANT_FUNCTIONS[call.function], call)
            value = computed(arguments["time"], params)
            if isinstance(value, Diagnostic):
                yield value
            elif value is not None and not 0 <= value < math.inf:
                message = f"the dead time is {value:g} s: expected a finite time of 0 or more"
                yield Diagnostic("FZ302", message, span_of(arguments["time"]), help="write a time, such as: 0.5 s")
            yield from _finite_start("the start of the dead time", arguments["start"], params)


def _finite_start(what: str, start: Expr, params: ParamValues) -> Iterator[Diagnostic]:
    """Report the start of a continuous state that has no finite value."""
    value = computed(start, params)
    if isinstance(value, Diagnostic):
        yield value
    elif value is not None and math.isinf(value):
        yield Diagnostic("FZ302", f"{what} is infinite", span_of(start), help="give it a finite start")


def _run(loop: Loop, params: ParamValues) -> Iterator[Diagnostic]:
    """Check duration and step of a run."""
    mistakes = [
        *_positive("the duration", loop.duration, params, "write a time, such as: run 50 s"),
        *_positive("the step", loop.step, params, "write a time, such as: run 50 s step 10 ms"),
    ]
    yield from mistakes
    duration = computed(loop.duration, params)
    step = None if loop.step is None else computed(loop.step, params)
    if mistakes or not isinstance(duration, float) or not isinstance(step, float) or loop.step is None:
        return
    if step > duration:
        message = f"the step is {step:g} s, longer than the run of {duration:g} s"
        yield Diagnostic("FZ302", message, span_of(loop.step), help="shorten the step, or lengthen the run")
    elif duration / step > MOST_SAMPLES:
        message = f"the run has {duration / step:,.0f} samples, more than {MOST_SAMPLES:,}"
        yield Diagnostic("FZ302", message, span_of(loop.step), help="lengthen the step, or shorten the run")


#: Settings that must be positive, that must not be negative, and that must ascend, by function.
_POSITIVE: Final = {"sine": ("frequency",), "settling": ("band",)}
_NOT_NEGATIVE: Final = {"noise": ("sigma", "seed")}
_ASCENDING: Final = {"pulse": ("begin", "end"), "ramp": ("begin", "end"), "rise_time": ("low", "high")}


def _functions(loop: Loop, params: ParamValues) -> Iterator[Diagnostic]:
    """Check the settings of signals and measures."""
    forms = SIGNALS | MEASURES
    values = [d.value for d in (*loop.definitions, *loop.measures)] + [a for i in loop.instances for a in i.arguments]
    for call in (e for value in values for e in walk(value)):
        if isinstance(call, Call) and call.function in forms:
            yield from _times(call, params) if forms[call.function].pairs else _settings(call, params)


def _times(call: Call, params: ParamValues) -> Iterator[Diagnostic]:
    before: float | None = None
    for pair in pairs_of(call):
        key, value = computed(pair.key, params), computed(pair.value, params)
        yield from (v for v in (key, value) if isinstance(v, Diagnostic))
        if isinstance(key, float) and before is not None and not key > before:
            message = f"the times of '{call.function}' do not ascend: {key:g} s follows {before:g} s"
            yield Diagnostic("FZ305", message, span_of(pair.key), help="put the times in order, each once")
            return
        before = key if isinstance(key, float) else None


def _settings(call: Call, params: ParamValues) -> Iterator[Diagnostic]:
    name = call.function
    form = (SIGNALS | MEASURES)[name]
    arguments = bound(form, call)
    results = {s: computed(arguments[s], params) for s in form.settings if s in arguments and s not in form.texts}
    yield from (v for v in results.values() if isinstance(v, Diagnostic))
    values = {s: v for s, v in results.items() if isinstance(v, float)}
    for setting, value in values.items():
        place = span_of(arguments[setting]) or call.span
        if setting in _POSITIVE.get(name, ()) and not value > 0:
            message = f"'{setting}' of '{name}' is {value:g}: expected a positive number"
            yield Diagnostic("FZ302", message, place, help=f"the form is: {form.form}")
        elif setting in _NOT_NEGATIVE.get(name, ()) and not 0 <= value < math.inf:
            message = f"'{setting}' of '{name}' is {value:g}: expected 0 or more"
            yield Diagnostic("FZ302", message, place, help=f"the form is: {form.form}")
        elif setting == "seed" and value != int(value):
            message = f"'seed' of '{name}' is {value:g}: expected a whole number"
            yield Diagnostic("FZ302", message, place, help=f"the form is: {form.form}")
    first, last = _ASCENDING.get(name, ("begin", "end"))
    if first in values and last in values and not values[first] < values[last]:
        message = f"'{last}' of '{name}' is {values[last]:g}, not above '{first}', {values[first]:g}"
        is_swapped = span_of(arguments[first]) is not None and values[first] > values[last]
        help_text = "put the smaller one first" if is_swapped else f"give '{last}' a value above {values[first]:g}"
        yield Diagnostic("FZ304", message, span_of(arguments[last]) or call.span, help=help_text)


def unread_names(block: EquationBlock) -> Iterator[Diagnostic]:
    """Find written params, inputs, lets and states without effect on outputs, claims and measures."""
    if isinstance(block, Plant) and block.external:  # the code reads them
        return
    reads: defaultdict[str, set[str]] = defaultdict(set)
    for reader, expr, parameters in (*expressions(block), *_settings_of_calls(block)):
        reads[reader].update({n.name.partition(".")[0] for n in names_in(expr)} - parameters)
    live: set[str] = set()
    ahead = [""]
    while ahead:
        names = reads[ahead.pop()] - live
        live |= names
        ahead += names
    kinds: list[tuple[str, Sequence[Param | Definition | Signal]]] = [("param", block.params)]
    kinds += [("let", block.definitions)]
    kinds += [("disturbance", block.disturbances)] if isinstance(block, Loop) else []
    kinds += [("input", block.inputs), ("state", block.states)]
    # States of transfer functions and matrices are not written.
    unread = {d.name: (kind, d) for kind, items in kinds for d in items if d.name not in live and d.span is not None}
    readers: defaultdict[str, list[str]] = defaultdict(list)
    for reader in unread:
        for name in reads[reader] - {reader}:
            readers[name].append(f"'{reader}'")
    for name, (kind, item) in unread.items():
        facts = (f"read only by {listed(readers[name])}, without effect on an output",) if readers[name] else ()
        message = f"no equation reads input '{name}'" if kind == "input" else f"{kind} '{name}' is not used"
        code = "FZ211" if kind == "input" else "FZ216"
        yield Diagnostic(code, message, item.span, "warning", facts, "remove it, or use it")


def _settings_of_calls(block: EquationBlock) -> Iterator[tuple[str, Expr, set[str]]]:
    """Yield the remaining expressions: values of params, starts, ranges, periods and tolerances."""
    ranges: list[tuple[str, Bounds | None]] = [(p.name, p.bounds) for p in block.params]
    settings: list[tuple[str, Expr | None]] = [(p.name, p.expression) for p in block.params]
    if isinstance(block, Loop):
        settings += [("", block.duration), ("", block.step), *(("", r.within) for r in block.requirements)]
        settings += [(d.name, d.nominal) for d in block.disturbances]
        settings += [("", e) for g in block.always for e in (g.begin, g.end)]
        ranges += [("", bounds) for bounds in block.family.values()]
    ranges += [(s.name, s.bounds) for s in (*block.inputs, *block.states)] + [("", r.bounds) for r in block.outputs]
    settings += [(s.name, s.start) for s in block.states]
    # A range of a state is a claim, and a run stops where a plant leaves it.
    settings += [("", Name(s.name)) for s in block.states if s.bounds is not None]
    settings += [("", block.period), *(("", g.within) for g in block.guarantees)]
    settings += [(name, end) for name, bounds in ranges if bounds is not None for end in (bounds.lower, bounds.upper)]
    yield from ((name, expr, set()) for name, expr in settings if expr is not None)
