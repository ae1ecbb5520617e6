"""Type of the arrays of numbers in signatures."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
