"""Habits of style that plain English does without, counted by package; the counts may only fall.

python -m tests.habits                       print the counts
python -m tests.habits --list is-none docs   list each place
python -m tests.habits --lower               store the counts that fell
"""

import argparse
import ast
import json
import re
from collections import Counter, defaultdict
from functools import cache
from pathlib import Path

from tests.own_files import own_files

ROOT = Path(__file__).parent.parent
STORED = Path(__file__).with_suffix(".json")

#: Turns of phrase in docstrings, comments and pages.
HABITS = {
    "what-clause": r"\b[Ww]hat (?:is|are|it|they|its|the|a|an|each|no|nothing|some|one|has|have|can|cannot|may|was|were"
    r"|does|do|differs|follows|[a-z]+s)\b",
    "nothing-subject": r"\b(?:that|which|what|where|whom) (?:nothing|none|nobody|no one)\b"
    r"|\b[Nn]othing (?:reads|names|uses|says|is|else)\b",
    "is-none": r"\b(?:is|are|was) none\b",
    "stands": r"\bstands?\b(?! for\b)",
    "own": r"\b(?:one's|its|their|of your|of his) own\b|\bof one's\b",
    "said-told-due": r"\b(?:is|are) (?:said|told|due)\b|\bsays (?:so|which|what)\b",
    "asked-for": r"\basked for\b|\bcomes? to (?:no|its|an)\b",
    "where-for-if": r"\b[Ww]here (?:no|it|they|this|nothing|there|an?|the) [a-z]+ (?:is|are|has|have|does|do)\b",
    "beside-behind": r"\b(?:beside|behind) (?:it|them|which)\b",
}
#: Participles that are no names of variables: a name says what a variable holds, not how it came about.
PARTICIPLES = {"found", "own", "given", "made", "taken", "said", "kept", "held", "shown", "known"}


def lines_of_page(source):
    """Yield each line of a page with its number, without code."""
    fenced = False
    for number, line in enumerate(source.split("\n"), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced:
            yield number, line


def lines_of_module(source, nodes):
    """Yield each line of the docstrings and comments of a module with its number."""
    for node in nodes:
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            text = ast.get_docstring(node, clean=False) or ""
            yield from enumerate(text.split("\n"), node.body[0].lineno) if text else ()
    for number, line in enumerate(source.split("\n"), 1):
        at = line.find("#")
        if at >= 0 and line[:at].count('"') % 2 == 0:
            yield number, line[at:]


def places(path):
    """Yield each habit of a file with its line and text; of participles the function whose variables they are."""
    source = path.read_text(encoding="utf-8")
    nodes = list(ast.walk(ast.parse(source))) if path.suffix == ".py" else []
    for number, text in lines_of_module(source, nodes) if nodes else lines_of_page(source):
        for habit, pattern in HABITS.items():
            for _ in re.finditer(pattern, text):
                yield habit, number, text.strip()
    for node in nodes:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            names = {n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
            if names & PARTICIPLES:
                yield "participle", node.lineno, f"{node.name}: {', '.join(sorted(names & PARTICIPLES))}"


@cache
def files():
    """Return the files that are counted, relative to the repository."""
    trees = [path for name in ("fuzzyctl", "apps", "docs") for path in own_files(ROOT / name, "*")]
    paths = [path for path in trees if path.suffix in (".py", ".md")]
    return [path.relative_to(ROOT) for path in [*paths, ROOT / "README.md", ROOT / "CONTRIBUTING.md"]]


def counts():
    """Return the count of each habit by package."""
    table = defaultdict(Counter)
    for path in files():
        for habit, _, _ in places(ROOT / path):
            table["/".join(path.parts[:2])][habit] += 1
    return {package: dict(sorted(table[package].items())) for package in sorted(table)}


def risen(now, stored):
    """Return each count that is larger than the stored one, as (package, habit, stored, now)."""
    return [
        (package, habit, stored.get(package, {}).get(habit, 0), count)
        for package, row in now.items()
        for habit, count in row.items()
        if count > stored.get(package, {}).get(habit, 0)
    ]


def main():
    """Print counts or places, or store the counts that fell."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--list", choices=[*HABITS, "participle"], help="print the places of a habit")
    parser.add_argument("--lower", action="store_true", help="store the counts; refused where one has risen")
    parser.add_argument("path", nargs="?", default="", help="beginning of the paths to list")
    options = parser.parse_args()
    if options.list:
        for path in files():
            for habit, number, text in places(ROOT / path) if str(path).startswith(options.path) else ():
                if habit == options.list:
                    print(f"{path}:{number}: {text[:140]}")
        return
    table = counts()
    if options.lower:
        assert not risen(table, json.loads(STORED.read_text())), "a count has risen"
        STORED.write_text(json.dumps(table, indent=1) + "\n")
    for habit in (*HABITS, "participle"):
        print(f"{habit:16}{sum(row.get(habit, 0) for row in table.values()):6}")


if __name__ == "__main__":
    main()
