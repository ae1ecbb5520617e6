"""Suggestions for unknown names: similar known names, and how known names are listed."""

from __future__ import annotations

import difflib
import unicodedata
from collections.abc import Collection, Iterable
from functools import lru_cache
from itertools import islice

from fuzzyctl.diagnostics.other_tools_words import PEER_REMARKS, PEER_WORDS

#: Letters of other alphabets that look like ASCII ones; fullwidth and other forms are found by Unicode's NFKC.
_ALIKE = str.maketrans(
    "АВЕЅІЈКМНОРСТУХаеѕіјорсухԁԛԝΑΒΕΖΗΙΚΜΝΟΡΤΥΧονı",
    "ABESIJKMHOPCTYXaesijopcyxdqwABEZHIKMNOPTYXovi",
)


def look_alikes(name: str) -> tuple[str, ...]:
    """Describe the letters of a name that look like ASCII ones but are others."""
    results = []
    for c in dict.fromkeys(name):
        plain = unicodedata.normalize("NFKC", c).translate(_ALIKE)
        if not c.isascii() and plain != c and plain.isascii():
            results.append(
                f"'{c}' in it is U+{ord(c):04X} ({unicodedata.name(c, 'unnamed')}), which looks like '{plain}'"
            )
    return tuple(results)


#: With more names than this only those that are one letter away are found.
_MOST_COMPARED = 64
#: Most pairs of letters that are compared for one name; where there are more, only names one letter away are found.
_MOST_PAIRS = 50_000
#: Most letters of all names with one letter left out; where there are more, none is found.
_MOST_LETTERS = 10_000_000

#: How alike two names must be to be taken for a slip: in names of two letters one may differ.
_LIKE = 0.5


def listed(names: Collection[str], most: int = 20) -> str:
    """Return names separated by commas, cut where there are very many."""
    rest = len(names) - most
    shown = ", ".join(islice(names, most))
    return shown if rest <= 0 else f"{shown} and {rest} more"


def counted(count: int, noun: str) -> str:
    """Return a number with its noun, such as `1 term` and `2 terms`."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def a_or_an(noun: str) -> str:
    """Return a noun with its article."""
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def closest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that a misspelt one most likely means, or None."""
    names = list(known)
    if not names:
        return None
    plain = unicodedata.normalize("NFKC", name).translate(_ALIKE)
    if plain != name and plain in names:
        return plain
    bare = _bare(name)
    if bare in PEER_WORDS and name not in names:
        # The word of another tool is better than one of a similar spelling.
        meant = next((word for word in PEER_WORDS[bare] if word in names), None)
        if meant is not None or not PEER_WORDS[bare]:
            return meant
    if len(names) > _MOST_COMPARED or len(name) * sum(map(len, names)) > _MOST_PAIRS:
        return _one_letter_away(name, tuple(names))
    folded = {_bare(n): n for n in reversed(names)}
    if bare in folded:
        return folded[bare]
    result = difflib.get_close_matches(name, names, n=1, cutoff=_LIKE)
    if result:
        return result[0]
    near = difflib.get_close_matches(bare, list(folded), n=1, cutoff=_LIKE)
    return folded[near[0]] if near else None


def _bare(name: str) -> str:
    """Return a name in small letters without underscores, in which spellings differ."""
    return name.casefold().replace("_", "")


def is_slip(name: str, meant: str, known: Collection[str]) -> bool:
    """Whether a name is a slip of one known name and of no other.

    It differs in capitals, underscores or look-alike letters alone; or, from three letters on, by one letter more,
    less, changed or swapped with its neighbour. Among very many names none is compared.
    """
    if len(known) > _MOST_COMPARED:
        return False
    plain = unicodedata.normalize("NFKC", name).translate(_ALIKE)
    names = set(known) | {meant}
    for form in (str, _bare):
        same = [n for n in names if form(n) == form(plain)]
        if same:
            return same == [meant]
    if len(meant) < 3:
        return False
    return [n for n in names if _is_one_letter_away(plain, n)] == [meant]


def _is_one_letter_away(a: str, b: str) -> bool:
    """Whether two names differ by one letter more, less or changed, or by two neighbours that are swapped."""
    a, b = sorted((a.casefold(), b.casefold()), key=len)
    if len(b) - len(a) > 1:
        return False
    at = next((i for i, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), len(a))
    if len(a) < len(b):
        return a[at:] == b[at + 1 :]
    return a[at + 1 :] == b[at + 1 :] or (a[at : at + 2] == b[at : at + 2][::-1] and a[at + 2 :] == b[at + 2 :])


def _one_letter_away(name: str, known: tuple[str, ...]) -> str | None:
    """Return a name with one letter more, less, changed or swapped with its neighbour.

    Comparing letter by letter with a thousand names takes milliseconds, and a file may hold thousands of mistakes.
    """
    index = _shortened(known)
    return next((index[s] for s in _without_a_letter(name.casefold()) if s in index), None)


@lru_cache(maxsize=4)
def _shortened(known: tuple[str, ...]) -> dict[str, str]:
    """Map every name, whole and without any one of its letters, to itself."""
    index: dict[str, str] = {}
    if sum(len(name) ** 2 for name in known) > _MOST_LETTERS:
        return index
    for name in known:
        for short in _without_a_letter(name.casefold()):
            index.setdefault(short, name)
    return index


def _without_a_letter(name: str) -> list[str]:
    # From the end on: of two names that are as near, the one that begins alike is meant.
    return [name, *(name[:i] + name[i + 1 :] for i in reversed(range(min(len(name), 200))))]


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return a help text that names the closest known name, or an empty string."""
    best = closest(name, known)
    remark = PEER_REMARKS.get(_bare(name), "")
    return f"did you mean '{best}'?{' ' if remark else ''}{remark}" if best is not None else ""
