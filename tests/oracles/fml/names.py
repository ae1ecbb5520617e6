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

#: Shapes as the standard spells them, with their kinds and the number of their parameters; drafts have another word for
#: a trapezoid. What a shape without a kind is depends on who wrote the document.
TAGGED_SHAPES: Final = (
    ("triangularShape", "triangle", 3),
    ("trapezoidShape", "trapezoid", 4),
    ("gaussianShape", "gaussian", 2),
    ("leftGaussianShape", None, 2),
    ("rightGaussianShape", None, 2),
    ("leftLinearShape", None, 2),
    ("rightLinearShape", None, 2),
    ("piShape", None, 2),
    ("zShape", "z_shape", 2),
    ("sShape", "s_shape", 2),
    ("rectangularShape", "rectangle", 2),
    ("singletonShape", "singleton", 1),
)
_DRAFTS: Final = (("trapezoidalShape", "trapezoid", 4),)

#: Kinds and numbers of parameters by the names of shapes in small letters.
SHAPES: Final = {tag.lower(): (kind, count) for tag, kind, count in (*TAGGED_SHAPES, *_DRAFTS)}

#: Shapes by kind, as the standard spells them.
TAGS: Final = {kind: tag for tag, kind, _ in TAGGED_SHAPES if kind is not None}

#: Shapes that are points.
POINT_SETS: Final = ("pointsetshape", "pointsetmonotonicshape", "usershape", "pointsshape")

#: All shapes as the standard spells them, for messages.
SHAPE_TAGS: Final = (*(tag for tag, _, _ in TAGGED_SHAPES), "pointSetShape", "circularDefinition")
