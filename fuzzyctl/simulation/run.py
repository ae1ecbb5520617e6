"""The result of a run: signals over time, measures and requirements, files of signals."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, UnknownNameError
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.experiments.parquet import available, write_table
from fuzzyctl.experiments.result_files import write_csv
from fuzzyctl.expr import Expr, Name, evaluate
from fuzzyctl.model.loop import Loop
from fuzzyctl.operations import Displayed, operation
from fuzzyctl.simulation.judgement import Judgement, Requirement
from fuzzyctl.simulation.loop_params import params_of

if TYPE_CHECKING:
    from fuzzyctl.annotations import Axes, FloatArray, Panels


@dataclass(frozen=True, repr=False)
class Run(Displayed):
    """One run of a loop.

    `run["tank.y"]` is a signal over the times `run.t`: a let of the loop, or an input, state or output of a block.

    Args:
        loop: The loop, its params set.
        t: Times of the samples, shape (n,) [s].
        record: All signals, shape (n, signals).
        positions: Columns of the signals by name.
        judgement: The measures and requirements of the loop.
        plant_states: Names of the states that are integrated.
        params: Values of free params.
        substeps: Steps of integration between two samples; 0 for an adaptive solver.
        stopped: Why it ended early, None for a run to the end.
        solver: What integrated the plants.
        error: Largest difference of each state from a run with half the step of integration, or a tenth of the
            tolerances of an adaptive solver; empty without such a run.
    """

    loop: Loop = field(repr=False)
    t: FloatArray = field(repr=False)
    record: FloatArray = field(repr=False)
    positions: Mapping[str, int] = field(repr=False)
    judgement: Judgement = field(repr=False)
    plant_states: tuple[str, ...] = ()
    params: Mapping[str, float] = field(default_factory=dict)
    substeps: int = 1
    stopped: Diagnostic | None = None
    solver: str = "RK4"
    error: Mapping[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        end = f"{self.t[-1]:.6g} s" if len(self.t) else "no time"
        met = f"{sum(r.holds for r in self.requirements)} of {len(self.requirements)} requirements hold"
        how = f"stopped, {met}" if self.stopped is not None else met
        return printable(f"Run({self.loop.name}: {end}, {len(self.t)} samples, {len(self.names)} signals; {how})")

    def plot(self, *, ax: Axes | None = None) -> Panels:
        """Draw the signals over time, see `fuzzyctl.plot.runs`."""
        panels: Panels = operation("plot_run")(self, ax=ax)
        return panels

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the signals."""
        return tuple(n for n in self.positions if not n.startswith("#"))

    def __getitem__(self, name: str) -> FloatArray:
        """Return a signal, shape (n,).

        Raises:
            UnknownNameError: For a name of none.
        """
        if name == "t":
            return self.t
        if name not in self.positions:
            raise UnknownNameError("signal", name, self.names)
        return self.record[:, self.positions[name]]

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.t)

    def signal(self, expr: Expr) -> FloatArray:
        """Return the record of a signal, of an operand of a measure, or of a constant, shape (n,)."""
        if expr in self.judgement.signals:
            return self.record[:, self.positions[f"#{self.judgement.signals.index(expr)}"]]
        if isinstance(expr, Name) and expr.name in self.positions:
            return self[expr.name]
        return np.full(len(self), evaluate(expr, self.loop.param_values.values | dict(self.params)))

    @cached_property
    def measures(self) -> dict[str, float]:
        """The measures by name, of the samples up to the stop if the run was stopped; NaN for one without a value."""
        return self.judgement.measures(self.t, self.signal, self.params)

    @cached_property
    def requirements(self) -> tuple[Requirement, ...]:
        """Whether each requirement holds; none does in a run that was stopped."""
        stopped = self.stopped is not None
        return self.judgement.requirements(self.measures, self.t, self.signal, self.params, stopped=stopped)

    @property
    def passed(self) -> bool:
        """Whether the run reached its end and meets all requirements."""
        return self.stopped is None and all(r.holds for r in self.requirements)

    def summary(self) -> dict[str, Any]:
        """Return the facts of the run as plain data; None stands for a number that is not finite."""
        return {
            "loop": self.loop.name,
            "title": self.loop.title,
            "file": self.loop.path,
            "params": params_of(self.loop) | dict(self.params),
            "samples": len(self.t),
            "step_s": float(self.t[1] - self.t[0]) if len(self.t) > 1 else None,
            "end_s": float(self.t[-1]) if len(self.t) else None,
            "solver": self.solver,
            "substeps": self.substeps or None,
            "integration_error": {n: _finite(v) for n, v in self.error.items()} or None,
            "measures": {n: _finite(v) for n, v in self.measures.items()},
            "requirements": [r.as_dict() for r in self.requirements],
            "stopped": None if self.stopped is None else self.stopped.as_dict(),
        }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


#: Formats of data, each with the suffix of its files.
FORMATS: Final = ("csv", "npz", "parquet")


def require_format(form: str) -> None:
    """Refuse a format whose package is missing.

    Raises:
        ArgumentError: For Parquet without pyarrow.
    """
    if form == "parquet" and not available():
        raise ArgumentError("Parquet needs pyarrow: pip install 'fuzzyctl[data]'")


def save(run: Run, path: Path, form: str) -> None:
    """Write the times and signals of a run to a file of one of `FORMATS`."""
    columns = {"t": run.t} | {name: run[name] for name in run.names}
    if form == "npz":
        with path.open("wb") as binary:
            np.savez_compressed(binary, **columns)  # type: ignore[arg-type]  # no signal is called allow_pickle
        return
    lists = {name: values.tolist() for name, values in columns.items()}
    if form == "csv":
        write_csv(path, lists)
    else:
        write_table(path, lists, {"loop": run.loop.name}, "fuzzyctl")
