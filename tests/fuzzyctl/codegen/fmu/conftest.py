"""FMUs on disk, each made once; their instances are freed at the end of a test."""

import pytest

from tests.fuzzyctl.codegen.fmu.fmus import Built


@pytest.fixture(scope="session")
def fmus(tmp_path_factory):
    made = {}
    yield made, tmp_path_factory.mktemp("fmus")
    for own in made.values():
        own.remove()


@pytest.fixture
def built(fmus):
    made, folder = fmus
    used = []

    def build(text, version=3, *options):
        key = (text, version, *options)
        if key not in made:
            made[key] = Built(text, version, folder / str(len(made)), *options)
        used.append(made[key])
        return made[key]

    yield build
    for own in used:
        own.free()
