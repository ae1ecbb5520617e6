"""What drawn systems of several formats are made of."""

import hypothesis.strategies as st
from hypothesis import assume

from fuzzyctl.expr import Number
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.model.variable import Membership, Term

NUMBERS = st.floats(-1e6, 1e6, allow_subnormal=False)

#: Memberships whose parameters need not rise.
_UNORDERED = ("gaussian2", "sigmoid_difference", "bell", "cosine")


def number(value):
    return Number(float(value))


@st.composite
def shapes(draw, kinds):
    """A membership of one of some kinds, with parameters that are no mistake."""
    kind = draw(st.sampled_from(kinds))
    formula = MEMBERSHIP[kind]
    count = 2 * draw(st.integers(2, 5)) if formula.variadic else len(formula.parameters)
    values = sorted(draw(st.lists(NUMBERS, min_size=count, max_size=count)))
    if kind == "piecewise":
        degrees = draw(st.lists(st.floats(0, 1), min_size=count // 2, max_size=count // 2))
        values = [v for pair in zip(values, degrees, strict=False) for v in pair]
    if kind in _UNORDERED:
        values = draw(st.permutations(values))
    if kind == "cosine":
        values[1] = 2 * (values[1] / 2)  # files say half the width
    assume(formula.mistake(tuple(values)) is None)
    return Membership(kind=kind, arguments=tuple(map(number, values)))


@st.composite
def variables(draw, name, kinds, names, make, **more):
    """An input or an output, as `make` says, with up to four terms."""
    low, high = sorted(draw(st.lists(NUMBERS, min_size=2, max_size=2, unique=True)))
    chosen = draw(st.lists(st.sampled_from(names), min_size=1, max_size=4, unique=True))
    terms = tuple(Term(name=n, membership=draw(shapes(kinds))) for n in chosen)
    return make(name=name, lower=number(low), upper=number(high), terms=terms, **more)
