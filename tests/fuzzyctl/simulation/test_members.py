"""Members of the family of a loop, and the claims that their runs break."""

import numpy as np
import pytest

from fuzzyctl import simulate
from fuzzyctl.simulation import members
from tests.fuzzyctl.simulation.test_families import TEXT


@pytest.fixture
def family(loop):
    return lambda lines="": loop(TEXT.format(lines=lines))


def test_corners_come_before_a_latin_hypercube(family):
    one = family()
    chosen = members.members(one, 40, seed=3)
    assert chosen[:32] == members.corners(one)
    assert chosen[0] == {"tank.h": 0.5, "tank.A": 2.0, "law.s": 0.0, "goal": 0.25, "leak": 0.0}
    assert chosen[31] == {"tank.h": 2.0, "tank.A": 8.0, "law.s": 5.0, "goal": 1.0, "leak": 1.0}
    starts = np.array([m["tank.h"] for m in chosen[32:]])
    assert sorted(np.floor((starts - 0.5) / 1.5 * 8)) == list(range(8))
    assert all(0.0 <= m["leak"] <= m["goal"] for m in chosen)  # the range of the leak ends at the goal
    assert chosen == members.members(one, 40, seed=3)
    assert chosen[32:] != members.members(one, 40, seed=4)[32:]


def test_fewer_members_than_corners_are_a_latin_hypercube(family):
    assert not {m["tank.h"] for m in members.members(family(), 10)} & {0.5, 2.0}


def test_ends_outside_of_a_range_are_missed_by_a_hair(loop):
    text = TEXT.format(lines="").replace("tank.A in [2, 8]", "tank.A in (2, 8)")
    values = {m["tank.A"] for m in members.corners(loop(text))}
    assert values == {np.nextafter(2.0, 3.0), np.nextafter(8.0, 7.0)}


def test_too_many_corners_are_drawn(loop):
    lines = "\n".join(f"disturbance d{k} in [0, 1] = 0" for k in range(4))
    chosen = members.corners(loop(TEXT.format(lines=lines)))
    assert len(chosen) == 256
    assert len({m["d0"] for m in chosen}) == 256


def test_the_run_of_a_member_is_that_of_its_numbers(family):
    one = family()
    chosen = members.corners(one)[::7]
    for member, run in zip(chosen, members.runs(one, chosen), strict=True):
        same = simulate(one, backend="python", **member)
        np.testing.assert_allclose(run["tank.h"], same["tank.h"], rtol=1e-10)


def test_broken_claims_name_the_first_member(family):
    one = family("require always tank.h <= 1\nrequire always tank.h <= 5\nmeasure m = final(tank.y)\nrequire m <= 9")
    chosen = members.corners(one)
    (broken,) = members.broken(chosen, members.runs(one, chosen))
    assert (broken.claim, broken.count, broken.member) == ("require always tank.h <= 1", 16, chosen[16])
    assert broken.facts == ("at t = 0 s", "tank.h = 2")
    assert members.replayed(broken.member).startswith("--set tank.h=2.0 --set tank.A=2.0 ")


def test_stopped_members_are_named(loop):
    one = loop(TEXT.format(lines="").replace("-k * y", "100 * y"))
    chosen = members.corners(one)
    broken = members.broken(chosen, members.runs(one, chosen))
    assert [b.claim for b in broken] == ["stopped"]
    assert "left its range" in broken[0].facts[0]
