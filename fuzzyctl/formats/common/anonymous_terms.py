"""Names for consequents without one, in formats whose rules name terms only."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Membership


def unnamed_terms(
    system: FuzzySystem, output: str, names: Iterable[str], *, fold: Callable[[str], str] = str
) -> dict[str, Membership]:
    """Return the consequents of an output that are no terms of it, each once, by names that are free.

    Args:
        system: The system whose rules are written.
        output: Name of the output.
        names: Names that its terms have in the file.
        fold: What makes two names one, such as a change of case.
    """
    taken = set(map(fold, names))
    found: dict[str, Membership] = {}
    for rule in system.rules:
        for c in rule.consequents:
            if c.output == output and isinstance(c.term, Membership) and c.term not in found.values():
                number = len(found) + 1
                while fold(f"c{number}") in taken:
                    number += 1
                taken.add(fold(f"c{number}"))
                found[f"c{number}"] = c.term
    return found
