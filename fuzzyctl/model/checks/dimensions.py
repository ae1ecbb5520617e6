"""Units as products of powers: whether two are equal, different, or unknown.

The usual spellings are read, such as `m/s`, `m s^-1`, `m·s⁻¹`, `m per s` and `(m)/(s)`, and units whose size is
beyond doubt. Any other word, such as `apples` or `°C`, is a unit without relation to others: two units can be compared
only if such words cancel.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import lru_cache
from typing import Final

from fuzzyctl.records import dataclass

#: A factor, and the powers of base units.
_MADE_OF: Final[dict[str, tuple[int, dict[str, int]]]] = {
    "m": (1, {"m": 1}),
    "s": (1, {"s": 1}),
    "A": (1, {"A": 1}),
    "K": (1, {"K": 1}),
    "mol": (1, {"mol": 1}),
    "Hz": (1, {"s": -1}),
    "N": (1, {"kg": 1, "m": 1, "s": -2}),
    "J": (1, {"kg": 1, "m": 2, "s": -2}),
    "W": (1, {"kg": 1, "m": 2, "s": -3}),
    "Wh": (3600, {"kg": 1, "m": 2, "s": -2}),
    "Pa": (1, {"kg": 1, "m": -1, "s": -2}),
    "bar": (100_000, {"kg": 1, "m": -1, "s": -2}),
    "V": (1, {"kg": 1, "m": 2, "s": -3, "A": -1}),
    "\N{GREEK CAPITAL LETTER OMEGA}": (1, {"kg": 1, "m": 2, "s": -3, "A": -2}),
}
#: The same for units that take no prefix.
_WHOLE: Final[dict[str, tuple[int | Fraction, dict[str, int]]]] = {
    "kg": (1, {"kg": 1}),
    "mg": (Fraction(1, 1_000_000), {"kg": 1}),
    "Nm": (1, {"kg": 1, "m": 2, "s": -2}),
    "sec": (1, {"s": 1}),
    "second": (1, {"s": 1}),
    "seconds": (1, {"s": 1}),
    "min": (60, {"s": 1}),
    "h": (3600, {"s": 1}),
    "hour": (3600, {"s": 1}),
    "hours": (3600, {"s": 1}),
    "metre": (1, {"m": 1}),
    "metres": (1, {"m": 1}),
    "meter": (1, {"m": 1}),
    "meters": (1, {"m": 1}),
    "L": (Fraction(1, 1000), {"m": 3}),
    "l": (Fraction(1, 1000), {"m": 3}),
}
_PREFIXES: Final[dict[str, Fraction]] = {
    "G": Fraction(10**9),
    "M": Fraction(10**6),
    "k": Fraction(1000),
    "h": Fraction(100),
    "d": Fraction(1, 10),
    "c": Fraction(1, 100),
    "m": Fraction(1, 1000),
    "\N{MICRO SIGN}": Fraction(1, 10**6),
    "\N{GREEK SMALL LETTER MU}": Fraction(1, 10**6),
    "u": Fraction(1, 10**6),
    "n": Fraction(1, 10**9),
}
_SUPERSCRIPTS: Final = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+-0123456789")
_TOKEN: Final = re.compile(
    r"\s*(?:(?P<divide>/|÷|per\b)|(?P<times>\*(?!\*)|·|⋅|×|\.)|(?P<open>[(\[])|(?P<close>[)\]])"
    r"|(?P<one>1(?![\d.]))"
    r"|(?P<word>(?:[^\W\d_⁰¹²³⁴⁵⁶⁷⁸⁹]|[°%$€])+)(?:\s*(?:\^|\*\*)\s*(?P<power>[+-]?\d{1,2}|\([+-]?\d{1,2}\))"
    r"|(?P<raised>[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]{1,2})|(?P<digits>-?\d{1,2}))?)"
)
#: Longer texts are not read.
_LONGEST: Final = 100
#: Texts that say that a quantity has no unit.
_NONE: Final = ("", "-", "–", "—", "1")


@dataclass(frozen=True)
class Dimension:
    """A product of powers.

    Args:
        size: The factor of its base units.
        powers: The power of each unit, never 0.
        words: Powers of unknown words.
    """

    size: Fraction
    powers: Mapping[str, int]
    words: Mapping[str, int]

    def over(self, other: Dimension) -> Dimension:
        """Return the quotient of two."""
        return self.times(other, -1)

    def times(self, other: Dimension, power: int) -> Dimension:
        """Return self · other^power."""
        return Dimension(
            self.size * other.size**power,
            _joined(self.powers, other.powers, power),
            _joined(self.words, other.words, power),
        )


_ONE: Final = Dimension(Fraction(1), {}, {})


@lru_cache(maxsize=256)
def are_same(first: str, second: str) -> bool:
    """Return whether two units are the same beyond doubt, however they are spelt."""
    if first == second:
        return True
    ratio = _ratio(first, second)
    return ratio is not None and ratio == _ONE


def surely_differ(unit: str, numerator: str, denominator: str = "1") -> bool:
    """Return whether a unit is not that of a quotient beyond doubt; words that are not known leave one."""
    whole, above, below = dimension(unit), dimension(numerator), dimension(denominator)
    if whole is None or above is None or below is None:
        return False
    ratio = whole.times(below, 1).over(above)
    return not ratio.words and ratio != _ONE


@lru_cache(maxsize=256)
def dimension(text: str) -> Dimension | None:
    """Return a unit as a product of powers, None for a text that cannot be read as one, or in two ways."""
    inner = text.strip()
    if len(inner) > _LONGEST:
        return None
    if inner.strip("[]() ") in _NONE:
        return _ONE
    try:
        tokens = list(_tokens(inner))
        result, rest = _product(tokens)
    except _UnreadError:
        return None
    return None if rest else result


def _ratio(first: str, second: str) -> Dimension | None:
    above, below = dimension(first), dimension(second)
    return None if above is None or below is None else above.over(below)


class _UnreadError(Exception):
    """Raised for a text that is not a unit."""


#: The kind of a token, and its dimension.
_Token = tuple[str, Dimension]


def _tokens(text: str) -> Iterator[_Token]:
    place = 0
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None:
            raise _UnreadError
        place = match.end()
        if match["word"] is None:
            yield next(k for k in ("divide", "times", "open", "close", "one") if match[k]), _ONE
            continue
        yield "word", _power(match)


def _power(match: re.Match[str]) -> Dimension:
    word = _word(match["word"])
    if word.words and match["digits"]:
        return _word(match["word"] + match["digits"])  # a name that ends in digits
    digits = match["power"] or (match["raised"] or "").translate(_SUPERSCRIPTS) or match["digits"] or "1"
    return _ONE.times(word, int(digits.strip("()")))


def _word(word: str) -> Dimension:
    if word in _WHOLE:
        size, powers = _WHOLE[word]
        return Dimension(Fraction(size), powers, {})
    word = word.replace("\N{OHM SIGN}", "\N{GREEK CAPITAL LETTER OMEGA}")
    for prefix, factor in (("", Fraction(1)), *_PREFIXES.items()):
        base = word.removeprefix(prefix)
        if word.startswith(prefix) and base in _MADE_OF:
            size, powers = _MADE_OF[base]
            return Dimension(factor * size, powers, {})
    return Dimension(Fraction(1), {}, {word: 1})


def _product(tokens: list[_Token]) -> tuple[Dimension, list[_Token]]:
    """Read factors up to the end or a closing parenthesis.

    People read a factor that follows a divisor, as in `J/kg K`, in two ways.
    """
    result, tokens = _factor(tokens)
    divided = False
    while tokens and tokens[0][0] != "close":
        divides = tokens[0][0] == "divide"
        if divided and not divides:
            raise _UnreadError
        divided = divides
        factor, tokens = _factor(tokens[1:] if tokens[0][0] in ("divide", "times") else tokens)
        result = result.times(factor, -1 if divides else 1)
    return result, tokens


def _factor(tokens: list[_Token]) -> tuple[Dimension, list[_Token]]:
    kind, value = tokens[0] if tokens else ("end", _ONE)
    if kind in ("word", "one"):
        return value, tokens[1:]
    if kind != "open":
        raise _UnreadError
    value, rest = _product(tokens[1:])
    if not rest:
        raise _UnreadError
    return value, rest[1:]


def _joined(a: Mapping[str, int], b: Mapping[str, int], power: int) -> dict[str, int]:
    results = {name: a.get(name, 0) + power * b.get(name, 0) for name in {*a, *b}}
    return {name: p for name, p in results.items() if p}
