"""Fuzzy sets of outputs that are formulas over the output: sampled, and refused where nothing samples them."""

import re
import runpy

import numpy as np
import pytest

from fuzzyctl import Defuzzifier, DiagnosticError, as_profile, compile, dump, load, loads
from fuzzyctl.kernels.compile import degrees
from fuzzyctl.testing import run_command
from tests import sizes

#: The same two sets twice: as formulas, and as kinds of their own.
FORMULAS = """\
system own
param top = 0.25
input e in [0, 1]
  terms L H
output u in [0, 1] else 0.5
  left  = function(lt(u, top) * u / top + ge(u, top) * (1 - u) / (1 - top))
  right = function(exp(-0.5 * ((u - 0.7) / 0.1)^2) + 0 / (u - 0.123456))
defuzzifier {defuzzifier}
implication {implication}
aggregation {aggregation}
if e is L then u is left
if e is H then u is right
if e is somewhat H then u is left weight 0.25
"""
KINDS = re.sub("left  = .*", "left = triangle(0, 0.25, 1)", FORMULAS)
KINDS = re.sub("right = .*", "right = gaussian(0.7, 0.1)", KINDS).replace("param top = 0.25\n", "")
USUAL = {"defuzzifier": "centroid(resolution=200)", "implication": "min", "aggregation": "max"}


@pytest.mark.parametrize("backend", sizes.BACKENDS)
@pytest.mark.parametrize(
    "method",
    [
        {},
        {"implication": "product", "aggregation": "sum"},
        {"defuzzifier": "bisector(resolution=101)", "aggregation": "probabilistic_sum"},
        {"defuzzifier": "lom(resolution=57)"},
    ],
    ids=str,
)
def test_they_are_the_sets_that_they_say(backend, method):
    own, kinds = (compile(loads(t.format(**USUAL | method)), backend=backend) for t in (FORMULAS, KINDS))
    for e in (0.0, 0.1, 0.3, 0.5, 0.77, 1.0):
        assert own(e) == pytest.approx(kinds(e), abs=1e-12)


def test_degrees_are_held_and_0_where_they_have_no_value():
    text = FORMULAS.format(**USUAL).replace("lt(u, top)", "9 * lt(u, top)").replace("exp(", "-exp(")
    system = loads(text)
    y = degrees(system, system.outputs[0], system.outputs[0].terms[0], np.array([0.0, 0.125, 0.25, 1.0]))
    assert y.tolist() == [0.0, 1.0, 1.0, 0.0]
    assert set(degrees(system, system.outputs[0], system.outputs[0].terms[1], np.linspace(0, 1, 9))) == {0.0}


@pytest.mark.parametrize(
    ("defuzzifier", "message"),
    [
        ("centroid", "has no closed form"),
        ("mom", "has no closed form"),
        ("weighted_average", "without a peak"),
        ("tsukamoto", "inverse .tsukamoto. does not know"),
        ("inverse_tsukamoto", "is a formula"),
    ],
)
def test_what_does_not_sample_refuses_them(defuzzifier, message):
    with pytest.raises(DiagnosticError, match=f"FZ214.*{message}"):
        loads(FORMULAS.format(**USUAL | {"defuzzifier": defuzzifier}))


@pytest.mark.parametrize(("kind", "lacks"), [("centroid", "closed form"), ("weighted_average", "known peak")])
def test_kernels_refuse_what_no_check_has_seen(kind, lacks):
    system = loads(FORMULAS.format(**USUAL))
    method = system.method.model_copy(update={"defuzzifier": Defuzzifier(kind=kind)})
    with pytest.raises(DiagnosticError, match=f"FZ214.*has no {lacks}"):
        compile(system.model_copy(update={"method": method}), backend="python")


def test_they_name_nothing_but_the_output_and_params():
    with pytest.raises(DiagnosticError, match="'e' is neither a param nor 'u' itself"):
        loads(FORMULAS.format(**USUAL).replace("9 * lt", "lt").replace("lt(u, top)", "lt(u, e)"))


def test_outputs_in_antecedents_have_their_degrees():
    text = FORMULAS.format(**USUAL).replace("if e is somewhat H then u is left weight 0.25", "")
    text += "output w in [0, 1]\n  a = constant(0)\n  b = constant(1)\n"
    text = text.replace("defuzzifier centroid(resolution=200)\n", "defuzzifier weighted_average\n")
    text = text.replace("else 0.5", "else 0.5 defuzzifier centroid(resolution=200)")
    system = loads(f"{text}if u is left then w is a\nif u is not left then w is b\n")
    u, w = system(e=0.3).values()
    assert w == pytest.approx(1.0 - (1.0 - u) / 0.75, abs=1e-12)


def test_they_are_printed_generated_and_refused_by_formats_without_them(tmp_path):
    system, path = loads(FORMULAS.format(**USUAL)), tmp_path / "own.fz"
    dump(system, path)
    assert load(path) == system
    assert run_command("codegen", path, "--target", "python", "-o", tmp_path).exit_code == 0
    found = runpy.run_path(str(tmp_path / "own.py"))["own"](0.3)
    assert found == pytest.approx(compile(system, backend="python")(0.3), abs=1e-15)
    assert as_profile(system, "pyfuzzylite")(e=0.3) == pytest.approx(system(e=0.3), abs=0.05)
    for name in ("fcl", "fis", "fml"):
        refused = run_command("convert", path, "-", "--to", name)
        assert "FZ608" in refused.errors
        assert "term 'left' of 'u' is a set that is a formula" in refused.errors
