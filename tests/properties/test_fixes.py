"""Slips of typists and of hands from other tools: found on their line, and repaired by `check --fix` without harm."""

import random
import re
import shutil
from collections import Counter
from itertools import islice
from pathlib import Path

import pytest

import fuzzyctl
from fuzzyctl.testing import check_text, run_command
from tests import sizes
from tests.shipped import LAWS, rules_folder

PUBLISHED = Path(__file__).parent.parent / "registry" / "published"
TOKEN = re.compile(r'"[^"\n]*"|(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?|[^\W\d]\w*|<=|>=|==|!=|[^\s]')
LAW_NAMES = {path.name for path in LAWS}
LETTERS = "abcdefghijklmnopqrstuvwxyz"


def texts():
    return sorted([*rules_folder().rglob("*.fz"), *PUBLISHED.glob("*.fz")])


def slipped(rng, word):
    """Return a word with one letter less, more, changed, or swapped with its neighbour, or in capitals."""
    k = rng.randrange(len(word) - 1)
    changed = word[:k] + rng.choice(LETTERS) + word[k + 1 :]
    swapped = word[:k] + word[k + 1] + word[k] + word[k + 2 :]
    return rng.choice(
        [word[:k] + word[k + 1 :], word[:k] + word[k] + word[k:], changed, swapped, word.upper(), word.capitalize()]
    )


def of_another_tool(rng, line):
    """Return a line with one habit of MATLAB, FCL, C or a word processor."""
    code = line.split("#")[0].rstrip()
    habits = [code + ";" + line[len(code) :]]
    if "#" in line:
        habits += [line.replace("#", "%", 1), line.replace("#", "//", 1)]
    if '"' in line:
        habits.append(re.sub(r'"([^"]*)"', "“\\1”", line))
    if " and " in code or " or " in code:
        habits.append(line.replace(" and ", " && ").replace(" or ", " || "))
    if re.search(r"\d\.\d", code):
        habits.append(re.sub(r"(\d)\.(\d)", r"\1,\2", line, count=1))
    if " = " in code:
        habits.append(line.replace(" = ", " := ", 1))
    return rng.choice(habits)


def mutant(rng, text):
    """Return a text with one slip, as (kind, text); None where the slip changes nothing."""
    lines = text.split("\n")
    i = rng.randrange(len(lines))
    line = lines[i]
    tokens = list(TOKEN.finditer(line.split("#")[0]))
    if not tokens:
        return None
    k = rng.randrange(len(tokens))
    (a, b), word = tokens[k].span(), tokens[k][0]
    kind = rng.choice(["letter", "letter", "letter", "habit", "habit", "repeated", "lost", "swapped"])
    if kind == "letter":
        changed = line[:a] + slipped(rng, word) + line[b:] if word.isidentifier() and len(word) > 3 else line
    elif kind == "habit":
        changed = of_another_tool(rng, line)
    elif kind == "repeated":
        changed = f"{line[:b]} {line[a:]}"
    elif kind == "lost":
        changed = line[:a] + line[b:]
    else:
        c, d = tokens[min(k + 1, len(tokens) - 1)].span()
        changed = line[:a] + line[c:d] + line[b:c] + word + line[d:] if c > a else line
    return None if changed.split() == line.split() else (kind, "\n".join([*lines[:i], changed, *lines[i + 1 :]]))


def behind(sign):
    return lambda line: line + sign


def changed(pattern, new):
    return lambda line: re.sub(pattern, new, line, count=1)


def in_rules(slip):
    return lambda line: slip(line) if line.startswith("if ") else line


#: Slips of one line by what they are: they may be combined, and none of them leaves open what was meant.
SLIPS = {
    "semicolon": behind(";"),
    "comma behind": behind(","),
    "percent": lambda line: f"{line}  % why",
    "curly quotes": changed(r'"([^"]*)"', "“\\1”"),
    "&&": lambda line: line.replace(" and ", " && "),
    "||": lambda line: line.replace(" or ", " || "),
    ":=": changed(r" = ", " := "),
    "capitals of rules": lambda line: (
        re.sub(r"^if\b|\b(then|is)\b", lambda m: m[0].upper(), line) if line[:2] == "if" else line
    ),
    "capitals of heads": changed(r"^(input|output|param|table|system)\b", lambda m: m[0].upper()),
    "== for is": in_rules(lambda line: line.replace(" is ", " == ")),
    "iz": changed(r"^(if .*?) is ", r"\1 iz "),
    "tehn": changed(r" then ", " tehn "),
    "=>": changed(r"^(if .*) then ", r"\1 => "),
    "comma before then": changed(r"^(if .*) then ", r"\1, then "),
    "range of dots": changed(r"\bin \[([-\w.]+), ([-\w.]+)\]", r"in \1 .. \2"),
    "bare unit": changed(r'unit "(\w+)"', r"unit \1"),
    "brackets of MATLAB": changed(r"= triangle\(([^(),]+), ([^(),]+), ([^(),]+)\)", r"= trimf [\1 \2 \3]"),
    "order of MATLAB": changed(r"= gaussian\(([^(),]+), ([^(),]+)\)", r"= gaussmf(\2, \1)"),
    "unclosed": changed(r"\)$", ""),
    "defuzzifer": changed(r"^defuzzifier", "defuzzifer"),
    "== behind param": changed(r"^(param \w+) =", r"\1 = ="),
    "minus sign": changed(r"-(?=\d)", "−"),
}


def slipped_lines(rng, text, count):
    """Yield a line of a text with a number of slips for each of its lines that can have them, as (number, line)."""
    for i, line in enumerate(text.split("\n")):
        usable = [
            s for s in SLIPS.values() if not re.search(r'#|".*[-=,;].*"', line) and line.strip() and s(line) != line
        ]
        if len(usable) < count:
            continue
        before = [line]
        for slip in rng.sample(usable, count):
            before.append(slip(before[-1]))
        if len(set(before)) == count + 1:
            yield i, before[-1]


def words_of(text):
    return [line.split() for line in text.split("\n")]


def fixed(text, path, certainty="sure"):
    """Return a text of a rule file of a folder after the fixes of the command, and how many errors it has then."""
    result = run_command("check", "--fix", certainty, "-", stdin=text, folder=path.parent)
    count = re.search(r"^(\d+) errors?, ", result.errors, flags=re.MULTILINE)
    return result.output, int(count[1]) if count else 0


def errors_of(text, path):
    """Return the errors of a text of a file, refuted claims left out."""
    found = check_text(text, str(path), folder=path.parent, guarantees=False)[1]
    return [d for d in found if d.severity == "error"]


def test_sure_fixes_bring_texts_back_and_make_none_worse():
    rng = random.Random(20)
    files = [(path, path.read_text(encoding="utf-8")) for path in texts()]
    wanted, seen, equal = sizes.examples(1000, 15), Counter(), Counter()
    while seen.total() < wanted:
        path, text = rng.choice(files)
        made = mutant(rng, text)
        if made is None:
            continue
        kind, slip = made
        errors = errors_of(slip, path)
        if not errors:  # another valid file, such as one with another title
            continue
        seen[kind] += 1
        once, left = fixed(slip, path)
        assert once == slip or fixed(once, path)[0] == once, slip
        assert left <= len(errors), slip
        equal[kind] += words_of(once) == words_of(text)
        assert fixed(slip, path, "likely")[1] <= len(errors), slip
    assert equal.total() >= 0.6 * wanted, {k: (equal[k], seen[k]) for k in seen}


@pytest.mark.parametrize(("count", "share"), [(2, 0.95), (3, 0.9)])
def test_lines_with_several_slips_come_back(count, share):
    """All repairs of a line at once: two or three slips that do not leave open what was meant."""
    rng, equal, others = random.Random(count), 0, []
    lines = [
        (path, text, i, line)
        for path in texts()
        for text in [path.read_text(encoding="utf-8")]
        if len(text) < 5000
        for i, line in slipped_lines(rng, text, count)
    ]
    wanted = min(sizes.examples(1000, 10), len(lines))
    for path, text, i, line in rng.sample(lines, wanted):
        rows = text.split("\n")
        repaired = fixed("\n".join([*rows[:i], line, *rows[i + 1 :]]), path, "likely")[0].split("\n")
        same = "".join(repaired[i].split("#")[0].split()) == "".join(rows[i].split())
        equal += same
        others += [] if same else [(line, repaired[i])]
    assert equal >= share * wanted, (equal, wanted, others)


def slips_of(text):
    """Yield (kind, line number, mutated text) for every token of every line of code, and every dropped row."""
    lines = text.split("\n")
    for i, line in enumerate(lines):
        code = line.split("#")[0]
        tokens = list(TOKEN.finditer(code))
        for k, token in enumerate(tokens):
            a, b = token.span()
            after = tokens[k + 1] if k + 1 < len(tokens) else None
            changes = {"delete": line[:a] + line[b:], "double": line[:b] + " " + line[a:]}
            if after is not None:
                swapped = after[0] + line[b : after.start()] + token[0]
                changes["swap"] = line[:a] + swapped + line[after.end() :]
            if len(token[0]) > 3 and token[0].isidentifier():
                changes["misspell"] = line[: a + 1] + line[a + 2 :]
            for kind, changed in changes.items():
                if changed.split() != line.split():
                    yield kind, i + 1, "\n".join([*lines[:i], changed, *lines[i + 1 :]])
        if "|" in code:
            yield "drop row", i, "\n".join([*lines[:i], *lines[i + 1 :]])


def errors_on_load(path, text):
    """Return the errors of a changed shipped file, which may use the others of its folder."""
    path.write_text(text, encoding="utf-8")
    try:
        fuzzyctl.load(path, block=fuzzyctl.Controller if path.name in LAW_NAMES else fuzzyctl.FuzzySystem)
    except fuzzyctl.DiagnosticError as error:
        return error.diagnostics
    except fuzzyctl.FuzzyctlError:  # it is another block
        return []
    return []


def test_slips_are_found_on_their_line(tmp_path):
    # A token has up to four slips, mostly three, so that each 41st one is of all kinds in turn: 170 of 7,000.
    step = 1 if sizes.LONG else 41
    elsewhere, found = [], 0
    for path in shutil.copytree(rules_folder(), tmp_path / "rules").glob("*.fz"):
        original = path.read_text(encoding="utf-8")
        for kind, line, text in islice(slips_of(original), 0, None, step):
            errors = errors_on_load(path, text)
            lines = {d.span.line for d in errors if d.span is not None}
            if errors and lines.isdisjoint(range(1, line + 1) if kind == "drop row" else (line,)):
                elsewhere.append((path.name, kind, line, sorted(lines), errors[0].message))
            elif errors:  # else another valid system, such as one with two terms swapped in a table
                found += 1
        path.write_text(original, encoding="utf-8")
    assert found > 3000 // step
    assert found >= 19 * len(elsewhere), elsewhere
