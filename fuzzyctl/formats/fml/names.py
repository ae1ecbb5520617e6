"""Vocabulary of FML, with the names used here."""

from __future__ import annotations

from typing import Final

#: Methods for AND and for activation; the schema calls two of them as their conorms.
CONJUNCTION_WORDS: Final[dict[str, str]] = {
    "MIN": "min",
    "PROD": "product",
    "BDIF": "bounded_difference",
    "BSUM": "bounded_difference",
    "DRP": "drastic_product",
    "DRS": "drastic_product",
    "EPROD": "einstein_product",
    "HPROD": "hamacher_product",
    "NILMIN": "nilpotent_minimum",
}

#: Methods for OR, and those for accumulation but one.
DISJUNCTION_WORDS: Final[dict[str, str]] = {
    "MAX": "max",
    "PROBOR": "probabilistic_sum",
    "BSUM": "bounded_sum",
    "DRS": "drastic_sum",
    "ESUM": "einstein_sum",
    "HSUM": "hamacher_sum",
    "NILMAX": "nilpotent_maximum",
}

#: Methods for accumulation; drafts have the plain sum, too.
ACCUMULATION_WORDS: Final = {**DISJUNCTION_WORDS, "SUM": "sum"}

#: Defuzzifiers; MM as in FCL stands in older files.
DEFUZZIFIER_WORDS: Final[dict[str, str]] = {
    "COG": "centroid",
    "COA": "bisector",
    "LM": "som",
    "RM": "lom",
    "MOM": "mom",
    "MM": "mom",
}

#: Modifiers that are hedges here; `intensify` is what the hedge `extremely` is in its usual meaning, while the
#: standard's `extremely` is the cube.
MODIFIERS: Final[dict[str, str]] = {
    "any": "any",
    "extremely": "extremely",
    "intensify": "extremely",
    "more_or_less": "slightly",
    "not": "not",
    "seldom": "seldom",
    "somewhat": "somewhat",
    "very": "very",
}

#: Shapes with the number of their parameters.
SHAPES: Final[dict[str, int]] = {
    "triangularshape": 3,
    "trapezoidshape": 4,
    "trapezoidalshape": 4,
    "gaussianshape": 2,
    "leftgaussianshape": 2,
    "rightgaussianshape": 2,
    "leftlinearshape": 2,
    "rightlinearshape": 2,
    "pishape": 2,
    "zshape": 2,
    "sshape": 2,
    "rectangularshape": 2,
    "singletonshape": 1,
}

#: Shapes that are points.
POINT_SETS: Final = ("pointsetshape", "pointsetmonotonicshape", "usershape", "pointsshape")

#: All shapes as the standard spells them, for messages.
SHAPE_TAGS: Final = (
    *("triangularShape", "trapezoidShape", "gaussianShape", "leftGaussianShape", "rightGaussianShape"),
    *("leftLinearShape", "rightLinearShape", "piShape", "zShape", "sShape", "rectangularShape", "singletonShape"),
    *("pointSetShape", "circularDefinition"),
)
