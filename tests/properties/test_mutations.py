"""Slips of a typist in the shipped rule files: nearly all that are mistakes are reported on their very line."""

import re
from itertools import islice

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import examine_all
from tests import sizes
from tests.shipped import rules_folder

TOKEN = re.compile(r'"[^"\n]*"|(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?|[^\W\d]\w*|<=|>=|==|!=|[^\s]')


def mutants(text):
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


def test_slips_are_found_on_their_line():
    # A token has up to four slips, mostly three: each fourth one is of all kinds in turn.
    # A token has up to four slips, mostly three, so that each 13th one is of all kinds in turn: 500 of 7,000.
    step = 1 if sizes.LONG else 13
    found = missed = accepted = 0
    elsewhere = []
    for path in sorted(rules_folder().glob("*.fz")):
        text = path.read_text(encoding="utf-8")
        for kind, line, mutant in islice(mutants(text), 0, None, step):
            _, diagnostics = examine_all(SourceText(path.name, mutant), folder=path.parent)
            if not diagnostics:
                accepted += 1  # another valid system, such as one with two terms swapped in a table
                continue
            lines = {d.span.line for d in diagnostics if d.span is not None}
            # A dropped row is reported at its table.
            near = range(1, line + 1) if kind == "drop row" else (line,)
            if lines & set(near):
                found += 1
            else:
                missed += 1
                elsewhere.append((path.name, kind, line, sorted(lines), diagnostics[0].message))
    assert found + missed > 1000 // step
    assert found / (found + missed) >= 0.95, f"{missed} of {found + missed}: {elsewhere[:20]}"
