"""HTML document of the report: headings, tables, settings and plots in one self-contained file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from dwmr.output import report
from dwmr.page import plots, settings, tables
from dwmr.results.paper_run import beside
from dwmr.scenario.model import Scenario
from dwmr.simulation.simulate import Trajectory

#: Content security policy: the browser loads nothing from anywhere.
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"

STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff; max-width: 70rem; margin: 0 auto;
  padding: 1rem 1.5rem 4rem; }
h1, h2, h3 { line-height: 1.2; } h2 { margin-top: 2.5rem; border-bottom: 1px solid #ccc; padding-bottom: .2rem; }
nav ul { padding: 0; } nav li { display: inline-block; margin-right: 1.2rem; } a { color: #0b5394; }
.wide { overflow-x: auto; } table { border-collapse: collapse; margin: 1rem 0; }
caption { text-align: left; font-weight: 600; padding-bottom: .3rem; }
th, td { padding: .15rem .7rem; border-bottom: 1px solid #ddd; text-align: left; vertical-align: top; }
thead th { border-bottom: 2px solid #666; } tbody th { font-weight: 400; }
.n { text-align: right; font-variant-numeric: tabular-nums; } code { overflow-wrap: anywhere; }
.warnings { background: #fff7d6; border-left: 4px solid #8a6d00; padding: .5rem 1rem; }
figure { margin: 1.5rem 0; } figcaption { color: #444; } summary { cursor: pointer; font-weight: 600; }
"""


def page(summary: Mapping[str, Any], trajectories: Sequence[Trajectory], scenario: Scenario) -> str:
    """Return the whole page, the same text every time.

    Args:
        summary: Content of summary.json.
        trajectories: One per control law.
        scenario: What was run.
    """
    name, runs = escape(scenario.name), summary["controllers"]
    links = [("results", "Results"), *((f"law-{t.controller}", t.controller) for t in trajectories)]
    links += [("settings", "Settings"), ("origin", "Origin")]
    items = "".join(f'<li><a href="#{escape(to)}">{escape(text)}</a></li>' for to, text in links)
    count = plots.buckets(trajectories)
    parts = [
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{name}: dwmr report</title>',
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<style>{STYLE}</style><script>{plots.library()}</script></head><body>",
        f"<header><h1>Scenario {name}</h1><p>{_headline(trajectories, scenario)}</p></header>",
        f'<nav aria-label="Sections"><ul>{items}</ul></nav><main>',
        _results(runs, scenario),
        *(_law(t, scenario, count) for t in trajectories),
        _settings(scenario),
        _origin(summary),
        "</main></body></html>\n",
    ]
    return "\n".join(parts)


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
            tables.effort(runs),
            warned,
            "</section>",
        ]
    )


def _law(trajectory: Trajectory, scenario: Scenario, count: int) -> str:
    law = escape(trajectory.controller)
    parts = [f'<section id="law-{law}"><h2>{law}</h2>']
    parts.append(
        "<p>Drag to zoom, double-click to go back; a click on a name hides its lines. Disturbance windows are shaded. "
        "Lines show the least and the greatest value of every stretch of time.</p><noscript><p>The plots need "
        "JavaScript; the tables do not.</p></noscript>"
    )
    for k, plot in enumerate(plots.of(trajectory, scenario, count)):
        label = escape(f"{plot.title}, {trajectory.controller}")
        parts.append(f'<figure aria-label="{label}"><h3>{escape(plot.title)}</h3>')
        parts.append(plots.to_html(plot, f"plot-{law}-{k}"))
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
