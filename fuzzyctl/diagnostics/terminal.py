"""Text safe for terminals: control characters made visible, missing characters and names spelt in ASCII."""

from __future__ import annotations

import codecs
import re
import unicodedata
from collections.abc import Mapping
from typing import Any, Final

#: Name of the error handler that `prepare` sets.
SPELT: Final = "fuzzyctl.spelt"

#: Control characters (C0, DEL, C1), characters that change the direction of the text, and halves of surrogate pairs.
_ACTIVE: Final = re.compile("[\\0-\\x1f\\x7f-\\x9f\\u202a-\\u202e\\u2066-\\u2069\\ud800-\\udfff]")

#: Signs that the messages and tables here are made of.
_SIGNS: Final[dict[str, str]] = {
    **dict(zip("│─┼×·−–—…‘’“”\ufffd", "|-+x.---.''\"\"?", strict=True)),
    "→": "->",
    "±": "+-",
    "≤": "<=",
    "≥": ">=",
    "°": "deg",
}


def printable(text: str) -> str:
    """Return a text of one line that no terminal acts on.

    Tabs become blanks, other control characters their picture such as ␛, and further active characters U+FFFD.
    """
    return _ACTIVE.sub(lambda match: _picture(match[0]), text)


def _picture(character: str) -> str:
    if character == "\t":
        return " "
    if character == "\x7f":
        return "␡"
    return chr(0x2400 + ord(character)) if character < " " else "\ufffd"


def spelt(text: str, encoding: str | None) -> str:
    """Return a text in the characters of an encoding; others are spelt in ASCII."""
    return text.encode(encoding, SPELT).decode(encoding) if encoding else text


def for_terminal(data: Any, encoding: str | None) -> Any:
    """Return plain data whose texts are `printable`, in the characters of an encoding."""
    if isinstance(data, str):
        return spelt(printable(data), encoding)
    if isinstance(data, Mapping):
        return {for_terminal(k, encoding): for_terminal(v, encoding) for k, v in data.items()}
    if isinstance(data, list | tuple):
        return [for_terminal(v, encoding) for v in data]
    return data


def _spelt(character: str) -> str:
    if character in _SIGNS:
        return _SIGNS[character]
    return "?" if "\u2400" <= character <= "\u2421" else in_ascii(character)


def _handle(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_spelt, error.object[error.start : error.end])), error.end


codecs.register_error(SPELT, _handle)


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
    return "".join(map(_transliterated, unicodedata.normalize("NFC", name)))


def _transliterated(character: str) -> str:
    if character.isascii():
        return character if character.isalnum() else "_"
    base = "".join(c for c in unicodedata.normalize("NFKD", character) if not unicodedata.combining(c))
    if base.isascii() and base.isalnum():
        return base
    if base.lower() in _GREEK:
        spelt = _GREEK[base.lower()]
        return spelt.capitalize() if base != base.lower() else spelt
    return "".join(f"u{ord(c):04X}" for c in character)
