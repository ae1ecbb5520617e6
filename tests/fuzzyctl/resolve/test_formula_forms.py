"""Conditions as numbers, `linear(...)` by names, and products in `terms` lines."""

import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.fz import dumps
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.loading.load import loads
from tests.fuzzyctl.messages import only, said_of

TEXT = """system forms
defuzzifier weighted_average
param h = 0.25
input e in [-1, 1]
  terms N Z P
input de in [-1, 1]
  A = ramp(-1, 1)
output u in [-1, 1] else 0
  terms low=-0.5 high=0.5
if e is N then u is low
if e is P and de is A then u is high
"""


def read(old, new):
    assert old in TEXT
    text = TEXT.replace(old, new)
    system = loads(text)
    assert loads(dumps(system)) == system == loads(format_source(SourceText("", text)))
    return system


def said(old, new):
    assert old in TEXT
    return [d for d in said_of(TEXT.replace(old, new)) if d[1] not in ("FZ208", "FZ211", "FZ216")]


@pytest.mark.parametrize(
    ("old", "short", "long"),
    [
        ("ramp(-1, 1)", "function(de > 0)", "function(gt(de, 0))"),
        ("ramp(-1, 1)", "function((de <= 0) * 0.5)", "function(le(de, 0) * 0.5)"),
        ("ramp(-1, 1)", "function(-0.5 <= de and de < 0.5)", "function(min(le(-0.5, de), lt(de, 0.5)))"),
        ("ramp(-1, 1)", "function(not (de == 0 or de != h))", "function(1 - max(eq(de, 0), ne(de, h)))"),
        ("ramp(-1, 1)", "function(abs((de >= 0) - 1))", "function(abs(ge(de, 0) - 1))"),
        ("u is high", "u is function((e > 0) * de)", "u is function(gt(e, 0) * de)"),
        ("u is high", "u is linear(0.5, e=2, de=-h)", "u is linear(2, -h, 0.5)"),
        ("u is high", "u is linear(de=1)", "u is linear(0, 1, 0)"),
        ("u is high", "u is linear(e=1, 0.5)", "u is linear(1, 0, 0.5)"),
        (
            "terms low=-0.5 high=0.5",
            "low = linear(1, de=2)\n  high = linear(e=1)",
            "low = linear(0, 2, 1)\n  high = linear(1, 0, 0)",
        ),
        ("terms low=-0.5 high=0.5", "terms low=-2*h high=h/2*3", "terms low=(-2*h) high=(h/2*3)"),
        ("terms low=-0.5 high=0.5", "terms low=-h high=h", "terms low=(-h) high=(h)"),
        ("terms low=-0.5 high=0.5", "terms low=-(h + 1)*2 high=(h)", "terms low=(-(h + 1)*2) high=(h)"),
        ("terms N Z P", "terms N@-h Z@h*h P@2*h", "terms N@(-h) Z@(h*h) P@(2*h)"),
    ],
)
def test_a_short_form_is_the_long_one(old, short, long):
    assert read(old, short) == read(old, long)


def test_a_hedge_may_hold_a_condition():
    short = read("param h = 0.25", "hedge sharp(x) = x > 0.5\nparam h = 0.25")
    assert short.hedges == read("param h = 0.25", "hedge sharp(x) = gt(x, 0.5)\nparam h = 0.25").hedges


def test_terms_may_be_called_like_units():
    terms = read("terms low=-0.5 high=0.5", "terms low=-1 s=2 high=3 ms=4 h=5").output("u").terms
    assert [t.name for t in terms] == ["low", "s", "high", "ms", "h"]


def test_items_are_formatted_without_blanks():
    text = TEXT.replace("low=-0.5 high=0.5", "low = - 2 * h   high=( h + 1 )* h / 2")
    assert "  terms low=-2*h high=(h + 1)*h/2\n" in format_source(SourceText("", text))


@pytest.mark.parametrize(
    ("old", "new", "code", "words"),
    [
        ("ramp(-1, 1)", "function(de and de > 0)", "7 FZ307", "expected a condition, found a number"),
        ("ramp(-1, 1)", "function(not de)", "7 FZ307", "expected a condition, found a number"),
        ("ramp(-1, 1)", "function(k > 0)", "7 FZ202", "'k' is neither a param nor 'de' itself"),
        ("ramp(-1, 1)", "ramp(-1, 1 < 2)", "7 FZ307", "expected a number, found a condition"),
        ("ramp(-1, 1)", "function(x=de)", "7 FZ303", "takes no named parameters"),
        ("u is high", "u is linear(1, 2, e=1)", "11 FZ303", "takes one constant"),
        ("u is high", "u is linear(1, e=1, e=2)", "11 FZ303", "the factor of 'e' is given twice"),
        ("u is high", "u is linear(1, ee=1)", "11 FZ202", "did you mean 'e'?"),
        ("u is high", "u is function(x=1)", "11 FZ303", "takes no named parameters"),
        ("u is high", "u is linear(1, e=de)", "11 FZ202", "no param 'de'"),
        ("low=-0.5 high=0.5", "low=h+1 high=0.5", "9 FZ102", "low=(h+1)"),
    ],
)
def test_a_mistake_is_reported_once(old, new, code, words):
    where, text = only(said(old, new))
    assert where == code
    assert words in text


@pytest.mark.parametrize(
    ("function", "short", "long"),
    [
        ("", "let z = e > 0\noutput w in [0, 1] = z * de", "let z = gt(e, 0)\noutput w in [0, 1] = z * de"),
        ("", "output w in [0, 1] = e > 0 and de > h", "output w in [0, 1] = min(gt(e, 0), gt(de, h))"),
        ("function on(x) = x > h\n", "output w in [0, 1] = on(e) * de", "output w in [0, 1] = gt(e, h) * de"),
    ],
)
def test_lets_formulas_of_outputs_and_functions_take_conditions(function, short, long):
    first, second = (TEXT.replace("input e", f"{lines}\ninput e") for lines in (short, long))
    assert loads(function + first) == loads(second)
