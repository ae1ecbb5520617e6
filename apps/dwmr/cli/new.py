"""`dwmr new NAME`: a new scenario, based on a shipped one."""

from __future__ import annotations

import re
from contextlib import nullcontext
from pathlib import Path

import click

from dwmr.cli.common import mistakes_as_diagnostics
from fuzzyctl.cli.streams import say

#: What a name may be: it becomes the name of a file.
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,99}")


@click.command(context_settings={"show_default": True})
@click.argument("name", required=False)
@click.option("--from", "base", default="paper", metavar="SCENARIO", help="Shipped scenario to start from.")
@click.option(
    "--extends",
    is_flag=True,
    help="Write only the name and what it extends, instead of a whole copy.",
)
@click.option(
    "-o",
    "--output",
    "path",
    type=click.Path(path_type=Path),
    show_default="NAME.toml",
    metavar="FILE",
    help="File to write.",
)
@click.option(
    "--rules",
    "folder",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Copy the rule files that the shipped scenario uses to this folder, for --rules of other commands.",
)
@click.option("--force", is_flag=True, help="Replace files that exist.")
def new(name: str | None, base: str, extends: bool, path: Path | None, folder: Path | None, force: bool) -> None:
    """Write a scenario NAME to start from: a copy of a shipped one with all its comments.

    A CSV file that the shipped scenario reads is written beside it. NAME may be left out with --rules.
    """
    from dwmr.config.shipped import shipped_names
    from dwmr.scenario import template
    from dwmr.scenario.file import UnknownScenarioError
    from fuzzyctl.support.writing import folder_for, write_together

    if name is None and (folder is None or path is not None or extends):
        raise click.UsageError("NAME is missing; only --rules DIR works without it")
    if name is not None and not NAME.fullmatch(name):
        raise click.BadParameter(
            "a name has up to 100 letters, digits, - and _, and begins with a letter or a digit", param_hint="'NAME'"
        )
    if name in shipped_names():
        raise click.BadParameter(f"{name} is the name of a shipped scenario; take another one", param_hint="'NAME'")
    try:
        files = template.files(name, base, path or Path(f"{name}.toml"), extends) if name is not None else {}
        files |= template.rule_files(base, folder) if folder is not None else {}
    except UnknownScenarioError as error:
        raise click.BadParameter(str(error), param_hint="'--from'") from error
    with mistakes_as_diagnostics("text"):
        template.refuse_present(files, force, folder)
        with folder_for(folder) if folder is not None else nullcontext():
            write_together(files)
    for one in files:
        say(f"wrote {one}")
