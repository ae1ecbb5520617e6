"""Words and numerics of the tools that write `.fis` files, and the signs that tell them apart."""

from __future__ import annotations

import re
from decimal import Decimal
from typing import Final, Literal

from fuzzyctl.formats.fis.sections import Sections
from fuzzyctl.formats.fis.shapes import OF_FUZZYLITE
from fuzzyctl.formats.fll.methods import profile_of_version, version_said
from fuzzyctl.model.profiles import Profile, profile

Dialect = Literal["matlab", "octave", "fuzzylite"]

# --- words ---------------------------------------------------------------------------------------------------------


def _as_here(*words: str) -> dict[str, str]:
    """Return words that the model has, too."""
    return {word: word for word in words}


#: Triangular norms for `and` and implication.
CONJUNCTION_WORDS: Final = {
    "min": "min",
    "prod": "product",
    **_as_here("product", "bounded_difference", "drastic_product", "einstein_product"),
    **_as_here("hamacher_product", "nilpotent_minimum"),
}

#: Triangular conorms for `or`.
DISJUNCTION_WORDS: Final = {
    "max": "max",
    "probor": "probabilistic_sum",
    "algebraic_sum": "probabilistic_sum",
    "bounded_sum": "bounded_sum",
    "normalized_sum": "bounded_sum",  # (a + b) / max(1, a + b) is min(1, a + b)
    **_as_here("drastic_sum", "einstein_sum", "hamacher_sum", "nilpotent_maximum"),
}

AGGREGATION_WORDS: Final = {**DISJUNCTION_WORDS, "sum": "sum"}

#: Words of Octave's toolkit and of fuzzylite that MATLAB does not have.
BEYOND_MATLAB: Final = frozenset({*CONJUNCTION_WORDS, *DISJUNCTION_WORDS} - {"min", "prod", "max", "probor"})

DEFUZZIFIER_WORDS: Final = {
    "centroid": "centroid",
    "centroid_integral": "centroid",
    **_as_here("bisector", "mom", "som", "lom"),
    "wtaver": "weighted_average",
    "wtsum": "weighted_sum",
}

#: Types of systems; the last three are fuzzylite's.
TYPES: Final = _as_here("mamdani", "sugeno", "tsukamoto", "inverse tsukamoto", "hybrid")


def _by_key(*keys: str) -> dict[str, str]:
    return {key.lower(): key for key in keys}


#: Keys of `[System]` by themselves in small letters.
SYSTEM_KEYS: Final = _by_key(
    *("Name", "Type", "Version", "NumInputs", "NumOutputs", "NumRules"),
    *("AndMethod", "OrMethod", "ImpMethod", "AggMethod", "DefuzzMethod"),
)

#: Keys of variables that only fuzzylite writes; no help lists them.
_FUZZYLITE_KEYS: Final = ("enabled", "default", "lock", "lockvalid", "lockprevious", "lockrange")

#: Keys of variables.
VARIABLE_KEYS: Final = {**_by_key("Name", "Range", "NumMFs", "MF1"), **dict.fromkeys(_FUZZYLITE_KEYS, "")}

#: Digits behind the point of the number of a term, for hedges; `extremely` is another function in fuzzylite than in
#: Octave, which has all fractions and raises degrees to ten times each.
HEDGES: Final[dict[tuple[str, ...], Decimal]] = {
    ("somewhat",): Decimal("0.05"),
    ("very",): Decimal("0.2"),
    ("extremely",): Decimal("0.3"),
    ("very", "very"): Decimal("0.4"),
}

#: The number that fuzzylite writes for `any`, whatever the term.
ANY: Final = Decimal("0.99")

# --- tools ---------------------------------------------------------------------------------------------------------

#: The comment of fuzzyctl in files whose numerics are not MATLAB's.
_NUMERICS: Final = re.compile(r"% numerics of (octave|octave_0_4|fuzzylite|fuzzylite_6|pyfuzzylite|matlab)$")


def _profile_of_comment(file: Sections) -> str | None:
    """Return the profile that a comment of fuzzyctl names."""
    return next((m.group(1) for c in file.comments if (m := _NUMERICS.match(c)) is not None), None)


def dialect_of_profile(profile: str) -> Dialect:
    """Return the dialect of the files of a profile's tool."""
    if profile.startswith("octave"):
        return "octave"
    return "fuzzylite" if "fuzzylite" in profile else "matlab"


def dialect_of(file: Sections, *, hedges: bool) -> Dialect:
    """Return the tool that wrote a file: MATLAB without a sign of another one.

    Args:
        file: The file.
        hedges: Whether rules have hedges, which MATLAB does not know.
    """
    name = _profile_of_comment(file)
    if name is not None:
        return dialect_of_profile(name)
    entries = [e for s in file.sections for e in s.entries if s.kind != "rules"]
    comments = " ".join(file.comments).lower()
    functions = (e.value.text.partition(":")[2].strip().lower() for e in entries if e.key.lower().startswith("mf"))
    if (
        any("generated" in c.lower() and "fuzzylite" in c.lower() for c in file.comments)
        or any(e.key.lower() in _FUZZYLITE_KEYS for e in entries)
        or fuzzylite_version(file) is not None
        or any(f[1:].startswith(tuple(OF_FUZZYLITE)) for f in functions)
    ):
        return "fuzzylite"
    methods = {e.value.text.strip("'\" ").lower() for e in entries if e.key.lower().endswith("method")}
    octave = "fuzzy-logic-toolkit" in comments or "octave" in comments
    return "octave" if hedges or octave or methods & BEYOND_MATLAB else "matlab"


def fuzzylite_version(file: Sections) -> int | None:
    """Return fuzzylite's major version; its files have it as the version, which is 1.0 or 2.0 in MATLAB's."""
    version = version_said(file.comments)
    if version is not None:
        return version
    for section in file.of("system"):
        entry = section.entry("Version")
        match = re.match(r"'?([0-9]{1,3})", entry.value.text) if entry is not None else None
        if match is not None and int(match.group(1)) >= 3:
            return int(match.group(1))
    return None


def numerics(file: Sections, dialect: Dialect) -> Profile:
    """Return the numerics that a comment names, or those of the tool that wrote the file."""
    name = _profile_of_comment(file)
    if name is None and dialect == "fuzzylite":
        return profile_of_version(fuzzylite_version(file))
    return profile(name or dialect)
