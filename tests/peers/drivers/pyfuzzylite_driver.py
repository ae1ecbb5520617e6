"""Evaluates FLL with pyfuzzylite; runs in an environment of its own, which has nothing but that.

    python pyfuzzylite_driver.py FOLDER

reads every NAME.fll of the folder with its points NAME.points, one a line, and writes the outputs to NAME.out, or to
NAME.err why there are none. The points of a file are a sequence: an engine keeps what it holds.
"""

from __future__ import annotations

import warnings

import fuzzylite as fl
from answering import answer


def evaluate(text: str, points: list[list[float]]) -> list[list[float]]:
    engine = fl.FllImporter().from_string(text)
    results = []
    for point in points:
        for variable, value in zip(engine.input_variables, point, strict=True):
            variable.value = value
        engine.process()
        results.append([float(fl.scalar(v.value).item()) for v in engine.output_variables])
    return results


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    answer(".fll", evaluate)
