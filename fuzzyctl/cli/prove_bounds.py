"""`fuzzyctl prove --bounds`: proved bounds of each output, points that attain them, and how steep it is."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.cli.common import (
    DONE,
    end_of_range,
    report,
)
from fuzzyctl.cli.loading import Choice, load_checked, open_block
from fuzzyctl.cli.streams import write_json

#: Part of the time of a controller that is left for what is under way when it ends; least time for its bounds [s].
_REST: Final = 0.25
_LEAST: Final = 0.1
#: Least time for the coverage of a system [s].
_SURE: Final = 0.5
#: Seconds that reading a byte of a system takes, beyond the first ones. Counted, as bounds of systems read no clock.
_BYTE: Final = 4.5 / (1 << 20)
_FREE: Final = 1 << 16
#: The same of an operation of a large system, which is planned, checked and compiled.
_OPERATION: Final = 5e-5
_FEW: Final = 10_000

if TYPE_CHECKING:
    from fuzzyctl.analysis.extremes import Extent
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.system import FuzzySystem


def print_bounds(file: str, choice: Choice, timeout: float, form: str) -> int:
    """Print what the outputs of a system or controller lie between, and how steep those of a system are.

    Args:
        file: The file.
        choice: The block, its params and profile.
        timeout: Seconds that all bounds may take together.
        form: "text" or "json".
    """
    from fuzzyctl.analysis import clock
    from fuzzyctl.analysis.extremes import extents
    from fuzzyctl.analysis.work import written
    from fuzzyctl.kernels.plan.build import plan
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.system import FuzzySystem

    began = clock.used()
    kinds: list[Any] = [Controller, FuzzySystem]
    block, examined, _ = open_block(file, choice.name, *kinds)
    left = (1.0 - _REST) * timeout - (clock.used() - began)
    if block.kind == "controller":
        controller = choice.changed(block)
        _show_controller(controller, max(left, min(timeout, _LEAST)), form)
        return DONE
    # One half of the time is for the bounds, even if it is not known whether rules fire everywhere.
    with clock.limited(max(0.5 * left, _SURE)):
        system = load_checked(file, replace(choice, name=block.name), examined)
    size = len(examined.source.text)
    spent = _BYTE * max(size - _FREE, 0) + _OPERATION * max(written(plan(system)) - _FEW, 0)
    # Small files without own hedges count operations well: the same bounds in every run, however busy the machine is.
    is_counted = not (spent or system.hedges)
    left = max(2.0 * timeout, 4.0 * _SURE) if is_counted else began + (1.0 - _REST) * timeout - clock.used()
    with clock.limited(left):
        found = extents(system, timeout=max(timeout - spent, 0.0))
    if form == "json":
        write_json({**system.identity, "outputs": [_as_data(e) for e in found]})
    else:
        report("\n".join(line for e in found for line in _lines(system, e)))
    return DONE


def _show_controller(controller: Controller, timeout: float, form: str) -> None:
    from fuzzyctl.analysis.induction.bounds import controller_bounds

    units = {s.name: s.unit for s in (*controller.results, *controller.states)}
    states = {s.name for s in controller.states}
    found = controller_bounds(controller, timeout)
    if form == "json":
        data = {
            n: {"name": n, "low": end_of_range(b.lo), "high": end_of_range(b.hi), "note": b.note or None}
            for n, b in found.items()
        }
        outputs, kept = ([d for n, d in data.items() if (n in states) == wanted] for wanted in (False, True))
        write_json({**controller.identity, "outputs": outputs, "states": kept})
        return
    for name, bound in found.items():
        unit, what = units[name], "state " if name in states else ""
        report(f"{what}{name}: from {bound.lo + 0.0:.9g} to {bound.hi + 0.0:.9g}{' ' + unit if unit else ''}")
        if bound.note:
            report(f"  {bound.note}")


def _lines(system: FuzzySystem, extent: Extent) -> Iterator[str]:
    unit = system.output(extent.name).unit
    yield f"{extent.name}: from {extent.lo + 0.0:.9g} to {extent.hi + 0.0:.9g}{' ' + unit if unit else ''}"
    for value, at in ((extent.lo_found, extent.lo_at), (extent.hi_found, extent.hi_at)):
        if at is not None and not math.isnan(value):
            yield f"  {value + 0.0:.9g} at {', '.join(f'{n} = {x + 0.0:.9g}' for n, x in at.items())}"
    slopes = [f"{s:.9g} along {n}" for n, s in extent.steepness.items() if math.isfinite(s)]
    if slopes:
        yield f"  slope at most {', '.join(slopes)}"
    unknown = [n for n, s in extent.steepness.items() if not math.isfinite(s)]
    if unknown:
        yield f"  no bound of the slope is known along {', '.join(unknown)}"
    if extent.note:
        yield f"  {extent.note}"


def _as_data(extent: Extent) -> dict[str, Any]:
    return {
        "name": extent.name,
        "low": end_of_range(extent.lo),
        "high": end_of_range(extent.hi),
        "low_found": end_of_range(extent.lo_found),
        "low_at": extent.lo_at,
        "high_found": end_of_range(extent.hi_found),
        "high_at": extent.hi_at,
        "slopes": {n: end_of_range(s) for n, s in extent.steepness.items()},
        "note": extent.note or None,
    }
