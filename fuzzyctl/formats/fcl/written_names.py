"""Identifiers of FCL: letters, digits and underscores, none of them reserved."""

from __future__ import annotations

import re
from typing import Final

from fuzzyctl.diagnostics.transliterate import in_ascii
from fuzzyctl.formats.fcl.names import (
    ACCUMULATION_WORDS,
    CONJUNCTION_WORDS,
    METHOD_WORDS,
    SHAPE_WORDS,
)
from fuzzyctl.formats.losses import Loss
from fuzzyctl.formulas import HEDGES
from fuzzyctl.model.system import FuzzySystem

#: Words that are no names in FCL; jFuzzyLogic takes none of them for one, wherever it stands.
RESERVED: Final = frozenset(
    {
        *("AND", "OR", "NOT", "IF", "THEN", "IS", "WITH", "RULE", "TERM", "RANGE", "METHOD", "ACCU", "ACT", "DEFAULT"),
        *("NC", "NAN", "INF", "INFINITY", "REAL", "LOCK", "ENABLED", "FUZZIFY", "DEFUZZIFY", "RULEBLOCK", "OPTIONS"),
        *("VAR", "VAR_INPUT", "VAR_OUTPUT", "FUNCTION_BLOCK", "EXP", "LN", "LOG", "SIN", "COS", "TAN", "ABS", "NONE"),
        *("END_VAR", "END_FUZZIFY", "END_DEFUZZIFY", "END_RULEBLOCK", "END_FUNCTION_BLOCK", "END_OPTIONS", "PI"),
        *CONJUNCTION_WORDS,
        *ACCUMULATION_WORDS,
        *METHOD_WORDS,
        *SHAPE_WORDS,
        *(h.upper() for h in HEDGES),
    }
)

_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


class WrittenNames:
    """What each name of a system becomes.

    Args:
        system: The system.

    Attributes:
        system: The name of the function block.
        variables: By their names.
        blocks: Rule blocks by their names.
        terms: By variable, then by term.
        losses: The names that were changed.
    """

    def __init__(self, system: FuzzySystem) -> None:
        self.losses: list[Loss] = []
        everything = (*system.inputs, *system.outputs)
        self.system = self._all(f"system '{system.name}'", [system.name])[system.name]
        self.variables = self._all("variable", [v.name for v in everything])
        self.blocks = self._all("rule block", [b.name for b in system.rule_blocks])
        self.terms = {v.name: self._all(f"variable '{v.name}'", [t.name for t in v.terms]) for v in everything}

    def _all(self, where: str, names: list[str]) -> dict[str, str]:
        """Return a name for each; those that can stay do, and names that differ in capitals only are told apart."""
        found: dict[str, str] = {}
        taken: set[str] = set()
        for name in sorted(names, key=lambda n: _plain(n) != n):
            plain, count = _plain(name), 1
            free = plain
            while free.upper() in taken:
                count += 1
                free = f"{plain}_{count}"
            taken.add(free.upper())
            found[name] = free
            if free != name:
                self.losses.append(Loss(where, f"the name '{name}'", f"it is called '{free}'", exact=True))
        return found


def _plain(name: str) -> str:
    if _NAME.fullmatch(name) and name.upper() not in RESERVED:
        return name
    found = re.sub(r"_+", "_", in_ascii(name)).strip("_") or "unnamed"
    if not found[0].isalpha():
        found = f"n_{found}"
    return f"{found}_" if found.upper() in RESERVED else found
