"""What the tests of blocks share: the mistakes that are found in a text."""

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import look_through


def errors_in(text, folder=None):
    """Return the errors of a text: code, message, and the text that each points at."""
    examined = look_through(SourceText("c.fz", text), folder=folder)
    return [(d.code, d.message, d.span.text if d.span else "") for d in examined.diagnostics if d.severity == "error"]


def repairs_in(text):
    """Return the repairs of the errors of a text."""
    return [d.help for d in look_through(SourceText("c.fz", text)).diagnostics if d.severity == "error"]
