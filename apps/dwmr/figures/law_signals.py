"""Figures of the signals of control laws: sliding surfaces, boundary layers, gains."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from dwmr.core.arrays import FloatArray
from dwmr.figures import panels
from dwmr.results import derived, lyapunov
from dwmr.results.decimation import thin
from dwmr.scenario.model import Scenario
from dwmr.simulation.simulate import Trajectory

#: Symbol and unit of σ in the two channels.
SIGMA = {"v": ("v", "m"), "omega": (r"\omega", "rad")}


def sliding(trajectory: Trajectory, scenario: Scenario) -> Figure:
    """Draw σ and σ* of both channels."""
    return _grid(trajectory, scenario, _both(trajectory, scenario), "", "")


def sliding_rates(trajectory: Trajectory, scenario: Scenario) -> Figure:
    """Draw the backward differences of σ and σ* of both channels."""
    rates = {key: derived.rate(signal, scenario.run.dt) for key, signal in _both(trajectory, scenario).items()}
    return _grid(trajectory, scenario, rates, r"\dot", "/s")


def _both(trajectory: Trajectory, scenario: Scenario) -> dict[tuple[str, str], FloatArray]:
    """Return σ and σ* by star and channel."""
    plain = lyapunov.signals(trajectory, scenario)
    stars = {("*", c): trajectory[f"sigma_{c}"] for c in derived.CHANNELS}
    return {("", c): plain[f"surface_{c}"] for c in derived.CHANNELS} | stars


def _grid(
    trajectory: Trajectory, scenario: Scenario, signals: Mapping[tuple[str, str], FloatArray], dot: str, per: str
) -> Figure:
    figure, rows = panels.grid(2, 2, height=2.6)
    for row, star in zip(rows, ("", "*"), strict=True):
        for axes, channel in zip(row, derived.CHANNELS, strict=True):
            symbol, unit = SIGMA[channel]
            label = rf"${dot}{{\sigma}}_{{{symbol}}}{'^*' if star else ''}$ [{unit}{per}]"
            panels.lines(axes, trajectory.t, signals[star, channel], trajectory.robots, label)
            panels.cut_peaks(axes, signals[star, channel])
    panels.mark(rows, trajectory, scenario)
    panels.legend(figure, rows[0, 0])
    return figure


def layers(trajectory: Trajectory, scenario: Scenario) -> Figure:
    """Draw σ* within its boundary layer ±β, one row per robot, zoomed to the layer."""
    figure, rows = panels.grid(len(trajectory.robots), 2, height=2.0)
    for i, robot in enumerate(trajectory.robots):
        for axes, channel in zip(rows[i], derived.CHANNELS, strict=True):
            symbol, unit = SIGMA[channel]
            sigma, beta = trajectory[f"sigma_{channel}"][:, i], trajectory[f"beta_{channel}"][:, i]
            names = [r"$\sigma^*$", r"boundary layer $\pm\beta$"]
            panels.lines(
                axes, trajectory.t, np.stack([sigma, beta], axis=1), names, rf"$\sigma_{{{symbol}}}^*$ [{unit}]"
            )
            axes.plot(*thin(trajectory.t, -beta, panels.BUCKETS), lw=1.0, **panels.colour(1))
            layers = trajectory[f"beta_{channel}"]
            reach = 1.8 * float(layers[np.isfinite(layers)].max())
            axes.set(ylim=(-reach, reach), title=robot)
    panels.mark(rows, trajectory, scenario)
    panels.legend(figure, rows[0, 0])
    return figure


def adaptive_gains(trajectory: Trajectory, scenario: Scenario) -> Figure:
    """Draw k̂_h and η̂ of both channels."""
    figure, rows = panels.grid(2, 2, height=2.6)
    for column, (channel, unit) in enumerate(zip(derived.CHANNELS, ("m/s", "rad/s"), strict=True)):
        symbol = SIGMA[channel][0]
        label = rf"$\hat{{k}}_{{h,{symbol}}}$ [{unit}]"
        panels.lines(rows[0, column], trajectory.t, trajectory[f"k_h_{channel}"], trajectory.robots, label)
        label = rf"$\hat{{\eta}}_{{{symbol}}}$ [-]"
        panels.lines(rows[1, column], trajectory.t, trajectory[f"eta_{channel}"], trajectory.robots, label)
    panels.mark(rows, trajectory, scenario)
    panels.legend(figure, rows[0, 0])
    return figure


def immune_gains(trajectory: Trajectory, scenario: Scenario) -> Figure:
    """Draw f(σ*, dσ*/dt) and G_AIS of both channels."""
    figure, rows = panels.grid(2, 2, height=2.6)
    for column, (channel, unit) in enumerate(zip(derived.CHANNELS, ("m/s", "rad/s"), strict=True)):
        symbol = SIGMA[channel][0]
        panels.lines(
            rows[0, column], trajectory.t, trajectory[f"f_{channel}"], trajectory.robots, rf"$f_{{{symbol}}}$ [-]"
        )
        label = rf"$\hat{{G}}_{{AIS,{symbol}}}$ [{unit}]"
        panels.lines(rows[1, column], trajectory.t, trajectory[f"g_ais_{channel}"], trajectory.robots, label)
    panels.mark(rows, trajectory, scenario)
    panels.legend(figure, rows[0, 0])
    return figure
