"""Dialect of an FCL file: the tool that it was written for, and the profile of its numerics."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Literal

from fuzzyctl.expr import Number
from fuzzyctl.formats.fll.methods import profile_of_version, version_said
from fuzzyctl.model.profiles import PROFILES, Profile
from tests.oracles.fcl.names import FUZZYLITE_ONLY, JFUZZYLOGIC_ONLY, JFUZZYLOGIC_SHAPES, fuzzylite_word
from tests.oracles.fcl.parser import FclFile
from tests.oracles.fcl.syntax import FunctionBlock, Setting, Word

DialectName = Literal["standard", "jfuzzylogic", "fuzzylite"]

#: A comment by which `write` says whose numerics the system has.
_NUMERICS: Final = re.compile(r"numerics of (\w+)")

#: Comments of files for fuzzylite: its own, and the one of `write`, whose file may have none of fuzzylite's words.
_FUZZYLITE_SIGNS: Final = ("generated with fuzzylite", "in the dialect of fuzzylite")

#: The numerics of a dialect, where no comment says others.
USUAL_NUMERICS: Final[dict[DialectName, str]] = {
    "standard": "exact",
    "jfuzzylogic": "jfuzzylogic",
    "fuzzylite": "fuzzylite",
}


@dataclass(frozen=True)
class Dialect:
    """The dialect of a file.

    Args:
        name: Whose words it uses.
        numerics: How the system is evaluated.
    """

    name: DialectName
    numerics: Profile


def dialect_of(file: FclFile) -> Dialect:
    """Return the dialect of a file, by its words and by its comments; without any sign the standard's."""
    name = _name(file)
    said = [m.group(1) for c in file.comments for m in _NUMERICS.finditer(c)]
    known = [n for n in said if n in PROFILES]
    if not known and name == "fuzzylite":
        return Dialect(name, profile_of_version(version_said(file.comments)))
    return Dialect(name, PROFILES[known[0] if known else USUAL_NUMERICS[name]])


def _name(file: FclFile) -> DialectName:
    said = " ".join(c for c in file.comments if not _NUMERICS.search(c)).lower()
    words = list(_words(file))
    signed = any(sign in said for sign in _FUZZYLITE_SIGNS)
    if signed or any(w.upper in FUZZYLITE_ONLY for w in words) or _of_fuzzylite(file):
        return "fuzzylite"
    of_jfuzzylogic = any(w.upper in JFUZZYLOGIC_ONLY for w in words) or any(
        kind.upper in JFUZZYLOGIC_SHAPES or kind.upper in ("FUNCTION", "SINGLETONS") for kind in _kinds(file)
    )
    slashes = any(c.startswith(("//", "/*")) and not _NUMERICS.search(c) for c in file.comments)
    return "jfuzzylogic" if of_jfuzzylogic or slashes or "jfuzzylogic" in said else "standard"


def _kinds(file: FclFile) -> Iterator[Word]:
    """Yield the words behind `TERM name :=`."""
    for block in file.blocks:
        for fuzzy in block.fuzzy:
            yield from (t.shape.kind for t in fuzzy.terms if t.shape.kind is not None)


def _of_fuzzylite(file: FclFile) -> bool:
    if any(fuzzylite_word(k.text) is not None for k in _kinds(file)):
        return True
    return any(
        s.keyword.upper in ("LOCK", "ENABLED")
        or (s.keyword.upper == "DEFAULT" and (len(s.values) > 1 or _is_nan(s.values[0])))
        for block in file.blocks
        for s in _settings(block)
    )


def _is_nan(value: object) -> bool:
    return isinstance(value, Number) and value.value != value.value


def _settings(block: FunctionBlock) -> Iterator[Setting]:
    for fuzzy in block.fuzzy:
        yield from fuzzy.settings
    for rules in block.rules:
        yield from rules.settings


def _words(file: FclFile) -> Iterator[Word]:
    """Yield the values of settings that are words."""
    for block in file.blocks:
        for setting in _settings(block):
            yield from (v for v in setting.values if isinstance(v, Word))
