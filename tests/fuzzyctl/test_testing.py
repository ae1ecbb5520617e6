import dataclasses
import math

import pytest

from fuzzyctl import ArgumentError, Block
from fuzzyctl.testing import CommandResult, check_text, run_command


def test_a_text_is_checked_with_its_name_and_folder(base, tmp_path):
    (block,), diagnostics = check_text(base)
    assert isinstance(block, Block)
    assert diagnostics == []
    blocks, mistakes = check_text("[System]\nName='x'\nType='mandani'\n", "a.fis")
    assert blocks == ()
    assert {d.file for d in mistakes} == {"a.fis"}
    table = base[: base.index("       N  P")].replace("x x y", 'x x y from "cells.csv"')
    (tmp_path / "cells.csv").write_text(",N,P\nN,N,Z\nZ,N,P\nP,Z,P\n", encoding="utf-8")
    assert check_text(table)[0] == ()
    assert check_text(table, folder=tmp_path)[1] == []
    assert check_text(table, folder=str(tmp_path))[1] == []
    with pytest.raises(ArgumentError, match="expected a text"):
        check_text(base.encode())


def test_a_claim_is_refuted_unless_told_otherwise(base):
    claim = base + "\nrequire u <= -3\n"
    assert [d.severity for d in check_text(claim)[1]] == ["error"]
    assert check_text(claim, guarantees=False)[1] == []


def test_a_command_gives_its_exit_code_and_both_streams(base, tmp_path):
    (tmp_path / "base.fz").write_text(base, encoding="utf-8")
    result = run_command("eval", "base.fz", "x=0", "y=5", folder=tmp_path)
    assert (result.exit_code, result.errors) == (0, "")
    assert result.output.startswith("u = ")
    assert run_command("check", "-", stdin=base).exit_code == 0
    wrong = run_command("check", "absent.fz", folder=tmp_path)
    assert (wrong.exit_code, wrong.output) == (1, "")
    assert "absent.fz" in wrong.errors


def test_an_exception_of_a_command_is_raised(monkeypatch):
    def broken(*_, **__):
        raise ZeroDivisionError

    monkeypatch.setattr("click.echo", broken)
    with pytest.raises(ZeroDivisionError):
        run_command("explain", "FZ203")


def test_results_behave_as_dataclasses_of_the_standard_library():
    """As all frozen dataclasses of the package, whose methods are shared."""
    fields = [("exit_code", int), ("output", str), ("errors", str)]
    standard = dataclasses.make_dataclass("CommandResult", fields, frozen=True)

    def behaviour(kind):
        a, b, c, d = kind(0, "a", ""), kind(0, "a", ""), kind(0, "a", "c"), kind(math.nan, "a", "")
        seen = [a == b, a == c, a == (0, "a", ""), d == d, repr(a), hash(a), len({a, b, c})]
        with pytest.raises(dataclasses.FrozenInstanceError) as refused:
            a.output = "b"
        return [*seen, str(refused.value)]

    assert behaviour(CommandResult) == behaviour(standard)
