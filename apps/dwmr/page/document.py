"""HTML document of the report: headings, tables, settings and plots in one self-contained file."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from importlib.resources import files
from typing import TYPE_CHECKING, Any, NamedTuple

from pydantic import BaseModel

from dwmr.figures.style import COLOURS
from dwmr.output import report
from dwmr.output.report import RunTable
from dwmr.page import plots
from dwmr.results.paper_tables import MEASURES, TABLES, beside, ratios
from dwmr.scenario.model import Scenario
from dwmr.simulation.simulate import Trajectory
from fuzzyctl.page.document import PANELS, asset, enclosed, html_document

if TYPE_CHECKING:
    from dwmr.figures.paper import PaperFigure

#: Errors besides those of the report.
_SECTIONS = (
    ("rmse_inertial", "Root mean square errors in inertial axes"),
    ("rmse_body", "Root mean square errors in the robot's own axes"),
)


def _table(caption: str, head: Sequence[str], body: Iterable[Sequence[str]], left: int = 2) -> str:
    """Return a table.

    Args:
        caption: Its subject.
        head: Names of the columns.
        body: Rows; a row's first cell is its heading.
        left: Columns of text, aligned to the left; the others hold numbers.
    """
    cells = "".join(f'<th scope="col"{_side(k, left)}>{escape(name)}</th>' for k, name in enumerate(head))
    lines = [
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(caption)}">',
        f"<table><caption>{escape(caption)}</caption>",
        f"<thead><tr>{cells}</tr></thead><tbody>",
    ]
    for row in body:
        rest = "".join(f"<td{_side(k, left)}>{escape(cell)}</td>" for k, cell in enumerate(row[1:], start=1))
        lines.append(f'<tr><th scope="row">{escape(row[0])}</th>{rest}</tr>')
    return "\n".join([*lines, "</tbody></table></div>"])


def _side(k: int, left: int) -> str:
    return "" if k < left else ' class="n"'


def _of_runs(one: RunTable) -> str:
    """Return a table of a report without its empty columns, with its legend."""
    rows = [(law, robot, *cells) for law, by_robot in one.rows.items() for robot, cells in by_robot.items()]
    columns = [k for k in range(2 + len(one.heads)) if k < 2 or any(row[k] for row in rows)]
    head = [("law", "robot", *(" ".join(text.split()) for text in one.heads))[k] for k in columns]
    table = _table(one.title, head, [[row[k] for k in columns] for row in rows])
    return table + (f"<p>{escape(one.about)}</p>" if one.about else "")


class Row(NamedTuple):
    """One setting."""

    key: str
    value: str
    unit: str
    doc: str


def setting_rows(section: BaseModel, prefix: str = "") -> Iterator[Row]:
    """Yield every setting of a section and of those in it, by its key in the scenario file.

    Args:
        section: A scenario or a part of one.
        prefix: Key of the section, with a dot at its end.
    """
    for name, field in type(section).model_fields.items():
        extra = field.json_schema_extra
        unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
        yield from _of(f"{prefix}{name}", getattr(section, name), unit, field.description or "")
    for name, value in (section.model_extra or {}).items():
        yield from _of(f"{prefix}{name}", value, "", "")


def _of(key: str, value: Any, unit: str, doc: str) -> Iterator[Row]:
    if isinstance(value, BaseModel):
        yield from setting_rows(value, f"{key}.")
    elif isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _of(f"{key}.{name}", inner, "", "")
    elif isinstance(value, tuple | list) and any(isinstance(one, BaseModel) for one in value):
        for k, one in enumerate(value):
            yield from _of(f"{key}[{k}]", one, unit, doc)
    elif value is not None:
        yield Row(key, _shown(value), "" if unit == "-" else unit, doc)


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple | list):
        return ", ".join(_shown(one) for one in value)
    return repr(value) if isinstance(value, float) else str(value)


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
        scenario: Scenario of the runs.
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
    """Return the script of the plots: that of all pages, and the part for the report."""
    placing = (files("dwmr.page") / "report.js").read_text(encoding="utf-8")
    return enclosed(*map(asset, PANELS), placing)


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
    sentences = "".join(f"<li>{escape(line)}</li>" for line in report.sentences(runs, printed))
    untimed = {law: {key: value for key, value in run.items() if key != "wall_s"} for law, run in runs.items()}
    first, *rest = report.run_tables(untimed, printed)
    others = [report.error_table(runs, section, title, None) for section, title in _SECTIONS]
    tables = [_of_runs(one) for one in (first, *others, *rest)]
    parts = [f'<section id="results"><h2>Results</h2><ul>{sentences}</ul>', *tables, warned, "</section>"]
    return "\n".join(parts)


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
    rows = list(setting_rows(scenario))
    for group in dict.fromkeys(_group(row.key) for row in rows):
        group_rows = [row for row in rows if _group(row.key) == group]
        table = _table(f"Settings of {group}", ("key", "value", "unit", "meaning"), group_rows, left=4)
        parts.append(f"<details><summary>{escape(group)}</summary>{table}</details>")
    return "\n".join([*parts, "</section>"])


def _group(key: str) -> str:
    """Return the table of a setting: `robots.leader` for those of a robot, else the first part of its key."""
    first, _, rest = key.partition(".")
    return f"{first}.{rest.partition('.')[0]}" if first == "robots" else first.partition("[")[0]


def _origin(summary: Mapping[str, Any]) -> str:
    origin, rules = summary["scenario"], summary["rules"]
    about = [["scenario", origin["file"], origin["sha256"]]]
    about += [[role, one["file"], one["sha256"]] for role, one in rules.items()]
    parts = ['<section id="origin"><h2>Origin</h2>']
    parts.append(_table("Files", ("role", "file", "SHA-256"), about, left=3))
    params = [[role, name, f"{value:g}"] for role, one in rules.items() for name, value in one["params"].items()]
    if params:
        parts.append(_table("Params of the rule files that the scenario sets", ("role", "param", "value"), params))
    if origin["overrides"]:
        items = "".join(f"<li><code>{escape(one)}</code></li>" for one in origin["overrides"])
        parts.append(f"<h3>Overrides</h3><ul>{items}</ul>")
    versions = [[name, value or "not installed"] for name, value in summary["versions"].items()]
    parts.append(_table("Versions", ("package", "version"), versions))
    return "\n".join([*parts, "</section>"])


class PaperPart(NamedTuple):
    """A part of the paper's results: the runs of one scenario and their figures.

    Attributes:
        scenario: Scenario of the runs.
        summary: As in summary.json.
        pictures: PNG files by figure.
    """

    scenario: Scenario
    summary: dict[str, Any]
    pictures: dict[PaperFigure, bytes]

    @property
    def printed(self) -> int | None:
        """Number of the table that the errors are shown beside, or None."""
        return beside(self.scenario)[0]

    @property
    def finished(self) -> bool:
        """Whether all runs came to their end."""
        return all(run["stopped"] is None for run in self.summary["controllers"].values())

    def sentences(self) -> list[str]:
        """Return one sentence of each run, and one of all."""
        why_not = beside(self.scenario)[1]
        return [*([why_not] if why_not else []), *report.sentences(self.summary["controllers"], self.printed)]

    def table(self) -> list[dict[str, Any]]:
        """Return the rows of the paper's table with our errors and their ratios, none without a table beside."""
        if self.printed is None:
            return []
        return [
            {
                "law": law, "robot": robot, "error": name, "paper": TABLES[self.printed][law][robot][name],
                "ours": run["rmse"][robot][MEASURES[name]], "ratio": ratio,
            }
            for law, run in self.summary["controllers"].items()
            if run["stopped"] is None
            for (robot, name), ratio in ratios(law, run["rmse"], self.printed).items()
        ]  # fmt: skip

    def origin(self) -> dict[str, Any]:
        """Return where the numbers come from, and the errors, without the time of the runs."""
        controllers = {law: {"rmse": run["rmse"], "stopped": run["stopped"]} for law, run in _runs(self.summary)}
        return {**self.summary, "controllers": controllers}


def _runs(summary: Mapping[str, Any]) -> Iterable[tuple[str, Any]]:
    runs: Mapping[str, Any] = summary["controllers"]
    return runs.items()


def paper_page(parts: Sequence[PaperPart], left_out: Mapping[str, str], interrupted: bool) -> str:
    """Return a page with the paper's tables beside our errors, and all figures with captions.

    Args:
        parts: The parts that were run.
        left_out: Reasons for missing parts.
        interrupted: Whether the rest is missing since the command was interrupted.
    """
    body = ["<main><header><h1>Tables 12 and 13, Figs. 8 to 39</h1>"]
    body.append("<p>Counterparts of those of Goto, Bertol and Martins, computed by dwmr.</p></header>")
    lines = [f"{what} left out: {why}" for what, why in left_out.items()]
    lines += ["The command was interrupted: the rest is missing."] if interrupted else []
    if lines:
        items = "".join(f"<li>{escape(line)}</li>" for line in lines)
        body.append(f'<div class="warnings"><h2>Missing</h2><ul>{items}</ul></div>')
    for part in parts:
        name, runs = part.scenario.name, part.summary["controllers"]
        sentences = "".join(f"<li>{escape(line)}</li>" for line in part.sentences())
        body.append(f'<section id="{escape(name)}"><h2>Scenario {escape(name)}</h2><ul>{sentences}</ul>')
        body.append(_of_runs(next(report.run_tables(runs, part.printed))))
        for figure, content in part.pictures.items():
            source = f"data:image/png;base64,{base64.b64encode(content).decode('ascii')}"
            body.append(f'<figure id="fig{figure.number}"><h3>{escape(figure.caption)}</h3>')
            body.append(f'<img src="{source}" alt="{escape(figure.caption)}">')
            body.append(f"<figcaption>{escape(figure.about)}</figcaption></figure>")
        body.append("</section>")
    style = asset("page.css") + STYLE + "img { max-width: 100%; background: #fff; }\n"
    return html_document("The paper's results: dwmr paper", "\n".join([*body, "</main>"]), {}, [], style)
