"""Plants: ordinary differential equations, algebraic outputs and dead time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Final

from fuzzyctl.model.controller import Definition, EquationBlock
from fuzzyctl.model.forms import NEEDED, Form
from fuzzyctl.records import dataclass


@dataclass(frozen=True, kw_only=True, repr=False)
class Plant(EquationBlock):
    """A plant in continuous time; its inputs are held while it is integrated over a period.

    A plant that was written as a transfer function, zeros and poles, or matrices is one of linear equations.
    Expressions may use the time `t` [s]; `delay(x, time, start=0)` is x of `time` seconds before.

    Args:
        derivatives: The derivative of each state by time.
        python: The file of a plant in Python, an empty string for one in text. Its `inputs`, `states` and `outputs`
            are those of the file, read without running it; `derivatives` are empty, and the value of each output is its
            own name.
        fmu: The file of a plant that is an FMU, else an empty string. The same holds for it; it has no states here.
        calls: Of a plant whose code is functions in place of a file: its derivatives from time, states and inputs, and
            its outputs from time and states, by `python`.
    """

    kind: ClassVar[str] = "plant"

    derivatives: tuple[Definition, ...] = ()
    python: str = ""
    fmu: str = ""
    calls: tuple[Callable[..., Any], ...] = ()

    @property
    def unclaimed(self) -> str:
        """Why the block has no claims to prove."""
        return "plants make no claims"

    @property
    def changes(self) -> tuple[Definition, ...]:
        """The derivatives."""
        return self.derivatives

    @property
    def external(self) -> str:
        """The file of code that computes the plant: in Python, or an FMU; an empty string for a plant in text."""
        return self.python or self.fmu


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
