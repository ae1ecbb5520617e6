"""The arithmetic of `verify.py`: sets of numbers, outward rounded. It needs Python alone.
Numbers are whole multiples of a unit, 2^-96. A form [c, r, g1, ..., gm] is the set of c + r e + g1 e1 + ... + gm em for
all e, e1, ..., em in [-1, 1]; forms share e1, ..., em. Operations round outward: r grows by the units that shifts drop.
A form [c, r] is an interval. docs/explanation/proofs.md, "Certificates", walks through this file."""
import math
from functools import partial, reduce
from itertools import pairwise, product, zip_longest
from typing import Any
BITS, SLABS, ONE, MINUS = 96, 12, 1 << 96, [-1 << 96, 0]  # binary digits after the point; slabs of a table; 1; -1
WORK = [0, 10**9]  # the work so far, and the most that a file may cause
def need(condition: Any, text: str, work: int = 0) -> Any:  # all that is checked is checked here; returns nothing
    WORK[0] += work
    if not condition or WORK[0] > WORK[1]: raise AssertionError("too much work" if condition else text)
def say(line: str) -> None: print(line) if line.isprintable() else need(False, "a text has control characters")
def keyed(**rows: Any) -> Any: return {(kind, i): a for kind, forms in rows.items() for i, a in enumerate(forms)}
def number(x: Any, cut: bool = False) -> Any:  # of the file; from 2^-43 on all numbers are multiples of the unit
    if isinstance(x, list): return [number(y, cut) for y in x]
    need(type(x) in (int, float) and abs(x) < 2**64, f"{x!r:.40} is no number below 2^64")
    need(cut or 2**BITS % x.as_integer_ratio()[1] == 0, f"{x!r:.40} is no multiple of 2^-{BITS}")
    return (x.as_integer_ratio()[0] << BITS) // x.as_integer_ratio()[1]
hinted = partial(number, cut=True)  # hints may be anything
def ends(a: Any) -> Any: return need(True, "", 20 + len(a)) or (a[0] - (r := sum(map(abs, a[1:]))), a[0] + r)
def between(low: int, high: int) -> list[int]:  # all numbers from low to high
    need(low <= high, "a range is empty")
    return [(low + high) >> 1, high - ((low + high) >> 1)]
def enclosed(low: Any, high: Any) -> list[int]: return between(hinted(low), -hinted(-high))  # ends are cut outward
def add(a: Any, b: Any) -> Any:
    return need(True, "", 9 + len(a + b)) or [x + y for x, y in zip_longest(a, b, fillvalue=0)]
def minus(a: Any, b: Any) -> Any: return add(a, times(b, MINUS))
def total(forms: Any) -> Any: return reduce(add, forms, [0, 0])
def times(a: list[int], b: list[int]) -> Any:  # e e lies in [0, 1] = 1/2 + [-1/2, 1/2], e f in [-1, 1]
    if not (any(a) and any(b)): return need(True, "", 9) or [0, 0]
    both, ra, rb = [x * y for x, y in zip(a[2:], b[2:])], sum(map(abs, a[1:])), sum(map(abs, b[1:]))
    r = abs(a[0]) * b[1] + abs(b[0]) * a[1] + ra * rb - sum(map(abs, both)) // 2
    g = [(a[0] * y + b[0] * x) >> BITS for x, y in zip_longest(a[2:], b[2:], fillvalue=0)]
    need(abs(a[0]) + ra + abs(b[0]) + rb < ONE << 200, "numbers become too large", 40 + 8 * len(g))
    return [(2 * a[0] * b[0] + sum(both)) >> (BITS + 1), (r >> BITS) + len(g) + 3, *g]  # each shift drops below a unit
def either(a: Any, b: Any = None) -> Any:  # all between two forms: their mean and half of their distance
    if b is None: return a
    return add(times(add(a, b), [ONE >> 1, 0]), [0, (max(map(abs, ends(minus(a, b)))) >> 1) + 1])
def wave(signs: tuple[int, ...], x: int) -> int:  # the sum of signs[n % 4] x^n / n!, wrong by less than a unit
    need(abs(x) < 64 * ONE, "the argument of sin, cos or exp is beyond 64", 400 + 40 * (abs(x) >> BITS))
    x, term, n, result = x << 128, 1 << (BITS + 128), 0, 0  # 128 further digits, as terms may reach e^64 < 2^93
    while term or n <= abs(x) >> (BITS + 128):  # then terms become smaller
        result, term, n = result + signs[n % 4] * term, term * x // ((n + 1) << (BITS + 128)), n + 1
    return result >> 128
EXP, SIN, COS, NEG = (partial(wave, s) for s in ((1, 1, 1, 1), (0, 1, 0, -1), (1, 0, -1, 0), (0, -1, 0, 1)))
FUNCTIONS: dict[str, Any] = {"exp": (EXP, EXP), "sin": (SIN, COS), "cos": (COS, NEG), "abs": (abs, abs),  # value, slope
    "inverse": (lambda m: ONE**2 // m, lambda m: -(ONE**3 // m**2)),  # at m, wrong by less than 2 units each
    "sqrt": (lambda m: math.isqrt(max(m, 0) << BITS), lambda m: math.isqrt(ONE**3 // (4 * m)))}  # 0 for negative m
def applied(name: str, a: list[int]) -> Any:  # f(x) = f(m) + s (x - m) + rest; m is the middle of the range
    (low, high), (value, slope), m = ends(a), FUNCTIONS[name], a[0]
    need(m > 0 if name == "sqrt" else name != "inverse" or low > 0 or high < 0, f"{name} of a set that holds 0")
    f, s, r = value(m), (abs(high) - abs(low)) * ONE // max(high - low, 1) if name == "abs" else slope(m), high - m
    # exp, sqrt, 1/x are convex or concave: the rest is 0 at m, largest at an end. |x| and the root bend at 0.
    rest = [0, *(value(x) - f - (s * (x - m) >> BITS) for x in (low, min(max(low, 0), high), high))]
    if name in ("sin", "cos"): rest = [-(r * r >> BITS) // 2 - 1, (r * r >> BITS) // 2 + 1]  # |f''| <= 1
    return total((times([0, *a[1:]], [s, 0]), [f, 9 + (r >> (BITS - 1))], between(min(rest), max(rest))))
def looked_up(knots: Any, values: Any, point: Any) -> int:  # linear in each input between knots, wrong by 1 for each
    if not knots: return int(values)
    k, x = knots[0], min(max(point[0], knots[0][0]), knots[0][-1])
    i = max(j for j in range(len(k) - 1) if k[j] <= x)
    first, last = (looked_up(knots[1:], values[j], point[1:]) for j in (i, i + 1))
    return int(first + (last - first) * (x - k[i]) // (k[i + 1] - k[i]))
def table_of(data: Any) -> Any:
    knots, values = number(data["knots"]), number(data["values"])
    need(all(len(k) > 1 and all(a < b for a, b in pairwise(k)) for k in knots), "falling knots")
    return knots, values
def tabulated(table: Any, inputs: Any, hint: Any) -> Any:  # a plane plus an error
    (knots, values), (slopes, shears), (low, high), rest = table, hint, ends(inputs[0]), []
    plane = total(times([0, *y[1:]], [s, 0]) for s, y in zip(slopes, inputs, strict=True))
    cuts = [low, *sorted({low + (high - low) * i // SLABS for i in range(SLABS)} | {*knots[0]}), high]
    bounds: Any = [[(s, *ends(minus(y, times(inputs[0], [s, 0])))) for s in (0, *shears)] for y in inputs[1:]]
    for a, b in pairwise(x for x in cuts if low <= x <= high):  # in each slab of the first input x, another input y
        axes = [[a, b]]                                         # lies in s x + (y - s x), for each shear s
        for k, bound in zip(knots[1:], bounds, strict=True):
            least = max(y + (min(s * a, s * b) >> BITS) for s, y, _ in bound)
            most = min(y + (max(s * a, s * b) >> BITS) + 1 for s, _, y in bound)
            axes.append([least, most, *(y for y in k if least < y < most)] if least <= most else [])
        work = 20 * sum(len(k) << i for i, k in enumerate(knots)) * (1 + math.prod(map(len, axes)))
        need(True, "", work + 40 * len(shears) * len(knots))
        for p in product(*axes):  # between knots the table less the plane is linear in each input: extreme at corners
            rest.append(looked_up(knots, values, p) - sum(s * (x - y[0]) >> BITS for s, x, y in zip(slopes, p, inputs)))
    return add(plane, between(min(rest) - 3 * len(knots), max(rest) + 3 * len(knots)))
def columns_of(rows: Any, p: int) -> Any:  # by symbol, those of p params first, then one for each error
    wide = [*zip_longest(*([*a[2:], *[0] * (p + 2 - len(a))] for a in rows), fillvalue=0)]
    return [*wide, *([a[1] * (i == j) for j, a in enumerate(rows)] for i in range(len(rows)))]
def cover(columns: Any, basis: Any, inverse: Any, slack: Any, text: str) -> None:  # columns, each times [-1, 1], sum to
    need(True, "", len(columns) * (len(basis) + len(inverse)) * len(slack))
    y = [[sum(map(int.__mul__, row, g)) >> BITS for row in inverse] for g in columns]  # basis y + rest, for any inverse
    back = [[sum(map(int.__mul__, row, z)) >> BITS for row in basis] for z in y]
    need(all(sum(map(abs, part)) <= ONE for part in zip(*y)), text)  # |y| <= 1
    need(all(sum(abs(g[i] - b[i]) + 1 for g, b in zip(columns, back)) <= s for i, s in enumerate(slack)), text)
def hull(a: Any) -> list[int]: return between(*ends(a))  # an interval
def chords(table: Any, xs: Any, ys: Any) -> Any:  # intervals of slopes s with f(x) - f(y) = the sum of s (x - y), all x
    (knots, values), results = table, []          # and y in two boxes: one input after the other goes from y to x
    inner = [[(low, *(z for z in k if low < z < high), high) for k, (low, high) in zip(knots, map(ends, box))]
             for box in (xs, ys)]  # the ends of a side, and the knots between: along an input f is linear from z to z
    for i, k in enumerate(knots):
        need(True, "", len(inner[0][i]) * len(inner[1][i]) * len(k) + sum(map(len, knots)))
        pairs = {(x, y) for x in inner[0][i] for y in inner[1][i] if any(min(x, y) < z < max(x, y) for z in k)}
        least, most = inner[1][i][0], inner[1][i][-1]  # slopes of chords are monotone in both ends but for those within
        pairs |= {(b, a) for a, b in pairwise(k) if a <= most and least <= b}  # the cells that y meets, which count too
        beside = [*inner[1][:i], *inner[0][i + 1:]]  # other inputs: at corners, as slopes are linear in each
        need(True, "", 9 * (len(pairs) + 1) * math.prod(map(len, beside)) << len(knots))
        slopes = [(0, 0)] if least <= k[0] or most >= k[-1] else []  # and beyond the knots
        for p, (a, b) in product(product(*beside), pairs):
            rise = looked_up(knots, values, (*p[:i], a, *p[i:])) - looked_up(knots, values, (*p[:i], b, *p[i:]))
            slopes.append(((rise << BITS) // (a - b), (2 * len(knots) << BITS) // abs(a - b) + 2))
        results.append(between(min(s - e for s, e in slopes), max(s + e for s, e in slopes)))
    return results
def unit(n: int) -> Any: return [[[ONE * (i == j), 0] for j in range(n)] for i in range(n)]
def exact(rows: Any) -> Any: return [[[x, 0] for x in row] for row in rows]
def multiplied(a: Any, b: Any) -> Any:  # matrices of intervals
    need(all(len(row) == len(b) for row in a), "matrices do not fit", 9 * len(a) * len(b) * len(b[0]))
    return [[total(map(times, row, column)) for column in zip(*b, strict=True)] for row in a]
def largest(a: Any) -> Any: return max(sum(max(map(abs, ends(x))) for x in row) for row in a)  # no vector grows by more
def length(a: Any) -> int: return math.isqrt(sum(max(map(abs, ends(x))) ** 2 for x in a)) + 1  # of a vector, at most
def evolved(a: Any, step: int) -> Any:  # all d(step) with d' = A d, from unit vectors; rows of A may change with time
    term, result, rest, k = unit(len(a)), unit(len(a)), ONE, 0  # the series of Peano and Baker: its integrals are means
    while largest(a) * step >> BITS > k * ONE // 2 or rest > 1 << (BITS // 2):  # of products of A
        k += 1
        need(k < 64, "a step is too long for its slopes")
        term = [[times(x, [step // k, 1]) for x in row] for row in multiplied(a, term)]
        result, rest = [[add(*pair) for pair in zip(*rows)] for rows in zip(result, term)], largest(term)
    return [[add(x, [0, rest]) for x in row] for row in result]  # each further term is at most half of the one before
def least_stretch(inverse: Any, basis: Any) -> Any:  # s > 0 with |inverse basis y| >= s |y| for all y
    need(all(len(row) == len(basis) == len(inverse) for row in (*basis, *inverse)), "no squares", 9 * len(basis) ** 3)
    pairs = [[sum(map(int.__mul__, row, column)) for column in zip(*basis)] for row in inverse]
    rest = [[(x - ONE**2 * (i == j)) >> BITS, 1] for i, row in enumerate(pairs) for j, x in enumerate(row)]
    need(length(rest) < ONE, "the inverse of a form is wrong")
    return ONE - length(rest)
def shrinks(matrix: Any, limit: int) -> bool:  # whether all matrices of intervals have a 2-norm below the limit
    n, before = range(len(matrix)), 1          # that of the radii is at most the root of the sum of their squares
    q = limit - math.isqrt(sum(a[1] ** 2 for row in matrix for a in row)) - 1
    need(True, "", 9 * len(matrix) ** 4)
    gram = [[q * q * (i == j) - sum(row[i][0] * row[j][0] for row in matrix) for j in n] for i in n]
    for k in n:  # Sylvester: q^2 - M' M is positive definite if its leading minors are; these are Bareiss' pivots
        if q <= 0 or gram[k][k] <= 0: return False
        for i, j in product(n[k + 1:], n[k + 1:]):
            gram[i][j] = (gram[i][j] * gram[k][k] - gram[i][k] * gram[k][j]) // before
        before = gram[k][k]
    return True
def ball_box(centre: Any, basis: Any, radius: int, stretch: int, params: int) -> Any:  # a box that holds a ball
    reach = ((math.isqrt(sum(x * x for x in row)) + 1) * radius // stretch + 2 for row in basis)
    return [[c, 0, *[0] * (params + i), e] for i, (c, e) in enumerate(zip(centre, reach))]
def at_ends(slopes: Any) -> Any:  # slopes of a node, those of some width at both ends, in all combinations
    wide = [[[a[0] - a[1], 0], [a[0] + a[1], 0]] if a[1] >> (BITS // 2) else [a] for _, a in slopes]
    return [[(j, a) for (j, _), a in zip(slopes, corner)] for corner in product(*wide)]
