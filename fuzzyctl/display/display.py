"""Which module shows which type: `html` for notebooks, `text` for `print`, `line` for the `repr` of parts."""

from __future__ import annotations

from importlib import import_module
from typing import Final

from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.expr import to_text
from fuzzyctl.formats.fz import antecedent_text, block_text, membership_text, method_lines, rule_text
from fuzzyctl.formats.fz_strings import bounds_text, guarantee_text
from fuzzyctl.model.block import Guarantee, Hedge, Node, Param
from fuzzyctl.model.controller import Definition, Signal
from fuzzyctl.model.loop import Varied
from fuzzyctl.model.method import Method
from fuzzyctl.model.rule import Antecedent, Rule, RuleBlock, RuleTable, rule_count
from fuzzyctl.model.variable import ANYWHERE, Let, LinguisticVariable, Membership, Term

#: Module and prefix of the functions by the name of the type, so that no type is loaded to show another one.
_PRESENTERS: Final = {
    "BlockTrace": "traces.trace",
    "Controller": "systems.block",
    "Experiment": "notebook.experiment",
    "FuzzySystem": "systems.system",
    "Kernel": "notebook.kernel",
    "Loop": "systems.block",
    "Panels": "notebook.plot",
    "Plant": "systems.block",
    "Plot": "notebook.plot",
    "Plot3D": "notebook.plot",
    "Proved": "notebook.verdict",
    "Refuted": "notebook.verdict",
    "Run": "notebook.run",
    "Trace": "traces.trace",
    "Undecided": "notebook.verdict",
    "Verdicts": "notebook.verdict",
}


def html(value: object) -> str:
    """Return an object of these types as HTML for a notebook."""
    return _presented(value, "html")


def text(value: object) -> str:
    """Return an object of these types as text for `print`, without a line end."""
    return _presented(value, "text").removesuffix("\n")


def line(part: Node) -> str:
    """Return the `repr` of a part of a system."""
    return printable(f"{type(part).__name__}({_part(part)})")


def _presented(value: object, form: str) -> str:
    name = next(kind.__name__ for kind in type(value).__mro__ if kind.__name__ in _PRESENTERS)
    module, _, prefix = _PRESENTERS[name].partition(".")
    text: str = getattr(import_module(f"fuzzyctl.display.{module}"), f"{prefix}_{form}")(value)
    return text


def _part(part: Node) -> str:
    """Return the text of a part without its type: `food in [0, 10]: rancid, delicious`."""
    match part:
        case LinguisticVariable():
            return _variable(part)
        case Term(name=name, membership=membership):
            return f"{name} = {membership_text(membership)}"
        case Membership():
            return membership_text(part)
        case Rule():
            return rule_text(part)
        case RuleTable():
            across = part.columns if part.rows is None else f"{part.rows} x {part.columns}"
            return f"{', '.join(part.outputs)} = {across}; {counted(part.rule_count, 'rule')}"
        case RuleBlock():
            return f"{block_text(part).removeprefix('rules ')}; {counted(sum(map(rule_count, part.rules)), 'rule')}"
        case Antecedent():
            return antecedent_text(part, top=True)
        case Param(name=name, expression=expression, unit=unit):
            return f"{name} = {to_text(expression)}{unit and ' ' + unit}"
        case Hedge(name=name, parameter=parameter, expression=expression):
            return f"{name}({parameter}) = {to_text(expression)}"
        case Guarantee():
            return guarantee_text(part)
        case Method():
            return ", ".join(method_lines(part)) or "exact"
        case Definition(name=name, value=value):
            return f"{name} = {to_text(value)}"
        case Varied(name=name, bounds=bounds):
            return f"{name}{bounds_text(bounds)}"
        case Signal():
            return f"{part.name}{bounds_text(part.bounds)}{part.unit and ' ' + part.unit}"
    raise TypeError(type(part).__name__)


def _variable(variable: LinguisticVariable) -> str:
    value = f" = {to_text(variable.value)}" if isinstance(variable, Let) else ""
    ends = (variable.lower, variable.upper)
    inside = "" if ends == ANYWHERE else f" in [{', '.join(map(to_text, ends))}]"
    terms = ", ".join(t.name for t in variable.terms)
    return f"{variable.name}{inside}{variable.unit and ' ' + variable.unit}{value}{terms and ': ' + terms}"
