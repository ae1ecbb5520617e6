import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl import expr as ex
from fuzzyctl import loads

NAMES = {"a": 2.0, "b": -3.0}


def number(value):
    return ex.Number(value)


#: Whole numbers near some: downwards, upwards, to the nearest, of two the even one.
STEPS = [
    *(("floor", x, v) for x, v in ((2.5, 2.0), (-2.5, -3.0), (-0.0, -0.0), (1e300, 1e300), (2.0, 2.0))),
    *(("ceil", x, v) for x, v in ((2.5, 3.0), (-2.5, -2.0), (4503599627370497.5, 4503599627370498.0))),
    *(("round", x, v) for x, v in ((0.5, 0.0), (1.5, 2.0), (2.5, 2.0), (-1.5, -2.0), (-0.3, 0.0), (2.6, 3.0))),
    ("round", 0.49999999999999994, 0.0),
    ("round", -0.49999999999999994, 0.0),
]
#: Those of `mod` have the sign of the divisor, those of `fmod` that of what is divided.
REMAINDERS = [
    *(("mod", a, b, v) for a, b, v in ((7.5, 2.0, 1.5), (-7.5, 2.0, 0.5), (7.5, -2.0, -0.5), (-4.0, 2.0, 0.0))),
    *(("fmod", a, b, v) for a, b, v in ((7.5, 2.0, 1.5), (-7.5, 2.0, -1.5), (7.5, -2.0, 1.5), (-7.5, -2.0, -1.5))),
    ("mod", 1e17, 3.0, 1e17 % 3.0),
]
#: What is true of a number below, at and above another.
COMPARED = {
    "lt": (1, 0, 0),
    "le": (1, 1, 0),
    "gt": (0, 0, 1),
    "ge": (0, 1, 1),
    "eq": (0, 1, 0),
    "ne": (1, 0, 1),
}


class TestEvaluate:
    @pytest.mark.parametrize(
        ("expression", "value"),
        [
            (ex.Binary("+", ex.Name("a"), number(1.0)), 3.0),
            (ex.Binary("-", number(1.0), ex.Name("b")), 4.0),
            (ex.Binary("/", number(1.0), ex.Name("a")), 0.5),
            (ex.Binary("^", ex.Name("a"), number(3.0)), 8.0),
            (ex.Negate(ex.Name("a")), -2.0),
            (ex.Call("max", (ex.Name("a"), ex.Name("b"))), 2.0),
            (ex.Call("atan2", (number(1.0), number(0.0))), math.pi / 2),
            (ex.Call("sign", (ex.Name("b"),)), -1.0),
            *((ex.Call(f, (number(x),)), v) for f, x, v in STEPS),
            *((ex.Call(f, (number(a), number(b))), v) for f, a, b, v in REMAINDERS),
            *(
                (ex.Call(f, (number(a), number(b))), float(v))
                for f, truths in COMPARED.items()
                for a, b, v in zip((1.0, 2.0, 2.0), (2.0, 2.0, 1.0), truths, strict=True)
            ),
            (ex.Name("inf"), math.inf),
        ],
    )
    def test_it_computes(self, expression, value):
        assert ex.evaluate(expression, NAMES) == value

    @pytest.mark.parametrize(
        ("expression", "message"),
        [
            (ex.Binary("/", number(1.0), number(0.0)), "division by zero"),
            (ex.Call("sqrt", (number(-1.0),)), "domain"),
            (ex.Call("log", (number(0.0),)), "domain"),
            (ex.Call("mod", (number(1.0), number(0.0))), "domain"),
            (ex.Call("fmod", (number(1.0), number(0.0))), "domain"),
            (ex.Binary("^", number(-8.0), number(0.5)), "domain"),
            (ex.Binary("^", number(10.0), number(1e6)), "too large"),
            (ex.Binary("*", number(1e200), number(1e200)), "too large"),
            (ex.Call("exp", (number(1e6),)), "too large"),
            (ex.Name("c"), "no param 'c'"),
            (ex.Compare("<", number(1.0), number(2.0)), "expected a number, found a condition"),
            (ex.Binary("-", ex.Name("inf"), ex.Name("inf")), "not a real number"),
        ],
    )
    def test_what_has_no_value_is_refused(self, expression, message):
        with pytest.raises(ex.ExprError, match=message):
            ex.evaluate(expression, NAMES)


class TestSign:
    def test_it_is_odd_with_zero_at_zero(self):
        assert [ex.sign(x) for x in (-2.0, -0.0, 0.0, 3.0)] == [-1.0, 0.0, 0.0, 1.0]
        assert math.isnan(ex.sign(math.nan))


class TestNumberText:
    @given(st.floats(allow_nan=False))
    def test_it_reads_back_bit_for_bit(self, value):
        assert math.copysign(1, float(ex.number_text(value))) == math.copysign(1, value)
        assert float(ex.number_text(value)) == value


def expressions():
    leaves = st.one_of(
        st.floats(0, 1e6, allow_nan=False).map(ex.Number),
        st.sampled_from(["a", "b"]).map(ex.Name),
    )

    def grow(inner):
        return st.one_of(
            st.builds(ex.Binary, st.sampled_from(["+", "-", "*", "/", "^"]), inner, inner),
            st.builds(lambda e: ex.Negate(e) if not isinstance(e, ex.Number) else ex.Number(-e.value), inner),
            st.builds(lambda a, b: ex.Call("min", (a, b)), inner, inner),
        )

    return st.recursive(leaves, grow, max_leaves=12)


class TestToText:
    @given(expressions())
    def test_what_is_printed_parses_to_the_same_tree(self, expression):
        system = loads(
            "system s\nparam a = 2\nparam b = 3\ninput x in [0, 1]\n  terms A B\n"
            f"output u in [0, 1] = {ex.to_text(expression)}\nrequire u <= a + b\n"
        )
        assert system.outputs[0].value == expression

    def test_a_power_binds_tighter_than_a_sign(self):
        system = loads(
            "system s\nparam c = -2^2\ninput x in [0, 1]\n  terms A B\noutput u in [c, 1]\n  A = singleton(0)\n"
            "defuzzifier weighted_average\nif x is A or x is B then u is A\n"
        )
        assert system.values["c"] == -4.0
