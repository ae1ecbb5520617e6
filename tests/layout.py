"""Rule files as `fuzzyctl fmt` lays them out, within this process."""

from fuzzyctl.testing import run_command


def laid_out(text):
    """Return the layout of a text without syntax errors."""
    result = run_command("fmt", "-", stdin=text)
    assert result.exit_code == 0, result.errors
    return result.output
