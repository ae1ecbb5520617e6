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

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from fuzzyctl.errors import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.expr import ONE, Expr, Number
from fuzzyctl.formulas import HEDGES
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.parser import parse
from fuzzyctl.model.checks import require_well_formed
from fuzzyctl.model.guarantee import Guarantee, Param
from fuzzyctl.model.method import Activation, Defuzzifier, Method
from fuzzyctl.model.rule import And, Antecedent, Cell, Is, Not, Or, Rule, RuleTable, literals
from fuzzyctl.model.rule import Consequent as ModelConsequent
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Fallback, Hold, Input, Membership, Output, Term
from fuzzyctl.source import SourceText

#: A number, or the text of an expression over params.
Value = float | int | str | Expr

#: What a term may be given as: a number (a constant), or a kind and its parameters, such as ("triangle", 0, 1, 2).
TermSpec = float | int | Sequence[Any] | Membership


def expression(value: Value) -> Expr:
    """Return an expression from a number, a text such as `"(k - 1) / 2"`, or an expression.

    Raises:
        DiagnosticError: For a text that is no expression.
    """
    if isinstance(value, Expr):
        return value
    if isinstance(value, str):
        statement = _statement(f"param _ = {value}", value)
        assert isinstance(statement, sx.Param)
        return statement.expression
    return Number(float(value))


def _statement(line: str, shown: str) -> sx.Statement:
    tree, mistakes = parse(SourceText(f"<{shown}>", line))
    if mistakes:
        raise DiagnosticError(mistakes)
    return tree.statements[0]


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
    return Input(**fields, extrapolate=extrapolate)


def output_variable(
    name: str,
    lower: Value,
    upper: Value,
    terms: Mapping[str, TermSpec] | _Partition,
    *,
    label: str = "",
    unit: str = "",
    otherwise: Value | Fallback | Hold | None = None,
    adaptive: Value | None = None,
) -> Output:
    """Return an output; the arguments are those of `input_variable`.

    Args:
        name: An identifier.
        lower: Lower end of the range.
        upper: Upper end of the range.
        terms: Terms by name, or a `partition`.
        label: What plots write.
        unit: Its unit.
        otherwise: What it is where no rule fires: a value, "midpoint", "nan", "error", or `Hold()`, the previous value.
        adaptive: The rate of adaptive consequents.
    """
    fields = _variable(name, lower, upper, terms, label, unit)
    if otherwise is not None:
        word = otherwise in ("midpoint", "nan", "error") or isinstance(otherwise, Hold)
        fields["otherwise"] = otherwise if word else expression(otherwise)  # type: ignore[arg-type]
    if adaptive is not None:
        fields["adaptive"] = expression(adaptive)
    return Output(**fields)


def _variable(
    name: str, lower: Value, upper: Value, terms: Mapping[str, TermSpec] | _Partition, label: str, unit: str
) -> dict[str, Any]:
    if isinstance(terms, _Partition):
        if terms.peaks is None and not all(isinstance(e, int | float) for e in (lower, upper)):
            raise ArgumentError("an even partition needs a range of numbers; give the peaks")
        terms = terms.terms(*(float(e) if isinstance(e, int | float) else 0.0 for e in (lower, upper)))
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
    if isinstance(spec, int | float):
        return membership("constant", spec)
    kind, *arguments = spec
    return membership(kind, *arguments)


def rule(text: str) -> Rule:
    """Return a rule from its text, such as `"if a is NB and not b is PS then f is NS weight 0.5"`.

    Raises:
        DiagnosticError: For a text that is no rule; names are checked when the system is built.
    """
    statement = _statement(text, "rule")
    if not isinstance(statement, sx.Rule):
        raise ArgumentError(f"{text!r} is no rule")
    consequents = []
    for c in statement.consequents:
        term: str | Membership = c.term.text if isinstance(c.term, sx.Word) else _function(c.term)
        consequents.append(ModelConsequent(output=c.output.text, term=term))
    antecedent = _antecedent(statement.antecedent)
    return Rule(antecedent=antecedent, consequents=tuple(consequents), weight=statement.weight or ONE)


def _function(term: sx.FunctionTerm) -> Membership:
    return Membership(kind=term.kind.text, arguments=term.arguments)


def _antecedent(truth: sx.Truth) -> Antecedent:
    match truth:
        case sx.Literal(variable=variable, hedges=hedges, term=term):
            return Is(variable=variable.text, term=term.text, hedges=tuple(h.text for h in hedges))
        case sx.Negation(operand=operand):
            return Not(operand=_antecedent(operand))
        case sx.Group(operand=operand):
            return _antecedent(operand)
        case sx.Chain(connective=connective, operands=operands):
            parts = tuple(_antecedent(o) for o in operands)
            return And(operands=parts) if connective == "and" else Or(operands=parts)
    raise TypeError(type(truth).__name__)


def rule_table(
    outputs: str | Sequence[str],
    rows: str,
    cells: Mapping[str, Any],
    columns: str | None = None,
    *,
    headers: str | Sequence[str] = (),
) -> RuleTable:
    """Return a rule table.

    Args:
        outputs: The output that the cells name, or several.
        rows: The input whose terms lead the rows; of a one-way table the only input.
        cells: For a two-way table the cells of each row, by its term, as a text or a sequence; for a one-way table the
            cell of each term. A cell is a term, a number, `.` for no rule, or for several outputs terms joined by `/`.
        columns: The input whose terms head the columns, None for a one-way table.
        headers: For a two-way table the terms of the columns, as a text or a sequence.
    """
    names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    if columns is None:
        row = tuple(_cell(c, names) for c in cells.values())
        return RuleTable(outputs=names, rows=None, columns=rows, row_terms=(), column_terms=tuple(cells), cells=(row,))
    head = tuple(headers.split() if isinstance(headers, str) else headers)
    body = []
    for label, given in cells.items():
        entries = given.split() if isinstance(given, str) else list(given)
        if len(entries) != len(head):
            raise ArgumentError(f"row {label!r} has {len(entries)} cells for {len(head)} columns")
        body.append(tuple(_cell(c, names) for c in entries))
    return RuleTable(
        outputs=names, rows=rows, columns=columns, row_terms=tuple(cells), column_terms=head, cells=tuple(body)
    )


def _cell(given: Any, outputs: tuple[str, ...]) -> Cell:
    if given is None or given == ".":
        return Cell(terms=())
    parts = given.split("/") if isinstance(given, str) else [given]
    if len(parts) != len(outputs):
        raise ArgumentError(f"cell {given!r} names {len(parts)} terms for {len(outputs)} outputs")
    return Cell(terms=tuple(_cell_term(p) for p in parts))


def _cell_term(part: Any) -> str | Membership:
    if isinstance(part, Membership):
        return part
    try:
        return membership("constant", float(part))
    except ValueError:
        return str(part)


def system(
    name: str,
    variables: Iterable[Input | Output],
    rules: Iterable[Rule | RuleTable | str],
    *,
    params: Mapping[str, Value] | None = None,
    title: str = "",
    citation: str = "",
    defuzzifier: str | Defuzzifier = "centroid",
    activation: Activation | None = None,
    guarantees: Iterable[Guarantee] = (),
    **norms: str,
) -> FuzzySystem:
    """Build and check a system.

    Args:
        name: An identifier.
        variables: Inputs and outputs, in the order of a kernel's arguments and results.
        rules: Rules, tables and texts of rules, in order.
        params: Named constants.
        title: What it is, for people.
        citation: Where it comes from.
        defuzzifier: A kind, or a `Defuzzifier`.
        activation: An activation method.
        guarantees: Claims.
        norms: `conjunction`, `disjunction`, `implication`, `aggregation`.

    Raises:
        DiagnosticError: With all mistakes, as for a file but without places.
    """
    given = list(variables)
    chosen = defuzzifier if isinstance(defuzzifier, Defuzzifier) else Defuzzifier(kind=defuzzifier)
    method = Method.model_validate({**norms, "activation": activation or Activation(), "defuzzifier": chosen})
    built = FuzzySystem(
        name=name,
        title=title,
        citation=citation,
        params=tuple(Param(name=n, expression=expression(v)) for n, v in (params or {}).items()),
        method=method,
        inputs=tuple(v for v in given if isinstance(v, Input)),
        outputs=tuple(v for v in given if isinstance(v, Output)),
        blocks=tuple(rule(r) if isinstance(r, str) else r for r in rules),
        guarantees=tuple(guarantees),
    )
    mistakes = list(_unknown_names(built))
    if mistakes:
        raise DiagnosticError(mistakes)
    require_well_formed(built)
    return built


def _unknown_names(built: FuzzySystem) -> Iterable[Diagnostic]:
    """Find what a file's resolver would find: variables and terms that do not exist."""
    variables = {v.name: v for v in (*built.inputs, *built.outputs)}
    for r in built.rules:
        named: list[tuple[str, str | Membership]] = [(i.variable, i.term) for i in literals(r.antecedent)]
        named += [(c.output, c.term) for c in r.consequents]
        for i in literals(r.antecedent):
            for hedge in i.hedges:
                if hedge not in HEDGES:
                    yield Diagnostic("FZ202", f"no hedge '{hedge}'", facts=(f"hedges: {', '.join(HEDGES)}",))
        for variable, term in named:
            if variable not in variables:
                yield Diagnostic("FZ202", f"no variable '{variable}'", facts=(f"variables: {', '.join(variables)}",))
            elif isinstance(term, str) and variables[variable].term(term) is None:
                names = ", ".join(t.name for t in variables[variable].terms)
                yield Diagnostic("FZ203", f"'{variable}' has no term '{term}'", facts=(f"terms: {names}",))
