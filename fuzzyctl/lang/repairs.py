"""Repairs of lines as one table: a pattern, its replacement, the reason, and whether it is sure.

Most are notations of MATLAB, fuzzylite, FCL, C, spreadsheets and papers. The effect of a repair is seen by reading the
line again, see `lang/recovery.py`. Patterns are matched without regard to case, against a line whose texts and comments
are masked. The named group that has matched is replaced, or the whole match.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from itertools import pairwise
from typing import Final

from fuzzyctl.diagnostics.other_tools_words import PEER_WORDS
from fuzzyctl.diagnostics.suggestions import closest, is_slip, look_alikes
from fuzzyctl.expr import FUNCTIONS
from fuzzyctl.lang.edits import NUMBER, VALUE, Edit, Repair, Surroundings, depth, head, row
from fuzzyctl.lang.foreign import is_value, known_kind, known_setting, remark
from fuzzyctl.lang.lines import keyword_behind, tokens
from fuzzyctl.lang.mistakes import SPELLINGS
from fuzzyctl.lang.syntax import BLOCKS, NAME, STATEMENT_KEYWORDS
from fuzzyctl.lang.term_repairs import TERMS

COMMENT: Final = "a comment begins with '#'"
_ENDS: Final = "a statement ends with its line"
_DECIMAL: Final = "decimals are written with a point"
_KEYWORD: Final = "|".join(STATEMENT_KEYWORDS)
_WORD: Final = rf"(?!(?:is|and|or|not|then|weight)\b){NAME}"
_SETTINGS: Final = ("and", "or", "implication", "aggregation", "activation", "defuzzifier", "semantics")

# -- characters

#: Statements in which `%` and `//` may be operators: those that hold expressions outside of parentheses.
_EXPRESSIONS: Final = re.compile(
    rf"\s*(?:(?:param|hedge|function|require|let|next|der|state|every|block|measure|run)\b|output\b[^=]*=\s*(?![\[(])|"
    rf"{NAME}\s*:?=\s*(?!{NAME}\s*\())",
    re.IGNORECASE,
)
_OPERATION: Final = re.compile(r"\s*(?:[-+*/^%<>=!,#\d()\]]|(?:unit|within|when|and|or)\b)")
#: Texts that begin with a number, such as `3 points` and `1st`.
_NUMBERED: Final = re.compile(r"\s*\d+(?:(?:st|nd|rd|th)\b|\s+(?!(?:unit|within|when|and|or)\b)[^\W\d])")


def _comments(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Replace signs of comments; in an expression `%` and `//` may be operators."""
    for m in re.finditer(
        r"(\(\*(.*?)\*\)|/\*(.*?)\*/)[ \t]*(?=(\S)?)|^[ \t]*(;+|--+|//+|%+|'+(?=[^'\n]*$))", code, re.M
    ):
        inner = text[slice(*m.span(2))] if m[2] is not None else text[slice(*m.span(3))]
        new = "#" if m[5] else f"# {inner.strip()}" if not m[4] else ""
        yield Edit(*m.span(5 if m[5] else 1), new, COMMENT)
    for m in re.finditer(r"(?<=[\s;)\]}\"])(?<!unit )(//+|%+(?!\s*(?://|#)))(?!\s*(?:;*\s*$|else\b|unit\b))", code):
        behind = code[m.end() :]
        goes_on = _OPERATION.match(behind) if m[0] == "%" else re.match(r"\s*[-+]?[\d(]", behind)
        computes = _EXPRESSIONS.match(code) or depth(code[: m.start()]) > 0
        if code[: m.start()].strip() and not (goes_on and computes and not _NUMBERED.match(behind)):
            yield Edit(m.start(), m.end(), "#", COMMENT)
            return


_WORDS_OF_SIGNS: Final = {"∧": " and ", "∨": " or ", "¬": "not ", "→": " then ", "⇒": " then ", "∈": " in ", "×": "*"}


def _characters(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Replace quotes, and characters that look like ASCII ones or have a spelling of their own."""
    for m in re.finditer(r"[“”„‟«»″]|(?<![\w'])'[^'\n]*'|(?<!\w)[‘’‚‛][^‘’\n]*[‘’](?!\w)|[^\x00-\x7f]", code):
        char = m[0][0]
        if char in "“”„‟«»″'‘’‚‛":
            new = '"' if len(m[0]) == 1 else f'"{text[m.start() + 1 : m.end() - 1]}"'
            yield Edit(*m.span(), new, "texts are written in straight double quotes")
        elif not (re.match(r"\w", char) or unicodedata.combining(char) or (char == "×" and head(code) == "table")):
            new = SPELLINGS.get(char) or _WORDS_OF_SIGNS.get(char) or unicodedata.normalize("NFKC", char)
            new = "." if unicodedata.category(char) == "Pd" and "|" in code else new
            start, end = m.span()
            if new.startswith(" "):
                start, end = len(code[:start].rstrip()), len(code) - len(code[end:].lstrip())
            if new.isascii():
                name = unicodedata.name(char, "a control character")
                yield Edit(start, end, new, f"U+{ord(char):04X}, {name}, is not a character of the language")


def _semicolons(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Drop semicolons at the end of a line; inside parentheses they are commas, between cells blanks."""
    for m in re.finditer(";", code):
        if depth(code[: m.start()]) > 0:
            yield Edit(*m.span(), ",", "parameters are separated by commas")
            part = re.search(r"[^()\[\];]*$", code[: m.start()])
            last = re.match(r"[^()\[\];]*(?!;)", code[m.end() :])
            for piece, at in ((part, 0), (last, m.end())):
                for comma in re.finditer(r"(?<=\d),(?=\d)", piece[0] if piece else ""):
                    place = at + (piece.start() if piece else 0) + comma.start()
                    if piece is part or not code[m.end() + len(piece[0] if piece else "") :].startswith(";"):
                        yield Edit(place, place + 1, ".", _DECIMAL)
        elif re.match(r"[\s;]*(#|$)", code[m.end() :]):
            yield Edit(*m.span(), "", _ENDS)
        elif around.block == "table" and head(code) not in STATEMENT_KEYWORDS:
            yield Edit(*m.span(), " ", "cells are separated by blanks")


def _bare_term(groups: list[str], around: Surroundings) -> str | None:
    numbers = around.declared.params | around.declared.variables
    return None if groups[3] in numbers else f"{groups[2]} {groups[3]}".strip()


#: Repairs of texts that no valid line holds: they are kept in any case.
CHARACTERS: Final[tuple[Repair, ...]] = (
    _comments,
    _characters,
    row(
        r"\bthen\b.*(?<!\bis)(?P<x>[\s;]+(end(?:_?if)?))(?=[\s;]*(?:#|$))",
        lambda g, around: None if g[2] in around.declared.names else "",
        _ENDS,
        heads="if",
    ),
    _semicolons,
    row(
        r"(?P<and>\s*&&\s*|\s*&\s*(?=\(|\w+\s*(?:\bis\b|[=~!])|~|!))|(?P<or>\s*\|\|\s*)|(?P<differs>~=)|"
        r"(?P<not>(?<!\w)[!~](?!=)\s*(?=[\w(]))|(?P<power>\*\*)",
        {"and": " and ", "or": " or ", "differs": "!=", "not": "not ", "power": "^"},
        "operators are written and, or, not, != and ^",
    ),
    # No character, but a line that holds it may be valid otherwise: a consequent in parentheses is a number.
    row(
        rf"\bis\s+(?:not\s+)?(?P<x>(very|not|somewhat|extremely|slightly|seldom)?\s*\(\s*({NAME})\s*\))",
        _bare_term,
        "a term has no parentheses",
        heads="if with",
    ),
)

# -- statements

_IN_RULES: Final = frozenset("if with is and or not unless then weight".split())  # noqa: SIM905
_IN_HEADS: Final = frozenset(
    "input output in unit else extrapolate clamp adaptive rate hold midpoint nan error".split()  # noqa: SIM905
)
#: Keywords inside statements, by the first word.
_KEYWORDS: Final[dict[str, frozenset[str]]] = {
    **dict.fromkeys(("if", "with", "otherwise", "else"), _IN_RULES),
    **dict.fromkeys(("input", "output"), _IN_HEADS),
    "table": frozenset({"x", "from"}),
    "require": frozenset({"within", "when", "and", "or", "not"}),
    "param": frozenset({"unit"}),
}


def _capitals(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    first = head(code)
    if first not in STATEMENT_KEYWORDS and first not in _KEYWORDS:
        return
    words = _KEYWORDS.get(first, frozenset()) | {first}
    for k, m in enumerate(re.finditer(NAME, code)):
        small = m[0].lower()
        if m[0] != small and (small in words and m[0] not in around.declared.variables if k else small == first):
            yield Edit(m.start(), m.end(), small, "keywords are written in small letters")


def _misspelt(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Replace a first word that is one of the language but for a slip."""
    match = re.match(rf"\s*({NAME})(?=[\s(])(?!\s*[:=|])", code)
    if match is None or match[1] in {*STATEMENT_KEYWORDS, "let", *_IN_RULES, *around.declared.names}:
        # A declared name begins a row without its bar, or the rest of a rule.
        return
    word, rest = match[1], code[match.end() :]
    if len(word) == 2 and (value := re.fullmatch(rf"\s+({NAME})\W*", rest)):
        for near in ("and", "or"):
            if (set(word) < set(near) or word == near[::-1]) and is_value(near, value[1]):
                yield Edit(*match.span(1), near, f"did you mean '{near}'?")
    if len(word) < 3 or keyword_behind(code) is not None:
        return
    near_word = closest(word, BLOCKS.get(around.in_block, STATEMENT_KEYWORDS))
    # `allow` takes any words; its codes are known by their form.
    if near_word is not None and (near_word not in ("allow", "deny") or re.match(r"\s+FZ\d", rest)):
        why = "; ".join((f"did you mean '{near_word}'?", *look_alikes(word)))
        yield Edit(*match.span(1), near_word, why, is_slip(word, near_word, STATEMENT_KEYWORDS))


def _repeated(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Remove each token that repeats the one before it, but for numbers and parentheses that open a part."""
    for one, other in pairwise(t for t in tokens(text) if t.kind not in ("blank", "comment")):
        is_surplus = one.text not in "()]" or (one.text != "(" and depth(code) < 0)
        if one.text == other.text and one.kind != "number" and is_surplus:
            yield Edit(one.end, other.end, "", "it stands there twice")


#: Keywords inside statements that may be misspelt.
_INNER: Final = (
    "in", "unit", "else", "is", "and", "or", "not", "then", "weight", "within", "when", "defuzzifier", "implication",
    "aggregation", "adaptive", "rate", "extrapolate", "clamp", "unless", "hold", "step",
)  # fmt: skip


def _slips(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Respell keywords inside the line; short words only if another keyword cannot be meant."""
    for m in re.finditer(rf"(?<=\s){NAME}", code):
        word, near = m[0], closest(m[0], _INNER)
        if word in _INNER or word in around.declared.names:
            continue
        if near is not None and is_slip(word, near, _INNER):
            yield Edit(*m.span(), near, f"did you mean '{near}'?")
        elif len(word) == 2 and word[0] == "i" and head(code) in ("if", "with"):
            yield Edit(*m.span(), "is", "it is like a keyword", sure=False)


def _unclosed(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Close texts, parentheses and brackets that are open at the end of a line."""
    line = code.rstrip()
    if code.count('"') % 2:
        yield Edit(len(line), len(line), '"', "a text is closed on its line", sure=False)
        return
    opened, missing = [c for c in line if c in "(["], depth(line)
    if 0 < missing <= 5:
        closing = "".join(")" if c == "(" else "]" for c in reversed(opened[-missing:]))
        # In a longer expression it may be another place that was meant.
        inside = line[max(line.rfind("("), line.rfind("[")) :]
        sure = re.search(r"[\w)]\s*[-+*/^]\s*[\w(]", inside) is None
        yield Edit(len(line), len(line), closing, "parentheses are closed", sure)


_OTHER_WORDS: Final = {
    **dict.fromkeys(("assert", "ensure", "guarantee", "prove"), "require"),
    **dict.fromkeys(("const", "constant", "let", "var", "parameter", "def", "real", "float", "double"), "param"),
    **dict.fromkeys(("include", "import"), "use"),
    **{word: word for word in ("system", "source", "use", "rules", "require")},
}


def _first_word(groups: list[str], around: Surroundings) -> str | None:
    """Return the keyword that a first word and the sign behind it mean."""
    word, sign, rest = groups[2].lower(), groups[3], groups[4]
    meant = _OTHER_WORDS.get(word)
    if meant is not None and meant != word:
        fits = {"param": rf"{NAME}\s*:?=", "use": '"'}.get(meant, "")
        return f"{meant} " if re.match(fits, rest) else None
    if meant is not None:
        return f"{word} " if sign else None
    setting = next((w for w in (word, *PEER_WORDS.get(word.replace("_", ""), ())) if w in _SETTINGS), None)
    is_value = re.fullmatch(rf"\"?{NAME}\"?\s*(?:\([^()]*\))?\s*(?:#.*)?", rest)
    return f"{setting} " if setting is not None and is_value else None


def _value_of_setting(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    for m in re.finditer(rf"\b(and|or|implication|aggregation|defuzzifier|activation)\s+({NAME})", code):
        meant = known_setting(m[1], m[2])
        if meant is not None:
            why = "values are written in small letters" if m[2].lower() == meant else f"here it is called '{meant}'"
            yield Edit(m.start(2), m.end(2), meant, "; ".join(filter(None, (why, remark(m[2])))))


def _range(groups: list[str], around: Surroundings) -> str | None:
    ends = groups[2:4] if groups[1] else groups[5:]
    names = {n for end in ends for n in re.findall(NAME, end) if not re.fullmatch("(?i)pi|inf(inity)?", n)}
    low, high = (re.sub(r"(?i)\binf(inity)?\b", "inf", end) for end in ends)
    return f" in [{low}, {high}]" if names <= around.declared.params else None


def _decimal_commas(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Replace commas inside numbers: those outside of parentheses, and those without the blank that others have."""
    for m in re.finditer(r"(?<![\w.,])(\d+)(,)\d+(?![\w.]|,\d)", code):
        if depth(code[: m.start()]) <= 0 or re.search(r",\s", code):
            grouped = re.fullmatch(r"[1-9]\d{0,2},\d{3}", m[0]) is not None
            more = f", thousands without a separator: {m[0].replace(',', '')}" if grouped else ""
            yield Edit(m.start(2), m.end(2), ".", _DECIMAL + more)


def _assigned(groups: list[str], around: Surroundings) -> str | None:
    """Return the equals sign; in a table a sign behind a name is a bar."""
    return None if around.block == "table" and head(groups[0]) not in (*STATEMENT_KEYWORDS, "") else " = "


def _declaration(groups: list[str], around: Surroundings) -> str | None:
    """Make a singleton of `k = 3` below an output, where the file reads the name as a term, and else a param.

    Derivatives and plants of one line have keywords of their own.
    """
    if not groups[6]:
        return f"der {groups[2] or groups[4]} " if groups[1] or groups[3] else "plant "
    indent, name, value = groups[7], groups[8], groups[9]
    if name.lower() in ("else", "default", "otherwise"):
        return None
    if indent or name in around.declared.terms:
        return f"{indent}{name} = constant({value})" if around.block == "output" else None
    # A param cannot have the name of a variable.
    return f"param {name} = {value}" if name not in around.declared.variables else None


def _title(groups: list[str], around: Surroundings) -> str | None:
    """Return a name without blanks and hyphens; that of a system with a title only is made of the title."""
    if groups[1]:
        return "_".join(dict.fromkeys(re.split(r"[ -]+", groups[1])))
    name = re.sub(r"\W+", "_", groups[3]).strip("_")
    return f" {name} {groups[2].strip()}" if re.fullmatch(NAME, name) else None


_NAMED: Final = re.compile(
    r"^\s*(?:param|hedge|rules|function|and|or|implication|aggregation|defuzzifier|activation)\s+$|"
    rf"\b(?:implication|aggregation|defuzzifier)\s+$|^\s*{NAME}\s*:?=\s*$",
    re.IGNORECASE,
)


def _quoted(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Drop the quotes of names: anywhere in rules and tables, before `=`, and where other statements have names."""
    first = head(code)
    for m in re.finditer(r"\"[^\"\n]*\"", code):
        name, before, behind = text[m.start() + 1 : m.end() - 1].strip(), code[: m.start()], code[m.end() :]
        is_cell = around.block == "table" and ("|" in code or re.fullmatch(r"(?:\s*\"[^\"]*\")+\s*", code))
        if (
            (first in ("if", "with", "terms", "table", "require") and not before.endswith("from "))
            or (re.fullmatch(r"\s*(?:input|output)\s+", before.lower()) and around.declared.counts[name] > 1)
            or _NAMED.search(before)
            or (not before.strip() and re.match(r"\s*[:=]", behind))
            or is_cell
        ) and re.fullmatch(NAME, name):
            yield Edit(*m.span(), name, "names have no quotes")


def _weight(groups: list[str], around: Surroundings) -> str | None:
    """Return the weight of a rule, which begins the line or ends it."""
    if groups[2]:
        weight = groups[2].replace(",", ".")
        return f"{groups[3]} weight {weight}" if float(weight) <= 1 else None
    term, sign, number, percent = groups[5], groups[7], groups[8].replace(",", "."), groups[9]
    numbers = around.declared.params | around.declared.variables
    called = known_kind(term) is not None or term in FUNCTIONS
    if (sign == "*" and term in numbers) or (sign in ("(", "[") and called) or (percent and "weight" not in sign):
        return None
    if not sign.strip() and not re.search(rf"\bis\s+{NAME}\)*\s+[\d.,]+\s*$", groups[0]):
        return None
    value = f"{float(number) / 100:g}" if percent else number
    return f" weight {value}" if float(value) <= 1 and term not in ("is", "not") else None


_SIGNED: Final = r"[-+]?(?:\w+(?:\.\w+)?|\.\w+)"
#: Variables of one line, each with its label.
_NAMED_ONES: Final = rf"{NAME}(?:\s*\"[^\"]*\")?(?:\s*,\s*{NAME}(?:\s*\"[^\"]*\")?)*"
_ENDS_OF_RANGE: Final = rf"({_SIGNED})\s*(?:,|;|:|\.\.+|\bto\b|\s)\s*({_SIGNED})(?:\s*[\])}}])?"


def _clause(groups: list[str], around: Surroundings) -> str:
    if groups[1]:
        return f'unit "{groups[2]}"'
    return "unit " if groups[4].lower() == "unit" else "else " if groups[4] else " "


STATEMENTS: Final[tuple[Repair, ...]] = (
    row(
        rf"(?P<x>;)|(?<=[)\]])(?P<y>\s*,?\s*)(?={NAME}\s*:?=\s*{NAME}\s*[(\[])",
        {"x": "\n", "y": "\n  "},
        "a line holds one statement, or one term with a function",
    ),
    _quoted,
    row(
        r"^\s*(?P<x>\}|\{|end\w*|\|?(?:\s*:?-{2,}:?\s*\|)+\s*(?::?-{2,}:?)?)\s*$"
        r"|^\s*(?P<rule>(?:rule\s*\w*\s*[:.)]|r?\d+\s*[.:)])\s*)(?=(?:\([\d.,]+\)\s*)?if\b)|^\s*(?P<other>else\s+)(?=if\b)"
        rf"|^\s*(?P<term>term\s*:?\s+)(?={NAME}\s*:?=|{NAME}\s+{NAME}\b)"
        rf"|^\s*(?P<terms>terms\s*:?\s+)(?={NAME}\s*:?=\s*{NAME}\s*[(\[])"
        r"|(?P<end>\s*(?:[{:,]|\bdo))\s*$|^\s*(?:if|with)\b.*[\w)](?P<stop>[\s,]*\.)\s*$|^\s*table\b[^)(]*(?P<table>\))\s*$",
        "",
        "the line can be read without it",
    ),
    row(
        r"^\s*(?P<x>(?:weight\s*[=:]?\s*)?\(?\s*(\d*[.,]?\d+)\s*\)?\s*[:,]?\s*(if\b(?!.*\bweight\b).*?))\s*$"
        r"|^\s*if\b.*(?<!\w)((?!(?:with|weight|cf)\b)(\w+)\)*(?P<y>\s*(,?\s*\bwith(?:\s+weight)?\b|,?\s*\bweight\b|,?\s*\bcf\b|[(\[*]|\s)\s*[=:]*\s*"
        r"(\d*[.,]?\d+|\d+[.,])\s*(%?)\s*[)\]]?))\s*$",
        _weight,
        "a rule ends with its weight, a number from 0 to 1: weight 0.5",
    ),
    row(
        rf"^\s*(?!(?:if|unless|else|then|and|or)\b)(?P<x>{NAME})(?=[\s(]+(?:not\s+)?\(?{NAME}\s+is\b.*\bthen\b)"
        rf"|^\s*(?P<y>)(?={NAME}\s+is\s+.*(?:\bthen\b|=>|->))|^\s*(?P<z>unless\s+(.*?))(?=\s*,?\s*\bthen\b)",
        lambda g, _: "if" if g[1] else f"if not ({_bare(g[4])})" if g[3] else "if ",
        "a rule begins with 'if'",
    ),
    row(
        rf"^\s*(?P<x>({NAME})(?:\s*(:=|:|=)\s*|\s+))(?=([^\n]*))",
        _first_word,
        "a statement begins with its keyword and goes on with its value",
    ),
    _value_of_setting,
    _capitals,
    row(
        rf"^\s*system\s+(?P<x>{NAME}(?:[ -]+{NAME})+)(?=\s*(?:\"|$))|^\s*system(?P<y>\s*\"([^\"]*)\")\s*$",
        _title,
        "a system has a name without blanks and hyphens before its title",
        sure=False,
    ),
    row(
        rf"^\s*(?:(?:param|let|next|block)\s+{NAME}|(?:hedge|function)\s+{NAME}\s*\([^()]*\)|{NAME})"
        rf"(?P<x>\s*(?::=|:|<-)\s*)(?=[^\s|:=])|^\s*param\s+{NAME}(?P<y>\s+)(?=[-+.\d(])|(?P<z>\s*:=\s*)",
        _assigned,
        "a value is assigned with '='",
    ),
    _decimal_commas,
    row(
        rf"^\s*(?:input|output)\s+(?!in\b){_NAMED_ONES}(?!\w)(?P<x>\s*(?:\bin\b|=|:|\brange\b|\bfrom\b)?\s*(?:range\s*)?"
        rf"[=:]?\s*[\[({{]?\s*{_ENDS_OF_RANGE})(?=\s*$|\s+[\w=])"
        rf"|^\s*param\b[^=]*?(?P<y>\s*\bin\s*[\[({{]?\s*{_ENDS_OF_RANGE})(?=\s*(?:$|:?=|[^\W\d]))",
        _range,
        "a range is written: in [low, high]",
    ),
    row(
        r"\b(?P<x>unit\s+(?!unit\b|[=:])[\[(]?([^\s\"\[\](),;]+)[\])]?)|\b(?P<y>(default|otherwise|(?:else|unit)(?=\s*[:=]))\s*(?::=|=|:|\s)\s*)"
        r"|(?P<z>\s*,\s*)(?=(?:unit|else|clamp|extrapolate|adaptive|implication|aggregation|defuzzifier|terms)\b)",
        _clause,
        'clauses follow the range without signs: unit "m" else 0',
        heads="input output param let state measure",
    ),
    row(
        rf"(?:\b(?:else|weight)\s+|(?<=\w[=@]))(?P<x>({VALUE}|(?<=[=@]){NAME}))(?=\s|$)",
        "({1})",
        "an expression of several parts is written in parentheses",
        heads="output if terms",
    ),
    row(
        rf"^\s*table(?P<x>\s+({NAME}(?:\s*,\s*{NAME})*)\s*[:(=]\s*({NAME})\s*(?:[,*×]|\b(?:x|by|and)\b)\s*({NAME})\s*\)?)\s*$",
        " {2} = {3} x {4}",
        "the form is: table OUTPUT = ROWS x COLUMNS",
    ),
    row(
        rf"^\s*(?P<x>d({NAME})\s*/\s*dt\s*)(?==)|^\s*(?P<y>der\s*\(\s*({NAME})\s*\)\s*)(?==)"
        rf"|^\s*(?P<z>)(?={NAME}\s*=\s*(?:tf|zpk|ss)\s*\()|^(?P<value>(\s*)(?!(?:{_KEYWORD})\b)({NAME})\s*=\s*({NUMBER}))\s*$",
        _declaration,
        "a statement begins with its keyword",
    ),
)

# -- rules and guarantees


def _bare(condition: str) -> str:
    inner = re.fullmatch(r"\(([^()]*)\)", condition)
    return (inner[1] if inner is not None else condition).strip()


def _else(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Give the rest of a rule behind `else`, or a line that begins with it, the negated condition of the rule above."""
    behind = re.match(r"\s*if\s+(.*?)\s+then\b.*?(,?\s*\belse\s+)(?=\S)", code, re.IGNORECASE)
    if behind is not None:
        condition = _bare(text[slice(*behind.span(1))])
        yield Edit(*behind.span(2), f"\nif not ({condition}) then ", "rules have no 'else'")
    match = re.match(r"\s*(else\b,?\s*(?:then\s+)?)(?!if\b)", code, re.IGNORECASE)
    if match is not None and " is " in code.lower():
        above = [re.match(r"(?:else\s+)?if\s+(.*?)\s+then\b", rule, re.IGNORECASE) for rule in around.above]
        bare = [_bare(m[1]) for m in above if m is not None]
        small = [re.sub(r"\b(?:IS|AND|OR|NOT)\b", lambda m: m[0].lower(), c) for c in bare]
        none = " and ".join(f"not ({c})" for c in small)
        new = f"if {none} then " if above and all(above) else "otherwise "
        yield Edit(*match.span(1), new, "rules have no 'else'")


def _consequents(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Separate consequents by commas, and drop their parentheses."""
    then = re.search(r"\bthen\b", code)
    if then is None or head(code) != "if":
        return
    why = "consequents have no parentheses and are separated by ','"
    for m in re.finditer(r"\(([^()]*\bis\b[^()]*)\)|\s*\band\b\s*", code[then.end() :]):
        start, end = then.end() + m.start(), then.end() + m.end()
        if m[1] is None:
            yield Edit(start, end, ", ", why)
        else:
            follows = re.match(r"\s*\(\s*\w+\s+is\b", code[end:])
            yield Edit(start, start + 1, "", why)
            yield Edit(end - 1, end, ", " if follows else "", why)


def _formula(groups: list[str], around: Surroundings) -> str | None:
    value = groups[1].strip()
    functions = re.findall(rf"(?m)^\s*function\s+({NAME})", around.declared.text)
    unknown = set(re.findall(rf"({NAME})\s*\(", value)) - {*FUNCTIONS, *functions}
    if any(value.startswith(name) or known_kind(name) for name in unknown):
        # A term before parentheses, or a membership function.
        return re.sub(r"\s+\(", "(", value) if re.match(r"(?:constant|linear|function)\s+\(", value) else None
    names = set(re.findall(NAME, value))
    numbers = around.declared.variables | around.declared.params
    if re.fullmatch(rf"\(\s*{NAME}\s*\)|{NAME}(?:-{NAME})+", value) and not names <= numbers:
        return None
    return f"function({value})" if re.search(r"[-+*/^(]", value) else None


def _grouped(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Put parentheses around the conjunctions of an antecedent that mixes AND and OR."""
    whole = re.match(r"\s*if\s+(.*?)\s+then\b", code)
    if whole is None:
        return
    why = "AND and OR are mixed; in other languages AND comes first"
    # Offsets of the operators of each part in parentheses, and of the whole antecedent.
    open_ones: list[tuple[list[re.Match[str]], int]] = [([], whole.start(1))]
    for m in re.finditer(r"[()]|\s+(?:and|or)\s+|$", code[: whole.end(1)]):
        if m[0] == "(":
            open_ones.append(([], m.end()))
        elif m[0].strip() in ("and", "or"):
            open_ones[-1][0].append(m)
        elif len(open_ones) > 1 or not m[0]:
            operators, start = open_ones.pop()
            ors = [o for o in operators if o[0].strip() == "or"]
            parts = zip([start, *(o.end() for o in ors)], [*(o.start() for o in ors), m.start()], strict=True)
            for a, b in parts if len(ors) not in (0, len(operators)) else ():
                if any(a < o.start() < b for o in operators):
                    yield Edit(a, a, "(", why)
                    yield Edit(b, b, ")", why)


_OPERATORS: Final = {"=": "==", "=>": ">=", "=<": "<=", "===": "==", "<>": "!=", "!==": "!="}
#: Words that are not misspelt 'and' or 'or'.
_LOGIC: Final = frozenset({"and", "or", "then", "xor", "nor", "nand", "xnor", "andnot"})
_COMPARED: Final = r"([^<>=!]+?)"


def _claim(groups: list[str], around: Surroundings) -> str | None:
    """Return a guarantee with the operators of here; two things are compared at a time."""
    claim = re.sub(r"\|([^|]+)\|", r"abs(\1)", groups[1])
    claim = re.sub(r"(?<![\w(,][=<>!])[=<>!]+", lambda m: _operator(m, claim), claim)
    claim = re.sub(rf"^({NAME})\s+between\s+(\S+)\s+and\s+(\S+)", r"\1 in [\2, \3]", claim)
    chain = re.match(
        rf"{_COMPARED}\s*([<>]=?)\s*{_COMPARED}\s*([<>]=?)\s*{_COMPARED}(?=\s+w(?:hen|ithin)\b|\s*$)", claim
    )
    if chain is None:
        return claim
    low, first, middle, second, high = (g.strip() for g in chain.groups())
    within = (first, second) == ("<=", "<=") and middle in around.declared.outputs
    new = f"bounded({middle}, {low}, {high})" if within else f"{low} {first} {middle} and {middle} {second} {high}"
    return new + claim[chain.end() :]


def _operator(m: re.Match[str], claim: str) -> str:
    """Return an operator of here; `=` in a call names an argument."""
    return m[0] if re.search(r"\w\([^()]*$", claim[: m.start()]) else _OPERATORS.get(m[0], m[0])


RULES: Final[tuple[Repair, ...]] = (
    _else,
    row(
        r"(?P<is>(?<=\w)\[\s*\"([^\"]*)\"\s*\])|(?P<then>\s*(?:->|=>|:(?=\s*\w+\s+is\b))\s*)"
        r"|(?P<differs>\s*(?:!=|<>|\bisn't\b|\bisnt\b)\s*)|(?P<or>\s*\|\s*)|(?P<equals>\s*(?<![<>])(?:==|:=|=)\s*)"
        r"|\bis\s+(?:not\s+)?(?P<hedge>more\s+or\s+less)\b",
        {"is": " is {2}", "then": " then ", "differs": " is not ", "or": " or ", "equals": " is ", "hedge": "somewhat"},
        "a rule is written: if INPUT is TERM and INPUT is not TERM then OUTPUT is TERM",
        heads="if with",
    ),
    row(
        rf"(?P<blank>,\s*(?=(?:then|unless)\b))|\b(?P<none>and\s+(?=then\b))|\b(?:and|or)\s+(?P<if>if\s+)"
        rf"|(?P<and>\s*,\s*)(?=(?:not\s+)?\(?{_WORD}\s+is\b.*\bthen\b)"
        rf"|^(?!.*\bthen\b).*\bis\s+(?:not\s+)?{NAME}\)?(?P<then>\s*,?\s*)(?=\(?{_WORD}\s+is\s+\w+\)?[^,]*$)",
        {"blank": " ", "none": "", "if": "", "and": " and ", "then": " then "},
        "conditions are joined by 'and' or 'or', the consequent begins with 'then'",
        heads="if",
    ),
    row(
        rf"\bis\s+(?:not\s+)?(?:(?P<x>(?:in\s+)?between\s+({_WORD})\s+and\s+({_WORD}))"
        rf"|(?P<y>({_WORD}(?:\s+(?:or|and)\s+(?:not\s+)?{_WORD})+))(?=\s+(?:and|or|then)\b|\s*\)))(?!\s+is\b)",
        lambda g, _: f"({g[2]} or {g[3]})" if g[1] else _alternatives(g),
        "terms are joined in parentheses: is (A or B)",
        heads="if with",
    ),
    row(
        rf"\bis\s+{NAME}\s+(?P<x>({NAME}))(?=\s+\(?{NAME}\s+is\b)",
        lambda g, _: None if g[1].lower() in _LOGIC else closest(g[1].lower(), ["and", "or", "then"]),
        "a condition is followed by 'and', 'or' or 'then'",
        heads="if with",
    ),
    _consequents,
    row(
        rf"(?:\b(?:if|and|or|not|then|with)\b[\s(]*|,\s*){_WORD}(?P<x>\s+)(?={_WORD}\s*(?:$|\)|,|\b(?:and|or|then|weight)\b))",
        " is ",
        "a variable and its term are joined by 'is'",
        heads="if with",
    ),
    row(
        rf"(?:\bthen\s+|,\s*){NAME}\s+is\s+(?!(?:linear|function|constant)\()(?P<x>(?:[^,()]|\((?:[^()]|\([^()]*\))*\))+?)(?=\s*(?:$|,|\bweight\b))",
        _formula,
        "a formula is a consequent as function(FORMULA)",
        heads="if",
    ),
    _grouped,
    row(r"^\s*require\s+(?P<x>[^#\n]*?)\s*$", _claim, "a guarantee compares two things with <, <=, >, >=, == or !="),
)


def _alternatives(groups: list[str]) -> str | None:
    words = set(re.findall(NAME, groups[5]))
    # What 'not' takes of 'not A or B' is open.
    return None if {"or", "and"} <= words or groups[0].split()[1].lower() == "not" else f"({groups[5]})"


#: All other repairs in their order; the last ones take any word for another.
ROWS: Final[tuple[Repair, ...]] = (
    *STATEMENTS,
    *TERMS,
    *RULES,
    _repeated,
    _misspelt,
    _slips,
    _unclosed,
)
