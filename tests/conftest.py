"""How Hypothesis draws in all tests: the same in every run, and others where a seed is given."""

import pytest
from hypothesis import core, settings


@pytest.hookimpl(trylast=True)  # once Hypothesis knows the seed
def pytest_configure():
    """Have tests without a seed draw the same, and print what reproduces a failure.

    What is drawn also hangs on the modules of the project that are loaded, since Hypothesis tries the constants that it
    finds there.
    """
    # Where all is drawn the same, a seed that is given would be unheeded.
    settings.register_profile("same", derandomize=core.global_force_seed is None, print_blob=True)
    settings.load_profile("same")
