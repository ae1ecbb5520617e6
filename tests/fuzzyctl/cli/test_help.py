"""Help fits a terminal of 80 columns, and no summary is cut."""

import re
import shlex
from pathlib import Path
from textwrap import dedent

import click
import pytest
from click.testing import CliRunner

from dwmr.cli.main import main as dwmr
from tests.commands import commands_of, main

COMMANDS = [(program, name) for program in (main, dwmr) for name in ("", *commands_of(program))]


@pytest.mark.parametrize(("program", "name"), COMMANDS)
def test_help_fits_80_columns(program, name):
    result = CliRunner().invoke(program, [*([name] if name else []), "--help"], env={"COLUMNS": "80"})
    assert result.exit_code == 0
    assert [line for line in result.output.splitlines() if len(line) > 80] == []


@pytest.mark.parametrize("program", [main, dwmr], ids=["fuzzyctl", "dwmr"])
def test_no_summary_of_a_command_is_cut_or_ends_at_an_abbreviation(program):
    shown = CliRunner().invoke(program, ["--help"], env={"COLUMNS": "80"}).output
    headings = {"Commands", *program.groups}
    sections = [shown.partition(f"\n{heading}:\n")[2].partition("\n\n")[0] for heading in headings]
    lines = [line for section in sections for line in section.splitlines()]
    assert len(lines) == len(commands_of(program))
    for line in lines:
        assert line.endswith(".")
        assert not line.endswith(("...", "Figs.", "Eqs.", "Table.", "e.g."))


def test_one_option_names_the_file_to_write():
    options = [o for c in commands_of(main).values() for o in c.params if isinstance(o, click.Option)]
    assert {tuple(o.opts) for o in options if "-o" in o.opts or "--output" in o.opts} == {("-o", "--output")}


@pytest.mark.parametrize(
    ("program", "written", "meant"),
    [
        (main, "chek", "'check'"),
        (main, "plot-s", "'plot-surface'"),
        (main, "watch", "'check --watch'"),
        (main, "plot-terms", "'plot --terms'"),
        (main, "bounds", "'prove --bounds'"),
        (main, "diff", "'compare --changes'"),
        (dwmr, "runn", "'run'"),
    ],
)
def test_an_unknown_command_is_reported_with_the_one_most_like_it(program, written, meant):
    result = CliRunner().invoke(program, [written])
    assert result.exit_code == 2
    assert f"Error: No such command '{written}'; did you mean {meant}?\n" in result.output


def test_an_option_is_no_command():
    result = CliRunner().invoke(main, ["--chek"])
    assert result.exit_code == 2
    assert "No such option" in result.output


@pytest.mark.parametrize("name", ["", *sorted({*commands_of(main)} - {"lsp", "studio"})])
def test_examples_of_help_run_as_printed_in_an_empty_folder(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shown = CliRunner().invoke(main, [*([name] if name else []), "--help"], env={"COLUMNS": "80"}).output
    if not name:
        text = shown.partition("A rule file, tip.fz:\n")[2].partition("\n\n")[0]
        Path("tip.fz").write_text(dedent(text), encoding="utf-8")
    for piped, line in re.findall(r"^  +(?:printf (.*) \| )?(fuzzyctl [a-z-]+ .*?)(?:   .*)?$", shown, re.MULTILINE):
        if "--watch" not in line:  # until Ctrl-C
            rows = piped.strip('"').replace("\\n", "\n")
            done = CliRunner().invoke(main, shlex.split(line)[1:], input=rows)
            expected = "--changes" in line or "k_s=0.6" in line  # a difference; a refuted claim
            assert done.exit_code == expected, f"{line}\n{done.stderr}"
