"""Words of the language with their form and meaning, for completion, hover and signatures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from fuzzyctl import expr as ex
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.formulas.hedges import HEDGES
from fuzzyctl.lang.mistakes import BLOCK_FORMS, FORMS, LET_FORM
from fuzzyctl.lang.syntax import BLOCKS, STATEMENT_KEYWORDS
from fuzzyctl.model.measures import MEASURES
from fuzzyctl.model.plant_forms import PLANTS
from fuzzyctl.model.signals import SIGNALS
from fuzzyctl.model.stateful_operators import OPERATORS


@dataclass(frozen=True)
class LanguageWord:
    """A word of the language.

    Args:
        name: The word.
        kind: "keyword", "membership function", "function", "operator", "signal", "measure", "plant" or "hedge".
        form: How it is written.
        what: What it means, one sentence; may be empty.
    """

    name: str
    kind: str
    form: str
    what: str = ""


def memberships() -> Iterator[LanguageWord]:
    """Yield the membership functions."""
    for name, formula in MEMBERSHIP.items():
        more = ", ..." if formula.variadic else ""
        form = f"{name}({', '.join(formula.parameters)}{more})"
        yield LanguageWord(name, "membership function", form, formula.summary)


def functions(block: str) -> Iterator[LanguageWord]:
    """Yield what an expression of a system, controller, plant or loop may call."""
    for name, (low, high) in ex.FUNCTIONS.items():
        names = ", ".join("xyz"[:low]) + (", ..." if high is None else "")
        yield LanguageWord(name, "function", f"{name}({names})")
    if block:
        yield LanguageWord("clamp", "function", "clamp(x, low, high)", "x, kept from low to high")
        yield LanguageWord("where", "function", "where(condition, x, y)", "x where the condition holds, else y")
    if block == "controller":
        for name, operator in OPERATORS.items():
            yield LanguageWord(name, "operator", operator.form, operator.what)
    if block == "loop":
        for name, form in SIGNALS.items():
            yield LanguageWord(name, "signal", form.form, form.what)


def measures() -> Iterator[LanguageWord]:
    """Yield the measures of loops."""
    for name, form in MEASURES.items():
        yield LanguageWord(name, "measure", form.form, form.what)


def plants() -> Iterator[LanguageWord]:
    """Yield the plants of one line."""
    for name, form in PLANTS.items():
        yield LanguageWord(name, "plant", form.form, form.what)


def keywords(block: str) -> Iterator[LanguageWord]:
    """Yield the words that begin a statement of a block, the empty one being a system."""
    forms = BLOCK_FORMS if block else FORMS
    for name in BLOCKS[block] if block else (*STATEMENT_KEYWORDS, "let"):
        form = LET_FORM if name == "let" and not block else forms.get(name, FORMS.get(name, name))
        yield LanguageWord(name, "keyword", form)


def hedges() -> Iterator[LanguageWord]:
    """Yield the hedges that need no declaration."""
    for name in HEDGES:
        yield LanguageWord(name, "hedge", f"VARIABLE is {name} TERM")


@cache
def called(block: str) -> dict[str, LanguageWord]:
    """Return all that may stand before an opening parenthesis in a block, by name."""
    words = [*memberships(), *plants(), *(measures() if block == "loop" else ()), *functions(block)]
    return {w.name: w for w in words}
