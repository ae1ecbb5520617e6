"""Published systems, typed as printed or after what is known of them, beside numpy and beside printed numbers."""

from pathlib import Path

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl.testing import run_command
from tests.registry import by_hand

FILES = sorted((Path(__file__).parent / "published").glob("*.fz"))
CONTROLLERS = {"li_gatland_1996": 2, "mudi_pal_1999": 2, "procyk_mamdani_1979": 2, "wang_1993": 3}
SYSTEMS = [p for p in FILES if p.stem not in CONTROLLERS]
BACKENDS = ("numpy",)
#: Those that the test line compiles; before a release, all.
COMPILED = ("kong_kosko_1992", "takagi_sugeno_1985", "li_gatland_1996")


def on_backends(names):
    """Pairs of a name and a backend."""
    some = [(name, backend) for name in names for backend in BACKENDS]
    compiled = [pytest.param(n, "numba", marks=[] if n in COMPILED else pytest.mark.long) for n in names]
    return pytest.mark.parametrize(("name", "backend"), [*some, *compiled])


def named(files):
    return pytest.mark.parametrize("path", files, ids=[p.stem for p in files])


@named(FILES)
class TestEveryFile:
    def test_it_is_clean_and_laid_out(self, path):
        found = run_command("check", path)
        assert (found.exit_code, "warning" in found.output + found.errors) == (0, False)
        assert run_command("fmt", "--check", path).exit_code == 0

    def test_its_head_says_what_is_printed_and_what_was_chosen(self, path):
        head = path.read_text().split("system", 1)[0]
        assert "# Printed:" in head or ("# After:" in head and "# Chosen:" in head)
        assert ('source "after ' in path.read_text()) == ("# After:" in head)


@on_backends([p.stem for p in SYSTEMS])
def test_numbers_are_those_of_numpy(name, backend):
    system = fuzzyctl.load(Path(__file__).parent / "published" / f"{name}.fz")
    low, high = (np.array([system.number(getattr(v, end)) for v in system.inputs]) for end in ("lower", "upper"))
    points = np.random.default_rng(7).uniform(low, high, (300, len(low)))
    found = fuzzyctl.compile(system, backend).batch(points)
    expected = getattr(by_hand, name)(*points.T)
    expected = np.stack(expected, axis=-1) if isinstance(expected, tuple) else np.asarray(expected)
    expected = expected.T if expected.shape != found.shape else expected
    scale = max(1.0, np.nanmax(np.abs(expected)))
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-11 * scale)


@named(SYSTEMS)
class TestEverySystem:
    def test_its_text_is_read_back(self, path):
        system = fuzzyctl.load(path)
        assert fuzzyctl.loads(fuzzyctl.dumps(system)) == system

    def test_its_guarantees_are_proved(self, path):
        verdicts = fuzzyctl.prove(fuzzyctl.load(path))
        assert [type(v).__name__ for v in verdicts] == ["Proved"] * len(verdicts)


@on_backends(CONTROLLERS)
def test_controllers_give_the_numbers_of_plain_loops(name, backend):
    controller = fuzzyctl.load(Path(__file__).parent / "published" / f"{name}.fz", block=name)
    rows = np.random.default_rng(8).uniform(-1, 1, (200, CONTROLLERS[name]))
    found, _ = fuzzyctl.compile(controller, backend).run(rows)
    expected = getattr(by_hand, name)(*rows.T)
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-12)


class TestPrintedNumbers:
    def load(self, name):
        return fuzzyctl.load(Path(__file__).parent / "published" / f"{name}.fz")

    def test_takagi_and_sugeno(self):
        assert round(self.load("takagi_sugeno_1985")(x1=12, x2=5), 1) == 17.8

    def test_lee(self):
        found = self.load("lee_1990")(x=4, y=8)
        assert found == pytest.approx({"area": 4.7, "maxima": 4.0}, abs=1e-12)

    def test_passino_and_yurkovich(self):
        found = self.load("passino_yurkovich_1998")(e=0.0, de=np.pi / 8 - np.pi / 32)
        assert int(found["gravity"] * 100) / 100 == -6.81
        assert found["average"] == pytest.approx(-7.5, abs=1e-12)

    def test_wang_tanaka_and_griffin(self):
        system = self.load("wang_tanaka_griffin_1996")
        level = np.pi / 2
        assert round((system(x1=1e-9, x2=0) / 1e-9), 2) == 120.67
        assert round(system(x1=0, x2=1), 2) == 22.67
        assert round((system(x1=level, x2=0)) / level, 1) == 2551.6
        assert round(system(x1=level, x2=1) - system(x1=level, x2=0), 1) == 764.0
