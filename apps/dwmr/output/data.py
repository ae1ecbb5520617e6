"""Files of recorded signals: npz, CSV, MATLAB's .mat and Parquet, which give back the same numbers, bit for bit."""

from __future__ import annotations

import csv
import json
import os
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fuzzyctl.experiments import parquet
from fuzzyctl.experiments.result_files import Results, finite

if TYPE_CHECKING:
    from dwmr.core.arrays import FloatArray
    from dwmr.scenario.model import Scenario
    from dwmr.simulation.simulate import Trajectory

#: Name of the times among the signals.
TIME = "t"


@dataclass(frozen=True)
class Data:
    """Signals of runs.

    Args:
        runs: By control law, then by signal: `t` of shape (samples,) [s], all others of shape (samples, robots).
        metadata: Plain data: robots, units and meanings of the signals, scenario, rule files, versions.
    """

    runs: Mapping[str, Mapping[str, FloatArray]]
    metadata: Mapping[str, Any]

    @property
    def robots(self) -> tuple[str, ...]:
        """Names in the order of the arrays' second axis."""
        return tuple(self.metadata["robots"])

    def signals(self) -> tuple[str, ...]:
        """Return the names of all signals of all runs but `t`, in order."""
        return tuple(dict.fromkeys(name for run in self.runs.values() for name in run if name != TIME))


def signals_of(trajectories: Sequence[Trajectory], scenario: Scenario, metadata: Mapping[str, Any]) -> Data:
    """Return the signals of some runs with their units, the Lyapunov functions of `lyapunov.signals` among them.

    Those are of the whole run, whatever is kept of it. A law without them has none, and where a signal of a law's own
    has the name of one, that signal is kept.

    Args:
        trajectories: One per control law, of the same robots.
        scenario: Scenario of the runs.
        metadata: What else to say about the runs.
    """
    from dwmr.results import lyapunov
    from dwmr.simulation.loop import SIGNALS

    units: dict[str, Any] = {TIME: {"unit": "s", "doc": "time"}}
    runs: dict[str, dict[str, FloatArray]] = {}
    for one in trajectories:
        samples: Any = saved_samples(one, scenario)
        if len(samples) == len(one.t):
            samples = slice(None)  # no copies
        runs[one.controller] = {TIME: one.t[samples]}
        for signal in (*SIGNALS, *one.law_signals):
            runs[one.controller][signal.name] = one[signal.name][samples]
            units[signal.name] = {"unit": signal.unit, "doc": signal.doc}
        functions = lyapunov.signals(one, scenario)
        for signal in lyapunov.SIGNALS:
            if signal.name in functions and signal.name not in one.names:
                runs[one.controller][signal.name] = functions[signal.name][samples]
                units.setdefault(signal.name, {"unit": signal.unit, "doc": signal.doc})
    return Data(runs, {**metadata, "robots": list(trajectories[0].robots), "signals": units})


def saved_samples(trajectory: Trajectory, scenario: Scenario) -> NDArray[np.int64]:
    """Return the numbers of the recorded samples that are saved: about every `run.save_every` periods, and the last."""
    from dwmr.simulation.periods import kept_samples

    return kept_samples(len(trajectory.t), max(1, scenario.run.save_every // trajectory.every))


def rows(data: Data) -> dict[str, Any]:
    """Return the signals as columns of one table, a row for each law, time and robot; None for missing signals.

    Returns:
        "controller" and "robot" as lists, "t" and the signals as arrays or None, by control law and column.
    """
    count = len(data.robots)
    return {
        law: {
            "controller": [law] * (len(run[TIME]) * count),
            TIME: np.repeat(run[TIME], count),
            "robot": list(data.robots) * len(run[TIME]),
            **{name: run[name].reshape(-1) if name in run else None for name in data.signals()},
        }
        for law, run in data.runs.items()
    }


def from_rows(law: Sequence[str], columns: Mapping[str, FloatArray], metadata: Mapping[str, Any]) -> Data:
    """Return the signals of a table as `rows` makes it; which signals a law has is in the metadata.

    Args:
        law: Control law of each row.
        columns: `t` and the signals, each of as many numbers as there are rows.
        metadata: With `robots`, and `runs`, the names of signals by control law.
    """
    laws, count = np.array(law), len(metadata["robots"])
    runs = {}
    for name, signals in metadata["runs"].items():
        mine = laws == name
        runs[name] = {TIME: columns[TIME][mine][::count]}
        runs[name] |= {s: columns[s][mine].reshape(-1, count) for s in signals if s != TIME}
    return Data(runs, {k: v for k, v in metadata.items() if k != "runs"})


def described(data: Data) -> dict[str, Any]:
    """Return the metadata with the names of the signals of each law, which a table cannot tell from empty cells."""
    return {**data.metadata, "runs": {law: list(run) for law, run in data.runs.items()}}


class UnreadableDataError(ValueError):
    """Raised when a file does not hold the signals of runs."""


def _save_npz(path: Path, data: Data) -> None:
    arrays: dict[str, Any] = {f"{law}/{name}": a for law, run in data.runs.items() for name, a in run.items()}
    arrays["metadata"] = np.array(json.dumps(data.metadata, indent=2, ensure_ascii=False))
    with path.open("wb") as file:
        np.savez(file, **arrays)


def _load_npz(path: Path) -> Data:
    runs: dict[str, dict[str, Any]] = {}
    with np.load(path, allow_pickle=False) as archive:
        for key in archive.files:
            law, slash, name = key.partition("/")
            if slash:
                runs.setdefault(law, {})[name] = archive[key]
        return Data(runs, json.loads(str(archive["metadata"])))


_MARK = "# metadata: "
#: Rows converted to text at a time.
_CHUNK = 20_000


def _save_csv(path: Path, data: Data) -> None:
    """Write the shortest text of every number that reads back bit for bit; a signal that a law has not is empty."""
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(f"{_MARK}{json.dumps(described(data), ensure_ascii=False)}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["controller", TIME, "robot", *data.signals()])
        for columns in rows(data).values():
            count = len(columns["controller"])
            for first in range(0, count, _CHUNK):
                writer.writerows(
                    zip(*(_text(c, first, min(first + _CHUNK, count)) for c in columns.values()), strict=True)
                )


def _text(column: Any, first: int, last: int) -> list[Any]:
    if column is None:
        return [""] * (last - first)
    part = column[first:last]
    # Python's own floats, which the csv module writes by repr
    return part if isinstance(part, list) else part.tolist()


def _load_csv(path: Path) -> Data:
    """Read what `_save_csv` wrote.

    Raises:
        ValueError: When it is something else.
    """
    with path.open(encoding="utf-8", newline="") as file:
        first = file.readline()
        if not first.startswith(_MARK):
            raise ValueError(f"its first line does not begin with '{_MARK.strip()}'")
        metadata = json.loads(first.removeprefix(_MARK))
        reader = csv.reader(file)
        names = next(reader)
        columns = list(zip(*reader, strict=True)) or [()] * len(names)
    cells_of = dict(zip(names, columns, strict=True))
    numbers = {
        name: np.array([float(cell or "nan") for cell in cells]) for name, cells in cells_of.items()
        if name not in ("controller", "robot")
    }  # fmt: skip
    return from_rows(cells_of["controller"], numbers, metadata)


#: The text at the head of the file; what scipy writes there has the time of day in it.
_HEAD = b"MATLAB 5.0 MAT-file, written by dwmr".ljust(116)


def _save_mat(path: Path, data: Data) -> None:
    """Write the signals; `t` is a column, as MATLAB has it."""
    from scipy import io

    variables: dict[str, Any] = {law: dict(run) for law, run in data.runs.items()}
    variables["robots"] = np.array(data.robots, dtype=object)
    # JSON's own escapes, because MATLAB's text has two bytes a character at most
    variables["metadata"] = json.dumps(described(data))
    with path.open("w+b") as file:
        io.savemat(file, variables, long_field_names=True, oned_as="column")
        file.seek(0)
        file.write(_HEAD)


def _load_mat(path: Path) -> Data:
    """Read what `_save_mat` wrote.

    Raises:
        ValueError: When it is something else.
    """
    from scipy import io

    try:
        variables = io.loadmat(str(path), squeeze_me=False)
    except (io.matlab.MatReadError, NotImplementedError) as error:
        raise ValueError(str(error)) from error
    metadata = json.loads(str(variables["metadata"][0]))
    runs = {law: _signals(variables[law][0, 0], names) for law, names in metadata.pop("runs").items()}
    return Data(runs, metadata)


def _signals(struct: Any, names: list[str]) -> dict[str, Any]:
    run = {name: np.ascontiguousarray(struct[name], dtype=np.float64) for name in names}
    run[TIME] = run[TIME].reshape(-1)
    return run


#: Under this key a file holds its metadata.
KEY = "dwmr"


def _save_parquet(path: Path, data: Data) -> None:
    """Write the signals: a row for each law, time and robot; a signal that a law has not is null."""
    import pyarrow as pa

    parts = []
    for columns in rows(data).values():
        count = len(columns["controller"])
        parts.append(
            pa.table({name: pa.nulls(count, pa.float64()) if c is None else pa.array(c) for name, c in columns.items()})
        )
    parquet.write(path, pa.concat_tables(parts), described(data), KEY)


def _load_parquet(path: Path) -> Data:
    """Read what `_save_parquet` wrote.

    Raises:
        ValueError: When it is something else.
    """
    table = parquet.read(path)
    laws = table.column("controller").to_pylist()
    names = [name for name in table.column_names if name not in ("controller", "robot")]
    numbers = {name: np.asarray(table.column(name).to_numpy(), dtype=np.float64) for name in names}
    return from_rows(laws, numbers, parquet.metadata_of(table, KEY))


#: How to write and to read each format, by the suffix of the file, which `dwmr run --data` takes.
FORMATS = {
    "npz": (_save_npz, _load_npz),
    "csv": (_save_csv, _load_csv),
    "mat": (_save_mat, _load_mat),
    "parquet": (_save_parquet, _load_parquet),
}
#: All files that a run leaves.
NAMES = ("summary.json", *(f"trajectory.{name}" for name in FORMATS), "path.png", "errors.png")


def suffix(path: Path) -> str:
    """Return the format that a file's name stands for."""
    return path.suffix.removeprefix(".").lower()


def load(path: str | os.PathLike[str]) -> Data:
    """Read the signals of runs from a file that `dwmr run` wrote.

    Args:
        path: A file with the suffix of its format: npz, csv, mat or parquet.

    Raises:
        OSError: When it cannot be read.
        UnreadableDataError: When it holds something else.
        ImportError: When Parquet is to be read without pyarrow.
    """
    path = Path(path)
    if suffix(path) not in FORMATS:
        raise UnreadableDataError(f"{path}: the suffix must be one of {', '.join(FORMATS)}")
    try:
        return FORMATS[suffix(path)][1](path)
    except (KeyError, ValueError, TypeError, IndexError, EOFError, zipfile.BadZipFile) as error:
        raise UnreadableDataError(f"{path} does not hold the signals of runs: {error}") from error


def save(path: Path, data: Data) -> None:
    """Write the signals of runs in the format of the file's suffix."""
    FORMATS[suffix(path)][0](path, data)


def write_trajectories(
    files: Results,
    trajectories: Sequence[Trajectory],
    scenario: Scenario,
    metadata: Mapping[str, Any],
    formats: Sequence[str] = ("npz",),
) -> None:
    """Write the signals of all control laws with their Lyapunov functions, in each format as trajectory.FORMAT.

    Args:
        files: Where they go.
        trajectories: One per control law.
        scenario: Scenario of the runs; of its samples every `run.save_every`-th is saved.
        metadata: What else to say about the run.
        formats: Of `FORMATS`.
    """
    data = signals_of(trajectories, scenario, finite(metadata))
    for one in formats:
        files.write(f"trajectory.{one}", lambda path: save(path, data))
