"""Break a package in small ways, and count the mutants that its tests find.

    python tests/mutants.py --package kernels --mutants 60
    python tests/mutants.py --package lang --mutants 20 --tests tests/golden tests/fuzzyctl/lang

Each mutant changes one comparison, operator, condition or constant in a copy of the checkout, and runs the tests of the
package until the first failure. Mutants are drawn with a fixed seed, evenly over ten modules; those that survive are
printed with their place. A mutant whose tests take ten times as long as without it counts as found.
"""

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from copy import deepcopy
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).parent.parent

SWAPS = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.And: ast.Or,
    ast.Or: ast.And,
}


def mutated(node):
    """Return a changed copy of an expression, None if it has no mutant."""
    copy = deepcopy(node)
    match copy:
        case ast.Compare(ops=[operator, *_]):
            copy.ops[0] = SWAPS[type(operator)]()
        case ast.BinOp(op=operator) | ast.BoolOp(op=operator) if type(operator) in SWAPS:
            copy.op = SWAPS[type(operator)]()
        case ast.Constant(value=bool()):
            copy.value = not copy.value
        case ast.Constant(value=int() | float()):
            copy.value += 1
        case ast.IfExp():
            copy.body, copy.orelse = copy.orelse, copy.body
        case _:
            return None
    return copy


def sites(tree):
    """Yield the expressions of functions that have a mutant."""
    waiting = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    seen = set()
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.JoinedStr | ast.arg | ast.Subscript):  # texts, types, indices of tuples
            continue
        if id(node) in seen:
            continue
        seen.add(id(node))
        if mutated(node) is not None:
            yield node
        fields = (
            value for name, value in ast.iter_fields(node) if name not in ("annotation", "returns", "decorator_list")
        )
        for value in fields:
            waiting += [n for n in (value if isinstance(value, list) else [value]) if isinstance(n, ast.AST)]


def replaced(text, node):
    """Return a text with an expression replaced by its mutant, and the changed line."""
    lines = text.encode().split(b"\n")
    start = sum(len(line) + 1 for line in lines[: node.lineno - 1]) + node.col_offset
    end = sum(len(line) + 1 for line in lines[: node.end_lineno - 1]) + node.end_col_offset
    new = f"({ast.unparse(mutated(node))})"
    data = text.encode()
    return (data[:start] + new.encode() + data[end:]).decode(), f"{data[start:end].decode()} -> {new}"


def drawn(folder, count, modules, seed):
    """Return mutants as (path, node), drawn evenly over some modules."""
    choice = random.Random(seed)
    files = {}
    for path in sorted(folder.rglob("*.py")):
        found = sorted(sites(ast.parse(path.read_text(encoding="utf-8"))), key=lambda n: (n.lineno, n.col_offset))
        if found:
            files[path] = found
    paths = choice.sample(sorted(files), min(modules, len(files)))
    share = -(-count // len(paths))
    mutants = [(path, node) for path in paths for node in choice.sample(files[path], min(share, len(files[path])))]
    return mutants[:count]


def passes(folder, tests, limit):
    """Whether the tests of a copy pass within a time [s]."""
    call = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider", *tests]
    environment = {**os.environ, "PYTHONPATH": f"{folder}{os.pathsep}{folder / 'apps'}"}
    try:
        done = subprocess.run(call, cwd=folder, env=environment, capture_output=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def main():
    """Run the mutants and print the survivors."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--package", required=True, help="a folder of fuzzyctl, or dwmr")
    parser.add_argument("--mutants", type=int, default=60)
    parser.add_argument("--modules", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tests", nargs="*", help="default: tests/fuzzyctl/PACKAGE")
    options = parser.parse_args()
    home = "apps/dwmr" if options.package == "dwmr" else f"fuzzyctl/{options.package}"
    tests = options.tests or [f"tests/{home.removeprefix('apps/')}"]
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "checkout"
        names = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
        for name in names.splitlines():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
        began = perf_counter()
        assert passes(folder, tests, None), "the tests fail without a mutant"
        limit = 30 + 10 * (perf_counter() - began)
        mutants = drawn(folder / home, options.mutants, options.modules, options.seed)
        survivors = 0
        for number, (path, node) in enumerate(mutants, 1):
            text = path.read_text(encoding="utf-8")
            changed, what = replaced(text, node)
            path.write_text(changed, encoding="utf-8")
            alive = passes(folder, tests, limit)
            path.write_text(text, encoding="utf-8")
            survivors += alive
            if sys.stderr.isatty():
                print(f"\r{number} of {len(mutants)}", end="", file=sys.stderr, flush=True)
            if alive:
                print(f"survived: {path.relative_to(folder)}:{node.lineno}: {what}", flush=True)
        print(f"{len(mutants) - survivors} of {len(mutants)} found")


if __name__ == "__main__":
    main()
