"""The tables of the page, as HTML; every text that comes from outside is escaped."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

from dwmr.metrics import TABLE_12

_ERRORS = (("x_e", "x_e [m]"), ("y_e", "y_e [m]"), ("theta_e", "θ_e [rad]"))
_SECTIONS = (
    ("rmse", "Root mean square errors, each robot in the axes of Table 12"),
    ("rmse_inertial", "Root mean square errors in inertial axes"),
    ("rmse_body", "Root mean square errors in the robot's own axes"),
)


def table(caption: str, head: Sequence[str], body: Iterable[Sequence[str]], left: int = 2) -> str:
    """Return a table.

    Args:
        caption: What it shows.
        head: Names of the columns.
        body: Rows; a row's first cell is its heading.
        left: Columns of text, which stand to the left; the others hold numbers.
    """
    cells = "".join(f'<th scope="col"{_side(k, left)}>{escape(name)}</th>' for k, name in enumerate(head))
    lines = [
        f'<div class="wide"><table><caption>{escape(caption)}</caption>',
        f"<thead><tr>{cells}</tr></thead><tbody>",
    ]
    for row in body:
        rest = "".join(f"<td{_side(k, left)}>{escape(cell)}</td>" for k, cell in enumerate(row[1:], start=1))
        lines.append(f'<tr><th scope="row">{escape(row[0])}</th>{rest}</tr>')
    return "\n".join([*lines, "</tbody></table></div>"])


def _side(k: int, left: int) -> str:
    return "" if k < left else ' class="n"'


def errors(runs: Mapping[str, Any], compare: bool) -> str:
    """Return the tables of tracking errors, the first beside Table 12 of the paper if asked for."""
    found = []
    for section, caption in _SECTIONS:
        beside = compare and section == "rmse"
        head = ["law", "robot"]
        for _, label in _ERRORS:
            head += [label, "Table 12", "ratio"] if beside else [label]
        rows = [
            [law, robot, *_error_cells(law, robot, run, section, beside)]
            for law, run in runs.items()
            for robot in run[section]
        ]
        found.append(table(caption + (", beside Table 12 of the paper" if beside else ""), head, rows))
    return "\n".join(found)


def _error_cells(law: str, robot: str, run: Mapping[str, Any], section: str, beside: bool) -> list[str]:
    # errors of a run that ended early are no counterpart of the printed ones
    printed = TABLE_12.get(law, {}).get(robot, {}) if run["stopped"] is None else {}
    cells = []
    for name, _ in _ERRORS:
        value, wanted = run[section][robot][name], printed.get(name)
        cells.append(_number(value))
        if beside:
            cells += ["", ""] if wanted is None else [f"{wanted:.4f}", f"{value / wanted:.2f}"]
    return cells


def effort(runs: Mapping[str, Any]) -> str:
    """Return the table of clearance, avoidance, chattering and limits."""
    head = ["law", "robot", "clearance [m]", "avoids [s]", "mean |dv_c/dt| [m/s²]", "mean |dω_c/dt| [rad/s²]"]
    head += ["at limit of v [%]", "of ω [%]", "of torque [%]"]
    rows = []
    for law, run in runs.items():
        for robot in run["rmse"]:
            clearance, chattering, limits = run["clearance"][robot], run["chattering"][robot], run["saturation"][robot]
            rows.append(
                [
                    law,
                    robot,
                    "" if clearance is None else f"{clearance:.2f}",
                    f"{run['avoidance_s'][robot]:.1f}",
                    f"{chattering['v']:.3f}",
                    f"{chattering['omega']:.3f}",
                    *(f"{100.0 * limits[name]:.1f}" for name in ("v", "omega", "torque")),
                ]
            )
    return table("Safety and effort", head, rows)


def _number(value: float) -> str:
    return f"{value:.4f}" if abs(value) < 1e6 else f"{value:.3e}"
