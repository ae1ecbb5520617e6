"""Syntax nodes of FCL: frozen, with locations, before names are resolved."""

from __future__ import annotations

from dataclasses import dataclass

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Expr


@dataclass(frozen=True)
class Word:
    """A name or keyword as written."""

    text: str
    span: Span

    @property
    def upper(self) -> str:
        """The word in capitals, as keywords are compared."""
        return self.text.upper()


@dataclass(frozen=True)
class Range:
    """`RANGE := (low .. high)`."""

    low: Expr
    high: Expr
    span: Span


@dataclass(frozen=True)
class Declaration:
    """A variable of a VAR block; `initial` is the constant after `:=`."""

    name: Word
    initial: Expr | None
    range: Range | None = None


@dataclass(frozen=True)
class VariableBlock:
    """VAR_INPUT, VAR_OUTPUT or VAR; `keyword` says which."""

    keyword: Word
    declarations: tuple[Declaration, ...]


@dataclass(frozen=True)
class Shape:
    """What stands behind `TERM name :=`.

    Args:
        kind: The word, such as TRIAN or Triangle; None for a list of points and for a lone number.
        arguments: Parameters; of points the coordinates one after the other.
        points: Whether it is a list of points.
        formula: The expression of FUNCTION, else None.
        span: Where it stands.
    """

    kind: Word | None
    arguments: tuple[Expr, ...]
    points: bool
    formula: Expr | None
    span: Span


@dataclass(frozen=True)
class TermLine:
    """`TERM name := shape;`."""

    name: Word
    shape: Shape
    span: Span


@dataclass(frozen=True)
class Setting:
    """`KEYWORD : value` or `KEYWORD := value`; values of several words are separated by `|`."""

    keyword: Word
    values: tuple[Word | Expr, ...]
    span: Span

    @property
    def word(self) -> Word | None:
        """The value where it is a single word."""
        value = self.values[0] if len(self.values) == 1 else None
        return value if isinstance(value, Word) else None


@dataclass(frozen=True)
class FuzzyBlock:
    """FUZZIFY or DEFUZZIFY of a variable."""

    keyword: Word
    variable: Word
    terms: tuple[TermLine, ...]
    settings: tuple[Setting, ...]
    range: Range | None


class Condition:
    """Base of what can stand between IF and THEN."""

    span: Span


@dataclass(frozen=True)
class Clause(Condition):
    """`variable IS words`: the last word is the term, and those before it are hedges."""

    variable: Word
    words: tuple[Word, ...]
    span: Span


@dataclass(frozen=True)
class Negated(Condition):
    """`NOT condition`."""

    operand: Condition
    span: Span


@dataclass(frozen=True)
class Joined(Condition):
    """Conditions joined by AND and OR as written, without precedence; `operators` is one shorter than `operands`."""

    operands: tuple[Condition, ...]
    operators: tuple[Word, ...]
    span: Span


@dataclass(frozen=True)
class RuleLine:
    """`RULE name : IF condition THEN conclusions WITH weight;`."""

    name: str
    condition: Condition
    conclusions: tuple[Clause, ...]
    weight: Expr | None
    span: Span


@dataclass(frozen=True)
class RuleBlock:
    """RULEBLOCK with its settings and rules."""

    name: str
    settings: tuple[Setting, ...]
    rules: tuple[RuleLine, ...]
    span: Span


@dataclass(frozen=True)
class FunctionBlock:
    """FUNCTION_BLOCK: one fuzzy system."""

    name: str
    variables: tuple[VariableBlock, ...]
    fuzzy: tuple[FuzzyBlock, ...]
    rules: tuple[RuleBlock, ...]
    span: Span
