"""Compilation of the loop's functions."""

import numpy as np
import pytest

from dwmr.core import jit


@pytest.mark.skipif(not jit.COMPILED, reason="needs numba: plain Python allocates as it likes")
def test_functions_of_the_loop_allocate_nothing():
    @jit.compiled
    def summed(values):
        return values.copy().sum()

    # Numba says the first if this process has compiled no allocation before, else the second.
    with pytest.raises(Exception, match=r"_ol_array_allocate|NRT required but not enabled"):
        summed(np.ones(3))
