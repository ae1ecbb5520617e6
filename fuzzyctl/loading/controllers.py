"""Controllers of a file: resolved each after those that it names, and checked."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.expr import Expr, ExprError, evaluate, span_of
from fuzzyctl.kernels.plan.expansion import DEEPEST_INSTANCES, equations_of, with_values
from fuzzyctl.lang import syntax as sx
from fuzzyctl.loading.assembly import Part
from fuzzyctl.model.controller import Controller, Signal
from fuzzyctl.model.guarantee import Bounds
from fuzzyctl.model.params import ParamCycleError, ParamValues
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.resolve.controllers import resolve_controller

#: Most parts of expressions that the controllers of a file expand to together.
MOST_PARTS: Final = 100_000


class Controllers:
    """Resolves the controllers of a file, each after those that it names.

    Attributes:
        diagnostics: Their mistakes.
    """

    def __init__(
        self,
        parts: Sequence[Part],
        systems: Sequence[FuzzySystem],
        elsewhere: Callable[[str], FuzzySystem | Controller | None],
    ) -> None:
        self.diagnostics: list[Diagnostic] = []
        self._systems = {s.name: s for s in systems}
        self._elsewhere = elsewhere
        self._parts: dict[str, Part] = {}
        self._found: dict[str, Controller | None] = {}
        self._path: list[str] = []
        self._parts_left = MOST_PARTS
        heads = [p.head for p in parts if p.head is not None]
        for part in parts:
            if isinstance(part.head, sx.Head) and part.head.keyword.text == "controller":
                self._parts.setdefault(part.head.name.text, part)
        #: Names of blocks that may have mistakes of their own.
        self._declared = frozenset(h.name.text for h in heads)

    def all(self) -> tuple[Controller, ...]:
        """Return the controllers without mistakes in the order written."""
        found = [self._resolved(name) for name in self._parts]
        return tuple(c for c in found if c is not None)

    def find(self, name: str) -> FuzzySystem | Controller | None:
        """Return the system or controller of that name, of this file or of a used one."""
        if name in self._systems:
            return self._systems[name]
        return self._resolved(name) if name in self._parts else self._elsewhere(name)

    def _resolved(self, name: str) -> Controller | None:
        if name in self._path:
            circle = " → ".join([*self._path[self._path.index(name) :], name])
            head = self._parts[name].head
            assert head is not None
            message = f"controller '{name}' contains itself"
            self.diagnostics.append(Diagnostic("FZ217", message, head.name.span, facts=(circle,)))
            return None
        if len(self._path) == DEEPEST_INSTANCES:
            head = self._parts[name].head
            message = f"controllers lie more than {DEEPEST_INSTANCES} levels inside each other"
            self.diagnostics.append(Diagnostic("FZ106", message, head.name.span if head is not None else None))
            return None
        if name not in self._found:
            part = self._parts[name]
            assert isinstance(part.head, sx.Head)
            self._path.append(name)
            unread = part.tree.unread | (self._declared - self._systems.keys())
            statements = (*part.shared, *part.tree.statements)
            controller, incomplete, diagnostics = resolve_controller(
                statements, part.head, self.find, unread=unread, path=part.tree.source.name
            )
            self._path.pop()
            failed = incomplete or any(d.severity == "error" for d in diagnostics)
            diagnostics.extend(_numbers(controller, ParamValues(controller.params, partial=failed)))
            failed = failed or any(d.severity == "error" for d in diagnostics)
            if not failed:
                diagnostics.extend(self._expanded(controller))
            self.diagnostics.extend(diagnostics)
            failed = failed or any(d.severity == "error" for d in diagnostics)
            self._found[name] = None if failed else controller
        return self._found[name]

    def _expanded(self, controller: Controller) -> list[Diagnostic]:
        """Return what is wrong with the order of the equations, or their number."""
        if self._parts_left <= 0:
            message = f"the controllers of this file expand to more than {MOST_PARTS:,} parts of expressions"
            return [Diagnostic("FZ112", message, controller.span, help="spread them over several files")]
        try:
            self._parts_left -= equations_of(controller).parts
        except DiagnosticError as error:
            self._parts_left -= MOST_PARTS // 20
            return list(error.diagnostics)
        return []


def with_params(controller: Controller, values: Mapping[str, float]) -> Controller:
    """Return a controller with some params set to numbers.

    Raises:
        DiagnosticError: For a param, a start or a period that is out of its range then.
    """
    changed = with_values(controller, values)
    mistakes = list(_numbers(changed, ParamValues(changed.params, partial=True)))
    if mistakes:
        raise DiagnosticError(mistakes)
    equations_of(changed)
    return changed


def _numbers(controller: Controller, params: ParamValues) -> Iterator[Diagnostic]:
    for error in params.errors:
        yield Diagnostic("FZ308" if isinstance(error, ParamCycleError) else "FZ307", error.message, error.span)
    signals: tuple[Signal, ...] = (*controller.inputs, *controller.states, *controller.results)
    ranges = [(s.name, s.bounds) for s in signals] + [(p.name, p.bounds) for p in controller.params]
    for name, bounds in ranges:
        if bounds is not None:
            yield from _range(name, bounds, params)
    for param in controller.params:
        yield from _within(f"param '{param.name}'", param.expression, param.bounds, params)
    for state in controller.states:
        yield from _within(f"the start of state '{state.name}'", state.start, state.bounds, params)
    if controller.period is not None:
        value = _computed(controller.period, params)
        if isinstance(value, Diagnostic):
            yield value
        elif value is not None and not value > 0:
            message = f"the period is {value:g} s, not positive"
            yield Diagnostic("FZ302", message, span_of(controller.period), help="write a time, such as: every 5 ms")


def _computed(expr: Expr, params: ParamValues) -> float | Diagnostic | None:
    """Return the value of an expression over params, None where a param that it needs has none."""
    if params.lacks(expr):
        return None
    try:
        return evaluate(expr, params.values)
    except ExprError as error:
        return Diagnostic("FZ307", error.message, error.span)


def _ends(bounds: Bounds, params: ParamValues) -> tuple[float, float] | None:
    low, high = (_computed(e, params) for e in (bounds.lower, bounds.upper))
    return (low, high) if isinstance(low, float) and isinstance(high, float) else None


def _range(name: str, bounds: Bounds, params: ParamValues) -> Iterator[Diagnostic]:
    ends = _ends(bounds, params)
    yield from (e for e in (_computed(x, params) for x in (bounds.lower, bounds.upper)) if isinstance(e, Diagnostic))
    if ends is not None and not ends[0] < ends[1]:
        message = f"the range of '{name}' is empty: {ends[0]:g} is not below {ends[1]:g}"
        yield Diagnostic("FZ304", message, bounds.span, help="put the smaller end first")


def _within(what: str, expr: Expr, bounds: Bounds | None, params: ParamValues) -> Iterator[Diagnostic]:
    """Report a number outside of its range."""
    value = _computed(expr, params)
    if isinstance(value, Diagnostic):
        if not what.startswith("param"):  # whose values are reported before
            yield value
        return
    ends = _ends(bounds, params) if bounds is not None else None
    if value is None or bounds is None or ends is None or not ends[0] < ends[1]:
        return
    above = value > ends[0] if bounds.without_lower else value >= ends[0]
    below = value < ends[1] if bounds.without_upper else value <= ends[1]
    if not (above and below):
        text = bounds.span.text if bounds.span is not None else f"[{ends[0]:g}, {ends[1]:g}]"
        yield Diagnostic("FZ302", f"{what} is {value:g}, outside of {text}", span_of(expr))
