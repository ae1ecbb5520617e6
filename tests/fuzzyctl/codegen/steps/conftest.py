"""Steps of all kinds."""

from tests.fuzzyctl.codegen.steps.texts import TEXTS


def pytest_generate_tests(metafunc):
    """Run a test that takes a `text` for controllers of all kinds."""
    if "text" in metafunc.fixturenames:
        metafunc.parametrize("text", TEXTS.values(), ids=TEXTS)
