"""The command group `fuzzyctl`."""

from __future__ import annotations

from typing import Final

import click

import fuzzyctl
from fuzzyctl.cli.streams import Program

#: By name of a command its module, its function there, and its line in the list of commands.
COMMANDS: Final = {
    "bounds": ("fuzzyctl.cli.bounds", "bounds", "Print proved bounds of each output of a rule file."),
    "check": ("fuzzyctl.cli.check", "check", "Find the mistakes of rule files."),
    "codegen": ("fuzzyctl.cli.codegen", "codegen", "Write a system as C99, Structured Text, Python or JavaScript."),
    "compare": ("fuzzyctl.cli.compare", "compare", "Compare the numbers of two files, or of several tools."),
    "convert": ("fuzzyctl.cli.convert", "convert", "Write a system in another format."),
    "diff": ("fuzzyctl.cli.diff", "diff", "Show what was changed from one rule file to another."),
    "doctor": ("fuzzyctl.cli.doctor", "doctor", "Say what is installed, and what is in use."),
    "eval": ("fuzzyctl.cli.eval", "evaluate", "Evaluate a rule file at a point, or at all points of a CSV."),
    "explain": ("fuzzyctl.cli.explain", "explain", "Explain a diagnostic code."),
    "fmt": ("fuzzyctl.cli.fmt", "fmt", "Lay rule files out: spacing, indentation, columns of tables."),
    "lsp": ("fuzzyctl.cli.lsp", "lsp", "Serve an editor: mistakes, completion, hover, renaming."),
    "new": ("fuzzyctl.cli.new", "new", "Write an annotated rule file to begin with."),
    "page": ("fuzzyctl.cli.page", "page", "Write a file as one page that computes offline."),
    "plot-surface": ("fuzzyctl.cli.plot", "plot_surface", "Draw an output over one or two inputs."),
    "plot-terms": ("fuzzyctl.cli.plot", "plot_terms", "Draw the terms of all inputs and outputs."),
    "prove": ("fuzzyctl.cli.prove", "prove", "Prove the guarantees of rule files: their 'require' lines."),
    "show": ("fuzzyctl.cli.show", "show_system", "Print a summary of a rule file."),
    "simulate": ("fuzzyctl.cli.simulate", "simulate", "Run loops of controllers and plants, and judge them."),
    "studio": ("fuzzyctl.cli.studio", "studio", "Edit rule files in the browser, with pictures."),
    "sweep": ("fuzzyctl.cli.sweep", "sweep", "Run loops many times with values that vary."),
    "watch": ("fuzzyctl.cli.watch", "watch", "Check a file again at every save, with numbers and picture."),
    "why": ("fuzzyctl.cli.why", "why", "Say why a system gives what it gives at a point."),
}


@click.group(
    cls=Program,
    deferred=COMMANDS,
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
    require bounded(tip, 0, 30)

\b
What to do with it:
  fuzzyctl check tip.fz                   find mistakes, with their repair
  fuzzyctl explain FZ203                  what a mistake means
  fuzzyctl show tip.fz                    print it on one page
  fuzzyctl prove tip.fz                   prove its guarantees, or refute them
  fuzzyctl bounds tip.fz                  bound its outputs and their slopes
  fuzzyctl eval tip.fz service=7          evaluate one point
  fuzzyctl why tip.fz service=7           which rules act there, and how much
  fuzzyctl plot-terms tip.fz              draw the terms
  fuzzyctl plot-surface tip.fz -o t.png   draw what it computes
  fuzzyctl page tip.fz -o tip.html        sliders, surface, rules to share
  fuzzyctl fmt tip.fz                     lay it out
  fuzzyctl watch tip.fz -o t.png          check and draw again at every save
  fuzzyctl codegen tip.fz --target c      write it as C99, or st, python ...
  fuzzyctl convert tip.fz tip.fis         from and to .fis, .fll, .fcl, .fml
  fuzzyctl diff tip.fz tip.fis            what was changed: terms, rules
  fuzzyctl compare tip.fz tip.fis         where their numbers differ, and why
  fuzzyctl simulate water_tank -o out     run a controller on a plant
  fuzzyctl sweep --help                   run loops many times
  fuzzyctl new heater                     write another file to begin with
  fuzzyctl new mine --from tipper         copy a shipped file
  fuzzyctl show                           list the shipped files
  fuzzyctl doctor                         what is installed and in use

\b
A file '-' is standard input. A name such as tipper is
tipper.fz of this folder, else the shipped file.

\b
Exit codes: 0 done, 1 mistakes found, 2 wrong usage,
3 undecided: a guarantee, or (check only) whether
some rule always fires.
""",
)
@click.version_option(fuzzyctl.__version__, prog_name="fuzzyctl")
def main() -> None:
    """Check, evaluate and draw fuzzy systems written in .fz rule files."""
