"""Functions with named arguments: signals and measures of loops, plants of one line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Final

from fuzzyctl.expr import Call, Expr, Keyword, Number, Pair, Text
from fuzzyctl.records import record

#: The default of a setting that must be given.
NEEDED: Final = None


@record(frozen=True)
class Form:
    """A function with named arguments.

    Args:
        form: How it is written.
        what: Its result.
        signals: Names of the arguments that may use signals; all must be given.
        settings: Names of the arguments behind them, which depend on params only, with their defaults, a number or a
            text; NEEDED for those that must be given. Each argument may be given by name.
        pairs: Whether it takes pairs `TIME: VALUE`, one or more, in place of arguments.
        texts: Names of the settings that are texts.
        lists: Names of the settings that are lists.
    """

    form: str
    what: str
    signals: tuple[str, ...] = ()
    settings: Mapping[str, float | str | None] = field(default_factory=dict, hash=False)
    pairs: bool = False
    texts: tuple[str, ...] = ()
    lists: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """All arguments in order."""
        return (*self.signals, *self.settings)


def bound(form: Form, call: Call) -> dict[str, Expr]:
    """Return the arguments of a well-formed call by name, with the defaults of those not given; pairs are left out."""
    positional = [a for a in call.arguments if not isinstance(a, Keyword | Pair)]
    defaults = {n: _default(value) for n, value in form.settings.items() if value is not NEEDED}
    named = {a.name: a.value for a in call.arguments if isinstance(a, Keyword)}
    return {**defaults, **dict(zip(form.names, positional, strict=False)), **named}


def _default(value: float | str) -> Expr:
    return Text(value) if isinstance(value, str) else Number(value)


def pairs_of(call: Call) -> Sequence[Pair]:
    """Return the arguments `TIME: VALUE` of a call in order."""
    return [a for a in call.arguments if isinstance(a, Pair)]
