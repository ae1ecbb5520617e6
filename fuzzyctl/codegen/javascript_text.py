"""Statements of programs as lines of JavaScript: every value a constant, every table of the module."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from importlib.resources import files
from typing import Any, Final

from fuzzyctl.codegen import c_source
from fuzzyctl.codegen.c_text import bare, wrapped
from fuzzyctl.codegen.comments import printable
from fuzzyctl.codegen.errors import CodegenError, unprintable
from fuzzyctl.codegen.simplify import TRUE
from fuzzyctl.codegen.wrapping import broken, folded
from fuzzyctl.expr import Binary, Call, Expr, replace
from fuzzyctl.kernels.program import quadrature
from fuzzyctl.kernels.program.printer import INDENT, PRIMITIVES, SCALAR, Dialect, index_text, text
from fuzzyctl.kernels.program.program import (
    Accumulate,
    Assign,
    Fold,
    Locate,
    Offset,
    Place,
    Program,
    Quadrature,
    Refuse,
    Statement,
)
from fuzzyctl.kernels.program.traversal import statements as all_of

#: Most knots counted by comparisons; more are searched in a loop.
COMPARED: Final = 16
#: Operations that the text itself has as comparisons and choices.
_PRINTED: Final = frozenset({"min", "max", "clip"})

#: The function that finds the last knot that is not beyond a value.
_FIND: Final = """function find(knots, x) {
    let k = 0;
    for (let step = 2 ** Math.floor(Math.log2(knots.length)); step >= 1; step /= 2) {
        if (k + step < knots.length && knots[k + step] <= x) {
            k += step;
        }
    }
    return k;
}"""

#: The function that refuses an argument which is not a number, such as the text of an element of a page.
REQUIRE_NUMBER: Final = """function require_number(name, value) {
    if (typeof value !== "number") {
        throw new TypeError("a number is expected for '" + name + "', not " + typeof value);
    }
}"""

#: The error if no rule fires for an output with `else error`.
NO_RULE_FIRES: Final = """export class NoRuleFiresError extends Error {
    constructor(output) {
        super("no rule fires for output '" + output + "'");
        this.name = "NoRuleFiresError";
        this.output = output;
    }
}"""


def literal(value: float) -> str:
    """Return a number that reads back bit for bit."""
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "Infinity" if value > 0 else "(-Infinity)"
    return repr(value) if math.copysign(1.0, value) > 0 else f"({value!r})"


def quoted(content: str) -> str:
    """Return a string in ASCII, which ends neither itself nor a script of a page."""
    return json.dumps(content).replace("<", "\\u003c")


def record(values: Mapping[str, Any]) -> str:
    """Return an object of strings, numbers and truth values; its keys are identifiers of the generated text."""
    parts = []
    for key, value in values.items():
        word = quoted(value) if isinstance(value, str) else str(value).lower()
        parts.append(f"{key}: {bare(literal(value)) if isinstance(value, float) else word}")
    return f"{{ {', '.join(parts)} }}" if parts else "{}"


def list_lines(declared: str, entries: Iterable[str]) -> Iterator[str]:
    """Yield the lines of a constant array, one entry in each."""
    yield from (f"{declared} = [", *(f"{INDENT}{entry}," for entry in entries), "];")


def comment(lines: Sequence[str]) -> list[str]:
    """Return lines as comments, in which no tag of a page begins or ends."""
    return [re.sub(r"<(?=[!/A-Za-z])", "< ", line) for line in c_source.comment(lines)]


def comments(notes: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """Return notes by name as lines of comment."""
    return {name: comment(list(folded([printable(note) for note in texts]))) for name, texts in notes.items()}


def _item(array: str, index: int | str | Place) -> str:
    return f"{array}[{index_text(index)}]"


#: How JavaScript writes expressions.
DIALECT: Final = Dialect(
    where=lambda c, a, b: f"({c} ? {a} : {b})",
    smaller=lambda a, b: f"({a} < {b} ? {a} : {b})",
    larger=lambda a, b: f"({a} > {b} ? {a} : {b})",
    clip=lambda x, a, b: f"({x} < {a} ? {a} : ({x} > {b} ? {b} : {x}))",
    logic=(" && ", " || ", "!"),
    locate=SCALAR.locate,
    item=_item,
    constant=literal,
)


def value_text(value: Expr, own: Dialect) -> str:
    """Return an expression, in parentheses if it is compound."""
    return "true" if value == TRUE else text(replace(value, _called), own)


def _called(node: Expr) -> Expr:
    """Take powers for calls, whose exponents are printed as all numbers are."""
    return Call("power", (node.left, node.right)) if isinstance(node, Binary) and node.op == "^" else node


def tables(program: Program, notes: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """Yield the tables of a program, each after a comment with its meaning."""
    for name, values in program.tables:
        yield from notes[name]
        yield f"const {name} = Float64Array.of("
        yield from wrapped([bare(literal(v)) for v in values], INDENT)
        yield ");"


def block(
    statements: Sequence[Statement],
    own: Dialect,
    refuse: Callable[[str], str],
    notes: Mapping[str, Sequence[str]],
    depth: int = 1,
) -> Iterator[str]:
    """Yield the lines of some statements.

    Args:
        statements: What to print.
        own: How expressions are written.
        refuse: The line of a refusal, from the name of the output.
        notes: Lines of comment before values, by name.
        depth: Levels of indentation.
    """
    pad = INDENT * depth
    for statement in statements:
        match statement:
            case Assign(name=name, value=value):
                yield from (pad + line for line in notes.get(name, ()))
                yield f"{pad}const {name} = {bare(value_text(value, own))};"
            case Locate(x=x):
                yield from (pad + line for line in _located(statement, value_text(x, own)))
            case Offset(name=name, parts=parts):
                total = " + ".join(n if stride == 1 else f"{stride} * {n}" for n, stride in parts)
                yield f"{pad}const {name} = {total};"
            case Accumulate():
                yield from block([statement.fold], own, refuse, notes, depth)
            case Fold(count=count, counter=k, first=first, body=body, then=then):
                yield from (f"{pad}let {s.name} = {bare(value_text(s.value, own))};" for s in first)
                yield f"{pad}for (let {k} = 0; {k} < {count}; ++{k}) {{"
                yield from block(body, own, refuse, notes, depth + 1)
                yield from (f"{pad}{INDENT}{s.name} = {bare(value_text(s.value, own))};" for s in then)
                yield f"{pad}}}"
            case Quadrature(found=found, area=area, kind=kind, x=x, body=body, value=value, places=places, marks=marks):
                yield f"{pad}const {statement.function} = ({x}) => {{"
                yield from block(body, own, refuse, notes, depth + 1)
                yield from (f"{pad}{INDENT}return {bare(value_text(value, own))};", f"{pad}}};")
                texts = ", ".join(bare(value_text(m, own)) for m in marks)
                yield f"{pad}const [{found}, {area}] = quadrature.{kind}({statement.function}, {places}, [{texts}]);"
            case Refuse(condition=condition, output=output):
                yield f"{pad}if ({bare(value_text(condition, own))}) {{"
                yield f"{pad}{INDENT}{refuse(output)}"
                yield f"{pad}}}"
            case _:
                raise unprintable(statement)


def _located(statement: Locate, x: str) -> Iterator[str]:
    """Yield lines that find a knot: all comparisons where they are few, else a search."""
    name, rest, table = statement.name, statement.rest, statement.table
    knots = [literal(k) for k in statement.knots]
    if statement.wants_rest:
        yield f"const {rest}_x = {x} < {knots[0]} ? {knots[0]} : {x} > {knots[-1]} ? {knots[-1]} : {x};"
        x = f"{rest}_x"
    # Without branches: at random points they take nearly twice the time.
    counted = " + ".join(["0", *(f"({x} >= {k})" for k in knots[1:])])
    place = counted if len(knots) <= COMPARED else f"find({table}, {x})"
    yield f"const {name}_k = {place};"
    yield f"const {name} = {name}_k{f' * {statement.stride}' if statement.stride != 1 else ''};"
    if statement.wants_rest:
        yield f"const {rest} = {rest}_x - {table}[{name}_k];"


def helpers(functions: Iterable[str], statements: Sequence[Statement]) -> Iterator[str]:
    """Yield the functions that programs call, and what these need.

    Raises:
        CodegenError: For a function that JavaScript has no text for.
    """
    for name in sorted(set(functions) - _PRINTED):
        primitive = PRIMITIVES.get(name)
        if primitive is None:
            raise CodegenError(f"the function {name!r} has no text in JavaScript", name)
        if primitive.javascript == f"Math.{name}":
            yield from (f"const {name} = {primitive.javascript};", "")
        else:
            arguments = ", ".join(primitive.arguments.split())
            yield from (f"function {name}({arguments}) {{", f"{INDENT}return {primitive.javascript};", "}", "")
    if any(isinstance(s, Locate) and len(s.knots) > COMPARED for s in all_of(statements)):
        yield from (_FIND, "")
    if any(isinstance(s, Quadrature) for s in all_of(statements)):
        yield from (_quadrature(), "")


def _quadrature() -> str:
    """Return the functions that integrate sets, with the constants of the kernels."""
    text = files("fuzzyctl.codegen").joinpath("quadrature.js").read_text(encoding="utf-8")
    lines: list[str] = []
    for name, value in vars(quadrature).items():
        if name.isupper() and re.search(rf"\b{name}\b", text):
            numbers = map(literal, value if isinstance(value, tuple) else (value,))
            literals = ", ".join(numbers) if not isinstance(value, tuple) else f"[{', '.join(numbers)}]"
            lines += broken([f"{INDENT}const {name} = {literals};"], "  ")
    return text.replace(f"{INDENT}CONSTANTS", "\n".join(lines)).rstrip()


def file_text(lines: Iterable[str]) -> str:
    """Return the text of a file, without blank lines that follow each other."""
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).rstrip("\n") + "\n"
