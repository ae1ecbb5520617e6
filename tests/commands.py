"""The commands of a program, imported."""


def commands_of(program):
    """Return the commands of a program by name; none for a single command."""
    if not hasattr(program, "list_commands"):
        return {}
    return {name: program.get_command(None, name) for name in program.list_commands(None)}
