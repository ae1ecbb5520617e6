"""Evaluates FLL with pyfuzzylite; runs in an environment of its own, which has nothing but that.

    python pyfuzzylite_driver.py FOLDER

reads every NAME.fll of the folder with its points NAME.points, one a line, and writes the outputs to NAME.out, or to
NAME.err why there are none. The points of a file are a sequence: an engine keeps what it holds.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import fuzzylite as fl


def evaluate(text: str, points: list[list[float]]) -> list[list[float]]:
    engine = fl.FllImporter().from_string(text)
    results = []
    for point in points:
        for variable, value in zip(engine.input_variables, point, strict=True):
            variable.value = value
        engine.process()
        results.append([float(fl.scalar(v.value).item()) for v in engine.output_variables])
    return results


def main() -> None:
    warnings.simplefilter("ignore")
    folder = Path(sys.argv[1])
    for path in sorted(folder.glob("*.fll")):
        points = [[float(n) for n in line.split()] for line in path.with_suffix(".points").read_text().splitlines()]
        try:
            rows = evaluate(path.read_text(), points)
        except Exception as error:  # noqa: BLE001 - whatever the peer raises is its answer
            path.with_suffix(".err").write_text(f"{type(error).__name__}: {error}\n")
            continue
        path.with_suffix(".out").write_text("".join(" ".join(map(repr, row)) + "\n" for row in rows))


if __name__ == "__main__":
    main()
