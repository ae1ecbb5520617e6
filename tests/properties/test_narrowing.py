"""Enclosures that use conditions hold what is computed at every point of a box."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.expr import Binary, Call, Compare, Logic, Name, Negate, Number, Where
from fuzzyctl.kernels.interval.narrowing import NarrowingInterpreter
from fuzzyctl.kernels.interval.vector import Enclosure
from tests.properties.running import quick

ARGUMENTS = ("x", "y", "z")
USUAL = st.sampled_from([-2.0, -1.0, -0.3, 0.0, 0.1, 0.5, 1.0, 3.0])
#: Large ones overflow, and the difference of two infinite values is NaN.
NUMBERS = st.one_of(USUAL, USUAL, st.sampled_from([-1.7e308, -1e200, 1e200, 1.7e308]))
FUNCTIONS = {"exp": np.exp, "sign": np.sign, "abs": np.abs}


def compute(expr, names):
    """Compute an expression as kernels do: a choice takes one branch, and NaN holds no comparison."""
    match expr:
        case Number(value=value):
            return value
        case Name(name=name):
            return names[name]
        case Negate(operand=operand):
            return -compute(operand, names)
        case Binary(op=op, left=left, right=right):
            a, b = np.float64(compute(left, names)), np.float64(compute(right, names))
            return float({"+": a + b, "-": a - b, "*": a * b, "/": a / b}[op])
        case Call(function=function, arguments=(operand,)):
            return float(FUNCTIONS[function](compute(operand, names)))
        case Call(function=function, arguments=(left, right)):
            a, b = compute(left, names), compute(right, names)
            return (a if a < b else b) if function == "min" else (a if a > b else b)
        case Where(condition=condition, then=then, otherwise=otherwise):
            return compute(then if holds(condition, names) else otherwise, names)
    raise TypeError


def holds(condition, names):
    match condition:
        case Compare(op=op, left=left, right=right):
            a, b = compute(left, names), compute(right, names)
            return {"<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b, "==": a == b, "!=": a != b}[op]
        case Logic(op="not", operands=(operand,)):
            return not holds(operand, names)
        case Logic(op="and", operands=operands):
            return all(holds(o, names) for o in operands)
    return any(holds(o, names) for o in condition.operands)


@st.composite
def values(draw, names, depth=2):
    """Draw an expression over names, lags and shares among them."""
    atom = st.one_of(st.sampled_from(names).map(Name), NUMBERS.map(Number))
    if depth == 0:
        return draw(atom)
    inner = values(names, depth - 1)
    start, kind = Name(draw(st.sampled_from(names))), draw(st.integers(0, 10))
    match kind:
        case 0:
            return start + draw(inner) * (draw(inner) - start)
        case 1:
            return start / (draw(inner) + start)
        case 2:
            return Where(draw(conditions(names)), draw(inner), draw(inner))
        case 3:
            return Call(draw(st.sampled_from(["min", "max"])), (draw(inner), draw(inner)))
        case 4:
            return -draw(inner)
        case 5 | 6:
            return Binary(draw(st.sampled_from("+-")), draw(inner), draw(inner))
        case 7:
            return Binary(draw(st.sampled_from("*/")), draw(inner), draw(inner))
        case 8:
            return Binary("*", start, start)
        case 9:
            return Call(draw(st.sampled_from(sorted(FUNCTIONS))), (draw(inner),))
    return draw(atom)


@st.composite
def conditions(draw, names, depth=1):
    """Draw a condition over names."""
    kind = draw(st.integers(0, 4)) if depth else 0
    if kind in (0, 1):
        op = draw(st.sampled_from(["<", "<=", ">", ">=", "==", "!="]))
        return Compare(op, draw(values(names, 1)), draw(values(names, 0)))
    if kind == 2:
        return Logic("not", (draw(conditions(names, depth - 1)),))
    return Logic("and" if kind == 3 else "or", tuple(draw(conditions(names, depth - 1)) for _ in range(2)))


@st.composite
def cases(draw):
    """Draw definitions, each over arguments and those before it, the last one a choice; and a box."""
    names, found = list(ARGUMENTS), {}
    for k in range(draw(st.integers(1, 4))):
        found[f"d{k}"] = draw(values(names))
        names.append(f"d{k}")
    found["last"] = Where(draw(conditions(names)), draw(values(names)), draw(values(names)))
    ends = [sorted(draw(st.tuples(NUMBERS, NUMBERS))) for _ in ARGUMENTS]
    return found, dict(zip(ARGUMENTS, ends, strict=True))


@given(cases(), st.integers(0, 2**32 - 1), st.booleans())
@quick(4000, 30)
def test_what_is_computed_lies_in_its_enclosure(case, seed, nearest):
    definitions, box = case
    given = {n: Enclosure(np.array([lo]), np.array([hi]), None, np.array(0.0)) for n, (lo, hi) in box.items()}
    interpreter = NarrowingInterpreter(given, definitions, nearest=nearest)
    random = np.random.default_rng(seed)
    with np.errstate(all="ignore"):
        for name, definition in definitions.items():
            interpreter.names[name] = interpreter.enclose(definition)
        for _ in range(60):
            inside = {n: min(max(0.3 * lo + 0.7 * hi, lo), hi) for n, (lo, hi) in box.items()}
            point = {n: float(random.choice([*ends, inside[n]])) for n, ends in box.items()}
            for name, definition in definitions.items():
                value = point[name] = compute(definition, point)
                lo, hi = (
                    float(np.broadcast_to(e, 1)[0]) for e in (interpreter.names[name].lo, interpreter.names[name].hi)
                )
                assert (lo <= value <= hi) or (math.isnan(value) and (lo, hi) == (-math.inf, math.inf)), (
                    name, value, lo, hi, definitions, point,
                )  # fmt: skip
