"""`fuzzyctl plot` and `fuzzyctl plot-surface`."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import Any, cast

import click
from click.core import ParameterSource

from fuzzyctl.cli.common import (
    QUIET,
    STATE,
    SVG_TEXT,
    answers_with_diagnostics,
    assignments,
    outside_range,
    show,
    state_of,
    unknown,
)
from fuzzyctl.cli.loading import Choice, chooses, load_evaluable
from fuzzyctl.cli.streams import say
from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError

#: What matplotlib is asked to write.
SUFFIXES = (".png", ".svg", ".pdf")


def _options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of a picture of an output."""

    @click.argument("file")
    @click.option("-x", "x", metavar="VAR", help="Input along the first axis.  [default: the first]")
    @click.option("-y", "y", metavar="VAR", help="Input along the second axis.  [default: the next]")
    @click.option(
        "--at", "at", multiple=True, metavar="VAR=VALUE", help="Value of another input.  [default: mid-range]"
    )
    @STATE
    @click.option("-z", "output", metavar="VAR", help="Output to draw.  [default: the first]")
    @click.option(
        "--resolution", type=click.IntRange(2, 2001), default=121, show_default=True, help="Points along an axis."
    )
    @click.option("-o", "--output", "out", metavar="FILE", help="PNG, SVG or PDF.  [default: SYSTEM-OUTPUT.png]")
    @SVG_TEXT
    @chooses
    @QUIET
    @answers_with_diagnostics
    @wraps(command)
    def run(**options: Any) -> None:
        command(**options)

    return cast("Callable[..., None]", run)


@click.command("plot-surface")
@_options
def plot_surface(**options: Any) -> None:
    """Draw an output of a system, or of a step of a controller, over one or two inputs.

    \b
    fuzzyctl plot-surface ais_reaction -o f.png
    fuzzyctl plot-surface tipper -x food --at service=3 -o tip.svg

    With -x alone, or a system of one input, the picture is a curve.
    """
    _draw_surface(**options)


@click.command("plot")
@click.option(
    "--terms",
    is_flag=True,
    help="Draw the terms of all inputs and outputs; for a controller, of its systems.",
)
@_options
def plot(
    terms: bool,
    file: str,
    choice: Choice,
    out: str | None,
    svg_text: bool,
    **options: Any,
) -> None:
    """Draw an output over one or two inputs, as plot-surface does, or the terms.

    \b
    fuzzyctl plot tipper -o tip.png
    fuzzyctl plot tipper --terms -o terms.png
    """
    if not terms:
        _draw_surface(file=file, choice=choice, out=out, svg_text=svg_text, **options)
        return
    source = click.get_current_context().get_parameter_source
    forbidden = [name for name in options if source(name) is ParameterSource.COMMANDLINE]
    if forbidden:
        raise click.UsageError("--terms takes no inputs, state, output and resolution")
    block = load_evaluable(file, choice)
    if not block.all_systems:
        help_text = "terms are those of the systems that it calls; 'fuzzyctl plot' draws an output"
        raise DiagnosticError([Diagnostic("FZ503", f"{block.kind} '{block.name}' calls no systems", help=help_text)])
    from fuzzyctl.plot.choices import file_part

    target = picture_file(out, f"{file_part(block.name)}-terms.png")
    from fuzzyctl.plot.memberships import draw_terms
    from fuzzyctl.plot.style import saved

    with saved(target, svg_text=svg_text) as figure:
        draw_terms(figure, block)
    say(f"wrote {target}")


def _draw_surface(
    file: str,
    x: str | None,
    y: str | None,
    at: tuple[str, ...],
    state: tuple[str, ...],
    output: str | None,
    resolution: int,
    out: str | None,
    svg_text: bool,
    choice: Choice,
) -> None:
    system = load_evaluable(file, choice)
    inputs = [v.name for v in system.inputs]
    if not inputs:
        help_text = "a plot is over one or two inputs; 'fuzzyctl eval' makes a step"
        raise DiagnosticError([Diagnostic("FZ503", f"{system.kind} '{system.name}' has no inputs", help=help_text)])
    chosen = output or system.outputs[0].name
    outputs = [o.name for o in system.outputs]
    for kind, name, names in (("output", chosen, outputs), ("input", x, inputs), ("input", y, inputs)):
        if name is not None and name not in names:
            raise DiagnosticError([unknown(kind, name, names)])
    if x is not None and x == y:
        raise DiagnosticError([Diagnostic("FZ502", f"'{x}' is named for both axes", help="drop one for a curve")])
    from fuzzyctl.plot.choices import chosen_axes, file_part

    fixed = assignments(at, inputs, "input")
    axes = chosen_axes(inputs, x, y, fixed)
    for axis, value in fixed.items():
        if math.isnan(value):
            raise DiagnosticError([Diagnostic("FZ503", f"'{axis}' is not a number to draw at", help="give a value")])
    show(outside_range(system, fixed))
    for axis in axes:
        if axis in fixed:
            message, help_text = f"'{axis}' is an axis and has a value too", f"drop '--at {axis}=...' or the axis"
            raise DiagnosticError([Diagnostic("FZ502", message, help=help_text)])
    target = picture_file(out, f"{file_part(system.name)}-{file_part(chosen)}.png")
    from fuzzyctl.plot.style import saved
    from fuzzyctl.plot.surfaces import Sampled, draw_surface

    try:
        drawn = Sampled.of(system)
        drawn = replace(drawn, state=state_of(drawn.kernel, state)) if state else drawn
        _ = [drawn.range(axis) for axis in axes]
    except ArgumentError as error:
        raise DiagnosticError([Diagnostic("FZ503", error.args[0])]) from None
    with saved(target, svg_text=svg_text) as figure:
        draw_surface(figure, drawn, axes, fixed, chosen, resolution)
    say(f"wrote {target}")


def picture_file(out: str | None, default: str) -> Path:
    """Return the file to draw to; a name that matplotlib has no format for, or in no folder, is a mistake."""
    target = Path(out or default)
    if target.suffix.lower() not in SUFFIXES:
        help_text = f"end the name with one of: {', '.join(SUFFIXES)}"
        message = f"no picture format '{target.suffix or target.name}'"
        raise DiagnosticError([Diagnostic("FZ005", message, file=str(target), help=help_text)])
    if len(target.name) > 200 or not os.path.isdir(target.parent):
        message = f"there is no folder '{target.parent}'"
        raise DiagnosticError([Diagnostic("FZ005", message, file=str(target), help="make it, or name another file")])
    return target
