"""A system as a Python module that builds it with `fuzzyctl.building.build`."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Final

from fuzzyctl.expr import ONE, Expr, Name, Negate, Number, replace_names, to_text
from fuzzyctl.formats.fz import (
    antecedent_text,
    block_settings,
    cell_text,
    defuzzifier_text,
    dumps,
    membership_text,
    method_lines,
    otherwise_text,
    rule_text,
)
from fuzzyctl.formats.fz_strings import guarantee_text
from fuzzyctl.loading.load import loads
from fuzzyctl.model.method import Method
from fuzzyctl.model.rule import Cell, Rule, RuleBlock, RuleTable
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import ANYWHERE, Input, Let, LinguisticVariable, Output

#: Names in the builder of settings that files call otherwise.
KEYWORDS: Final = {"and": "conjunction", "or": "disjunction"}

#: Longest line before arguments get lines of their own.
WIDTH: Final = 110


def module_text(system: FuzzySystem) -> str:
    """Return a Python module whose `system` means the same as a system that a rule file could hold.

    Args:
        system: A system whose names are identifiers.

    Raises:
        DiagnosticError: For a system that no rule file can hold; the builder has the checks of files.
    """
    loads(dumps(system))
    return "\n".join(_lines(system)) + "\n"


def _lines(system: FuzzySystem) -> Iterator[str]:
    title = f"{system.name}: {system.title}" if system.title else system.name
    yield f'"""{_docstring(title)}"""'
    yield ""
    text = "\n".join([*_variables(system), *_system(system)])
    yield "from fuzzyctl import build"
    yield ""
    yield text


def _docstring(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"""', "'''").rstrip('"')


def _variables(system: FuzzySystem) -> Iterator[str]:
    yield "inputs = ["
    for v in system.inputs:
        yield from _indented(_call("build.input_variable", _variable(v)) + ",")
    yield "]"
    if system.lets:
        yield "lets = ["
        for let in system.lets:
            yield from _indented(_call("build.let_variable", _let(let)) + ",")
        yield "]"
    yield "outputs = ["
    for o in system.outputs:
        yield from _indented(_call("build.output_variable", _variable(o)) + ",")
    yield "]"


def _let(v: Let) -> list[str]:
    is_ranged = (v.lower, v.upper) != ANYWHERE
    arguments = [_value(v.lower), _value(v.upper), *_described(v)] if is_ranged else _described(v)[1:]
    return [_text(v.name), _value(v.value), *arguments]


def _variable(v: LinguisticVariable) -> list[str]:
    arguments = [_text(v.name), _value(v.lower), _value(v.upper), *_described(v)]
    match v:
        case Input(extrapolate=True):
            arguments.append("extrapolate=True")
        case Output():
            arguments += _output(v)
    return arguments


def _described(v: LinguisticVariable) -> list[str]:
    """Return the terms of a variable as an argument, then its label and unit."""
    terms = [f"{_text(t.name)}: {_text(membership_text(t.membership))}" for t in v.terms]
    named = [f"{name}={_text(getattr(v, name))}" for name in ("label", "unit") if getattr(v, name)]
    return [_bracketed("{", terms, "}"), *named]


def _output(o: Output) -> list[str]:
    arguments = []
    if o.value is not None:
        return [f"value={_value(o.value)}", *(["clamp=True"] if o.clamped else [])]
    if o.otherwise is not None:
        value = _value(o.otherwise) if isinstance(o.otherwise, Expr) else _text(otherwise_text(o.otherwise))
        arguments.append(f"otherwise={value}")
    if o.adaptive is not None:
        arguments.append(f"adaptive={_text(to_text(o.adaptive))}")
    if o.clamped:
        arguments.append("clamp=True")
    arguments += [f"{n}={_text(getattr(o, n))}" for n in ("implication", "aggregation") if getattr(o, n) is not None]
    if o.defuzzifier is not None:
        arguments.append(f"defuzzifier={_text(defuzzifier_text(o.defuzzifier))}")
    return arguments


def _system(system: FuzzySystem) -> Iterator[str]:
    yield "rules = ["
    for block in system.blocks:
        yield from _indented(_block(block) + ",")
    yield "]"
    arguments = [_text(system.name), "[*inputs, *lets, *outputs]" if system.lets else "[*inputs, *outputs]", "rules"]
    if system.params:
        params = [
            f"{_text(p.name)}: ({_value(p.expression)}, {_text(p.unit)})"
            if p.unit
            else f"{_text(p.name)}: {_value(p.expression)}"
            for p in system.params
        ]
        arguments.append("params=" + _bracketed("{", params, "}"))
    if system.hedges:
        hedges = [f"{_text(h.name)}: {_text(_hedge(h.parameter, h.expression))}" for h in system.hedges]
        arguments.append("hedges=" + _bracketed("{", hedges, "}"))
    arguments += [f"{name}={_text(getattr(system, name))}" for name in ("title", "citation") if getattr(system, name)]
    arguments += _method(system.method)
    if system.guarantees:
        arguments.append("guarantees=" + _bracketed("[", [_text(guarantee_text(g)) for g in system.guarantees], "]"))
    yield _call("system = build.system", arguments)


def _hedge(parameter: str, expression: Expr) -> str:
    return to_text(replace_names(expression, {parameter: Name("x")}))


def _method(method: Method) -> list[str]:
    """Return the settings as a file has them, as keyword arguments."""
    settings = [line.split(maxsplit=1) for line in method_lines(method)]
    return [f"{KEYWORDS.get(keyword, keyword)}={_text(text)}" for keyword, text in settings]


def _block(block: Rule | RuleTable | RuleBlock) -> str:
    match block:
        case RuleTable():
            return _call("build.rule_table", _table(block))
        case RuleBlock():
            settings = [f"{KEYWORDS.get(keyword, keyword)}={_text(text)}" for keyword, text in block_settings(block)]
            rules = "[\n" + "\n".join(line for part in block.rules for line in _indented(_block(part) + ",")) + "\n]"
            return _call("build.rule_block", [_text(block.name), rules, *settings])
    return _text(rule_text(block))


def _table(table: RuleTable) -> list[str]:
    outputs = (
        _text(table.outputs[0]) if len(table.outputs) == 1 else _bracketed("[", [_text(o) for o in table.outputs], "]")
    )
    condition = [] if table.condition is None else [f"condition={_text(antecedent_text(table.condition, top=True))}"]
    if table.rows is None:
        cells = [f"{_text(t)}: {_cell(c)}" for t, c in zip(table.column_terms, table.cells[0], strict=True)]
        return [outputs, _text(table.columns), _bracketed("{", cells, "}"), *condition]
    rows = [f"{_text(t)}: {_row(row)}" for t, row in zip(table.row_terms, table.cells, strict=True)]
    head = f"headers={_text(' '.join(table.column_terms))}"
    return [outputs, _text(table.rows), _bracketed("{", rows, "}"), _text(table.columns), head, *condition]


def _row(row: Sequence[Cell]) -> str:
    return _text(" ".join(cell_text(c) for c in row))


def _cell(cell: Cell) -> str:
    return "None" if not cell.terms and cell.weight == ONE else _text(cell_text(cell))


def _text(text: str) -> str:
    """Return a text as a Python literal in double quotes; JSON's escapes are Python's too."""
    return json.dumps(text, ensure_ascii=False)


def _value(expr: Expr) -> str:
    match expr:
        case Number(value=value):
            return (
                repr(int(value)) if value == int(value) and abs(value) < 1e15 and str(value) != "-0.0" else repr(value)
            )
        case Negate(operand=Number()):
            return f"-{_value(expr.operand)}"
    return _text(to_text(expr))


def _bracketed(left: str, items: Sequence[str], right: str) -> str:
    line = f"{left}{', '.join(items)}{right}"
    if len(line) <= WIDTH - 20:
        return line
    inner = "\n".join(f"    {line}" for item in items for line in f"{item},".split("\n"))
    return f"{left}\n{inner}\n{right}"


def _call(function: str, arguments: Sequence[str]) -> str:
    line = f"{function}({', '.join(arguments)})"
    if len(line) <= WIDTH - 4 and "\n" not in line:
        return line
    inner = "\n".join(f"    {line}" for argument in arguments for line in f"{argument},".split("\n"))
    return f"{function}(\n{inner}\n)"


def _indented(text: str) -> Iterator[str]:
    yield from (f"    {line}" for line in text.split("\n"))
