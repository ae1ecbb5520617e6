"""Commands of pages, run within this process: most of the time of a process of its own is spent on imports."""

from __future__ import annotations

import re
import shlex
import traceback
from collections.abc import Mapping
from pathlib import Path

from click.testing import CliRunner

from dwmr.cli.main import main as dwmr
from fuzzyctl.cli.main import main as fuzzyctl

PROGRAMS = {"fuzzyctl": fuzzyctl, "dwmr": dwmr}

#: Commands that start processes of their own, which spend seconds on imports; before a release they do.
SWEEPS = (("dwmr", ["sweep"]), ("dwmr", ["compare"]), ("fuzzyctl", ["sweep"]))

#: A command with what a shell does for it: values of variables before it, and a file that takes one of its streams.
_FORM = re.compile(r"(?P<values>(?:[A-Z_]+=[\w./]* )*)(?P<words>.*?)(?: (?P<stream>2?)> (?P<file>[\w.-]+))?")

#: What only a shell or a process of its own does: operators of the shell, and what is said about the process.
_OF_A_PROCESS = re.compile(r"[|;&<>$*`~#?]|\bdoctor\b")


def run_here(command: str, environment: Mapping[str, str]) -> tuple[int, str] | None:
    """Run a command of the project in the current folder.

    Returns:
        The exit code and what it prints, both streams in order; None for a command that needs a shell.
    """
    form = _FORM.fullmatch(command)
    if form is None or form["words"].partition(" ")[0] not in PROGRAMS or _OF_A_PROCESS.search(form["words"]):
        return None
    environment = {**environment, **dict(value.split("=") for value in form["values"].split())}
    name, *arguments = shlex.split(form["words"])
    if (name, arguments[:1]) in SWEEPS and not {"--jobs", "--dask", "--help"}.intersection(arguments):
        arguments += ["--jobs", "1"]
    done = CliRunner(env=environment).invoke(PROGRAMS[name], arguments, prog_name=name)
    unexpected = done.exception is not None and not isinstance(done.exception, SystemExit)
    said = "".join(traceback.format_exception(done.exception)) if unexpected else ""
    if form["file"] is None:
        return done.exit_code, done.output + said
    kept, shown = (done.stderr, done.stdout) if form["stream"] else (done.stdout, done.stderr)
    Path(form["file"]).write_text(kept, encoding="utf-8")
    return done.exit_code, shown + said
