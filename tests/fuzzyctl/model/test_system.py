import math
from fractions import Fraction

import numpy as np
import pytest

from fuzzyctl import (
    ArgumentError,
    DiagnosticError,
    NoRuleFiresError,
    UnknownNameError,
    ValueOutOfBoundsError,
    load,
    loads,
)


@pytest.fixture(scope="module")
def ais():
    return load("ais_reaction")


class TestEquality:
    def test_places_take_no_part(self, base):
        assert loads(base) == loads("\n\n# comment\n" + base.replace("  N |", "N|"))
        assert hash(loads(base)) == hash(loads("\n" + base))

    def test_meaning_does(self, base, changed):
        assert loads(base) != loads(changed(("triangle(-1, 0, 1)", "triangle(-1, 0.1, 1)")))
        assert loads(base) != loads(changed(("Z |  N  P", "Z |  N  Z")))


class TestParams:
    def test_values_follow_their_expressions(self, ais):
        assert ais.values["f_max"] == (0.1 - 0.001) / 0.55

    def test_setting_one_moves_what_is_computed_from_it(self, ais):
        changed = ais.with_params(k_s=0.6)
        assert changed.values["f_max"] == (0.1 - 0.001) / 0.6
        assert changed.number(changed.output("f").upper) == changed.values["f_max"]
        assert ais.values["k_s"] == 0.55

    def test_unknown_names_and_values_are_refused(self, ais):
        with pytest.raises(UnknownNameError, match="did you mean 'k_s'"):
            ais.with_params(ks=1)
        with pytest.raises(ValueOutOfBoundsError, match="finite"):
            ais.with_params(k_s=math.nan)

    @pytest.mark.parametrize("number", [np.float32(0.5), np.float16(0.5), np.longdouble(0.5), Fraction(1, 2)])
    def test_numbers_of_every_type_are_taken_without_a_warning(self, ais, number):
        assert ais.with_params(k_s=number).values["k_s"] == 0.5

    @pytest.mark.parametrize("number", [np.float32("inf"), np.float16("nan"), 10**400, -Fraction(10**400)])
    def test_numbers_that_no_float_can_be_are_refused(self, ais, number):
        with pytest.raises(ValueOutOfBoundsError, match="finite"):
            ais.with_params(k_s=number)

    def test_a_system_that_is_not_well_formed_with_them_is_refused(self, ais):
        with pytest.raises(DiagnosticError, match="FZ307"):
            ais.with_params(k_s=0.0)


class TestCall:
    def test_numbers_give_a_number(self, ais):
        assert ais(sigma=0.0, dsigma=0.0) == 0.18

    def test_arrays_broadcast(self, ais):
        sigma, dsigma = np.linspace(-0.05, 0.05, 5)[:, None], np.linspace(-1, 1, 3)
        values = ais(sigma=sigma, dsigma=dsigma)
        assert values.shape == (5, 3)
        assert values[3, 1] == pytest.approx(ais(sigma=sigma[3, 0], dsigma=dsigma[1]), rel=1e-12)

    def test_names_that_python_spells_in_another_form_are_found(self, changed):
        system = loads(changed(("input x", "input \u00b5"), ("table u = x x y", "table u = \u00b5 x y")))
        spelt, written = ({name: 1.0, "y": 10.0} for name in ("\u03bc", "\u00b5"))
        assert system(**spelt) == system(**written)

    def test_names_are_checked(self, ais):
        with pytest.raises(UnknownNameError, match="sigma"):
            ais(sgma=0.0, dsigma=0.0)
        with pytest.raises(ArgumentError, match="dsigma"):
            ais(sigma=0.0)

    def test_a_broken_promise_is_an_error_not_a_nan(self, changed):
        system = loads(changed(("N |  N  Z", "N |  .  Z")))
        with pytest.raises(NoRuleFiresError, match="output 'u' at x = -1, y = 0"):
            system(x=-1.0, y=0.0)
        with pytest.raises(NoRuleFiresError, match="output 'u' at x = -1, y = 0"):
            system(x=[math.nan, 1.0, -1.0], y=0.0)
        values = system(x=[math.nan, 1.0], y=0.0)
        assert math.isnan(values[0])
        assert math.isnan(system(x=math.nan, y=0.0))
        assert values[1] == system(x=1.0, y=0.0)

    def test_several_outputs_come_by_name(self, changed):
        system = loads(
            changed(
                ("table u", "output v in [0, 1]\n  A = triangle(0, 0.5, 1)\n\ntable u"),
                after="if x is N or x is Z then v is A\n",
            ).replace("output v in [0, 1]", "output v in [0, 1] else 0.25")
        )
        result = system(x=1.0, y=10.0)
        assert set(result) == {"u", "v"}
        assert result["v"] == 0.25
        assert system(x=-1.0, y=0.0)["v"] == 0.5
