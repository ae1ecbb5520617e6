"""The peers: what each can evaluate, in which form it takes systems, and how it is run."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from peers import fll
from peers.drawing import CURVED, DISJUNCTIONS, MONOTONE, STRAIGHT, Abilities

from fuzzyctl.model.system import FuzzySystem

DRIVERS = Path(__file__).parent / "drivers"
INF = float("inf")


def folder() -> Path:
    """Return where the peers are installed: `FUZZYCTL_PEERS`, or a folder among the temporary ones."""
    return Path(os.environ.get("FUZZYCTL_PEERS") or Path(tempfile.gettempdir()) / "fuzzyctl-peers")


@dataclass(frozen=True)
class Peer:
    """A tool whose numbers are compared with those of the profile that imitates it.

    Args:
        name: As `--peer` takes it.
        profile: The profile.
        version: What is installed.
        packages: What pip installs for it, with versions; empty for what is no Python package.
        suffix: Of the files that it takes.
        text: A system in its form.
        abilities: What it can evaluate.
        driver: The file that runs it.
    """

    name: str
    profile: str
    version: str
    packages: tuple[str, ...]
    suffix: str
    text: Callable[[FuzzySystem], str]
    abilities: Abilities
    driver: str

    def command(self) -> list[str] | None:
        """Return what runs its driver, without the folder of systems; None where it is not installed."""
        if self.packages:
            python = folder() / self.name / "bin" / "python"
            return [str(python), str(DRIVERS / self.driver)] if python.exists() else None
        program = folder() / self.name / "driver"
        return [str(program)] if program.exists() else None


_FUZZYLITE = Abilities(
    monotone=MONOTONE,
    kinds=(*STRAIGHT, *CURVED),
    aggregations=(*DISJUNCTIONS, "sum"),
    consequent_hedges=("very", "somewhat", "extremely", "seldom", "not", "any"),
    activations=("first", "last", "highest", "lowest", "proportional", "threshold"),
    infinite=True,
    heights=True,
    holds=True,
    chains=True,
    own_methods=True,
    resolutions=(1, 2, 10, 25, 100, 101, 200, None),
    specials=(INF, -INF),
)

PEERS = {
    p.name: p
    for p in (
        Peer(
            "pyfuzzylite", "pyfuzzylite", "8.0.6", ("pyfuzzylite==8.0.6",), ".fll", fll.text, _FUZZYLITE,
            "pyfuzzylite_driver.py",
        ),
        Peer("fuzzylite", "fuzzylite_6", "6.0", (), ".fll", fll.text, _FUZZYLITE, "fuzzylite.cpp"),
    )
}  # fmt: skip

if __name__ == "__main__":
    sys.stdout.write("".join(f"{p.name} {p.version}\n" for p in PEERS.values()))
