"""Functions of plants: dead time, and the forms of plants of one line."""

from __future__ import annotations

from typing import Final

from fuzzyctl.model.forms import NEEDED, Form

#: Functions that expressions of plants may call.
PLANT_FUNCTIONS: Final[dict[str, Form]] = {
    "delay": Form(
        form="delay(x, time, start=0)",
        what="x of some seconds before; start until then",
        signals=("x",),
        settings={"time": NEEDED, "start": 0.0},
    ),
}

#: Plants of one line by the function that they are written with; all arguments depend on params only.
PLANTS: Final[dict[str, Form]] = {
    "tf": Form(
        form="tf(num=[1], den=[1, 2, 1], delay=0 s)",
        what="a transfer function: coefficients of the highest power first",
        settings={"num": NEEDED, "den": NEEDED, "delay": 0.0},
        lists=("num", "den"),
    ),
    "zpk": Form(
        form="zpk(zeros=[-3], poles=[-1, pair(-1, 2)], gain=1, delay=0 s)",
        what="zeros, poles and gain; pair(a, b) is the conjugate pair a ± b i",
        settings={"zeros": NEEDED, "poles": NEEDED, "gain": 1.0, "delay": 0.0},
        lists=("zeros", "poles"),
    ),
    "ss": Form(
        form="ss(A=[[0, 1], [-2, -3]], B=[0, 1], C=[1, 0], D=[0], delay=0 s)",
        what="matrices of x' = A x + B u, y = C x + D u, as lists of rows",
        settings={"A": NEEDED, "B": NEEDED, "C": NEEDED, "D": "", "delay": 0.0},
        lists=("A", "B", "C", "D"),
    ),
    "python": Form(
        form='python("cart.py")',
        what="a plant in Python; see the reference",
        settings={"file": NEEDED},
        texts=("file",),
    ),
    "fmu": Form(
        form='fmu("motor.fmu")',
        what="a Functional Mock-up Unit for co-simulation; see the reference",
        settings={"file": NEEDED},
        texts=("file",),
    ),
}
