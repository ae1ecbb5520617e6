"""Tools that write `.fis` files: how a file tells which one wrote it, and what it says in `[System]`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from fuzzyctl.formats.common.report import meant
from fuzzyctl.formats.common.translation import Translation
from fuzzyctl.formats.fis import values, vocabulary
from fuzzyctl.formats.fis.sections import Entry, Section, Sections
from fuzzyctl.formats.fis.vocabulary import Dialect
from fuzzyctl.formats.fll.methods import profile_of_version, version_said
from fuzzyctl.model.profiles import Profile, profile

#: What fuzzyctl writes into files whose numerics are not MATLAB's.
_SAID: Final = re.compile(r"% numerics of (octave|octave_0_4|fuzzylite|fuzzylite_6|pyfuzzylite|matlab)$")

#: Keys of variables that only fuzzylite writes.
_FUZZYLITE_KEYS: Final = frozenset({"enabled", "default", "lock", "lockvalid", "lockprevious", "lockrange"})


def _profile_said(file: Sections) -> str | None:
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
    said = _profile_said(file)
    if said is not None:
        return family(said)
    entries = [e for s in file.sections for e in s.entries if s.kind != "rules"]
    comments = " ".join(file.comments).lower()
    functions = (e.value.text.partition(":")[2].strip().lower() for e in entries if e.key.lower().startswith("mf"))
    if (
        any("generated" in c.lower() and "fuzzylite" in c.lower() for c in file.comments)
        or any(e.key.lower() in _FUZZYLITE_KEYS for e in entries)
        or fuzzylite_version(file) is not None
        or any(f[1:].startswith(tuple(vocabulary.OF_FUZZYLITE)) for f in functions)
    ):
        return "fuzzylite"
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


def numerics(file: Sections, dialect: Dialect) -> Profile:
    """Return how the tool computes that wrote a file, if no comment names other numerics."""
    said = _profile_said(file)
    if said is None and dialect == "fuzzylite":
        return profile_of_version(fuzzylite_version(file))
    return profile(said or dialect)


def check_keys(section: Section, known: Mapping[str, str], translation: Translation) -> None:
    """Report keys that are given twice, and warn of those that have no effect; `known` has them in small letters."""
    seen: dict[str, Entry] = {}
    for entry in section.entries:
        key = entry.key.lower()
        if values.NUMBERED.match(key):
            continue
        earlier = seen.setdefault(key, entry)
        if earlier is not entry:
            translation.given_twice(f"'{entry.key}'", entry.key_span, earlier.span)
        elif key.startswith("typered"):
            message = f"'{entry.key}' belongs to type-2 systems"
            translation.error("FZ602", message, entry.span, help="only type-1 systems are computed")
        elif key not in known:
            listed = [k for k in known.values() if k]
            help_text = meant(entry.key, listed) or f"keys of [{section.kind.title()}]: {', '.join(listed)}"
            translation.warning("FZ603", f"'{entry.key}' has no effect", entry.key_span, help=help_text)


def kind_of(section: Section, translation: Translation) -> str:
    """Return the type of a system."""
    entry = section.entry("Type")
    if entry is None:
        return "mamdani"
    word = values.string(entry).text.lower().replace("-", " ")
    help_text = "only type-1 systems are computed" if "2" in word else ""
    found = translation.look_up(entry.value, vocabulary.TYPES, "type", word=word, otherwise=help_text)
    return found or "mamdani"


def method(entry: Entry | None, known: Mapping[str, str], usual: str, translation: Translation) -> str:
    """Return a method as the model calls it; an empty one, as fuzzylite writes for none, is the usual one."""
    word = values.string(entry).text.lower() if entry is not None else ""
    if entry is None or not word:
        return usual
    otherwise = "a method of your own is a program, which cannot be read here"
    return translation.look_up(entry.value, known, entry.key, word=word, otherwise=otherwise) or usual
