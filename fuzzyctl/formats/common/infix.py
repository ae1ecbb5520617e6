"""Parser of infix expressions by precedence; each dialect has a table of its operators."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from fuzzyctl.diagnostics.source import Span

Node = TypeVar("Node")
Location = TypeVar("Location")


@dataclass(frozen=True)
class Operator:
    """An infix operator.

    Args:
        level: Its precedence: operators of higher levels bind first.
        right: Whether several of one level are read from the right.
        run: Whether a run of it is one node with all operands, not a node for each two.
    """

    level: int
    right: bool = False
    run: bool = False


class InfixParser(Generic[Node, Location]):
    """Parser of operands with operators between them and before them.

    A dialect defines its tokens (`_peek`, `_take`), its operands (`_atom`), and the nodes of its operators (`_unary`,
    `_binary`, `_joined`, as far as the tables have such operators).

    Attributes:
        infix: The operators between operands, by their text.
        prefix: The operators before an operand, each with the level down to which that operand reaches.
        deepest: Largest number of `_nested` expressions within each other.
    """

    infix: Mapping[str, Operator]
    prefix: Mapping[str, int] = {}
    deepest = 0
    depth = 0

    _peek: Callable[[], str]
    _take: Callable[[], Location]
    _atom: Callable[[], Node]
    _unary: Callable[[str, Node, Location], Node]
    _binary: Callable[[str, Node, Node, Location], Node]
    _joined: Callable[[str, Sequence[Node], Sequence[Location]], Node]
    _too_deep: Callable[[Location], Exception]

    def parse(self, least: int = 0) -> Node:
        """Take an expression of operators of at least some level."""
        left = self._operand(least)
        while (operator := self.infix.get(sign := self._peek())) is not None and operator.level >= least:
            if operator.run:
                left = self._run(sign, operator.level + 1, left)
                continue
            location = self._take()
            right = self._nested(operator.level, location) if operator.right else self.parse(operator.level + 1)
            left = self._binary(sign, left, right, location)
        return left

    def _operand(self, least: int) -> Node:
        """Take an atom with the prefix operators before it; `least` is the level of the operator before."""
        level = self.prefix.get(sign := self._peek())
        if level is None:
            return self._atom()
        location = self._take()
        return self._unary(sign, self._nested(level, location), location)

    def _nested(self, least: int, location: Location) -> Node:
        """Take an expression one level of nesting further down."""
        self._enter(location)
        node = self.parse(least)
        self.depth -= 1
        return node

    def _enter(self, location: Location) -> None:
        self.depth += 1
        if self.depth > self.deepest:
            raise self._too_deep(location)

    def _run(self, sign: str, least: int, first: Node) -> Node:
        locations = [self._take()]
        operands = [self._of_run(first, locations[0]), self._of_run(self.parse(least), locations[0])]
        while self._peek() == sign:
            locations.append(self._take())
            operands.append(self._of_run(self.parse(least), locations[-1]))
        return self._joined(sign, operands, locations)

    def _of_run(self, operand: Node, location: Location) -> Node:
        """Return an operand as it enters a run."""
        return operand


class SpanParser(InfixParser[Node, Span]):
    """Parser whose tokens are stretches of a text.

    Attributes:
        tokens: The tokens.
        next: Position of the next one.
    """

    tokens: Sequence[Span]
    next = 0

    def _text(self) -> str:
        return self.tokens[self.next].text if self.next < len(self.tokens) else ""

    _peek = _text

    def _take(self) -> Span:
        self.next += 1
        return self.tokens[self.next - 1]


def tokens_of(span: Span, pattern: re.Pattern[str]) -> Iterator[tuple[Span, bool]]:
    """Yield the tokens of a text without blanks, each with True, and with False a character that begins no token."""
    text, at = span.text, 0
    while at < len(text):
        match = pattern.match(text, at)
        end = at + 1 if match is None else match.end()
        if match is not None or not text[at].isspace():
            yield Span(span.source, span.start + at, span.start + end), match is not None
        at = end
