"""How much a test may compute, which no other process of the machine makes more."""

import time
from contextlib import contextmanager


@contextmanager
def at_most(seconds):
    """Fail where the block takes this thread more seconds of a processor."""
    began = time.thread_time()
    yield
    took = time.thread_time() - began
    assert took < seconds, f"took {took:.2f} s of a processor, may take {seconds:g} s"
