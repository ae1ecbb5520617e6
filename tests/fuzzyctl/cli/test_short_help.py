"""The list of commands has a whole sentence for each."""

import pytest
from click.testing import CliRunner

from dwmr.cli.main import main as dwmr
from fuzzyctl.cli.main import main as fuzzyctl
from tests.commands import commands_of


@pytest.mark.parametrize("program", [fuzzyctl, dwmr], ids=["fuzzyctl", "dwmr"])
def test_no_line_is_cut_or_ends_at_an_abbreviation(program):
    shown = CliRunner().invoke(program, ["--help"], env={"COLUMNS": "80"}).output
    lines = shown.partition("Commands:\n")[2].partition("\n\n")[0].splitlines()
    assert len(lines) == len(commands_of(program))
    for line in lines:
        assert line.endswith(".")
        assert not line.endswith(("...", "Figs.", "Eqs.", "Table.", "e.g."))
