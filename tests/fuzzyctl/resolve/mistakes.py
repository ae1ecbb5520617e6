"""What tables of mistakes share: the errors that are found in a text."""

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import look_through


def errors_in(text, folder=None):
    """Return the errors of a text: code, message, and the text that each points at."""
    examined = look_through(SourceText("c.fz", text), folder=folder)
    return [(d.code, d.message, d.span.text if d.span else "") for d in examined.diagnostics if d.severity == "error"]


def repairs_in(text):
    """Return the repairs of the errors of a text."""
    return [d.help for d in look_through(SourceText("c.fz", text)).diagnostics if d.severity == "error"]


def require_one(text, expected):
    """Require a single error: its code, its message, the beginning of its location, a part of its repair if given."""
    code, message, location, *repair = expected
    ((found_code, found_message, found_location),) = errors_in(text)
    assert (found_code, found_message) == (code, message)
    assert found_location.startswith(location)
    assert repairs_in(text)[0] or code not in {"FZ217", "FZ303"}
    for part in repair:
        assert part in repairs_in(text)[0]
