"""Loader of other tools' files: errors of a rule file that are usual there become warnings."""

from __future__ import annotations

import dataclasses
import re
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.common.ranges import is_read_by_consequents
from fuzzyctl.formats.registry import Format
from fuzzyctl.model.checks.checks import check_model, in_order
from fuzzyctl.model.checks.terms import BY_AVERAGE
from fuzzyctl.model.system import FuzzySystem

#: Errors of rule files that are warnings in files of other tools, where the system still has a meaning.
LENIENT: Final = frozenset({"FZ210"})

#: Hints that say nothing about files of other tools: ranges of their outputs bound no consequent.
_MEANT: Final = frozenset({"FZ306"})

#: By format the setting that makes an average of a centroid of numbers.
_AVERAGES: Final = {
    "fis": "write: Type='sugeno' and DefuzzMethod='wtaver'",
    "fll": "write: defuzzifier: WeightedAverage",
}

#: The part of a help that names a line of rule files.
_ALLOW: Final = re.compile(r"write '(allow FZ\d+)'")


def examine_foreign(format: Format, source: SourceText) -> tuple[tuple[FuzzySystem, ...], list[Diagnostic]]:
    """Read and check all systems of a file of another tool.

    Returns:
        The systems without errors, and all diagnostics in the order of their places.
    """
    systems, diagnostics = format.read(source)
    sound = []
    for system in systems:
        checks = [_softened(d, source, format) for d in check_model(system) if not _is_meant(d, system)]
        diagnostics = [*diagnostics, *checks]
        if not any(d.severity == "error" for d in checks):
            sound.append(system)
    if source.encoding:
        message = f"the file is not UTF-8; it is read as {source.encoding}"
        help_text = "save it as UTF-8 if names look wrong"
        diagnostics = [*diagnostics, Diagnostic("FZ605", message, None, "warning", help=help_text, file=source.name)]
    return tuple(sound), in_order(diagnostics)


def _is_meant(diagnostic: Diagnostic, system: FuzzySystem) -> bool:
    """Whether a hint is about a property that files of other tools have on purpose.

    An input without terms serves linear consequents only; its range need not be covered.
    """
    if diagnostic.code not in ("FZ211", "FZ309"):
        return diagnostic.code in _MEANT
    variable = next((v for v in system.inputs if v.span == diagnostic.span), None)
    if variable is None:
        return False
    return not variable.terms if diagnostic.code == "FZ309" else is_read_by_consequents(variable, system)


def _softened(diagnostic: Diagnostic, source: SourceText, format: Format) -> Diagnostic:
    severity = "warning" if diagnostic.code in LENIENT else diagnostic.severity
    # Helps with lines of a rule file do not suit a file of another format.
    help_text = "" if diagnostic.help.startswith("write: ") else diagnostic.help
    if help_text.startswith("from left to right it is: "):
        help_text = "give the numbers from left to right"
    if help_text == BY_AVERAGE:
        help_text = _AVERAGES.get(format.name, "")
    return dataclasses.replace(diagnostic, severity=severity, help=help_text, file=diagnostic.file or source.name)


def with_option(diagnostic: Diagnostic) -> Diagnostic:
    """Return a diagnostic whose help names an option of `check`, since other formats have no line `allow`."""
    return dataclasses.replace(diagnostic, help=_ALLOW.sub(r"check with '--\1'", diagnostic.help))
