"""Work grows no faster than files do: functions called are counted, so that no clock decides."""

import gc
import itertools
import math
import pkgutil
import re
import sys
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from click.testing import CliRunner

from fuzzyctl.analysis import effects
from fuzzyctl.analysis.bounds import output_bounds
from fuzzyctl.analysis.branch_and_bound.boxed_system import System
from fuzzyctl.analysis.check import check_source
from fuzzyctl.analysis.coverage.box_search import BUDGET, Search
from fuzzyctl.analysis.coverage.coverage import uncovered_of
from fuzzyctl.analysis.degrees import Truths
from fuzzyctl.analysis.extremes import extents
from fuzzyctl.analysis.induction.prover import ControllerProver
from fuzzyctl.analysis.verdicts import Refuted, Witness
from fuzzyctl.analysis.work import COVERAGE, SpentError, Work
from fuzzyctl.cli.loading import claim_reports
from fuzzyctl.cli.main import main
from fuzzyctl.cli.page import _add
from fuzzyctl.codegen import javascript_parts
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.javascript_source import module
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.explain.trace import _Contributions
from fuzzyctl.expr import Name
from fuzzyctl.kernels.inference.inference import evaluation
from fuzzyctl.kernels.plan.build import degree_name, plan
from fuzzyctl.kernels.plan.expansion import equations_of
from fuzzyctl.kernels.program.printer import IEEE_SCALAR
from fuzzyctl.lang.csv_table import parse_csv_table
from fuzzyctl.lang.lines import LogicalLine, split
from fuzzyctl.lang.parser import MAX_OPERATORS, parse
from fuzzyctl.loading.assembly import MAX_FILES
from fuzzyctl.loading.examination import MAX_SYSTEMS
from fuzzyctl.loading.load import load, loads, look_through
from fuzzyctl.model.block import Param, ParamValues
from fuzzyctl.model.checks.partitions import spoilt_partitions
from fuzzyctl.model.computed_numbers import Numbers
from fuzzyctl.page.systems import SystemFacts
from fuzzyctl.resolve.block_expressions import Expressions
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.rules import resolve_antecedent, resolve_rule
from fuzzyctl.resolve.system import MAX_GUARANTEES, MAX_TERMS_IN_ALL, MAX_VARIABLES
from fuzzyctl.simulation.expansion import loop_equations
from fuzzyctl.simulation.experiment import Experiment
from fuzzyctl.simulation.judgement import Judgement
from fuzzyctl.simulation.panels import inputs_of_time
from fuzzyctl.simulation.source import RunSource

sys.path.insert(0, str(Path(__file__).parent.parent / "fuzz"))
from worst_files import CASES, HEAD  # its folder is no package

#: Cases whose work the budget of a check bounds: the size at which they are tried, and the most calls. Without the
#: budget the second takes 5,000,000.
BOUNDED = [
    pytest.param("a-hedge-that-turns-often-in-a-row", 1.0, 10_000_000, marks=pytest.mark.long),
    ("own-hedges-of-consequents", 0.3, 1_000_000),
    ("own-hedges-that-turn-often", 0.05, 2_000_000),
]
#: Cases with two sizes, the second twice the first, that took much more than twice the work.
GROWING = {
    "names-in-one-terms-line": 0.01,
    "long-unknown-names": 0.01,
    "small-systems": 0.01,
}

#: The same for loops that call nothing.
LOOPING = {
    "blocks-of-rules": 0.04,
}
#: Cases with searches, a size, and the most lines that are executed for them.
COUNTED = [
    pytest.param("a-thousand-samples-of-many-outputs", 0.2, 16_000_000, marks=pytest.mark.long),
    pytest.param("dead-rules-of-many-cells", 0.1, 18_000_000, marks=pytest.mark.long),
    ("many-gaussians", 0.2, 4_000_000),
    pytest.param("outputs-that-jump", 0.1, 18_000_000, marks=pytest.mark.long),
    pytest.param("rules-for-many-outputs-of-ten-inputs", 0.2, 18_000_000, marks=pytest.mark.long),
]


def calls_of(call, name=None):
    """Return how many functions, or functions of one name, a call calls, which is the same on every machine."""
    count = 0

    def counted(frame, event, _what):
        nonlocal count
        count += event == "call" and name in (None, frame.f_code.co_name)

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
    return check_source(SourceText("worst.fz", text))


def text_of(name, size):
    (text,) = CASES[name](size).values()
    return text


@pytest.fixture(autouse=True, scope="module")
def _warm():
    """Import what a check imports, and build the grammar."""
    checked(text_of("one-rule-over-20-inputs-without-else", 0.1))
    checked("system worst\nparam p = not 1\n")


@pytest.mark.parametrize(("name", "size"), GROWING.items())
def test_work_grows_with_the_size_of_a_file(name, size):
    small, large = (calls_of(lambda s=s: checked(text_of(name, s))) for s in (size, 2 * size))
    assert large < 2.6 * small


@pytest.mark.parametrize(("name", "size"), LOOPING.items())
def test_loops_grow_with_the_size_of_a_file(name, size):
    small, large = (lines_of(lambda s=s: checked(text_of(name, s))) for s in (size, 2 * size))
    assert large < 2.6 * small


RULE = "if x is low then y is small\n"


def test_an_explanation_looks_for_the_consequents_of_all_rules_once():
    class Counted(tuple):
        read = 0

        def __iter__(self):
            Counted.read += 1
            return super().__iter__()

    system = loads(f"system s\n{HEAD}{RULE * 5}")
    output = plan(system).outputs[0]
    output = replace(output, implied=Counted(output.implied))
    contributions = _Contributions(output, [1.0] * 5, [None] * 5, 5.0, None)
    for position, rule in enumerate(system.rules):
        assert len(contributions.by(position, rule.consequents)) == 1
    assert Counted.read == 1


@pytest.mark.parametrize(("name", "size", "most"), COUNTED)
def test_searches_spend_the_work_of_a_check(name, size, most):
    assert lines_of(lambda: checked(text_of(name, size))) < most


@pytest.mark.parametrize(("name", "size", "most"), BOUNDED)
def test_work_of_own_hedges_is_bounded(name, size, most):
    assert calls_of(lambda: checked(text_of(name, size))) < most


@pytest.mark.parametrize("otherwise", ["", "-without-else"])
def test_work_grows_with_the_inputs_of_a_rule(otherwise):
    small, large = (calls_of(lambda s=s: checked(text_of(f"one-rule-over-20-inputs{otherwise}", s))) for s in (0.5, 1))
    assert large < 4 * small


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("statements-with-an-open-parenthesis", marks=pytest.mark.long),
        pytest.param("unclosed-quotes", marks=pytest.mark.long),
        "unknown-lines",
    ],
)
def test_nothing_is_read_after_too_many_mistakes(name, monkeypatch):
    monkeypatch.setattr("fuzzyctl.lang.parser.MAX_MISTAKES", 50)  # a tenth
    small, large = (calls_of(lambda s=s: checked(text_of(name, s))) for s in (0.005, 0.02))
    assert large < 1.1 * small


def test_a_file_that_needs_no_repairs_is_read_once():
    assert calls_of(lambda: checked(f"{HEAD}param p = 1 2 3\n"), "_read_lines") == 1


@pytest.mark.parametrize(("most", "times"), [(200_000, 3), (1000, 2)])
def test_a_long_text_is_repaired_in_one_round(most, times, monkeypatch):
    monkeypatch.setattr("fuzzyctl.lang.recovery._READ", most)
    monkeypatch.setattr("fuzzyctl.lang.recovery._MOST", 1000)
    text = HEAD + "if x is low THEN y is small\n" * 50
    assert calls_of(lambda: parse(SourceText("worst.fz", text)), "_read_lines") == times


def test_where_reading_stops_nothing_is_repaired(monkeypatch):
    monkeypatch.setattr("fuzzyctl.lang.parser.MAX_WORDS", 40)
    text = HEAD + "if x is low then (y is small,\n  y is large)\n" * 50
    assert calls_of(lambda: parse(SourceText("worst.fz", text)), "_read_lines") == 1


class Words(frozenset):
    """Very many words, so that joining them with others would take long."""

    def __or__(self, other):
        pytest.fail("all words are copied")


def test_a_consequent_is_not_compared_with_all_others():
    class Compared(str):
        __hash__ = str.__hash__
        times = 0

        def __eq__(self, other):
            Compared.times += 1
            return str.__eq__(self, other)

    concluded = ", ".join(f"y{k} is small" for k in range(100))
    (rule,) = parse(SourceText("worst.fz", f"if x is low then {concluded}\n"))[0].statements
    consequents = tuple(replace(c, output=replace(c.output, text=Compared(c.output.text))) for c in rule.consequents)
    resolve_rule(Context(), replace(rule, consequents=consequents))
    assert Compared.times < 10 * 100


def test_names_of_a_block_are_sorted_once_for_all_mistakes():
    block, known = Expressions(Context(), None, {}.get), {"b", "a"}
    assert block.ordered(known) == ["a", "b"]
    assert block.ordered(known) is block.ordered(known)
    assert block.ordered({"c"}) == ["c"]


def test_outputs_of_an_instance_are_not_looked_for_among_all():
    class Members(dict):
        def __iter__(self):
            pytest.fail("all members are looked at")

    block = Expressions(Context(), None, {}.get, members=Members(b=("b.u",)))
    assert not block.formula(Name("b"), names={"b"})
    assert block.context.diagnostics[0].help == "write one of: b.u"


def test_unread_words_are_not_copied_for_each_unknown_block(monkeypatch):
    monkeypatch.setattr(
        "fuzzyctl.loading.blocks.Context", lambda **given: Context(**{**given, "unread": Words(given["unread"])})
    )
    _, (error,) = checked("controller c\ninput e\nblock b = wrost(e)\noutput u = e\n")
    assert error.message == "no controller 'wrost'"


def test_unread_words_are_not_copied_for_each_reserved_name():
    _, let = parse(SourceText("worst.fz", "system s\nlet and = x + 1\n"))[0].statements
    context = Context(unread=Words(["and"]))
    assert not context.declare(let.name, "a let")


def test_lines_above_mistakes_are_read_once_for_all_of_them(monkeypatch):
    seen = []
    monkeypatch.setattr("fuzzyctl.lang.recovery._RULE", Mock(match=lambda *at: seen.append(at)))
    params = "".join(f"param p{k} = {k}\n" for k in range(50))
    parse(SourceText("worst.fz", params + "if x is low THEN y is small\n" * 50))
    assert len(seen) <= 50


def test_names_are_looked_for_once_for_all_mistakes():
    text = HEAD + "if x is low THEN y is small\n" * 50
    assert calls_of(lambda: parse(SourceText("worst.fz", text)), "variables") == 1


def test_parentheses_are_not_measured_anew_at_each_level():
    def read(depth):
        from fuzzyctl.lang.grammar import parse_line

        text = "param p = " + "(1 + " * depth + "1" + ")" * depth
        line = LogicalLine(0, len(text), "param", "statement", "")
        assert parse_line(SourceText("worst.fz", text), line, "statement")[0] is not None

    assert calls_of(lambda: read(90)) < 4 * calls_of(lambda: read(30))


def test_own_hedges_are_applied_once_for_all_rules():
    hedge = f"hedge h(x) = {' * '.join(['x'] * 90)}\n"
    text = f"system s\n{hedge}{HEAD}"
    rule = f"if x is {'h ' * 10}low then y is small\n"
    one, twenty = (loads(text + count * rule) for count in (1, 20))

    def calls(system, *names):
        fresh = replace(system)  # which has no plan yet
        return calls_of(lambda: plan(fresh), *names)

    assert calls(twenty) < 5 * calls(one)
    assert calls(twenty, "__hash__") < 3 * calls(one, "__hash__")


def test_each_step_of_a_firing_strength_is_enclosed_once():
    hedge = "hedge h(x) = x * x * x * x\n"
    flat = plan(loads(f"system s\n{hedge}{HEAD}if x is {'h ' * 10}low then y is small\n"))
    strength = flat.strengths[flat.rules[0].strength]
    truths = Truths(flat, {degree_name(0): (0.0, 1.0)})
    assert calls_of(lambda: truths.strength(strength), "strength") == 1 + len(flat.steps)


def test_known_hedges_are_not_listed_for_each_rule():
    class Hedges(dict):
        def __iter__(self):
            pytest.fail("all hedges are looked at")

    (rule,) = parse(SourceText("worst.fz", "if x is h a then y is b\n"))[0].statements
    context = Context(hedges=Hedges(h=None))
    resolve_antecedent(context, rule.antecedent)
    assert "hedge" not in " ".join(d.message for d in context.diagnostics)


def test_nested_parentheses_are_split_in_one_piece(monkeypatch):
    monkeypatch.setattr("fuzzyctl.lang.lines._collect", lambda *_: pytest.fail("the line is read piece by piece"))
    (line,) = split(SourceText("worst.fz", "if x is a then y is b weight (1 / (1 + k))  # (a"))
    assert (line.word, line.comment) == ("if", "# (a")


@pytest.mark.parametrize(
    "value",
    ["(1 + " * 90 + "1" + ")" * 90, "-" * 90 + "1", "2^" * 90 + "1", "max(1, " * 90 + "1" + ")" * 90],
)
def test_expressions_as_deep_as_allowed_are_read(value):
    for line in (f"param p = {value}", f"let p = x - {value}"):
        assert parse(SourceText("worst.fz", line))[0].statements


PLANT = "plant p\ninput u\nstate h = 0\nder h = u - h\noutput y = h\n"
#: Lines of a loop by what they are; '@' is the number of a line, '#' that of the one before.
CHAINS = {
    "blocks": "block b@ = p(b#.y)\n",
    "lets": "let a@ = a# + 1\n",
    "measures": "measure m@ = m# + 1\n",
}


def loop_of(kind, count):
    """Return a loop of a chain of blocks, lets or measures."""
    text = "".join(CHAINS[kind].replace("@", str(k)).replace("#", str(k - 1)) for k in range(1, count))
    first = "block b0 = p(1)\nlet a0 = b0.y\nmeasure m0 = final(b0.y)\nrun 1 s step 100 ms\n"
    (loop,) = look_through(SourceText("worst.fz", f"{PLANT}loop l\n{first}{text}")).loops
    return loop


def test_the_text_of_a_run_grows_with_its_plants():
    def size(count):
        run = Experiment(loop_of("blocks", count), "python")
        return len("".join(RunSource(run.equations, run.programs, IEEE_SCALAR).lines()))

    assert size(80) < 2.2 * size(40)


@pytest.mark.parametrize(
    ("kind", "work"),
    [
        ("blocks", lambda loop: loop_equations(loop, ())),
        ("lets", inputs_of_time),
        ("measures", lambda loop: Judgement(loop).measures(np.zeros(2), lambda _: np.zeros(2), {})),
    ],
)
def test_chains_in_a_loop_are_followed_once(kind, work):
    loops = [loop_of(kind, count) for count in (100, 200)]
    small, large = (lines_of(lambda loop=loop: work(loop)) for loop in loops)
    assert large < 2.3 * small


def test_numbers_of_many_states_are_computed_without_a_look_at_all_names():
    def expanded(count):
        states = "".join(
            f"state s{k} in [-1, 1] = 0\nnext s{k} = s{k} / 2 + p{k}\nparam p{k} = 0\n" for k in range(count)
        )
        (controller,) = look_through(SourceText("c.fz", f"controller c\ninput e\noutput u = e\n{states}")).controllers
        return lines_of(lambda: equations_of(controller))

    assert expanded(200) < 2.3 * expanded(100)


def test_runs_end_with_the_time_however_many_claims_there_are(monkeypatch):
    claims = "".join(f"require u <= {k} + 2\n" for k in range(50))
    text = f"controller c\ninput e in [-1, 1]\nevery 1 s\noutput u = e\n{claims}"
    (controller,) = look_through(SourceText("c.fz", text)).controllers
    prover = ControllerProver(controller, 1.0, until=-math.inf)
    calls = counted_calls(monkeypatch, "fuzzyctl.analysis.induction.replay.Runs._run")
    assert not prover._reached
    assert len(calls) < 50


def test_what_a_page_says_of_rules_grows_with_their_number():
    def work(count):
        text = f"system s\n{HEAD}" + RULE * count
        unit = prepare(loads(text), text)
        return lines_of(lambda: SystemFacts(unit, ()).data())

    assert work(200) < 2.3 * work(100)


def test_a_page_computes_each_hedge_of_a_row_once():
    def work(count):
        text = f"system s\n{HEAD}if x is {'very ' * count}low then y is small\n"
        unit = prepare(loads(text), text)
        facts = SystemFacts(unit, ())
        facts.data()
        return calls_of(lambda: javascript_parts.module(unit, facts.shown))

    assert work(12) < 3 * work(6)


def test_names_are_not_looked_through_anew_for_each_mistake_of_a_large_file(monkeypatch):
    calls = counted_calls(monkeypatch, "fuzzyctl.resolve.context.Context._is_other")
    checked("".join(f"param p{k} = q{k}\n" for k in range(1000)))
    assert len(calls) < 40 * 1000  # of 1000 names for 500 mistakes


def test_coverage_is_looked_for_once_for_the_slopes_along_all_inputs(monkeypatch):
    calls = counted_calls(monkeypatch, "fuzzyctl.analysis.branch_and_bound.boxed_system.uncovered_of")
    head = "".join(f"input x{k} in [0, 1]\n  terms low high\n" for k in range(5))
    rules = "if x0 is low then y is small\nif x1 is high then y is large\n"
    extents(loads(f"system s\n{head}output y in [0, 1] else 0.5\n  terms small large\n{rules}"))
    assert len(calls) == 1


def test_lets_are_enclosed_once_for_all_consequents(monkeypatch):
    calls = counted_calls(monkeypatch, "fuzzyctl.analysis.bounds.enclosed")
    head = HEAD.replace("else 0\n", "else 0 defuzzifier weighted_average\n") + "let a = x * 2\n"
    rules = "".join(f"if x is low then y is function(sin(a) + {k})\n" for k in range(50))
    output_bounds(loads(f"system s\n{head}{rules}"))
    assert len(calls) < 10


def test_consequents_are_not_compared_with_all_others():
    head = HEAD.replace("else 0\n", "else 0 defuzzifier weighted_average\n")

    def work(count):
        rules = "".join(f"if x is low then y is function({k} * x)\n" for k in range(count))
        flat = plan(loads(f"system s\n{head}{rules}"))
        return calls_of(lambda: evaluation(flat), "__eq__")

    assert work(200) < 2.3 * work(100)


def test_no_kernel_is_compiled_for_bounds_of_a_system_that_takes_the_time_to_read(tmp_path, monkeypatch):
    calls = counted_calls(monkeypatch, "fuzzyctl.analysis.extremes.Judge")
    expr = " + ".join(["sin(x)"] * 40)
    rules = "".join(f"if x is low then y is function({expr} + {k})\n" for k in range(300))
    text = "system s\n" + HEAD.replace("else 0\n", "else 0 defuzzifier weighted_average\n") + rules
    (tmp_path / "s.fz").write_text(text, encoding="utf-8")
    result = CliRunner().invoke(main, ["prove", "--bounds", str(tmp_path / "s.fz"), "--timeout", "1"])
    assert result.exit_code == 0
    assert "the time is spent" in result.output
    assert not calls


@pytest.mark.parametrize(
    ("name", "size"), [("own-hedges-that-turn-often", 0.2), ("a-hedge-that-turns-often-in-a-row", 1.0)]
)
def test_bounds_end_in_time_where_operations_are_not_counted(name, size, tmp_path, monkeypatch):
    used = itertools.count(step=0.5)  # each look at the clock is half a second
    monkeypatch.setattr("fuzzyctl.analysis.work.used", lambda: next(used))
    (tmp_path / "s.fz").write_text(text_of(name, size), encoding="utf-8")
    result = CliRunner().invoke(main, ["prove", "--bounds", str(tmp_path / "s.fz")])
    assert result.exit_code == 0
    assert "the time is spent" in result.output
    assert next(used) < 100.0


class TestPages:
    @pytest.mark.parametrize(
        ("name", "size"),
        [
            ("many-rules-of-one-input", 0.45),
            ("a-long-piecewise", 0.5),
            ("a-long-piecewise-output", 0.1),
            ("a-million-samples-of-many-terms", 0.2),
            ("inputs-of-a-thousand-terms-in-one-rule", 1.0),
        ],
    )
    def test_of_large_systems_are_refused_before_anything_is_proved(self, name, size, tmp_path, monkeypatch):
        monkeypatch.setattr("fuzzyctl.analysis.check.check_changed", lambda *_, **__: pytest.fail("it is checked"))
        (tmp_path / "s.fz").write_text(text_of(name, size), encoding="utf-8")
        result = CliRunner().invoke(main, ["page", str(tmp_path / "s.fz"), "-o", str(tmp_path / "s.html"), "--quiet"])
        assert result.exit_code == 1
        assert re.search(r"takes about [\d,]+ operations, more than 50,000", result.output)
        assert not (tmp_path / "s.html").exists()

    def test_of_programs_that_turn_out_large_are_refused(self):
        text = text_of("rules-under-an-activation", 0.1)
        with pytest.raises(CodegenError, match="operations, more than 50,000"):
            module(prepare(loads(text), text))

    def test_compare_no_diagnostic_with_all_others(self):
        def work(count):
            known = [Diagnostic("FZ216", str(k), None) for k in range(count)]
            return lines_of(lambda: _add(known, list(known)))

        assert work(400) < 2.3 * work(200)


def test_claims_that_are_reported_are_not_compared_with_all_others():
    text = SourceText("worst.fz", "require u <= 1\n" * 400)

    def work(count):
        spans = [Span(text, 15 * k, 15 * k + 14) for k in range(count)]
        verdicts = [Refuted("u <= 1", Witness({}, ()), span=span) for span in spans]
        known = [Diagnostic("FZ404", "", span, witness={}) for span in spans[::2]]
        found = []
        return lines_of(lambda: found.extend(claim_reports(verdicts, known))), found

    (small, _), (large, found) = work(200), work(400)
    assert len(found) == 200
    assert large < 2.3 * small


def test_params_are_enclosed_once_for_all_boxes(monkeypatch):
    system = loads(f"system s\n{HEAD}{RULE}" + "".join(f"param p{k} = 1\n" for k in range(50)))
    boxed = System(system, plan(system))
    calls = counted_calls(monkeypatch, "fuzzyctl.analysis.branch_and_bound.boxed_system.constant")
    with np.errstate(all="ignore"):
        for _ in range(10):
            boxed.enclose([Name("y")], np.zeros((1, 1)), np.ones((1, 1)), sloped=True)
    assert len(calls) < 10 * 50


def counted_calls(monkeypatch, target):
    """Replace a function by itself, and return a list that grows with each call of it."""
    owner, name = target.rsplit(".", 1)
    function, calls = getattr(pkgutil.resolve_name(owner), name), []
    monkeypatch.setattr(target, lambda *a, **k: (calls.append(a), function(*a, **k))[1])
    return calls


def test_depths_of_a_long_antecedent_are_not_measured_anew():
    def planned(operands):
        terms = " ".join(f"t{k}" for k in range(40))
        antecedent = " or ".join(f"x is t{k}" for k in range(operands))
        head = f"system s\ninput x in [0, 1]\n  terms {terms}\noutput y in [0, 1] else 0\n  terms small large\n"
        system = loads(f"{head}if {antecedent} then y is small\n")
        return calls_of(lambda: plan(system))

    one, ten, forty = (planned(operands) for operands in (1, 10, 40))
    assert forty - one < 5 * (ten - one)


def test_few_pairs_of_rules_are_compared_part_by_part(monkeypatch):
    known = " ".join(f"t{k}" for k in range(10))
    head = f"system s\ninput x in [0, 1]\n  terms {known}\ninput z in [0, 1]\n  terms {known}\n"
    rules = "".join(f"if x is t{k // 10} and z is t{k % 10} then y is small\n" for k in range(100))
    calls = counted_calls(monkeypatch, "fuzzyctl.analysis.effects.Counter")
    checked(f"{head}output y in [0, 1]\n  terms small large\n{rules}")
    assert len(calls) < 100 * 100


def test_a_firing_strength_of_many_rules_is_enclosed_once(monkeypatch):
    calls = counted_calls(monkeypatch, "fuzzyctl.analysis.degrees.enclose")
    system = loads("system s\n" + HEAD + 500 * "if x is low then y is small\n")
    effects.diagnostics(system, plan(system))
    assert len(calls) < 100


def test_samples_are_not_computed_where_no_work_is_left(monkeypatch):
    outputs = "".join(f"output y{k} in [0, 1]\n  terms small large\n" for k in range(20))
    concluded = ", ".join(f"y{k} is small" for k in range(20))
    head = f"system s\ndefuzzifier centroid(resolution=1000)\ninput x in [0, 1]\n  terms low high\n{outputs}"
    flat = plan(loads(f"{head}if x is low then {concluded}\n"))
    calls = counted_calls(monkeypatch, "fuzzyctl.analysis.coverage.box_search.seen_points")
    uncovered_of(flat, Work(0))
    assert not calls


def test_degrees_of_a_terms_line_are_not_added_up(monkeypatch):
    monkeypatch.setattr("fuzzyctl.model.checks.partitions._Set.degree", lambda *_: pytest.fail("one is computed"))
    known = " ".join(f"t{k}" for k in range(10))
    system = loads(f"system s\n{HEAD.replace('low high', known)}if x is t0 then y is small\n")
    assert not list(spoilt_partitions(Numbers(system)))


def test_the_help_for_unused_terms_is_written_once_for_a_terms_line(monkeypatch):
    calls = counted_calls(monkeypatch, "fuzzyctl.model.checks.partitions._written")
    known = " ".join(f"t{k}" for k in range(10))
    head = HEAD.replace("low high", known)
    _, diagnostics = checked(f"system s\n{head}if x is t0 then y is small\n")
    assert len([d for d in diagnostics if d.code == "FZ208"]) == 10  # nine terms of the input, one of the output
    assert len(calls) == 2


def test_a_hole_reaches_along_all_inputs_at_little_work():
    """Whether a hole can be extended where the rule fires is not looked for in each of 7^k cells."""
    flat = plan(loads(text_of("inputs-of-a-thousand-terms-in-one-rule", 0.1)))
    work = Work(COVERAGE)
    hole = Search(flat, flat.outputs[0], True, work).verdict()
    assert COVERAGE - work.left < 0.5 * BUDGET
    ((name, short),) = ((n, s) for n, s in hole.region.items() if (s.lower, s.upper) != (0.0, 1.0))
    assert (name, short.lower, round(99 * short.upper)) == ("a23", 0.0, 22)


def test_own_hedges_spend_work_for_each_box():
    def spent(hedges):
        hedge = f"hedge h(x) = {' * '.join(['x'] * 80)}\n"
        head = HEAD.replace(" else 0", "")
        flat = plan(loads(f"system s\n{hedge}{head}if x is {'h ' * hedges}low then y is small\n"))
        work = Work(COVERAGE)
        Search(flat, flat.outputs[0], True, work).verdict()
        return COVERAGE - work.left

    assert spent(9) > 4.5 * spent(2)  # as many times as there are hedges


def test_own_hedges_of_more_parts_than_the_limit_are_refused():
    hedge = f"hedge h(x) = {' * '.join(['x'] * 90)}\n"
    terms = " ".join(f"t{k}" for k in range(60))
    rules = "".join(f"if x is {'h ' * 10}t{k} then y is small\n" for k in range(60))
    text = f"system s\n{hedge}input x in [0, 1]\n  terms {terms}\noutput y in [0, 1] else 0\n  terms small large\n"
    _, diagnostics = checked(text + rules)
    (error,) = (d for d in diagnostics if d.severity == "error")
    assert (error.code, error.span.line) == ("FZ112", 2)


def test_more_operators_than_the_limit_are_refused_before_a_line_is_read(monkeypatch):
    monkeypatch.setattr("fuzzyctl.lang.parser.split", lambda _: pytest.fail("lines are read"))
    text = "param p = 1" + " + 1" * (MAX_OPERATORS + 1)
    tree, (error,) = parse(SourceText("worst.fz", text))
    assert (error.code, error.message) == ("FZ112", "the file has 80,001 operators, more than 80,000")
    assert error.span.start == text.rindex("+")
    assert tree.lost_variable


def test_signs_of_numbers_texts_and_comments_are_no_operators(monkeypatch):
    monkeypatch.setattr("fuzzyctl.lang.parser.MAX_OPERATORS", 1000)
    line = 'a = piecewise(-1, -2e-3, - 3, [-4) # 1 - 2 "\nsource "1 - 2"\n'
    _, mistakes = parse(SourceText("worst.fz", line * 500))
    assert not [d for d in mistakes if "operators" in d.message]


def test_variables_are_counted_before_they_are_resolved(monkeypatch):
    monkeypatch.setattr("fuzzyctl.resolve.system.resolve_variable", lambda *_: pytest.fail("one is resolved"))
    _, diagnostics = checked(text_of("thousands-of-inputs", 0.2))
    (error,) = (d for d in diagnostics if d.severity == "error")
    assert (error.code, error.span.line) == ("FZ112", 2 * MAX_VARIABLES + 3)
    assert re.fullmatch(r"the system has \d+ inputs, outputs and lets, more than 2000", error.message)


def test_terms_are_counted_before_they_are_resolved(monkeypatch):
    monkeypatch.setattr("fuzzyctl.resolve.system.resolve_variable", lambda *_: pytest.fail("one is resolved"))
    inputs = "".join(f"input x{k} in [0, 1]\n  terms {' '.join(f't{i}' for i in range(1000))}\n" for k in range(25))
    _, diagnostics = checked(f"system s\n{HEAD}{inputs}")
    assert [d.message for d in diagnostics if d.severity == "error"] == [
        f"the variables of the system have 25004 terms, more than {MAX_TERMS_IN_ALL}"
    ]


def test_guarantees_are_counted_before_they_are_resolved(monkeypatch):
    monkeypatch.setattr("fuzzyctl.resolve.system.resolve_require", lambda *_: pytest.fail("one is resolved"))
    text = text_of("claims-that-hold", 1.0)
    _, diagnostics = checked(text + "require y <= 2\n")
    (error,) = (d for d in diagnostics if d.severity == "error")
    assert (error.code, error.span.line) == ("FZ112", 1 + text.count("\n"))
    assert error.message == f"the system has {MAX_GUARANTEES + 1} guarantees, more than {MAX_GUARANTEES}"


def test_names_of_a_param_are_looked_for_once_to_compute_it():
    text = "".join(f"param p{k} = p{k + 1} + 1 / 0\n" for k in range(50))
    params = parse(SourceText("worst.fz", text))[0].statements
    given = [Param(name=p.name.text, expression=p.expression) for p in params]
    assert calls_of(lambda: ParamValues(given, partial=True), "names_in") == 50


def test_rules_are_counted_before_they_are_resolved(monkeypatch):
    monkeypatch.setattr("fuzzyctl.resolve.system.resolve_blocks", lambda *_, **__: pytest.fail("rules are resolved"))
    _, diagnostics = checked(text_of("a-table-that-is-too-large", 0.15))
    assert [d.message for d in diagnostics] == ["the system has 22500 rules, more than 20000"]


def test_fields_of_a_csv_file_are_read_without_the_grammar(monkeypatch):
    def refused(*_):
        pytest.fail("the grammar is asked")

    monkeypatch.setattr("fuzzyctl.lang.csv_table.parse_line", refused)
    tree, _ = parse(SourceText("worst.fz", "table y = x\n"))
    table, mistakes = parse_csv_table(tree.statements[0], SourceText("worst.csv", ",low,high\n,small,large\n"))
    assert not mistakes
    assert [cell.terms[0].text for cell in table.rows[0].cells] == ["small", "large"]


def test_commands_collect_garbage_seldom():
    threshold = gc.get_threshold()
    try:
        CliRunner().invoke(main, ["explain", "FZ112"])
        assert gc.get_threshold()[0] >= 50_000
    finally:
        gc.set_threshold(*threshold)


class TestWork:
    def test_of_a_part_is_that_of_the_whole(self):
        whole = Work(100)
        part = whole.part(30)
        assert part.takes(20)
        assert (part.left, whole.left) == (10, 80)
        with pytest.raises(SpentError):
            part.spend(11)
        assert (part.left, whole.left) == (0, 70)

    def test_suffices_for_less_than_a_check(self):
        assert Work().left > BUDGET


class TestSystems:
    def test_more_than_the_limit_are_refused_with_a_repair(self):
        from fuzzyctl.diagnostics.diagnostic import DiagnosticError

        text = "".join(f"system s{k}\n" for k in range(MAX_SYSTEMS + 1))
        with pytest.raises(DiagnosticError, match="holds 201 systems, controllers, plants and loops"):
            loads(text)


class TestUsedFiles:
    def test_missing_ones_count_and_are_not_looked_for_beyond_the_limit(self, tmp_path):
        text = "system s\n" + "".join(f'use "gone{k}.fz"\n' for k in range(3 * MAX_FILES)) + HEAD
        _, diagnostics = check_source(SourceText("worst.fz", text), folder=tmp_path)
        messages = [d.message for d in diagnostics if d.code == "FZ218"]
        assert len(messages) == MAX_FILES + 1
        assert messages[-1] == f"more than {MAX_FILES} files are used"

    def test_each_is_read_once_however_many_ways_lead_to_it(self, tmp_path):
        """Layers of two files that use both files of the next layer: 2^20 ways from the first to the last."""
        body = "input x in [0, 1]\n  terms a b\noutput y in [0, 1] else 0\n  terms c d\nif x is a then y is c\n"
        for layer in range(20):
            for side in "lr":
                uses = "".join(f'use "{layer + 1}{other}.fz"\n' for other in "lr") if layer < 19 else ""
                text = f"{uses}system s{layer}{side}\n{body}"
                claim = f"require y == s{layer + 1}{side}.y\n" if layer < 19 else ""
                (tmp_path / f"{layer}{side}.fz").write_text(text + claim, encoding="utf-8")
        assert load(tmp_path / "0l.fz").compared[0].name == "s1l"
