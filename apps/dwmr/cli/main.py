"""Entry point of the command line: registers the commands."""

from __future__ import annotations

from typing import Final

import click

from fuzzyctl.cli.streams import Program

#: By name of a command its module, its function there, and its line in the list of commands.
COMMANDS: Final = {
    "show": ("dwmr.cli.scenarios", "show", "Print a summary of a scenario, or list the shipped ones."),
    "new": ("dwmr.cli.scenarios", "new", "Write a scenario to start from."),
    "check": ("dwmr.cli.scenarios", "check", "Find the mistakes of scenarios and their rule files."),
    "run": ("dwmr.cli.run", "run", "Run a scenario and write the results to a folder."),
    "figures": ("dwmr.cli.figures", "figures", "Draw the counterparts of the paper's Figures 8 to 39."),
    "paper": ("dwmr.cli.figures", "paper", "Write all tables and figures of the paper, with one page."),
    "animate": ("dwmr.cli.animate", "animate", "Write a run as a film, GIF or MP4."),
    "report": ("dwmr.cli.run", "report", "Write one HTML page with tables and interactive plots."),
    "compare": ("dwmr.cli.repetitions", "compare", "Compare control laws, with confidence intervals."),
    "bench": ("dwmr.cli.repetitions", "bench", "Tune control laws equally, and compare them on held-out runs."),
    "identify": ("dwmr.cli.identify", "identify", "Identify a robot's parameters from a log."),
    "sweep": ("dwmr.cli.repetitions", "sweep", "Run a scenario many times with varied values."),
}


@click.group(
    cls=Program,
    groups={"Commands": dict(sorted(COMMANDS.items()))},
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(package_name="fuzzyctl")
def main() -> None:
    """Simulate formations of mobile robots under sliding mode control.

    \b
    dwmr show                            the shipped scenarios
    dwmr show paper                      a summary of one
    dwmr new mine                        a scenario of your own
    dwmr check mine.toml                 list its mistakes
    dwmr run paper                       the paper's run
    dwmr run paper --controller all      all control laws, compared with Table 12
    dwmr new --rules my-rules            rule files of your own
    dwmr run paper --rules my-rules      the same run with these
    dwmr run paper --set rules.ais_reaction.k_s=0.5 --set run.horizon=60
    dwmr figures paper -o figures        counterparts of Figs. 8 to 28
    dwmr figures experiment -o figures   counterparts of Figs. 29 to 39
    dwmr paper -o paper                  all tables and figures of the paper
    dwmr animate paper -o run.gif        the run as a film
    dwmr run mine.toml --beside log.csv  a run beside real robots
    dwmr identify log.csv -o mine.toml   a robot's mass, friction, lag
    dwmr report paper --controller all   tables and plots on one HTML page
    dwmr compare paper --runs 20         laws with confidence intervals
    dwmr bench paper                     laws after equal tuning
    dwmr sweep spec.toml                 many runs, on all processors
    """
