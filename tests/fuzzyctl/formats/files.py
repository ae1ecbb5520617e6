"""Files of other tools, read and written as the tests of formats need it."""

from pathlib import Path

from fuzzyctl import dumps
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.registry import FORMATS
from fuzzyctl.loading.load import examine_all

#: Whole files as people and tools write them, by name.
SAMPLES = {
    p.name: p.read_text(encoding="utf-8")
    for p in sorted(Path(__file__).parent.rglob("*.*"))
    if p.suffix[:2] in (".f", ".x")
}


def examined(name, text):
    """Return the first system of a text without errors, else None, and all diagnostics; `name` or its suffix."""
    systems, diagnostics = examine_all(SourceText(name if "." in name else f"t.{name}", text))
    return (systems[0] if systems else None), diagnostics


def read(name, text):
    """Return the first system of a text without errors."""
    system, diagnostics = examined(name, text)
    assert system is not None, "\n".join(map(str, diagnostics))
    return system


def lines(name, text):
    """Return the lines of a text as a rule file, without indents."""
    return [line.strip() for line in dumps(read(name, text)).splitlines()]


def rules(name, text):
    return [line for line in lines(name, text) if line.startswith("if ")]


def head(name, text):
    """Return the settings of a system as a rule file has them, by their words."""
    settings = (line.split(maxsplit=1) for line in lines(name, text) if line)
    return {words[0]: words[1] for words in settings if words[0] in SETTINGS and len(words) > 1}


SETTINGS = ("semantics", "and", "or", "implication", "aggregation", "activation", "defuzzifier")


def said(name, text, *severities):
    """Return code, line and column of the diagnostics of a reader, those of some severities if any are given."""
    _, found = FORMATS[name].read(SourceText(f"t.{name}", text))
    found = [d for d in found if d.severity in (severities or ("error", "warning"))]
    return [(d.code, d.span.line, d.span.column) if d.span else (d.code, 0, 0) for d in found]


def errors(name, text):
    return [d for d in examined(name, text)[1] if d.severity == "error"]


def write(format, system):
    """Return the text of a system, and the parts whose loss changes numbers."""
    text, losses = FORMATS[format].write(system)
    return text, [loss.what for loss in losses if not loss.exact]


def replaced(text, *pairs):
    """Return a text with parts replaced, which it must have."""
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new)
    return text


#: A small file of fuzzylite that tests vary.
SMALL = SAMPLES["small.fll"]
