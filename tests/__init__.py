"""The tests; they use one thread of BLAS, as commands do, which numpy reads when it is imported."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
