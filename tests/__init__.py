"""Tests: as in commands, one thread of BLAS, which is told before numpy is imported."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
