"""Catalogue of the paper's Figs. 8 to 39: control law, content and drawing function of each counterpart."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from dwmr.core.arrays import FloatArray
from dwmr.figures import motion, panels
from dwmr.figures.panels import thin
from dwmr.figures.style import STYLE, TITLES
from dwmr.results import derived, lyapunov
from dwmr.scenario.model import Scenario
from dwmr.simulation.simulate import Trajectory

#: Symbol and unit of σ in the two channels.
SIGMA = {"v": ("v", "m"), "omega": (r"\omega", "rad")}


def sliding(trajectory: Trajectory, scenario: Scenario) -> Figure:
    """Draw σ and σ* of both channels."""
    return _grid(trajectory, scenario, _both(trajectory, scenario), "", "")


def sliding_rates(trajectory: Trajectory, scenario: Scenario) -> Figure:
    """Draw the backward differences of σ and σ* of both channels."""
    rates = {key: derived.rate(signal, trajectory.step) for key, signal in _both(trajectory, scenario).items()}
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
    return panels.finished(figure, rows, trajectory, scenario, rows[0, 0])


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
    return panels.finished(figure, rows, trajectory, scenario, rows[0, 0])


def gains(trajectory: Trajectory, scenario: Scenario, chosen: Sequence[tuple[str, str, bool]]) -> Figure:
    """Draw gains of both channels, a row each: signal, symbol with a place for the channel's, whether it has a unit."""
    figure, rows = panels.grid(len(chosen), 2, height=2.6)
    for row, (signal, text, has_unit) in zip(rows, chosen, strict=True):
        for axes, channel, unit in zip(row, derived.CHANNELS, ("m/s", "rad/s"), strict=True):
            label = f"${text.replace('CHANNEL', SIGMA[channel][0])}$ [{unit if has_unit else '-'}]"
            panels.lines(axes, trajectory.t, trajectory[f"{signal}_{channel}"], trajectory.robots, label)
    return panels.finished(figure, rows, trajectory, scenario, rows[0, 0])


#: Rows of the figures of gains.
ADAPTIVE = (("k_h", r"\hat{k}_{h,CHANNEL}", True), ("eta", r"\hat{\eta}_{CHANNEL}", False))
IMMUNE = (("f", "f_{CHANNEL}", False), ("g_ais", r"\hat{G}_{AIS,CHANNEL}", True))


Draw = Callable[[Trajectory, Scenario], Figure]


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper and its counterpart.

    Attributes:
        number: Its number in the paper.
        law: Name of the control law it shows.
        title: Its subject, in a few words.
        about: Contents of the counterpart, quantities and units.
        draw: Draws it.
        needs: Requirements on the scenario: "obstacles", "followers", "avoidance".
        experiment: Whether it shows rigid bodies, as Figs. 29 to 39 do, and not the simulation.
    """

    number: int
    law: str
    title: str
    about: str
    draw: Draw
    needs: tuple[str, ...] = ()
    experiment: bool = False

    @property
    def subject(self) -> str:
        """The law whose run it shows, and whether that is the experiment."""
        return f"{TITLES[self.law]}, experiment" if self.experiment else TITLES[self.law]

    @property
    def caption(self) -> str:
        """Its number, law and subject."""
        return f"Fig. {self.number}, {self.subject}: {self.title}"

    def file(self, suffix: str) -> str:
        """Return the name of its file."""
        return f"fig{self.number:02d}.{suffix}"

    def obstacle_to(self, scenario: Scenario) -> str:
        """Return why a scenario has no such figure, or an empty text."""
        if self.experiment and scenario.run.plant != "mujoco":
            what = f"it shows rigid bodies, and run.plant is {scenario.run.plant!r}"
            return f"{what}; see figure {self.number - _LATER}"
        if all(self.law not in r.controllers for r in scenario.robots.values()):
            return f"the scenario has no gains for {self.law}"
        if "followers" in self.needs and not derived.followers(scenario):
            return "no robot follows another one"
        if "obstacles" in self.needs and not scenario.obstacles:
            return "the scenario has no obstacles"
        if "avoidance" in self.needs and not derived.avoiders(scenario):
            return "no robot avoids an obstacle"
        return ""


def _run(number: int, law: str) -> list[PaperFigure]:
    """Return the figures that exist for every law: path and chattering, velocity errors, formation."""
    return [
        PaperFigure(
            number,
            law,
            "Paths, formation, obstacles; chattering",
            "Left: the robots' reference points, start marked by a circle, their bodies at eleven moments, around the "
            "obstacles with their constant avoidance radius R̄_d. Right: the chattering measure |dv_c/dt| of both "
            "channels, the greatest value of every stretch of time, on a logarithmic axis [m/s², rad/s²].",
            motion.path_and_chattering,
        ),
        PaperFigure(
            number + 1 if law != "aifqsmc" else 18,
            law,
            "Velocity tracking errors and their compensation, first two robots",
            "v_e = v_c − v, with v the velocity over ground, and the sliding mode portion of the control law, which "
            "shall cancel it [m/s, rad/s].",
            motion.velocity_errors,
        ),
        PaperFigure(
            number + 2 if law != "aifqsmc" else 19,
            law,
            "Velocity tracking errors of the other robots; separation and bearing errors",
            "As the figure before, for the robots after the second; last, L_d − L [m] and Ψ_d − Ψ, unwrapped "
            "[rad], of followers.",
            motion.velocity_and_formation_errors,
            ("followers",),
        ),
    ]


def _sliding(number: int, law: str) -> list[PaperFigure]:
    return [
        PaperFigure(
            number,
            law,
            "Sliding surfaces σ and σ*",
            "Above σ of Eq. (7), below σ* of Eq. (9), in both channels [m, rad].",
            sliding,
        ),
        _rates(number + 1, law),
    ]


def _rates(number: int, law: str) -> PaperFigure:
    about = "Backward differences over one control period of σ, above, and σ*, below [m/s, rad/s]."
    return PaperFigure(number, law, "Rates of the sliding surfaces", about, sliding_rates)


def _avoidance(law: str) -> list[PaperFigure]:
    needs = ("obstacles", "avoidance")
    about = (
        "R_d, Eqs. (58) to (63), its constant part R̄_d, and the distance d_ia; the mode is on while d_ia <= R_d [m]."
    )
    return [
        PaperFigure(
            14,
            law,
            "Blending vectors; orientation of the reference",
            "Above: U_b, away from the obstacle, and U_f, around it, at half their length, and the direction of "
            "their sum U along the way around each obstacle. Below: θ_r of the original path and θ_r in force, which "
            "avoidance changes, unwrapped [rad].",
            motion.blending,
            needs,
        ),
        PaperFigure(
            15,
            law,
            "Variable radii of the first two obstacles",
            about,
            partial(motion.radii, chosen=slice(0, 2), distance=False),
            needs,
        ),
        PaperFigure(
            16,
            law,
            "Variable radii of the other obstacles; distances of the avoiding robot",
            f"{about} Last: the distance from every obstacle's centre, which shall stay above r_a + R_R, on a "
            "logarithmic axis [m].",
            partial(motion.radii, chosen=slice(2, None), distance=True),
            needs,
        ),
        PaperFigure(
            17,
            law,
            "Distances of the followers from the obstacles",
            "From every obstacle's centre, on a logarithmic axis; r_a + R_R is dotted [m]. Each title has the "
            "least gap between body and obstacle.",
            motion.follower_distances,
            ("obstacles", "followers"),
        ),
    ]


def _gains(law: str) -> list[PaperFigure]:
    return [
        PaperFigure(
            20,
            law,
            "σ* within its boundary layer",
            "σ* and ±β, zoomed to the layer; what leaves the panel is cut off [m, rad].",
            layers,
        ),
        _rates(21, law),
        PaperFigure(
            22,
            law,
            "Adaptive gains",
            "k̂_h [m/s, rad/s] and η̂ = k_s / k̂_h [-] in both channels.",
            partial(gains, chosen=ADAPTIVE),
        ),
        PaperFigure(
            23,
            law,
            "Immune reaction and switching gain",
            "f(σ*, dσ*/dt) [-] and G_AIS = k̂_h − k_s f [m/s, rad/s] in both channels.",
            partial(gains, chosen=IMMUNE),
        ),
    ]


_SIMULATION = [
    *_run(8, "smc"),
    *_sliding(11, "smc"),
    *_run(13, "aifqsmc"),
    *_avoidance("aifqsmc"),
    *_gains("aifqsmc"),
    *_run(24, "fcafsmc"),
    *_sliding(27, "fcafsmc"),
]
#: Figs. 29 to 39 of the experiment show what Figs. 13 to 23 show of the simulation, one for one.
_LATER = 16
_EXPERIMENT = [replace(f, number=f.number + _LATER, experiment=True) for f in _SIMULATION if 13 <= f.number <= 23]
FIGURES = tuple(sorted([*_SIMULATION, *_EXPERIMENT], key=lambda figure: figure.number))


def usual(scenario: Scenario) -> list[PaperFigure]:
    """Return the figures of a scenario: those of the paper's experiment for rigid bodies, else of its simulation."""
    return [figure for figure in FIGURES if figure.experiment == (scenario.run.plant == "mujoco")]


def numbers(text: str) -> tuple[int, ...]:
    """Return the numbers of figures in a list such as "8,12" or "13-23".

    Raises:
        ValueError: When it is not such a list, or names a figure that has no counterpart.
    """
    drawn = [figure.number for figure in FIGURES]
    chosen: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.strip().isdecimal() or (dash and not last.strip().isdecimal()):
            raise ValueError(f"{part.strip()!r} is not the number of a figure; write such as 8,12 or 13-23")
        low, high = int(first), int(last) if dash else int(first)
        if low > high or low < drawn[0] or high > drawn[-1]:
            raise ValueError(f"only figures {drawn[0]} to {drawn[-1]} have counterparts")
        chosen.update(range(low, high + 1))
    return tuple(sorted(chosen))


def draw(figure: PaperFigure, path: Path, trajectory: Trajectory, scenario: Scenario) -> None:
    """Draw the counterpart of a figure into a file, the same bytes every time.

    Args:
        figure: Which.
        path: File to write: PNG, PDF or SVG by its suffix.
        trajectory: A run under the figure's control law.
        scenario: Its scenario.
    """
    undated = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    with mpl.rc_context({**STYLE, "svg.hashsalt": "dwmr"}):
        drawn = figure.draw(trajectory, scenario)
        drawn.suptitle(figure.caption, fontsize=10)
        drawn.savefig(path, metadata=undated[path.suffix])
