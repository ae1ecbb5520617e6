"""Systems written as FCL read back as they were, and no text breaks the reader."""

import math

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from fuzzyctl import as_profile, loads
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import ONE, Binary, Call, Name, Number
from fuzzyctl.formats.fcl import read_all, write
from fuzzyctl.kernels.compile import compile as compiled
from fuzzyctl.model.checks.checks import check_model
from fuzzyctl.model.method import Method
from fuzzyctl.model.profiles import PROFILES
from fuzzyctl.model.rule import Consequent, Is, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Membership, Output, Term
from tests.effort import at_most
from tests.fuzzyctl.formats.drawn_fcl import systems
from tests.fuzzyctl.formats.drawn_parts import number
from tests.sizes import examples


def read_back(text):
    found, diagnostics = read_all(SourceText("drawn.fcl", text))
    assert len(found) == 1, [d.message for d in diagnostics]
    return found[0]


@settings(deadline=None, max_examples=examples(60), suppress_health_check=list(HealthCheck))
@given(systems())
def test_what_is_written_reads_back_as_the_same_system(system):
    assume(not any(d.severity == "error" for d in check_model(system)))
    text, losses = write(system)
    assert [x for x in losses if x.what != "not"] == [], text  # fuzzylite has none before a condition
    assert read_back(text) == system, text


def test_nothing_is_left_to_do_the_second_time():
    text, _ = write(loads(TIPPER, "tipper.fcl"))
    again, losses = write(read_back(text))
    assert again == text
    assert losses == []


TIPPER = """FUNCTION_BLOCK tipper // as jFuzzyLogic has it
VAR_INPUT service : REAL; RANGE := (0 .. 10); food : REAL; RANGE := (0 .. 10); END_VAR
VAR_OUTPUT tip : REAL; END_VAR
FUZZIFY service
 TERM poor := GAUSS 0 1.5; TERM good := GAUSS 5 1.5; TERM excellent := GAUSS 10 1.5;
END_FUZZIFY
FUZZIFY food
 TERM rancid := TRAPE -2 0 1 3; TERM delicious := TRAPE 7 9 10 12;
END_FUZZIFY
DEFUZZIFY tip
 TERM cheap := TRIAN 0 5 10; TERM average := TRIAN 10 15 20; TERM generous := TRIAN 20 25 30;
 METHOD : COG; DEFAULT := 0; RANGE := (0 .. 30);
END_DEFUZZIFY
RULEBLOCK rules
 ACCU : MAX; AND : MIN; ACT : MIN;
 RULE 1 : IF service IS poor OR food IS rancid THEN tip IS cheap;
 RULE 2 : IF service IS good THEN tip IS average;
 RULE 3 : IF service IS excellent OR food IS delicious THEN tip IS generous;
END_RULEBLOCK
END_FUNCTION_BLOCK
"""


def test_the_tipper_has_the_numbers_of_jfuzzylogic():
    # Run with jFuzzyLogic, revision 1f421d1b.
    points = {(2, 1): 7.0151131237, (4, 5): 14.4530473104, (7, 8): 20.3444408811, (1, 2): 5.5540191962}
    kernel = compiled(loads(TIPPER, "tipper.fcl"))
    for point, value in points.items():
        assert abs(kernel(*point) - value) < 5e-11  # the digits printed


def minimal(**update):
    x = Input(name="x", lower=number(0), upper=number(1), terms=(term("a", "triangle", 0, 0, 1),), extrapolate=True)
    y = Output(name="y", lower=number(0), upper=number(1), terms=(term("b", "triangle", 0, 1, 1),), otherwise="nan")
    rule = Rule(antecedent=Is(variable="x", term="a"), consequents=(Consequent(output="y", term="b"),))
    fields = {"name": "m", "inputs": (x,), "outputs": (y,), "blocks": (rule,)}
    return FuzzySystem(**(fields | update))


def term(name, kind, *values):
    return Term(name=name, membership=Membership(kind=kind, arguments=tuple(map(number, values))))


def lossy(system):
    return [str(loss) for loss in write(system)[1] if not loss.exact]


def test_what_fcl_has_no_words_for_is_said():
    base = minimal()
    assert lossy(base) == []
    y, rule = base.outputs[0], base.blocks[0]
    sampled = Method(defuzzifier=PROFILES["matlab"].defuzzifier("centroid"))
    assert "defuzzifier" in lossy(minimal(method=sampled))[0]
    assert "else error" in lossy(minimal(outputs=(y.model_copy(update={"otherwise": "error"}),)))[0]
    assert "adaptive" in lossy(minimal(outputs=(y.model_copy(update={"adaptive": ONE}),)))[0]
    clamped = lossy(minimal(outputs=(y.model_copy(update={"clamped": True}),)))  # fuzzylite has a word, and samples
    assert [x for x in clamped if "clamp" in x] == []
    hedged = rule.model_copy(update={"antecedent": Is(variable="x", term="a", hedges=("slightly",))})
    assert any("hedge 'slightly'" in x for x in lossy(minimal(blocks=(hedged,))))
    after = Method(semantics=PROFILES["exact"].semantics.model_copy(update={"weight": "after"}))
    weighted = rule.model_copy(update={"weight": Number(0.5)})
    assert "weight after" in lossy(minimal(method=after, blocks=(weighted,)))[0]
    assert lossy(minimal(method=after)) == []


@pytest.mark.parametrize(
    ("profile", "terms", "tool"),
    [
        ("matlab", [("triangle", 0, 0, 1)], "exact"),
        ("exact", [("gaussian", 0, 1)], "jfuzzylogic"),
        ("matlab", [("gaussian", 0, 1)], "jfuzzylogic"),
        ("exact", [("s_shape", 0, 1)], "fuzzylite"),
        ("pyfuzzylite", [("s_shape", 0, 1)], "fuzzylite"),
        ("jfuzzylogic", [("gaussian", 0, 1)], "jfuzzylogic"),
        ("fuzzylite_6", [("s_shape", 0, 1)], "fuzzylite_6"),
        ("exact", [("triangle", 0, 0, 1)], "exact"),
    ],
)
def test_a_file_has_the_numerics_of_the_tool_that_reads_it_and_what_changes_is_said(profile, terms, tool):
    own = PROFILES[profile]
    method = Method(defuzzifier=own.defuzzifier("centroid"), semantics=own.semantics)
    x = minimal().inputs[0].model_copy(update={"terms": tuple(term("a", *t) for t in terms)})
    y = minimal().outputs[0].model_copy(update={"otherwise": Number(0.5)})
    system = minimal(method=method, inputs=(x,), outputs=(y,))
    text, losses = write(system)
    back = read_back(text)
    assert back.method.semantics.profile == tool
    assert back.method.defuzzifier == PROFILES[tool].defuzzifier("centroid")
    reported = [loss.what for loss in losses if not loss.exact]
    assert any(what.startswith("defuzzifier") for what in reported) == (method.defuzzifier != back.method.defuzzifier)
    differs = method.defuzzifier != back.method.defuzzifier or "least 0.0" in reported
    assert bool(reported) == (profile != tool and differs)
    points = [0.0, 0.1, 0.25, 0.5, 0.7, 0.9]
    same = [back(x=p) for p in points] == pytest.approx([system(x=p) for p in points], rel=1e-12, nan_ok=True)
    assert same == (method.defuzzifier == back.method.defuzzifier)


def test_sums_have_the_words_that_fuzzylite_reads():
    fuzzylite = PROFILES["fuzzylite"]
    sets = Method(aggregation="sum", defuzzifier=fuzzylite.defuzzifier("centroid"), semantics=fuzzylite.semantics)
    assert "ACCU : UnboundedSum;" in write(minimal(method=sets))[0]
    output = minimal().outputs[0].model_copy(update={"terms": (term("b", "singleton", 1),)})
    averages = sets.model_copy(update={"defuzzifier": fuzzylite.defuzzifier("weighted_average")})
    text, losses = write(minimal(method=averages, outputs=(output,)))
    assert "ACCU" not in text
    assert [x for x in losses if not x.exact] == []
    assert "if x is a then y is b\n" in text


def test_shoulders_are_points_and_functions_keep_their_value():
    wave = Call("exp", (Binary("*", Name("x"), Number(-0.5)),))
    shoulder = term("a", "triangle", -math.inf, 0, 1)
    x = minimal().inputs[0].model_copy(update={"terms": (shoulder,)})
    y = (
        minimal()
        .outputs[0]
        .model_copy(
            update={
                "terms": (Term(name="b", membership=Membership(kind="function", arguments=(wave,))),),
                "otherwise": Number(0.0),
            }
        )
    )
    method = Method(defuzzifier=PROFILES["exact"].defuzzifier("weighted_average"))
    system = minimal(inputs=(x,), outputs=(y,), method=method)
    text, losses = write(system)
    assert all(x.exact for x in losses)
    assert "TERM a := (0, 1) (1, 0);" in text
    assert "FUNCTION EXP(x * -0.5)" in text
    assert read_back(text)(x=0.3) == system(x=0.3) == math.exp(-0.15)


def test_names_that_fcl_cannot_hold_are_changed_and_that_is_said():
    x = minimal().inputs[0].model_copy(update={"name": "Drehzahl [1/min]"})
    rule = Rule(antecedent=Is(variable=x.name, term="a"), consequents=minimal().blocks[0].consequents)
    text, losses = write(minimal(inputs=(x,), blocks=(rule,), name="MIN"))
    assert "Drehzahl_1_min : REAL;" in text
    assert "FUNCTION_BLOCK MIN_" in text
    assert sorted(x.what for x in losses if "name" in x.what) == ["the name 'Drehzahl [1/min]'", "the name 'MIN'"]


WORDS = st.sampled_from(
    "FUNCTION_BLOCK END_FUNCTION_BLOCK VAR_INPUT END_VAR FUZZIFY x END_FUZZIFY TERM low := ( 0 , 1 ) ; DEFUZZIFY "
    "METHOD : COG RANGE .. RULEBLOCK RULE IF IS THEN AND OR NOT WITH DEFAULT NC | ACCU END_RULEBLOCK FUNCTION + - * / "
    "^ % TRIAN Triangle nan inf (* *) /* // # { \n".split(" ")
)


def survives(text):
    with at_most(5):
        found, diagnostics = read_all(SourceText("drawn.fcl", text))
        assert found or diagnostics


@settings(deadline=None, max_examples=examples(200))
@given(st.lists(WORDS, max_size=60).map(" ".join))
def test_any_words_are_read_or_reported(text):
    survives(text)


@settings(deadline=None, max_examples=examples(200))
@given(st.data())
def test_any_change_of_a_file_is_read_or_reported(data):
    text = TIPPER
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text)))
        until = min(len(text), at + data.draw(st.integers(0, 30)))
        text = text[:at] + data.draw(st.text(max_size=6) | WORDS) + text[until:]
    survives(text)


def test_a_large_file_takes_bounded_time():
    survives(TIPPER.replace("RULE 1", "RULE 1 : IF food IS nothing THEN tip IS cheap;\nRULE 1") * 150)
    survives("RULE 1 : IF (" * 30_000)
    survives("TERM a := (" * 30_000)


TSUKAMOTO = """\
system s
defuzzifier {method}
input x in [0, 10]
  low = triangle(-inf, 0, 10)
  high = ramp(0, 10)
output y in [0, 20] else 0
  a = {a}
  b = {b}
if x is low then y is a
if x is high then y is b
"""


@pytest.mark.parametrize(
    ("method", "a", "b"),
    [
        ("tsukamoto", "s_shape(5, 12)", "ramp(5, 10)"),
        ("tsukamoto", "triangle(0, 8, inf)", "pi_shape(-inf, 2, 5, 9)"),
        ("tsukamoto_sum", "piecewise(5, 0, 12, 1)", "ramp(5, 10)"),
        ("inverse_tsukamoto", "triangle(0, 8, inf)", "gaussian(5, 2)"),
        ("inverse_tsukamoto_sum", "triangle(0, 8, 9)", "gaussian(5, 2)"),
    ],
)
def test_tsukamotos_methods_are_written_for_fuzzylite_and_read_back(method, a, b):
    system = loads(TSUKAMOTO.format(method=method, a=a, b=b))
    text, losses = write(system)
    assert "METHOD : COGS" in text
    assert [x for x in losses if not x.exact] == []
    again = read_back(text)
    assert again.method.defuzzifier.kind == method
    places = [x / 4 for x in range(41)]
    assert [again(x=x) for x in places] == [system(x=x) for x in places]


@pytest.mark.parametrize("held", ["", " extrapolate"])
@pytest.mark.parametrize("term", ["gaussian2(-inf, 1, 3, 2)", "gaussian2(6, 2, inf, 1)", "triangle(-inf, 3, 7)"])
def test_sides_that_never_end_are_read_back(term, held):
    text = TSUKAMOTO.format(method="centroid", a=term, b="ramp(5, 10)").replace("triangle(-inf, 0, 10)", term)
    system = loads(text.replace("[0, 10]", f"[0, 10]{held}"))
    if term.startswith("gaussian2"):
        system = as_profile(system, "fuzzylite")
    written, losses = write(system)
    assert [x for x in losses if not x.exact and x.what != "clamped to its range"] == []
    again = read_back(written)
    places = [-30.0, -1.0, *(x / 4 for x in range(41)), 11.0, 40.0] if held else [x / 4 for x in range(41)]
    assert [again(x=x) for x in places] == pytest.approx([system(x=x) for x in places], rel=1e-12)


def test_a_system_of_fuzzylite_without_any_word_of_its_own_stays_one():
    text = TSUKAMOTO.format(method="weighted_average", a="singleton(3)", b="singleton(5)")
    text = text.replace("system s", "system s\nsemantics fuzzylite").replace("[0, 10]", "[0, 10] extrapolate")
    text = text.replace("triangle(-inf, 0, 10)", "piecewise(0, 1, 10, 0)").replace(
        "ramp(0, 10)", "piecewise(0, 0, 10, 1)"
    )
    again = read_back(write(loads(text))[0])
    assert again.method.semantics.profile == "fuzzylite"


@pytest.mark.parametrize(
    ("condition", "written"),
    [("any a", "any"), ("any very a", "any"), ("very any a", "very any"), ("not any a", "not any")],
)
def test_nothing_stands_behind_any_as_fuzzylite_takes_nothing_there(condition, written):
    system = loads(
        "system t\ndefuzzifier weighted_average\ninput x in [0, 10]\n  a = ramp(10, 0)\noutput y in [0, 4] else 2\n"
        f"  p = constant(1)\n  q = constant(3)\nif x is {condition} then y is p\nif x is a then y is q\n"
    )
    text, _ = write(system)
    assert f"if x is {written} then y is p\n" in text
    (back,), _ = read_all(SourceText("t.fcl", text))
    for x in (0.0, 2.5, 7.0, 10.0):
        assert back(x=x) == pytest.approx(system(x=x), rel=1e-12)


def test_many_terms_of_one_name_and_characters_without_meaning_take_their_time_only():
    text = write(loads(TSUKAMOTO.format(method="centroid", a="ramp(0, 9)", b="ramp(9, 0)")))[0]
    with at_most(8):
        again = read_back(text.replace("  TERM a :=", f"{'  TERM a := Ramp 0 9;' * 4000}\n  TERM a :=", 1))
        assert len({t.name for t in again.outputs[0].terms}) == 4002
        _, diagnostics = read_all(SourceText("x.fcl", "$@" * 40_000))
        assert len(diagnostics) < 110


@pytest.mark.parametrize(("name", "written"), [("σ", "sigma"), ("Qualität", "Qualitat"), ("Δe [m/s]", "Deltae_m_s")])
def test_names_beyond_ascii_are_spelt(name, written):
    x = minimal().inputs[0].model_copy(update={"name": name})
    rule = Rule(antecedent=Is(variable=name, term="a"), consequents=minimal().blocks[0].consequents)
    assert f"  {written} : REAL;" in write(minimal(inputs=(x,), blocks=(rule,)))[0]


def test_a_pi_shape_without_sides_is_one_again():
    text = "system s\nsemantics fuzzylite\ninput a in [0, 1] extrapolate\n  low = gaussian(0, 1)\n"
    text += "output f in [0, 1] else nan\n  low = pi_shape(0, 0, 1, 1)\nif a is low then f is low\n"
    system = loads(text)
    assert read_back(write(system)[0]).outputs == system.outputs
