"""Builder of systems in Python: the same model and the same checks, without a file.

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
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

from fuzzyctl.building import fragments, values
from fuzzyctl.building.fragments import rule
from fuzzyctl.building.values import Value, activation_of, method_of, partition
from fuzzyctl.building.variables import Hold, input_variable, let_variable, membership, output_variable
from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import ONE, Expr
from fuzzyctl.formats.fz import dumps
from fuzzyctl.formulas.norms import Aggregation, Conjunction, Disjunction
from fuzzyctl.loading.load import examine
from fuzzyctl.model.block import Guarantee, Hedge, Param
from fuzzyctl.model.method import Activation, Defuzzifier, Method, Semantics
from fuzzyctl.model.rule import Cell, Rule, RuleBlock, RuleTable, literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Let, Membership, Output
from fuzzyctl.support import arguments

#: Names as the language has them; which of them are words of the language is for the checks.
_NAME: Final = re.compile(r"[^\W\d]\w*")

#: The parts that a system names: the kind, and the name.
_Named = Iterator[tuple[str, str]]


def require_as_file(built: FuzzySystem) -> None:
    """Check a system as a rule file.

    Raises:
        DiagnosticError: With all mistakes, without places.
        ArgumentError: For elements made by hand that cannot be expressed in .fz.
        ValueOutOfBoundsError: For a title, label, unit or citation that a rule file cannot hold.
    """
    mistakes = list(_no_names(built))
    if mistakes:  # nothing can be printed
        raise DiagnosticError(mistakes)
    text = dumps(built)
    read, blocks = examine(SourceText(f"system {built.name}", text))
    errors = [_without_place(d) for d in blocks if d.severity == "error"]
    if errors:
        raise DiagnosticError(errors)
    if read is None or dumps(read) != text:  # such as a name in a rule made by hand that prints as something else
        raise ArgumentError(f"the system {built.name!r} contains elements that cannot be expressed in .fz")


def _without_place(d: Diagnostic) -> Diagnostic:
    """Return a diagnostic of generated text without its location, and without the lines that its facts name."""
    facts = tuple(re.sub(r" \(line \d+\)", "", fact) for fact in d.facts)
    return dataclasses.replace(d, span=None, notes=(), facts=facts)


def _no_names(built: FuzzySystem) -> Iterator[Diagnostic]:
    """Find names that cannot be written as names of a rule file."""
    named = [*_declared(built), *_method_names(built), *_in_rules(built), *_in_tables(built)]
    for what, name in dict.fromkeys(named):
        if not _NAME.fullmatch(name):
            help_text = "a name is a letter, and letters, digits and underscores behind it"
            yield Diagnostic("FZ102", f"{name!r} cannot be the name of {what}", help=help_text)


def _declared(built: FuzzySystem) -> _Named:
    yield "a system", built.name
    for p in built.params:
        yield "a param", p.name
    for h in built.hedges:
        yield "a hedge", h.name
        yield "the parameter of a hedge", h.parameter
    for v in built.variables:
        yield "a variable", v.name
        for t in v.terms:
            yield f"a term of '{v.name}'", t.name
            yield "a membership function", t.membership.kind
    yield from (("a rule block", b.name) for b in built.rule_blocks)


def _method_names(built: FuzzySystem) -> _Named:
    owners: tuple[Method | Output | RuleBlock, ...] = (built.method, *built.outputs, *built.rule_blocks)
    for owner in owners:
        for field in ("conjunction", "disjunction", "implication", "aggregation"):
            name = getattr(owner, field, None)
            if name is not None:
                yield f"{'an' if field[0] in 'ai' else 'a'} {field}", name
        for field in ("activation", "defuzzifier"):
            setting = getattr(owner, field, None)
            if setting is not None:
                yield f"{'an' if field[0] == 'a' else 'a'} {field}", setting.kind


def _in_rules(built: FuzzySystem) -> _Named:
    for r in built.rules:
        for i in literals(r.antecedent):
            yield from (("a part of a rule", w) for w in (i.variable, i.term, *i.hedges))
        for c in r.consequents:
            name = c.term.kind if isinstance(c.term, Membership) else c.term
            yield from (("a part of a rule", w) for w in (c.output, *c.hedges, name))


def _in_tables(built: FuzzySystem) -> _Named:
    for table in built.tables_and_rules:
        if isinstance(table, RuleTable):
            words = [*table.outputs, table.columns, *([table.rows] if table.rows else [])]
            yield from (("a part of a table", w) for w in (*words, *table.row_terms, *table.column_terms))


def row(label: str, cells: object, outputs: tuple[str, ...], columns: int) -> tuple[Cell, ...]:
    """Return the cells of a row, given as a text or a sequence.

    Args:
        label: The term that leads the row.
        cells: The cells of the row.
        outputs: The outputs that each cell sets.
        columns: The expected number of cells.

    Raises:
        ArgumentError: For another number of cells, and for an invalid cell.
        DiagnosticError: For an invalid text.
    """
    name = f"row {label!r}"
    parts = (
        fragments.cells(cells) if isinstance(cells, str) else arguments.items(name, "cells in a text or a list", cells)
    )
    if len(parts) != columns:
        raise ArgumentError(f"{name} has {len(parts)} cells for {columns} columns")
    return tuple(cell(f"a cell of {name}", c, outputs) for c in parts)


def cell(name: str, content: object, outputs: tuple[str, ...]) -> Cell:
    """Return one cell; an empty cell has no rule.

    Args:
        name: What to call it where it is refused.
        content: A text, a number, a membership, a cell, or None for no rule.
        outputs: The outputs that it sets.

    Raises:
        ArgumentError: For another number of terms than of outputs, and for an invalid cell.
        DiagnosticError: For an invalid text.
    """
    if content is None:
        return Cell(terms=())
    if isinstance(content, Cell):
        result = content
    elif isinstance(content, str):
        texts = fragments.cells(content)
        if len(texts) != 1:
            raise ArgumentError(f"expected one cell, got {content!r}")
        result = texts[0]
    else:
        result = Cell(terms=(values.membership(name, content),), weight=ONE)
    if result.terms and len(result.terms) != len(outputs):
        raise ArgumentError(f"{name} names {len(result.terms)} terms for {len(outputs)} outputs")
    return result


__all__ = [
    "Hold",
    "expression",
    "input_variable",
    "let_variable",
    "membership",
    "output_variable",
    "partition",
    "rule",
    "rule_block",
    "rule_table",
    "system",
]


def __dir__() -> list[str]:
    return __all__


def expression(value: Value) -> Expr:
    """Return an expression from a number, a text such as `"(k - 1) / 2"`, or an expression.

    Raises:
        DiagnosticError: For a text that is not an expression.
        ArgumentError: For anything else.
        ValueOutOfBoundsError: For NaN, which no number of a system can be, and numbers beyond the range of floats.
    """
    return values.expression("the value", value)


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
        condition: For a slice the condition after `with` in a file, such as `"mode is slow"`.

    Raises:
        ArgumentError: For rows and cells of the wrong length.
        DiagnosticError: For a text that is neither a cell nor a condition.
    """
    names = (outputs,) if isinstance(outputs, str) else arguments.names("'outputs'", outputs)
    by_label = arguments.mapping("'cells'", "cells by the terms of the rows", cells)
    arguments.text("'rows'", rows)
    head = arguments.names("'headers'", headers)
    if columns is None:
        if head:
            raise ArgumentError("'headers' are the terms of 'columns', and none are given")
        head, body = tuple(by_label), [tuple(cell(f"cell {n!r}", c, names) for n, c in by_label.items())]
    else:
        arguments.text("'columns'", columns)
        body = [row(label, row_cells, names, len(head)) for label, row_cells in by_label.items()]
    return RuleTable(
        outputs=names,
        rows=None if columns is None else rows,
        columns=rows if columns is None else columns,
        row_terms=() if columns is None else tuple(by_label),
        column_terms=head,
        cells=tuple(body),
        condition=None if condition is None else fragments.antecedent(condition),
    )


def rule_block(
    name: str,
    rules: Iterable[Rule | RuleTable | str],
    *,
    conjunction: Conjunction | None = None,
    disjunction: Disjunction | None = None,
    implication: Conjunction | None = None,
    activation: str | Activation | None = None,
) -> RuleBlock:
    """Return a rule block: rules that are joined, implied and chosen by other methods than those of the system.

    Args:
        name: An identifier; each block of a system has another one.
        rules: Rules, tables and texts of rules, in order; at least one.
        conjunction, disjunction, implication: Norms; None for those of the system, or the implication of the output.
        activation: The text after `activation` in a file, or an `Activation`; None for that of the system. A method
            that compares rules compares those of the block.

    Raises:
        ArgumentError: For no rules at all, and for arguments of a type that they cannot have.
        DiagnosticError: For a text that is neither a rule nor an activation method.
    """
    due = "a list of rules, tables and texts of rules"
    parts = arguments.items_of("'rules'", (Rule, RuleTable, str), due, rules)
    if not parts:
        raise ArgumentError("a rule block needs a rule")
    norms = {"conjunction": conjunction, "disjunction": disjunction, "implication": implication}
    return RuleBlock(
        **values.texts(name=name, **{n: norm for n, norm in norms.items() if norm is not None}),
        activation=None if activation is None else activation_of(activation),
        rules=tuple(rule(r) if isinstance(r, str) else r for r in parts),
    )


def system(
    name: str,
    variables: Iterable[Input | Output | Let],
    rules: Iterable[Rule | RuleTable | RuleBlock | str],
    *,
    params: Mapping[str, Value | tuple[Value, str]] | None = None,
    hedges: Mapping[str, str] | None = None,
    title: str = "",
    citation: str = "",
    semantics: str | Semantics = "exact",
    defuzzifier: str | Defuzzifier | None = None,
    activation: str | Activation | None = None,
    guarantees: Iterable[Guarantee | str] = (),
    conjunction: Conjunction | None = None,
    disjunction: Disjunction | None = None,
    implication: Conjunction | None = None,
    aggregation: Aggregation | None = None,
) -> FuzzySystem:
    """Build and check a system.

    Args:
        name: An identifier.
        variables: Inputs, lets and outputs; inputs and outputs in the order of a kernel's arguments and results.
        rules: Rules, tables and texts of rules, in order; then rule blocks.
        params: Named constants, each a value, or a value and its unit.
        hedges: Own hedges, each an expression over `x`, such as `{"fairly": "x ^ 0.7"}`.
        title: A title for people.
        citation: Where it comes from.
        semantics: The text after `semantics` in a file, such as `"matlab"`, or a `Semantics`.
        defuzzifier: The text after `defuzzifier` in a file, or a `Defuzzifier`; None for the centroid.
        activation: The text after `activation` in a file, such as `"highest(count=1)"`, or an `Activation`.
        guarantees: The texts after `require` in a file.
        conjunction, disjunction, implication, aggregation: Norms; None for those of the semantics.

    Raises:
        DiagnosticError: With all mistakes, as for a file but without places.
        ArgumentError: For an argument of a type that it cannot have.
    """
    parts = arguments.items_of("'variables'", (Input, Output, Let), "a list of inputs, lets and outputs", variables)
    norms: dict[str, str | None] = {"conjunction": conjunction, "disjunction": disjunction}
    norms |= {"implication": implication, "aggregation": aggregation}
    built = FuzzySystem(
        **values.texts(name=name, title=title, citation=citation),
        params=_params({} if params is None else params),
        hedges=_hedges({} if hedges is None else hedges),
        method=method_of(semantics, defuzzifier, activation, norms),
        inputs=tuple(v for v in parts if isinstance(v, Input)),
        outputs=tuple(v for v in parts if isinstance(v, Output)),
        blocks=_blocks(rules),
        guarantees=_guarantees(guarantees),
        lets=tuple(v for v in parts if isinstance(v, Let)),
    )
    require_as_file(built)
    return built


def _blocks(rules: object) -> tuple[Rule | RuleTable | RuleBlock, ...]:
    due = "a list of rules, tables, rule blocks and texts of rules"
    parts = arguments.items_of("'rules'", (Rule, RuleTable, RuleBlock, str), due, rules)
    kinds = [isinstance(r, RuleBlock) for r in parts]
    if kinds != sorted(kinds):
        raise ArgumentError("rules and tables of no rule block come before all rule blocks")
    return tuple(rule(r) if isinstance(r, str) else r for r in parts)


def _guarantees(guarantees: object) -> tuple[Guarantee, ...]:
    due = "a list of guarantees and texts of guarantees"
    parts = arguments.items_of("'guarantees'", (Guarantee, str), due, guarantees)
    return tuple(fragments.guarantee(g) if isinstance(g, str) else g for g in parts)


def _hedges(hedges: object) -> tuple[Hedge, ...]:
    texts = arguments.mapping("'hedges'", "expressions over x by name", hedges)
    return tuple(fragments.hedge(n, arguments.text(f"hedge {n!r}", t)) for n, t in texts.items())


def _params(params: object) -> tuple[Param, ...]:
    named = arguments.mapping("'params'", "values by name", params)
    return tuple(_param(n, v) for n, v in named.items())


def _param(name: str, default: object) -> Param:
    what = f"param {name!r}"
    if isinstance(default, tuple) and len(default) != 2:
        raise ArgumentError(f"{what} must be a value, or a value and its unit, got {len(default)} of them")
    value, unit = default if isinstance(default, tuple) else (default, "")
    return Param(name=name, expression=values.expression(what, value), unit=arguments.text(f"the unit of {what}", unit))
