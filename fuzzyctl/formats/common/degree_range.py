"""Formulas of terms that leave [0, 1], which other tools compute with and fuzzyctl does not."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Final

from fuzzyctl.expr import Expr, ExprError, evaluate
from fuzzyctl.formats.common.report import Reporter
from fuzzyctl.model.variable import Term

#: Steps from end to end of a range at which formulas are evaluated.
_STEPS: Final = 100
#: Rounding may bring a degree so far beyond.
_SLACK: Final = 1e-12


def warn_of_degrees_beyond(
    terms: Iterable[Term],
    variable: str,
    ends: tuple[float, float],
    findings: Reporter,
    *,
    below: bool = True,
    params: Mapping[str, float] | None = None,
) -> None:
    """Warn of terms whose formula of the variable has some degree in the range that is no truth, each once.

    Args:
        terms: The terms of the variable.
        variable: Its name.
        ends: Its range; an infinite one is not looked at.
        findings: Where the warnings go.
        below: Whether degrees below 0 matter; the maximum of sets, which begins at 0, has none.
        params: Values of what else the formulas name.
    """
    low, high = ends
    if not math.isfinite(high - low):
        return
    places = [low + (high - low) * k / _STEPS for k in range(_STEPS + 1)]
    for term in terms:
        if term.membership.kind not in ("function", "formula"):
            continue
        formula = term.membership.arguments[0]
        degrees = ((x, _degree(formula, {**(params or {}), variable: x})) for x in places)
        least = -_SLACK if below else -math.inf
        outside = [(max(-y, y - 1.0), x, y) for x, y in degrees if y is not None and not least <= y <= 1.0 + _SLACK]
        if outside:
            _, x, y = max(outside)
            message = f"the degree of '{term.name}' is {y:.6g} at {variable} = {x:.6g}, and held within [0, 1] here"
            help_text = "other tools go on with it as it is; scale the formula, or clip it there, too"
            findings.warning("FZ609", message, term.membership.span or term.span, help=help_text)


def _degree(formula: Expr, names: Mapping[str, float]) -> float | None:
    try:
        return evaluate(formula, names)
    except ExprError:  # no value there
        return None
