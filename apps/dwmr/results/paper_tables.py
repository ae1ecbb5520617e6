"""Tables 12 and 13 of the paper, and the differences of a scenario from the runs behind them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from dwmr.scenario.file import find, read
from dwmr.scenario.model import Robot, Scenario

#: Duration of the runs behind Table 12 [s] (section 7); errors of a shorter run have no counterpart there.
TABLE_12_HORIZON = 200.0

#: Goto, Bertol, Martins, Table 12: RMSE of x_e [m], y_e [m], theta_e [rad] with disturbances and obstacles.
TABLE_12: dict[str, dict[str, dict[str, float]]] = {
    controller: {
        robot: dict(zip(("x_e", "y_e", "theta_e"), row, strict=True))
        for robot, row in zip(("leader", "follower1", "follower2"), rows, strict=True)
    }
    for controller, rows in {
        "smc": ((3.2309, 3.4591, 4.0197), (0.8302, 2.3546, 0.4170), (0.7973, 1.9537, 0.4404)),
        "aifqsmc": ((0.5399, 0.6988, 0.2327), (0.1298, 0.1340, 0.0318), (0.1008, 0.1114, 0.0206)),
        "fcafsmc": ((0.4519, 0.5694, 0.2546), (0.1806, 0.1883, 0.0528), (0.1456, 0.1693, 0.0427)),
    }.items()
}


#: The same, Table 13: AIFQSMC in Gazebo, to which no disturbance was added.
TABLE_13: dict[str, dict[str, dict[str, float]]] = {
    "aifqsmc": {
        "leader": {"x_e": 0.4604, "y_e": 0.5881, "theta_e": 0.2205},
        "follower1": {"x_e": 0.1532, "y_e": 0.2428, "theta_e": 0.1987},
        "follower2": {"x_e": 0.0999, "y_e": 0.1560, "theta_e": 0.0349},
    }
}

TABLES = {12: TABLE_12, 13: TABLE_13}

#: Errors of the tables as measures of a run. Angles are not wrapped: the 4.02 rad of SMC's leader are more than π.
MEASURES = {"x_e": "x_e", "y_e": "y_e", "theta_e": "theta_e_unwrapped"}
#: Differences from a table within which errors are counted.
BARS = (0.10, 0.12)


def ratios(law: str, rmse: Mapping[str, Mapping[str, float]], number: int) -> dict[tuple[str, str], float]:
    """Return the errors of a run over those of a table of the paper by robot and error.

    Args:
        law: Its control law.
        rmse: Root mean square errors by robot, as `summary.json` has them.
        number: Of the table.
    """
    return {
        (robot, name): rmse[robot][MEASURES[name]] / wanted
        for robot, row in TABLES[number].get(law, {}).items()
        if robot in rmse
        for name, wanted in row.items()
    }


def near(values: Sequence[float], number: int) -> str:
    """Return how many of some ratios to a table are near 1, and their least and greatest."""
    first, second = (sum(abs(one - 1.0) <= bar for one in values) for bar in BARS)
    within = f"{first} of {len(values)} errors within {100 * BARS[0]:.0f} % of Table {number}"
    return f"{within}, {second} within {100 * BARS[1]:.0f} %, ratios {min(values):.2f} to {max(values):.2f}"


#: Keys of a robot that its errors do not depend on, or by design may differ: the measures' outline, the gains.
_FREE = ("body", "controllers")
#: Numbers of the paper's tables by the shipped scenario of their runs.
_TABLES = {
    "paper": 12,
    "paper-with-limits": 12,
    "paper-constant-gain": 12,
    "paper-ideal-loop": 12,
    "paper-lost-turn": 12,
    "undisturbed": 13,
    "experiment": 13,
}
#: The shipped scenario that is the run of a table.
_SHIPPED = {12: "paper", 13: "experiment"}
#: Keys that are listed before the rest is counted.
_MOST_SHOWN = 4


def differences(scenario: Scenario, shipped: str) -> tuple[str, ...]:
    """Return the keys in which a run is not the paper's, its gains and rule files aside.

    Args:
        scenario: The scenario.
        shipped: Name of the scenario that is the paper's run.
    """
    paper = read(find(shipped)).scenario
    keys = [
        key
        for key in ("reference", "formation", "communication", "obstacles", "avoidance", "load", "disturbances")
        if getattr(scenario, key) != getattr(paper, key)
    ]
    keys += [f"run.{key}" for key in ("horizon", "plant") if getattr(scenario.run, key) != getattr(paper.run, key)]
    return (*keys, *_robots(scenario, paper))


def beside(scenario: Scenario, wanted: int | None = None) -> tuple[int | None, str]:
    """Return the number of the paper's table that errors are shown beside, and a remark on differences.

    Args:
        scenario: The scenario.
        wanted: Number of a table that is shown whatever differs, None for that of an unchanged run of the paper.
    """
    if wanted is not None:
        keys = differences(scenario, _SHIPPED[wanted])
        return wanted, f"Table {wanted} speaks of another run: {as_text(keys)}" if keys else ""
    number = _TABLES.get(scenario.name)
    if number is None or scenario.run.horizon < TABLE_12_HORIZON:
        return None, ""
    keys = differences(scenario, scenario.name)
    return (None, f"Table {number} is left out, it speaks of another run: {as_text(keys)}") if keys else (number, "")


def as_text(keys: tuple[str, ...]) -> str:
    """Return that some keys are not the paper's."""
    text = ", ".join(keys[:_MOST_SHOWN])
    more = f" and {len(keys) - _MOST_SHOWN} more" if len(keys) > _MOST_SHOWN else ""
    verb = "is" if len(keys) == 1 and keys[0] not in ("obstacles", "disturbances") else "are"
    return f"{text}{more} {verb} not the paper's"


def _robots(scenario: Scenario, paper: Scenario) -> Iterable[str]:
    """Give the keys of the paper's robots that differ, and the names of robots that it has not."""
    keys = tuple(k for k in Robot.model_fields if k not in _FREE)
    for name in dict.fromkeys((*paper.robots, *scenario.robots)):
        if name not in paper.robots or name not in scenario.robots:
            yield f"robots.{name}"
            continue
        mine, theirs = scenario.robots[name], paper.robots[name]
        yield from (f"robots.{name}.{key}" for key in keys if getattr(mine, key) != getattr(theirs, key))
