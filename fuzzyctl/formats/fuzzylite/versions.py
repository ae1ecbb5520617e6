"""Version of fuzzylite that wrote a file, and the profile of its numerics."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from types import MappingProxyType
from typing import Final

from fuzzyctl.model.profiles import PROFILES, Profile

_GENERATED: Final = re.compile(r"generated (?:with|by) fuzzylite (\d{1,3})\b", re.IGNORECASE)

#: Samples of versions before 6, where a file says no number.
_SAMPLES_BEFORE_6: Final = 200


def version_said(comments: Iterable[str]) -> int | None:
    """Return the major version of fuzzylite that a comment names."""
    found = (_GENERATED.search(c) for c in comments)
    return next((int(match.group(1)) for match in found if match is not None), None)


def profile_of_version(version: int | None) -> Profile:
    """Return the numerics of a version of fuzzylite; those of the newest where none is known."""
    if version is None or version > 6:
        return PROFILES["fuzzylite"]
    six = PROFILES["fuzzylite_6"]
    if version == 6:
        return six
    older = {
        kind: d.model_copy(update={"resolution": _SAMPLES_BEFORE_6}) if d.resolution is not None else d
        for kind, d in six.defuzzifiers.items()
    }
    return replace(six, defuzzifiers=MappingProxyType(older))
