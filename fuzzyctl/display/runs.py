"""What a run of a loop looks like in a notebook: measures, requirements, and its signals over time."""

from __future__ import annotations

from fuzzyctl.display.markup import Markup, page, pairs, paragraph, picture_svg, table
from fuzzyctl.simulation.run import Run


def html(run: Run) -> str:
    """Return measures and requirements as tables, and a picture of the signals."""
    units = {m.name: m.unit for m in run.loop.measures}
    return page(
        run.loop.title or run.loop.name,
        paragraph(repr(run)),
        paragraph("" if run.stopped is None else f"stopped: {run.stopped.message}"),
        table("Measures", ("measure", "value", "unit"), [(n, f"{v:.6g}", units[n]) for n, v in run.measures.items()]),
        pairs("Requirements", {r.text: _said(r.holds, r.facts) for r in run.requirements}),
        _picture(run),
    )


def _said(holds: bool, facts: tuple[str, ...]) -> str:
    return "holds" if holds else "; ".join(("does not hold", *facts))


def _picture(run: Run) -> Markup:
    from fuzzyctl.plot.figures import svg
    from fuzzyctl.plot.time_series import runs

    return picture_svg(svg(runs(run).figure), "signals over time") if len(run) else Markup("")
