"""What peers do otherwise and profiles do not imitate: what it is here, and that the profile says so."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))

from fuzzyctl.model.profiles import PROFILES
from tests.peers.catalogue import PEERS
from tests.peers.known_bugs import BUGS


@pytest.mark.parametrize("bug", BUGS, ids=lambda b: f"{b.peer}: {b.says}")
class TestKnownBugs:
    def test_the_number_is_not_the_peers(self, bug):
        names = [i.name for i in bug.system.inputs]
        ours = bug.system(**dict(zip(names, bug.point, strict=True)))
        assert ours == pytest.approx(bug.ours, rel=1e-12, nan_ok=True)
        assert ours != pytest.approx(bug.theirs, rel=1e-3)

    def test_the_profile_says_so(self, bug):
        listed = PROFILES[PEERS[bug.peer].profile].not_imitated
        assert [t for t in listed if t.startswith(bug.says)]

    def test_the_peer_can_be_asked_again(self, bug):
        assert PEERS[bug.peer].text(bug.system).strip()
