from fractions import Fraction

import numpy as np
import pytest

from fuzzyctl.errors import ArgumentError, ValueOutOfBoundsError
from fuzzyctl.kernels.compile import compile as compile_system


class TestArguments:
    @pytest.mark.parametrize("service", [None, "7", 1j, np.array([1 + 1j]), np.ma.masked_array([1.0], [True])])
    def test_what_is_no_real_number_is_refused_by_name(self, tipper, service):
        with pytest.raises(ArgumentError, match="service"):
            tipper(service=service, food=8)

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


class TestBlocks:
    @pytest.mark.parametrize("backend", ["numpy"])
    def test_states_of_later_blocks_are_their_own(self, adaptive, backend):
        points = np.linspace(-0.4, 0.4, 20_001)[:, None]
        state = np.random.default_rng(3).uniform(-2, 2, (20_001, 7))
        found = compile_system(adaptive, backend).batch(points, state)
        python = compile_system(adaptive, "python")
        for i in (0, 8191, 8192, 16384, 20_000):
            assert found[i] == pytest.approx(python(points[i, 0], state[i]), rel=1e-14, abs=1e-15)
