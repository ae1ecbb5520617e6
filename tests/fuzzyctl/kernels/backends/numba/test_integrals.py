"""Text of adaptive integrals: a system that is called again has no second copy."""

import pytest

import fuzzyctl
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.kernels.backends.numba import source
from fuzzyctl.kernels.plan.expansion import equations_of
from fuzzyctl.kernels.step_form import step_program
from fuzzyctl.loading.load import look_through

CURVED = """system {name}
defuzzifier centroid
input e in [-1, 1]
  N = triangle(-inf, -1, 1)
  P = triangle(-1, 1, inf)
output u in [-1, 1]
  N = gaussian(-1, {width})
  P = gaussian(1, 0.4)
if e is N then u is N
if e is P then u is P
"""


def text_of(outputs):
    own = "".join(CURVED.format(name=name, width=width) for name, width in (("g", 0.4), ("h", 0.5)))
    text = own + f"controller c\ninput x\n{outputs}\nevery 1 s\n"
    controller = look_through(SourceText("c.fz", text)).controllers[-1]
    return controller, source.storing_source(step_program(equations_of(controller)))


def test_a_set_that_is_called_again_is_compiled_once():
    _, text = text_of("output u = g(x) + g(0.5 * x)")
    assert text.count("def stretch_") == 1
    assert text.count("\nmoments_") == 1


def test_sets_that_differ_by_a_number_are_two():
    _, text = text_of("output u = g(x) + h(x)")
    assert text.count("def stretch_") == 2


@pytest.mark.long
def test_each_call_has_its_own_value():
    controller, _ = text_of("output u = g(x)\noutput v = g(0.5 * x)\noutput w = g(-x)")
    compiled, plain = (fuzzyctl.compile(controller, backend) for backend in ("numba", "python"))
    for x in (0.7, -0.2):
        assert compiled(x, [])[0] == plain(x, [])[0]
