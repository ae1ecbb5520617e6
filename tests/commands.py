"""The commands of a program, imported, and `fuzzyctl` run within this process."""

from click.testing import CliRunner

from fuzzyctl.cli.main import main


def commands_of(program):
    """Return the commands of a program by name; none for a single command."""
    if not hasattr(program, "list_commands"):
        return {}
    return {name: program.get_command(None, name) for name in program.list_commands(None)}


def runner(*words, **environment):
    """Return a function that runs `fuzzyctl WORDS ARGUMENTS` within this process."""

    def run(*arguments, stdin=None, color=False):
        cli = CliRunner(env=environment)
        return cli.invoke(main, [*words, *map(str, arguments)], input=stdin, color=color)

    return run
