"""Transliteration of names to ASCII."""

from __future__ import annotations

import unicodedata
from typing import Final

_GREEK: Final = dict(
    zip(
        "αβγδεζηθικλμνξοπρςστυφχψω",
        (
            *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu"),
            *("nu", "xi", "omicron", "pi", "rho", "sigma", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega"),
        ),
        strict=True,
    )
)


def in_ascii(name: str) -> str:
    """Return a name in ASCII letters, digits and underscores.

    Greek letters are spelt out, accents dropped, and other characters outside ASCII become `uXXXX`.
    """
    return "".join(map(_spelt, unicodedata.normalize("NFC", name)))


def _spelt(character: str) -> str:
    if character.isascii():
        return character if character.isalnum() else "_"
    base = "".join(c for c in unicodedata.normalize("NFKD", character) if not unicodedata.combining(c))
    if base.isascii() and base.isalnum():
        return base
    if base.lower() in _GREEK:
        spelt = _GREEK[base.lower()]
        return spelt.capitalize() if base != base.lower() else spelt
    return "".join(f"u{ord(c):04X}" for c in character)
