"""Vocabulary of FML, with the names used here; the writer takes the first word of a table for each meaning."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Final

from fuzzyctl.formats.common.words import Shape, ShapeWord, Values

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

#: By connector its methods, and the attribute of a definition that names one.
NORMS: Final = {"and": (CONJUNCTION_WORDS, "t-norm"), "or": (DISJUNCTION_WORDS, "t-conorm")}

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


def word_for(words: Mapping[str, str], meaning: str, usual: str = "") -> str:
    """Return the first word that has a meaning, the usual one where there is none."""
    return next((word for word, own in words.items() if own == meaning), usual)


def _slope(p: Values, *, falls: bool) -> Shape:
    first, last = p
    if first == last:  # a step
        return "rectangle", (-math.inf, first) if falls else (first, math.inf)
    return "ramp", (last, first) if falls else (first, last)


def _gaussian_side(p: Values, *, falls: bool) -> Shape:
    center, deviation = p
    left, right = (-math.inf, center) if falls else (center, math.inf)
    return "gaussian2", (left, deviation, right, deviation)


def _pi_of_width(p: Values) -> Shape:
    return "pi_shape", (p[0] - p[1], p[0], p[0], p[0] + p[1])


def _pi(p: Values) -> Shape:
    """Return a curve that rises and falls as far; where it could not rise it has a center and a width."""
    return _pi_of_width(p) if p[0] >= p[1] else ("pi_shape", (p[0], p[1], p[1], p[1] + (p[1] - p[0])))


def _side(kind: str, read: Callable[..., Shape], *, falls: bool) -> ShapeWord:
    return ShapeWord(kind, "param1 param2", read=lambda p: read(p, falls=falls))


#: Shapes as JFML means and the standard spells them.
SHAPE_WORDS: Final[dict[str, ShapeWord]] = {
    "triangularShape": ShapeWord("triangle", "left peak right"),
    "trapezoidShape": ShapeWord("trapezoid", "left left_top right_top right"),
    "gaussianShape": ShapeWord("gaussian", "mean sigma"),
    "leftGaussianShape": _side("gaussian2", _gaussian_side, falls=True),
    "rightGaussianShape": _side("gaussian2", _gaussian_side, falls=False),
    "leftLinearShape": _side("ramp", _slope, falls=True),
    "rightLinearShape": _side("ramp", _slope, falls=False),
    "piShape": ShapeWord("pi_shape", "start top", read=_pi),
    "zShape": ShapeWord("z_shape", "start end"),
    "sShape": ShapeWord("s_shape", "start end"),
    "rectangularShape": ShapeWord("rectangle", "left right"),
    "singletonShape": ShapeWord("singleton", "value"),
}

#: The same by their names in small letters; earlier drafts have another word for a trapezoid.
SHAPES: Final = {tag.lower(): word for tag, word in SHAPE_WORDS.items()}
SHAPES["trapezoidalshape"] = SHAPE_WORDS["trapezoidShape"]

#: The shapes of drafts, which mirror left and right.
DRAFT_SHAPES: Final = {
    **SHAPES,
    **{f"left{kind}shape": SHAPES[f"right{kind}shape"] for kind in ("gaussian", "linear")},
    **{f"right{kind}shape": SHAPES[f"left{kind}shape"] for kind in ("gaussian", "linear")},
    "pishape": ShapeWord("pi_shape", "center width", read=_pi_of_width),
}

#: Shapes by kind whose parameters are those of the kind, as the standard spells them.
TAGS: Final = {word.kind: tag for tag, word in SHAPE_WORDS.items() if word.read is None}

#: Shapes that are points.
POINT_SETS: Final = ("pointsetshape", "pointsetmonotonicshape", "usershape", "pointsshape")

#: All shapes as the standard spells them, for messages.
SHAPE_TAGS: Final = (*SHAPE_WORDS, "pointSetShape", "circularDefinition")
