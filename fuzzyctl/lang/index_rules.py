"""Rules of MATLAB by the numbers of terms, such as `1 -2, 1 (0.5) : 1`, as rules of the language."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from fuzzyctl.lang.edits import Edit, Surroundings, masked
from fuzzyctl.lang.syntax import NAME

_NUMBERS: Final = r"-?\d+(?:\s+-?\d+)*"
_RULE: Final = re.compile(
    rf"\s*(?P<inputs>{_NUMBERS})\s*,\s*(?P<outputs>{_NUMBERS})\s*\(\s*(?P<weight>\d*\.?\d+)\s*\)\s*:\s*(?P<joint>[12])\s*$"
)
_HEAD: Final = re.compile(rf"\s*(input|output)\s+({NAME})", re.IGNORECASE)
_TERMS: Final = re.compile(r"\s*terms\s+(.+)", re.IGNORECASE)
_TERM: Final = re.compile(rf"\s*({NAME})\s*=")


def index_rule(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Write a rule of numbers with the names of variables and terms, in their order in the file.

    A number that is too large, or as many as there are no variables for, gives no edit.
    """
    found = _RULE.match(code.rstrip())
    if found is None:
        return
    inputs, outputs = _declared(around.declared.text)
    conditions = _literals(inputs, found["inputs"].split())
    consequents = _literals(outputs, found["outputs"].split())
    if not conditions or not consequents:
        return
    joined = (" and " if found["joint"] == "1" else " or ").join(conditions)
    weight = "" if float(found["weight"]) == 1 else f" weight {found['weight']}"
    start = len(code) - len(code.lstrip())
    rule = f"if {joined} then {', '.join(consequents)}{weight}"
    yield Edit(start, len(code.rstrip()), rule, "a rule names its variables and terms", sure=False)


def _literals(variables: Mapping[str, Sequence[str]], numbers: Sequence[str]) -> list[str] | None:
    """Return `VARIABLE is TERM` for each number but 0; None where variables or terms are lacking."""
    if len(numbers) != len(variables):
        return None
    found = []
    for (name, terms), number in zip(variables.items(), map(int, numbers), strict=True):
        if abs(number) > len(terms):
            return None
        if number:
            found.append(f"{name} is {'not ' if number < 0 else ''}{terms[abs(number) - 1]}")
    return found


def _declared(text: str) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
    """Return the terms of each input and of each output, in the order of the text."""
    kinds: dict[str, dict[str, list[str]]] = {"input": {}, "output": {}}
    terms: list[str] = []
    for line in masked(text).split("\n"):
        head, listed, single = _HEAD.match(line), _TERMS.match(line), _TERM.match(line)
        if head is not None:
            terms = kinds[head[1].lower()].setdefault(head[2], [])
        elif listed is not None:
            terms += re.findall(rf"(?<![\w@=.])({NAME})", listed[1])
        elif single is not None:
            terms.append(single[1])
    return kinds["input"], kinds["output"]
