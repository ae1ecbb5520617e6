"""Valid identifiers for names from formats that allow any text as a name."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Collection, Iterable
from typing import Any, Final

from fuzzyctl.expr import CONSTANTS, FUNCTIONS, SOFT, Name, replace_names
from fuzzyctl.formats.registry import Loss
from fuzzyctl.formulas import HEDGES
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule, RuleBlock, RuleTable
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable, Membership

#: Words that cannot be names where rules and expressions name things.
_RESERVED: Final = frozenset(
    {"and", "or", "not", "then", "is", "weight", "nan", "hold", *HEDGES, *CONSTANTS, *FUNCTIONS} - SOFT
)

_NAME: Final = re.compile(r"[^\W\d][\w\u0300-\u036f]*")

#: Longest name of a rule file.
_LONGEST: Final = 200


def with_identifiers(
    system: FuzzySystem, reserved: Collection[str] = (), of_variables: Collection[str] = ()
) -> tuple[FuzzySystem, list[Loss]]:
    """Return a system whose names are identifiers, and which names were changed.

    What is called otherwise keeps its name as its label or title where it has none of its own. Titles, labels and units
    lose double quotes and line ends, which no string of a rule file can hold.

    Args:
        system: The system.
        reserved: Words besides those of rule files that are no names.
        of_variables: Further ones that are no names of variables.
    """
    system = _with_plain_texts(system)
    soft = frozenset(of_variables) | (SOFT & {o.name for o in system.outputs})

    def spelt(name: str, where: str) -> str:
        return _spelt(name, {*reserved, *soft} if where == "variable" else reserved)

    return _keeping_names(system, *with_names(system, spelt))


def as_read(system: FuzzySystem) -> tuple[FuzzySystem, list[Loss]]:
    """Return a system of another tool's file whose names are identifiers, and which names were changed.

    Words of rules stay names, since calls may use them; see `with_identifiers`.
    """

    def spelt(name: str, where: str) -> str:
        return name if _is_name(name) and len(name) <= _LONGEST else _spelt(name, ())

    return _keeping_names(system, *with_names(system, spelt))


def name_before(name: str, label: str) -> str:
    """Return the name that a file had in place of an identifier: the label, if the identifier was made of it."""
    if not label or _is_name(label):
        return name
    made = _spelt(label, ())
    return label if name == made or name.removeprefix(f"{made}_").isdecimal() else name


def _keeping_names(system: FuzzySystem, named: FuzzySystem, losses: list[Loss]) -> tuple[FuzzySystem, list[Loss]]:
    """Return a renamed system with the names that variables and it had as labels and title, if these are empty."""
    if not losses:
        return system, losses
    kept = {
        field: tuple(
            n.model_copy(update={"label": o.label or (_plain(o.name) if n.name != o.name else "")})
            for o, n in zip(getattr(system, field), getattr(named, field), strict=True)
        )
        for field in ("inputs", "outputs")
    }
    title = system.title or (_plain(system.name) if named.name != system.name else "")
    return named.model_copy(update={"title": title, **kept}), losses


def with_names(
    system: FuzzySystem, spelt: Callable[[str, str], str], fold: Callable[[str], str] = str
) -> tuple[FuzzySystem, list[Loss]]:
    """Return a system whose names a format can hold, and which names were changed.

    Args:
        system: The system.
        spelt: Makes of a name one that the format can hold; gets what has the name, too.
        fold: What makes two names one, such as a change of case.
    """
    changed = _Names(system, spelt, fold)
    if not changed.losses:
        return system, []
    update: dict[str, Any] = {
        "name": changed.system,
        "inputs": tuple(changed.variable(v) for v in system.inputs),
        "outputs": tuple(changed.variable(v) for v in system.outputs),
        "blocks": tuple(changed.block(b) for b in system.blocks),
    }
    return system.model_copy(update=update), changed.losses


def _with_plain_texts(system: FuzzySystem) -> FuzzySystem:
    variables = {
        field: tuple(
            v.model_copy(update={"label": _plain(v.label), "unit": _plain(v.unit)}) for v in getattr(system, field)
        )
        for field in ("inputs", "outputs")
    }
    texts = {"title": _plain(system.title), "citation": _plain(system.citation)}
    return system.model_copy(update={**variables, **texts})


def _plain(text: str) -> str:
    """Return a text that a string of a rule file can hold."""
    lines = unicodedata.normalize("NFC", text).replace('"', "'").replace("\0", "")
    return " ".join(lines.split()) if re.search(r"[\r\n]", lines) else lines


def identifier(name: str, taken: Iterable[str] = (), reserved: Collection[str] = ()) -> str:
    """Return a name as an identifier that is none of those taken, and no reserved word."""
    return _free(_spelt(name, reserved), set(taken), str)


def _spelt(name: str, reserved: Collection[str]) -> str:
    """Return a name as an identifier that is no reserved word."""
    text = unicodedata.normalize("NFC", name)
    found = text
    if not _is_name(text):
        found = "_".join("".join(c if _is_name(f"_{c}") else " " for c in text).replace("_", " ").split()) or "unnamed"
        found = found if _is_name(found) else f"_{found}"
    found = unicodedata.normalize("NFC", found[: _LONGEST - 8])
    return f"{found}_" if found in _RESERVED or found in reserved else found


def _free(name: str, taken: Collection[str], fold: Callable[[str], str]) -> str:
    """Return a name, with the first free number behind it if it is taken."""
    found, number = name, 1
    while fold(found) in taken:
        number += 1
        found = f"{name}_{number}"
    return found


def _is_name(text: str) -> bool:
    """Return whether both rule files and Python take a text for a name."""
    return text.isidentifier() and _NAME.fullmatch(text) is not None


class _Names:
    """What each name becomes; names that need no change keep theirs, and others make way for them."""

    def __init__(self, system: FuzzySystem, spelt: Callable[[str, str], str], fold: Callable[[str], str]) -> None:
        self.losses: list[Loss] = []
        self._spelt, self._fold = spelt, fold
        self.system = self._renamed(f"system '{system.name}'", [system.name])[system.name]
        variables = [*system.inputs, *system.outputs]
        self.variables = self._renamed("variable", [v.name for v in variables], [p.name for p in system.params])
        self.blocks = self._renamed("rule block", [b.name for b in system.rule_blocks])
        self.terms = {v.name: self._renamed(f"variable '{v.name}'", [t.name for t in v.terms]) for v in variables}

    def _renamed(self, where: str, names: list[str], others: Iterable[str] = ()) -> dict[str, str]:
        spelt = {n: self._spelt(n, where) for n in names}
        found: dict[str, str] = {}
        taken = set(map(self._fold, others))
        for name in sorted(names, key=lambda n: spelt[n] != n):
            found[name] = _free(spelt[name], taken, self._fold)
            taken.add(self._fold(found[name]))
            if found[name] != name:
                why = f"it is called '{found[name]}'"
                self.losses.append(Loss(where, f"the name '{name}'", why, exact=True))
        return found

    def variable(self, v: Any) -> Any:
        terms = tuple(
            t.model_copy(update={"name": self.terms[v.name][t.name], "membership": self.membership(t.membership)})
            for t in v.terms
        )
        update: dict[str, Any] = {"name": self.variables[v.name], "terms": terms}
        if getattr(v, "adaptive", None) is not None:
            update["adaptive"] = replace_names(v.adaptive, self._expressions())
        assert isinstance(v, LinguisticVariable)
        return v.model_copy(update=update)

    def membership(self, m: Membership) -> Membership:
        return m.model_copy(update={"arguments": tuple(replace_names(a, self._expressions()) for a in m.arguments)})

    def _expressions(self) -> dict[str, Any]:
        return {old: Name(new) for old, new in self.variables.items() if old != new}

    def block(self, block: Rule | RuleTable | RuleBlock) -> Rule | RuleTable | RuleBlock:
        if not isinstance(block, RuleBlock):
            return self._part(block)
        return block.model_copy(
            update={"name": self.blocks[block.name], "rules": tuple(self._part(p) for p in block.rules)}
        )

    def _part(self, block: Rule | RuleTable) -> Rule | RuleTable:
        if isinstance(block, Rule):
            consequents = tuple(
                c.model_copy(update={"output": self.variables[c.output], "term": self._consequent(c.output, c.term)})
                for c in block.consequents
            )
            return block.model_copy(
                update={"antecedent": self.antecedent(block.antecedent), "consequents": consequents}
            )
        return self._table(block)

    def _table(self, table: RuleTable) -> RuleTable:
        rows = None if table.rows is None else self.variables[table.rows]
        cells = tuple(
            tuple(
                c.model_copy(
                    update={
                        "terms": tuple(self._consequent(o, t) for o, t in zip(table.outputs, c.terms, strict=False))
                    }
                )
                for c in row
            )
            for row in table.cells
        )
        update = {
            "outputs": tuple(self.variables[o] for o in table.outputs),
            "rows": rows,
            "columns": self.variables[table.columns],
            "row_terms": tuple(self.terms[table.rows][t] for t in table.row_terms) if table.rows is not None else (),
            "column_terms": tuple(self.terms[table.columns][t] for t in table.column_terms),
            "cells": cells,
            "condition": None if table.condition is None else self.antecedent(table.condition),
        }
        return table.model_copy(update=update)

    def _consequent(self, output: str, term: str | Membership) -> str | Membership:
        return self.membership(term) if isinstance(term, Membership) else self.terms[output][term]

    def antecedent(self, antecedent: Antecedent) -> Antecedent:
        match antecedent:
            case Is(variable=variable, term=term):
                return antecedent.model_copy(
                    update={"variable": self.variables[variable], "term": self.terms[variable][term]}
                )
            case Not(operand=operand):
                return antecedent.model_copy(update={"operand": self.antecedent(operand)})
            case And(operands=operands) | Or(operands=operands):
                return antecedent.model_copy(update={"operands": tuple(map(self.antecedent, operands))})
        raise TypeError(type(antecedent).__name__)
