"""How drivers answer: for every file of a folder with points the outputs, or why there are none."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

Points = list[list[float]]


def answer(suffix: str, evaluate: Callable[[str, Points], list[list[float]]]) -> None:
    """Evaluate the folder that the first argument names.

    Args:
        suffix: Of the files that hold a system; NAME.points has its points, one a line.
        evaluate: Returns the outputs at each point, for the text of a file and its points. They go to NAME.out, and
            what it raises to NAME.err.
    """
    for path in sorted(Path(sys.argv[1]).glob(f"*{suffix}")):
        points = [[float(n) for n in line.split()] for line in path.with_suffix(".points").read_text().splitlines()]
        try:
            rows = evaluate(path.read_text(), points)
        except Exception as error:  # noqa: BLE001 - whatever the peer raises is its answer
            path.with_suffix(".err").write_text(f"{type(error).__name__}: {error}\n")
            continue
        path.with_suffix(".out").write_text("".join(" ".join(map(repr, row)) + "\n" for row in rows))
