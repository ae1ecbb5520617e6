"""Report of a run on the terminal: tables with the paper's values for comparison, and warnings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from dwmr.results.paper_tables import MEASURES, TABLES, near, ratios
from dwmr.scenario.model import FAST, SETTLING
from fuzzyctl.diagnostics.terminal import printable

if TYPE_CHECKING:
    from dwmr.results.identification import Identified

_COLUMNS = (("x_e", "m"), ("y_e", "m"), ("theta_e", "rad"))
_SYMBOLS = {"x_e": "x_e", "y_e": "y_e", "theta_e": "θ_e"}
_BY_UNIT = (("x_e", "y_e"), ("theta_e",))

#: Legends of the tables.
_ERRORS = "x_e, y_e: of a robot on the reference along x and y, of a follower along and across it."
_RATIO = " θ_e: not wrapped, as in the paper. ratio: ours / paper's."
_SAFETY = (
    "centre: least distance of the reference point from an obstacle's centre. gap: least distance of the body from an "
    "obstacle and from another robot's body, negative where they overlap. hit: how many it touched. switches: how "
    "often an avoidance begins or ends. arrives: time from which on it stays within run.arrival of its place, no if it "
    "is farther away at the end."
)
ABOUT_FILTER = (
    "disc gap: least distance of the disc about the robot. changed: share of time in which the filter changed its "
    "commands. infeasible: moments at which no command kept a barrier; missed: others at which it was not kept."
)
_EFFORT = (
    "|dv_c|, |dω_c|: mean change of the commands in a second, the chattering; outside: more than "
    f"{SETTLING:g} s away from all avoidances. limit: share of time at the largest "
    "velocity, turning rate, torque. took: computing time of the loop."
)
_STABILITY = (
    "% of: share of time with dV/dt > 0, by Eqs. (14) and (26). k_h: adaptive gain, its largest value, the last one, "
    "and its growth per second in the last quarter."
)
_LOG = "Taken at the stamps of each log, up to the end of the run. distance: of the places. θ: wrapped."

#: Heads of the tables.
_LOG_HEADS = ("x\nm", "y\nm", "distance\nm", "θ\nrad", "v\nm/s", "ω\nrad/s", "\nsamples")
_SAFETY_HEADS = (
    "centre\nm",
    "obstacle\ngap m",
    "robot\ngap m",
    "obstacles\nhit",
    "robots\nhit",
    "avoids\ns",
    "\nswitches",
    "arrives\ns",
)
_FILTER_HEADS = ("disc\ngap m", "changed\n%", "infeasible\nmoments", "missed\nmoments")
_EFFORT_HEADS = (
    "|dv_c|\nm/s²",
    "\noutside",
    "|dω_c|\nrad/s²",
    "\noutside",
    "% at limit of\nv    ω    τ",
    "least\nG_AIS",
    "took\ns",
)
_STABILITY_HEADS = (
    "% of\n(14)", "% of\n(26)", *(h for c in "vω" for h in (f"k_h,{c}\nlargest", "\nfinal", "\ngrowth")),
)  # fmt: skip

#: Origin of the numbers of the paper's tables.
_PAPERS = {
    12: " Table 12: the paper's simulation; what the paper does not print of it is fitted here to this table.",
    13: " Table 13: AIFQSMC in Gazebo, whose robots have bodies and sensors; here they are what the scenario says.",
}

#: Residuals of an identification beyond this multiple of the noise are reported; correlated noise reaches 2 to 4 [-].
_LARGEST_EXCESS = 5.0
#: An adaptive gain that exceeds its floor by this factor is reported [-].
WOUND_UP = 10.0

#: Moments of one kind at which a barrier was not kept that are printed.
MOST_BARRIERS = 5

#: Least width of the tables; text for a pipe or a file is not squeezed further.
_WIDTH = 80
#: A longer name of a law would squeeze the numbers beside it.
_LONGEST_NAME = 10


def console() -> Console:
    """Return a console on standard output that is never too narrow for the tables."""
    terminal = Console()
    return terminal if terminal.width >= _WIDTH else Console(width=_WIDTH)


def print_report(
    out: Console, summary: Mapping[str, Any], printed: int | None, why_not: str = "", picture: str = ""
) -> None:
    """Print tracking errors, safety, effort, stability, warnings and one sentence of every control law.

    Args:
        out: Where to.
        summary: Content of summary.json.
        printed: Number of the paper's table to show beside the errors, None for none.
        why_not: Why it is not shown, where a reader may expect it.
        picture: File that the sentence points to.
    """
    runs = summary["controllers"]
    for one in run_tables(runs, printed):
        out.print(one.title, style="bold", highlight=False)  # rich would make the title as narrow as the table
        out.print(table_by_law(one.heads, one.rows))
        out.print(one.about, style="dim", highlight=False)
        out.print()
    for line in ([why_not] if why_not else []) + warnings(runs):
        out.print("[yellow]warning:[/] ", escape(printable(line)), sep="", highlight=False)
    for line in sentences(runs, printed, picture):
        out.print(escape(printable(line)), style="bold", highlight=False)


class RunTable(NamedTuple):
    """Table of measures, with a row for each law and robot.

    Attributes:
        title: Its subject.
        heads: Of the columns of numbers, in two lines.
        rows: Cells by law and robot.
        about: Legend of the columns.
    """

    title: str
    heads: Sequence[str]
    rows: Mapping[str, Mapping[str, Sequence[str]]]
    about: str


def run_tables(runs: Mapping[str, Any], printed: int | None) -> Iterator[RunTable]:
    """Yield the tables of a report: tracking errors, safety, effort and stability.

    Args:
        runs: Measures by control law.
        printed: Number of the paper's table beside the errors, None for none.
    """
    yield error_table(runs, "rmse", "Root mean square errors", printed)
    if any("log" in run for run in runs.values()):
        yield RunTable("Root mean square differences from the log", _LOG_HEADS, _rows(runs, _log), _LOG)
    yield RunTable("Safety", _SAFETY_HEADS, _rows(runs, _safety), _SAFETY)
    if any("safety" in run for run in runs.values()):
        cells = _rows(runs, lambda _, run, robot: filter_cells(run, robot))
        yield RunTable("Safety filter", _FILTER_HEADS, cells, ABOUT_FILTER)
    yield RunTable("Effort", _EFFORT_HEADS, _rows(runs, _effort), _EFFORT)
    if any(run.get("lyapunov") for run in runs.values()):
        yield RunTable("Stability", _STABILITY_HEADS, _rows(runs, _stability), _STABILITY)


def error_table(runs: Mapping[str, Any], section: str, title: str, printed: int | None) -> RunTable:
    """Return the table of tracking errors in a section of the summary, beside a table of the paper or None."""
    heads = []
    for name, unit in _COLUMNS:
        heads += [f"{_SYMBOLS[name]}\n{unit}", *([f"Table\n{printed}", "\nratio"] if printed is not None else [])]

    def cells(law: str, run: Mapping[str, Any], robot: str) -> list[str]:
        values, wanted = run[section][robot], _printed_errors(law, run, printed).get(robot, {})
        pairs = [(values[_measured(name, printed)], wanted.get(name)) for name, _ in _COLUMNS]
        return [cell for value, one in pairs for cell in _cells(value, one, printed is not None)]

    if printed is None:
        return RunTable(title, heads, _rows(runs, cells), _ERRORS if section == "rmse" else "")
    about = _ERRORS + _RATIO + _PAPERS[printed]
    return RunTable(f"{title} beside Table {printed} of the paper", heads, _rows(runs, cells), about)


def sentences(runs: Mapping[str, Any], printed: int | None, picture: str = "") -> list[str]:
    """Return one sentence of each run, and of all that are in a table of the paper.

    Args:
        runs: Measures by control law.
        printed: Number of the paper's table beside the errors, None for none.
        picture: File to point to.
    """
    lines = [sentence(law, run, printed, picture) for law, run in runs.items()]
    by_law = {law: values for law, run in runs.items() if (values := _ratios(law, run, printed))}
    if printed is not None and len(by_law) > 1:
        lines.append(f"{', '.join(by_law)}: {near([one for values in by_law.values() for one in values], printed)}")
    return lines


def sentence(law: str, run: Mapping[str, Any], printed: int | None, picture: str = "") -> str:
    """Return what became of a run in one sentence: how it ended, its errors, collisions and arrivals.

    Args:
        law: Name of the control law.
        run: Its measures.
        printed: Number of the paper's table beside the errors, None for none.
        picture: File to point to.
    """
    parts = [_largest_errors(law, run, printed), _collisions(run), _arrivals(run)]
    if run["stopped"]:
        parts.insert(0, f"stopped at t = {run['stopped']['t']:.3f} s")
    return f"{law}: {', '.join(parts)}" + (f"; see {picture}" if picture else "")


def _largest_errors(law: str, run: Mapping[str, Any], printed: int | None) -> str:
    if printed is not None and (values := _ratios(law, run, printed)):
        return near(values, printed)
    far, turned = (max(row[name] for row in run["rmse"].values() for name in names) for names in _BY_UNIT)
    return f"root mean square errors up to {_number(far, 3)} m and {_number(turned, 3)} rad"


def _ratios(law: str, run: Mapping[str, Any], printed: int | None) -> list[float]:
    """Return the ratios of a run's errors to a table of the paper; a run that ended early has none."""
    return [] if printed is None or run["stopped"] else [*ratios(law, run["rmse"], printed).values()]


def _collisions(run: Mapping[str, Any]) -> str:
    counts = [(run["obstacles_hit"], "with obstacles"), (run["robots_hit"], "between robots")]
    parts = [f"{len(hits)} {where}" for hits, where in counts if hits]
    if parts:
        return f"collisions: {' and '.join(parts)}"
    gaps = [run[kind][robot] for kind in ("obstacle_gap", "robot_gap") for robot in run["rmse"]]
    least = min((gap for gap in gaps if gap is not None), default=None)
    return "no collision" + ("" if least is None else f" (least gap {_number(least, 2)} m)")


def _arrivals(run: Mapping[str, Any]) -> str:
    reached = [one["reached"] for one in run["arrival"].values()]
    return "all arrive" if all(reached) else f"{sum(reached)} of {len(reached)} arrive"


def _printed_errors(law: str, run: Mapping[str, Any], printed: int | None) -> Mapping[str, Mapping[str, float]]:
    """Return the errors of a table of the paper by robot; those of a run that ended early have no counterpart."""
    return TABLES[printed].get(law, {}) if printed is not None and run["stopped"] is None else {}


def _measured(name: str, printed: int | None) -> str:
    """Return the measure in the column of an error: beside a table of the paper angles are not wrapped."""
    return name if printed is None else MEASURES[name]


def _cells(value: float, printed: float | None, compare: bool) -> list[str]:
    number = _number(value, 4)
    if not compare:
        return [number]
    return [number, "" if printed is None else f"{printed:.4f}", "" if printed is None else f"{value / printed:.2f}"]


def _number(value: float, digits: int, sign: str = "") -> str:
    """Return a number with some digits behind the point, a large one by its power of ten."""
    return f"{value:{sign}.{digits}f}" if abs(value) < 1e6 else f"{value:{sign}.3e}"


def _log(law: str, run: Mapping[str, Any], robot: str) -> list[str]:
    row = run["log"].get(robot, {})
    names = ("x", "y", "distance", "theta", "v", "omega")
    return [*("" if row.get(name) is None else _number(row[name], 4) for name in names), str(row.get("samples", ""))]


def print_identified(out: Console, identified: Mapping[str, Identified]) -> None:
    """Print a table of estimates for each robot, and how well they fit the log."""
    for robot, one in identified.items():
        table = Table(header_style="bold dim", box=None, pad_edge=False, collapse_padding=True)
        for head in ("parameter", "value", "low", "high", "scenario", "unit"):
            table.add_column(head, justify="left" if head in ("parameter", "unit") else "right")
        for row in one.estimates:
            numbers = (
                "none" if n is None else f"{round(n, 9) + 0.0:.4g}" for n in (row.value, row.low, row.high, row.before)
            )
            value, low, high, before = numbers
            cells = ("held" if row.low is None else value, "", "", value) if row.why else (value, low, high, before)
            table.add_row(row.key, *cells, row.unit)
        out.print(escape(printable(robot)), style="bold", highlight=False)
        out.print(table)
        v, omega, old_v, old_omega = (_number(number, 4) for number in (*one.residuals, *one.before))
        out.print(
            f"{one.samples} samples; residuals: v {v} m/s, ω {omega} rad/s (root mean square; with the values of the "
            f"scenario {old_v} m/s, {old_omega} rad/s). One sample correlates with the next by {one.correlation:.2f}, "
            f"which widens the intervals {math.sqrt((1.0 + one.correlation) / (1.0 - one.correlation)):.2f} times.",
            style="dim", highlight=False,
        )  # fmt: skip
        if one.excess > _LARGEST_EXCESS:
            text = f"a residual is {one.excess:.1f} times the noise of the log: robot and plant differ in ways that "
            out.print("[yellow]warning:[/] ", text, "the intervals do not include", sep="", highlight=False)
        for row in one.estimates:
            if row.why:
                out.print(f"{row.key} is not determined: {row.why}", highlight=False)
        out.print()


def _safety(law: str, run: Mapping[str, Any], robot: str) -> list[str]:
    distances = [run[kind][robot] for kind in ("centre_distance", "obstacle_gap", "robot_gap")]
    gaps = ["" if one is None else _number(one, 2) for one in distances]
    switches = str(run["avoidance_switches"][robot]["all"])
    avoids = f"{run['avoidance_s'][robot]:.1f}"
    return [*gaps, *map(str, _hits(run, robot)), avoids, switches, _arrives(run, robot)]


def _arrives(run: Mapping[str, Any], robot: str) -> str:
    """Return the time at which a robot arrives [s], or no."""
    t = run["arrival"][robot]["t"]
    return "no" if t is None else f"{t:.1f}"


def _hits(run: Mapping[str, Any], robot: str) -> tuple[int, int]:
    """Return how many obstacles and how many other robots the body of a robot touched."""
    obstacles = sum(hit["robot"] == robot for hit in run["obstacles_hit"])
    return obstacles, sum(robot in hit["robots"] for hit in run["robots_hit"])


def filter_cells(run: Mapping[str, Any], robot: str) -> list[str]:
    """Return the effects of the safety filter on a robot: least distance of its disc, share of time, moments."""
    measures = run["safety"]
    gap = measures["disc_gap"][robot]
    moments = [sum(robot in (one["robot"], one["with"]) for one in measures[kind]) for kind in ("infeasible", "missed")]
    return ["" if gap is None else _number(gap, 2), f"{100.0 * measures['acts'][robot]:.1f}", *map(str, moments)]


def _chattering(run: Mapping[str, Any], robot: str) -> list[str]:
    """Return the chattering of the linear and the angular velocity, each in the whole run and outside of avoidances."""
    levels = (run["chattering"][robot], run["chattering_outside"][robot])
    return ["" if level is None else _number(level[channel], 3) for channel in ("v", "omega") for level in levels]


def _effort(law: str, run: Mapping[str, Any], robot: str) -> list[str]:
    is_first, limits, g_ais = robot == next(iter(run["rmse"])), run["saturation"][robot], run.get("g_ais_min")
    return [
        *_chattering(run, robot),
        " ".join(f"{100 * limits[name]:4.1f}" for name in ("v", "omega", "torque")),
        f"{g_ais:.4f}" if is_first and g_ais is not None else "",
        f"{run['wall_s']:.3f}" if is_first and "wall_s" in run else "",
    ]


def _stability(law: str, run: Mapping[str, Any], robot: str) -> list[str]:
    """Return the shares of Lyapunov functions and the drift of adaptive gains; empty cells for a law without them."""
    shares, drifts = run.get("lyapunov", {}).get(robot, {}), run.get("drift", {}).get(robot, {})
    percents = [_percent(shares.get(f"V_dot_{number}_positive")) for number in (10, 23)]
    return [*percents, *(cell for name in ("k_h_v", "k_h_omega") for cell in _drift(drifts.get(name)))]


def _name(law: str, row: int, rows: int) -> str:
    """Return the name of a law in one of its rows, a long one word by word down the rows."""
    words = [law] if len(law) <= _LONGEST_NAME else law.split("_")
    return "\n".join(words[row:]) if row == rows - 1 else "".join(words[row : row + 1])


def _percent(share: float | None) -> str:
    return "" if share is None else f"{100 * share:.1f}"


def _drift(gain: Mapping[str, float] | None) -> tuple[str, str, str]:
    if gain is None:
        return "", "", ""
    growth = round(gain["growth"], 4) + 0.0  # no -0.0000
    return _number(gain["largest"], 3), _number(gain["final"], 3), _number(growth, 4, "+")


def _rows(
    runs: Mapping[str, Any], cells: Callable[[str, Mapping[str, Any], str], Sequence[str]]
) -> dict[str, dict[str, Sequence[str]]]:
    """Return the rows of a table; `cells` returns those of a law, its run and a robot."""
    return {law: {robot: cells(law, run, robot) for robot in run["rmse"]} for law, run in runs.items()}


def table_by_law(heads: Iterable[str], rows: Mapping[str, Mapping[str, Sequence[str]]], second: str = "robot") -> Table:
    """Return a table with a row for each law and robot.

    Args:
        heads: Heads of the columns of numbers.
        rows: Cells by law and robot.
        second: Head of the second column.
    """
    table = Table(header_style="bold dim", box=None, pad_edge=False, collapse_padding=True)
    table.add_column("\nlaw")
    table.add_column(f"\n{second}")
    for head in heads:
        table.add_column(head, justify="right", style="dim" if head.startswith("Table\n") else None)
    for law, by_robot in rows.items():
        for k, (robot, cells) in enumerate(by_robot.items()):
            table.add_row(escape(_name(law, k, len(by_robot))), escape(robot), *cells)
    return table


def warnings(runs: Mapping[str, Any]) -> list[str]:
    """Return warnings about the runs, one line each."""
    lines = []
    for controller, run in runs.items():
        if run["stopped"]:
            stop = run["stopped"]
            where = f", robot {stop['robot']}" if stop["robot"] else ""
            lines.append(f"{controller}: stopped at t = {stop['t']:.3f} s{where}: {stop['reason']}")
        lines += [f"{controller}: {line}" for line in (*contacts(run), *barriers(run), *switching(run), *wound_up(run))]
        shares = {robot: share for robot, share in run["condition_violated"].items() if share > 0}
        if shares:
            robots = ", ".join(f"{robot} {100 * share:.1f} %" for robot, share in shares.items())
            lines.append(
                f"{controller}: λ2/λ3 <= 1/(|d + x_e| + 1), after Eq. (13), fails for part of the time: {robots}"
            )
    return lines


def contacts(run: Mapping[str, Any]) -> list[str]:
    """Return which bodies touched, one line each; an obstacle is named by its key, as `--set` takes it."""
    met = [(f"{hit['robot']} hits obstacles.{hit['obstacle']}", hit) for hit in run["obstacles_hit"]]
    met += [(f"{' and '.join(hit['robots'])} hit each other", hit) for hit in run["robots_hit"]]
    return [
        f"{what} at t = {hit['t']:.2f} s; in contact for {hit['lasted']:.2f} s, overlap {hit['depth']:.2f} m at most"
        for what, hit in met
    ]


def switching(run: Mapping[str, Any]) -> list[str]:
    """Return whose avoidance switches on and off from one control period to the next, so that a shorter one adds more.

    One run shows it: motions of a robot take longer than some periods.
    """
    return [
        f"the avoidance of {robot} switches {switches['all']} times, {switches['fast']} of them within {FAST} control "
        "periods: more often with a shorter run.dt; set avoidance.hysteresis against it"
        for robot, switches in run["avoidance_switches"].items()
        if switches["fast"]
    ]


def wound_up(run: Mapping[str, Any]) -> list[str]:
    """Return which adaptive gains left their floors by more than `WOUND_UP`, one line each."""
    return [
        f"{robot}'s {name} rises to {_number(gain['largest'], 3)}, {gain['largest'] / gain['start']:.0f} times its "
        "floor: robot.conditional_adaptation = true keeps it while its command is changed"
        for robot, gains in run.get("drift", {}).items()
        for name, gain in gains.items()
        if gain["start"] > 0.0 and gain["largest"] > WOUND_UP * gain["start"]
    ]


def barriers(run: Mapping[str, Any]) -> list[str]:
    """Return when the safety filter could not keep a barrier and when the robots missed one, first ones first."""
    lines = []
    for kind, words in (
        ("infeasible", "no command within the limits keeps {0} away from {1}"),
        ("missed", "{0} comes nearer to {1} than its command allows"),
    ):
        moments = run.get("safety", {}).get(kind, [])
        for one in moments[:MOST_BARRIERS]:
            lines.append(
                f"{words.format(one['robot'], one['with'])} at t = {one['t']:.2f} s, ({one['x']:.2f}, {one['y']:.2f}) "
                f"m, for {one['lasted']:.2f} s, {one['by']:.2g} m/s at most"
            )
        if len(moments) > MOST_BARRIERS:
            lines.append(f"{len(moments) - MOST_BARRIERS} more such moments are under safety.{kind} of summary.json")
    return lines
