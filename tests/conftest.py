"""What holds in all tests: draws of Hypothesis, the time of proofs, workers of sweeps, garbage, Ctrl-C, bytecode."""

import gc
import multiprocessing
import os
import signal
import sys
import time

import pytest
from hypothesis import HealthCheck, core, settings

from fuzzyctl.analysis.work import clock
from fuzzyctl.experiments import sweep_workers
from tests import sizes


@pytest.hookimpl(trylast=True)  # once Hypothesis knows the seed
def pytest_configure(config):
    """Have tests without a seed draw the same, and print what reproduces a failure.

    What is drawn also hangs on the modules of the project that are loaded, since Hypothesis tries the constants that it
    finds there.
    """
    sizes.LONG = config.option.markexpr != "not long"
    # Hundreds of processes import the project: each would compile all of it where bytecode is not kept.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False
    # Shells start background jobs with SIGINT ignored, and so would all that the tests start.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    settings.register_profile(
        "same",
        max_examples=sizes.examples(100, 30),
        # Where all is drawn the same, a seed that is given would be unheeded.
        derandomize=core.global_force_seed is None,
        print_blob=True,
        # Other processes may slow a test down at any time.
        deadline=None,
        suppress_health_check=[HealthCheck.too_slow],
    )
    settings.load_profile("same")


def pytest_collection_finish():
    """Keep the thousands of tests out of every collection of garbage, which looked at all of them each time."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True, scope="session")
def processor_time_of_proofs():
    """Have proofs in this process count what they compute, so that no verdict depends on what else the machine does."""
    clock.now = time.thread_time


@pytest.fixture(autouse=True, scope="session")
def workers_that_are_copies_of_this_process():
    """Have sweeps in this process fork their workers in the test line: a new interpreter spends 2 s on imports.

    Before a release they are started as users have them.
    """
    if not sizes.LONG and sys.platform == "linux":
        sweep_workers.get_context = lambda _: multiprocessing.get_context("fork")
