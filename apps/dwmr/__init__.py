"""Formation of differential-drive robots under sliding mode control, after Goto, Bertol and Martins.

`read`, `simulate` and `measure` run a scenario from Python, `load` reads the signals that `dwmr run` wrote, and `find`
returns the file of a shipped scenario. `read_logs` reads logs of real robots, `differences` compares a run with them,
`identify` fits a robot to one, `Replica` simulates it. `import dwmr` loads nothing heavy.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dwmr.control.fuzzy_gains import Known
    from dwmr.output.data import load
    from dwmr.results.identification import Replica, UnexplainedError, identify
    from dwmr.results.logs import Log, differences, read_logs
    from dwmr.results.metrics import measure
    from dwmr.scenario.file import find, read
    from dwmr.simulation.simulate import simulate

_HOMES = {
    "Known": "dwmr.control.fuzzy_gains",
    "Log": "dwmr.results.logs",
    "Replica": "dwmr.results.identification",
    "differences": "dwmr.results.logs",
    "find": "dwmr.scenario.file",
    "UnexplainedError": "dwmr.results.identification",
    "identify": "dwmr.results.identification",
    "load": "dwmr.output.data",
    "measure": "dwmr.results.metrics",
    "read": "dwmr.scenario.file",
    "read_logs": "dwmr.results.logs",
    "simulate": "dwmr.simulation.simulate",
}

__all__ = [
    "Known", "Log", "Replica", "UnexplainedError", "differences", "find", "identify", "load", "measure", "read",
    "read_logs", "simulate",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'dwmr' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return [*__all__]
