"""Mistakes in controllers: each with its code, its message and the text that it points at."""

import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import look_through
from tests.fuzzyctl.resolve.mistakes import errors_in, require_one

SYSTEM = """system rule
param k = 1
input e in [-1, 1]
  terms N P
output u in [-1, 1]
  terms N P
table u = e
  N P
| N P
"""
HEAD = "controller c\ninput x\n"


#: What follows the head of a controller, and the one mistake in it.
MISTAKES = {
    "output y = z": ("FZ202", "no name 'z'", "z"),
    "output y = sine(x)": ("FZ202", "no function or system 'sine'", "sine(x"),
    "state s = 0\noutput y = s": ("FZ212", "state 's' has no 'next' line", "s"),
    "next x = 1\noutput y = x": ("FZ202", "no state 'x'", "x"),
    "state s = 0\nnext s = 1\nnext s = 2\noutput y = s": (
        "FZ215",
        "the next value of 's' is given twice",
        "next s = 2",
    ),
    "let a = 1\nlet a = 2\noutput y = a": ("FZ201", "'a' is declared twice", "a"),
    "let dt = 1\noutput y = dt": ("FZ201", "'dt' is a word of controllers and cannot name a let", "dt"),
    "let a = x": ("FZ212", "controller 'c' has no outputs", "c"),
    "every 0 s\noutput y = x": ("FZ302", "the period is 0 s, not positive", "0 s"),
    "every 1 s\nevery 2 s\noutput y = x": ("FZ215", "'every' is given twice", "every 2 s"),
    "param k in [2, 3] = 1\noutput y = k": ("FZ302", "param 'k' is 1, outside of [2, 3]", "1"),
    "param k in (0, 1) = 0\noutput y = k": ("FZ302", "param 'k' is 0, outside of (0, 1)", "0"),
    "param k in [3, 2] = 1\noutput y = k": ("FZ304", "the range of 'k' is empty: 3 is not below 2", "[3, 2]"),
    "param k = k\noutput y = k": ("FZ308", "param 'k' depends on itself: k → k", "k"),
    "param k = 1/0\noutput y = k": ("FZ307", "division by zero", "1/0"),
    "output y = x + 1/0": ("FZ307", "division by zero", "1/0"),
    "param k = 0\nlet a = x / k\noutput y = a": ("FZ307", "division by zero", "x / k"),
    "let a = 0\nlet b = a\noutput y = x / b": ("FZ307", "division by zero", "x / b"),
    "output y = mod(x, 0)": ("FZ307", "division by zero", "mod(x, 0"),
    "param k = inf\noutput y = k": ("FZ307", "param 'k' is infinite", "k"),
    "param k = -1\noutput y = clamp(x, 0, log(k))": (
        "FZ307",
        "an argument lies outside the function's domain",
        "log(k",
    ),
    "state s = 0\nnext s = s + exp(1000)\noutput y = s": ("FZ307", "the value is too large", "exp(1000"),
    "function f(a) = a * (inf - inf)\noutput y = f(x)": ("FZ307", "the value is not a real number", "inf - inf"),
    "output y = x\nrequire y < 1 / (2 - 2)": ("FZ307", "division by zero", "1 / (2 - 2"),
    "state s in [0, 1] = 2\nnext s = s\noutput y = s": (
        "FZ302",
        "the start of state 's' is 2, outside of [0, 1]",
        "2",
    ),
    "output y = where(x, 1, 2)": ("FZ307", "expected a condition, found a number", "x"),
    "output y = 1 + (x > 2)": ("FZ307", "expected a number, found a condition", "x > 2"),
    "output y = clamp(x, 1)": ("FZ303", "'clamp' takes 3 arguments, not 2", "clamp(x, 1"),
    "output y = lowpass(x)": ("FZ303", "wrong arguments of 'lowpass'", "lowpass(x"),
    "output y = previous(x, begin=2)": ("FZ303", "wrong arguments of 'previous'", "previous(x, begin=2"),
    "output y = min(x, a=2)": ("FZ303", "unexpected named argument 'a'", "a=2"),
    "output y = delay(x, 2.5)": (
        "FZ302",
        "a delay of 2.5 samples: expected a whole number from 1 to 10,000",
        "2.5",
    ),
    "output y = delay(x, inf)": ("FZ302", "a delay of inf samples: expected a whole number from 1 to 10,000", "inf"),
    "output y = delay(x, 1e9)": (
        "FZ302",
        "a delay of 1e+09 samples: expected a whole number from 1 to 10,000",
        "1e9",
    ),
    "let a = b\nlet b = a\noutput y = a": ("FZ220", "algebraic loop: 'a' depends on itself within one step", "a"),
    "let a = derivative(b)\nlet b = lowpass(a, 1 s)\noutput y = a": (
        "FZ220",
        "algebraic loop: 'b' depends on itself within one step",
        "b",
    ),
    "output y = clamp(lowpass(derivative(y), 1 s), -1, 1)": (
        "FZ220",
        "algebraic loop: 'y' depends on itself within one step",
        "y",
    ),
    "block b = c(x)\noutput y = b.y": ("FZ217", "controller 'c' contains itself", "c"),
    "block b = x\noutput y = x": ("FZ214", "expected a call of a controller", "x"),
    "block b = none(x)\noutput y = b.y": ("FZ202", "no controller 'none'", "none(x"),
    "output y = x\nrequire increasing(y, x)": (
        "FZ214",
        "'increasing' is a claim about a system, not about a step of a controller",
        "increasing(y, x",
    ),
    "output y = x\nrequire bounded(y, 0)": ("FZ303", "'bounded' takes 3 arguments, not 2", "bounded(y, 0"),
    "output y = x\nrequire bounded(y, 0, 1) > 0": ("FZ202", "no function or system 'bounded'", "bounded(y, 0, 1"),
    "output y = x\nrequire bounded(z, 0, 1)": ("FZ202", "no name 'z'", "z"),
    "output y = x\nrequire x > 0 when total(y)": (
        "FZ214",
        "'total' is a claim about a system, not about a step of a controller",
        "total(y",
    ),
    "output y = x\nrequire y": ("FZ307", "expected a condition, found a number", "y"),
    "output y = x\nrequire z > 0": ("FZ202", "no name 'z'", "z"),
    "output y = x\nrequire y > 0 when x": ("FZ307", "expected a condition, found a number", "x"),
    "output y = x\nrequire previous(y) > 0": (
        "FZ214",
        "'previous' keeps a state, which only 'let', 'next', 'output' and 'block' lines may have",
        "previous(y",
    ),
    "output y = x\nrequire y > 0 within x": ("FZ202", "no param 'x'", "x"),
    "output y = x\nrequire y > 0 within -1": ("FZ302", "the tolerance is -1, below 0", "-1"),
    "output y = x\nrequire y > 0 within inf": ("FZ302", "the tolerance is infinite", "inf"),
    "output y = x\nrequire y > 0 within 1/0": ("FZ307", "division by zero", "1/0"),
    "function f(a) = previous(a)\noutput y = f(x)": (
        "FZ214",
        "'previous' keeps a state, which only 'let', 'next', 'output' and 'block' lines may have",
        "previous(a",
    ),
    "function f(a) = a + b\noutput y = f(x)": ("FZ202", "no parameter or param 'b'", "b"),
    "function f(a) = f(a)\noutput y = f(x)": ("FZ217", "function 'f' calls itself", "f"),
    "function f(a, a) = a\noutput y = f(x, x)": ("FZ201", "parameter 'a' is given twice", "a"),
    "function clamp(a) = a\noutput y = x": ("FZ201", "there is a function 'clamp' already", "clamp"),
    "terms A B\noutput y = x": ("FZ101", "'terms' belongs to a system, not to a controller", "terms"),
    "lett a = 2\noutput y = x": ("FZ101", "unexpected 'lett': did you mean 'let'?", "lett"),
    "let a\noutput y = x": ("FZ102", "the line ends too early", "a"),
}

#: The same where a file holds the system `rule` as well.
CALLS = {
    "output y = rule()": ("FZ303", "'rule' lacks a value for: e", "rule"),
    "output y = rule(x, x)": ("FZ303", "'rule' takes 1 input, not 2", "rule(x, x"),
    "output y = rule(x, e=x)": ("FZ303", "argument 'e' is given twice", "e=x"),
    "output y = rule(x, q=x)": ("FZ202", "'rule' has no input or param 'q'", "q=x"),
    "output y = rule(x, k=inf)": ("FZ307", "param 'k' of 'rule' is infinite", "inf"),
    "let a = 0\noutput y = x + 1 / a": ("FZ307", "division by zero", "1 / a"),
    "output y = rule(x, k=x)": ("FZ202", "no param 'x'", "x"),
    "function f(a) = rule(x)\noutput y = f(x)": ("FZ202", "no parameter or param 'x'", "x"),
    "block b = rule(x)\noutput y = x": ("FZ214", "'rule' is a system, and 'block' takes a controller", "rule(x"),
}

#: The same below `way` in m and `time` in s.
UNITS = {
    'output y unit "m" = time': ("'y' is measured in m, 'time' in s", "time"),
    'output y unit "V" = derivative(way) + 2': ("'y' is measured in V, 'derivative(way) + 2' in m/s", "derivative(wa"),
    "output y = derivative(way) + way": ("'derivative(way)' is measured in m/s, 'way' in m", "way"),
    'output y unit "m" = integral(way)': ("'y' is measured in m, 'integral(way)' in m s", "integral(way"),
    'output y unit "m/s" = derivative(derivative(way))': (
        "'y' is measured in m/s, 'derivative(derivative(way))' in (m/s)/s",
        "derivative(derivative(way",
    ),
    'param k = 1 unit "s"\noutput y = previous(way, k)': (
        "'k' is measured in s, 'start' of 'previous' in m",
        "k",
    ),
    'param k = 1 unit "m"\noutput y = rate_limit(way, k)': (
        "'k' is measured in m, 'rate' of 'rate_limit' in m/s",
        "k",
    ),
    'param k = 1 unit "m"\noutput y = integral(way, start=k)': (
        "'k' is measured in m, 'start' of 'integral' in m s",
        "k",
    ),
    'param k = 1 unit "m"\noutput y = lowpass(way, k)': ("'k' is measured in m, 'time' of 'lowpass' in s", "k"),
    'param k = 1 unit "s"\nstate z unit "m" = k\nnext z = z\noutput y = z': ("'z' is measured in m, 'k' in s", "k"),
    'output y unit "s" = lowpass(way, 1 s)': ("'y' is measured in s, 'lowpass(way, 1 s)' in m", "lowpass(way, 1 s"),
    'state k unit "s" = 0\nnext k = way\noutput y = k': ("'k' is measured in s, 'way' in m", "way"),
    "output y = clamp(way, time, 3)": ("'way' is measured in m, 'time' in s", "time"),
    "output y = previous(time) + way": ("'previous(time)' is measured in s, 'way' in m", "way"),
    "output y = where(x > 0, way, time)": ("'way' is measured in m, 'time' in s", "time"),
}


class TestMistakes:
    @pytest.mark.parametrize("text", UNITS)
    def test_units_of_what_is_joined_and_of_what_has_a_name_fit(self, text):
        message, place = UNITS[text]
        ((code, found, found_place),) = errors_in(HEAD + 'input way unit "m"\ninput time unit "s"\n' + text + "\n")
        assert (code, found) == ("FZ312", message)
        assert found_place.startswith(place)

    def test_units_of_settings_and_of_conditions_are_those_of_other_things(self):
        text = 'input way unit "m"\ninput time unit "s"\nparam T = 1 unit "s"\n'
        text += 'output y unit "m" = where(time > 0, lowpass(way, T), rate_limit(clamp(way, -1, 1), 2))\n'
        assert errors_in(HEAD + text) == []
        text = 'input v unit "m s^-1"\ninput way unit "m"\ninput a unit "rad"\ninput w unit "1/s"\n'
        text += 'output y unit "m" = integral(v) + hysteresis(way, 1, 2)\noutput z = derivative(way) + v\n'
        text += 'output q = derivative(a) + w\noutput r unit "m/s^2" = derivative(derivative(way))\n'
        assert errors_in(HEAD + text) == []

    @pytest.mark.parametrize("text", MISTAKES)
    def test_each_has_its_message_and_nothing_else_is_reported(self, text):
        require_one(HEAD + text + "\n", MISTAKES[text])

    @pytest.mark.parametrize("text", CALLS)
    def test_calls_of_systems_are_checked(self, text):
        require_one(SYSTEM + HEAD + text + "\n", CALLS[text])

    def test_all_are_found_at_once(self):
        text = HEAD + "let a = zz\nstate s = 0\nevery 0 s\nparam k in [2, 3] = 1\noutput y = where(x, 1, 2)\nfoo\n"
        assert sorted(code for code, _, _ in errors_in(text)) == ["FZ101", "FZ202", "FZ212", "FZ302", "FZ302", "FZ307"]

    def test_a_mistake_inside_a_block_is_reported_once(self):
        text = "controller a\ninput x\noutput y = q\n" + HEAD + "block b = a(x)\noutput z = b.y\n"
        assert [message for _, message, _ in errors_in(text)] == ["no name 'q'"]

    @pytest.mark.parametrize(
        ("slip", "message"),
        [
            ("param g = = 2\n", "unexpected '=': it stands there twice"),
            ("let b = nope(x)\n", "no function or system 'nope'"),
        ],
    )
    def test_outputs_of_a_call_whose_system_is_not_known_are_no_mistakes(self, slip, message):
        """A mistake in any line may leave the systems of a file without a meaning."""
        system = SYSTEM.replace("output u", "output v in [-1, 1]\n  terms N P\noutput u").replace(
            "table u = e\n  N P\n| N P", "table u, v = e\n  N P\n| N/P P/N"
        )
        text = system + HEAD + "let a = rule(x)\noutput y = a.u + a.v\n"
        assert errors_in(text) == []
        found = errors_in(text + slip + ("output z = b.w + b\n" if "nope" in slip else ""))
        assert [m for _, m, _ in found] == [message]

    def test_a_function_has_no_operator_with_a_state(self):
        text = HEAD + "function f(a) = previous(a)\noutput y = f(x)\n"
        message = "'previous' keeps a state, which only 'let', 'next', 'output' and 'block' lines may have"
        require_one(text, ("FZ214", message, "previous", "give it a name with 'let', and pass that name on"))

    def test_a_function_calls_no_system_with_a_state(self):
        system = SYSTEM.replace("output u in [-1, 1]", "output u in [-1, 1] else hold")
        assert errors_in(system + HEAD + "output y = rule(x)\n") == []
        ((code, message, _),) = errors_in(system + HEAD + "function f(a) = rule(a)\noutput y = f(x)\n")
        assert code == "FZ214"
        assert message == "'rule' keeps a state, which only 'let', 'next', 'output' and 'block' lines may have"

    def test_a_function_inside_a_system_is_one_of_that_system(self):
        text = SYSTEM.replace("param k = 1", "param k = 1\nfunction f(a, b) = a * b")
        text = text.replace("  terms N P\n", "  N = f(-k)\n  P = f(k)\n", 1)
        assert errors_in(text) == []
        assert [m for _, m, _ in errors_in(text + HEAD + "output y = f(x, 1)\n")] == ["no function or system 'f'"]

    @pytest.mark.parametrize("word", ["let", "state", "next", "block", "every"])
    def test_words_of_controllers_are_names_in_systems(self, word):
        text = SYSTEM.replace("terms N P\noutput", f"{word} = ramp(1, -1)\n  P = ramp(-1, 1)\noutput", 1)
        assert errors_in(text.replace("\n  N P\n| N P", f"\n  {word} P\n| N P")) == []

    def test_systems_do_not_take_statements_of_controllers(self):
        ((code, message, _),) = errors_in(SYSTEM + "state s = 1\n")
        assert (code, message) == ("FZ101", "'state' belongs to a controller")


@pytest.mark.parametrize(("names", "form"), [("u", "'rule(...)'"), ("uv", "'let NAME = rule(...)' and read 'NAME.u'")])
def test_a_call_as_systems_write_it_is_answered_with_the_form_of_controllers(names, form):
    outputs = "".join(f"output {name} in [0, 1] = x\n" for name in names)
    text = f"system rule\ninput x in [0, 1]\n{outputs}{HEAD}output y = rule.u(x)\n"
    examined = look_through(SourceText("c.fz", text))
    (found,) = (d for d in examined.diagnostics if d.severity == "error")
    assert (found.code, found.help) == ("FZ202", f"write {form}")


@pytest.mark.parametrize(
    ("lines", "repair"),
    [
        ("let z = 2 * sqrt(4)", "'z' is a let: write 'param z = 2 * sqrt(4)' in place of it"),
        ("let z = 2 * x", "'z' is a let, which may change while it runs; a constant begins with 'param'"),
        ("let z = previous(1)", "'z' is a let, which may change while it runs; a constant begins with 'param'"),
        ("state z = 2\nnext z = z", "'z' is a state, which may change while it runs; a constant begins with 'param'"),
    ],
)
def test_a_signal_in_a_param_of_a_call_is_answered_with_what_to_write(lines, repair):
    text = f"{SYSTEM}{HEAD}{lines}\noutput y = rule(x, k=1/z)\n"
    (found,) = (d for d in look_through(SourceText("c.fz", text)).diagnostics if d.severity == "error")
    assert (found.message, found.span.text, found.help) == ("no param 'z'", "z", repair)


@pytest.mark.parametrize(
    ("line", "mistake"),
    {
        "let a = if x > 0 then 1 else 2": ("FZ102", "unexpected 'x'", "x"),
        "let a = 1 if x > 0 else 2": ("FZ102", "unexpected 'if'", "if"),
        "let a = x > 0 ? 1 : 2": ("FZ105", "unexpected '?'", "?"),
        "let a = 1 when x > 0": ("FZ102", "unexpected 'when'", "when"),
        "if x > 0 then y = 1": ("FZ101", "'if' begins no statement", "if"),
        "when x > 0 y = 1": ("FZ101", "'when' begins no statement", "when"),
    }.items(),
)
def test_a_choice_in_the_words_of_other_languages_is_shown_as_where(line, mistake):
    require_one(f"controller c\ninput x\n{line}\noutput y = x\n", (*mistake, "where(CONDITION, VALUE, OTHER_VALUE)"))


@pytest.mark.parametrize("function", ["if", "iff", "ifelse", "case", "select"])
def test_a_choice_as_a_function_of_another_name_is_shown_as_where(function):
    text = f"controller c\ninput x\noutput y = {function}(x > 0, 1, 2)\n"
    require_one(text, ("FZ202", f"no function or system '{function}'", function, "did you mean 'where'?"))
