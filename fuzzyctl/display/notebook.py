"""Kernels, plots, experiments, runs and verdicts as HTML for a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fuzzyctl.analysis.verdicts import Refuted, Undecided, Verdict, Verdicts
from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.display.layout import number_text
from fuzzyctl.display.markup import Markup, lines, page, pairs, paragraph, picture_png, picture_svg, table
from fuzzyctl.formats.fz_strings import guarantee_text

if TYPE_CHECKING:
    from fuzzyctl.kernels.kernel import Kernel
    from fuzzyctl.plot.figures import Panels, Plot, Plot3D
    from fuzzyctl.simulation.experiment import Experiment
    from fuzzyctl.simulation.run import Run


def kernel_html(kernel: Kernel) -> str:
    """Return the facts of a kernel, and of a system without free numbers its surface."""
    facts = {
        "backend": kernel.backend,
        "inputs": ", ".join(kernel.input_names),
        "outputs": ", ".join(kernel.output_names),
    }
    if not kernel.form.moves:
        facts["rules"] = str(kernel.n_rules)
    facts["states"] = str(kernel.n_states)
    if kernel.form.moves:
        facts["period"] = "given by the caller" if kernel.period is None else f"{kernel.period:.12g} s"
    else:
        facts["algorithm"] = kernel.algorithm.name
    if kernel.free_names:
        facts["free numbers"] = ", ".join(kernel.free_names)
    picture = Markup("") if kernel.form.moves or kernel.free_names else _surface_of(kernel)
    return page("Kernel", pairs("", facts), picture)


def _surface_of(kernel: Kernel) -> Markup:
    from fuzzyctl.plot.figures import png
    from fuzzyctl.plot.surfaces import overview

    try:
        picture = png(overview(kernel))
    except NoRuleFiresError as error:
        return paragraph(f"no surface: {error}", "note")
    return picture_png(picture, f"{kernel.output_names[0]} over {' and '.join(kernel.input_names[:2])}")


def plot_html(plot: Panels | Plot | Plot3D) -> str:
    """Return the picture; one whose colours stand for values stays on white."""
    from fuzzyctl.plot.figures import Panels, png, svg

    figure: Any = plot.figure if isinstance(plot, Panels) else plot.get_figure(root=True)
    texts = [ax.get_title() or ax.get_ylabel() for ax in figure.axes]
    what = ", ".join(filter(None, texts)) or "plot"
    return page("", picture_png(png(figure), what) if _has_values(figure) else picture_svg(svg(figure), what))


def _has_values(figure: Any) -> bool:
    """Whether colours stand for values anywhere, as in maps and surfaces."""
    return any(c.get_array() is not None for ax in figure.axes for c in (*ax.collections, *ax.images))


def experiment_html(experiment: Experiment) -> str:
    """Return the facts of an experiment."""
    loop = experiment.loop
    facts = {
        "backend": experiment.backend,
        "samples": f"{experiment.samples:,}, {number_text(experiment.step)} s apart",
        "free params": ", ".join(f"{n} = {number_text(v)}" for n, v in experiment.nominal.items()) or "none",
        "signals": ", ".join(n for n in experiment.positions if "#" not in n),
        "measures": ", ".join(m.name for m in loop.measures) or "none",
        "requirements": "; ".join(map(guarantee_text, (*loop.requirements, *loop.guarantees))) or "none",
    }
    return page(f"experiment {loop.name}{f': {loop.title}' if loop.title else ''}", pairs("", facts))


def run_html(run: Run) -> str:
    """Return measures and requirements of a run as tables, and a picture of its signals."""
    units = {m.name: m.unit for m in run.loop.measures}
    return page(
        run.loop.title or run.loop.name,
        paragraph(repr(run)),
        paragraph("" if run.stopped is None else f"stopped: {run.stopped.message}"),
        table("Measures", ("measure", "value", "unit"), [(n, f"{v:.6g}", units[n]) for n, v in run.measures.items()]),
        pairs("Requirements", {r.text: "; ".join((r.verdict, *r.facts)) for r in run.requirements}),
        _signals(run),
    )


def _signals(run: Run) -> Markup:
    from fuzzyctl.plot.figures import svg
    from fuzzyctl.plot.time_series import runs

    return picture_svg(svg(runs(run).figure), "signals over time") if len(run) else Markup("")


def verdict_html(verdict: Verdict | Verdicts) -> str:
    """Return one verdict with its witness, or a table of several."""
    if isinstance(verdict, Verdicts):
        verdicts = [(_word(v), v.claim, _finding(v)) for v in verdict]
        width = 3 if any(finding for _, _, finding in verdicts) else 2
        header = ("verdict", "claim", "found")[:width]
        return page(counted(len(verdict), "guarantee"), table("", header, [row[:width] for row in verdicts]))
    parts: list[Markup] = [paragraph(_note(verdict), "note")]
    if isinstance(verdict, Refuted):
        parts.append(_witness(verdict))
    if isinstance(verdict, Undecided):
        names = list(dict.fromkeys(name for box in verdict.boxes for name in box))
        rows = [[str(k + 1), *(str(box.get(n, "")) for n in names)] for k, box in enumerate(verdict.boxes)]
        parts.append(table("Open boxes", ("box", *names), rows))
    return page(f"{_word(verdict)}: {verdict.claim}", *parts)


def _word(verdict: Verdict) -> str:
    return type(verdict).__name__.lower()


def _note(verdict: Verdict) -> str:
    if isinstance(verdict, Undecided):
        return verdict.reason + (f"; {verdict.remaining} boxes remain" if verdict.remaining else "")
    return verdict.note


def _finding(verdict: Verdict) -> Any:
    if isinstance(verdict, Refuted):
        return lines(filter(None, (str(verdict.witness), verdict.note)))
    return _note(verdict)


def _witness(verdict: Refuted) -> Markup:
    witness = verdict.witness
    points = [p for p in (witness.point, witness.other) if p is not None]
    rows = [(name, *(repr(p.get(name, "")) for p in points)) for name in witness.point]
    header = ("input", "value", "other value")[: 1 + len(points)]
    sides = pairs("Values there", {side: f"{value:.12g}" for side, value in witness.sides})
    return Markup("\n".join((table("Witness", header, rows), sides)))
