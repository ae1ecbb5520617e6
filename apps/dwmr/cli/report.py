"""`dwmr report SCENARIO`: one HTML page with tables and interactive plots."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics
from fuzzyctl.cli.streams import interrupts_wait, say, terminated_as_interrupted


@click.command(context_settings={"show_default": True})
@click.argument("scenario")
@run_options.output_option("path", "report.html", "FILE", "HTML page to write; one that exists is replaced.")
@run_options.controller_option
@run_options.rules_option
@run_options.set_option
def report(
    scenario: str, path: Path, controller: str | None, rules_folder: Path | None, overrides: tuple[str, ...]
) -> None:
    """Run SCENARIO, a shipped name or a TOML file, and write one HTML page about it.

    The page holds tables, settings and interactive plots, and opens without a network.
    """
    with mistakes_as_diagnostics("text"), terminated_as_interrupted():
        task = run_options.read(scenario, rules_folder, overrides)
        finished = _report(task, run_options.laws_of(task, controller), path)
    if not finished:
        sys.exit(1)


def _report(task: run_options.Task, names: tuple[str, ...], path: Path) -> bool:
    """Check, run and write; return whether every run came to its end."""
    from fuzzyctl.experiments.result_files import one_file

    run_options.check(task, names)
    with one_file(path) as files:
        trajectories = run_options.simulate(task, names)
        if len(trajectories) < len(names) or any(t.stop and t.stop.reason == "interrupted" for t in trajectories):
            raise KeyboardInterrupt
        with interrupts_wait():
            from dwmr.output.summary import describe
            from dwmr.page.document import page
            from dwmr.results.metrics import measure

            summary = describe(task.file, task.rules, task.overrides)
            summary["controllers"] = {t.controller: measure(t, task.file.scenario) for t in trajectories}
            text = page(summary, trajectories, task.file.scenario)
            files.write(path.name, lambda part: _write(part, text))
            files.publish()
    run_options.say_stops(trajectories)
    say(f"wrote {path}: {len(text.encode()) / 1e6:.1f} MB")
    return all(t.stop is None for t in trajectories)


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
