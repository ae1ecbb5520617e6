"""HTML tables of the report, with escaped text."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

from dwmr.output.report import filter_cells, hits, printed_errors

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
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(caption)}">',
        f"<table><caption>{escape(caption)}</caption>",
        f"<thead><tr>{cells}</tr></thead><tbody>",
    ]
    for row in body:
        rest = "".join(f"<td{_side(k, left)}>{escape(cell)}</td>" for k, cell in enumerate(row[1:], start=1))
        lines.append(f'<tr><th scope="row">{escape(row[0])}</th>{rest}</tr>')
    return "\n".join([*lines, "</tbody></table></div>"])


def _side(k: int, left: int) -> str:
    return "" if k < left else ' class="n"'


def errors(runs: Mapping[str, Any], printed: int | None) -> str:
    """Return the tables of tracking errors, the first beside a table of the paper if one is given by its number."""
    found = []
    for section, caption in _SECTIONS:
        beside = printed if section == "rmse" else None
        head = ["law", "robot"]
        for _, label in _ERRORS:
            head += [label] if beside is None else [label, f"Table {beside}", "ratio"]
        rows = [
            [law, robot, *_error_cells(law, robot, run, section, beside)]
            for law, run in runs.items()
            for robot in run[section]
        ]
        found.append(table(caption + ("" if beside is None else f", beside Table {beside} of the paper"), head, rows))
    return "\n".join(found)


def _error_cells(law: str, robot: str, run: Mapping[str, Any], section: str, beside: int | None) -> list[str]:
    wanted = printed_errors(law, run, beside).get(robot, {})
    cells = []
    for name, _ in _ERRORS:
        value, one = run[section][robot][name], wanted.get(name)
        cells.append(_number(value))
        if beside is not None:
            cells += ["", ""] if one is None else [f"{one:.4f}", f"{value / one:.2f}"]
    return cells


def safety(runs: Mapping[str, Any]) -> str:
    """Return the table of distances, contacts and avoidance."""
    kinds = {
        "centre_distance": "reference point to an obstacle's centre [m]",
        "obstacle_gap": "body to an obstacle [m]",
        "robot_gap": "body to another body [m]",
    }
    head = ["law", "robot", *(f"least distance, {what}" for what in kinds.values())]
    head += ["obstacles hit", "robots hit", "avoids [s]"]
    rows = [
        [
            law,
            robot,
            *("" if run[kind][robot] is None else f"{run[kind][robot]:.2f}" for kind in kinds),
            *map(str, hits(run, robot)),
            f"{run['avoidance_s'][robot]:.1f}",
        ]
        for law, run in runs.items()
        for robot in run["rmse"]
    ]
    return table("Safety; distances of bodies that overlap are negative", head, rows)


def safety_filter(runs: Mapping[str, Any]) -> str:
    """Return the table of what the safety filter did, nothing without one."""
    if not any("safety" in run for run in runs.values()):
        return ""
    head = ["law", "robot", "least distance of its disc [m]", "commands changed [% of time]"]
    head += ["infeasible moments", "missed moments"]
    rows = [[law, robot, *filter_cells(run, robot)] for law, run in runs.items() for robot in run["rmse"]]
    return table("Safety filter", head, rows)


def effort(runs: Mapping[str, Any]) -> str:
    """Return the table of chattering and limits."""
    head = ["law", "robot", "mean |dv_c/dt| [m/s²]", "mean |dω_c/dt| [rad/s²]"]
    head += ["at limit of v [%]", "of ω [%]", "of torque [%]"]
    rows = []
    for law, run in runs.items():
        for robot in run["rmse"]:
            chattering, limits = run["chattering"][robot], run["saturation"][robot]
            rows.append(
                [
                    law,
                    robot,
                    f"{chattering['v']:.3f}",
                    f"{chattering['omega']:.3f}",
                    *(f"{100.0 * limits[name]:.1f}" for name in ("v", "omega", "torque")),
                ]
            )
    return table("Effort", head, rows)


def stability(runs: Mapping[str, Any]) -> str:
    """Return the table of Lyapunov functions and of the drift of adaptive gains, nothing where no law has them."""
    if not any(run.get("lyapunov") for run in runs.values()):
        return ""
    head = ["law", "robot", "dV/dt > 0, Eq. (14) [% of time]", "dV/dt > 0, Eq. (26) [% of time]"]
    for gain in ("k_h,v [m/s]", "k_h,ω [rad/s]"):
        head += [f"{gain}: largest", "last", "growth per s, last quarter"]
    rows = []
    for law, run in runs.items():
        for robot in run["rmse"]:
            shares, drifts = run.get("lyapunov", {}).get(robot, {}), run.get("drift", {}).get(robot, {})
            cells = [shares.get(f"V_dot_{number}_positive") for number in (10, 23)]
            row = [law, robot, *("" if share is None else f"{100.0 * share:.1f}" for share in cells)]
            for name in ("k_h_v", "k_h_omega"):
                gain = drifts.get(name)
                row += ["", "", ""] if gain is None else [_number(gain[key]) for key in ("largest", "final", "growth")]
            rows.append(row)
    return table("Stability", head, rows)


def _number(value: float) -> str:
    return f"{value:.4f}" if abs(value) < 1e6 else f"{value:.3e}"
