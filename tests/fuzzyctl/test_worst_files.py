"""Work grows no faster than files do, and limits bound it: lines and calls are counted, so that no clock decides."""

import gc
import itertools
import re
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

import fuzzyctl
from fuzzyctl import DiagnosticError, Experiment, loads, output_bounds
from fuzzyctl.testing import check_text, run_command

sys.path.insert(0, str(Path(__file__).parent.parent / "fuzz"))
from worst_files import CASES, HEAD  # its folder is no package

SUGENO = HEAD.replace("else 0\n", "else 0 defuzzifier weighted_average\n")
RULE = "if x is low then y is small\n"
PLANT = "plant p\ninput u\nstate h = 0\nder h = u - h\noutput y = h\n"
LOOP = f"{PLANT}loop l\nblock b0 = p(1)\nlet a0 = b0.y\nmeasure m0 = final(b0.y)\nrun 1 s step 100 ms\n"


def calls_of(call):
    """Return how many functions a call calls, which is the same on every machine."""
    count = 0

    def counted(_frame, event, _what):
        nonlocal count
        count += event == "call"

    sys.setprofile(counted)
    try:
        call()
    finally:
        sys.setprofile(None)
    return count


def lines_of(call):
    """Return how many lines are executed, each pass of a loop counted."""
    count = 0

    def counted(_frame, event, _what):
        nonlocal count
        count += event == "line"
        return counted

    before = sys.gettrace()
    sys.settrace(counted)
    try:
        call()
    finally:
        sys.settrace(before)
    return count


def checked(text):
    return check_text(text)[1]


def text_of(name, size):
    (text,) = CASES[name](size).values()
    return text


def worst(name):
    """Return a function from a number of KiB to the text of a worst case."""
    return lambda count: text_of(name, count / 1024)


def repeated(line, head="", tail=""):
    """Return a function from a count to a text of numbered lines: '@' is the number, '#' the one before it."""
    return lambda n: (
        head + "".join(line.replace("@", str(k)).replace("#", str(k - 1)) for k in range(1, n + 1)) + tail.format(n)
    )


def system(rules, head=HEAD):
    return repeated(rules, f"system s\n{head}")


def compiled(text):
    return fuzzyctl.compile(loads(text), "python")


def ran(text):
    return Experiment(loads(text, block="l"), "python").run()


def shown(text):
    with TemporaryDirectory() as folder:
        assert run_command("page", "-", "-o", f"{folder}/s.html", "--quiet", stdin=text).exit_code in (0, 1)


#: What is done with a text, by what grows, and the smaller of two sizes: the other is twice as large.
GROWING = {
    "names of a terms line": (checked, worst("names-in-one-terms-line"), 10),
    "long unknown names": (checked, worst("long-unknown-names"), 10),
    "systems": (checked, worst("small-systems"), 4),
    "rule blocks": (checked, worst("blocks-of-rules"), 6),
    "unknown params": (checked, repeated("param p@ = q@\n"), 200),
    "terms without use": (checked, repeated(" t@", "system s\ninput x in [0, 1]\n  terms"), 500),
    "operands of a rule": (checked, worst("one-rule-over-20-inputs"), 512),
    "operands of a rule without else": (checked, worst("one-rule-over-20-inputs-without-else"), 512),
    "refuted claims": (checked, system("require y <= 0 - @\n", SUGENO.replace(" else 0", "") + RULE), 200),
    "params of a claim": (checked, system("param p@ = @\n", f"{HEAD}{RULE}require y <= 9\n"), 300),
    "blocks of a loop": (ran, repeated("block b@ = p(b#.y)\n", LOOP), 40),
    "lets of a loop": (ran, repeated("let a@ = a# + 1\n", LOOP), 200),
    "measures of a loop": (ran, repeated("measure m@ = m# + 1\n", LOOP), 200),
    "states of a controller": (
        compiled,
        repeated(
            "state s@ in [-1, 1] = 0\nnext s@ = s@ / 2 + p@\nparam p@ = 0\n", "controller c\ninput e\noutput u = e\n"
        ),
        150,
    ),
    "functions as consequents": (compiled, system("if x is low then y is function(@ * x)\n", SUGENO), 150),
    "hedges of a rule": (compiled, repeated("very ", f"system s\n{HEAD}if x is ", "low then y is small\n"), 30),
    "bounds of consequents": (
        lambda text: output_bounds(loads(text)),
        system("if x is low then y is function(sin(a) + @)\n", f"{SUGENO}let a = x * 2\n"),
        80,
    ),
    "rules of a page": (shown, system(RULE), 150),
    "parentheses": (checked, lambda n: f"param p = {'(1 + ' * n}1{')' * n}\n", 45),
}


@pytest.fixture(autouse=True, scope="module")
def _warm():
    """Import what the operations import, and build the grammar."""
    for operation, make, _ in GROWING.values():
        operation(make(2))


@pytest.mark.parametrize("name", GROWING)
def test_work_grows_with_the_size_of_a_file(name):
    operation, make, size = GROWING[name]
    small, large = (lines_of(lambda n=n: operation(make(n))) for n in (size, 2 * size))
    assert large < (4 if name.startswith("operands") else 2.6) * small


#: Cases whose work the budget of a check bounds: the size at which they are tried, and the most calls. Without the
#: budget the second takes 5,000,000.
@pytest.mark.parametrize(
    ("name", "size", "most"),
    [
        pytest.param("a-hedge-that-turns-often-in-a-row", 1.0, 10_000_000, marks=pytest.mark.long),
        pytest.param("own-hedges-of-consequents", 0.3, 1_000_000, marks=pytest.mark.long),
        ("own-hedges-that-turn-often", 0.05, 2_000_000),
    ],
)
def test_work_of_own_hedges_is_bounded(name, size, most):
    assert calls_of(lambda: checked(text_of(name, size))) < most


@pytest.mark.parametrize(
    ("name", "size", "most"),
    [
        pytest.param("a-thousand-samples-of-many-outputs", 0.2, 16_000_000, marks=pytest.mark.long),
        pytest.param("dead-rules-of-many-cells", 0.1, 18_000_000, marks=pytest.mark.long),
        ("many-gaussians", 0.2, 4_000_000),
        pytest.param("outputs-that-jump", 0.1, 18_000_000, marks=pytest.mark.long),
        pytest.param("rules-for-many-outputs-of-ten-inputs", 0.2, 18_000_000, marks=pytest.mark.long),
    ],
)
def test_searches_spend_the_work_of_a_check(name, size, most):
    assert lines_of(lambda: checked(text_of(name, size))) < most


@pytest.mark.parametrize("name", ["statements-with-an-open-parenthesis", "unclosed-quotes", "unknown-lines"])
@pytest.mark.long
def test_no_line_is_read_after_too_many_mistakes(name, monkeypatch):
    monkeypatch.setattr("fuzzyctl.lang.parser.MAX_MISTAKES", 50)  # a tenth
    small, large = (calls_of(lambda s=s: checked(text_of(name, s))) for s in (0.005, 0.02))
    assert large < 1.1 * small


@pytest.mark.parametrize(
    ("name", "size"), [("own-hedges-that-turn-often", 0.2), ("a-hedge-that-turns-often-in-a-row", 1.0)]
)
def test_bounds_end_in_time_where_operations_are_not_counted(name, size, monkeypatch):
    used = itertools.count(step=0.5)  # each look at the clock is half a second
    monkeypatch.setattr("fuzzyctl.analysis.work.clock.used", lambda: next(used))
    result = run_command("prove", "--bounds", "-", stdin=text_of(name, size))
    assert result.exit_code == 0
    assert "the time is spent" in result.output
    assert next(used) < 100.0


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("many-rules-of-one-input", 0.45),
        ("a-long-piecewise-output", 0.1),
        ("a-million-samples-of-many-terms", 0.2),
        pytest.param("a-long-piecewise", 0.5, marks=pytest.mark.long),
        pytest.param("inputs-of-a-thousand-terms-in-one-rule", 1.0, marks=pytest.mark.long),
    ],
)
def test_pages_of_large_systems_are_refused_before_anything_is_proved(name, size, tmp_path, monkeypatch):
    monkeypatch.setattr("fuzzyctl.analysis.check.check_changed", lambda *_, **__: pytest.fail("it is checked"))
    result = run_command("page", "-", "-o", tmp_path / "s.html", "--quiet", stdin=text_of(name, size))
    assert result.exit_code == 1
    assert re.search(r"takes about [\d,]+ operations, more than 50,000", result.errors)
    assert not (tmp_path / "s.html").exists()


#: Texts beyond a limit, and how they are refused.
TOO_MUCH = {
    "variables": (
        lambda: text_of("thousands-of-inputs", 0.1),
        r"the system has \d+ inputs, outputs and lets, more than 2000",
    ),
    "terms": (
        lambda: (
            f"system s\n{HEAD}"
            + "".join(f"input x{k} in [0, 1]\n  terms {' '.join(f't{i}' for i in range(1000))}\n" for k in range(25))
        ),
        "the variables of the system have 25004 terms, more than 25000",
    ),
    "guarantees": (
        lambda: text_of("claims-that-hold", 1.0) + "require y <= 2\n",
        "the system has 1001 guarantees, more than 1000",
    ),
    "rules": (lambda: text_of("a-table-that-is-too-large", 0.15), "the system has 22500 rules, more than 20000"),
    "outputs": (
        lambda: f"system s\n{HEAD}{RULE}" + "".join(f"output v{k} in [0, 1] = x\n" for k in range(200)),
        "the system has 201 outputs, more than 200",
    ),
    "own hedges": (
        lambda: (
            f"system s\nhedge h(x) = {' * '.join(['x'] * 90)}\ninput x in [0, 1]\n"
            f"  terms {' '.join(f't{k}' for k in range(60))}\noutput y in [0, 1] else 0\n  terms small large\n"
            + "".join(f"if x is {'h ' * 10}t{k} then y is small\n" for k in range(60))
        ),
        ".*",
    ),
}


@pytest.mark.parametrize("name", TOO_MUCH)
def test_more_than_a_limit_allows_is_one_error(name):
    make, message = TOO_MUCH[name]
    (error,) = (d for d in checked(make()) if d.severity == "error")
    assert error.code == "FZ112"
    assert re.fullmatch(message, error.message)


def test_more_systems_than_a_file_may_have_are_refused():
    with pytest.raises(DiagnosticError, match="holds 201 systems, controllers, plants and loops"):
        loads("".join(f"system s{k}\n" for k in range(201)))


def test_commands_collect_garbage_seldom():
    threshold = gc.get_threshold()
    try:
        run_command("explain", "FZ112")
        assert gc.get_threshold()[0] >= 50_000
    finally:
        gc.set_threshold(*threshold)
