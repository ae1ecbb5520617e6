"""`dwmr new NAME`: a new scenario, based on a shipped one."""

from __future__ import annotations

import re
from contextlib import nullcontext
from pathlib import Path

import click

from dwmr.cli.common import mistakes_as_diagnostics, refuse_present
from dwmr.control.rule_files import LAWS
from dwmr.scenario.file import SHIPPED, UnknownScenarioError, read, shipped_names
from fuzzyctl.cli.streams import say
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.loading.assembly import files_read
from fuzzyctl.support.shipped import rules_folder
from fuzzyctl.support.writing import folder_for, write_together

#: Valid names, which become names of files.
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
    if name is None and (folder is None or path is not None or extends):
        raise click.UsageError("NAME is missing; only --rules DIR works without it")
    if name is not None and not NAME.fullmatch(name):
        raise click.BadParameter(
            "a name has up to 100 letters, digits, - and _, and begins with a letter or a digit", param_hint="'NAME'"
        )
    if name in shipped_names():
        raise click.BadParameter(f"{name} is the name of a shipped scenario; take another one", param_hint="'NAME'")
    try:
        files = _files(name, base, path or Path(f"{name}.toml"), extends) if name is not None else {}
        files |= _rule_files(base, folder) if folder is not None else {}
    except UnknownScenarioError as error:
        raise click.BadParameter(str(error), param_hint="'--from'") from error
    with mistakes_as_diagnostics("text"):
        refuse_present(files, force, folder)
        with folder_for(folder) if folder is not None else nullcontext():
            write_together(files)
    for one in files:
        say(f"wrote {one}")


def _files(name: str, base: str, path: Path, extends: bool) -> dict[Path, str]:
    """Return the texts to write by path: the scenario first, then the CSV file that it reads.

    Args:
        name: The scenario's name.
        base: Name of the shipped scenario to start from.
        path: Where the scenario goes.
        extends: Whether it extends the shipped one instead of copying it.

    Raises:
        UnknownScenarioError: When there is no such shipped scenario.
    """
    _require_shipped(base)
    if extends:
        return {path: _EXTENDING.format(base=base, name=name)}
    text = (SHIPPED / f"{base}.toml").read_text(encoding="utf-8")
    renamed = re.sub(r'^name = ".*"$', f'name = "{name}"', text, count=1, flags=re.MULTILINE)
    beside = getattr(read(SHIPPED / f"{base}.toml").scenario.reference, "file", None)
    if beside is not None:
        renamed = renamed.replace(beside, f"{path.stem}.csv")
    head = f"# Made by `dwmr new` from {base}; `dwmr check {path.name}` finds mistakes.\n#\n"
    files = {path: head + renamed}
    if beside is not None:
        files[path.with_suffix(".csv")] = (SHIPPED / beside).read_text(encoding="utf-8")
    return files


def _rule_files(base: str, folder: Path) -> dict[Path, str]:
    """Return copies of the rule files that a shipped scenario and the control laws use, by their path in a folder.

    Raises:
        UnknownScenarioError: When there is no such shipped scenario.
    """
    _require_shipped(base)
    named = read(SHIPPED / f"{base}.toml").scenario.rules.values()
    paths = {rules_folder() / name for name in (*(rule.file for rule in named), *LAWS.values())}
    paths |= {used for path in paths for used in files_read(path)}
    return {folder / path.name: path.read_text(encoding="utf-8") for path in sorted(paths)}


def _require_shipped(base: str) -> None:
    if base not in shipped_names():
        hint = did_you_mean(base, shipped_names())
        message = f"no shipped scenario {base[:200]!r}; there are {', '.join(shipped_names())}"
        raise UnknownScenarioError(message + (f"; {hint}" if hint else ""))


_EXTENDING = """\
# {name}: {base} with other values.
#
# What stands here replaces the value of {base}, key by key; lists such as obstacles are replaced whole. `dwmr show
# {base}` prints what it says.

extends = "{base}"
name = "{name}"

[run]
# horizon = 60.0                    # s
"""
