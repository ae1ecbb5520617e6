"""Rules: antecedents, consequents, and the tables that stand for many rules."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyctl.diagnostics.diagnostic import ValueOutOfBoundsError
from fuzzyctl.expr import ONE, Expr
from fuzzyctl.model.block import Node
from fuzzyctl.model.method import Activation
from fuzzyctl.model.variable import Membership
from fuzzyctl.records import dataclass


@dataclass(frozen=True, kw_only=True, repr=False)
class Antecedent(Node):
    """Base of the parts of an antecedent, between `if` and `then`."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Is(Antecedent):
    """The degree of one term of one variable, changed by hedges.

    Args:
        variable: An input, or an output, which counts with its crisp value of the same evaluation.
        term: One of its terms.
        hedges: Names of hedges as written; the one nearest to the term, the last, applies first.
    """

    variable: str
    term: str
    hedges: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, repr=False)
class Not(Antecedent):
    """Complement: 1 minus the truth of the operand."""

    operand: Antecedent


@dataclass(frozen=True, kw_only=True, repr=False)
class And(Antecedent):
    """Conjunction of two or more antecedents by the t-norm of the system or the rule block, from left to right."""

    operands: tuple[Antecedent, ...]


@dataclass(frozen=True, kw_only=True, repr=False)
class Or(Antecedent):
    """Disjunction of two or more antecedents by the s-norm of the system or the rule block, from left to right."""

    operands: tuple[Antecedent, ...]


@dataclass(frozen=True, kw_only=True)
class Consequent(Node):
    """`output is term`; in tables of Takagi-Sugeno systems a consequent without a name may stand for the term.

    Args:
        output: The output.
        term: One of its terms.
        hedges: Names of hedges as written; their effect is set by `Semantics.consequent_hedges`.
    """

    output: str
    term: str | Membership
    hedges: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, repr=False)
class Rule(Node):
    """One rule; its weight multiplies the firing strength before implication."""

    antecedent: Antecedent
    consequents: tuple[Consequent, ...]
    weight: Expr = ONE


@dataclass(frozen=True, kw_only=True)
class Cell(Node):
    """One cell of a rule table.

    Args:
        terms: A term for each output of the table, or none at all where there is no rule.
        weight: That of its rule.
        hedges: Those of each term, as in a consequent; empty if no term has any.
    """

    terms: tuple[str | Membership, ...]
    weight: Expr = ONE
    hedges: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True, kw_only=True, repr=False)
class RuleTable(Node):
    """A rule table: every cell that is not empty is the rule `row and column then outputs`.

    Args:
        outputs: The outputs that the cells name, in order.
        rows: The input whose terms lead the rows, or an output; None for a one-way table, which has a single row.
        columns: The input whose terms head the columns, or an output.
        row_terms: Terms of the rows in the order written; empty for a one-way table.
        column_terms: Terms of the columns in the order written.
        cells: One tuple a row.
        condition: What must hold besides, joined to each rule by the conjunction; None for nothing.
    """

    outputs: tuple[str, ...]
    rows: str | None
    columns: str
    row_terms: tuple[str, ...]
    column_terms: tuple[str, ...]
    cells: tuple[tuple[Cell, ...], ...]
    condition: Antecedent | None = None

    @property
    def rule_count(self) -> int:
        """How many of its cells are rules."""
        return sum(bool(cell.terms) for row in self.cells for cell in row)

    def rules(self) -> Iterator[Rule]:
        """Yield the rules row by row; each has the span of its cell."""
        columns = [Is(variable=self.columns, term=term) for term in self.column_terms]
        rows = [Is(variable=self.rows, term=term) for term in self.row_terms] if self.rows is not None else []
        for i, row in enumerate(self.cells):
            for column, cell in zip(columns, row, strict=True):
                if not cell.terms:
                    continue
                antecedent: Antecedent = And(operands=(rows[i], column)) if rows else column
                if self.condition is not None:
                    parts = antecedent.operands if isinstance(antecedent, And) else (antecedent,)
                    antecedent = And(operands=(self.condition, *parts))
                hedges = cell.hedges or ((),) * len(cell.terms)
                consequents = tuple(
                    Consequent(output=o, term=t, hedges=h, span=cell.span)
                    for o, t, h in zip(self.outputs, cell.terms, hedges, strict=True)
                )
                yield Rule(antecedent=antecedent, consequents=consequents, weight=cell.weight, span=cell.span)


@dataclass(frozen=True, kw_only=True, repr=False)
class RuleBlock(Node):
    """Rules that belong together, with methods of joining, implication and activation.

    Args:
        name: Its name; in a rule file each block of a system has another one.
        conjunction: How its rules join by `and`; None for the way of the system.
        disjunction: How its rules join by `or`; None for the way of the system.
        implication: Of an activation and the sets that its rules conclude; None for that of each output.
        activation: Which of its rules act; None for the method of the system. Methods that compare rules compare those
            of one block with each other.
        rules: Rule tables and single rules in the order written, at least one.
    """

    name: str
    conjunction: str | None = None
    disjunction: str | None = None
    implication: str | None = None
    activation: Activation | None = None
    rules: tuple[RuleTable | Rule, ...]

    def __post_init__(self) -> None:
        Node.__post_init__(self)
        if not self.rules:
            raise ValueOutOfBoundsError("RuleBlock.rules", self.rules, "one rule or more")


def rules_of(part: RuleTable | Rule) -> Iterator[Rule]:
    """Yield the rules of a table, or a single rule."""
    if isinstance(part, RuleTable):
        yield from part.rules()
    else:
        yield part


def rule_count(part: RuleTable | Rule) -> int:
    """Return how many rules a table or a single rule is."""
    return part.rule_count if isinstance(part, RuleTable) else 1


def literals(antecedent: Antecedent) -> list[Is]:
    """Return every `input is term` of an antecedent from left to right."""
    if isinstance(antecedent, And):  # nearly all are, of nothing but these
        literals = [part for part in antecedent.operands if isinstance(part, Is)]
        if len(literals) == len(antecedent.operands):
            return literals
    return [part for part in parts_of(antecedent) if isinstance(part, Is)]


def is_joined_by(kind: type[And] | type[Or], antecedent: Antecedent) -> bool:
    """Return whether an antecedent, or a part of it, joins with `and` or with `or`."""
    return any(isinstance(part, kind) for part in parts_of(antecedent))


def parts_of(antecedent: Antecedent) -> list[Antecedent]:
    """Return an antecedent and every part of it, each before its parts, from left to right."""
    parts: list[Antecedent] = []
    left = [antecedent]
    while left:
        part = left.pop()
        parts.append(part)
        if isinstance(part, And | Or):
            left.extend(reversed(part.operands))
        elif isinstance(part, Not):
            left.append(part.operand)
    return parts
