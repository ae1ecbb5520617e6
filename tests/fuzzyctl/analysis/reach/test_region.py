"""The script that draws the region of attraction of a loop."""

from pathlib import Path

import numpy as np

import fuzzyctl
from tests.explanation import FOLDER, script

FILE = FOLDER / "proofs" / "weak_motor.fz"


def test_starts_near_upright_are_proved_and_runs_from_far_away_leave():
    region = script("proofs/region.py")
    loop = fuzzyctl.load(FILE, block=fuzzyctl.Loop)
    assert region.is_proved(loop, ((-0.1, 0.1), (-0.1, 0.1)), 20.0)
    lost = region.lost(loop, ("pendulum.theta", "pendulum.omega"), ((0.6, 1.2), (0.4, 1.2)))
    assert len(lost) > region.RUNS**2 / 2
    assert not region.is_proved(loop, ((1.1, 1.2), (1.1, 1.2)), 0.5)


def test_a_map_is_cut_where_it_is_not_proved(monkeypatch, tmp_path):
    region = script("proofs/region.py")
    monkeypatch.setattr(region, "is_proved", lambda loop, box, timeout: box[0][1] <= 0.0)
    found = region.region(Path(FILE), 1, 1.0)
    assert found.proved == [((-1.2, 0.0), (0.0, 1.2)), ((-1.2, 0.0), (-1.2, 0.0))]
    assert found.share == 0.5
    region.draw(found, tmp_path / "region.png")
    assert (tmp_path / "region.png").stat().st_size > 1000
    assert np.abs(found.lost).max() <= 1.2
