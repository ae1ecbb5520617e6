"""What kernels look like in a notebook: what goes in and out, and the surface of a system."""

from __future__ import annotations

from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.display.markup import Markup, page, pairs, paragraph, picture_png
from fuzzyctl.kernels.kernel import Kernel


def html(shown: Kernel) -> str:
    """Return the facts of a kernel, and of a system without free numbers its surface."""
    facts = {"backend": shown.backend, "inputs": ", ".join(shown.input_names), "outputs": ", ".join(shown.output_names)}
    if not shown.form.moves:
        facts["rules"] = str(shown.n_rules)
    facts["states"] = str(shown.n_states)
    if shown.form.moves:
        facts["period"] = "given by the caller" if shown.period is None else f"{shown.period:.12g} s"
    else:
        facts["algorithm"] = shown.algorithm.name
    if shown.free_names:
        facts["free numbers"] = ", ".join(shown.free_names)
    picture = Markup("") if shown.form.moves or shown.free_names else _surface(shown)
    return page("Kernel", pairs("", facts), picture)


def _surface(kernel: Kernel) -> Markup:
    from fuzzyctl.plot.figures import png
    from fuzzyctl.plot.surfaces import overview

    try:
        picture = png(overview(kernel))
    except NoRuleFiresError as error:
        return paragraph(f"no surface: {error}", "note")
    return picture_png(picture, f"{kernel.output_names[0]} over {' and '.join(kernel.input_names[:2])}")
