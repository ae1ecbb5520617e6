"""Registers the commands."""

from __future__ import annotations

import click

import fuzzyctl
from fuzzyctl.cli.bounds import bounds
from fuzzyctl.cli.check import check
from fuzzyctl.cli.codegen import codegen
from fuzzyctl.cli.compare import compare
from fuzzyctl.cli.convert import convert
from fuzzyctl.cli.diff import diff
from fuzzyctl.cli.doctor import doctor
from fuzzyctl.cli.eval import evaluate
from fuzzyctl.cli.explain import explain
from fuzzyctl.cli.fmt import fmt
from fuzzyctl.cli.new import new
from fuzzyctl.cli.plot import plot_surface, plot_terms
from fuzzyctl.cli.prove import prove
from fuzzyctl.cli.show import show_system
from fuzzyctl.cli.streams import Program
from fuzzyctl.cli.why import why


@click.group(
    cls=Program,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="""\
\b
A rule file, tip.fz:
    system tip "How much to tip"
    input service in [0, 10]
      terms poor good excellent
    output tip in [0, 30] unit "%"
      terms low fair high
    defuzzifier center_average
    table tip = service
         poor  good  excellent
      |  low   fair  high

\b
What to do with it:
  fuzzyctl check tip.fz                   find mistakes, with their repair
  fuzzyctl explain FZ203                  what a mistake means
  fuzzyctl show tip.fz                    print it on one page
  fuzzyctl prove tip.fz                   prove its guarantees, or refute them
  fuzzyctl bounds tip.fz                  bound its outputs and their slopes
  fuzzyctl eval tip.fz service=7          evaluate one point
  fuzzyctl eval tip.fz --points in.csv    evaluate all rows of a CSV
  fuzzyctl why tip.fz service=7           which rules act there, and how much
  fuzzyctl plot-terms tip.fz              draw the terms
  fuzzyctl plot-surface tip.fz -o tip.png draw what it computes
  fuzzyctl fmt tip.fz                     lay it out
  fuzzyctl codegen tip.fz --target c      write it as C99, or st, or python
  fuzzyctl convert tip.fis tip.fz         from and to .fis, .fll, .fcl, .fml
  fuzzyctl diff old.fz new.fz             what was changed: terms, rules
  fuzzyctl compare old.fz new.fz          where their numbers differ, and why
  fuzzyctl new heater                     write another file to begin with
  fuzzyctl doctor                         what is installed and in use

\b
A file '-' is standard input.

\b
Exit codes: 0 done, 1 mistakes found, 2 wrong usage,
3 undecided: a guarantee, or (check only) whether
some rule always fires.
""",
)
@click.version_option(fuzzyctl.__version__, prog_name="fuzzyctl")
def main() -> None:
    """Check, evaluate and draw fuzzy systems written in .fz rule files."""


for command in (
    new,
    check,
    explain,
    show_system,
    evaluate,
    prove,
    bounds,
    plot_surface,
    plot_terms,
    fmt,
    codegen,
    compare,
    convert,
    diff,
    doctor,
    why,
):
    main.add_command(command)
