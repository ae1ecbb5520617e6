"""Reference trajectories compiled: posture and velocities of the virtual robot as functions of time."""

from __future__ import annotations

from collections.abc import Callable

from dwmr.core.arrays import FloatArray
from dwmr.core.interfaces import reference_path
from dwmr.core.reference import Reference
from dwmr.reference import curves

eight = reference_path(curves.eight)
circle = reference_path(curves.circle)
line = reference_path(curves.line)
spline = reference_path(curves.spline)

#: Compiled path by the name of its function in `curves`, see `prepared.Shape`.
PATHS: dict[str, Callable[[float, FloatArray], Reference]] = {
    "eight": eight,
    "circle": circle,
    "line": line,
    "spline": spline,
}
