"""Tables of words both ways: norms that belong together, membership functions, and conditions with `any`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeVar

#: The norms that belong together by De Morgan's laws: `not (a and b)` is `not a or not b`.
_PAIRS: Final = (
    ("min", "max"),
    ("product", "probabilistic_sum"),
    ("bounded_difference", "bounded_sum"),
    ("drastic_product", "drastic_sum"),
    ("nilpotent_minimum", "nilpotent_maximum"),
    ("einstein_product", "einstein_sum"),
    ("hamacher_product", "hamacher_sum"),
)
DUAL_OF: Final[dict[str, str]] = {a: b for pair in _PAIRS for a, b in (pair, pair[::-1])}


def first_words(words: Mapping[str, str]) -> dict[str, str]:
    """Return the first word of a file for each name of the model."""
    return {name: word for word, name in reversed(list(words.items()))}


def up_to_any(hedges: Sequence[str], term: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the hedges and the term, if any, of a condition of fuzzylite, which allows nothing behind `any`."""
    if "any" in hedges:
        return tuple(hedges[: hedges.index("any") + 1]), ()
    return tuple(hedges), (term,)


T = TypeVar("T")

Values = tuple[float, ...]

#: A kind of the model with its parameters.
Shape = tuple[str, Values]


@dataclass(frozen=True)
class ShapeWord:
    """A word of a format for a membership function.

    Args:
        kind: Its kind in the model.
        form: Names of its parameters in the order of the file; a list without end closes with `...`.
        order: Positions in the file of the parameters in the order of the model; empty if both are the same.
        doubled: Positions in the model of parameters that are twice as large as in the file.
        magnitudes: Positions in the model of parameters whose sign does not matter, such as a width that is squared.
        read: Makes the kind and the parameters of those of a file, if more than their order changes.
    """

    kind: str
    form: str
    order: tuple[int, ...] = ()
    doubled: tuple[int, ...] = ()
    magnitudes: tuple[int, ...] = ()
    read: Callable[[Values], Shape] | None = None

    @property
    def count(self) -> int | None:
        """Number of parameters, None for a list without end."""
        return None if self.form.endswith("...") else len(self.form.split())

    def shape(self, p: Values) -> Shape:
        """Return the kind and the parameters in the model for those of a file."""
        if self.read is not None:
            return self.read(p)
        values = (2 * v if i in self.doubled else v for i, v in enumerate(self.ordered(p)))
        return self.kind, tuple(abs(v) if i in self.magnitudes else v for i, v in enumerate(values))

    def ordered(self, p: Sequence[T]) -> tuple[T, ...]:
        """Return the parameters in the order of the model for those of a file, which may be numbers or expressions."""
        return tuple(p[i] for i in self.order) if self.order else tuple(p)

    def parameters(self, p: Values) -> Values:
        """Return the parameters in a file for those of the model."""
        values = tuple(v / 2 if i in self.doubled else v for i, v in enumerate(p))
        return tuple(values[self.order.index(i)] for i in range(len(values))) if self.order else values


def words_by_kind(words: Mapping[str, ShapeWord]) -> dict[str, tuple[str, ShapeWord]]:
    """Return the first word of a table for each kind of the model."""
    return {word.kind: (name, word) for name, word in reversed(list(words.items()))}


def one_sided(kind: str, p: Values) -> Shape:
    """Return a term with one infinite foot as the equal ramp, `s_shape` or `z_shape`; any other term unchanged."""
    if kind in ("triangle", "trapezoid", "pi_shape"):
        left, left_top, right_top, right = p if len(p) == 4 else (p[0], p[1], p[1], p[2])
        if right == math.inf and -math.inf < left < left_top:
            return ("s_shape" if kind == "pi_shape" else "ramp"), (left, left_top)
        if left == -math.inf and right_top < right < math.inf:
            return ("z_shape", (right_top, right)) if kind == "pi_shape" else ("ramp", (right, right_top))
    return kind, p
