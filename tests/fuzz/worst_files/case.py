"""Registry of worst cases, the limits that they reach, and what their files are made of."""

from collections.abc import Callable, Iterator
from itertools import chain, islice

#: Largest size of a file in bytes, and the other limits of docs/reference/language.md.
BYTES = 1 << 20
TERMS, OUTPUTS, RULES, FILES, NAME, OPERATORS, VARIABLES = 1000, 200, 20_000, 64, 200, 80_000, 2000
GUARANTEES = 1000

#: Somewhat fewer lines of controllers, plants, loops and lets than allowed, so that others stand beside them.
EQUATIONS = 9900

#: By name a worst case: from a size to the contents of files; the first is checked.
CASES: dict[str, Callable[[float], dict[str, str]]] = {}

HEAD = """input x in [0, 1]
  terms low high
output y in [0, 1] else 0
  terms small large
"""
SUGENO = """defuzzifier weighted_average
output y in [0, 1] else 0
  terms small=0 large=1
"""


def case(make):
    """Register a function that yields the pieces of one system, up to the largest size of a file."""
    _register(make.__name__.replace("_", "-"), make, "system worst\n")
    return make


def file_case(make):
    """Register a function that yields the pieces of a file with the headlines of its blocks."""
    _register(make.__name__.replace("_", "-"), make)
    return make


def repetitions(cases, head="system worst\n", most=None):
    """Register files by name: a piece that is repeated, at most some times, and before it the pieces of a beginning."""
    for name, pieces in cases.items():

        def make(size, pieces=pieces):
            return islice(repeated(*pieces), most and len(pieces) - 1 + int(most * size))

        _register(name, make, "" if "systems" in name else head)


def _register(name, make, *head):
    CASES[name] = lambda size: {f"{name}.fz": cut(chain(head, make(size)), size)}


def files_case(make):
    """Register a function that returns several files."""
    CASES[make.__name__.replace("_", "-")] = make
    return make


def cut(pieces: Iterator[str], size: float = 1.0) -> str:
    """Join pieces as long as they fit into a file."""
    found, left = [], int(BYTES * size)
    for piece in pieces:
        left -= len(piece.encode())
        if left < 0:
            break
        found.append(piece)
    return "".join(found)


def repeated(piece, *parts):
    """Yield a beginning, and pieces numbered from 0 for ever."""
    yield from parts
    k = 0
    while True:
        yield piece.replace("@", str(k))
        k += 1


def computed(size, operators, piece, head):
    """Yield a beginning, and pieces of some operators each, until a file may have no more."""
    yield from islice(repeated(piece, head), 1 + int(OPERATORS * size) // operators)


def names(count, prefix="t"):
    return [f"{prefix}{k}" for k in range(int(count))]


def inputs_of(count, terms="a b"):
    return "".join(f"input x{k} in [0, 1]\n  terms {terms}\n" for k in range(count))
