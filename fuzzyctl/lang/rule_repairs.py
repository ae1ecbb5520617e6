"""Repairs of rules and guarantees in the notation of MATLAB, FCL, C and papers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Final

from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.expr import FUNCTIONS
from fuzzyctl.lang.edits import Edit, Repair, Surroundings
from fuzzyctl.lang.index_rules import index_rule
from fuzzyctl.lang.other_tools import known_kind
from fuzzyctl.lang.repair_patterns import NUMBER, by_pattern, head
from fuzzyctl.lang.syntax import NAME

_RULE_WORDS: Final = "is|and|or|not|then|weight"
_WORD: Final = rf"(?!(?:{_RULE_WORDS})\b){NAME}"
#: A decimal, with a comma where that is usual.
_WEIGHT: Final = r"\d+(?:[.,]\d*)?|[.,]\d+"
#: A formula without commas but those of calls.
_FORMULA: Final = r"(?:[^,()]|\((?:[^()]|\([^()]*\))*\))+?"
_IS: Final = "a variable and its term are joined by 'is'"
_MIXED: Final = "AND and OR are mixed; in other languages AND comes first"
_NO_ELSE: Final = "rules have no 'else'"
#: Words that are no misspelt 'and' or 'or'.
_OTHER_LOGIC: Final = frozenset({"and", "or", "then", "xor", "nor", "nand", "xnor", "andnot"})
_OPERATORS: Final = {"=": "==", "=>": ">=", "=<": "<=", "===": "==", "<>": "!=", "!==": "!="}


def _alternatives(groups: list[str], around: Surroundings) -> str | None:
    """Return `(e is A or e is B)` for `e is (A or B)`, negated for `e is not (A or B)`."""
    if groups[3] and "(" not in groups[4]:
        # What 'not' takes of 'not A or B' is open.
        return None
    if {"or", "and"} <= set(re.findall(NAME, groups[4])):
        return None
    variable, negation, names = groups[2], groups[3], re.split(r"\s+(or|and)\s+|\s*,\s*", groups[4].strip("() "))
    terms = [n for n in names if n and n not in ("or", "and")]
    joined = " and " if " and " in groups[4] else " or "
    whole = f"({joined.join(f'{variable} is {t}' for t in terms)})"
    return f"not {whole}" if negation else whole


def _otherwise(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Give a line that begins with `else` the negated condition of the rule above it, or `otherwise`."""
    found = re.match(r"\s*(else\b,?\s*(?:then\s+)?)(?!if\b)", code, re.IGNORECASE)
    above = [re.match(r"(?:else\s+)?if\s+(.*?)\s+then\b", rule, re.IGNORECASE) for rule in around.above]
    if found is None or " is " not in code.lower():
        return
    none = " and ".join(f"not ({_lowered(_bare(m[1]))})" for m in above if m is not None)
    condition = f"if {none} then " if above and all(above) else "otherwise "
    yield Edit(found.start(1), found.end(1), condition, _NO_ELSE)


def _else_behind(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Part `if A then B else C` into two rules."""
    found = re.match(r"\s*if\s+(.*?)\s+then\b.*?(,?\s*\belse\s+)(?=\S)", code, re.IGNORECASE)
    if found is not None:
        condition = text[found.start(1) : found.end(1)]
        yield Edit(found.start(2), found.end(2), f"\nif not ({_bare(condition)}) then ", _NO_ELSE)


def _lowered(condition: str) -> str:
    return re.sub(r"\b(?:IS|AND|OR|NOT)\b", lambda m: m[0].lower(), condition)


def _bare(condition: str) -> str:
    inner = re.fullmatch(r"\(([^()]*)\)", condition)
    return (inner[1] if inner is not None else condition).strip()


def _conjunction(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Replace `and` between consequents."""
    then = re.search(r"\bthen\b", code)
    if then is not None and head(code) == "if":
        for m in re.finditer(r"\s*\band\b\s*|(?<=\))\s*(?=\()", code[then.end() :]):
            yield Edit(then.end() + m.start(), then.end() + m.end(), ", ", "consequents are separated by ','")


def _parentheses(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Drop parentheses around consequents."""
    then = re.search(r"\bthen\b", code)
    if then is None or head(code) != "if":
        return
    for m in re.finditer(r"\(([^()]*\bis\b[^()]*)\)", code[then.end() :]):
        closing = then.end() + m.end() - 1
        follows = re.match(r"\s*\(\s*\w+\s+is\b", code[closing + 1 :])
        yield Edit(then.end() + m.start(), then.end() + m.start() + 1, "", "consequents have no parentheses")
        yield Edit(closing, closing + 1, ", " if follows else "", "consequents have no parentheses")


def _weight_in_parentheses(groups: list[str], around: Surroundings) -> str | None:
    value = (groups[3] or groups[4]).replace(",", ".")
    called = known_kind(groups[1]) is not None or groups[1] in FUNCTIONS
    return f" weight {value}" if not called and float(value) <= 1 else None


def _number_or_formula(groups: list[str], around: Surroundings) -> str | None:
    value = groups[2].strip()
    own = re.findall(rf"(?m)^\s*function\s+({NAME})", around.declared.text)
    unknown = set(re.findall(rf"({NAME})\s*\(", value)) - {*FUNCTIONS, *own}
    if any(value.startswith(name) or known_kind(name) for name in unknown):
        # A term before parentheses, or a membership function.
        return None
    names = set(re.findall(NAME, value))
    if re.fullmatch(rf"\(\s*{NAME}\s*\)", value) and not names <= around.declared.variables | around.declared.params:
        return None
    if (
        "-" in value
        and re.fullmatch(rf"{NAME}(?:-{NAME})+", value)
        and not names <= around.declared.variables | around.declared.params
    ):
        return value.replace("-", "_")
    return f"function({value})" if re.search(r"[-+*/^(]", value) else None


def _weight_of_term(groups: list[str], around: Surroundings) -> str | None:
    return None if groups[1] in around.declared.params | around.declared.variables else f" weight {groups[3]}"


def _misspelt_and(groups: list[str], around: Surroundings) -> str | None:
    word = groups[2].lower()
    return None if word in _OTHER_LOGIC else closest(word, ["and", "or", "then"])


def _grouped(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Put parentheses around the conjunctions of an antecedent that mixes AND and OR."""
    whole = re.match(r"\s*if\s+(.*?)\s+then\b", code)
    if whole is None:
        return
    # Offsets of the operators of each part in parentheses, of the whole antecedent first.
    parts: list[list[re.Match[str]]] = [[]]
    ends: list[tuple[int, int]] = []
    open_ones = [(parts[0], whole.start(1))]
    for m in re.finditer(r"[()]|\s+(?:and|or)\s+", code[: whole.end(1)]):
        if m[0] == "(":
            open_ones.append(([], m.end()))
        elif m[0] == ")" and len(open_ones) > 1:
            operators, start = open_ones.pop()
            parts.append(operators)
            ends.append((start, m.start()))
        elif m[0] != ")":
            open_ones[-1][0].append(m)
    for operators, (start, end) in zip(parts, [whole.span(1), *ends], strict=True):
        if len({m[0].strip() for m in operators}) == 2:
            yield from _conjunctions(operators, start, end)


def _conjunctions(operators: Sequence[re.Match[str]], start: int, end: int) -> Iterator[Edit]:
    """Yield parentheses around what `and` joins between two places."""
    ors = [m for m in operators if m[0].strip() == "or"]
    for a, b in zip([start, *(m.end() for m in ors)], [*(m.start() for m in ors), end], strict=True):
        if any(a < m.start() < b for m in operators):
            yield Edit(a, a, "(", _MIXED)
            yield Edit(b, b, ")", _MIXED)


def _chain(groups: list[str], around: Surroundings) -> str | None:
    low, first, middle, second, high = (g.strip() for g in groups[2:7])
    if (first, second) == ("<=", "<=") and middle in around.declared.outputs:
        return f"bounded({middle}, {low}, {high})"
    return f"{low} {first} {middle} and {middle} {second} {high}"


def _comparisons(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Replace comparisons of other languages; `=` in a call names an argument."""
    if head(code) != "require":
        return
    for m in re.finditer(r"[=<>!]+", code):
        if m[0] in _OPERATORS and not re.search(r"\w\([^()]*$", code[: m.start()]):
            yield Edit(m.start(), m.end(), _OPERATORS[m[0]], "comparisons are written <, <=, >, >=, == and !=")


_COMPARED: Final = r"([^<>=!]+?)"

RULES: Final[tuple[Repair, ...]] = (
    index_rule,
    _otherwise,
    by_pattern(
        r"^\s*(?P<x>unless\s+(.*?))(?=\s*,?\s*\bthen\b)",
        lambda g, _: f"if not ({_bare(g[2])})",
        "'unless' is written 'if not'",
    ),
    by_pattern(r"(?P<x>\s*,\s*)(?=unless\b)", " ", "'unless' follows without a comma", heads="if"),
    _else_behind,
    by_pattern(rf"({NAME})(?P<x>\[\s*\"([^\"]*)\"\s*\])", " is {3}", _IS, heads="if with"),
    by_pattern(
        rf"\bis\s+{NAME}\s+(?P<x>({NAME}))(?=\s+\(?{NAME}\s+is\b)",
        _misspelt_and,
        "a condition is followed by 'and', 'or' or 'then'",
        heads="if with",
    ),
    by_pattern(r"\s*(?:->|=>|:(?=\s*\w+\s+is\b))\s*", " then ", "the consequent begins with 'then'", heads="if"),
    by_pattern(r"\band\s+(?=then\b)", "", "'then' follows the condition", heads="if"),
    by_pattern(r"(?P<x>,\s*)(?=then\b)", " ", "'then' follows without a comma", heads="if"),
    by_pattern(
        rf"(?P<x>\s*,\s*)(?=(?:not\s+)?\(?{_WORD}\s+is\b.*\bthen\b)",
        " and ",
        "conditions are joined by 'and' or 'or'",
        heads="if",
    ),
    by_pattern(r"\b(?:and|or)\s+(?P<x>if\s+)", "", "a rule has one 'if'", heads="if"),
    by_pattern(
        rf"\bis\s+(?P<x>(?:in\s+)?between\s+({_WORD})\s+and\s+({_WORD}))",
        "({2} or {3})",
        "terms are joined by 'or', with those between them if there are any",
        heads="if with",
    ),
    by_pattern(
        rf"({_WORD})\s+is\s+(?P<x>({_WORD}(?:\s+{_WORD})*\s+(?:and|or)\s+not\s+{_WORD}))(?=\s+(?:and|or|then)\b)",
        "({3})",
        "each term has its variable",
        heads="if with",
    ),
    by_pattern(r"\s*\|\s*", " or ", "the disjunction is written 'or'", heads="if with"),
    by_pattern(
        r"\s*(?:!=|<>|\bisn't\b|\bisnt\b)\s*", " is not ", "a negated term is written 'is not'", heads="if with"
    ),
    by_pattern(r"\bweight(?P<x>\s*[=:]+\s*|(?=[\d.]))", " ", "'weight' is followed by its value", heads="if"),
    by_pattern(r"\s*(?<![<>])(?:==|:=|=)\s*", " is ", _IS, heads="if with"),
    by_pattern(r"\bis\s+(?:not\s+)?(?P<x>\"([^\"\n]*)\")", "{2}", "names have no quotes", heads="if with"),
    by_pattern(
        r"\bis\s+(?:not\s+)?(?P<x>more\s+or\s+less)\b", "somewhat", "the hedge √x is called somewhat", heads="if with"
    ),
    by_pattern(
        r"\bis\s+(?P<x>((?:very|not|somewhat|extremely|slightly|seldom)\s*\(\s*([\w]+)\s*\)))",
        lambda g, _: " ".join(re.findall(NAME, g[1])),
        "a hedge stands before its term without parentheses",
        heads="if with",
    ),
    by_pattern(
        rf"(?P<x>({_WORD})\s+is\s+(not\s+)?(\(\s*{_WORD}(?:\s*(?:\bor\b|\band\b|,)\s*{_WORD})+\s*\)|"
        rf"{_WORD}(?:\s+or\s+{_WORD})+(?=\s+(?:and|then)\b|\s*\))))(?!\s+is\b)",
        _alternatives,
        "each term has its variable",
        heads="if with",
    ),
    by_pattern(r"[\w)](?P<x>[\s,]*\.)\s*$", "", "a rule ends without a full stop", heads="if with"),
    by_pattern(
        r"\bweight\s+(?P<x>(\d{1,2}(?:\.\d+)?|100)\s*%)\s*$",
        lambda g, _: f"{float(g[2]) / 100:g}",
        "a weight is a number from 0 to 1",
        heads="if",
    ),
    by_pattern(
        r"\bis\s+(?P<x>(constant|linear|function)\s+\()", "{2}(", "the parenthesis follows its function", heads="if"
    ),
    by_pattern(
        rf"(\w+)\)*(?P<x>\s*(?:\(\s*({_WEIGHT})\s*\)|\[\s*({_WEIGHT})\s*\]))\s*$",
        _weight_in_parentheses,
        "a weight begins with 'weight'",
        heads="if",
    ),
    by_pattern(
        r"(?P<x>,?\s*\bwith(?:\s+weight)?|,\s*weight|,?\s*\bcf\b)(?=\s*[=:]?\s*[\d.]+\s*$)",
        " weight",
        "a weight begins with 'weight'",
        heads="if",
    ),
    by_pattern(rf"\bis\s+{_WORD}(?P<x>\s+)(?=[\d.]+\s*$)", " weight ", "a weight begins with 'weight'", heads="if"),
    by_pattern(
        rf"^(?!.*\bthen\b).*\bis\s+(?:not\s+)?{NAME}\)?(?P<x>\s*,?\s*)(?=\(?{_WORD}\s+is\s+\w+\)?[^,]*$)",
        " then ",
        "the consequent begins with 'then'",
        heads="if",
    ),
    _parentheses,
    _conjunction,
    by_pattern(
        rf"(?:\b(?:if|and|or|not|then|with)\b[\s(]*|,\s*){_WORD}(?P<x>\s+)(?={_WORD}\s*(?:$|\)|,|\b(?:and|or|then|weight)\b))",
        " is ",
        _IS,
        heads="if with",
    ),
    by_pattern(
        rf"(?:\bis\s+(?:not\s+)?)(?P<x>({NAME}(?:-{NAME})+))(?=\s*(?:$|,|\)|\b(?:and|or|then|weight)\b))",
        _number_or_formula,
        "a name has no hyphen, which is a minus sign",
        heads="if with",
    ),
    by_pattern(
        rf"\bthen\b.*\bis\s+({NAME})(?P<x>\s*\*\s*({NUMBER}))\s*$",
        _weight_of_term,
        "a weight begins with 'weight'",
        heads="if",
    ),
    by_pattern(
        rf"(?:\bthen\s+|,\s*){NAME}\s+is\s+(?!(?:linear|function|constant)\s*\()(?P<x>({_FORMULA}))(?=\s*(?:$|,|\bweight\b))",
        _number_or_formula,
        "a formula is a consequent as function(FORMULA)",
        heads="if",
    ),
    _grouped,
    # Guarantees.
    by_pattern(r"\|([^|]+)\|", "abs({1})", "an absolute value is written abs(...)", heads="require"),
    _comparisons,
    by_pattern(
        rf"^\s*require\s+(?P<x>{_COMPARED}\s*([<>]=?)\s*{_COMPARED}\s*([<>]=?)\s*{_COMPARED})(?=\s+w(?:hen|ithin)\b|\s*$)",
        _chain,
        "two things are compared at a time",
        heads="require",
    ),
    by_pattern(
        rf"^\s*require\s+(?P<x>({NAME})\s+between\s+(\S+)\s+and\s+(\S+))",
        "{2} in [{3}, {4}]",
        "bounds are written OUTPUT in [LOW, HIGH]",
        heads="require",
    ),
)
