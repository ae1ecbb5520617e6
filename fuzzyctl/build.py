"""Builds systems in Python: the same model, the same checks, without a file.

```python
from math import inf
from fuzzyctl import build

service = build.input_variable("service", 0, 10, build.partition("poor good excellent"))
tip = build.output_variable("tip", 0, 30, {"low": 0, "fair": 15, "high": 30}, unit="%")
table = build.rule_table("tip", "service", {"poor": "low", "good": "fair", "excellent": "high"})
system = build.system("tip", [service, tip], [table], defuzzifier="weighted_average")
```
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from numbers import Real
from typing import Any, Final, Literal, TypeVar

from pydantic import ValidationError

from fuzzyctl import fragments
from fuzzyctl.errors import ArgumentError, Diagnostic, DiagnosticError, ValueOutOfBoundsError
from fuzzyctl.expr import ONE, Expr, Name, Negate, Number
from fuzzyctl.formats.fz import dumps
from fuzzyctl.fragments import rule
from fuzzyctl.loading import examine
from fuzzyctl.model.guarantee import Guarantee, Param
from fuzzyctl.model.method import Activation, Defuzzifier, Method
from fuzzyctl.model.node import Node
from fuzzyctl.model.rule import Cell, Rule, RuleTable, literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Fallback, Hold, Input, Membership, Output, Term
from fuzzyctl.source import SourceText

__all__ = [
    "Hold",
    "expression",
    "input_variable",
    "membership",
    "output_variable",
    "partition",
    "rule",
    "rule_table",
    "system",
]

#: A number, or the text of an expression over params.
Value = float | int | str | Expr

#: What a term may be given as: a number or the text of an expression (a constant), a kind with its parameters, such as
#: ("triangle", 0, 1, 2) or "triangle(0, 1, 2)".
TermSpec = float | int | str | Sequence[Any] | Membership

_Part = TypeVar("_Part", bound=Node)

#: Names as the language has them; which of them are words of the language is for the checks.
_NAME: Final = re.compile(r"[^\W\d]\w*")


def expression(value: Value) -> Expr:
    """Return an expression from a number, a text such as `"(k - 1) / 2"`, or an expression.

    Raises:
        DiagnosticError: For a text that is no expression.
        ArgumentError: For anything else.
        ValueOutOfBoundsError: For NaN, which no number of a system can be.
    """
    if isinstance(value, Expr):
        return value
    if isinstance(value, str):
        return fragments.expression(value)
    if not isinstance(value, Real):
        raise ArgumentError(f"a number or the text of an expression is due, got {type(value).__name__}")
    if value != value:
        raise ValueOutOfBoundsError("a number of a system", value, "not NaN")
    if math.isinf(value):  # a name, as in a file
        return Name("inf") if value > 0 else Negate(Name("inf"))
    return Number(float(value))


def membership(kind: str, *arguments: Value, height: Value = 1) -> Membership:
    """Return a membership function, such as `membership("triangle", -inf, 0, 1)`."""
    return Membership(kind=kind, arguments=tuple(map(expression, arguments)), height=expression(height))


def partition(names: str | Sequence[str], peaks: Sequence[Value] | None = None) -> _Partition:
    """Return a triangular partition: terms that meet at each other's peaks, with shoulders at the ends.

    Args:
        names: The terms, in a text separated by blanks or as a sequence.
        peaks: Their peaks; None spreads them evenly over the range of the variable.
    """
    return _Partition(tuple(names.split() if isinstance(names, str) else names), peaks)


class _Partition:
    def __init__(self, names: tuple[str, ...], peaks: Sequence[Value] | None) -> None:
        if len(names) < 2 or (peaks is not None and len(peaks) != len(names)):
            raise ArgumentError(f"a partition needs two terms or more and a peak for each, got {names} and {peaks}")
        self.names, self.peaks = names, peaks

    def terms(self, lower: float, upper: float) -> dict[str, TermSpec]:
        last = len(self.names) - 1
        peaks = self.peaks or [(lower * (last - k) + upper * k) / last for k in range(last + 1)]
        feet = [-math.inf, *peaks, math.inf]
        return {n: ("triangle", feet[k], peaks[k], feet[k + 2]) for k, n in enumerate(self.names)}


def input_variable(
    name: str,
    lower: Value,
    upper: Value,
    terms: Mapping[str, TermSpec] | _Partition,
    *,
    label: str = "",
    unit: str = "",
    extrapolate: bool = False,
) -> Input:
    """Return an input.

    Args:
        name: An identifier.
        lower: Lower end of the range.
        upper: Upper end of the range.
        terms: Terms by name, or a `partition`.
        label: What plots write.
        unit: Its unit.
        extrapolate: Whether values outside the range go through the formulas instead of being clamped.
    """
    fields = _variable(name, lower, upper, terms, label, unit)
    return _made(Input, fields | {"extrapolate": extrapolate})


def output_variable(
    name: str,
    lower: Value,
    upper: Value,
    terms: Mapping[str, TermSpec] | _Partition,
    *,
    label: str = "",
    unit: str = "",
    otherwise: Value | Fallback | Literal["hold"] | Hold | None = None,
    adaptive: Value | None = None,
    implication: str | None = None,
    aggregation: str | None = None,
    defuzzifier: str | Defuzzifier | None = None,
) -> Output:
    """Return an output; the arguments are those of `input_variable`.

    Args:
        name: An identifier.
        lower: Lower end of the range.
        upper: Upper end of the range.
        terms: Terms by name, or a `partition`.
        label: What plots write.
        unit: Its unit.
        otherwise: What it is where no rule fires: a value, "midpoint", "nan", "error", "hold" or `Hold(start=...)`.
        adaptive: The rate of adaptive consequents.
        implication: Its own implication, None for the system's.
        aggregation: Its own aggregation, None for the system's.
        defuzzifier: Its own defuzzifier, None for the system's.
    """
    fields = _variable(name, lower, upper, terms, label, unit)
    own = None if defuzzifier is None else _defuzzifier(defuzzifier)
    fields |= {"implication": implication, "aggregation": aggregation, "defuzzifier": own}
    if otherwise is not None:
        fields["otherwise"] = _otherwise(otherwise)
    if adaptive is not None:
        fields["adaptive"] = expression(adaptive)
    return _made(Output, fields)


def _otherwise(given: Value | Hold) -> Expr | Hold | str:
    if given == "hold":
        return Hold()
    if isinstance(given, Hold) or given in ("midpoint", "nan", "error"):
        return given
    return expression(given)


def _defuzzifier(given: str | Defuzzifier) -> Defuzzifier:
    return given if isinstance(given, Defuzzifier) else Defuzzifier(kind=given)


def _made(kind: type[_Part], fields: Mapping[str, Any]) -> _Part:
    """Return a part of a model.

    Raises:
        ArgumentError: For a field of a type that it cannot have.
    """
    try:
        return kind.model_validate(fields)
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"][:1])
        raise ArgumentError(f"{field!r} of {kind.__name__.lower()} cannot be {first['input']!r}") from None


def _variable(
    name: str, lower: Value, upper: Value, terms: Mapping[str, TermSpec] | _Partition, label: str, unit: str
) -> dict[str, Any]:
    if isinstance(terms, _Partition):
        numbers = [e for e in (lower, upper) if isinstance(e, Real)]
        if terms.peaks is None and len(numbers) < 2:
            raise ArgumentError("an even partition needs a range of numbers; give the peaks")
        terms = terms.terms(*(map(float, numbers) if len(numbers) == 2 else (0.0, 0.0)))
    return {
        "name": name,
        "label": label,
        "unit": unit,
        "lower": expression(lower),
        "upper": expression(upper),
        "terms": tuple(Term(name=n, membership=_membership(t)) for n, t in terms.items()),
    }


def _membership(spec: TermSpec) -> Membership:
    if isinstance(spec, Membership):
        return spec
    if isinstance(spec, str):
        return fragments.membership(spec) or membership("constant", spec)
    if isinstance(spec, Sequence):
        return membership(spec[0], *spec[1:])
    return membership("constant", spec)


def rule_table(
    outputs: str | Sequence[str],
    rows: str,
    cells: Mapping[str, Any],
    columns: str | None = None,
    *,
    headers: str | Sequence[str] = (),
    condition: str | None = None,
) -> RuleTable:
    """Return a rule table.

    Args:
        outputs: The output that the cells name, or several.
        rows: The input whose terms lead the rows; of a one-way table the only input.
        cells: For a two-way table the cells of each row, by its term, as a text or a sequence; for a one-way table the
            cell of each term. A cell is what it is in a file, such as `"NB"`, `"."`, `"NB*0.5"`, `"linear(1, 2, 3)"`,
            `"(2 * k)"` or, for several outputs, `"NB/PB"`; or a number, a `membership`, or None for no rule.
        columns: The input whose terms head the columns, None for a one-way table.
        headers: For a two-way table the terms of the columns, as a text or a sequence.
        condition: For a slice what stands behind `with` in a file, such as `"mode is slow"`.

    Raises:
        ArgumentError: For rows and cells of the wrong length.
        DiagnosticError: For a text that is no cell or no condition.
    """
    names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    if columns is None:
        head, body = tuple(cells), [[_cell(c, names) for c in cells.values()]]
    else:
        head = tuple(headers.split() if isinstance(headers, str) else headers)
        body = [_row(label, given, names, len(head)) for label, given in cells.items()]
    return RuleTable(
        outputs=names,
        rows=None if columns is None else rows,
        columns=rows if columns is None else columns,
        row_terms=() if columns is None else tuple(cells),
        column_terms=head,
        cells=tuple(map(tuple, body)),
        condition=None if condition is None else fragments.antecedent(condition),
    )


def _row(label: str, given: Any, outputs: tuple[str, ...], columns: int) -> list[Cell]:
    row = fragments.cells(given) if isinstance(given, str) else [_cell(c, outputs) for c in given]
    if len(row) != columns:
        raise ArgumentError(f"row {label!r} has {len(row)} cells for {columns} columns")
    return [_cell(c, outputs) for c in row]


def _cell(given: Any, outputs: tuple[str, ...]) -> Cell:
    """Return one cell; a cell without a term stands for no rule."""
    cell: Cell = given
    if given is None:
        cell = Cell(terms=())
    elif isinstance(given, str):
        found = fragments.cells(given)
        if len(found) != 1:
            raise ArgumentError(f"one cell is due, got {given!r}")
        cell = found[0]
    elif not isinstance(given, Cell):
        cell = Cell(terms=(_membership(given),), weight=ONE)
    if cell.terms and len(cell.terms) != len(outputs):
        raise ArgumentError(f"cell {given!r} names {len(cell.terms)} terms for {len(outputs)} outputs")
    return cell


def system(
    name: str,
    variables: Iterable[Input | Output],
    rules: Iterable[Rule | RuleTable | str],
    *,
    params: Mapping[str, Value | tuple[Value, str]] | None = None,
    hedges: Mapping[str, str] | None = None,
    title: str = "",
    citation: str = "",
    defuzzifier: str | Defuzzifier = "centroid",
    activation: Activation | None = None,
    guarantees: Iterable[Guarantee | str] = (),
    conjunction: str = "min",
    disjunction: str = "max",
    implication: str = "min",
    aggregation: str = "max",
) -> FuzzySystem:
    """Build and check a system.

    Args:
        name: An identifier.
        variables: Inputs and outputs, in the order of a kernel's arguments and results.
        rules: Rules, tables and texts of rules, in order.
        params: Named constants, each a value, or a value and its unit.
        hedges: Own hedges, each an expression over `x`, such as `{"fairly": "x ^ 0.7"}`.
        title: What it is, for people.
        citation: Where it comes from.
        defuzzifier: A kind, or a `Defuzzifier`.
        activation: An activation method.
        guarantees: What stands behind `require` in a file.
        conjunction, disjunction, implication, aggregation: Norms.

    Raises:
        DiagnosticError: With all mistakes, as for a file but without places.
        ArgumentError: For an argument of a type that it cannot have.
    """
    given = list(variables)
    fields = {"conjunction": conjunction, "disjunction": disjunction}
    fields |= {"implication": implication, "aggregation": aggregation}
    norms: dict[str, Any] = {**fields, "defuzzifier": _defuzzifier(defuzzifier)}
    method = _made(Method, norms | {"activation": activation or Activation()})
    built = _made(
        FuzzySystem,
        {
            "name": name,
            "title": title,
            "citation": citation,
            "params": tuple(_param(n, v) for n, v in (params or {}).items()),
            "hedges": tuple(fragments.hedge(n, text) for n, text in (hedges or {}).items()),
            "method": method,
            "inputs": tuple(v for v in given if isinstance(v, Input)),
            "outputs": tuple(v for v in given if isinstance(v, Output)),
            "blocks": tuple(rule(r) if isinstance(r, str) else r for r in rules),
            "guarantees": tuple(fragments.guarantee(g) if isinstance(g, str) else g for g in guarantees),
        },
    )
    _require_as_file(built)
    return built


def _param(name: str, given: Value | tuple[Value, str]) -> Param:
    value, unit = given if isinstance(given, tuple) else (given, "")
    return _made(Param, {"name": name, "expression": expression(value), "unit": unit})


def _require_as_file(built: FuzzySystem) -> None:
    """Check a system as the rule file that it prints as, so that Python and files have one set of checks.

    Raises:
        DiagnosticError: With all mistakes, without places.
    """
    mistakes = list(_no_names(built))
    if mistakes:  # nothing can be printed
        raise DiagnosticError(mistakes)
    text = dumps(built)
    read, found = examine(SourceText(f"system {built.name}", text))
    errors = [_without_place(d) for d in found if d.severity == "error"]
    if errors:
        raise DiagnosticError(errors)
    if read is None or dumps(read) != text:  # such as a name in a rule made by hand that prints as something else
        raise ArgumentError(f"the system {built.name!r} has parts that no rule file can say")


def _without_place(d: Diagnostic) -> Diagnostic:
    """Return a diagnostic of a text that nobody has written: without lines, and without facts that name them."""
    facts = tuple(re.sub(r" \(line \d+\)", "", fact) for fact in d.facts)
    return dataclasses.replace(d, span=None, notes=(), facts=facts)


def _no_names(built: FuzzySystem) -> Iterator[Diagnostic]:
    """Find names that cannot be printed where a name is due."""
    variables = (*built.inputs, *built.outputs)
    named = [("system", built.name), *(("param", p.name) for p in built.params)]
    named += [("hedge", h.name) for h in built.hedges] + [("variable", v.name) for v in variables]
    named += [(f"term of '{v.name}'", t.name) for v in variables for t in v.terms]
    for r in built.rules:
        named += [("part of a rule", w) for i in literals(r.antecedent) for w in (i.variable, i.term, *i.hedges)]
        named += [("part of a rule", w) for c in r.consequents for w in (c.output, c.term) if isinstance(w, str)]
    for table in (b for b in built.blocks if isinstance(b, RuleTable)):
        words = [*table.outputs, table.columns, *([table.rows] if table.rows else [])]
        named += [("part of a table", w) for w in (*words, *table.row_terms, *table.column_terms)]
    for what, name in dict.fromkeys(named):
        if not _NAME.fullmatch(name):
            help_text = "a name is a letter, and letters, digits and underscores behind it"
            yield Diagnostic("FZ102", f"{name!r} cannot be the name of a {what}", help=help_text)
