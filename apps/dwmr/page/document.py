"""HTML document of the report: headings, tables, settings and plots in one self-contained file."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from dwmr.output import report
from dwmr.page import plots, settings, tables
from dwmr.results.paper_run import beside
from dwmr.scenario.model import Scenario
from dwmr.simulation.simulate import Trajectory

STYLE = """
:root { color-scheme: light dark; --ink: #1a1a1a; --paper: #fff; --faint: #ddd; --strong: #666; --soft: #444;
  --link: #0b5394; --warned: #fff7d6; --edge: #8a6d00; --window: #f0e442; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8e8e8; --paper: #1c1c1c; --faint: #444; --strong: #999;
  --soft: #b8b8b8; --link: #8ab8e8; --warned: #3a3210; --edge: #d0b040; --window: #b0a838; } }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 84rem;
  margin: 0 auto; padding: 1rem 1.5rem 4rem; }
h1, h2, h3 { line-height: 1.2; }
h2 { margin-top: 2.5rem; border-bottom: 1px solid var(--faint); padding-bottom: .2rem; }
nav ul { padding: 0; } nav li { display: inline-block; margin-right: 1.2rem; } a { color: var(--link); }
.wide { overflow-x: auto; } table { border-collapse: collapse; margin: 1rem 0; }
caption { text-align: left; font-weight: 600; padding-bottom: .3rem; }
th, td { padding: .15rem .7rem; border-bottom: 1px solid var(--faint); text-align: left; vertical-align: top; }
thead th { border-bottom: 2px solid var(--strong); } tbody th { font-weight: 400; }
.n { text-align: right; font-variant-numeric: tabular-nums; } code { overflow-wrap: anywhere; }
.warnings { background: var(--warned); border-left: 4px solid var(--edge); padding: .5rem 1rem; }
figure { margin: 1.5rem 0; } figcaption { color: var(--soft); } summary { cursor: pointer; font-weight: 600; }
.panels { display: grid; grid-template-columns: repeat(var(--columns), minmax(0, 1fr)); gap: .2rem 1rem; }
.panel { min-width: 0; } .panel svg { touch-action: pan-y; user-select: none; cursor: crosshair; }
@media (max-width: 50rem) { .panels { grid-template-columns: minmax(0, 1fr); } }
.note { margin: 0 0 .6rem; font-size: 13px; color: var(--soft); }
.readout { margin: 0; min-height: 1.5em; font-size: 13px; }
button { font: inherit; font-size: 13px; color: inherit; background: none; border: 1px solid var(--faint);
  border-radius: 4px; padding: .1rem .5rem; margin-right: .4rem; cursor: pointer; }
.legend button > * { vertical-align: middle; margin-right: .3rem; } .legend [aria-pressed="false"] { opacity: .45; }
svg text { fill: var(--ink); font-size: 12px; } svg .label { font-weight: 600; font-size: 13px; }
.grid { stroke: var(--faint); } .frame { fill: none; stroke: var(--strong); } .line { fill: none; }
.window { fill: var(--window); opacity: .25; } .body { fill: var(--soft); } .reach { fill: none; stroke: var(--soft);
  stroke-dasharray: 5 3; }
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
    items = "".join(f'<li><a href="#{to}">{text}</a></li>' for to, text in links)
    drawn, script = plots.of(trajectories, scenario), plots.script()
    parts = [
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{name}: dwmr report</title>',
        f'<meta http-equiv="Content-Security-Policy" content="{_policy(script)}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<style>{STYLE}</style></head><body>",
        f"<header><h1>Scenario {name}</h1><p>{_headline(trajectories, scenario)}</p></header>",
        f'<nav aria-label="Sections"><ul>{items}</ul></nav><main>',
        _results(runs, scenario),
        _plots(drawn),
        _settings(scenario),
        _origin(summary),
        f'</main><script type="application/json" id="plots">{plots.to_json(drawn)}</script>',
        f"<script>{script}</script></body></html>\n",
    ]
    return "\n".join(parts)


def _policy(script: str) -> str:
    """Return the content security policy: the browser loads nothing from anywhere, and runs this script only."""
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'"


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
            tables.stability(runs),
            warned,
            "</section>",
        ]
    )


def _plots(drawn: Sequence[plots.Plot]) -> str:
    parts = ['<section id="plots-of-runs"><h2>Plots</h2>']
    parts.append(
        "<p>Drag to zoom, double-click to go back; a click on a name hides its lines. Disturbance windows are shaded. "
        "Lines show the least and the greatest value of every stretch of time.</p><noscript><p>The plots need "
        "JavaScript; the tables do not.</p></noscript>"
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
