"""What kernels and steps look like in a notebook: what goes in and out, and the surface of a kernel."""

from __future__ import annotations

from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.display.markup import Markup, page, pairs, paragraph, picture_png
from fuzzyctl.kernels.free_kernel import FreeKernel
from fuzzyctl.kernels.kernel import Kernel
from fuzzyctl.kernels.steps.step import Step


def html(shown: Kernel | FreeKernel | Step) -> str:
    """Return the facts of a kernel or a step; of a kernel also its surface."""
    facts = {"backend": shown.backend, "inputs": ", ".join(shown.input_names), "outputs": ", ".join(shown.output_names)}
    if isinstance(shown, Step):
        facts["states"] = f"{len(shown.state_names)}"
        facts["period"] = "given by the caller" if shown.period is None else f"{shown.period:.12g} s"
    if isinstance(shown, Kernel):
        facts |= {"rules": str(shown.n_rules), "states": str(shown.n_states), "algorithm": shown.algorithm.name}
    else:
        facts["free numbers"] = ", ".join(shown.free_names) or "none"
    picture = _surface(shown) if isinstance(shown, Kernel) else Markup("")
    return page(type(shown).__name__, pairs("", facts), picture)


def _surface(kernel: Kernel) -> Markup:
    from fuzzyctl.plot.figures import png
    from fuzzyctl.plot.surfaces import overview

    try:
        picture = png(overview(kernel))
    except NoRuleFiresError as error:
        return paragraph(f"no surface: {error}", "note")
    return picture_png(picture, f"{kernel.output_names[0]} over {' and '.join(kernel.input_names[:2])}")
