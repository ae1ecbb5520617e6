"""Check a certificate of `fuzzyctl prove`: python verify.py FILE.json. It needs Python alone and searches for nothing.

Numbers are whole multiples of a unit, 2^-96. A form [c, r, g1, ..., gm] is the set of all c + r e + g1 e1 + ... + gm em
with e, e1, ..., em in [-1, 1]; forms share e1, ..., em. Operations round outward: r grows by the units that shifts drop.
docs/explanation/proofs.md walks through this file, see "Certificates".
"""
# fmt: off
import json
import math
import sys
from functools import cache, reduce
from itertools import pairwise, product, zip_longest
from typing import Any

BITS, SLABS, WORK = 96, 12, [0, 2 * 10**8]  # digits; slabs of a table; the work so far, and the most that a file may cause
ONE, Form = 1 << BITS, list[int]

def need(condition: bool, text: str) -> None:  # everything that is checked is checked here
    if not condition: raise AssertionError(text)

def number(x: Any) -> Any:  # numbers of the file; those from 2^-43 on are multiples of the unit, smaller ones are cut
    if isinstance(x, list): return [number(y) for y in x]
    need(type(x) in (int, float) and abs(x) < 2**64, f"{x!r:.40} is no number below 2^64")
    return (x.as_integer_ratio()[0] << BITS) // x.as_integer_ratio()[1]

def ends(a: Form) -> tuple[int, int]: return a[0] - sum(map(abs, a[1:])), a[0] + sum(map(abs, a[1:]))

def between(low: int, high: int) -> Form:  # all numbers from one to another
    need(low <= high, "a range is empty")
    return [(low + high) >> 1, high - ((low + high) >> 1)]

def add(a: Form, b: Form) -> Form: return [x + y for x, y in zip_longest(a, b, fillvalue=0)]  # exact

def times(a: Form, b: Form) -> Form:  # squares of symbols lie in [0, 1] = 1/2 + [-1/2, 1/2], other products in [-1, 1]
    if not (any(a) and any(b)): return [0, 0]
    both, ra, rb = [x * y for x, y in zip(a[2:], b[2:])], sum(map(abs, a[1:])), sum(map(abs, b[1:]))
    r = abs(a[0]) * b[1] + abs(b[0]) * a[1] + ra * rb - sum(map(abs, both)) // 2
    g = [(a[0] * y + b[0] * x) >> BITS for x, y in zip_longest(a[2:], b[2:], fillvalue=0)]
    WORK[0] += 20 + len(g)
    need(WORK[0] < WORK[1], "the file causes too much work")
    return [(2 * a[0] * b[0] + sum(both)) >> (BITS + 1), (r >> BITS) + len(g) + 3, *g]  # each shift drops below a unit

def total(forms: Any) -> Form: return reduce(add, forms, [0, 0])

def wave(x: int, signs: tuple[int, ...]) -> int:  # the sum of signs[n % 4] x^n / n!, wrong by less than a unit
    need(abs(x) < 16 * ONE, "the argument of sin, cos or exp is beyond 16")
    x, term, result = x << 64, 1 << (BITS + 64), 0  # 64 further digits; after 160 terms less than 2^-200 is left
    for n in range(160): result, term = result + signs[n % 4] * term, term * x // ((n + 1) << (BITS + 64))
    return result >> 64

EXP, SIN, COS, MINUS = (1, 1, 1, 1), (0, 1, 0, -1), (1, 0, -1, 0), [-ONE, 0]
VALUES: dict[str, Any] = {"exp": lambda m: wave(m, EXP), "sin": lambda m: wave(m, SIN), "cos": lambda m: wave(m, COS),
                          "sqrt": lambda m: math.isqrt(m << BITS), "inverse": lambda m: ONE**2 // m, "abs": abs}
SLOPES: dict[str, Any] = {"exp": VALUES["exp"], "sin": VALUES["cos"], "cos": lambda m: -wave(m, SIN),  # as the values, at
          "sqrt": lambda m: math.isqrt(ONE**3 // (4 * m)), "inverse": lambda m: -(ONE**3 // m**2)}  # m within 2 units

def applied(name: str, a: Form) -> Form:  # f(x) = f(m) + s (x - m) + rest; m is the middle of the range, s the slope there
    (low, high), value, m = ends(a), VALUES[name], a[0]
    low, r = max(low, 0) if name == "sqrt" else low, high - m  # the root of a negative number counts as 0
    need(m > 0 if name == "sqrt" else name != "inverse" or low > 0 or high < 0, f"{name} of a set that holds 0")
    f, s = value(m), (abs(high) - abs(low)) * ONE // max(high - low, 1) if name == "abs" else SLOPES[name](m)
    # exp, sqrt and 1/x are convex or concave: the rest is 0 at m, largest at an end. |x| is straight but for a bend at 0.
    rest = [0, *(value(x) - f - (s * (x - m) >> BITS) for x in (low, min(max(low, 0), high), high))]
    if name in ("sin", "cos"): rest = [-(r * r >> BITS) // 2 - 1, (r * r >> BITS) // 2 + 1]  # |f''| <= 1
    return total((times([0, *a[1:]], [s, 0]), [f, 9 + (r >> (BITS - 1))], between(min(rest), max(rest))))

def looked_up(knots: Any, values: Any, point: Any) -> int:  # linear in each input between knots; wrong by a unit for each
    if not knots: return int(values)
    k, x = knots[0], min(max(point[0], knots[0][0]), knots[0][-1])
    i = max(j for j in range(len(k) - 1) if k[j] <= x)
    first, last = (looked_up(knots[1:], values[j], point[1:]) for j in (i, i + 1))
    return int(first + (last - first) * (x - k[i]) // (k[i + 1] - k[i]))

def tabulated(knots: Any, values: Any, inputs: list[Form], slopes: Form, shears: Form) -> Form:  # a plane plus an error
    (low, high), rest = ends(inputs[0]), []
    cuts = [low, *sorted({low + (high - low) * i // SLABS for i in range(SLABS)} | {*knots[0]}), high]
    bounds = [[(s, *ends(add(y, times(inputs[0], [-s, 0])))) for s in (0, *shears)] for y in inputs[1:]]
    for a, b in pairwise(x for x in cuts if low <= x <= high):  # a slab of the first input; s a, s b and the range of y - s x
        axes = [[a, b]]                                         # bound each other input y in it, for each shear s
        for k, bound in zip(knots[1:], bounds, strict=True):
            least = max(x + (min(s * a, s * b) >> BITS) for s, x, _ in bound)
            most = min(x + (max(s * a, s * b) >> BITS) + 1 for s, _, x in bound)
            axes.append([least, most, *(x for x in k if least < x < most)] if least <= most else [])
        WORK[0] += 99 * math.prod(map(len, axes))
        for p in product(*axes):  # between knots the table less the plane is linear in each input: extreme at corners
            plane = sum(s * (x - y[0]) >> BITS for s, x, y in zip(slopes, p, inputs, strict=True))
            rest.append(looked_up(knots, values, p) - plane)
    error = between(min(rest) - 3 * len(knots), max(rest) + 3 * len(knots))
    return total([error, *(times([0, *y[1:]], [s, 0]) for s, y in zip(slopes, inputs, strict=True))])

def cover(columns: Any, basis: Any, inverse: Any, slack: Any, text: str) -> None:  # sums of columns, each times [-1, 1],
    y = [[sum(map(int.__mul__, row, g)) >> BITS for row in inverse] for g in columns]  # are basis y + rest, by any inverse
    back = [[sum(map(int.__mul__, row, z)) >> BITS for row in basis] for z in y]
    for i, error in enumerate(slack):  # with |y| <= 1 and |rest| <= slack
        need(sum(abs(z[i]) for z in y) <= ONE and sum(abs(g[i] - b[i]) + 1 for g, b in zip(columns, back)) <= error, text)

def dot(a: Any, b: Any) -> Form: return total(times(x, y) for x, y in zip(a, b, strict=True))

def definite(m: Any, text: str) -> None:  # a symmetric matrix of forms is positive definite: its pivots L D L' are above 0
    for k, row in enumerate(m):
        need(ends(row[k])[0] > 0, text)
        for other in m[k + 1:]:
            factor = times(times(other[k], applied("inverse", row[k])), MINUS)
            other[k:] = [add(x, times(factor, y)) for x, y in zip(other[k:], row[k:], strict=True)]

def keyed(**rows: Any) -> dict[Any, Form]: return {(kind, i): a for kind, forms in rows.items() for i, a in enumerate(forms)}

class Loop:  # x' = rates(x, held, memory); at multiples of the period held = values(x, memory), memory = next(x, memory)
    def __init__(self, data: Any) -> None:
        self.nodes, self.rates, self.values, self.next = (data[k] for k in ("nodes", "rates", "held", "next"))
        self.tables = [(number(t["knots"]), number(t["values"])) for t in data["tables"]]
        need(all(len(k) > 1 and all(a < b for a, b in pairwise(k)) for t in self.tables for k in t[0]), "knots do not rise")
        need(all(self.nodes[i] == ["state", i] for i in range(len(self.rates))), "the first nodes are not the states")
        self.period, self.claims, self.params = number(data["period"]), data["claims"], len(data["params"])
        self.noise = [between(a, b) for a, b in number(data["disturbances"])]

    def series(self, inputs: Any, seeds: Any = None, hints: Any = ()) -> Any:  # a function: Taylor coefficient k of node i
        @cache
        def v(i: int, k: int = 0) -> Form:
            op, *rest = self.nodes[i]
            if op == "+": return add(v(rest[0], k), v(rest[1], k))
            if op == "*": return folded(*rest, k, range(k + 1))
            if op == "const": return [0 if k else number(*rest), 0]
            if op == "error" and not k: return [0, number(*rest) + 1]
            if op in VALUES and not k: return applied(op, v(rest[0]))
            if op in ("exp", "sin", "cos"):  # y' = slope x', so that k y[k] = sum of j x[j] slope[k - j]
                slope, sign = (i, 1) if op == "exp" else (rest[1], 1 if op == "sin" else -1)
                need(slope == i or self.nodes[slope] == ["cos" if op == "sin" else "sin", rest[0], i], "a wrong slope")
                terms = ([x * j for x in times(v(rest[0], j), v(slope, k - j))] for j in range(1, k + 1))
                return times(total(terms), [sign * ONE // k, 1])
            if op == "inverse": return times(times(v(i), MINUS), folded(rest[0], i, k, range(1, k + 1)))  # x y = 1
            if op == "sqrt":  # y y = x
                other = add(v(rest[0], k), times(folded(i, i, k, range(1, k)), MINUS))
                return times(other, applied("inverse", add(v(i), v(i))))
            if op == "abs":
                need(0 not in range(ends(v(rest[0]))[0] + 1, ends(v(rest[0]))[1]), "|x| is not smooth over a set with 0 inside")
                return v(rest[0], k) if v(rest[0])[0] > 0 else times(v(rest[0], k), MINUS)
            if op == "table":
                need(k == 0, "a table is not smooth")
                hint = number(hints[str(i)]) if str(i) in hints else ([0] * len(rest[1:]), [])
                return tabulated(*self.tables[rest[0]], [v(p) for p in rest[1:]], *hint)
            if k and seeds is not None: return seeds.get((op, *rest), [0, 0])  # a derivative by inputs, not by time
            if op == "state" and k: return times(v(self.rates[rest[0]], k - 1), [ONE // k, 1])  # x' = rate
            return [ONE if (op, k) == ("time", 1) else 0, 0] if k else inputs[op, *rest]

        def folded(a: int, b: int, k: int, js: range) -> Form: return total(times(v(a, j), v(b, k - j)) for j in js)
        return v

    def advance(self, inputs: Any, x: list[Form], begin: int, step: int, hint: Any) -> Any:  # the states at the end, over all
        tube, n, order = [between(a, b) for a, b in number(hint["tube"])], range(len(x)), hint["order"]
        span = inputs | keyed(state=tube) | {("time",): between(begin, begin + step)}
        own = inputs | keyed(state=x, disturbance=[[w[0], 0] for w in self.noise]) | {("time",): [begin, 0]}
        whole, v, results, where = self.series(span), self.series(own), [], f"from t = {begin / ONE:.9g} s on"
        need(order in range(9), "an order is not from 0 to 8")
        for i in n:  # Picard: solutions stay in the tube, as x + [0, step] rates(tube) does
            (low, high), (slow, fast), (least, most) = ends(x[i]), ends(whole(self.rates[i])), ends(tube[i])
            inside = least <= low + min(0, slow * step >> BITS) and high + max(0, (fast * step >> BITS) + 1) <= most
            need(inside, f"the tube of state {i} does not hold its solutions {where}")
        time = [step >> 1, 0, *[0] * (max(map(len, own.values())) - 2), step - (step >> 1)]
        for at in ([step, 0], time):  # x + x[1] t + ... + x[order] t^order + rest t^(order + 1), the rest that of the tube
            rows = [between(*ends(whole(i, order + 1))) for i in n]
            for k in range(order, -1, -1): rows = [add(times(rows[i], at), v(i, k)) for i in n]
            results.append(rows)
        if self.noise:  # they move a solution by y, |y|' <= M |y| + b: |y| <= apart if step (M apart + b) <= apart (Gronwall)
            apart, moved = number(hint["apart"]), [0] * len(x)
            for key, spread in keyed(state=apart, disturbance=[w[1] for w in self.noise]).items():
                slopes = self.series(span, {key: [ONE, 0]})
                moved = [moved[i] + (max(map(abs, ends(slopes(self.rates[i], 1)))) * spread >> BITS) + 1 for i in n]
            need(all((moved[i] * step >> BITS) + 1 <= apart[i] for i in n), f"disturbances move a state further {where}")
            results = [[add(rows[i], [0, apart[i]]) for i in n] for rows in results]
        return *results, add([begin, 0], time)

    def show(self, due: Any, inputs: Any, first: int, last: int, parts: int) -> None:  # claims from first to last / parts
        v, a, b = self.series(inputs), first * ONE, last * ONE
        for text, clauses, begin, end in due:  # each clause is a list of nodes, one of which is >= 0, or > 0
            if a <= end * parts and (b > begin * parts or a == b == begin * parts):
                holds = all(any(ends(v(i))[0] >= strict for i, strict in clause) for clause in clauses)
                need(holds, f"'{text:.99}' is not shown from sample {first / parts:.9g} on")

    def run(self, proof: Any, ranges: Any) -> None:  # check that claims hold for all members in ranges of params and states
        if "cut" in proof:  # of both halves
            (side, value), (low, high) = proof["cut"], ranges[proof["cut"][0]]
            for half, part in zip(([low, value], [value, high]), proof["halves"], strict=True):
                self.run({"claims": proof["claims"], **part}, [*ranges[:side], half, *ranges[side + 1:]])
            return
        p, n, anchor, box = self.params, len(self.rates), None, [between(a, b) for a, b in number(ranges)]
        box = [[a[0], 0, *[0] * i, a[1]] for i, a in enumerate(box)]  # a symbol for each number
        claims = [(c["text"], c["clauses"], number(c["from"]), math.inf if c["until"] is None else number(c["until"]))
                  for c in (self.claims[i] for i in proof["claims"])]
        rows, fixed = box[p:], keyed(param=box[:p], disturbance=self.noise)
        for k, hint in enumerate(proof["steps"]):
            x, parts, last = rows[:n], hint["parts"], k + 1 == len(proof["steps"])
            need(parts or (last and all(c[3] < math.inf for c in claims)), f"no time passes after sample {k}")
            inputs = fixed | keyed(state=x, memory=rows[n:]) | {("time",): [k * self.period, 0]}
            v = self.series(inputs, None, hint["tables"])
            inputs |= keyed(held=[v(i) for i in self.values])
            self.show(claims, inputs, k, k, 1)
            for j, part in enumerate(parts, k * len(parts)):
                a, b = (i * self.period // len(parts) for i in (j, j + 1))
                x, over, time = self.advance(inputs, x, a, b - a, part)
                self.show(claims, inputs | keyed(state=over) | {("time",): time}, j, j + 1, len(parts))
            rows = [*x, *(v(i) for i in self.next)]
            wide = max(map(len, rows))  # the error of each state becomes a symbol
            rows = [[a[0], 0, *a[2:], *[0] * (wide - len(a) + i), a[1], *[0] * (len(rows) - 1 - i)] for i, a in enumerate(rows)]
            if "set" in hint:  # a parallelotope, wider by some slack, that holds all columns but those of the params
                basis, inverse, slack = number(hint["set"])
                cover([*zip(*(a[2 + p:] for a in rows))], basis, inverse, slack, f"the set at sample {k + 1} does not hold all")
                rows = [[a[0], e, *a[2: 2 + p], *row] for a, e, row in zip(rows, slack, basis, strict=True)]
                if hint.get("anchor"): anchor = k + 1, rows, basis, inverse, slack
        for text, _, begin, end in claims:
            if end < math.inf: need(end <= k * ONE, f"the steps end before '{text:.99}' does")
            else: need(anchor and begin <= anchor[0] * ONE and ["time"] not in self.nodes, f"'{text:.99}' is not for all time")
        if anchor:  # for each value of the params the last set lies in the earlier one, which thus holds all later ones
            apart = [add(a, [-x for x in b[: 2 + p]]) for a, b in zip(rows, anchor[1], strict=True)]
            cover([*zip(*([a[0], *a[2:]] for a in apart))], *anchor[2:], "the last set does not lie in the earlier one")

def check(data: Any) -> None:  # a whole file; print what it shows
    need(data["format"] == "fuzzyctl certificate 1", "the file is of another kind")
    for part in data["parts"]:
        if part["kind"] == "lyapunov":
            P, *vertices = ([[[x, 0] for x in row] for row in m] for m in number([part["P"], *part["vertices"]]))
            for A in vertices:
                down = [[times(dot(row, column), MINUS) for column in zip(*A)] for row in P]  # -P A
                definite([[add(down[i][j], down[j][i]) for j in range(len(P))] for i in range(len(P))], "it does not fall")
            definite(P, "P is not positive definite")
            print(f"verified: {part['text']:.99}: P and -(A'P + P A) are positive definite for {len(vertices)} matrices A")
            continue
        loop, ranges, names = Loop(part), [*part["params"], *part["start"]], part["names"]
        print(f"Loop {part['loop']:.99}: a controller every {part['period']} s; in operations:")
        for i, node in enumerate(loop.nodes): print(f"  n{i} =", *node)
        for name, (low, high) in zip(names, ranges, strict=True): print(f"  {name:.99} begins in [{low}, {high}]")
        for proof in part["proofs"]: loop.run(proof, ranges)
        for i, c in enumerate(loop.claims):
            need(any(i in proof["claims"] for proof in part["proofs"]), f"'{c['text']:.99}' has no proof")
            print(f"verified: {c['text']:.99}, from sample {c['from']} until {c['until']}: one of each {c['clauses']} >= 0")

def main(path: str) -> int:
    try:
        with open(path, "rb") as file: data = json.loads(file.read(1 << 26), parse_constant=lambda x: need(False, f"{x}?"))
        check(data)
    except AssertionError as error: print(f"not verified: {error}")
    except (OSError, ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError) as error:
        print(f"{path}: no certificate: {type(error).__name__} {error!s:.200}")
    else: return 0
    return 1

if __name__ == "__main__": sys.exit(main(sys.argv[1]))
