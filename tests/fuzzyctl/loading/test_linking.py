"""Guarantees that name outputs of other systems."""

import pytest

from fuzzyctl import Proved, Refuted, dumps, load, loads, prove

ONE = """system coarse
and product
defuzzifier weighted_average
input e in [0, 4] unit "m"
  terms N P
output u in [0, 8] unit "N"
  terms small=0 large=8
table u = e
     N      P
  |  small  large
"""
OTHER = """
system fine
defuzzifier weighted_average
input e in [0, 4] unit "m"
  terms N Z P
output w in [0, 8] unit "N"
  terms small=0 half=4 large=8
table w = e
     N      Z     P
  |  small  half  large
"""
WIDE = """
system wide
and product
defuzzifier weighted_average
input d in [-1, 1] unit "m/s"
  terms N P
input e in [0, 4] unit "m"
  terms N P
output u in [0, 8] unit "N"
  terms small=0 large=8
table u = d x e
       N      P
  N |  small  large
  P |  small  large
"""


def verdicts(*claims, rest=OTHER + WIDE):
    text = ONE + "".join(f"require {c}\n" for c in claims) + rest
    return prove(loads(text, block="coarse"))


class TestComparedSystems:
    def test_two_that_are_the_same_function_are_proved_to_be(self):
        exact, close = verdicts("u == fine.w", "u == fine.w within 1e-9")
        assert isinstance(exact, Proved)
        assert "exact arithmetic" in exact.note
        assert close == Proved("u == fine.w within 1e-9")

    def test_a_corner_of_the_other_one_is_seen(self):
        bent = OTHER.replace("half=4", "half=4.5")
        (verdict,) = verdicts("u == fine.w within 0.4", rest=bent)
        assert isinstance(verdict, Refuted)
        assert verdict.witness.point["e"] == pytest.approx(2.0, abs=0.4)
        assert dict(verdict.witness.sides)["fine.w"] - dict(verdict.witness.sides)["u"] > 0.4
        assert isinstance(verdicts("u == fine.w within 0.5000001", rest=bent)[0], Proved)

    def test_inputs_go_by_name_and_arguments_by_place(self):
        assert isinstance(verdicts("u == wide.u(0.3, e) within 1e-9")[0], Proved)
        assert isinstance(verdicts("u(4 - e) == 8 - wide.u(-1, e) within 1e-9")[0], Proved)
        text = WIDE + "require u == fine.w within 1e-9\n" + OTHER
        assert [type(v) for v in prove(loads(text, block="wide"))] == [Proved]

    def test_curved_ones_are_compared_by_subdivision(self):
        curved = OTHER.replace("terms N Z P", "N = gaussian(0, 1)\n  Z = gaussian(2, 1)\n  P = gaussian(4, 1)")
        near, far = verdicts("u == fine.w within 0.5", "u == fine.w within 0.05", rest=curved)
        assert isinstance(near, Proved)
        assert isinstance(far, Refuted)

    def test_a_range_of_the_other_one_that_ends_earlier_counts(self):
        short = OTHER.replace("in [0, 4]", "in [0, 2]").replace("large=8", "large=4").replace("half=4", "half=2")
        (verdict,) = verdicts("u == fine.w within 1e-9", rest=short)
        assert isinstance(verdict, Refuted)
        assert verdict.witness.point["e"] > 2
        assert isinstance(verdicts("u == fine.w within 1e-9 when e <= 2", rest=short)[0], Proved)

    def test_a_used_file_lends_its_systems_for_comparing(self, tmp_path):
        (tmp_path / "old.fz").write_text(OTHER.lstrip())
        path = tmp_path / "new.fz"
        path.write_text(ONE.replace("\n", '\nuse "old.fz"\n', 1) + "require u == fine.w within 1e-9\n")
        assert [type(v) for v in prove(path)] == [Proved]
        assert [v.name for v in load(path).inputs] == ["e"]

    def test_a_shared_param_is_set_in_both(self):
        text = "param top = 8\n" + ONE.replace("=8", "=(top)") + "require u == fine.w within 1e-9\n"
        system = loads(
            text + OTHER.replace("large=8", "large=(top)").replace("half=4", "half=(top / 2)"), block="coarse"
        )
        assert isinstance(prove(system.with_params(top=7.0))[0], Proved)
        own = loads(
            text + "".join(OTHER.partition("fine")[:2]) + "\nparam mine = 8" + OTHER.partition("fine")[2],
            block="coarse",
        )
        assert isinstance(prove(own.with_params(top=7.0))[0], Refuted)

    def test_it_is_written_with_the_systems_it_names(self):
        system = loads(ONE + "require u == fine.w\n" + OTHER, block="coarse")
        assert loads(dumps(system), block="coarse") == system
        assert [s.name for s in system.compared] == ["fine"]
        assert not system.compared[0].guarantees

    def test_each_may_name_the_other(self):
        text = ONE + "require u == fine.w within 1\n" + OTHER + "require w <= coarse.u + 1\n"
        for name in ("coarse", "fine"):
            assert [type(v) for v in prove(loads(text, block=name))] == [Proved]
