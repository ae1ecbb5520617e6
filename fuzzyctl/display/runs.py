"""What experiments and runs look like in a notebook: what is compiled; measures, requirements, signals over time."""

from __future__ import annotations

from fuzzyctl.display.layout import number_text
from fuzzyctl.display.markup import Markup, page, pairs, paragraph, picture_svg, table
from fuzzyctl.expr import to_text
from fuzzyctl.simulation.experiment import Experiment
from fuzzyctl.simulation.run import Run


def html(shown: Experiment | Run) -> str:
    """Return the facts of an experiment; of a run measures and requirements as tables, and a picture of the signals."""
    return _run(shown) if isinstance(shown, Run) else _experiment(shown)


def _experiment(experiment: Experiment) -> str:
    loop = experiment.loop
    facts = {
        "backend": experiment.backend,
        "samples": f"{experiment.samples:,}, {number_text(experiment.step)} s apart",
        "free params": ", ".join(f"{n} = {number_text(v)}" for n, v in experiment.nominal.items()) or "none",
        "signals": ", ".join(n for n in experiment.positions if "#" not in n),
        "measures": ", ".join(m.name for m in loop.measures) or "none",
        "requirements": "; ".join(to_text(r.claim) for r in loop.requirements) or "none",
    }
    return page(f"experiment {loop.name}{f': {loop.title}' if loop.title else ''}", pairs("", facts))


def _run(run: Run) -> str:
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
