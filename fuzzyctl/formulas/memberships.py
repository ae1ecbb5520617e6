"""Registry of membership functions of rule files, with the variants that other tools compute."""

from __future__ import annotations

from typing import Final, Literal

from fuzzyctl.formulas import PIECEWISE, SINGLETONS
from fuzzyctl.formulas.bells import BELLS
from fuzzyctl.formulas.curves import CURVES
from fuzzyctl.formulas.formula import MembershipFormula
from fuzzyctl.formulas.sigmoids import CLAMPED_DIFFERENCE, SIGMOIDS
from fuzzyctl.formulas.splines import SPLINES
from fuzzyctl.formulas.trapezoids import TRAPEZOIDS

MembershipKind = Literal[
    "triangle",
    "trapezoid",
    "rectangle",
    "ramp",
    "piecewise",
    "gaussian",
    "gaussian2",
    "bell",
    "sigmoid",
    "sigmoid_difference",
    "sigmoid_product",
    "s_shape",
    "z_shape",
    "pi_shape",
    "cosine",
    "spike",
    "concave",
    "arc",
    "semi_ellipse",
    "singleton",
    "constant",
]
#: The kinds of membership functions by name, in the order of the reference.
MEMBERSHIP: Final[dict[str, MembershipFormula]] = {
    f.name: f for f in (*TRAPEZOIDS, PIECEWISE, *BELLS, *SIGMOIDS, *SPLINES, *CURVES, *SINGLETONS)
}

#: Functions as other tools compute them, by the kind that rule files write and by the difference.
VARIANTS: Final[dict[str, MembershipFormula]] = {"sigmoid_difference clamped": CLAMPED_DIFFERENCE}


def formula_of(kind: str) -> MembershipFormula:
    """Return the formula of a membership function or a variant of one."""
    return VARIANTS[kind] if kind in VARIANTS else MEMBERSHIP[kind]
