"""What an importer may ask of an FMU: samples between communication points, states, errors, messages."""

import subprocess

import fmpy.validation
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.fuzzyctl.codegen.conftest import STRICT, averaged, text, written
from tests.fuzzyctl.codegen.fmu.fmus import write_fmu
from tests.fuzzyctl.codegen.fmu.test_agreement import TANK
from tests.fuzzyctl.codegen.steps.targets import by_kernel
from tests.fuzzyctl.codegen.steps.texts import TEXTS
from tests.sizes import examples

COUNTER = """controller counter
input x in [-2, 2]
param gain in (0, 10] = 2
param double = 2 * gain
state n = 0
next n = n + gain * x
output y "count" unit "m" = n
every 0.1 s
"""
VERSIONS = pytest.mark.parametrize("version", [2, 3])


#: Models that differ in what their FMUs hold.
MODELS = {
    "counter": COUNTER,
    "greek": TEXTS["greek"],
    "clock": TEXTS["clock"],
    "operators": TEXTS["operators"],
    "system": averaged("gaps", otherwise=" else error"),
    "plant": TANK,
}
#: In the test line each has one version: they differ in their descriptions, which golden texts hold.
DESCRIBED = [
    pytest.param(model, version, id=f"{name}-{version}", marks=[pytest.mark.long] if (k + version) % 2 else [])
    for k, (name, model) in enumerate(MODELS.items())
    for version in (2, 3)
]


@pytest.mark.parametrize(("model", "version"), DESCRIBED)
def test_fmpy_finds_no_problem_and_the_c_compiles_without_a_warning(model, version, built, tmp_path):
    made = built(model, version)
    assert fmpy.validation.validate_fmu(str(made.path)) == []
    if version == 3:
        (build,) = fmpy.model_description.read_build_description(made.folder)
        assert build.sourceFileSets[0].sourceFiles[-1] == "fmi3.c"
    prefix = f"-DFMI{version}_FUNCTION_PREFIX=own_"
    flags = [*STRICT, "-Wshadow", prefix, "-c", f"sources/fmi{version}.c", "-o", str(tmp_path / "own.o")]
    subprocess.run(["cc", *flags], cwd=made.folder, check=True)
    assert b"own_fmi" in (tmp_path / "own.o").read_bytes()


@VERSIONS
def test_a_controller_samples_at_its_own_instants(built, version):
    made = built(COUNTER, version)
    small, large = made.instance(start=3.0), made.instance(start=3.0)
    found = [small.step(0.025, x=1.0)[0] for _ in range(10)]
    assert found == [0, 0, 0, 0, 2, 2, 2, 2, 4, 4]
    assert [large.step(size, x=1.0)[0] for size in (0.3, 0.1, 0.15, 0.05)] == [4, 6, 10, 10]


@given(
    sizes=st.lists(st.integers(1, 30), min_size=1, max_size=20),
    start=st.floats(-10, 10),
    inputs=st.lists(st.floats(-2, 2), min_size=20, max_size=20),
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=examples(100, 20))
def test_samples_do_not_hang_on_the_communication_steps(built, sizes, start, inputs):
    """Steps of 10 ms to 0.3 s: the samples lie in [begin, end), each with the input of its step."""
    instance = built(COUNTER).instance(start=start)
    total, before, made, ticks = 0.0, 0.0, 0, 0
    for size, x in zip(sizes, inputs, strict=False):
        ticks += size
        while made * 10 < ticks:
            before, total, made = total, total + 2 * x, made + 1
        assert instance.step(size / 100, x=x) == pytest.approx([before], abs=1e-12)
    built(COUNTER).forget(instance)


@VERSIONS
def test_outputs_before_the_first_step_are_those_of_the_inputs(built, version):
    pid = built(TEXTS["pid"], version).instance(r=1.5, y=0.5)
    (before,) = pid.get("u")
    assert before == pytest.approx(by_kernel(TEXTS["pid"], np.array([[1.5, 0.5]]))[0, 0], abs=1e-12)
    assert pid.step(0.05) == [before]  # the state was not touched


@VERSIONS
def test_states_are_copied_written_and_read(built, version):
    made = built(COUNTER, version)
    instance, other = made.instance(), made.instance()
    for _ in range(3):
        instance.step(0.1, x=1.0)
    own = instance.own
    state = own.getFMUState()
    size = own.serializeFMUState(state) if version == 3 else own.serializeFMUstate(state)
    assert instance.step(0.1) == [6]
    own.setFMUState(state)
    instance.time -= 0.1
    assert instance.step(0.1) == [6]
    copy = (other.own.deserializeFMUState if version == 3 else other.own.deSerializeFMUstate)(size)
    other.own.setFMUState(copy)
    other.time = 0.3 - 1e-17
    assert other.step(0.1) == [6]
    read = other.own.deserializeFMUState if version == 3 else other.own.deSerializeFMUstate
    with pytest.raises(FMICallException):
        read(size[:-1])
    with pytest.raises(FMICallException):
        read(b"x" + size[1:])
    assert "this is no state of this FMU" in made.messages[-1][1]


@VERSIONS
def test_a_reset_begins_anew(built, version):
    instance = built(COUNTER, version).instance(gain=5.0)
    instance.step(0.1, x=1.0)
    instance.own.reset()
    assert instance.get("gain", "x", "y") == [2, 0, 0]
    if version == 2:
        instance.own.setupExperiment(startTime=1.0)
    instance.initialize(1.0)
    assert [instance.step(0.1, x=1.0)[0] for _ in range(2)] == [0, 2]


@VERSIONS
def test_nan_gives_nan_leaves_the_state_and_is_logged_once(built, version):
    made = built(COUNTER, version)
    instance = made.instance()
    for x in (1.0, 1.0):
        instance.step(0.1, x=x)
    assert all(np.isnan(instance.step(0.1, x=float("nan"))) for _ in range(3))
    assert instance.step(0.1, x=1.0) == [4]
    assert [m for m in made.messages if m[0] == "logStatusWarning"] == [
        ("logStatusWarning", f"fmi{version}DoStep: input 'x' is NaN from t = 0.2 s on")
    ]


@VERSIONS
def test_samples_are_logged_where_they_are_wanted(built, version):
    made = built(COUNTER, version)
    instance = made.instance()
    instance.own.setDebugLogging(True, ["logEvents"]) if version == 3 else instance.own.fmi2SetDebugLogging(
        instance.own.component, 1, 0, None
    )
    instance.step(0.2, x=1.0)
    assert [m[1] for m in made.messages] == ["sample 1 at t = 0 s", "sample 2 at t = 0.1 s"]


@VERSIONS
@pytest.mark.parametrize(
    ("act", "message"),
    [
        (lambda i: i.set(gain=0.0), "parameter 'gain' must be from 2.22507386e-308 to 10, got 0"),
        (lambda i: i.set(gain=float("nan")), "parameter 'gain' must be from"),
        (lambda i: i.set(y=1.0), "'y' is no input and no parameter"),
        (lambda i: i.step(float("inf")), "expected a finite time"),
        (lambda i: i.step(-0.1), "expected a"),
        (lambda i: i.step(float("nan")), "expected a"),
        (lambda i: i.own.doStep(float("nan"), 0.1), "expected a finite time"),
        (lambda i: i.own.doStep(-0.1, 0.1), "the step begins at -0.1 s, the one before ended at 0 s"),
        (lambda i: i.own.doStep(0.5, 0.1), "the step begins at 0.5 s, the one before ended at 0 s"),
        (lambda i: i.own.exitInitializationMode(), "not allowed between steps"),
        (lambda i: i.references.update(q=99) or i.get("q"), "no variable has the reference 99"),
        (lambda i: i.own.getString([1]), "there is no variable of this type"),
    ],
)
def test_what_an_importer_does_wrong_is_an_error_with_a_message(built, version, act, message):
    made = built(COUNTER, version)
    instance = made.instance()
    with pytest.raises(FMICallException, match="error"):
        act(instance)
    category, reported = made.messages[-1]
    assert category == "logStatusError"
    assert reported.startswith("fmi")
    assert message in reported


def test_a_step_of_no_length_does_nothing_in_fmi_2_and_is_an_error_in_fmi_3(built):
    instance = built(COUNTER, 2).instance()
    assert [instance.step(size, x=1.0)[0] for size in (0.1, 0.0, 0.0, 0.1)] == [0, 0, 0, 2]
    with pytest.raises(FMICallException):
        built(COUNTER, 3).instance().step(0.0)


@VERSIONS
def test_a_run_ends_where_no_rule_fires_and_can_be_reset(built, version):
    made = built(TEXTS["refusing"], version)
    instance = made.instance(x=2.0)
    instance.step(0.05)
    with pytest.raises(FMICallException):
        instance.step(0.05, x=0.0)
    assert made.messages[-1][1].startswith(f"fmi{version}DoStep: no rule fires for output 'u' at t = 0.05")
    with pytest.raises(FMICallException):
        instance.step(0.05, x=2.0)
    assert "not allowed after an error" in made.messages[-1][1]
    instance.own.reset()


def test_a_state_that_leaves_its_range_ends_the_run(built):
    made = built(TANK.replace("[0, inf)", "[0, 2]"))
    instance = made.instance()
    with pytest.raises(FMICallException):
        [instance.step(0.1, v=10.0) for _ in range(50)]
    assert "state 'h' is not a number, or left its range at t = " in made.messages[-1][1]


def test_another_token_is_refused(built):
    made = built(COUNTER)
    own, made.description.guid = made.description.guid, "{other}"
    with pytest.raises(Exception, match="instantiate"):
        made.instance(begin=False)
    made.description.guid = own
    assert made.messages == [
        (
            "logStatusError",
            f"fmi3InstantiateCoSimulation: expected the token {own}, as in modelDescription.xml",
        )
    ]


def test_variables_have_units_ranges_and_kinds(built):
    made = built(COUNTER, 2)
    known = {v.name: v for v in made.description.modelVariables}
    assert {n: (v.causality, v.variability) for n, v in known.items()} == {
        "x": ("input", "continuous"),
        "y": ("output", "discrete"),
        "gain": ("parameter", "tunable"),
    }
    assert (known["x"].min, known["x"].max, known["x"].start) == ("-2.0", "2.0", "0.0")
    assert (known["y"].unit, known["y"].description) == ("m", "count")
    assert made.description.defaultExperiment.stepSize == "0.1"


def test_params_that_are_not_free_are_constants(built):
    made = built(COUNTER, 3, "--free", "gain")
    known = {v.name: (v.variability, v.start) for v in made.description.modelVariables}
    assert known["gain"] == ("tunable", "2.0")
    own = averaged("own", "param p = 2").replace("constant(19)", "constant(p)")
    own += "\ncontroller c\ninput e in [0, 10]\nparam gain = 2\nparam double = 2 * gain\nparam begin = 1\n"
    own += "param time = 0.1\nparam heavy = 3\nstate s = begin\nnext s = double * e\n"
    own += "let k = own(gain * e, 0, p=heavy)\noutput u = k + s\nevery time\n"
    known = {v.name: v.variability for v in built(own).description.modelVariables if "param" in f"{v.causality}"}
    constants = [v.name for v in built(own).description.modelVariables if v.variability == "constant"]
    assert known == {"gain": "tunable"}
    assert constants == ["begin", "time", "heavy"]
    assert "the period depends on 'time'" in refused(own, "--free", "time")


def test_the_same_text_gives_the_same_fmu_and_another_text_another_token(built, tmp_path):
    one, other = built(COUNTER), built(COUNTER.replace("gain * x", "gain + x"))
    again = write_fmu(COUNTER, tmp_path / "own.fmu")
    assert one.path.read_bytes() == again.read_bytes()
    assert one.description.guid != other.description.guid


def refused(text, *options):
    found = written(text, "fmu", *options)
    assert found.code != 0
    return " ".join(found.errors.split())


@pytest.mark.parametrize(
    ("own", "message", "options"),
    [
        (text("fmi3DoStep"), "begins as names of the standard", ()),
        ("plant p\ninput u\nstate x = 0\nder x = delay(u, 1 s)\noutput y = x\n", "dead time", ()),
        ("plant p\ninput u\noutput y = 2 * u\n", "has no states", ()),
        (TANK, "depends on 'start'", ("--free", "start")),
    ],
)
def test_what_has_no_fmu_is_refused(own, message, options):
    assert message in refused(own, *options)


def test_any_label_is_an_attribute(built):
    label = "σ < 'a' & b > c; \U0001f600 ]]> é"
    for version in (2, 3):
        made = built(COUNTER.replace("counter\n", f'counter "{label}"\n', 1), version)
        assert made.description.description == label
