"""Checksum of the sources that the runs of a sweep depend on."""

from __future__ import annotations

from pathlib import Path

from fuzzyctl.experiments.result_files import versions
from fuzzyctl.experiments.sweep_journal import sources

#: Packages that no result depends on.
OUTSIDE = ("cli/", "figures/", "page/", "output/data/")


def software() -> dict[str, str | None]:
    """Return the versions of what computes a run, and a checksum of its sources."""
    return {**versions(), "sources": sources(Path(__file__).parents[1], OUTSIDE)}
