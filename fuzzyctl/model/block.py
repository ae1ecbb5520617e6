"""The base of systems, controllers, plants and loops: nodes, params, hedges, guarantees, and the values of params."""

from __future__ import annotations

import math
import sys
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field, fields, replace
from functools import cache, cached_property
from types import UnionType
from typing import (
    TYPE_CHECKING,
    Any,
    ClassVar,
    Final,
    Literal,
    NamedTuple,
    Self,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.diagnostic import ValueOutOfBoundsError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import CONSTANTS, Expr, ExprError, evaluate, names_in
from fuzzyctl.operations import Described, Printed
from fuzzyctl.records import dataclass


@dataclass(frozen=True, kw_only=True, repr=False)
class Node(Described):
    """A frozen part of a fuzzy system; `span` says where it was written and takes no part in equality.

    A list in place of a tuple is taken as one.

    Raises:
        ValueOutOfBoundsError: When a field has a value of another type than declared, or a float that is not finite.
    """

    span: Span | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        kind: Any = type(self)
        values = self.__dict__
        for name, plain, takes in _fields_of(kind):
            value = values[name]
            if isinstance(value, plain):
                continue
            if isinstance(value, list):
                value = tuple(value)
                object.__setattr__(self, name, value)
            if not takes(value):
                declared = kind.__dataclass_fields__[name].type
                raise ValueOutOfBoundsError(f"{kind.__name__}.{name}", value, f"of type {declared}")

    def __dir__(self) -> list[str]:
        """Return the names to complete; `model_copy` is for code that copies either kind of model."""
        return [name for name in super().__dir__() if name != "model_copy"]

    def model_copy(self, *, update: Mapping[str, Any] | None = None) -> Self:
        """Return a copy with some fields changed."""
        return replace(self, **(update or {}))


class _Accepted(NamedTuple):
    """The values that a field accepts: instances of some types, words, finite numbers, tuples of accepted items."""

    plain: tuple[type, ...]
    words: tuple[str, ...]
    number: bool
    items: _Accepted | None

    def takes(self, value: object) -> bool:
        """Return whether a value is accepted."""
        if isinstance(value, tuple) and self.items is not None:
            plain, takes = self.items.plain, self.items.takes
            return not [item for item in value if not isinstance(item, plain) and not takes(item)]
        if isinstance(value, float | int):
            return isinstance(value, self.plain) or (self.number and abs(value) <= sys.float_info.max)
        return isinstance(value, self.plain) or (isinstance(value, str) and value in self.words)


@cache
def _fields_of(kind: Any) -> tuple[tuple[str, tuple[type, ...], Callable[[object], bool]], ...]:
    """Return the fields of a model type with the types that they accept, and a function that checks a value."""
    hints = get_type_hints(kind)
    accepted = [(f.name, _accepted(hints[f.name])) for f in fields(kind)]
    return tuple((name, a.plain, a.takes) for name, a in accepted)


def _accepted(declared: Any) -> _Accepted:
    plain: list[type] = []
    words: tuple[str, ...] = ()
    items = None
    for part in get_args(declared) if get_origin(declared) in (Union, UnionType) else (declared,):
        if get_origin(part) is Literal:
            words += get_args(part)
        elif get_origin(part) is tuple:
            items = _accepted(get_args(part)[0])
        elif part is not float:
            plain.append(get_origin(part) or part)
    return _Accepted(tuple(plain), words, float in (declared, *get_args(declared)), items)


@dataclass(frozen=True, kw_only=True)
class Bounds(Node):
    """A range of numbers; each end belongs to it unless it is left out."""

    lower: Expr
    upper: Expr
    without_lower: bool = False
    without_upper: bool = False

    def holds(self, value: float, low: float, high: float) -> bool:
        """Return whether a value lies in the range, whose ends have these numbers."""
        above = value > low if self.without_lower else value >= low
        below = value < high if self.without_upper else value <= high
        return above and below

    def text(self, low: float, high: float) -> str:
        """Return the range with the numbers of its ends, such as `[0, 2)`."""
        return f"{'(' if self.without_lower else '['}{low:g}, {high:g}{')' if self.without_upper else ']'}"


@dataclass(frozen=True, kw_only=True, repr=False)
class Param(Node):
    """A named constant; its expression may use params declared anywhere in the system."""

    name: str
    expression: Expr
    unit: str = ""
    bounds: Bounds | None = None


@dataclass(frozen=True, kw_only=True, repr=False)
class Hedge(Node):
    """A hedge of the user's own: `hedge NAME(x) = expression`, over its parameter and params."""

    name: str
    parameter: str
    expression: Expr


@dataclass(frozen=True, kw_only=True, repr=False)
class Guarantee(Node):
    """A claim over the whole input box: `require CLAIM within TOLERANCE when REGION`."""

    claim: Expr
    within: Expr | None = None
    when: Expr | None = None


@dataclass(frozen=True, kw_only=True, repr=False)
class Block(Node, Printed):
    """A system, controller, plant or loop.

    Args:
        name: Its identifier.
        title: A title for people.
        citation: Where it comes from.
        params: Named constants, as expressions.
        path: The file it was read from, or an empty string.
    """

    #: The word of the rule file that begins such a block.
    kind: ClassVar[str]
    #: Whether expressions call it; each other block is given a name, by `block NAME = ...`.
    is_function: ClassVar[bool] = False
    #: Whether it is sampled, so that its equations give the next state, and claims are about every step.
    is_sampled: ClassVar[bool] = False
    name: str
    title: str = ""
    citation: str = ""
    params: tuple[Param, ...] = ()
    path: str = field(default="", compare=False, repr=False)

    if TYPE_CHECKING:  # fields of systems and of the other blocks, whose parts have other types

        @property
        def inputs(self) -> tuple[Any, ...]:
            """The inputs in the order of declaration."""

        @property
        def outputs(self) -> tuple[Any, ...]:
            """The outputs in the order of declaration."""

        @property
        def systems(self) -> tuple[Any, ...]:
            """The systems that it evaluates."""

        @property
        def definitions(self) -> tuple[Any, ...]:
            """The `let` lines."""

        def range_of(self, signal: Any) -> tuple[float, float]:
            """Return the ends of the range of an input or output; infinite without a range."""

        def with_params(self, **values: float) -> Self:
            """Return the block with some params set to numbers."""

        def with_systems(self, change: Callable[[Any], Any]) -> Self:
            """Return the block with each system that it evaluates changed, those of blocks inside among them."""

    @property
    def parts(self) -> tuple[Block, ...]:
        """The blocks that it calls, each behind those that it calls itself, and at last the block."""
        return (self,)

    @property
    def unclaimed(self) -> str:
        """Why the block has no claims to prove, an empty text for one that can have some."""
        return ""

    @property
    def all_systems(self) -> tuple[Any, ...]:
        """The systems that it evaluates, those of blocks inside among them, each once."""
        return tuple({(s.name, s.path): s for part in self.parts for s in part.systems}.values())

    @property
    def lets(self) -> tuple[Any, ...]:
        """The lets of a system, which claims take by their values; those of other blocks are part of their steps."""
        return ()

    @property
    def states(self) -> tuple[Any, ...]:
        """The declared states in the order of declaration; systems declare none."""
        return ()

    @property
    def changes(self) -> tuple[Any, ...]:
        """The next value of each state, of a plant its derivative by time."""
        return ()

    @property
    def conditions(self) -> dict[str, Expr]:
        """The names of conditions, which claims may have in place of them; a let of a system is a number."""
        return {}

    @property
    def settable(self) -> list[str]:
        """The names of the params that can be set, those of a controller's instances among them."""
        return [p.name for p in self.params]

    @property
    def identity(self) -> dict[str, str]:
        """The keys that name the block in JSON."""
        return {self.kind: self.name}

    @cached_property
    def param_values(self) -> ParamValues:
        """Values of the params as far as they can be computed, and why others cannot."""
        return ParamValues(self.params)

    @cached_property
    def values(self) -> dict[str, float]:
        """Values of all params.

        Raises:
            ExprError: If a param cannot be computed; a loaded block has none such.
        """
        computed = self.param_values
        if computed.errors:
            raise computed.errors[0]
        return computed.values

    def number(self, expr: Expr) -> float:
        """Compute an expression over the params."""
        return evaluate(expr, self.values)

    def as_declared(self, name: str) -> str:
        """Return the name of an input as the file spells it: Python writes µ and some others in another form (NFKC)."""
        if name.isascii():
            return name
        return next((v.name for v in self.inputs if unicodedata.normalize("NFKC", v.name) == name), name)


#: Repair of a param that is infinite.
FINITE: Final = "give it a finite number, a large one where nothing is limited"


class ParamCycleError(ExprError):
    """Raised when a param depends on itself."""

    def __init__(self, names: list[str], span: Span | None) -> None:
        super().__init__(f"param '{names[0]}' depends on itself: {' → '.join(names)}", span)


class ParamValues:
    """Values of params, as far as they can be computed.

    Args:
        params: The params.
        partial: Whether some may be missing; a name that is not among them is then no mistake.

    Attributes:
        values: By name.
        failed: Names of those without a value.
        errors: Why, once for each cause.
    """

    def __init__(self, params: Sequence[Param], *, partial: bool = False) -> None:
        self.partial = partial
        self.values: dict[str, float] = {}
        self.failed: set[str] = set()
        self.errors: list[ExprError] = []
        self._by_name = {p.name: p for p in params}
        self._names: dict[str, list[ex.Name]] = {}
        for param in params:
            self._settle(param)

    def _settle(self, start: Param) -> None:
        """Compute a param and the params that it needs, without recursion: chains of params may be long."""
        open_names = [start.name]
        is_open = {start.name}
        while open_names:
            param = self._by_name[open_names[-1]]
            needed = None if self._is_settled(param.name) else self._needed(param)
            if needed is None:
                self._compute(param)
                is_open.discard(open_names.pop())
            elif needed.name in is_open:
                cycle = open_names[open_names.index(needed.name) :]
                self.errors.append(ParamCycleError([*cycle, needed.name], needed.span))
                self.failed.update(cycle)
            else:
                open_names.append(needed.name)
                is_open.add(needed.name)

    def _is_settled(self, name: str) -> bool:
        return name in self.values or name in self.failed

    def _needed(self, param: Param) -> ex.Name | None:
        names = self._names.get(param.name)
        if names is None:
            names = self._names[param.name] = names_in(param.expression)
        return next((n for n in names if n.name in self._by_name and not self._is_settled(n.name)), None)

    def _compute(self, param: Param) -> None:
        if self._is_settled(param.name):
            return
        self.failed.add(param.name)
        if self._lacks(self._names.pop(param.name)):
            return
        try:
            value = evaluate(param.expression, self.values)
            if math.isinf(value):
                error = ExprError(f"param '{param.name}' is infinite", param.span)
                error.help = FINITE
                raise error
        except ExprError as error:
            self.errors.append(error)
            return
        self.failed.discard(param.name)
        self.values[param.name] = value

    def of(self, expr: ex.Expr) -> float | None:
        """Return the value of an expression over params, None where it has none."""
        try:
            return evaluate(expr, self.values)
        except ExprError:
            return None

    def lacks(self, expr: ex.Expr) -> bool:
        """Whether an expression has no value because it uses a param without a value."""
        return (bool(self.failed) or self.partial) and self._lacks(names_in(expr))

    def _lacks(self, names: Iterable[ex.Name]) -> bool:
        unknown = {n.name for n in names if n.name not in self.values and n.name not in CONSTANTS}
        return any(n in self.failed for n in unknown) or (self.partial and bool(unknown))
