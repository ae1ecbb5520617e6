from fractions import Fraction

import numpy as np
import pytest

from fuzzyctl import loads
from fuzzyctl.diagnostics.diagnostic import ArgumentError, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.forms import SystemForm
from fuzzyctl.kernels.kernel import Kernel
from fuzzyctl.kernels.plan.build import plan


class TestArguments:
    @pytest.mark.parametrize("service", [None, "7", 1j, np.array([1 + 1j]), np.ma.masked_array([1.0], [True])])
    def test_what_is_no_real_number_is_refused_by_name(self, tipper, service):
        with pytest.raises(ArgumentError, match="service"):
            tipper(service=service, food=8)

    def test_a_system_takes_names_and_says_so(self, tipper):
        with pytest.raises(ArgumentError, match=r"by name: system\(service=\.\.\., food=\.\.\.\)"):
            tipper(7, food=8)

    @pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
    def test_texts_are_not_read_as_numbers(self, tipper, backend):
        with pytest.raises(ArgumentError, match="points"):
            compile_system(tipper, backend).batch([["0.01", "0"]])

    @pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
    def test_numbers_beyond_floats_are_refused_by_name(self, tipper, backend):
        kernel = compile_system(tipper, backend)
        with pytest.raises(ValueOutOfBoundsError, match="service"):
            kernel(10**400, 0)
        with pytest.raises(ValueOutOfBoundsError, match="points"):
            kernel.batch([[10**400, 0]])

    def test_fractions_are_numbers_in_arrays_too(self, tipper):
        kernel = compile_system(tipper, "python")
        assert kernel.batch([[Fraction(7, 2), 8]])[0] == kernel(Fraction(7, 2), 8)

    @pytest.mark.parametrize("arguments", [(None,), ("tipper",)])
    def test_compile_takes_a_system(self, arguments):
        with pytest.raises(ArgumentError, match="FuzzySystem"):
            compile_system(*arguments)

    def test_compile_takes_the_name_of_a_backend(self, tipper):
        with pytest.raises(ArgumentError, match="backend"):
            compile_system(tipper, None)


def of_class(kind, tmp_path):
    """Return the same points as an array of a class that derives from numpy's, or at an odd address."""
    points = np.array([[3.0, 8.0], [9.5, 1.0]])
    if kind == "matrix":
        return points.view(np.matrix)
    if kind == "memmap":
        found = np.memmap(tmp_path / "points", dtype=float, mode="w+", shape=points.shape)
    else:
        found = np.zeros(points.nbytes + 1, np.uint8)[1:].view(float).reshape(points.shape)
        assert not found.flags.aligned
    found[...] = points
    return found


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
class TestArrays:
    @pytest.mark.parametrize("kind", ["matrix", "memmap", "odd address"])
    def test_of_other_classes_and_at_odd_addresses_are_points_like_others(self, tipper, backend, kind, tmp_path):
        kernel = compile_system(tipper, backend)
        found = kernel.batch(of_class(kind, tmp_path))
        assert found.tolist() == pytest.approx([kernel(3.0, 8.0), kernel(9.5, 1.0)], rel=1e-12)

    def test_on_disk_are_places_for_results(self, tipper, backend, tmp_path):
        out = np.memmap(tmp_path / "results", dtype=float, mode="w+", shape=(2,))
        kernel = compile_system(tipper, backend)
        assert kernel.batch([[3.0, 8.0], [9.5, 1.0]], out=out) is out
        assert out.tolist() == pytest.approx([kernel(3.0, 8.0), kernel(9.5, 1.0)], rel=1e-12)


REFUSING = """system s
defuzzifier weighted_average
input µ in [0, 10]
  low  = triangle(-inf, 1, 4)
input load in [0, 1]
  some = triangle(0, 0.5, inf)
output u in [-5, 20] else error
  a = constant(3)
if µ is low and load is some then u is a
"""
ADAPTING = """system s
and product
defuzzifier weighted_average
input x in [0, 10]
  low  = triangle(-inf, 1, 4)
  high = triangle(1, 4, inf)
output u in [-5, 20] adaptive rate x
  a = constant(3)
  b = constant(4)
if x is low then u is a
if x is high then u is b
"""


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
class TestNames:
    """Inputs by name, which Python binds for functions and not for kernels."""

    def test_stand_for_positions(self, tipper, backend):
        kernel = compile_system(tipper, backend)
        assert kernel(food=8.0, service=3.0) == kernel(3.0, food=8.0) == kernel(3.0, 8.0)

    def test_may_be_written_otherwise_by_python(self, backend):
        kernel = compile_system(loads(REFUSING), backend)
        assert kernel(**{"μ": 2.0}, load=0.5) == kernel(2.0, 0.5) == 3.0  # noqa: PIE804 - the other letter

    def test_go_with_a_state(self, backend):
        kernel = compile_system(loads(ADAPTING), backend)
        assert kernel(x=2.0, state=[1.0, 9.0]) == kernel(2.0, state=[1.0, 9.0]) == kernel(2.0, [1.0, 9.0])

    @pytest.mark.parametrize("text", [REFUSING, ADAPTING])
    def test_that_are_none_are_reported_with_the_nearest(self, backend, text):
        kernel = compile_system(loads(text), backend)
        with pytest.raises(UnknownNameError, match="no input 'loda'; there are: .*" + ("x, state|µ, load.*'load'")):
            kernel(loda=1.0)

    def test_must_be_all_and_once(self, tipper, backend):
        kernel = compile_system(tipper, backend)
        with pytest.raises(ArgumentError, match="missing for: service"):
            kernel(food=8.0)
        with pytest.raises(ArgumentError, match="'service' is given by position and by name"):
            kernel(3.0, service=3.0, food=2.0)
        with pytest.raises(ArgumentError, match="real number"):
            kernel(service="good", food=2.0)


def test_a_kernel_knows_its_backends_and_algorithms(tipper):
    with pytest.raises(UnknownNameError, match="no backend 'cuda'"):
        Kernel(SystemForm(plan(tipper)), "cuda")
    with pytest.raises(UnknownNameError, match=r"no algorithm 'rule'.*'rules'"):
        SystemForm(plan(tipper), "rule")


class TestBlocks:
    @pytest.mark.parametrize("backend", ["numpy"])
    def test_states_of_later_blocks_are_their_own(self, adaptive, backend):
        points = np.linspace(-0.4, 0.4, 20_001)[:, None]
        state = np.random.default_rng(3).uniform(-2, 2, (20_001, 7))
        found = compile_system(adaptive, backend).batch(points, state)
        python = compile_system(adaptive, "python")
        for i in (0, 8191, 8192, 16384, 20_000):
            assert found[i] == pytest.approx(python(points[i, 0], state[i]), rel=1e-14, abs=1e-15)
