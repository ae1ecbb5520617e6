"""What a run says on the terminal: the tables beside the paper's and the warnings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from dwmr.metrics import TABLE_12
from fuzzyctl.terminal import printable

_COLUMNS = (("x_e", "m"), ("y_e", "m"), ("theta_e", "rad"))
_SYMBOLS = {"x_e": "x_e", "y_e": "y_e", "theta_e": "θ_e"}


#: Least width of the tables; text for a pipe or a file is not squeezed further.
_WIDTH = 80
#: A longer name of a law would squeeze the numbers beside it.
_LONGEST_NAME = 10


def console() -> Console:
    """Return a console on standard output that is never too narrow for the tables."""
    found = Console()
    return found if found.width >= _WIDTH else Console(width=_WIDTH)


def print_report(out: Console, summary: Mapping[str, Any], compare: bool, why_not: str = "") -> None:
    """Print tracking errors, safety, effort, stability and warnings of every control law.

    Args:
        out: Where to.
        summary: Content of summary.json.
        compare: Whether to show Table 12 of the paper beside the errors.
        why_not: Why it is not shown, where a reader may expect it.
    """
    runs = summary["controllers"]
    out.print(_errors(runs, compare))
    out.print()
    out.print(_effort(runs))
    if any(run.get("lyapunov") for run in runs.values()):
        out.print()
        out.print(_stability(runs))
    for line in ([why_not] if why_not else []) + warnings(runs):
        out.print("[yellow]warning:[/] ", escape(printable(line)), sep="", highlight=False)


def _errors(runs: Mapping[str, Any], compare: bool) -> Table:
    title = "Root mean square errors" + (" beside Table 12 of the paper" if compare else "")
    table = _table(title)
    for name, unit in _COLUMNS:
        table.add_column(f"{_SYMBOLS[name]}\n{unit}", justify="right")
        if compare:
            table.add_column("Table\n12", justify="right", style="dim")
            table.add_column("\nratio", justify="right")
    for controller, run in runs.items():
        for k, (robot, values) in enumerate(run["rmse"].items()):
            whole = run["stopped"] is None  # errors of a run that ended early are no counterpart of the printed ones
            printed = TABLE_12.get(controller, {}).get(robot, {}) if whole else {}
            cells = [c for name, _ in _COLUMNS for c in _cells(values[name], printed.get(name), compare)]
            table.add_row(
                _name(controller, k, len(run["rmse"])), escape(robot), *cells, end_section=k == len(run["rmse"]) - 1
            )
    return table


def _cells(value: float, printed: float | None, compare: bool) -> list[str]:
    shown = _number(value, 4)
    if not compare:
        return [shown]
    return [shown, "" if printed is None else f"{printed:.4f}", "" if printed is None else f"{value / printed:.2f}"]


def _number(value: float, digits: int, sign: str = "") -> str:
    """Return a number with some digits behind the point, a large one by its power of ten."""
    return f"{value:{sign}.{digits}f}" if abs(value) < 1e6 else f"{value:{sign}.3e}"


def _effort(runs: Mapping[str, Any]) -> Table:
    table = _table("Safety and effort; |dv_c|, |dω_c| are the chattering")
    for name in (
        "clear-\nance m",
        "avoids\ns",
        "|dv_c|\nm/s²",
        "|dω_c|\nrad/s²",
        "% at limit of\nv    ω    τ",
        "least\nG_AIS",
        "took\ns",
    ):
        table.add_column(name, justify="right")
    for controller, run in runs.items():
        for k, robot in enumerate(run["rmse"]):
            first, chattering, limits = k == 0, run["chattering"][robot], run["saturation"][robot]
            clearance, g_ais = run["clearance"][robot], run.get("g_ais_min")
            table.add_row(
                _name(controller, k, len(run["rmse"])),
                escape(robot),
                "" if clearance is None else _number(clearance, 2),
                f"{run['avoidance_s'][robot]:.1f}",
                _number(chattering["v"], 3),
                _number(chattering["omega"], 3),
                " ".join(f"{100 * limits[name]:4.1f}" for name in ("v", "omega", "torque")),
                f"{g_ais:.4f}" if first and g_ais is not None else "",
                f"{run['wall_s']:.3f}" if first else "",
                end_section=k == len(run["rmse"]) - 1,
            )
    return table


def _stability(runs: Mapping[str, Any]) -> Table:
    """Return the table of Lyapunov functions and of the adaptive gains' drift; empty cells where a law has none."""
    table = _table("Stability: % of time with dV/dt > 0; gains k_h and their growth at the end")
    gains = [head for channel in "vω" for head in (f"k_h,{channel}\nlargest", "\nfinal", "\ngrowth")]
    for name in ("% in\n(14)", "% in\n(26)", *gains):
        table.add_column(name, justify="right")
    for controller, run in runs.items():
        for k, robot in enumerate(run["rmse"]):
            shares, drifts = run.get("lyapunov", {}).get(robot, {}), run.get("drift", {}).get(robot, {})
            table.add_row(
                _name(controller, k, len(run["rmse"])),
                escape(robot),
                *(_percent(shares.get(f"V_dot_{number}_positive")) for number in (10, 23)),
                *(cell for name in ("k_h_v", "k_h_omega") for cell in _drift(drifts.get(name))),
                end_section=k == len(run["rmse"]) - 1,
            )
    return table


def _name(law: str, row: int, rows: int) -> str:
    """Return what stands beside one of a law's rows: its name, a long one word by word down the rows."""
    words = [law] if len(law) <= _LONGEST_NAME else law.split("_")
    return "\n".join(words[row:]) if row == rows - 1 else "".join(words[row : row + 1])


def _percent(share: float | None) -> str:
    return "" if share is None else f"{100 * share:.1f}"


def _drift(gain: Mapping[str, float] | None) -> tuple[str, str, str]:
    if gain is None:
        return "", "", ""
    growth = round(gain["growth"], 4) + 0.0  # no -0.0000
    return _number(gain["largest"], 3), _number(gain["final"], 3), _number(growth, 4, "+")


def _table(title: str) -> Table:
    table = Table(
        title=title,
        title_justify="left",
        title_style="bold",
        header_style="bold dim",
        box=None,
        pad_edge=False,
        collapse_padding=True,
    )
    table.add_column("\nlaw")
    table.add_column("\nrobot")
    return table


def warnings(runs: Mapping[str, Any]) -> list[str]:
    """Return what a reader must know about the runs, one line each."""
    lines = []
    for controller, run in runs.items():
        if run["stopped"]:
            stop = run["stopped"]
            where = f", robot {stop['robot']}" if stop["robot"] else ""
            lines.append(f"{controller}: stopped at t = {stop['t']:.3f} s{where}: {stop['reason']}")
        for hit in run["collisions"]:
            lines.append(f"{controller}: {hit['robot']} is inside obstacle {hit['obstacle']} at t = {hit['t']:.2f} s")
        shares = {robot: share for robot, share in run["condition_violated"].items() if share > 0}
        if shares:
            shown = ", ".join(f"{robot} {100 * share:.1f} %" for robot, share in shares.items())
            lines.append(
                f"{controller}: λ2/λ3 <= 1/(|d + x_e| + 1), after Eq. (13), fails for part of the time: {shown}"
            )
    return lines
