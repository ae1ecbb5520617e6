"""'-' as a file, warnings that are printed once, and `--quiet`, for all commands."""

import pytest

from tests.commands import commands_of, main, runner

#: Each command that reads a rule file, with its other words.
COMMANDS = {
    "check": [],
    "show": [],
    "prove": [],
    "prove --bounds": [],
    "eval": ["x=0.5", "y=3"],
    "why": ["x=0.5", "y=3"],
    "page": ["-o", "x.html"],
    "plot --terms": ["-o", "terms.svg"],
    "plot": ["-o", "surface.svg", "--resolution", "5"],
    "plot-surface": ["-z", "u", "--resolution", "5", "-o", "surface.svg"],
    "codegen": ["--target", "python", "-o", "code"],
    "convert": ["out.fz"],
    "compare": ["--as", "exact,matlab", "--points", "50"],
}
#: Those that print the warnings of the file.
WARNING = [c for c in COMMANDS if c not in ("show", "prove")]
run = runner()


@pytest.fixture
def base(base, tmp_path, monkeypatch):
    """A file whose bounds are exact, so that no search goes on to its time limit."""
    monkeypatch.chdir(tmp_path)
    text = base.replace("\ninput x", "\nand product\ndefuzzifier center_average\n\ninput x", 1)
    (tmp_path / "a.fz").write_text(text)
    return text


@pytest.fixture
def spare(base, tmp_path):
    """A file with a warning: its param is not used."""
    (tmp_path / "spare.fz").write_text(base + "param spare = 0\nrequire u <= 2\n")


@pytest.mark.parametrize("command", COMMANDS)
def test_standard_input_gives_what_the_file_gives(tmp_path, base, command):
    from_file = run(*command.split(), "a.fz", *COMMANDS[command])
    (tmp_path / "out.fz").unlink(missing_ok=True)
    piped = run(*command.split(), "-", *COMMANDS[command], stdin=base)
    assert piped.exit_code == from_file.exit_code == 0
    assert piped.output.replace("<stdin>", "a.fz").replace("-  and", "a.fz  and").replace("- as", "a.fz as") == (
        from_file.output
    )


def test_standard_input_is_a_file_for_every_command_that_reads_one():
    # A sweep names its files, the language server is given texts, the studio serves until Ctrl-C, and a certificate is
    # a file that 'prove' writes.
    others = {"new", "explain", "doctor", "lsp", "studio", "sweep", "verify"}
    assert set(commands_of(main)) - others == {*(c.split()[0] for c in COMMANDS), "fmt", "simulate"}


def test_standard_input_uses_files_of_the_current_folder_and_is_named_in_diagnostics(tmp_path, base):
    head, rest = base.split("input y")
    (tmp_path / "part.fz").write_text("input y" + rest.split("output u")[0])
    text = f'{head}use "part.fz"\noutput u' + rest.split("output u")[1]
    assert run("check", "-", stdin=text).output == "<stdin>: base: 6 rules, no errors\n"
    assert "<stdin>:21:11: error[FZ203]" in run("check", "-", stdin=base.replace("N  Z", "N  Y", 1)).output


@pytest.mark.parametrize("command", ["check", "fmt"])
def test_standard_input_is_bounded_as_files_are(command):
    result = run(command, "-", stdin="#" * ((1 << 20) + 1))
    assert result.exit_code == 1
    assert "<stdin>: error[FZ003]: the file is larger than 1,048,576 bytes" in result.stderr


@pytest.mark.parametrize("command", WARNING)
def test_warnings_are_printed_once_and_not_if_the_command_is_quiet(spare, command):
    words = [*command.split(), "spare.fz", *COMMANDS[command]]
    assert run(*words).output.count("warning[FZ216]") == 1
    quiet = run(*words, *(["--force"] if command == "convert" else []), "-q")
    assert (quiet.exit_code, "warning" in quiet.output) == (0, False)


def test_warnings_of_a_file_that_is_given_twice_are_printed_once(spare):
    assert run("compare", "spare.fz", "spare.fz", "--points", "50").output.count("warning[FZ216]") == 1
    checked = run("check", "spare.fz", "spare.fz").output
    assert checked.count("warning[FZ216]") == checked.count("no errors") == 1
    assert "0 errors, 1 warning\n" in checked
    assert run("prove", "spare.fz", "spare.fz").output.count("proved: ") == 1
