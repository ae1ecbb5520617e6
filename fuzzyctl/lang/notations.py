"""Repairs of foreign notation: keywords, settings and heads of blocks."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from fuzzyctl.diagnostics.other_tools_words import PEER_WORDS
from fuzzyctl.diagnostics.suggestions import closest, is_slip, look_alikes
from fuzzyctl.lang.character_repairs import DECIMAL, ENDS
from fuzzyctl.lang.edits import Edit, Repair, Surroundings
from fuzzyctl.lang.lines import keyword_behind
from fuzzyctl.lang.other_tools import is_value, known_setting, remark
from fuzzyctl.lang.repair_patterns import NUMBER, Replacement, by_pattern, head
from fuzzyctl.lang.syntax import BLOCKS, NAME, STATEMENT_KEYWORDS

_CASE: Final = "keywords are written in small letters"
_DERIVATIVE: Final = "a derivative is written: der STATE = EXPRESSION"
_SETTINGS: Final = ("and", "or", "implication", "aggregation", "activation", "defuzzifier", "semantics")
_IN_RULES: Final = "if with is and or not unless then weight"
_IN_HEADS: Final = "input output in unit else extrapolate clamp adaptive rate hold midpoint nan error"

#: Keywords inside statements, by the first word.
_KEYWORDS: Final[dict[str, frozenset[str]]] = {
    **dict.fromkeys(("if", "with", "otherwise", "else"), frozenset(_IN_RULES.split())),
    **dict.fromkeys(("input", "output"), frozenset(_IN_HEADS.split())),
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
            yield Edit(m.start(), m.end(), small, _CASE)


def _misspelt(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Replace a first word that is one of the language but for a slip."""
    found = re.match(rf"\s*({NAME})(?=[\s(])(?!\s*[:=|])", code)
    if found is None or found[1] in STATEMENT_KEYWORDS or found[1] in _KEYWORDS["if"] or len(found[1]) < 3:
        return
    if found[1] in around.declared.names:
        # It begins a row without its bar, or the rest of a rule.
        return
    if keyword_behind(code) is not None:
        return
    near = closest(found[1], BLOCKS.get(around.in_block, STATEMENT_KEYWORDS))
    # `allow` takes any words; its codes are known by their form.
    if near is not None and (near not in ("allow", "deny") or re.match(r"\s+FZ\d", code[found.end() :])):
        why = "; ".join((f"did you mean '{near}'?", *look_alikes(found[1])))
        yield Edit(found.start(1), found.end(1), near, why, is_slip(found[1], near, STATEMENT_KEYWORDS))


def _misspelt_norm(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Replace a first word of two letters of `and` or `or` before the name of a norm."""
    found = re.fullmatch(rf"\s*(\w\w)\s+({NAME})\W*", code)
    if found is not None and found[1] not in STATEMENT_KEYWORDS and found[1] not in around.declared.names:
        for near in ("and", "or"):
            is_near = set(found[1]) < set(near) or found[1] == near[::-1]
            if is_near and is_value(near, found[2]):
                yield Edit(found.start(1), found.end(1), near, f"did you mean '{near}'?")


def _unclosed(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Close what is open at the end of a line: texts, parentheses and brackets."""
    line = code.rstrip()
    if code.count('"') % 2:
        yield Edit(len(line), len(line), '"', "a text is closed on its line", sure=False)
        return
    opened = [c for c in line if c in "(["]
    missing = len(opened) - sum(c in ")]" for c in line)
    if 0 < missing <= 5:
        closing = "".join(")" if c == "(" else "]" for c in reversed(opened[-missing:]))
        # In a longer expression it may be another place that was meant.
        inside = line[max(line.rfind("("), line.rfind("[")) :]
        sure = re.search(r"[\w)]\s*[-+*/^]\s*[\w(]", inside) is None
        yield Edit(len(line), len(line), closing, "parentheses are closed", sure)


def _setting_of(groups: list[str], around: Surroundings) -> str | None:
    word = groups[2].lower()
    meant = (word, *PEER_WORDS.get(word.replace("_", ""), ()))
    keyword = next((w for w in meant if w in _SETTINGS), None)
    return None if keyword is None else f"{keyword} "


def _value_of_setting(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    for m in re.finditer(rf"\b(and|or|implication|aggregation|defuzzifier|activation)\s+({NAME})", code):
        meant = known_setting(m[1], m[2])
        if meant is not None:
            more = remark(m[2])
            why = "values are written in small letters" if m[2].lower() == meant else f"here it is called '{meant}'"
            why = f"{why}; {more}" if more else why
            yield Edit(m.start(2), m.end(2), meant, why)


def _range(groups: list[str], around: Surroundings) -> str | None:
    names = {n for end in groups[-2:] for n in re.findall(NAME, end) if not re.fullmatch("(?i)pi|inf(inity)?", n)}
    if not names <= around.declared.params:
        return None
    low, high = (re.sub(r"(?i)\binf(inity)?\b", "inf", g) for g in groups[-2:])
    return f" in [{low}, {high}]"


def _decimal_commas(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    """Replace commas inside numbers: those outside of parentheses, and those without the blank that others have."""
    for m in re.finditer(r"(?<![\w.,])(\d+)(,)\d+(?![\w.]|,\d)", code):
        inside = code.count("(", 0, m.start()) > code.count(")", 0, m.start())
        inside = inside or code.count("[", 0, m.start()) > code.count("]", 0, m.start())
        if not inside or re.search(r",\s", code):
            grouped = re.fullmatch(r"[1-9]\d{0,2},\d{3}", m[0]) is not None
            more = f", thousands without a separator: {m[0].replace(',', '')}" if grouped else ""
            yield Edit(m.start(2), m.end(2), ".", DECIMAL + more)


def _declaration(groups: list[str], around: Surroundings) -> str | None:
    """Make a singleton of `k = 3` below an output, where the file reads the name as a term, and else a param."""
    indent, name, value = groups[2], groups[3], groups[4]
    if name.lower() in ("else", "default", "otherwise"):
        return None
    if indent or name in around.declared.terms:
        return f"{indent}{name} = constant({value})" if around.block == "output" else None
    # A param cannot have the name of a variable.
    return f"param {name} = {value}" if name not in around.declared.variables else None


def _joined(groups: list[str], around: Surroundings) -> str:
    return "_".join(dict.fromkeys(re.split(r"[ -]+", groups[1])))


def _named(groups: list[str], around: Surroundings) -> str | None:
    name = re.sub(r"\W+", "_", groups[2]).strip("_")
    return f" {name} {groups[1].strip()}" if re.fullmatch(NAME, name) else None


def _weighted(groups: list[str], around: Surroundings) -> str | None:
    weight = groups[2].replace(",", ".")
    return f"{groups[3]} weight {weight}" if float(weight) <= 1 else None


def _outside_tables(repair: Repair) -> Repair:
    def only(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
        if around.block != "table":
            yield from repair(code, text, around)

    return only


def _bare_name(groups: list[str], around: Surroundings) -> str | None:
    name = groups[1][1:-1].strip()
    return name if re.fullmatch(NAME, name) else None


_TEXT: Final = r"(?P<x>\"[^\"\n]*\")"
_NAMED: Final = "param|hedge|rules|function|and|or|implication|aggregation|defuzzifier|activation"


def _used_name(groups: list[str], around: Surroundings) -> str | None:
    """Return the name of a variable that other lines use; others may be labels whose name is missing."""
    name = _bare_name(groups, around)
    return name if name is not None and around.declared.counts[name] > 1 else None


def _unquoted(pattern: str, name: Replacement = _bare_name, *, heads: str = "") -> Repair:
    return by_pattern(pattern, name, "names have no quotes", heads=heads)


_UNQUOTED: Final = _unquoted(_TEXT)


def _unquoted_cells(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
    if around.block == "table" and ("|" in code or re.fullmatch(r"(?:\s*\"[^\"]*\")+\s*", code)):
        yield from _UNQUOTED(code, text, around)


#: Texts where names stand: anywhere in rules and tables, first in other statements, before and behind `=`.
_QUOTED: Final[tuple[Repair, ...]] = (
    _unquoted(rf"(?<!from ){_TEXT}", heads="if with terms table require"),
    _unquoted(rf"^\s*(?:input|output)\s+{_TEXT}", _used_name),
    _unquoted(rf"(?:^\s*(?:{_NAMED})|\b(?:implication|aggregation|defuzzifier))\s+{_TEXT}"),
    _unquoted(rf"^\s*{_TEXT}(?=\s*[:=])"),
    _unquoted(rf"^\s*{NAME}\s*:?=\s*{_TEXT}\s*$"),
    _unquoted_cells,
)


def _header(groups: list[str], around: Surroundings) -> str | None:
    """Drop the bars of the line below a table where all between them are terms of its columns, but for a corner."""
    corner, *cells = (cell.strip() for cell in groups[1].strip().strip("|").split("|"))
    column = re.findall(NAME, around.statement)[-1:]
    if not around.is_first or around.block != "table" or not column:
        return None
    terms = around.declared.words.get(column[0], set())
    is_corner = around.declared.variables.issuperset(re.split(r"\s*[\\/]\s*", corner)) or not corner
    names = cells if is_corner else [corner, *cells]
    distinct = len(set(names)) == len(names) > 0
    return f"{groups[2]}{' '.join(names)}" if distinct and terms.issuperset(names) else None


_SIGNED: Final = r"[-+]?[\w.]+"

#: Variables of one line, each with its label.
_NAMED_ONES: Final = rf"{NAME}(?:\s*\"[^\"]*\")?(?:\s*,\s*{NAME}(?:\s*\"[^\"]*\")?)*"

STATEMENTS: Final[tuple[Repair, ...]] = (
    by_pattern(";", "\n", "a line holds one statement"),
    by_pattern(rf"^\s*({'|'.join(STATEMENT_KEYWORDS)})\b(?P<x>\s+\1)(?=\s+[\w\"])", "", "a statement has one keyword"),
    *_QUOTED,
    by_pattern(
        r"^(?P<x>(\s*)[^|\n]*\|[^\n]*\|[^\n]*)$", _header, "the header holds the terms of the columns and no bars"
    ),
    by_pattern(
        r"^\s*(?P<x>\|?(?:\s*:?-{2,}:?\s*\|)+\s*(?::?-{2,}:?)?)\s*$", "", "a table has no line between header and rows"
    ),
    by_pattern(
        r"^\s*(?P<x>(?:rule\s*\w*\s*[:.)]|r?\d+\s*[.:)])\s*)(?=(?:\([\d.,]+\)\s*)?if\b)",
        "",
        "rules have no name or number",
    ),
    by_pattern(
        r"^\s*(?P<x>(?:weight\s*[=:]?\s*)?\(?\s*(\d*[.,]?\d+)\s*\)?\s*[:,]?\s*(if\b(?!.*\bweight\b).*?))\s*$",
        _weighted,
        "the weight of a rule stands at its end",
    ),
    by_pattern(r"^\s*(?P<x>\}|\{|end\w*)\s*$", "", "a block ends where the next statement begins"),
    by_pattern(r"(?P<x>\s*(?:[{:,]|\bdo))\s*$", "", ENDS),
    by_pattern(
        rf"^\s*(?!(?:if|unless|else|then|and|or)\b)(?P<x>{NAME})(?=[\s(]+(?:not\s+)?\(?{NAME}\s+is\b.*\bthen\b)",
        "if",
        "a rule begins with 'if'",
    ),
    by_pattern(r"^\s*(?P<x>else\s+)(?=if\b)", "", "rules have no 'else', each acts on its own"),
    by_pattern(rf"^\s*(?P<x>)(?={NAME}\s+is\s+.*(?:\bthen\b|=>|->))", "if ", "a rule begins with 'if'"),
    by_pattern(r"^\s*(?P<x>assert|ensure|guarantee|prove)\b", "require", "a guarantee begins with 'require'"),
    by_pattern(
        rf"^\s*(?:(?:hedge|function)\s+{NAME}\s*\([^()]*\)|(?:let|next|block)\s+{NAME})(?P<x>\s*(?::=|:|<-)\s*)",
        " = ",
        "a value is assigned with '='",
    ),
    by_pattern(
        rf"^\s*(?P<x>const|constant|let|var|parameter|def|real|float|double)(?=\s+{NAME}\s*:?=)",
        "param",
        "a named constant begins with 'param'",
    ),
    by_pattern(r"^\s*(?P<x>(?:include|import)\s+)(?=\")", "use ", "another file is named with 'use'"),
    by_pattern(rf"^\s*(?P<x>term\s*:?\s+)(?={NAME}\s*:?=|{NAME}\s+{NAME}\b)", "", "a term begins with its name"),
    by_pattern(
        rf"(?<=[)\]])(?P<x>\s*,?\s*)(?={NAME}\s*:?=\s*{NAME}\s*[(\[])",
        "\n  ",
        "each term with a function has its own line",
        heads="terms",
    ),
    by_pattern(rf"^\s*(?P<x>terms\s*:?\s+)(?={NAME}\s*:?=\s*{NAME}\s*[(\[])", "", "a term begins with its name"),
    by_pattern(
        rf"^\s*(?P<x>({NAME})\s*(?::=|:|=)?\s*)(?={NAME}\s*(?:\([^()]*\))?\s*$)",
        _setting_of,
        "a keyword is followed by its value",
    ),
    _value_of_setting,
    by_pattern(
        r"^\s*(?:system|source|use|rules|require)(?P<x>\s*(?::=|:|=)\s*)", " ", "the keyword is followed by its value"
    ),
    _capitals,
    by_pattern(
        rf"^\s*system\s+(?P<x>({NAME}(?:[ -]+{NAME})+))(?=\s*(?:\"|$))",
        _joined,
        "a name has no blanks or hyphens",
        sure=False,
    ),
    by_pattern(
        r"^\s*system(?P<x>\s*\"([^\"]*)\")\s*$",
        _named,
        "a system has a name before its title",
        sure=False,
    ),
    by_pattern(rf"^\s*param\s+{NAME}(?P<x>\s*(?::=|:|<-)\s*|\s+(?=[-+.\d(]))", " = ", "a value is assigned with '='"),
    _outside_tables(
        by_pattern(rf"^\s*{NAME}(?P<x>\s*(?::=|:|<-)\s*)(?=[^\s|:=])", " = ", "a value is assigned with '='")
    ),
    _decimal_commas,
    by_pattern(
        rf"^\s*(?:input|output)\s+(?!in\b){_NAMED_ONES}(?!\w)(?P<x>\s*(?:\bin\b|=|:|\brange\b|\bfrom\b)?\s*(?:range\s*)?"
        rf"[=:]?\s*[\[({{]?\s*({_SIGNED}?)\s*(?:,|;|:|\.\.+|\bto\b|\s)\s*({_SIGNED})\s*[\])}}]?)(?=\s*$|\s+\w)",
        _range,
        "a range is written: in [low, high]",
        heads="input output",
    ),
    by_pattern(
        rf"\bin\s*(?P<x>[\[({{]?\s*({_SIGNED})\s*(?:,|;|:|\.\.+|\bto\b|\s)\s*({_SIGNED})(?:\s*[\])}}])?)"
        r"(?=\s*(?:$|:?=|[^\W\d]))",
        "[{2}, {3}]",
        "a range is written: in [low, high]",
        heads="param",
    ),
    by_pattern(
        r"\s*\b(?P<x>default|otherwise)\s*(?::=|=|:)?\s*", "else ", "the value without rules is 'else'", heads="output"
    ),
    by_pattern(
        r"(?P<x>\s*,\s*)(?=(?:unit|else|clamp|extrapolate|adaptive|implication|aggregation|defuzzifier|terms)\b)",
        " ",
        "what follows the range is separated by blanks",
        heads="input output",
    ),
    by_pattern(r"\belse(?P<x>\s*(?::=|=|:)\s*)", " ", "'else' is followed by its value", heads="output"),
    by_pattern(r"\bunit(?P<x>\s*[=:]\s*)", " ", "'unit' is followed by a text", heads="input output param"),
    by_pattern(
        r"\bunit\s+(?!unit\b)(?P<x>[\[(]?([^\s\"\[\](),;]+)[\])]?)",
        '"{2}"',
        "a unit is a text in double quotes",
        heads="input output param let state measure",
    ),
    by_pattern(
        rf"\b(?:else|weight)\s+(?P<x>([-+]?[\w.]+(?:\s*[-+*/^]\s*[\w.]+)+|[-+]{NAME}))",
        "({2})",
        "an expression of several parts is written in parentheses",
        heads="output if",
    ),
    by_pattern(
        rf"^\s*table\s+{NAME}(?:\s*,\s*{NAME})*(?P<x>\s*[:(=]\s*)(?={NAME})",
        " = ",
        "the form is: table OUTPUT = ROWS x COLUMNS",
    ),
    by_pattern(
        rf"^\s*table\s+{NAME}\s*=\s*{NAME}(?P<x>\s*(?:,|\*|\bby\b|\band\b)\s*)(?={NAME})",
        " x ",
        "inputs are crossed with 'x'",
    ),
    by_pattern(r"^\s*table\b[^)(]*(?P<x>\))\s*$", "", "the form is: table OUTPUT = ROWS x COLUMNS"),
    by_pattern(rf"^\s*(?P<x>d({NAME})\s*/\s*dt\s*)(?==)", "der {2} ", _DERIVATIVE),
    by_pattern(rf"^\s*der(?P<x>\s*\(\s*({NAME})\s*\)\s*)(?==)", " {2} ", _DERIVATIVE),
    by_pattern(rf"^\s*(?P<x>)(?={NAME}\s*=\s*(?:tf|zpk|ss)\s*\()", "plant ", "a plant of one line begins with 'plant'"),
    by_pattern(r"\s*:=\s*", " = ", "a value is assigned with '='"),
    by_pattern(r"\*\*", "^", "a power is written '^'"),
    by_pattern(
        r"(?<![\w.)])([\w.]+)\s*%\s*([\w.]+)",
        "mod({1}, {2})",
        "a remainder is written mod(a, b)",
        heads="param require",
    ),
    by_pattern(
        rf"^(?P<x>(\s*)(?!(?:{'|'.join(STATEMENT_KEYWORDS)})\b)({NAME})\s*=\s*({NUMBER}))\s*$",
        _declaration,
        "a value alone declares nothing",
    ),
)

#: What comes last, since it takes any word for another.
SPELLING: Final[tuple[Repair, ...]] = (_misspelt, _misspelt_norm, _unclosed)
