"""The tipper of MATLAB's manual, under the profiles of the tools that have it."""

from __future__ import annotations

from pathlib import Path

import pytest

import fuzzyctl
from tests.tipper import POINTS, TIPS

SAMPLES = Path(__file__).parent.parent / "fuzzyctl" / "formats" / "samples"
TIPPER = (SAMPLES / "tipper.fis").read_text(encoding="utf-8")


def tips(profile: str) -> list[float]:
    system = fuzzyctl.loads(TIPPER, "tipper.fis")
    return fuzzyctl.compile(fuzzyctl.as_profile(system, profile), backend="python").batch(POINTS).tolist()


def test_matlabs_manual_prints_these():
    printed = [f"{tip:.4f}" for tip in tips("matlab")]
    assert printed[:3] == ["7.0169", "14.4585", "20.3414"]


@pytest.mark.parametrize("profile", TIPS)
def test_each_tool_gives_its_own_tips(profile):
    assert [f"{tip:.10f}" for tip in tips(profile)] == [f"{tip:.10f}" for tip in TIPS[profile]]
