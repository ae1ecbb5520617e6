"""Errors of lines that parse but are written for another tool: words, parameter counts, rules."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.other_tools import known_kind, known_setting

#: Words that are no hedges unless a file declares them: an antecedent or a consequent has run on.
_RUN_ON: Final = frozenset({"is", "unless", "else"})


def foreign(node: Any, text: str) -> Diagnostic | None:
    """Return the mistake of a line that has been read and that only another tool writes so; None for all valid lines.

    Args:
        node: The line.
        text: The text of the whole file.
    """
    match node:
        case sx.TermLine(kind=kind, arguments=arguments):
            return _odd_term(kind, arguments)
        case sx.Setting(keyword=keyword, value=value) | sx.Activation(keyword=keyword, kind=value):
            meant = known_setting(keyword.text, value.text)
            return None if meant is None else Diagnostic("FZ213", f"'{value.text}' is '{meant}' here", value.span)
        case sx.Variable(clauses=clauses):
            settings = (foreign(c.setting, text) for c in clauses if isinstance(c, sx.SettingClause))
            return next((d for d in settings if d is not None), None)
        case sx.Rule(antecedent=antecedent, consequents=consequents):
            words = [*_hedges(antecedent), *(h for c in consequents for h in c.hedges)]
            odd = next((w for w in words if _runs_on(w.text, text)), None)
            return None if odd is None else Diagnostic("FZ102", f"unexpected '{odd.text}'", odd.span)
    return None


def _odd_term(kind: sx.Word, arguments: tuple[sx.Argument, ...]) -> Diagnostic | None:
    formula = MEMBERSHIP.get(kind.text)
    if formula is None:
        is_other = kind.text not in ("linear", "function") and known_kind(kind.text) is not None
        return Diagnostic("FZ202", f"no membership function '{kind.text}'", kind.span) if is_other else None
    due, given = len(formula.parameters), sum(a.keyword is None for a in arguments)
    if not formula.variadic and (given > due or len(arguments) < due):
        return Diagnostic("FZ303", f"'{kind.text}' takes {due} parameters", kind.span)
    return None


def _runs_on(hedge: str, text: str) -> bool:
    return hedge.lower() in _RUN_ON and not re.search(rf"(?m)^[ \t]*hedge[ \t]+{hedge}\b", text)


def _hedges(truth: sx.Truth) -> Iterator[sx.Word]:
    match truth:
        case sx.Literal(hedges=hedges):
            yield from hedges
        case sx.Negation(operand=operand) | sx.Group(operand=operand):
            yield from _hedges(operand)
        case sx.Chain(operands=operands):
            for operand in operands:
                yield from _hedges(operand)
