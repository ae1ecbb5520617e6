"""HTML document of the report: headings, tables, settings and plots in one self-contained file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from typing import Any

from dwmr.figures.style import COLOURS
from dwmr.output import report
from dwmr.page import plots, settings, tables
from dwmr.results.paper_run import beside
from dwmr.scenario.model import Scenario
from dwmr.simulation.simulate import Trajectory
from fuzzyctl.page.document import PANELS, asset, enclosed, html_document

#: Where the report differs from other pages: it is read from above to below.
STYLE = """
h2 { margin-top: 2.5rem; border-bottom: 1px solid var(--line); padding-bottom: 0.2rem; }
caption { font-weight: 600; }
.n { text-align: right; font-variant-numeric: tabular-nums; }
.warnings { background: var(--card); border-left: 4px solid var(--warning); padding: 0.5rem 1rem; }
figure { margin: 1.5rem 0; }
figcaption { color: var(--note); }
summary { cursor: pointer; font-weight: 600; }
"""


def page(summary: Mapping[str, Any], trajectories: Sequence[Trajectory], scenario: Scenario) -> str:
    """Return the whole page, the same text every time.

    Args:
        summary: Content of summary.json.
        trajectories: One per control law.
        scenario: What was run.
    """
    name, runs = escape(scenario.name), summary["controllers"]
    links = (("results", "Results"), ("plots-of-runs", "Plots"), ("settings", "Settings"), ("origin", "Origin"))
    items = "".join(f'<a href="#{to}">{text}</a>' for to, text in links)
    drawn = plots.of(trajectories, scenario)
    parts = [
        f"<main><header><h1>Scenario {name}</h1><p>{_headline(trajectories, scenario)}</p></header>",
        f'<nav aria-label="Sections">{items}</nav>',
        _results(runs, scenario),
        _plots(drawn),
        _settings(scenario),
        _origin(summary),
        "</main>",
    ]
    facts = {"colors": COLOURS, "plots": [plot.data for plot in drawn]}
    title, style = f"{scenario.name}: dwmr report", asset("page.css") + STYLE
    return html_document(title, "\n".join(parts), facts, [script()], style)


def script() -> str:
    """Return what draws the plots: that of all pages, and where the report has them."""
    own = (files("dwmr.page") / "report.js").read_text(encoding="utf-8")
    return enclosed(*map(asset, PANELS), own)


def _headline(trajectories: Sequence[Trajectory], scenario: Scenario) -> str:
    robots, laws = len(scenario.robots), ", ".join(escape(t.controller) for t in trajectories)
    return (
        f"{robots} robot{'s' if robots != 1 else ''}, {len(scenario.obstacles)} obstacles, "
        f"{scenario.run.horizon:g} s in control periods of {1000.0 * scenario.run.dt:g} ms, under {laws}."
    )


def _results(runs: Mapping[str, Any], scenario: Scenario) -> str:
    printed, why_not = beside(scenario)
    lines = [f"<li>{escape(line)}</li>" for line in ([why_not] if why_not else []) + report.warnings(runs)]
    warned = f'<div class="warnings"><h3>Warnings</h3><ul>{"".join(lines)}</ul></div>' if lines else ""
    said = "".join(f"<li>{escape(report.sentence(law, run, printed))}</li>" for law, run in runs.items())
    return "\n".join(
        [
            f'<section id="results"><h2>Results</h2><ul>{said}</ul>',
            tables.errors(runs, printed),
            tables.safety(runs),
            tables.safety_filter(runs),
            tables.effort(runs),
            tables.stability(runs),
            warned,
            "</section>",
        ]
    )


def _plots(drawn: Sequence[plots.Plot]) -> str:
    parts = ['<section id="plots-of-runs"><h2>Plots</h2>']
    parts.append(
        "<p>Drag to zoom, double-click to go back; a click on a name hides its lines. Disturbance windows are shaded; "
        "a bar at the head of a panel marks the load. Lines show the least and the greatest value of every "
        "stretch of time.</p><noscript><p>The plots need JavaScript; the tables do not.</p></noscript>"
    )
    for k, plot in enumerate(drawn):
        parts.append(f'<figure><h3>{escape(plot.title)}</h3><div id="plot-{k}"></div>')
        parts.append(f"<figcaption>{escape(plot.caption)}</figcaption></figure>")
    return "\n".join([*parts, "</section>"])


def _settings(scenario: Scenario) -> str:
    parts = ['<section id="settings"><h2>Settings</h2>']
    rows = list(settings.rows(scenario))
    for group in dict.fromkeys(_group(row.key) for row in rows):
        own = [row for row in rows if _group(row.key) == group]
        table = tables.table(f"Settings of {group}", ("key", "value", "unit", "meaning"), own, left=4)
        parts.append(f"<details><summary>{escape(group)}</summary>{table}</details>")
    return "\n".join([*parts, "</section>"])


def _group(key: str) -> str:
    """Return the table a setting stands in: `robots.leader` for those of a robot, else the first part of its key."""
    first, _, rest = key.partition(".")
    return f"{first}.{rest.partition('.')[0]}" if first == "robots" else first.partition("[")[0]


def _origin(summary: Mapping[str, Any]) -> str:
    origin, rules = summary["scenario"], summary["rules"]
    about = [["scenario", origin["file"], origin["sha256"]]]
    about += [[role, one["file"], one["sha256"]] for role, one in rules.items()]
    parts = ['<section id="origin"><h2>Origin</h2>']
    parts.append(tables.table("Files", ("role", "file", "SHA-256"), about, left=3))
    params = [[role, name, f"{value:g}"] for role, one in rules.items() for name, value in one["params"].items()]
    if params:
        parts.append(
            tables.table("Params of the rule files that the scenario sets", ("role", "param", "value"), params)
        )
    if origin["overrides"]:
        given = "".join(f"<li><code>{escape(one)}</code></li>" for one in origin["overrides"])
        parts.append(f"<h3>Overrides</h3><ul>{given}</ul>")
    versions = [[name, value or "not installed"] for name, value in summary["versions"].items()]
    parts.append(tables.table("Versions", ("package", "version"), versions))
    return "\n".join([*parts, "</section>"])
