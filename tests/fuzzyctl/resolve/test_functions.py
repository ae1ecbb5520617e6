"""Functions of a file in systems: kinds of membership functions, and parts of formulas."""

import pytest

import fuzzyctl
from fuzzyctl import DiagnosticError

SYSTEM = "system s\ndefuzzifier weighted_average\ninput e in [-1, 1]\n"
OUTPUT = "output u in [0, 1] = e\n"

WHOLE = """
param k = 2
function hump(x, c, w) = 1 / (1 + ((x - c) / w)^2)
function gain(a) = k * abs(a)
function twice(a) = gain(gain(a))
system s
defuzzifier weighted_average
input e in [-1, 1]
  near = hump(0, 0.5)
  far  = function(1 - hump(e, 0, 0.5))
let g = twice(e)
output u in [-9, 9]
  a = function(gain(e) + 1)
output y in [0, 20] = gain(u)
if e is near then u is a
if e is far then u is function(twice(e) + 0 * g)
"""

CHAIN = "".join(f"function g{i}(x) = 1 + g{i + 1}(x)\n" for i in range(300)) + "function g300(x) = x\n"

MISTAKES = {
    "function f(x) = f(x)\n" + SYSTEM + "  A = f()\n" + OUTPUT: ("FZ217", "function 'f' calls itself", "f"),
    "function f(x, a) = x + q\n" + SYSTEM + "  A = f(1)\n" + OUTPUT: ("FZ202", "no parameter or param 'q'", "q"),
    "function f(x) = e * x\n" + SYSTEM + "  A = f()\n" + OUTPUT: ("FZ202", "no parameter or param 'e'", "e"),
    "function f(x, a) = x * a\n" + SYSTEM + "  A = f(1, 2)\n" + OUTPUT: (
        "FZ303",
        "'f' takes 1 parameter besides the variable, not 2",
        "f",
    ),
    "function f(x, a) = x * a\n" + SYSTEM + "  A = f(a=1)\n" + OUTPUT: (
        "FZ303",
        "'f' takes no named parameters",
        "a=1",
    ),
    "function f(x) = x\n" + SYSTEM + "output u in [0, 1] = f(e, 2)\n": (
        "FZ303",
        "'f' takes 1 argument, not 2",
        "f(e, 2",
    ),
    "function f(x) = x\nfunction f(y) = y\n" + SYSTEM + OUTPUT: ("FZ201", "there is a function 'f' already", "f"),
    "function sin(x) = x\n" + SYSTEM + OUTPUT: ("FZ201", "there is a function 'sin' already", "sin"),
    "function f(x) = not x\n" + SYSTEM + "output u in [0, 1] = f(e)\n": (
        "FZ307",
        "expected a condition, found a number",
        "e",
    ),
    "function f(x) = x\n" + SYSTEM + "output u in [0, 1] = f(e) + q\n": ("FZ202", "no param, input or output 'q'", "q"),
    "function f(x) = x * x * x * x\n" + SYSTEM + "output u in [0, 1] = f(f(f(f(f(f(e))))))\n": (
        "FZ112",
        "the expression expands to more than 2,000 parts",
        "x",
    ),
    CHAIN + SYSTEM + "output u in [0, 1] = g0(e)\n": ("FZ106", "the expression expands too deep", "x"),
    SYSTEM + "  A = hmup(1)\nfunction hump(x, a) = x\n" + OUTPUT: ("FZ202", "no membership function 'hmup'", "hmup"),
}


@pytest.mark.parametrize("text", MISTAKES, ids=[m[1] for m in MISTAKES.values()])
def test_each_mistake_has_its_message_and_nothing_else_is_reported(text):
    with pytest.raises(DiagnosticError) as caught:
        fuzzyctl.loads(text)
    (found,) = caught.value.diagnostics
    assert (found.code, found.message, found.span.text.rstrip(")")) == MISTAKES[text]


def test_functions_are_what_their_expressions_are():
    system = fuzzyctl.loads(WHOLE)
    near = 1 / (1 + (0.25 / 0.5) ** 2)
    u = near * (2 * 0.25 + 1) + (1 - near) * 4 * 0.25
    assert system(e=0.25) == pytest.approx({"u": u, "y": 2 * u}, rel=1e-15)
    assert system.with_params(k=3)(e=0.25)["y"] == pytest.approx(3 * (near * 1.75 + (1 - near) * 9 * 0.25), rel=1e-15)


def test_the_text_of_a_system_holds_what_functions_stand_for():
    system = fuzzyctl.loads(WHOLE)
    text = fuzzyctl.dumps(system)
    assert "near = function(1 / (1 + ((e - 0) / 0.5)^2))" in text
    assert fuzzyctl.loads(text) == system


def test_a_function_that_controllers_share_may_clamp():
    text = (
        "function sat(x, most) = clamp(2 * x, -most, most)\n"
        + SYSTEM
        + "output u in [-1, 1] = sat(e, 0.5) + sat(e, 1)\n"
    )
    system = fuzzyctl.loads(text)
    assert [system(e=x) for x in (-1.0, 0.1, 0.4)] == pytest.approx([-1.5, 0.4, 1.3])
    assert fuzzyctl.loads(fuzzyctl.dumps(system)) == system
