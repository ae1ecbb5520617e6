"""Scenarios of the tests: those of the paper, short runs, and mistakes."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from dwmr import Known, find, measure, read, simulate
from fuzzyctl import DiagnosticError
from tests.shipped import rules_folder

PAPER = find("paper")
ROBOTS = ("leader", "follower1", "follower2")
#: A disturbance after which the run diverges at 1.005 s.
DIVERGES = ("disturbances.0.start=1", "disturbances.0.force=1e300")


def diagnostics(call, *arguments):
    """Return the diagnostics with which a call is refused."""
    with pytest.raises(DiagnosticError) as caught:
        call(*arguments)
    return caught.value.diagnostics


def mistakes(path, *overrides):
    """Return the diagnostics of a scenario with mistakes, a path or the name of a shipped one."""
    return diagnostics(read, find(str(path)), overrides)


def messages(path, *overrides):
    """Return the messages of a scenario with mistakes."""
    return [one.message for one in mistakes(path, *overrides)]


def warned(path, *overrides):
    """Return the messages of a scenario's warnings."""
    return [one.message for one in read(find(str(path)), overrides).warnings]


def run(path, law="", *overrides, folders=()):
    """Return the trajectory of a scenario, a path or the name of a shipped one."""
    return simulate(read(find(str(path)), overrides), law, folders)


#: Compiled code of the shipped rule files, whose guarantees other tests prove.
KNOWN = Known(proved=True)


@cache
def shared(name, law, *overrides):
    """Return file and trajectory of a shipped scenario; equal calls share one run."""
    file = read(find(name), overrides)
    return file, simulate(file, law, known=KNOWN)


@cache
def measured(name, law, *overrides):
    """Return the measures of a shipped scenario; equal calls share one run."""
    file, trajectory = shared(name, law, *overrides)
    return measure(trajectory, file.scenario)


def by_hand(law="smc", samples=3, stop=None, **columns):
    """Return samples of the paper's robots, zero but for the columns given.

    Columns that the loop does not record are signals of the law.
    """
    _, run = shared("paper-with-limits", "smc", "run.horizon=0.01")
    recorded = run.names[: run.values.shape[2]]
    own = tuple(name for name in columns if name not in recorded)
    values, law_values = np.zeros((samples, 3, len(recorded))), np.zeros((samples, 3, len(own)))
    values[:, :, recorded.index("obstacle")] = -1
    for name, column in columns.items():
        (law_values[:, :, own.index(name)] if name in own else values[:, :, recorded.index(name)])[...] = column
    signals = tuple(run.law_signals[0]._replace(name=name, unit="", doc="") for name in own)
    return dataclasses.replace(
        run, controller=law, t=0.005 * np.arange(samples), values=values, law_values=law_values, law_signals=signals,
        stop=stop,
    )  # fmt: skip


def changed(run, **columns):
    """Return a run with other values in some columns; a column may be a function of the old one."""
    values, law_values = run.values.copy(), run.law_values.copy()
    every = [values[:, :, k] for k in range(values.shape[2])] + [
        law_values[:, :, k] for k in range(law_values.shape[2])
    ]
    for name, column in columns.items():
        old = every[run.names.index(name)]
        old[...] = column(old) if callable(column) else column
    return dataclasses.replace(run, values=values, law_values=law_values)


def in_frame(points, robot, x, y, theta):
    """Return points, shape (n, 2), in the frame of a robot's wheel axis; its reference point is at x, y."""
    ahead, left = (np.array([np.cos(turn), np.sin(turn)]) for turn in (theta, theta + 0.5 * np.pi))
    return (points - (np.array([x, y]) - robot.d * ahead)) @ np.stack([ahead, left], axis=1)


def edited_rules(folder, name, *replacements):
    """Write a shipped rule file with some text replaced into a folder; return the folder."""
    return edited(rules_folder() / name, folder / name, *replacements).parent


def edited(source, target, *replacements):
    """Write a file with some text replaced, once each; return the new file."""
    text = source.read_text(encoding="utf-8")
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new, 1)
    target.write_text(text, encoding="utf-8")
    return target
