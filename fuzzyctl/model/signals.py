"""Signals of loops: functions of the time `t` that references, disturbances and noise are made of."""

from __future__ import annotations

from typing import Final

from fuzzyctl.model.forms import NEEDED, Form

#: Name of the time of a run [s], in plants and loops.
TIME: Final = "t"

#: The signals by name; all their arguments depend on params only.
SIGNALS: Final[dict[str, Form]] = {
    "steps": Form(
        form="steps(0: 1.0, 25 s: 0.5)",
        what="the value of the last time that has come; 0 before the first one; times ascend",
        pairs=True,
    ),
    "pulse": Form(
        form="pulse(begin, end)",
        what="1 for begin <= t < end, else 0",
        settings={"begin": NEEDED, "end": NEEDED},
    ),
    "ramp": Form(
        form="ramp(begin, end, low=0, high=1)",
        what="low until begin, then on a straight line to high at end",
        settings={"begin": NEEDED, "end": NEEDED, "low": 0.0, "high": 1.0},
    ),
    "sine": Form(
        form="sine(frequency, amplitude=1, phase=0)",
        what="amplitude sin(2 pi frequency t + phase), frequency in Hz, phase in rad",
        settings={"frequency": NEEDED, "amplitude": 1.0, "phase": 0.0},
    ),
    "noise": Form(
        form="noise(sigma, seed=0)",
        what="normal with mean 0 and standard deviation sigma, drawn for each sample of the record and held",
        settings={"sigma": NEEDED, "seed": 0.0},
    ),
    "csv": Form(
        form='csv("file.csv", column="NAME", time="NAME")',
        what="a column of a CSV file with a header, on straight lines between its rows; constant before and behind "
        "them; 'time' names the column of ascending times [s], the first one if left out",
        settings={"file": NEEDED, "column": NEEDED, "time": ""},
        texts=("file", "column", "time"),
    ),
}
