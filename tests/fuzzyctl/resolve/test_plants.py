"""Mistakes in plants: each with its code, its message, its location and its repair."""

import pytest

from tests.fuzzyctl.resolve.mistakes import errors_in, repairs_in, require_one

HEAD = "plant p\ninput u\nstate x = 0\nder x = u - x\n"

#: What follows the head of a plant, and the one mistake in it: code, message, location, part of the repair.
MISTAKES = {
    "": ("FZ212", "plant 'p' has no outputs", "p", "add an 'output"),
    "state h = 1\noutput y = h": ("FZ212", "state 'h' has no 'der' line", "h", "add: der h = EXPRESSION"),
    "der z = 1\noutput y = x": ("FZ202", "no state 'z'", "z", "declare it: state z = START"),
    "der u = 1\noutput y = x": (
        "FZ202",
        "no state 'u'",
        "u",
        "only a state has a derivative: declare one with another name",
    ),
    "der x = 1\noutput y = x": ("FZ215", "the derivative of 'x' is given twice", "der x = 1", ""),
    "next x = 1\noutput y = x": ("FZ101", "'next' belongs to a controller, not to a plant", "next", "write: der STATE"),
    "every 1 s\noutput y = x": ("FZ101", "'every' belongs to a controller, not to a plant", "every", "continuous"),
    "block b = p(x)\noutput y = x": (
        "FZ101",
        "'block' belongs to a controller, not to a plant",
        "block",
        "connect blocks in a loop",
    ),
    "measure m = iae(x, u)\noutput y = x": (
        "FZ101",
        "'measure' belongs to a loop, not to a plant",
        "measure",
        "put it into a loop",
    ),
    "run 5 s\noutput y = x": ("FZ101", "'run' belongs to a loop, not to a plant", "run", "put it into a loop"),
    "terms A B\noutput y = x": ("FZ101", "'terms' belongs to a system, not to a plant", "terms", "call that system"),
    "dre x = 1\noutput y = x": ("FZ101", "unexpected 'dre': did you mean 'der'?", "dre", "der x = 1"),
    "let t = 1\noutput y = x": ("FZ201", "'t' is a word of plants and cannot name a let", "t", "rename it"),
    "output y = previous(x)": ("FZ214", "'previous' belongs to controllers", "previous(x", "use a state, or delay"),
    "output y = derivative(x)": ("FZ214", "'derivative' belongs to controllers", "derivative(x", "use a state"),
    "output y = integral(x)": ("FZ214", "'integral' belongs to controllers", "integral(x", "der s = x"),
    "output y = hysteresis(x, 0, 1)": ("FZ214", "'hysteresis' belongs to controllers", "hysteresis", "controller"),
    "output y = noise(1)": ("FZ214", "'noise' belongs to loops", "noise(1", "add an input"),
    "output y = overshoot(x, u)": ("FZ214", "'overshoot' belongs to 'measure' lines of loops", "overshoot", "loop"),
    "output y = tf(x)": ("FZ214", "'tf' belongs to plants of one line", "tf(x", "plant NAME = tf(num="),
    "output y = dt * x": ("FZ202", "no name 'dt'", "dt", ""),
    "output y = delay(x)": ("FZ303", "wrong arguments of 'delay'", "delay(x", "the form is: delay(x, time"),
    "output y = delay(x, 1 s, 2, 3)": ("FZ303", "wrong arguments of 'delay'", "delay(", "the form is: delay"),
    "output y = delay(x, u)": ("FZ202", "no param 'u'", "u", ""),
    "output y = delay(x, -1)": (
        "FZ302",
        "the dead time is -1 s: expected a finite time of 0 or more",
        "-1",
        "write a time",
    ),
    "output y = delay(x, inf)": (
        "FZ302",
        "the dead time is inf s: expected a finite time of 0 or more",
        "inf",
        "write a time",
    ),
    "output y = delay(x, 1, inf)": ("FZ302", "the start of the dead time is infinite", "inf", "give it a finite start"),
    "state w = -inf\nder w = x\noutput y = x": ("FZ302", "the start of state 'w' is infinite", "-inf", "give it"),
    "output y = x / (1 - 1)": ("FZ307", "division by zero", "x / (1 - 1", "give the divisor a value"),
    "output y = delay(x, 1 s, start=1/0)": ("FZ307", "division by zero", "1/0", ""),
    "function f(a) = delay(a, 1 s)\noutput y = f(x)": (
        "FZ214",
        "'delay' keeps past values, which only 'let', 'der' and 'output' lines may have",
        "delay(a, 1 s",
        "'let'",
    ),
    "function f(a) = f(a)\noutput y = f(x)": ("FZ217", "function 'f' calls itself", "f", ""),
    "let a = b\nlet b = a + u\noutput y = a": (
        "FZ220",
        "algebraic loop: 'a' depends on itself within one step",
        "a",
        "let a state break it, or delay",
    ),
    "output y = max(x, [1, 2])": ("FZ303", "expected a number, found a list", "[1, 2]", ""),
    'output y = max(x, "a")': ("FZ303", "expected a number, found a text", '"a"', ""),
    "output y = max(x, 1: 2)": ("FZ303", "expected a number, found a pair 'a: b'", "1: 2", ""),
    "param k = max([1])\noutput y = x": ("FZ303", "unexpected argument", "[1]", "write a number"),
    "state h in [0, 1] = 2\nder h = 0\noutput y = h": (
        "FZ302",
        "the start of state 'h' is 2, outside of [0, 1]",
        "2",
        "",
    ),
    "state h = u\nder h = 0\noutput y = h": ("FZ202", "no param 'u'", "u", ""),
    "param k in [2, 3] = 1\noutput y = k": ("FZ302", "param 'k' is 1, outside of [2, 3]", "1", ""),
    "output y = where(x, 1, 2)": ("FZ307", "expected a condition, found a number", "x", "compare it"),
    "output y in [3, 2] = x": ("FZ304", "the range of 'y' is empty: 3 is not below 2", "[3, 2]", ""),
}

#: Plants of one line, with the one mistake in each.
ONE_LINE = {
    "tf(num=[1, 2, 3], den=[1, 2])": (
        "FZ221",
        "the transfer function is not proper: its numerator has order 2, its denominator 1",
        "[1, 2, 3]",
        "remove zeros",
    ),
    "tf(num=[1], den=[0, 1])": ("FZ302", "the leading coefficient of 'den' is 0", "0", "remove it"),
    "tf(num=[1 / 0], den=[1, 1])": ("FZ307", "division by zero", "1 / 0", ""),
    "zpk(zeros=[], poles=[-1, pair(-1, log(-2))], gain=1)": (
        "FZ307",
        "an argument lies outside the function's domain",
        "log(-2",
        "",
    ),
    "zpk(zeros=[], poles=[-1], gain=1 / 0)": ("FZ307", "division by zero", "1 / 0", ""),
    "tf(num=[1], den=[1, 1], delay=1 / 0)": ("FZ307", "division by zero", "1 / 0", ""),
    "ss(A=[[-1, 1 / 0], [0, -1]], B=[1, 0], C=[1, 0])": ("FZ307", "division by zero", "1 / 0", ""),
    "tf(num=[0, 1], den=[1, 1])": ("FZ302", "the leading coefficient of 'num' is 0", "0", "remove it"),
    "tf(num=[0], den=[1, 1])": ("FZ302", "the leading coefficient of 'num' is 0", "0", "write another number"),
    "tf(num=[], den=[1, 1])": ("FZ303", "'num' is empty", "[]", "the form is: tf("),
    "tf(num=[1])": ("FZ303", "wrong arguments of 'tf'", "tf(num=[1]", "the form is: tf("),
    "tf(num=1, den=[1, 1])": ("FZ303", "expected a list for 'num'", "1", "the form is: tf("),
    "tf(num=[1], den=[1, q])": ("FZ202", "no param 'q'", "q", ""),
    "tf(num=[1], den=[1, [2]])": ("FZ303", "expected a number, found a list", "[2]", ""),
    "tf(num=[1], den=[1, 2], delay=-1)": (
        "FZ302",
        "the dead time is -1 s: expected a finite time of 0 or more",
        "-1",
        "write a time",
    ),
    "tf(num=[1], den=[1e-300, 1e300])": ("FZ307", "the coefficients are too large or too small", "tf(", "scale them"),
    "tf(num=[1], den=[1, 2], dealy=1)": ("FZ303", "wrong arguments of 'tf'", "tf(", "delay=0 s"),
    "zpk(zeros=[-1, -2], poles=[-1])": (
        "FZ221",
        "the transfer function is not proper: its list of zeros has order 2, its list of poles 1",
        "[-1, -2]",
        "remove zeros",
    ),
    "zpk(zeros=[], poles=[pair(-1)])": ("FZ303", "'pair' takes 2 arguments, not 1", "pair(-1", "imaginary part"),
    "ss(A=[[0, 1], [2]], B=[0, 1], C=[1, 0])": (
        "FZ222",
        "'A' has 2 rows of 2 and 1, not 2 rows of 2",
        "[[0, 1], [2]]",
        "entries",
    ),
    "ss(A=[[0, 1], [2, 3]], B=[0, 1, 2], C=[1, 0])": (
        "FZ222",
        "'B' has 3 rows of 1, not 2 rows of 1",
        "[0, 1, 2]",
        "entries",
    ),
    "ss(A=[[0, 1], [2, 3]], B=[0, 1], C=[1])": ("FZ222", "'C' has 1 row of 1, not 1 row of 2", "[1]", "entries"),
    "ss(A=[[0, 1], [2, 3]], B=[0, 1], C=[1, 0], D=[1, 2])": (
        "FZ222",
        "'D' has 1 row of 2, not 1 row of 1",
        "[1, 2]",
        "entries",
    ),
    "ss(A=[], B=[0], C=[1])": ("FZ303", "'A' is empty", "[]", "the form is: ss("),
    "ss(A=[1, [2]], B=[0], C=[1])": ("FZ303", "'A' mixes rows and numbers", "[1, [2]]", "the form is: ss("),
    "tff(num=[1])": ("FZ214", "expected tf, zpk, ss, python or fmu", "tff(num=[1]", "did you mean 'tf'"),
    "3": ("FZ214", "expected tf, zpk, ss, python or fmu", "3", "the forms are: tf("),
    "python(cart)": ("FZ303", "expected a text for 'file'", "cart", 'python("cart.py")'),
    'python("cart.py")': ("FZ218", "a text that is no file can use no files", '"cart.py"', "write it to a file"),
    "tf(num=[1], den=[1, 2])\nlet a = 1": (
        "FZ214",
        "'let' does not go with a plant of one line, which is complete",
        "let",
        "remove it",
    ),
    "tf(num=[1], den=[1, 2])\nparam u = 1": (
        "FZ201",
        "'u' is a name of the plant itself and cannot name a param",
        "u",
        "rename it",
    ),
}


class TestMistakes:
    @pytest.mark.parametrize("text", MISTAKES)
    def test_each_is_reported_alone_with_its_repair(self, text):
        require_one(f"{HEAD}{text}\n", MISTAKES[text])

    @pytest.mark.parametrize("text", ONE_LINE)
    def test_plants_of_one_line_are_checked(self, text):
        require_one(f"plant p = {text}\n", ONE_LINE[text])

    def test_a_system_with_a_state_is_refused(self):
        system = (
            "system rule\ninput e in [-1, 1]\n  terms N P\noutput v in [-1, 1] else hold\n  terms N P\n"
            "table v = e\n  N P\n| N P\n"
        )
        message = "'rule' keeps a state from one sample to the next, which only controllers have"
        require_one(system + HEAD + "output y = rule(x)\n", ("FZ214", message, "rule(x", "call it in a controller"))

    def test_controllers_and_plants_are_no_functions(self):
        controller = "controller c\ninput e\noutput v = e\n"
        message = "'c' is a controller, which has a state of its own"
        require_one(controller + HEAD + "output y = c(x)\n", ("FZ214", message, "c(x", "blocks of a loop"))
        plant = HEAD + "output y = x\n"
        inside = "controller c\ninput e\nblock b = p(e)\noutput v = e\n"
        message = "'p' is a plant, and 'block' takes a controller"
        require_one(plant + inside, ("FZ214", message, "p(e", "blocks of a loop"))

    def test_der_in_a_controller_is_repaired(self):
        text = "controller c\ninput e\nstate s = 0\nder s = e\noutput v = s\n"
        expected = ("FZ101", "'der' belongs to a plant, not to a controller", "der", "next STATE = STATE + dt")
        require_one(text, expected)

    def test_quantities_of_different_units_are_not_added(self):
        text = 'plant p\ninput u unit "V"\nstate h unit "m" = 0\nder h = 2 * u\noutput y = h + u\n'
        require_one(text, ("FZ312", "'h' is measured in m, 'u' in V", "u", "one unit"))

    def test_a_derivative_has_the_unit_of_its_state_per_second(self):
        text = 'plant p\ninput u unit "UNIT"\nstate h unit "m" = 0\nder h = u\noutput y = h\n'
        for unit in ("m/s", "m s^-1", "pumps"):
            assert errors_in(text.replace("UNIT", unit)) == []
        message = "'u' is measured in m/min, the derivative of 'h' in m per s"
        require_one(text.replace("UNIT", "m/min"), ("FZ312", message, "u", "write a factor"))


def test_a_word_of_the_language_as_a_name_is_repaired():
    text = "controller weight\ninput e\noutput u = e\n"
    assert errors_in(text) == [("FZ201", "'weight' is a word of the language and cannot name a controller", "weight")]
    assert repairs_in(text) == ["rename it, such as: weight_1"]


@pytest.mark.parametrize("head", ["controller pi\ninput e", "plant pi\ninput e"])
def test_pi_is_the_name_of_blocks_and_a_number_in_expressions(head):
    loop = "loop l\nblock b = pi(cos(pi))\nrun 1 s step 10 ms\nmeasure total = final(b.u)\nrequire total < 0\n"
    assert errors_in(f"{head}\noutput u = e / pi\n{loop}") == []
