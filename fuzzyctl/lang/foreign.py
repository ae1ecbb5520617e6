"""Notations of other tools: their words, lines that parse but are written for them, lines without a keyword."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any, Final, Literal

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.fixes import Fix, Replacement
from fuzzyctl.diagnostics.other_tools_words import PEER_REMARKS, PEER_WORDS
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, DISJUNCTIONS, IMPLICATIONS, MEMBERSHIP
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.lines import LogicalLine
from fuzzyctl.lang.mistakes import FORMS
from fuzzyctl.lang.syntax import NAME, FallbackClause, Table, Variable
from fuzzyctl.records import dataclass

_VALUES: Final[dict[str, tuple[str, ...]]] = {
    "and": tuple(CONJUNCTIONS),
    "or": tuple(DISJUNCTIONS),
    "implication": tuple(IMPLICATIONS),
    "aggregation": tuple(AGGREGATIONS),
    "defuzzifier": (
        *("centroid", "bisector", "som", "lom", "mom"),
        *("center_average", "weighted_average", "weighted_sum"),
    ),
    "activation": ("general", "first", "last", "highest", "lowest", "proportional", "threshold"),
}


@dataclass(frozen=True)
class Form:
    """How another tool writes a membership function.

    Args:
        tool: The tool.
        parameters: Its parameters in its order, by their names here.
    """

    tool: str
    parameters: tuple[str, ...]


def _forms(tool: str, **orders: str) -> dict[str, Form]:
    return {word: Form(tool, tuple(parameters.split())) for word, parameters in orders.items()}


#: Functions whose parameters have another order than here.
ORDERS: Final = {
    **_forms(
        "MATLAB",
        gaussmf="sigma mean",
        gauss2mf="sigma_left mean_left sigma_right mean_right",
        gbellmf="width slope center",
        sigmf="slope inflection",
        dsigmf="rising left falling right",
        psigmf="rising left falling right",
        linzmf="end start",
    ),
    **_forms("FCL", gbell="width slope center", sigm="slope inflection"),
}
#: Those of scikit-fuzzy, which are called with the universe first and take their parameters apart.
SCIKIT_ORDERS: Final = _forms(
    "scikit-fuzzy",
    gaussmf="mean sigma",
    gauss2mf="mean_left sigma_left mean_right sigma_right",
    gbellmf="width slope center",
    sigmf="inflection slope",
    dsigmf="left rising right falling",
    psigmf="left rising right falling",
)
#: Words of other tools that a misspelt membership function may be like; 'gauss' is too like 'gauss2'.
PEER_KINDS: Final = tuple(w for w, meant in PEER_WORDS.items() if meant and meant[0] in MEMBERSHIP and w != "gauss")


def known_kind(word: str) -> str | None:
    """Return the membership function that a word means, in capitals, with other underscores or in another tool."""
    return word if word in MEMBERSHIP else _meant(word, tuple(MEMBERSHIP))


def differing_order(kind: str, word: str) -> str:
    """Return how the order of parameters differs in another tool; an empty string for the same order.

    Args:
        kind: The membership function.
        word: Its name, for which the order of MATLAB counts, or a word of another tool.
    """
    # MATLAB's linsmf has the order of the ramp here; only linzmf, by its own name, has another.
    theirs = word if word in ORDERS else next((w for w in ORDERS if known_kind(w) == kind != "ramp"), None)
    if theirs is None:
        return ""
    form, ours = ORDERS[theirs], ", ".join(MEMBERSHIP[kind].parameters)
    return f"{form.tool} writes {theirs}({', '.join(form.parameters)}), here it is {kind}({ours}): the order differs"


def is_value(keyword: str, word: str) -> bool:
    """Whether a word is a value of a setting."""
    return word in _VALUES.get(keyword, ())


def known_setting(keyword: str, word: str) -> str | None:
    """Return the value of a setting that a word of another tool means; None for a value and for an unknown word."""
    values = _VALUES.get(keyword, ())
    return None if word in values else _meant(word, values)


def remark(word: str) -> str:
    """Return a remark on a word of another tool, or an empty string."""
    return PEER_REMARKS.get(_bare(word), "")


def _meant(word: str, values: tuple[str, ...]) -> str | None:
    bare = _bare(word)
    same = next((v for v in values if _bare(v) == bare), None)
    return same or next((w for w in PEER_WORDS.get(bare, ()) if w in values), None)


def _bare(word: str) -> str:
    return word.casefold().replace("_", "")


#: Words that are not hedges unless a file declares them: an antecedent or a consequent has run on.
_RUN_ON: Final = frozenset({"is", "unless", "else"})


def foreign(node: Any, text: str) -> Diagnostic | None:
    """Return the mistake of a parsed line in the notation of another tool; None for a valid line.

    Args:
        node: The line.
        text: The text of the whole file.
    """
    match node:
        case sx.TermLine(kind=kind, arguments=arguments):
            return _odd_term(kind, arguments)
        case sx.Setting(keyword=keyword, value=value) | sx.Activation(keyword=keyword, kind=value):
            meant = known_setting(keyword.text, value.text)
            return None if meant is None else Diagnostic("FZ213", f"'{value.text}' is '{meant}' here", value.span)
        case sx.Variable(clauses=clauses):
            settings = (foreign(c.setting, text) for c in clauses if isinstance(c, sx.SettingClause))
            return next((d for d in settings if d is not None), None)
        case sx.Rule(antecedent=antecedent, consequents=consequents):
            words = [*_hedges(antecedent), *(h for c in consequents for h in c.hedges)]
            odd = next((w for w in words if _runs_on(w.text, text)), None)
            return None if odd is None else Diagnostic("FZ102", f"unexpected '{odd.text}'", odd.span)
    return None


def _odd_term(kind: sx.Word, arguments: tuple[sx.Argument, ...]) -> Diagnostic | None:
    formula = MEMBERSHIP.get(kind.text)
    if formula is None:
        is_other = kind.text not in ("linear", "function") and known_kind(kind.text) is not None
        return Diagnostic("FZ202", f"no membership function '{kind.text}'", kind.span) if is_other else None
    arity, positional = len(formula.parameters), sum(a.keyword is None for a in arguments)
    if not formula.variadic and (positional > arity or len(arguments) < arity):
        return Diagnostic("FZ303", f"'{kind.text}' takes {arity} parameters", kind.span)
    return None


def _runs_on(hedge: str, text: str) -> bool:
    return hedge.lower() in _RUN_ON and not re.search(rf"(?m)^[ \t]*hedge[ \t]+{hedge}\b", text)


def _hedges(truth: sx.Truth) -> Iterator[sx.Word]:
    match truth:
        case sx.Literal(hedges=hedges):
            yield from hedges
        case sx.Negation(operand=operand) | sx.Group(operand=operand):
            yield from _hedges(operand)
        case sx.Chain(operands=operands):
            for operand in operands:
                yield from _hedges(operand)


#: Words that begin a line with the value of an output without a rule, as FCL and others write it, and such a line.
ELSE_WORDS: Final = ("else", "default", "otherwise")
_ELSE_LINE: Final = (
    rf"(?i)\s*({'|'.join(ELSE_WORDS)})\b\s*(?::=|=|:)?\s*([-+]?(?:\d+[.,]?\d*|\.\d+)|hold|midpoint|nan|error|nc)"
    r"[\s;.]*(?:(?://|%).*)?"
)


def misplaced_else(source: SourceText, line: LogicalLine, above: Any) -> Diagnostic | None:
    """Return the mistake of a line such as `default 5`, with a fix of both lines; None for any other line.

    Args:
        source: The text.
        line: The line.
        above: The statement above it.
    """
    match = re.compile(_ELSE_LINE).fullmatch(source.text, line.start, line.end)
    if match is None or not isinstance(above, Variable) or above.keyword.text != "output" or above.value is not None:
        return None
    if any(isinstance(clause, FallbackClause) for clause in above.clauses):
        return None
    value = match[2].lower().replace(",", ".")
    value = "hold" if value == "nc" else value  # FCL: no change
    after = source.text.find("\n", line.end) + 1
    whole = Span(source, line.start, line.end if line.comment or not after else after)
    end = Span(source, above.span.end, above.span.end)
    return Diagnostic(
        "FZ101",
        f"'{match[1]}' does not begin a statement: the value of an output where no rule fires has its own line",
        Span(source, *match.span(1)),
        help=f"write: {above.span.text.strip()} else {value}",
        fix=Fix((Replacement(end, f" else {value}"), Replacement(whole, "")), "sure"),
    )


#: A line without a keyword: the head of a variable or a table, or a header whose table is missing.
Headless = Literal["variable", "table", "header", ""]

_VARIABLE: Final = rf'\s*{NAME}\s+(?:"[^"\n]*"\s*)?in\s*\['
_CROSS: Final = rf'(?:\s+(?:x|×)\s+{NAME})(?:\s+from\s+"[^"\n]*")?|\s+from\s+"[^"\n]*"'
_TABLE: Final = rf"\s*{NAME}(?:\s*,\s*{NAME})*\s*=\s*{NAME}({_CROSS})?\s*"
_BARRED_TERM: Final = rf"\s*{NAME}\s*\|\s*(?:{'|'.join(MEMBERSHIP)})\s*\("
_DECLARES: Final = "input|output|hedge|param|function|let|state|next|der|block|measure|controller|plant|loop"
_NAMELESS: Final = rf"\s*(?:input|output)\s+in\s*\[|\s*(?:{_DECLARES})\b(?!\s*{NAME})"
_NAMELESS_PARAM: Final = rf"\s*param\s*=(?!\s*{NAME}\s*\()"
_NAMES: Final = rf"\s*{NAME}(?:\s+{NAME})*\s*"


def headless(source: SourceText, line: LogicalLine, below: LogicalLine | None) -> Headless:
    """Return which head a line without a keyword is; an empty string for any other line.

    Args:
        source: The text.
        line: A line that begins with no keyword.
        below: The next line with code, None at the end.
    """
    text = line.code(source)
    # Settings and other statements of names only are not headers.
    following = below.code(source) if below is not None and below.kind != "statement" else ""
    if re.match(_VARIABLE, text):
        return "variable"
    table = re.fullmatch(_TABLE, text)
    # `a = b` alone may be a param or a term; above a line of names it is a one-way table.
    if table is not None and (table[1] or re.fullmatch(_NAMES, following)):
        return "table"
    if re.fullmatch(_NAMES, text) and below is not None and below.kind == "row":
        return "header"
    return ""


def is_nameless(source: SourceText, line: LogicalLine) -> bool:
    """Whether a line that could not be read, or that looks like a term line, is a declaration without its name."""
    # A term may be called `param`, but then a membership function follows.
    pattern = _NAMELESS_PARAM if line.kind == "term_line" else _NAMELESS
    return re.match(pattern, line.code(source)) is not None


def looks_like_variable(source: SourceText, line: LogicalLine) -> bool:
    """Whether a line that begins with no keyword has a range, as only the head of a variable has."""
    return re.search(r"\bin\s*\[", line.code(source)) is not None


def looks_like_term(source: SourceText, line: LogicalLine) -> bool:
    """Whether a line with a bar is a term line rather than the row of a table."""
    return "=" in line.code(source) or re.match(_BARRED_TERM, line.code(source)) is not None


def is_barless_row(source: SourceText, line: LogicalLine, columns: int, labelled: bool) -> bool:
    """Whether a line below the header of a table is a row but for its bar: as many cells as there are columns."""
    words = line.code(source).split()
    if len(words) != columns + labelled or "is" in words or "then" in words:
        return False
    return all(re.fullmatch(r"[^\s=|\"<>:;]+", word) for word in words)


def describe_barless(source: SourceText, rows: Sequence[LogicalLine], table: object) -> Diagnostic:
    """Return the diagnostic for all rows of a table that lack their bar."""
    place = rows[0].place(source)
    text = place.text
    labelled = isinstance(table, Table) and table.second is not None
    first_word, *others = re.split(r"\s+" if "(" in text else r"[\s,;]+", text.rstrip(",;"))
    label, cells = (first_word, " ".join(others)) if labelled and others else ("", " ".join([first_word, *others]))
    more = len(rows) - 1
    facts = (f"and so {'does' if more == 1 else 'do'} {counted(more, 'other row')}",) if more else ()
    return Diagnostic(
        "FZ102", "the row lacks its bar", place, facts=facts, help=f"write '{f'{label} | {cells}'.strip()}'"
    )


def describe_headless(source: SourceText, line: LogicalLine, head: Headless) -> Diagnostic:
    """Return the diagnostic for a head without its keyword, one for its whole block."""
    if head == "header":
        message = "unexpected table header outside of a table"
        return Diagnostic("FZ110", message, line.place(source), help=f"the form is: {FORMS['table']}")
    keyword, form = ("input' or 'output", "output") if head == "variable" else ("table", "table")
    message = f"a line that declares a {head} begins with '{keyword}', not with '{line.word}'"
    help_text = f"put the keyword before it; the form is: {FORMS[form]}"
    return Diagnostic("FZ101", message, line.word_place(source), help=help_text)


#: Each format with the suffix of its files and how they begin. No rule file begins in one of these ways.
_BEGINNINGS: Final[tuple[tuple[str, str, str], ...]] = (
    ("a file of MATLAB or Octave", ".fis", r"\[System\]"),
    ("a fuzzylite file", ".fll", r"Engine[ \t]*:"),
    ("an FCL file", ".fcl", r"FUNCTION_BLOCK\b"),
    ("an FML file", ".fml", r"<\?xml\b|<(?:\w+:)?Fuzzy(?:Controller|System)\b"),
)

#: Empty lines and comments of any of these formats, matched without backtracking.
_BEFORE: Final = r"(?s:\s|(?:[#%]|//)[^\n]*|\(\*.*?\*\))*+"


def other_format(source: SourceText) -> Diagnostic | None:
    """Return the mistake of a file in the format of another tool; None for any other file."""
    for name, suffix, beginning in _BEGINNINGS:
        match = re.match(rf"{_BEFORE}((?i:{beginning}))", source.text)
        if match is not None:
            help_text = f"save it under a name that ends with '{suffix}', by which it is known"
            return Diagnostic("FZ101", f"this is {name}, not a rule file", Span(source, *match.span(1)), help=help_text)
    return None
