"""Public names with their signatures, and the help of every command."""

import inspect
from importlib import import_module

import pytest
from click.testing import CliRunner

import fuzzyctl
from fuzzyctl.diagnostics.diagnostic import CODES
from tests.commands import commands_of
from tests.frozen.kept import check_kept

COMMANDS = {"fuzzyctl": "fuzzyctl.cli.main", "dwmr": "dwmr.cli.main"}


def signatures(name):
    """Yield a line for a public name and one for each public member that it defines itself."""
    thing = getattr(fuzzyctl, name)
    if not inspect.isclass(thing):
        yield f"{name}{inspect.signature(thing)}"
        return
    yield f"{name}{inspect.signature(thing.__init__)}"
    for member in sorted(vars(thing).keys() | vars(thing.__mro__[1]).keys()):
        if not member.startswith("_"):
            value = inspect.getattr_static(thing, member)
            yield f"  .{member}{inspect.signature(value) if inspect.isfunction(value) else ''}"


def test_public_names_are_as_kept():
    check_kept(
        "interface", "names", "".join(f"{line}\n" for name in sorted(fuzzyctl.__all__) for line in signatures(name))
    )


def test_diagnostic_codes_are_as_kept():
    check_kept("interface", "codes", "".join(f"{code} {title}\n" for code, title in CODES.items()))


def helps(main, command, path):
    """Yield the help of a command and of all its subcommands, as a terminal of 80 columns shows it."""
    shown = CliRunner(env={"COLUMNS": "80"}).invoke(main, [*path[1:], "--help"], prog_name=path[0])
    yield f"$ {' '.join(path)} --help\n{shown.output.rstrip()}\n\n"
    for name, inner in sorted(commands_of(command).items()):
        yield from helps(main, inner, [*path, name])


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_of_commands_is_as_kept(name):
    main = import_module(COMMANDS[name]).main
    check_kept("interface", name, "".join(helps(main, main, [name])))
