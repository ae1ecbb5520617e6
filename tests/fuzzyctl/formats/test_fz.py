"""Texts of systems: read back equal, laid out, or refused."""

from dataclasses import replace

import pytest

from fuzzyctl import ValueOutOfBoundsError, build, dump, dumps, load, loads
from fuzzyctl.testing import run_command
from tests.shipped import SYSTEMS


class TestDumps:
    @pytest.mark.parametrize("path", SYSTEMS, ids=lambda p: p.name)
    def test_shipped_files_come_back_as_they_were(self, path):
        system = load(path)
        assert loads(dumps(system)) == system

    @pytest.mark.parametrize(
        "after",
        [
            "if not (x is N or x is P) and (y is N and x is Z) then u is Z weight (1 / 3)\n",
            "if x is N then u is P weight 0.1\nrequire (u > 0 or u < 1) and not u == 2 when abs(x) >= 0.1\n",
            "require u(-x, 10 - y) == -u within 1e-12\nrequire lipschitz(u, x) <= 3\n",
        ],
    )
    def test_rules_and_guarantees_come_back(self, changed, after):
        system = loads(changed(after=after))
        assert loads(dumps(system)) == system

    def test_settings_params_and_clauses_come_back(self, changed):
        text = changed(
            (
                "\ninput x",
                '\nsource "s"\nand product\ndefuzzifier centroid(resolution=7, grid=endpoints)\n'
                'param a = -(1 - 2)^-2 / 3 unit "m"\nparam b = a - (1 - a)\ninput x "X"',
            ),
            ("[0, 10]", "[0 * a, 10]"),
            ('unit "m"\n  terms', 'unit "m" extrapolate\n  terms'),
            ("[-2, 2]", "[-2, 2] else (b)"),
            ("N |  N  Z", "N |  .  Z*0.1"),
        )
        system = loads(text)
        assert loads(dumps(system)) == system
        assert loads(dumps(loads(dumps(system)))) == system

    def test_every_digit_is_kept(self, changed):
        system = loads(changed(("triangle(-1, 0, 1)", "triangle(-1, 0.1, 1)"))).with_params()
        moved = loads(changed(("triangle(-1, 0, 1)", "triangle(-1, 0.10000000000000002, 1)")))
        assert loads(dumps(moved)) == moved != system

    def test_a_file_is_written_whole(self, tmp_path, base):
        dump(loads(base), tmp_path / "a.fz")
        assert load(tmp_path / "a.fz") == loads(base)

    def test_it_is_laid_out(self, base):
        text = dumps(loads(base))
        assert run_command("fmt", "-", stdin=text).output == text

    def test_a_title_that_no_string_can_hold_is_refused(self, base):
        system = loads(base)
        for title in ('a "quoted" title', "two\nlines", "e\u0301"):
            with pytest.raises(ValueOutOfBoundsError, match="title"):
                dumps(system.model_copy(update={"title": title}))

    def test_a_formula_of_less_than_full_height_has_it_in_its_text(self, changed):
        system = loads(changed(("triangle(-1, 0, 1)", "function(1 - abs(x))")))
        (term,) = [t for t in system.inputs[0].terms if t.membership.kind == "function"]
        lower = replace(term, membership=replace(term.membership, height=build.expression(0.5)))
        x = replace(system.inputs[0], terms=tuple(lower if t is term else t for t in system.inputs[0].terms))
        built = replace(system, inputs=(x, *system.inputs[1:]))
        assert "function(0.5 * (1 - abs(x)))" in dumps(built)
        assert loads(dumps(built))(x=0.3, y=2) == built(x=0.3, y=2)
