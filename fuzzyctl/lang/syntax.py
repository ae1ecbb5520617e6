"""Syntax tree: statements as written, each with its location."""

from __future__ import annotations

from typing import Final, dataclass_transform

from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.expr import Expr
from fuzzyctl.records import record

#: Words that begin a statement.
STATEMENT_KEYWORDS: Final = (
    "fz",
    "system",
    "source",
    "use",
    "semantics",
    "and",
    "or",
    "implication",
    "aggregation",
    "activation",
    "defuzzifier",
    "param",
    "hedge",
    "function",
    "controller",
    "plant",
    "loop",
    "input",
    "output",
    "terms",
    "rules",
    "with",
    "table",
    "if",
    "otherwise",
    "require",
    "allow",
    "deny",
)

#: Words that begin a block of equations.
HEADS: Final = ("controller", "plant", "loop")

_COMMON: Final = (*HEADS, "system", "source", "use", "param", "function", "let", "allow", "deny")
#: Words that begin a statement within such a block, by its head; some are those of a system, with a form of their own.
BLOCKS: Final[dict[str, tuple[str, ...]]] = {
    "controller": (*_COMMON, "input", "output", "state", "next", "every", "block", "require"),
    "plant": (*_COMMON, "input", "output", "state", "der"),
    "loop": (*_COMMON, "block", "for", "disturbance", "measure", "run", "require"),
}
#: All of them.
BLOCK_KEYWORDS: Final = tuple(dict.fromkeys(word for words in BLOCKS.values() for word in words))

#: Words that are not names, since rules and expressions use them.
RESERVED: Final = frozenset({"and", "or", "not", "then", "weight", "inf", "pi"})


#: A name, as a regular expression; combining marks belong to it, since text may come in decomposed form.
NAME: Final = r"[^\W\d][\w\u0300-\u036f]*"

#: Longest name.
MAX_NAME: Final = 200


@dataclass_transform(frozen_default=True, eq_default=False)
class Node:
    """Base of all parts of a tree: frozen for type checkers, equal to itself only."""

    def __init_subclass__(cls) -> None:
        """Make each kind a record of its fields."""
        record(frozen=True, eq=False)(cls)


class Word(Node):
    """A name as typed, in normal form NFC."""

    text: str
    span: Span


class Statement(Node):
    """Base of all statements; the span covers the line without its comment."""

    span: Span


class Version(Statement):
    """`fz 1`."""

    number: Word


class System(Statement):
    """`system NAME "title"`."""

    name: Word
    title: str


class Citation(Statement):
    """`source "..."`."""

    text: str


class Option(Node):
    """`name=value` inside the parentheses of a setting."""

    name: Word
    value: Word


class Setting(Statement):
    """`and`, `or`, `implication`, `aggregation` or `defuzzifier` with a value and options."""

    keyword: Word
    value: Word
    options: tuple[Option, ...]


class Semantics(Statement):
    """`semantics PROFILE(...)`."""

    keyword: Word
    profile: Word
    options: tuple[Option, ...] = ()


class ActivationOption(Node):
    """`name=value`, or a comparison with a value, inside the parentheses of an activation method."""

    name: Word
    value: Expr


class Activation(Statement):
    """`activation KIND(...)`."""

    keyword: Word
    kind: Word
    options: tuple[ActivationOption, ...]


class Hedge(Statement):
    """`hedge NAME(x) = expression`."""

    name: Word
    parameter: Word
    expression: Expr


class Use(Statement):
    """`use "file.fz"`."""

    path: str
    path_span: Span


class Allow(Statement):
    """`allow CODES "reason"` and `deny CODES "reason"`."""

    keyword: Word
    codes: tuple[Word, ...]
    reason: str


class Bounds(Node):
    """`in [low, high]`; a parenthesis in place of a bracket excludes the end."""

    lower: Expr
    upper: Expr
    without_lower: bool
    without_upper: bool
    span: Span


class Param(Statement):
    """`param NAME in [low, high] = expression unit "..."`."""

    name: Word
    expression: Expr
    unit: str
    bounds: Bounds | None = None


class Argument(Node):
    """One parameter of a term, with its name where it was given by keyword."""

    value: Expr
    keyword: Word | None
    span: Span


class TermLine(Statement):
    """`NAME = kind(...)` below an input or an output."""

    name: Word
    kind: Word
    arguments: tuple[Argument, ...]


class PartitionItem(Node):
    """One item of a `terms` line: a name with a peak (`@`), with a value (`=`), or alone."""

    name: Word
    peak: Expr | None
    value: Expr | None


class TermsLine(Statement):
    """`terms ...` below an input or an output."""

    items: tuple[PartitionItem, ...]


class UnitClause(Node):
    """`unit "..."` of a variable."""

    text: str
    span: Span


class Held(Node):
    """`hold(EXPR)`: the previous output, at first the value of the expression."""

    start: Expr
    span: Span


class FallbackClause(Node):
    """`else VALUE`, `else word` or `else hold(EXPR)`."""

    value: Expr | Word | Held
    span: Span


class AdaptiveClause(Node):
    """`adaptive rate EXPR`."""

    rate: Expr
    span: Span


class ExtrapolateClause(Node):
    """`extrapolate`."""

    span: Span


class ClampClause(Node):
    """`clamp`."""

    span: Span


class SettingClause(Node):
    """`implication`, `aggregation` or `defuzzifier` of one output."""

    setting: Setting
    span: Span


class TermsClause(Node):
    """`terms of VARIABLE`."""

    variable: Word
    span: Span


Clause = TermsClause | UnitClause | FallbackClause | AdaptiveClause | ExtrapolateClause | ClampClause | SettingClause


class FunctionTerm(Node):
    """A consequent without a name: `linear(...)`, `function(...)`, `constant(...)`."""

    kind: Word
    arguments: tuple[Expr, ...]
    span: Span


class HedgedTerm(Node):
    """`[hedges term]` in a cell."""

    hedges: tuple[Word, ...]
    term: Word
    span: Span


#: The consequents of a rule; an expression is a constant.
ConsequentTerm = Word | Expr | FunctionTerm


class Variable(Statement):
    """An `input`, `output` or `let` with the term lines below it, which all variables of one line have in common."""

    keyword: Word
    name: Word
    label: str
    lower: Expr
    upper: Expr
    clauses: tuple[Clause, ...]
    terms: tuple[TermLine | TermsLine, ...] = ()
    #: Some line below could not be read, so that missing terms are not reported.
    incomplete: bool = False
    #: The value of an `output` or a `let` without rules.
    value: Expr | None = None
    #: Whether a `let` has a range.
    ranged: bool = True
    #: The other variables of the line, each with its label.
    others: tuple[tuple[Word, str], ...] = ()


class CellText(Node):
    """One cell of a table row; no terms means no rule."""

    terms: tuple[ConsequentTerm | HedgedTerm, ...]
    weight: Expr | None
    span: Span


class Truth(Node):
    """Base of all antecedents, between `if` and `then`."""

    span: Span


class With(Statement):
    """`with CONDITION` above a table."""

    condition: Truth


class HeaderLine(Statement):
    """The line of terms above the rows of a table."""

    terms: tuple[Word, ...]


class RowLine(Statement):
    """One row of a table."""

    label: Word | None
    cells: tuple[CellText, ...]


class Table(Statement):
    """`table OUT = ROWS x COLUMNS` with header and rows; `second` is None for `table OUT = INPUT`.

    `csv` names a file that holds header and rows; `condition` is that of a `with` line above the table; `scale`
    multiplies the numbers of its cells. A label of a row or a column may be a number, as text.
    """

    outputs: tuple[Word, ...]
    first: Word
    second: Word | None
    csv: str = ""
    csv_span: Span | None = None
    condition: Truth | None = None
    header: HeaderLine | None = None
    rows: tuple[RowLine, ...] = ()
    incomplete: bool = False
    scale: Expr | None = None


class Rules(Statement):
    """`rules NAME` with the settings of the block: the tables and rules from here to the next such line are its own."""

    name: Word
    settings: tuple[Setting | Activation, ...]


class Literal(Truth):
    """`variable is [hedges] term`."""

    variable: Word
    hedges: tuple[Word, ...]
    term: Word


class Negation(Truth):
    """`not ...`."""

    operand: Truth


class Group(Truth):
    """`( ... )`."""

    operand: Truth


class Chain(Truth):
    """`a and b and c`, or the same with `or`."""

    connective: str
    operands: tuple[Truth, ...]


class ConsequentText(Node):
    """`output is hedges term`, or a number or a function in place of the term."""

    output: Word
    term: ConsequentTerm
    hedges: tuple[Word, ...] = ()


class Rule(Statement):
    """`if ... then ... weight w`."""

    antecedent: Truth
    consequents: tuple[ConsequentText, ...]
    weight: Expr | None


class Otherwise(Statement):
    """`otherwise ... weight w`: the rule that fires as far as the others do not."""

    consequents: tuple[ConsequentText, ...]
    weight: Expr | None


class Require(Statement):
    """`require CLAIM within TOLERANCE when REGION`."""

    claim: Expr
    within: Expr | None
    when: Expr | None


class Always(Require):
    """`require always CLAIM within TOLERANCE from BEGIN until END`, or `... forever` in place of an end."""

    begin: Expr | None
    end: Expr | None
    forever: bool


# -- controllers


class Head(Statement):
    """`controller NAME "title"`, `plant NAME "title"`, `loop NAME "title"`; a plant of one line has a formula."""

    keyword: Word
    name: Word
    title: str
    formula: Expr | None = None


class Function(Statement):
    """`function NAME(a, b) = expression`."""

    name: Word
    parameters: tuple[Word, ...]
    expression: Expr


class Signal(Statement):
    """`input`, `output`, `state`, `measure` or `disturbance` with a label and a unit; an input has no value."""

    keyword: Word
    name: Word
    label: str
    bounds: Bounds | None
    unit: str
    value: Expr | None


class Equation(Statement):
    """`let`, `next`, `der` or `block` with a name and an expression."""

    keyword: Word
    name: Word
    value: Expr


class Every(Statement):
    """`every PERIOD`."""

    period: Expr


class Run(Statement):
    """`run DURATION step STEP`."""

    duration: Expr
    step: Expr | None


class Varied(Statement):
    """`for NAME in [low, high]`: a start of a state or a param that differs between the members of a family."""

    name: Word
    bounds: Bounds


class SyntaxTree(Node):
    """All statements of a file in the order written.

    Args:
        source: The text.
        statements: What could be read.
        used: Declarations of the files that it uses.
        unread: Words of lines that could not be read; a name among them may have been declared there.
        lost_variable: Whether terms stood below no input or output: one declaration is missing.
        lost_file: Whether some file that it uses could not be read at all.
        lost_input: Whether the declaration of some input could not be read, so that inputs cannot be counted.
        nameless: Keywords of declarations whose name is missing; unknown names may be theirs.
        repaired: Whether the text had mistakes and was read in full after their repair.
    """

    source: SourceText
    statements: tuple[Statement, ...]
    unread: frozenset[str] = frozenset()
    used: tuple[Statement, ...] = ()
    lost_variable: bool = False
    lost_input: bool = False
    lost_file: bool = False
    nameless: frozenset[str] = frozenset()
    repaired: bool = False
