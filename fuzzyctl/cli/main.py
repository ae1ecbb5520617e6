"""The command group `fuzzyctl`."""

from __future__ import annotations

from typing import Final

import click

import fuzzyctl
from fuzzyctl.cli.streams import Program

#: The groups of the list of commands; by name of a command its module, its function there, and its line in the list.
GROUPS: Final = {
    "Write": {
        "new": ("fuzzyctl.cli.new", "new", "Write an annotated rule file to begin with."),
        "fmt": ("fuzzyctl.cli.fmt", "fmt", "Format rule files: spacing, indentation, columns of tables."),
        "check": ("fuzzyctl.cli.check", "check", "Find mistakes in rule files, once or at every save."),
        "explain": ("fuzzyctl.cli.explain", "explain", "Explain a diagnostic code."),
    },
    "Ask": {
        "eval": ("fuzzyctl.cli.eval", "evaluate", "Evaluate a rule file at a point, or at all points of a CSV."),
        "why": ("fuzzyctl.cli.eval", "why", "Explain an output at a point by the rules that act."),
        "plot": ("fuzzyctl.cli.plot", "plot", "Draw an output over inputs, or the terms."),
        "plot-surface": ("fuzzyctl.cli.plot", "plot_surface", "Draw an output over one or two inputs."),
        "show": ("fuzzyctl.cli.show", "show_system", "Print a summary of a rule file."),
    },
    "Trust": {
        "prove": ("fuzzyctl.cli.prove", "prove", "Prove the guarantees of rule files, or bound their outputs."),
        "verify": ("fuzzyctl.cli.prove", "verify", "Check a certificate that 'prove --certificate' wrote."),
        "compare": ("fuzzyctl.cli.compare", "compare", "Compare two files, in numbers or in what was changed."),
    },
    "Run": {
        "simulate": (
            "fuzzyctl.cli.simulate",
            "simulate",
            "Run closed loops, and check their requirements.",
        ),
        "sweep": ("fuzzyctl.cli.sweep", "sweep", "Run loops many times with varied values."),
    },
    "Ship": {
        "codegen": ("fuzzyctl.cli.codegen", "codegen", "Write a block as C99, Structured Text, JavaScript, an FMU."),
        "convert": ("fuzzyctl.cli.convert", "convert", "Write a system in another format."),
        "page": ("fuzzyctl.cli.page", "page", "Write a file as one page that computes offline."),
        "studio": ("fuzzyctl.cli.serve", "studio", "Edit rule files in the browser, with pictures."),
        "lsp": ("fuzzyctl.cli.serve", "lsp", "Serve an editor: mistakes, completion, hover, renaming."),
        "doctor": ("fuzzyctl.cli.doctor", "doctor", "Report what is installed and in use."),
    },
}

#: Commands of earlier versions, with their replacements.
MOVED: Final = {
    "bounds": "prove --bounds",
    "diff": "compare --changes",
    "plot-terms": "plot --terms",
    "watch": "check --watch",
}


@click.group(
    cls=Program,
    groups=GROUPS,
    moved=MOVED,
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
  fuzzyctl prove tip.fz --bounds          bound its outputs and their slopes
  fuzzyctl eval tip.fz service=7          evaluate one point
  fuzzyctl why tip.fz service=7           which rules act there, and how much
  fuzzyctl plot tip.fz --terms            draw the terms
  fuzzyctl plot-surface tip.fz -o t.png   draw what it computes
  fuzzyctl page tip.fz -o tip.html        sliders, surface, rules to share
  fuzzyctl fmt tip.fz                     lay it out
  fuzzyctl check tip.fz --watch -o t.png  check and draw again at every save
  fuzzyctl codegen tip.fz --target c      write it as C99, or st, python ...
  fuzzyctl convert tip.fz tip.fis         from and to .fis, .fll, .fcl, .fml
  fuzzyctl compare tip.fz tip.fis --changes   what was changed
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
