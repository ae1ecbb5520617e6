"""The peers: what each can evaluate, in which form it takes systems, and how it is run."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from fuzzyctl import FuzzySystem
from tests.peers import fis, fll, plain
from tests.peers.drawing import CONJUNCTIONS, CURVED, DISJUNCTIONS, MONOTONE, STRAIGHT, Abilities

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
        if self.driver.endswith(".m"):
            octave = shutil.which("octave-cli")
            return [octave, "--quiet", "--no-init-file", str(DRIVERS / self.driver)] if octave else None
        program = folder() / self.name / "driver"
        return [str(program)] if program.exists() else None


_FUZZYLITE = Abilities(
    monotone=MONOTONE,
    kinds=(*STRAIGHT, *CURVED),
    aggregations=(*DISJUNCTIONS, "sum"),
    sums=("weighted_average", "weighted_sum", "inverse_tsukamoto", "inverse_tsukamoto_sum"),
    consequent_hedges=("very", "somewhat", "extremely", "seldom", "not", "any"),
    activations=("first", "last", "highest", "lowest", "proportional", "threshold"),
    infinite=True,
    heights=True,
    holds=True,
    chains=True,
    own_methods=True,
    blocks=True,
    resolutions=(1, 2, 10, 25, 100, 101, 200, None),
    specials=(INF, -INF),
)

#: Of the terms that release 6.0 inverts only ramps are inverted as they should be; corners at samples are not its own.
_FUZZYLITE_6 = replace(
    _FUZZYLITE,
    sets=tuple(k for k in (*STRAIGHT, *CURVED) if k != "rectangle"),
    monotone=("ramp",),
    tall=False,
    empties=False,
)
#: Its drastic norms are left out: they are no norms of a single degree, nor of three.
_OF_OCTAVE = tuple(
    tuple(n for n in norms if "drastic" not in n and "nilpotent" not in n) for norms in (CONJUNCTIONS, DISJUNCTIONS)
)
_OCTAVE = Abilities(
    kinds=tuple(
        "triangle trapezoid gaussian gaussian2 bell sigmoid sigmoid_difference sigmoid_product s_shape z_shape "
        "pi_shape".split()
    ),
    conjunctions=_OF_OCTAVE[0],
    disjunctions=_OF_OCTAVE[1],
    implications=_OF_OCTAVE[0],
    aggregations=(*_OF_OCTAVE[1], "sum"),
    defuzzifiers=("centroid", "som", "lom", "mom"),
    consequents=("constant", "linear"),
    hedges=("very", "somewhat", "extremely", "not"),
    consequent_hedges=("very", "somewhat", "extremely", "not"),
    jumps=False,
    nested=False,
    fewest_rules=2,
    inside=True,
    whole_slopes=True,
    extrapolates=True,
)
_SIMPFUL = Abilities(
    kinds=("triangle", "trapezoid", "piecewise", "gaussian", "gaussian2", "sigmoid"),
    conjunctions=("min", "product"),
    disjunctions=("max",),
    implications=("min",),
    aggregations=("max", "sum"),
    defuzzifiers=("centroid",),
    consequents=("constant", "linear"),
    sums=("weighted_average",),
    hedges=(),
    crosses=False,
    jumps=False,
    extrapolates=True,
    resolutions=(100, 101, None),
)
_SCIKIT_FUZZY = Abilities(
    kinds=("triangle", "trapezoid", "ramp", "piecewise"),
    conjunctions=("min", "product"),
    disjunctions=("max",),
    implications=("min",),
    aggregations=("max",),
    defuzzifiers=("centroid",),
    sums=(),
    hedges=(),
    negates=True,
    jumps=False,
    extrapolates=False,
    resolutions=(None, None, 11, 26, 101),
)

PEERS = {
    p.name: p
    for p in (
        Peer(
            "pyfuzzylite", "pyfuzzylite", "8.0.6", ("pyfuzzylite==8.0.6",), ".fll", fll.text, _FUZZYLITE,
            "pyfuzzylite_driver.py",
        ),
        Peer("fuzzylite", "fuzzylite_6", "6.0", (), ".fll", fll.text, _FUZZYLITE_6, "fuzzylite.cpp"),
        Peer("octave", "octave_0_4", "0.4.6", (), ".fis", fis.text, _OCTAVE, "octave_driver.m"),
        Peer("simpful", "simpful", "2.12.0", ("simpful==2.12.0",), ".json", plain.text, _SIMPFUL, "simpful_driver.py"),
        Peer(
            "scikit_fuzzy", "scikit_fuzzy", "0.5.0", ("scikit-fuzzy==0.5.0", "networkx", "scipy", "packaging"), ".json",
            plain.text, _SCIKIT_FUZZY, "scikit_fuzzy_driver.py",
        ),
    )
}  # fmt: skip

if __name__ == "__main__":
    sys.stdout.write("".join(f"{p.name} {p.version}\n" for p in PEERS.values()))
