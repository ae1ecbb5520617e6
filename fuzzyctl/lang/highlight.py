"""Syntax highlighting of rule files: one list of patterns, as a Pygments lexer and as a TextMate grammar.

A pattern belongs to one line; where two fit, the earlier one counts. Keywords are soft, so a word is one where it
begins a line, or where only rules and clauses have it.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

from pygments.lexer import RegexLexer, bygroups
from pygments.token import (
    Comment,
    Keyword,
    Name,
    Number,
    Operator,
    Punctuation,
    String,
    Whitespace,
)

from fuzzyctl.expr import CONSTANTS, FUNCTIONS
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.lang.syntax import BLOCK_KEYWORDS, NAME, STATEMENT_KEYWORDS

#: Words of the language that stand within a line.
CLAUSES: Final = (
    "adaptive",
    "always",
    "and",
    "clamp",
    "else",
    "extrapolate",
    "forever",
    "from",
    "in",
    "is",
    "not",
    "of",
    "or",
    "rate",
    "scale",
    "step",
    "then",
    "unit",
    "unless",
    "until",
    "weight",
    "when",
    "within",
)

#: Functions of controllers with state, and the others that only controllers have.
OPERATORS: Final = (
    "delay", "derivative", "difference", "hysteresis", "integral", "lowpass", "previous", "rate_limit",
)  # fmt: skip
CONTROLLER_FUNCTIONS: Final = ("clamp", "where")
#: Plants of one line, signals and measures of loops.
LOOP_FUNCTIONS: Final = (
    "csv", "effort", "final", "fmu", "iae", "ise", "itae", "maximum", "mean", "minimum", "noise", "overshoot", "pair",
    "pulse", "python", "ramp", "rise_time", "rms", "settling", "sine", "ss", "steady_state_error", "steps", "tf", "zpk",
)  # fmt: skip

#: Words that are consequents where a parenthesis follows.
CONSEQUENTS: Final = ("constant", "function", "linear")
#: Words that behind `else` may have a parenthesis.
FALLBACKS: Final = ("hold",)

#: Statements that give something a name.
DECLARATIONS: Final = (
    "block",
    "controller",
    "der",
    "disturbance",
    "function",
    "hedge",
    "input",
    "let",
    "loop",
    "measure",
    "next",
    "output",
    "param",
    "plant",
    "rules",
    "state",
    "system",
)

#: The kind of a piece of text: its scope in a TextMate grammar, and its token in Pygments.
TOKENS: Final[dict[str, Any]] = {
    "comment.line.number-sign.fz": Comment.Single,
    "string.quoted.double.fz": String.Double,
    "keyword.control.fz": Keyword,
    "variable.other.declaration.fz": Name.Variable,
    "support.function.fz": Name.Builtin,
    "constant.language.fz": Name.Constant,
    "constant.numeric.fz": Number,
    "variable.other.fz": Name,
    "keyword.operator.fz": Operator,
    "punctuation.separator.fz": Punctuation,
    "": Whitespace,
}

_COMMENT, _STRING, _KEYWORD, _DECLARED, _FUNCTION, _CONSTANT, _NUMBER, _NAME, _OPERATOR, _PUNCTUATION, _BLANK = TOKENS


def _any(words: Iterable[str]) -> str:
    """Return a pattern for any of some words; longer ones first, since the first that fits counts."""
    return "|".join(sorted(set(words), key=lambda w: (-len(w), w)))


_LEAD = r"^([ \t]*)"
#: A statement's keyword is a name where `=` or `|` follows: `table = triangle(...)` is a term.
_STATEMENT = r"\b(?![ \t]*[=|])"

_CALLED = (*MEMBERSHIP, *FUNCTIONS, *CONSEQUENTS, *FALLBACKS, *OPERATORS, *CONTROLLER_FUNCTIONS, *LOOP_FUNCTIONS)

#: Each pattern with its scopes: one for the whole match, or one for each group, which then cover all of it.
PATTERNS: Final[tuple[tuple[str, str | tuple[str, ...]], ...]] = (
    (r"#[^\n]*", _COMMENT),
    (r'"[^"\n]*"', _STRING),
    (rf"{_LEAD}(allow|deny)({_STATEMENT})([^\"#\n]*)", (_BLANK, _KEYWORD, _BLANK, _CONSTANT)),
    (rf"{_LEAD}({_any(DECLARATIONS)})({_STATEMENT}[ \t]+)({NAME})", (_BLANK, _KEYWORD, _BLANK, _DECLARED)),
    (
        rf"{_LEAD}(table)({_STATEMENT}[^=\n]*)(=)([ \t]*)({NAME})([ \t]+)(x\b|×)",
        (_BLANK, _KEYWORD, _NAME, _OPERATOR, _BLANK, _NAME, _BLANK, _KEYWORD),
    ),
    (rf"{_LEAD}(require)([ \t]+)(stable)(?=[ \t]*(?:#|$))", (_BLANK, _KEYWORD, _BLANK, _KEYWORD)),
    (rf"{_LEAD}({_any([*STATEMENT_KEYWORDS, *BLOCK_KEYWORDS])})({_STATEMENT})", (_BLANK, _KEYWORD, _BLANK)),
    (rf"{_LEAD}({NAME})([ \t]*)(=)", (_BLANK, _DECLARED, _BLANK, _OPERATOR)),
    (rf"{_LEAD}({NAME})([ \t]*)(\|)", (_BLANK, _NAME, _BLANK, _OPERATOR)),
    (rf"\b(?:{_any(_CALLED)})(?=[ \t]*\()", _FUNCTION),
    (rf"\b(?:{_any(CONSTANTS)})\b", _CONSTANT),
    (rf"\b(?:{_any(CLAUSES)})\b", _KEYWORD),
    (r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?(?:[ \t]*(?:%|(?:us|ms|s|min|h)(?!\w))|(?![\w.]))", _NUMBER),
    (NAME, _NAME),
    (r"<=|>=|==|!=|[-+*/^<>=|@.]", _OPERATOR),
    (r"[()\[\],:]", _PUNCTUATION),
    (r"[ \t\r]+", _BLANK),
)


def _action(scopes: str | tuple[str, ...]) -> Any:
    return TOKENS[scopes] if isinstance(scopes, str) else bygroups(*(TOKENS[s] for s in scopes))


class FuzzyLexer(RegexLexer):  # type: ignore[misc]  # pygments has no types
    """The Pygments lexer of rule files: `pygmentize -l fz`, Sphinx, MkDocs."""

    name = "fuzzyctl rules"
    aliases = ("fz", "fuzzyctl")
    filenames = ("*.fz",)
    mimetypes = ("text/x-fuzzyctl",)
    url = ""

    tokens: Final[dict[str, list[tuple[str, Any]]]] = {
        "root": [*((pattern, _action(scopes)) for pattern, scopes in PATTERNS), (r"\n", Whitespace)]
    }


def textmate() -> dict[str, Any]:
    """Return the TextMate grammar that docs/editors/fz.tmLanguage.json holds."""
    return {
        "name": "fuzzyctl rules",
        "scopeName": "source.fz",
        "fileTypes": ["fz"],
        "patterns": [_textmate(pattern, scopes) for pattern, scopes in PATTERNS if scopes != _BLANK],
    }


def _textmate(pattern: str, scopes: str | tuple[str, ...]) -> dict[str, Any]:
    if isinstance(scopes, str):
        return {"match": pattern, "name": scopes}
    captures = {str(i): {"name": scope} for i, scope in enumerate(scopes, start=1) if scope}
    return {"match": pattern, "captures": captures}
