"""Loops: which controllers drive which plants, with references, disturbances, measures and a duration."""

from __future__ import annotations

from typing import ClassVar, Final

from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.expr import Expr
from fuzzyctl.model.block import Bounds, Guarantee, Node, Param
from fuzzyctl.model.controller import Definition, EquationBlock, Signal, State
from fuzzyctl.model.forms import NEEDED, Form
from fuzzyctl.model.plant import Plant
from fuzzyctl.records import dataclass


@dataclass(frozen=True, kw_only=True, repr=False)
class Measure(Definition):
    """A number that a run is judged by: `measure NAME "label" unit "..." = MEASURE(signal, ...)`."""

    label: str = ""
    unit: str = ""


@dataclass(frozen=True, kw_only=True, repr=False)
class Varied(Node):
    """A number that differs between the members of a family: `for NAME in [low, high]`.

    Args:
        name: `BLOCK.STATE` for the start of a state, `BLOCK.PARAM`, or a param of the loop.
        bounds: Its range.
    """

    name: str
    bounds: Bounds


@dataclass(frozen=True, kw_only=True, repr=False)
class Disturbance(Signal):
    """Any signal within a range; a plain run takes the nominal value."""

    bounds: Bounds
    nominal: Expr


@dataclass(frozen=True, kw_only=True, repr=False)
class Always(Guarantee):
    """A claim about every instant of every member of a family.

    Args:
        begin: The first time that it speaks of [s]; None for the begin of the run.
        end: The last one [s]; None for the end of the run.
        forever: Whether it goes on behind the end of the run.
    """

    begin: Expr | None = None
    end: Expr | None = None
    forever: bool = False


@dataclass(frozen=True, kw_only=True, repr=False)
class Stable(Guarantee):
    """The claim that every member of a family converges; its expression is the word `stable`."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Loop(EquationBlock):
    """An experiment: blocks, their connections, and measures.

    Args:
        definitions: References, disturbances and other signals, which may use the time `t` [s] and call the functions
            of `model/signals.py`; files of `csv` are named relative to the folder of `path`.
        measures: The results of a run: expressions over params, other measures and calls of the functions of
            `model/measures.py`, whose first arguments are expressions over signals.
        requirements: Claims about measures, checked on the run.
        varied: Starts and params in which the members of the family of the loop differ.
        disturbances: Signals that may be anything in their ranges.
        guarantees: Claims about every member, `Always` or `Stable`; a run judges the former at its samples.
        duration: How long a run lasts [s].
        step: Time between two samples of the record [s]; None for the shortest period of the controllers.
        plants: The plants that instances are of.
    """

    kind: ClassVar[str] = "loop"

    measures: tuple[Measure, ...] = ()
    requirements: tuple[Guarantee, ...] = ()
    varied: tuple[Varied, ...] = ()
    disturbances: tuple[Disturbance, ...] = ()
    duration: Expr
    step: Expr | None = None
    plants: tuple[Plant, ...] = ()

    def __repr__(self) -> str:
        blocks = ", ".join(f"{i.name} = {i.controller}" for i in self.instances)
        judged = f"{counted(len(self.measures), 'measure')}, {counted(len(self.requirements), 'requirement')}"
        return printable(f"Loop({self.name}: {blocks}; {judged})")

    @property
    def unclaimed(self) -> str:
        """Why the loop has no claims to prove, an empty text if it has some."""
        return "" if self.guarantees else "runs decide the requirements of loops: fuzzyctl simulate"

    @property
    def signals(self) -> tuple[Definition, ...]:
        """The `let` lines, and the disturbances with their nominal values."""
        nominal = (Definition(name=d.name, value=d.nominal, span=d.span) for d in self.disturbances)
        return (*self.definitions, *nominal)

    @property
    def always(self) -> tuple[Always, ...]:
        """The claims about every instant."""
        return tuple(g for g in self.guarantees if isinstance(g, Always))

    @property
    def family(self) -> dict[str, Bounds]:
        """The ranges of the numbers in which members differ, by name: those of `varied`, then the disturbances."""
        return {v.name: v.bounds for v in self.varied} | {d.name: d.bounds for d in self.disturbances}

    def declared(self, name: str) -> tuple[EquationBlock, Param | State | Disturbance] | None:
        """Return the param, state or disturbance of a name, behind the block that declares it; None for none.

        Args:
            name: `BLOCK.STATE`, `BLOCK.PARAM`, or a param or a disturbance of the loop.
        """
        first, dot, rest = name.partition(".")
        instance = next((i for i in self.instances if i.name == first), None) if dot else None
        block = self.callee(instance) if instance is not None else self
        items: list[Param | State | Disturbance] = [*block.params, *block.states]
        items += self.disturbances if block is self else ()
        return next(((block, item) for item in items if item.name == (rest if instance is not None else name)), None)


def _measure(form: str, what: str, *signals: str, **settings: float) -> Form:
    """Return a measure; each may be limited to the samples with begin <= t <= end."""
    return Form(form, what, signals, {**settings, "begin": 0.0, "end": float("inf")})


_BOTH = ("y", "reference")

#: The measures by name. Every one takes `begin=` and `end=` as well: only samples between these times count.
MEASURES: Final[dict[str, Form]] = {
    "overshoot": _measure(
        "overshoot(y, reference)",
        "the largest excess of y over the last value of the reference, relative to the step from the first value of y "
        "to it; 0 if y does not exceed it",
        *_BOTH,
    ),
    "rise_time": _measure(
        "rise_time(y, reference, low=10 %, high=90 %)",
        "the time from low to high, relative to the step from the first value of y to the last one of the reference "
        "[s]",
        *_BOTH,
        low=0.1,
        high=0.9,
    ),
    "settling": _measure(
        "settling(y, reference, band=2 %)",
        "the time from begin until y stays within the band around the last value of the reference [s]; the band is "
        "relative to the step from the first value of y to it; inf if y does not settle",
        *_BOTH,
        band=0.02,
    ),
    "steady_state_error": _measure(
        "steady_state_error(y, reference)", "the mean of reference - y over the last twentieth of the time", *_BOTH
    ),
    "iae": _measure("iae(y, reference)", "the integral of abs(reference - y)", *_BOTH),
    "ise": _measure("ise(y, reference)", "the integral of (reference - y)^2", *_BOTH),
    "itae": _measure("itae(y, reference)", "the integral of (t - begin) abs(reference - y)", *_BOTH),
    "integral": _measure("integral(x)", "the integral of x", "x"),
    "effort": _measure("effort(u)", "the integral of u^2", "u"),
    "maximum": _measure("maximum(x)", "the largest value of x", "x"),
    "minimum": _measure("minimum(x)", "the smallest value of x", "x"),
    "final": _measure("final(x)", "the last value of x", "x"),
    "mean": _measure("mean(x)", "the integral of x divided by the time", "x"),
    "rms": _measure("rms(x)", "the root of the mean of x^2", "x"),
}


#: Name of the time of a run [s], in plants and loops.
TIME: Final = "t"

#: The signals by name; all their arguments depend on params only.
SIGNALS: Final[dict[str, Form]] = {
    "steps": Form(
        form="steps(0: 1.0, 25 s: 0.5)",
        what="the value at the last time that has passed; 0 before the first one; times ascend",
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
        what="a column of a CSV file with a header, interpolated linearly between its rows, constant before and after "
        "them; 'time' names the column of ascending times [s], by default the first one",
        settings={"file": NEEDED, "column": NEEDED, "time": ""},
        texts=("file", "column", "time"),
    ),
}
