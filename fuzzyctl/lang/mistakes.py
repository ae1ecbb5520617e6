"""Diagnostics of syntax errors: the token found, the tokens expected, and the likely repair."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.fixes import Fix, Replacement, respelt
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import closest, look_alikes
from fuzzyctl.expr import MAX_DEPTH
from fuzzyctl.lang.lines import LogicalLine, keyword_behind
from fuzzyctl.lang.syntax import BLOCK_KEYWORDS, BLOCKS, NAME, STATEMENT_KEYWORDS

if TYPE_CHECKING:
    from lark.exceptions import UnexpectedInput, UnexpectedToken

#: Characters that have a spelling of their own here.
SPELLINGS: Final = {"≤": "<=", "≥": ">=", "≠": "!=", "−": "-", "–": "-", "—": "-", "·": "*", "⋅": "*", "∞": "inf"}

_DASH: Final = r"(?:^|[\s|])[-–—]\s*$"
_CORNER: Final = rf"\s*({NAME}\s*[\\/]\s*{NAME})(?:\s*\|)?(?=\s)"

#: The help of a cell without a rule.
NO_RULE: Final = "write '.' where there is to be no rule"


def repair(source: SourceText, line: LogicalLine, at: int) -> str:
    """Return the correct form of a known slip where the parser stopped, or an empty string.

    Args:
        source: The text.
        line: The line that cannot be read.
        at: The offset of the unexpected token, or the end of the line.
    """
    text = source.text
    if line.kind == "row" and (at == line.end or text[at - 1].isspace()) and re.search(_DASH, text[line.start : at]):
        return NO_RULE
    if text[at - 1 : at + 1] == "**":
        return "write '^' for a power"
    if line.word == "table" and re.match(r"[x×]\s", text[at : at + 2]):
        return "for a third variable put 'with VARIABLE is TERM' above a table for each of its terms"
    if line.word == "require" and text.startswith("within", at):
        return "write 'within' once, and before 'when'"
    if line.word == "require" and line.in_block == "loop" and text.startswith("when", at):
        return "put the condition into the claim, such as: a <= 1 or b > 2"
    if line.word == "require" and line.in_block == "loop":
        word = re.fullmatch(r"\s*require\s+(\w+)\s+", text[line.start : at])
        return "did you mean 'always'?" if word is not None and closest(word[1], ("always",)) else ""
    return ""


def corner(source: SourceText, line: LogicalLine) -> tuple[int, int] | None:
    r"""Return the offsets of a printed corner of a table, such as e\de; None without one."""
    match = re.compile(_CORNER).match(source.text, line.start, line.end) if line.kind in ("header", "row") else None
    return match.span(1) if match is not None else None


#: How each statement is written: the help of a broken one.
FORMS: Final[dict[str, str]] = {
    "fz": "fz 1",
    "system": 'system NAME "title"',
    "source": 'source "where it comes from"',
    "use": 'use "file.fz"',
    "semantics": "semantics exact | matlab | fuzzylite(least=0, ...) | ...",
    "and": "and min | product | ...",
    "or": "or max | probabilistic_sum | ...",
    "implication": "implication min | product | ...",
    "aggregation": "aggregation max | sum | ...",
    "activation": "activation general | first(count=2, threshold=0.1) | highest(count=1) | threshold(>= 0.5) | ...",
    "defuzzifier": "defuzzifier centroid | centroid(resolution=1000) | center_average | weighted_average | ...",
    "param": 'param NAME = expression unit "..."',
    "hedge": "hedge NAME(x) = expression over x",
    "function": "function NAME(a, b) = expression over a and b",
    "controller": 'controller NAME "title"',
    "plant": 'plant NAME "title", or plant NAME = tf(num=[...], den=[...])',
    "loop": 'loop NAME "title"',
    "input": 'input NAME "label" in [low, high] unit "..."',
    "output": 'output NAME "label" in [low, high] unit "..." else VALUE',
    "terms": "terms NB@-1 ZO@0 PB@1, or terms NB ZO PB, or terms NB=0 ZO=0 PB=0",
    "rules": "rules NAME and product or max implication min activation highest(count=1) (above tables and rules)",
    "with": "with INPUT is TERM (above a table)",
    "table": "table OUTPUT = ROW_INPUT x COLUMN_INPUT, or table OUTPUT = INPUT",
    "if": "if INPUT is TERM and INPUT is TERM then OUTPUT is TERM weight 0.5",
    "otherwise": "otherwise OUTPUT is TERM weight 0.5",
    "require": "require EXPRESSION >= EXPRESSION within 1e-12 when CONDITION",
    "allow": 'allow FZ208 "reason"',
    "deny": 'deny FZ208 "reason"',
}

#: How a part that nests too deeply can be split, by its kind.
_SPLIT: Final[dict[str, str]] = {
    "antecedent": "split it: let other rules set an output from some of the inputs, and read that output here",
    "expression": "split it: give parts a name with 'let', or with 'param' where no input is read",
}

#: The form in a system of `let NAME = EXPRESSION` of controllers.
LET_FORM: Final = 'let NAME "label" in [low, high] unit "..." = EXPRESSION; label, range and unit may be left out'

#: How the statements of controllers, plants and loops are written where systems have none or another form.
BLOCK_FORMS: Final[dict[str, str]] = {
    **{k: FORMS[k] for k in BLOCK_KEYWORDS if k in FORMS},
    "param": 'param NAME in [low, high] = expression unit "..."',
    "input": 'input NAME "label" in [low, high] unit "..."',
    "output": 'output NAME "label" in [low, high] unit "..." = EXPRESSION',
    "state": 'state NAME "label" in [low, high] unit "..." = START',
    "let": "let NAME = EXPRESSION",
    "next": "next STATE = EXPRESSION",
    "der": "der STATE = EXPRESSION",
    "every": "every 5 ms",
    "block": "block NAME = CONTROLLER(input, ..., param=value)",
    "measure": 'measure NAME "label" unit "..." = MEASURE(signal, ...)',
    "run": "run 50 s step 10 ms",
    "for": "for BLOCK.STATE in [low, high], or for PARAM in [low, high]",
    "disturbance": 'disturbance NAME "label" in [low, high] unit "..." = VALUE',
}

#: The claims of loops.
CLAIMS: Final = "require MEASURE <= NUMBER, require always CONDITION from 20 s until 50 s, or require stable"

#: What to write in place of a statement of another block, by its word and the block that it is found in.
_IN_PLACE: Final[dict[tuple[str, str], str]] = {
    ("der", "controller"): "a controller is sampled; write: next STATE = STATE + dt * EXPRESSION",
    ("next", "plant"): "a plant is continuous; write: der STATE = EXPRESSION, the derivative of the state by time",
    ("every", "plant"): "a plant is continuous; give the sample time in a controller",
    ("every", "loop"): "give the sample time in a controller, and the step of the record as: run 50 s step 10 ms",
    ("block", "plant"): "connect blocks in a loop",
    ("require", "plant"): "state the claim in a loop, about a measure",
    ("output", "loop"): "write: let NAME = EXPRESSION",
    ("input", "loop"): "write a signal of time, such as: let NAME = steps(0: 1.0)",
    ("state", "loop"): "put it into a plant or a controller, and add that as a block",
    ("next", "loop"): "put it into a controller, and add that as a block",
    ("der", "loop"): "put it into a plant, and add that as a block",
    ("measure", "controller"): "put it into a loop",
    ("measure", "plant"): "put it into a loop",
    ("run", "controller"): "put it into a loop",
    ("run", "plant"): "put it into a loop",
    **{(word, head): "put it into a loop" for word in ("for", "disturbance") for head in ("controller", "plant")},
}

#: How an equation chooses between two values, and what other languages write in its place.
CHOICE: Final = "a choice is written: where(CONDITION, VALUE, OTHER_VALUE)"
_CHOOSES: Final = r"(?<![<>=!])=(?!=)[^#\n]*?(?:\b(?:if|when)\b|\?)"

_BELOW: Final[dict[str, str]] = {
    "term_line": "NAME = triangle(left, peak, right)",
    "header": "the terms of the columns, separated by blanks",
    "row": "TERM | cells separated by blanks, '.' for no rule",
    "label": "a term in each field; fields are parted by commas",
    "cell": "a term, a number, TERM*0.5, or '.' for no rule; what holds commas stands in double quotes",
}

#: Terminals of the grammar in words; all others are keywords and stand for themselves.
_TERMINALS: Final[dict[str, str]] = {
    "NAME": "a name",
    "NUMBER": "a number",
    "QUANTITY": "a number",
    "STRING": 'a text in "quotes"',
    "COMPARE": "a comparison (<, <=, >, >=, ==, !=)",
    "SUM": "+ or -",
    "PRODUCT": "* or /",
    "POWER": "^",
    "DOT": "'.'",
    "LPAR": "'('",
    "RPAR": "')'",
    "LSQB": "'['",
    "RSQB": "']'",
    "COMMA": "','",
    "EQUAL": "'='",
    "AT": "'@'",
    "VBAR": "'|'",
    "SLASH": "'/'",
    "STAR": "'*'",
    "COLON": "':'",
    "$END": "the end of the line",
}

#: Keywords inside rules.
RULE_WORDS: Final = frozenset({"is", "and", "or", "not", "then", "weight"})

_NO_TERM: Final = r"\bis\s+(and|or|then|\))(?!\w)"
#: A line that goes on with the rule above it.
_GOES_ON: Final = rf"\s*(and|or)\s+(?:if\b|not\b|\(|{NAME}\s+is\b)"
#: A comparison with a number in a condition.
_COMPARED: Final = r"(?<![-=<>])([<>]=?)\s*+([-+]?[\d.]++)"
#: The text in the place of the weight of a rule.
_NEAR_WEIGHT: Final = rf"(?<!\w)((?>{NAME}))\s++[-+]?(?:\.?\d\S*+|\([^()]*+\))\s*+(?:#.*)?$"


def too_deep(is_antecedent: bool, span: Span) -> Diagnostic:
    """Return the mistake of an antecedent or of an expression that nests deeper than its readers can go."""
    what = "antecedent" if is_antecedent else "expression"
    return Diagnostic("FZ106", f"the {what} nests deeper than {MAX_DEPTH} levels", span, help=_SPLIT[what])


def describe(source: SourceText, line: LogicalLine, error: UnexpectedInput) -> Diagnostic:
    """Return the diagnostic for a line that the grammar refuses."""
    place = corner(source, line)
    if place is not None:
        help_text = "leave it out: the header line holds the terms of the columns and nothing else"
        return Diagnostic("FZ102", "a table of a rule file has no corner", Span(source, *place), help=help_text)
    help_text = (
        CHOICE if line.in_block and re.compile(_CHOOSES).search(source.text, line.start, line.end) else form_of(line)
    )
    from lark.exceptions import UnexpectedCharacters, UnexpectedToken  # here, since only broken lines need them

    if isinstance(error, UnexpectedCharacters):
        position: Any = error.pos_in_stream
        return _bad_character(source, line, line.start + position, help_text)
    assert isinstance(error, UnexpectedToken)
    if error.token.type == "COLON":  # which only pairs of loops have
        return _bad_character(source, line, line.start + (error.token.start_pos or 0), help_text)
    expected = _expected(error)
    slip = _slip_in_a_rule(source, line)
    if slip is not None:
        return slip
    unit = "field" if line.kind in ("label", "cell") else "line"
    facts = (f"expected {expected.replace('end of the line', f'end of the {unit}')}",) if expected else ()
    token = error.token
    if token.type == "$END":
        where = Span(source, max(line.start, line.end - 1), line.end)
        repaired = repair(source, line, line.end) or help_text
        return Diagnostic("FZ102", f"the {unit} ends too early", where, facts=facts, help=repaired)
    start = line.start + (token.start_pos or 0)
    return Diagnostic(
        "FZ102",
        f"unexpected '{token}'",
        Span(source, start, start + len(token)),
        facts=facts,
        help=repair(source, line, start) or (help_text if line.word == "fz" else _repair(error, help_text)),
    )


def form_of(line: LogicalLine) -> str:
    """Return how a line of its kind is written, as the repair of a broken one."""
    forms = BLOCK_FORMS if line.in_block else FORMS
    form = forms.get(line.word, "") if line.kind in ("statement", "block_statement") else _BELOW.get(line.kind, "")
    form = CLAIMS if line.word == "require" and line.in_block == "loop" else form
    return f"the form is: {form}" if form else ""


def _slip_in_a_rule(source: SourceText, line: LogicalLine) -> Diagnostic | None:
    """Find a word of a rule that is a keyword but for its capitals, or that is found where a term is expected."""
    goes_on = re.compile(_GOES_ON).match(source.text, line.start, line.end) if line.word in ("and", "or") else None
    if goes_on is not None:
        message = f"'{goes_on[1]}' does not continue a rule: a rule is one line, which goes on inside parentheses"
        help_text = f"the form is: if (INPUT is TERM {goes_on[1]} INPUT is TERM) then OUTPUT is TERM"
        return Diagnostic("FZ102", message, Span(source, *goes_on.span(1)), help=help_text)
    if line.word not in ("if", "with"):
        return None
    lacking = re.compile(_NO_TERM).search(source.text, line.start, line.end)
    if lacking is not None:
        place = Span(source, lacking.start(1), lacking.end(1))
        return Diagnostic(
            "FZ102", f"a term is missing before '{lacking[1]}'", place, help=f"the form is: {FORMS['if']}"
        )
    then = re.compile(r"\bthen\b").search(source.text, line.start, line.end)
    compared = re.compile(_COMPARED).search(source.text, line.start, line.end if then is None else then.start())
    if compared is not None:
        return _comparison(source, compared)
    late = re.compile(_NEAR_WEIGHT).search(source.text, line.start, line.end)
    if late is not None and late[1] != "weight" and closest(late[1], ["weight"]):
        place = Span(source, late.start(1), late.end(1))
        help_text = f"did you mean 'weight'? the form is: {FORMS['if']}"
        return Diagnostic("FZ102", f"unexpected '{late[1]}'", place, help=help_text)
    for match in re.compile(NAME).finditer(source.text, line.start, line.end):
        small = match[0].lower()
        if small in RULE_WORDS and match[0] != small:
            return capital_keyword(match[0], Span(source, match.start(), match.end()))
    return None


def _comparison(source: SourceText, comparison: re.Match[str]) -> Diagnostic:
    sign, number = comparison[1], comparison[2]
    ends = f"-inf, {number}" if sign[0] == "<" else f"{number}, inf"
    help_text = f"declare a term of the input, such as: LIMIT = rectangle({ends}), and write: INPUT is LIMIT"
    message = "the condition of a rule compares with terms, not with numbers"
    return Diagnostic("FZ102", message, Span(source, *comparison.span(1)), help=help_text)


def capital_keyword(word: str, place: Span, code: str = "FZ102") -> Diagnostic:
    """Return the diagnostic for a keyword in capitals."""
    message = f"'{word}' is not a keyword: keywords are written small"
    fix = Fix((Replacement(place, word.lower()),), "sure")
    return Diagnostic(code, message, place, help=f"write '{word.lower()}'", fix=fix)


def _expected(error: UnexpectedToken) -> str:
    """List the words that may be at the place, most useful first; operators that may always follow are left out."""
    accepted = set(error.accepts or error.expected or ()) - {"MEMBER", "COLON"}
    if "NUMBER" in accepted:  # lists and texts are arguments of a few functions only
        accepted -= {"LSQB", "STRING"}
    if "$END" in accepted or accepted & {"RPAR", "RSQB", "COMMA"}:
        accepted -= {"SUM", "PRODUCT", "POWER", "COMPARE", "AND", "OR"}
    words = sorted({_TERMINALS.get(t, f"'{t.removeprefix('K_').lower()}'") for t in accepted})
    if len(words) > 6:
        return ""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}" if words else ""


def _repair(error: UnexpectedToken, help_text: str) -> str:
    if error.token.type == "IS" and "then" in help_text:
        # A word in the place of `then` was taken for a hedge.
        return f"is 'then' missing or misspelt? {help_text}"
    accepted = set(error.accepts or error.expected or ())
    if error.token.type == "NAME" and "NUMBER" in accepted and "NAME" not in accepted:
        # Only a number or parentheses may stand here.
        sign = "" if "SUM" in accepted else "with its sign "
        param = f"put a param {sign}in parentheses, such as ({'' if 'SUM' in accepted else '-'}{error.token})"
        cell = "; the weight of a term is written TERM*0.5, a formula of inputs function(...)"
        return param + cell if "for no rule" in help_text else param
    keywords = [t.removeprefix("K_").lower() for t in accepted - {"MEMBER"} if t not in _TERMINALS and t.isalpha()]
    near = closest(str(error.token), keywords) if error.token.type == "NAME" else None
    return f"did you mean '{near}'? {help_text}".strip() if near else help_text


def _bad_character(source: SourceText, line: LogicalLine, at: int, help_text: str) -> Diagnostic:
    char = source.text[at]
    place = Span(source, at, at + 1)
    if char.isdigit() or (char == "." and source.text[at + 1 : at + 2].isdigit()):
        return _bad_number(source, at, help_text)
    if char == "'":
        return Diagnostic("FZ105", "expected double quotes around a text", place, help='write "..."')
    if char.isprintable() and (char.isascii() or not unicodedata.name(char, "")):
        return Diagnostic("FZ105", f"unexpected '{char}'", place, help=help_text)
    if char in SPELLINGS:
        is_dash = line.kind == "row" and unicodedata.category(char) == "Pd"
        help_text = NO_RULE if is_dash else f"write '{SPELLINGS[char]}'"
    name = unicodedata.name(char, "a control character")
    character = f"'{char}' (U+{ord(char):04X}, {name})" if char.isprintable() else f"U+{ord(char):04X} ({name})"
    return Diagnostic("FZ105", f"unexpected {character}", place, help=help_text)


def _bad_number(source: SourceText, at: int, help_text: str) -> Diagnostic:
    """Return the diagnostic of a number with digits of another script, or one that runs into letters."""
    number = re.compile(r"[\w.]+").match(source.text, at)
    assert number is not None
    foreign = next((i for i in range(at, number.end()) if not source.text[i].isascii()), None)
    if foreign is None or not source.text[foreign].isdigit():
        place = Span(source, at, at + 1)
        return Diagnostic("FZ102", "a number is malformed or runs into letters", place, help=help_text)
    char = source.text[foreign]
    character = f"'{char}' (U+{ord(char):04X}, {unicodedata.name(char, 'a digit')})"
    digit = unicodedata.decimal(char, None)
    return Diagnostic(
        "FZ105",
        f"{character} is not a digit of a number",
        Span(source, foreign, foreign + 1),
        help=f"write '{digit}'" if digit is not None else help_text,
    )


def meant_keyword(word: str) -> str | None:
    """Return the keyword that the first word of a line most likely means."""
    return _meant(word, STATEMENT_KEYWORDS)


def _meant(word: str, keywords: Sequence[str]) -> str | None:
    small = word.lower()
    if small in keywords:
        return small
    return closest(word, keywords) if len(word) > 2 else None


def describe_unknown_line(source: SourceText, line: LogicalLine, block: str) -> Diagnostic:
    """Return the diagnostic for a line that begins with no keyword and fits nothing above it."""
    text, start = line.code(source), line.place(source).start
    if not line.word:
        char = source.text[start]
        if not char.isascii() or not char.isprintable():
            return _bad_character(source, line, start, "")
        return Diagnostic(
            "FZ101",
            f"a line cannot begin with '{char}'",
            Span(source, start, start + 1),
            facts=(_keywords(STATEMENT_KEYWORDS),),
        )
    place = line.word_place(source)
    keywords = BLOCKS[line.in_block] if line.in_block else STATEMENT_KEYWORDS
    forms = BLOCK_FORMS if line.in_block else FORMS
    if line.word.lower() in keywords and line.word != line.word.lower():
        return capital_keyword(line.word, place, "FZ101")
    assigned = bool(line.in_block and re.match(r"\s*\w+\s*=", text))  # no keyword stands before '='
    near = None if assigned else _meant(line.word, keywords)
    if line.in_block and line.word in ("if", "when", "elif", "else") and not re.search(r"\bis\b", text):
        help_text = f"{CHOICE}, as the value of a 'let', 'next' or 'output'"
        return Diagnostic("FZ101", f"'{line.word}' does not begin a statement", place, help=help_text)
    if line.word in ("then", "is", "not") or (near != "if" and re.search(r"\bthen\b", text)):
        help_text = "a rule is one line, which goes on in the next only inside parentheses"
        return Diagnostic("FZ101", f"'{line.word}' does not begin a statement", place, help=help_text)
    if line.word in keywords:
        return Diagnostic("FZ102", "unexpected '=' or '|'", place, help=f"the form is: {forms[line.word]}")
    if line.word == "let" and not line.in_block:
        return Diagnostic("FZ101", "expected a name, then '='", place, help=f"the form is: {LET_FORM}")
    if line.word in BLOCK_FORMS or (line.in_block and line.word in FORMS):
        return _of_another_block(line, place)
    behind = keyword_behind(text)
    if behind is not None:
        help_text = f"remove '{line.word}'; the form is: {(forms | FORMS | BLOCK_FORMS)[behind]}"
        gap = re.match(r"\s*\w+\s+", text)
        fix = (
            Fix((Replacement(Span(source, start, line.start + gap.end()), ""),), "likely") if gap is not None else None
        )
        return Diagnostic("FZ101", f"'{line.word}' does not begin a statement", place, help=help_text, fix=fix)
    hint = f"did you mean '{near}'? the form is: {forms[near]}" if near else ""
    if not hint and block == "variable":
        hint = f"a term is written: {_BELOW['term_line']}"
    if assigned:
        assigning = (word for word in ("let", "der", "next", "output") if word in keywords)
        hint = f"write: {' or '.join(f'{word} {line.word} = ...' for word in assigning)}"
    facts = (*look_alikes(line.word), _keywords(keywords))
    fix = respelt(place, line.word, near, keywords)
    return Diagnostic("FZ101", f"'{line.word}' does not begin a statement", place, facts=facts, help=hint, fix=fix)


def _of_another_block(line: LogicalLine, place: Span) -> Diagnostic:
    """Return the diagnostic for a statement that only other blocks have."""
    heads = [head for head, words in BLOCKS.items() if line.word in words and head != "loop"]
    owner = next(iter(heads), "system" if line.word in FORMS else "loop")
    message = f"'{line.word}' belongs to a {owner}{f', not to a {line.in_block}' if line.in_block else ''}"
    help_text = _IN_PLACE.get((line.word, line.in_block), "")
    if not help_text and owner == "system":
        help_text = "put it below a 'system' line, and call that system"
    return Diagnostic("FZ101", message, place, help=help_text or f'put it below a line: {owner} NAME "title"')


def orphan(source: SourceText, line: LogicalLine, wanted: str) -> Diagnostic:
    """Return the diagnostic for a term line or a table line outside of a block."""
    place = line.place(source)
    if wanted == "variable":
        help_text = f"begin it with a keyword, such as: {FORMS['param']}" if line.kind == "term_line" else ""
        return Diagnostic("FZ110", "unexpected term outside of an input or output", place, help=help_text)
    return Diagnostic("FZ110", "unexpected table row outside of a table", place, help=f"the form is: {FORMS['table']}")


def _keywords(keywords: Sequence[str]) -> str:
    return f"statements begin with: {', '.join(keywords)}"
