"""Valid identifiers for names from formats that allow any text as a name."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Collection, Iterable
from typing import Any, Final

from fuzzyctl.expr import CONSTANTS, FUNCTIONS, SOFT, Name, replace_names
from fuzzyctl.formats.common.report import Names
from fuzzyctl.formats.registry import Loss
from fuzzyctl.formulas import HEDGES
from fuzzyctl.model.rule import And, Cell, Consequent, Is, Not, Or, Rule, RuleBlock, RuleTable
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable, Membership, Term

#: Words that cannot be names in rules and expressions.
_RESERVED: Final = frozenset(
    {"and", "or", "not", "then", "is", "weight", "nan", "hold", *HEDGES, *CONSTANTS, *FUNCTIONS} - SOFT
)

_NAME: Final = re.compile(r"[^\W\d][\w\u0300-\u036f]*")

#: Longest name of a rule file.
_LONGEST: Final = 200


def with_identifiers(
    system: FuzzySystem, reserved: Collection[str] = (), of_variables: Collection[str] = ()
) -> tuple[FuzzySystem, list[Loss]]:
    """Return a system whose names are identifiers, and the names that changed.

    A renamed variable or system keeps its name as its label or title if that is empty. Titles, labels and units lose
    double quotes and line ends, which no string of a rule file can hold.

    Args:
        system: The system.
        reserved: Words besides those of rule files that are not names.
        of_variables: Further ones that are not names of variables.
    """
    fields: dict[str, Any] = {"title": _plain(system.title), "citation": _plain(system.citation)}
    for field in ("inputs", "outputs"):
        fields[field] = tuple(
            v.model_copy(update={"label": _plain(v.label), "unit": _plain(v.unit)}) for v in getattr(system, field)
        )
    soft = frozenset(of_variables) | (SOFT & {o.name for o in system.outputs})

    def spelt(name: str, where: str) -> str:
        return _spelt(name, {*reserved, *soft} if where == "variable" else reserved)

    return _with_names_and_labels(system.model_copy(update=fields), spelt)


def as_read(system: FuzzySystem) -> tuple[FuzzySystem, list[Loss]]:
    """Return a system of another tool's file whose names are identifiers, and the names that changed.

    Words of rules stay names, since calls may use them; see `with_identifiers`.
    """

    def spelt(name: str, where: str) -> str:
        return name if _is_name(name) and len(name) <= _LONGEST else _spelt(name, ())

    return _with_names_and_labels(system, spelt)


def name_before(name: str, label: str) -> str:
    """Return the name in the file that an identifier was made of: the label, if it leads to this identifier."""
    if not label or _is_name(label):
        return name
    spelling = _spelt(label, ())
    return label if name == spelling or name.removeprefix(f"{spelling}_").isdecimal() else name


def with_names(
    system: FuzzySystem, spelt: Callable[[str, str], str], fold: Callable[[str], str] = str
) -> tuple[FuzzySystem, list[Loss]]:
    """Return a system whose names a format can hold, and the names that changed.

    Args:
        system: The system.
        spelt: Makes a name that the format can hold of a name and its owner, such as `variable`.
        fold: Makes equal names of two that the format does not tell apart, such as a change of case.
    """
    names = _NewNames(system, spelt, fold)
    return (names.renamed(system) if names.losses else system), names.losses


def _with_names_and_labels(system: FuzzySystem, spelt: Callable[[str, str], str]) -> tuple[FuzzySystem, list[Loss]]:
    """Return a renamed system with the old names as labels and title, if these are empty."""
    named, losses = with_names(system, spelt)
    if not losses:
        return system, losses
    fields: dict[str, Any] = {
        field: tuple(
            n.model_copy(update={"label": o.label or (_plain(o.name) if n.name != o.name else "")})
            for o, n in zip(getattr(system, field), getattr(named, field), strict=True)
        )
        for field in ("inputs", "outputs")
    }
    fields["title"] = system.title or (_plain(system.name) if named.name != system.name else "")
    return named.model_copy(update=fields), losses


def _plain(text: str) -> str:
    """Return a text that a string of a rule file can hold."""
    lines = unicodedata.normalize("NFC", text).replace('"', "'").replace("\0", "")
    return " ".join(lines.split()) if re.search(r"[\r\n]", lines) else lines


def identifier(name: str, taken: Iterable[str] = (), reserved: Collection[str] = ()) -> str:
    """Return a name as an identifier that is not taken and no reserved word."""
    return Names(taken).take(_spelt(name, reserved))


def _spelt(name: str, reserved: Collection[str]) -> str:
    """Return a name as an identifier that is not a reserved word."""
    text = unicodedata.normalize("NFC", name)
    if not _is_name(text):
        text = "_".join("".join(c if _is_name(f"_{c}") else " " for c in text).replace("_", " ").split()) or "unnamed"
        text = text if _is_name(text) else f"_{text}"
    text = unicodedata.normalize("NFC", text[: _LONGEST - 8])
    return f"{text}_" if text in _RESERVED or text in reserved else text


def _is_name(text: str) -> bool:
    """Return whether both rule files and Python take a text for a name."""
    return text.isidentifier() and _NAME.fullmatch(text) is not None


class _NewNames:
    """The new name of each name; names that need no change keep theirs, and others make way for them."""

    def __init__(self, system: FuzzySystem, spelt: Callable[[str, str], str], fold: Callable[[str], str]) -> None:
        self.losses: list[Loss] = []
        self._spelt, self._fold = spelt, fold
        self.system = self._new(f"system '{system.name}'", [system.name])[system.name]
        variables = [*system.inputs, *system.outputs]
        self.variables = self._new("variable", [v.name for v in variables], [p.name for p in system.params])
        self.blocks = self._new("rule block", [b.name for b in system.rule_blocks])
        self.terms = {v.name: self._new(f"variable '{v.name}'", [t.name for t in v.terms]) for v in variables}
        self._names: dict[str, Any] = {old: Name(new) for old, new in self.variables.items() if old != new}

    def _new(self, where: str, names: list[str], others: Iterable[str] = ()) -> dict[str, str]:
        spelt = {n: self._spelt(n, where) for n in names}
        free, new = Names(others, self._fold), dict[str, str]()
        for name in sorted(names, key=lambda n: spelt[n] != n):
            new[name] = free.take(spelt[name])
            if new[name] != name:
                self.losses.append(Loss(where, f"the name '{name}'", f"it is called '{new[name]}'", exact=True))
        return new

    def renamed(self, node: Any) -> Any:
        """Return a system, or a part of it, with the new names."""
        return node.model_copy(update=self._fields(node))

    def _all(self, nodes: Iterable[Any]) -> tuple[Any, ...]:
        return tuple(map(self.renamed, nodes))

    def _fields(self, node: Any) -> dict[str, Any]:
        match node:
            case Is(variable=variable, term=term):
                return {"variable": self.variables[variable], "term": self.terms[variable][term]}
            case Not(operand=operand):
                return {"operand": self.renamed(operand)}
            case And(operands=operands) | Or(operands=operands):
                return {"operands": self._all(operands)}
            case Consequent(output=output, term=term):
                return {"output": self.variables[output], "term": self._consequent(output, term)}
            case Rule(antecedent=antecedent, consequents=consequents):
                return {"antecedent": self.renamed(antecedent), "consequents": self._all(consequents)}
            case RuleBlock(name=name, rules=rules):
                return {"name": self.blocks[name], "rules": self._all(rules)}
            case RuleTable():
                return self._fields_of_table(node)
            case Membership(arguments=arguments):
                return {"arguments": tuple(replace_names(a, self._names) for a in arguments)}
            case LinguisticVariable(name=name, terms=terms):
                update = {"name": self.variables[name], "terms": tuple(self._term(name, t) for t in terms)}
                rate = getattr(node, "adaptive", None)
                return update if rate is None else {**update, "adaptive": replace_names(rate, self._names)}
            case FuzzySystem():
                lists = {field: self._all(getattr(node, field)) for field in ("inputs", "outputs", "blocks")}
                return {"name": self.system, **lists}
        raise TypeError(type(node).__name__)

    def _term(self, variable: str, term: Term) -> Term:
        update = {"name": self.terms[variable][term.name], "membership": self.renamed(term.membership)}
        return term.model_copy(update=update)

    def _consequent(self, output: str, term: str | Membership) -> Any:
        return self.renamed(term) if isinstance(term, Membership) else self.terms[output][term]

    def _fields_of_table(self, table: RuleTable) -> dict[str, Any]:
        def cell(cell: Cell) -> Cell:
            terms = tuple(self._consequent(o, t) for o, t in zip(table.outputs, cell.terms, strict=False))
            return cell.model_copy(update={"terms": terms})

        rows, columns = table.rows, table.columns
        return {
            "outputs": tuple(self.variables[o] for o in table.outputs),
            "rows": None if rows is None else self.variables[rows],
            "columns": self.variables[columns],
            "row_terms": () if rows is None else tuple(self.terms[rows][t] for t in table.row_terms),
            "column_terms": tuple(self.terms[columns][t] for t in table.column_terms),
            "cells": tuple(tuple(map(cell, row)) for row in table.cells),
            "condition": None if table.condition is None else self.renamed(table.condition),
        }
