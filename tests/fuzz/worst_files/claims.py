"""Worst cases of guarantees and units."""

from itertools import islice

from worst_files.case import GUARANTEES, HEAD, case, computed, cut, inputs_of, repeated, repetitions

SMALL = HEAD.replace(" else 0", "") + "if x is low then y is small\nif x is high then y is large\n"
SQUARE = inputs_of(2, "a b c d e f g") + "output y in [0, 1]\n  terms small large\n"

SQUARE += "table y = x0 x x1\n  a b c d e f g\n" + "".join(f"{t} | {'small large ' * 3}small\n" for t in "abcdefg")

repetitions(
    {
        "claims-that-hold": ("require y <= 1 + @\n", SMALL),
        "claims-that-are-refuted": ("require y <= 0.5 + 0 * @\n", SMALL),
        "claims-about-slopes": ("require lipschitz(y, x0) <= 100 + @\n", SQUARE),
        "claims-about-slopes-that-are-refuted": ("require increasing(y, x0)\n", SQUARE),
        "claims-of-totality": ("require total(y) >= 0.1\n", SQUARE),
        "claims-with-conditions": ("require y <= 1 when " + " and ".join(["x >= 0"] * 40) + "\n", SMALL),
        "claims-about-unknown-names": ("require yy@ <= 1\n", SMALL),
        "claims-of-unlike-units": (
            "require y <= x\n",
            SMALL.replace("input x in [0, 1]", 'input x in [0, 1] unit "m"').replace(
                "output y in [0, 1]", 'output y in [0, 1] unit "s"'
            ),
        ),
    },
    most=GUARANTEES,
)
repetitions(
    {
        "claims-more-than-allowed": ("require y <= 1 + @\n", SMALL),
        "a-long-unit": ("m^2 s per ", HEAD.replace("y in [0, 1]", 'y in [0, 1] unit "m"'), 'param p = 1 unit "'),
    }
)


@case
def claims_that_are_hard(size):
    yield from computed(size, 4, "require y - y^2 + sin(@ * y) <= 1.25\n", SQUARE)


@case
def claims_that_are_long(size):
    yield from computed(size, 90, f"require {' + '.join(['y'] * 90)} <= @ + 100\n", SMALL)


@case
def claims_at_other_points(size):
    yield from computed(size, 39, "require " + " + ".join(f"y(x + {k}, 0)" for k in range(20)) + " <= 1\n", SMALL)


@case
def long_units(size):
    unit = " ".join(["m"] * 300)
    head = SMALL.replace("y in [0, 1]", f'y in [0, 1] unit "{unit}"')
    yield from islice(repeated(f'param p@ = 1 unit "{unit}"\nrequire y <= p@\n', head), 1 + int(GUARANTEES * size))


@case
def a_claim_in_a_long_unit(size):
    unit = cut(repeated("m "), 0.4 * size)
    text = SMALL.replace("y in [0, 1]", f'y in [0, 1] unit "{unit}"')
    yield text + f'param p = 1 unit "{unit}"\nrequire y <= p\n'
