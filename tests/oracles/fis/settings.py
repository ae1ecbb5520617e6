"""Section `[System]` of a `.fis` file: tool, type and methods."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from fuzzyctl.formats.common.report import Findings, meant
from fuzzyctl.formats.fll.methods import version_said
from tests.oracles.fis import values, vocabulary
from tests.oracles.fis.sections import Entry, Section, Sections
from tests.oracles.fis.vocabulary import Dialect

_KEYS: Final = (
    "Name", "Type", "Version", "NumInputs", "NumOutputs", "NumRules",
    "AndMethod", "OrMethod", "ImpMethod", "AggMethod", "DefuzzMethod",
)  # fmt: skip

#: Types of systems; the last three are fuzzylite's.
_TYPES: Final = ("mamdani", "sugeno", "tsukamoto", "inverse tsukamoto", "hybrid")

#: What fuzzyctl writes into files whose numerics are not MATLAB's.
_SAID: Final = re.compile(r"% numerics of (octave|octave_0_4|fuzzylite|fuzzylite_6|pyfuzzylite|matlab)$")

#: Keys of variables that only fuzzylite writes.
_FUZZYLITE_KEYS: Final = frozenset({"enabled", "default", "lock", "lockvalid", "lockprevious", "lockrange"})


@dataclass(frozen=True)
class Settings:
    """What `[System]` says.

    Args:
        name: Name of the system.
        kind: One of the types.
        norms: The norms of a `Method`, by field.
        defuzzifier: Its kind, as the model calls it.
        entry: Where the defuzzifier is named, None where it is the usual one.
    """

    name: str
    kind: str
    norms: dict[str, Any]
    defuzzifier: str
    entry: Entry | None

    @property
    def weighted(self) -> bool:
        """Whether the defuzzifier sums over rules."""
        return self.defuzzifier.startswith("weighted")


def profile_of(file: Sections) -> str | None:
    """Return the profile that a comment of fuzzyctl names."""
    return next((m.group(1) for c in file.comments if (m := _SAID.match(c)) is not None), None)


def family(profile: str) -> Dialect:
    """Return whose dialect goes with a profile."""
    if profile.startswith("octave"):
        return "octave"
    return "fuzzylite" if "fuzzylite" in profile else "matlab"


def dialect_of(file: Sections, hedged: bool) -> Dialect:
    """Tell who wrote a file; without a sign of another tool it is MATLAB.

    Args:
        file: The file.
        hedged: Whether rules have hedges, which MATLAB does not know.
    """
    said = profile_of(file)
    if said is not None:
        return family(said)
    entries = [e for s in file.sections for e in s.entries if s.kind != "rules"]
    if any("generated" in c.lower() and "fuzzylite" in c.lower() for c in file.comments):
        return "fuzzylite"
    if any(e.key.lower() in _FUZZYLITE_KEYS for e in entries) or fuzzylite_version(file) is not None:
        return "fuzzylite"
    functions = (e.value.text.partition(":")[2].strip().lower() for e in entries if e.key.lower().startswith("mf"))
    if any(f[1:].startswith(tuple(vocabulary.OF_FUZZYLITE)) for f in functions):
        return "fuzzylite"
    comments = " ".join(file.comments).lower()
    methods = {e.value.text.strip("'\" ").lower() for e in entries if e.key.lower().endswith("method")}
    if hedged or "fuzzy-logic-toolkit" in comments or "octave" in comments or methods & vocabulary.BEYOND_MATLAB:
        return "octave"
    return "matlab"


def fuzzylite_version(file: Sections) -> int | None:
    """Return fuzzylite's major version, which its files give where MATLAB's have 1.0 or 2.0."""
    said = version_said(file.comments)
    if said is not None:
        return said
    for section in file.of("system"):
        entry = section.entry("Version")
        match = re.match(r"'?([0-9]{1,3})", entry.value.text) if entry is not None else None
        if match is not None and int(match.group(1)) >= 3:
            return int(match.group(1))
    return None


def read_settings(file: Sections, section: Section, findings: Findings) -> Settings:
    """Return what a section `[System]` says; what it does not say is as in MATLAB."""
    _check_keys(section, findings)
    kind = _kind(section, findings)
    sugeno = kind != "mamdani" and kind != "hybrid"
    name = section.entry("Name")
    aggregations = dict(vocabulary.AGGREGATION_WORDS)
    version = fuzzylite_version(file)
    if version is not None and version < 6:
        aggregations["sum"] = "probabilistic_sum"  # its exporter called the algebraic sum so
    entry = section.entry("DefuzzMethod")
    usual = "weighted_average" if sugeno else "centroid"

    def method(key: str, known: Mapping[str, str], otherwise: str) -> str:
        return _method(section.entry(key), known, otherwise, findings)

    return Settings(
        name=values.string(name).text if name is not None else "",
        kind=kind,
        norms={
            "conjunction": method("AndMethod", vocabulary.CONJUNCTION_WORDS, "product" if sugeno else "min"),
            "disjunction": method("OrMethod", vocabulary.DISJUNCTION_WORDS, "probabilistic_sum" if sugeno else "max"),
            "implication": method("ImpMethod", vocabulary.CONJUNCTION_WORDS, "product" if sugeno else "min"),
            "aggregation": method("AggMethod", aggregations, "sum" if sugeno else "max"),
        },
        defuzzifier=method("DefuzzMethod", vocabulary.DEFUZZIFIER_WORDS, usual),
        entry=entry,
    )


def _check_keys(section: Section, findings: Findings) -> None:
    seen: dict[str, Entry] = {}
    known = {k.lower() for k in _KEYS}
    for entry in section.entries:
        key = entry.key.lower()
        earlier = seen.setdefault(key, entry)
        if earlier is not entry:
            findings.given_twice(f"'{entry.key}'", entry.key_span, earlier.span)
        elif key.startswith("typered"):
            message = f"'{entry.key}' belongs to type-2 systems"
            findings.error("FZ602", message, entry.span, help="only type-1 systems are computed")
        elif key not in known:
            help_text = meant(entry.key, _KEYS) or f"keys of [System]: {', '.join(_KEYS)}"
            findings.warning("FZ603", f"nothing reads '{entry.key}'", entry.key_span, help=help_text)


def _kind(section: Section, findings: Findings) -> str:
    entry = section.entry("Type")
    if entry is None:
        return "mamdani"
    kind = values.string(entry).text.lower().replace("-", " ")
    if kind in _TYPES:
        return kind
    if "2" in kind:
        message = f"'{kind}' is a type-2 system"
        findings.error("FZ602", message, entry.value, help="only type-1 systems are computed")
    else:
        message = f"there is no type '{kind[:40]}'"
        findings.error("FZ602", message, entry.value, help=f"types: {', '.join(_TYPES)}")
    return "mamdani"


def _method(entry: Entry | None, known: Mapping[str, str], otherwise: str, findings: Findings) -> str:
    """Return a method as the model calls it; an empty one, as fuzzylite writes for none, is the usual one."""
    if entry is None:
        return otherwise
    word = values.string(entry).text
    if not word:
        return otherwise
    plain = word.lower()
    if plain in known:
        return known[plain]
    message = f"there is no {entry.key} '{word[:40]}'"
    help_text = meant(plain, known) or "a method of one's own is a program, which cannot be read here"
    findings.error("FZ602", message, entry.value, help=help_text, facts=(f"methods: {', '.join(known)}",))
    return otherwise
