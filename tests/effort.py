"""Limits on the work of a test, which do not depend on other processes of the machine."""

import cProfile
import pstats
import time
from contextlib import contextmanager


@contextmanager
def at_most(seconds):
    """Fail where the block takes this thread more seconds of a processor."""
    began = time.thread_time()
    yield
    took = time.thread_time() - began
    assert took < seconds, f"took {took:.2f} s of a processor, may take {seconds:g} s"


@contextmanager
def at_most_calls(count):
    """Fail if the block makes more calls of functions, however fast the machine is."""
    with cProfile.Profile() as profile:
        yield
    calls = pstats.Stats(profile).total_calls
    assert calls <= count, f"{calls:,} calls, at most {count:,} are allowed"
