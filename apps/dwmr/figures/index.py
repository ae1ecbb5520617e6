"""Index page of a folder of figures: a caption for each, and the reason for each missing one."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from dwmr.figures.paper import FIGURES, usual
from dwmr.scenario.model import Scenario


def index(made: Collection[int], left_out: Mapping[int, str], suffix: str, scenario: Scenario) -> str:
    """Return the text of index.md: every figure with its caption, and why others are missing.

    Args:
        made: Numbers of the figures that were drawn.
        left_out: Why others were not, by number.
        suffix: Of the pictures' files.
        scenario: Scenario of the runs.
    """
    items = [f for f in FIGURES if f in usual(scenario) or f.number in made or f.number in left_out]
    lines = [
        f"# Figures of the scenario {_plain(scenario.name)}",
        "",
        f"Counterparts of Figs. {items[0].number} to {items[-1].number} of Goto, Bertol, Martins, drawn from simulated "
        "runs. Disturbance windows are shaded; a bar at the foot of a panel marks obstacle avoidance, one at its head "
        "the load. Signals are drawn by the least and greatest value of every stretch of time, so that chattering "
        "shows as the band it fills.",
        "",
    ]
    for figure in items:
        lines.append(f"## Fig. {figure.number}: {figure.title} ({figure.subject})")
        lines.append("")
        if figure.number in made:
            lines += [figure.about, "", f"![Fig. {figure.number}]({figure.file(suffix)})", ""]
        else:
            lines += [f"Left out: {left_out.get(figure.number, 'not asked for')}.", ""]
    lines += [
        "## The paper's other figures",
        "",
        "Figs. 1 to 4 are drawings of geometry and block diagrams, without numbers. Figs. 5 to 7 are membership "
        "functions: `fuzzyctl plot --terms` draws them from the rule files. Figs. 8 to 28 show the simulation, "
        "`dwmr figures paper`, and Figs. 29 to 39 the experiment, with rigid bodies, `dwmr figures experiment`.",
        "",
    ]
    return "\n".join(lines)


def _plain(text: str) -> str:
    """Return text for Markdown with nothing that it would take for markup."""
    return "".join(f"\\{c}" if c in r"\`*_{}[]()<>#+!|" else " " if c in "\r\n" else c for c in text)
