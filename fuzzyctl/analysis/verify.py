"""Check a certificate of `fuzzyctl prove`: python verify.py FILE.json. It needs Python alone and searches for nothing.
Numbers are whole multiples of a unit, 2^-96. A form [c, r, g1, ..., gm] is the set of c + r e + g1 e1 + ... + gm em for
all e, e1, ..., em in [-1, 1]; forms share e1, ..., em. Operations round outward: r grows by the units that shifts drop.
docs/explanation/proofs.md, "Certificates", walks through this file."""
import json, math, sys
from functools import cache, partial, reduce
from itertools import pairwise, product, zip_longest
from typing import Any
BITS, SLABS, ONE, MINUS = 96, 12, 1 << 96, [-1 << 96, 0]  # binary digits after the point; slabs of a table; 1; -1
WORK = [0, 10**9]  # the work so far, and the most that a file may cause
def need(condition: Any, text: str, work: int = 0) -> Any:  # all that is checked is checked here; returns nothing
    WORK[0] += work
    if not condition or WORK[0] > WORK[1]: raise AssertionError("too much work" if condition else text)
def say(line: str) -> None: print(line) if line.isprintable() else need(False, "a text has control characters")
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
def add(a: Any, b: Any) -> Any: return need(True, "", len(a + b)) or [x + y for x, y in zip_longest(a, b, fillvalue=0)]
def minus(a: Any, b: Any) -> Any: return add(a, times(b, MINUS))
def total(forms: Any) -> list[int]: return reduce(add, forms, [0, 0])
def times(a: list[int], b: list[int]) -> list[int]:  # e e lies in [0, 1] = 1/2 + [-1/2, 1/2], e f in [-1, 1]
    if not (any(a) and any(b)): return [0, 0]
    both, ra, rb = [x * y for x, y in zip(a[2:], b[2:])], sum(map(abs, a[1:])), sum(map(abs, b[1:]))
    r = abs(a[0]) * b[1] + abs(b[0]) * a[1] + ra * rb - sum(map(abs, both)) // 2
    g = [(a[0] * y + b[0] * x) >> BITS for x, y in zip_longest(a[2:], b[2:], fillvalue=0)]
    need(abs(a[0]) + ra + abs(b[0]) + rb < ONE << 200, "numbers become too large", 40 + 8 * len(g))
    return [(2 * a[0] * b[0] + sum(both)) >> (BITS + 1), (r >> BITS) + len(g) + 3, *g]  # each shift drops below a unit
def wave(signs: tuple[int, ...], x: int) -> int:  # the sum of signs[n % 4] x^n / n!, wrong by less than a unit
    need(abs(x) < 16 * ONE, "the argument of sin, cos or exp is beyond 16", 400)
    x, term, result = x << 64, 1 << (BITS + 64), 0  # 64 further digits; after 160 terms less than 2^-200 is left
    for n in range(160): result, term = result + signs[n % 4] * term, term * x // ((n + 1) << (BITS + 64))
    return result >> 64
EXP, SIN, COS, NEG = (partial(wave, s) for s in ((1, 1, 1, 1), (0, 1, 0, -1), (1, 0, -1, 0), (0, -1, 0, 1)))
FUNCTIONS: dict[str, Any] = {"exp": (EXP, EXP), "sin": (SIN, COS), "cos": (COS, NEG), "abs": (abs, abs),  # value, slope
    "inverse": (lambda m: ONE**2 // m, lambda m: -(ONE**3 // m**2)),  # at m, wrong by less than 2 units each
    "sqrt": (lambda m: math.isqrt(max(m, 0) << BITS), lambda m: math.isqrt(ONE**3 // (4 * m)))}  # 0 for negative m
def applied(name: str, a: list[int]) -> list[int]:  # f(x) = f(m) + s (x - m) + rest; m is the middle of the range
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
def tabulated(table: Any, inputs: Any, hint: Any) -> Any:  # a plane plus an error
    (knots, values), (slopes, shears), (low, high), rest = table, hint, ends(inputs[0]), []
    cuts = [low, *sorted({low + (high - low) * i // SLABS for i in range(SLABS)} | {*knots[0]}), high]
    bounds: Any = [[(s, *ends(minus(y, times(inputs[0], [s, 0])))) for s in (0, *shears)] for y in inputs[1:]]
    for a, b in pairwise(x for x in cuts if low <= x <= high):  # in each slab of the first input x, another input y
        axes = [[a, b]]                                         # lies in s x + (y - s x), for each shear s
        for k, bound in zip(knots[1:], bounds, strict=True):
            least = max(y + (min(s * a, s * b) >> BITS) for s, y, _ in bound)
            most = min(y + (max(s * a, s * b) >> BITS) + 1 for s, _, y in bound)
            axes.append([least, most, *(y for y in k if least < y < most)] if least <= most else [])
        need(True, "", 20 * sum(len(k) << i for i, k in enumerate(knots)) * (1 + math.prod(map(len, axes))))
        for p in product(*axes):  # between knots the table less the plane is linear in each input: extreme at corners
            rest.append(looked_up(knots, values, p) - sum(s * (x - y[0]) >> BITS for s, x, y in zip(slopes, p, inputs)))
    plane = total(times([0, *y[1:]], [s, 0]) for s, y in zip(slopes, inputs, strict=True))
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
def keyed(**rows: Any) -> Any: return {(kind, i): a for kind, forms in rows.items() for i, a in enumerate(forms)}
class Loop:  # x' = rates(x, held, memory); every period held = values(x, memory), memory = next(x, memory)
    def __init__(self, data: Any) -> None:
        self.nodes, self.rates, self.values, self.next = (data[k] for k in ("nodes", "rates", "held", "next"))
        self.tables: Any = [(number(t["knots"]), number(t["values"])) for t in data["tables"]]
        need(all(len(k) > 1 and all(a < b for a, b in pairwise(k)) for t in self.tables for k in t[0]), "falling knots")
        need(all(self.nodes[i] == ["state", i] for i in range(len(self.rates))), "the first nodes are not the states")
        self.period, self.params = number(data["period"]), len(data["params"])
        self.claims = [(t, c, hinted(a), math.inf if b is None else -hinted(-b)) for t, c, a, b in data["claims"]]
        need(self.period > 0 and self.claims, "no period, or no claims")
        need(all(c and t.isprintable() and max(a, 0) <= b for t, c, a, b in self.claims), "an unreadable, empty claim")
        self.noise = [enclosed(*pair) for pair in data["disturbances"]]
    def series(self, inputs: Any, seeds: Any = None, hints: Any = ()) -> Any:  # Taylor coefficients in time, of node i
        @cache
        def v(i: int, k: int = 0) -> Any:
            op, *rest = self.nodes[i]
            need(not k or op not in ("error", "table", "abs"), f"the derivative of {op} is not known", 100)
            if op == "+": return add(v(rest[0], k), v(rest[1], k))
            if op == "*": return folded(rest[0], rest[1], k, range(k + 1))
            if op == "const": return [0, 0] if k else enclosed(*rest, *rest)
            if op == "error": return [0, sum(enclosed(0, *rest))]
            if op == "table": return tabulated(self.tables[rest[0]], [v(j) for j in rest[1:]], hinted(hints[str(i)]))
            if op in FUNCTIONS and not k: return applied(op, v(rest[0]))
            if op in ("exp", "sin", "cos"):  # y' = slope x', so that k y[k] = sum of j x[j] slope[k - j]
                need(self.nodes[rest[1]] == [{"sin": "cos", "cos": "sin"}.get(op, op), rest[0], i], "a wrong slope")
                terms = ([x * j for x in times(v(rest[0], j), v(rest[1], k - j))] for j in range(1, k + 1))
                return times(total(terms), [(-ONE if op == "cos" else ONE) // k, 1])
            if op == "inverse": return times(times(v(i), MINUS), folded(rest[0], i, k, range(1, k + 1)))  # x y = 1
            if op == "sqrt":  # y y = x, so that 2 y[0] y[k] = x[k] - the sum of y[j] y[k - j]
                return times(minus(v(rest[0], k), folded(i, i, k, range(1, k))), applied("inverse", add(v(i), v(i))))
            if k and seeds is not None: return seeds.get((op, *rest), [0, 0])  # a derivative by inputs, not by time
            if op == "state" and k: return times(v(self.rates[rest[0]], k - 1), [ONE // k, 1])  # x' = rate
            return [ONE if (op, k) == ("time", 1) else 0, 0] if k else inputs[op, *rest]
        def folded(a: int, b: int, k: int, js: Any) -> list[int]: return total(times(v(a, j), v(b, k - j)) for j in js)
        return v
    def advance(self, inputs: Any, x: Any, begin: int, step: int, hint: Any) -> Any:  # states at the end and over it
        tube, n, order = [between(a, b) for a, b in hinted(hint["tube"])], range(len(x)), range(65).index(hint["order"])
        span = inputs | keyed(state=tube) | {("time",): between(begin, begin + step)}
        start = inputs | keyed(state=x, disturbance=[[w[0], 0] for w in self.noise]) | {("time",): [begin, 0]}
        whole, v, results, where = self.series(span), self.series(start), [], f"from t = {begin / ONE:.9g} s on"
        for i in n:  # Picard: solutions stay in the tube, as x + [0, step] rates(tube) does
            (low, high), (slow, fast), (least, most) = ends(x[i]), ends(whole(self.rates[i])), ends(tube[i])
            low, high = low + min(0, slow * step >> BITS), high + max(0, (fast * step >> BITS) + 1)
            need(least <= low and high <= most, f"the tube of state {i} does not hold all {where}")
        time = [step >> 1, *[0] * (max(map(len, start.values())) - 1), step - (step >> 1)]
        for at in ([step, 0], time):  # x + x[1] t + ... + x[order] t^order + the rest of the tube t^(order + 1)
            rows = [between(*ends(whole(i, order + 1))) for i in n]
            for k in range(order, -1, -1): rows = [add(times(rows[i], at), v(i, k)) for i in n]
            results.append(rows)
        if self.noise:  # moves solutions by y, |y|' <= M |y| + b: |y| <= apart if step (M apart + b) < apart (Gronwall)
            spread = keyed(state=(apart := hinted(hint["apart"])), disturbance=[w[1] for w in self.noise])
            slopes = [(self.series(span, {key: [ONE, 0]}), s) for key, s in spread.items()]
            for r, a in zip(self.rates, apart, strict=True):
                moved = sum((max(map(abs, ends(slope(r, 1)))) * s >> BITS) + 1 for slope, s in slopes)
                need(0 <= moved * step >> BITS < a, f"disturbances move a state by more {where}")
            results = [[add(rows[i], [0, apart[i]]) for i in n] for rows in results]
        return *results, add([begin, 0], time)
    def show(self, due: Any, inputs: Any, a: int, b: int) -> None:  # the claims about times from a to b, in periods
        v, WORK[0] = self.series(inputs), WORK[0] + 10 * len(due)
        for text, clauses, _, _ in (c for c in due if a <= c[3] and (b > c[2] or a == b == c[2])):
            holds = all(any(ends(v(i))[0] >= (mark == 1) for i, mark in clause) for clause in clauses)  # 1: above 0
            need(holds, f"'{text:.99}' is not shown from sample {a / ONE:.9g} on")
    def run(self, proof: Any, due: Any, ranges: Any) -> Any:  # claims about all params and starts in some ranges
        if "cut" in proof:  # in two halves
            side, middle = proof["cut"]
            parts = [ranges[side][0], middle], [middle, ranges[side][1]]
            return [self.run(proof["halves"][i], due, [*ranges[:side], parts[i], *ranges[side + 1:]]) for i in (0, 1)]
        p, n, k, still, anchor = self.params, len(self.rates), 0, ["time"] not in self.nodes, None
        need(len(ranges) + len(self.next) + len(self.values) < 1000, "too many states")
        box = [[a[0], 0, *[0] * i, a[1]] for i, a in enumerate(enclosed(*r) for r in ranges)]
        rows, fixed = box[p:], keyed(param=box[:p], disturbance=self.noise)
        for k, hint in enumerate(proof["steps"], 1):
            x, parts, m = rows[:n], hint["parts"], len(hint["parts"])
            need(m or (k == len(proof["steps"]) and all(c[3] < math.inf for c in due)), f"no time passes in period {k}")
            inputs = fixed | keyed(state=x, memory=rows[n:]) | {("time",): [(k - 1) * self.period, 0]}
            v = self.series(inputs, None, hint["tables"])
            inputs |= keyed(held=[v(i) for i in self.values])
            self.show(due, inputs, (k - 1) * ONE, (k - 1) * ONE)
            for j, part in enumerate(parts, (k - 1) * m):
                a, b = j * self.period // m, (j + 1) * self.period // m
                x, over, time = self.advance(inputs, x, a, b - a, part)
                self.show(due, inputs | keyed(state=over) | {("time",): time}, j * ONE // m, -(-(j + 1) * ONE // m))
            rows, slack = [*x, *(v(i) for i in self.next)], [0] * len(rows)
            columns = columns_of(rows, p)  # each error is a new symbol
            need(len(columns) * len(self.nodes) < 10**7, "too many symbols", len(columns) * len(rows) + len(ranges) * m)
            if "set" in hint:  # but for those of the params and some others they lie in a parallelotope and some slack
                (basis, inverse, slack), keep = hinted(hint["set"]), [*range(p), *hint["keep"]]
                cover([c for i, c in enumerate(columns) if i not in keep], basis, inverse, slack, f"set {k} is small")
                columns = [*(columns[i] for i in keep), *zip(*basis, strict=True)]
                if still and "anchor" in hint and not hint["keep"] and k < len(proof["steps"]):
                    anchor = k * ONE, [[a[0], 0, *g[:p]] for a, g in zip(rows, zip(*columns))], basis, inverse, slack
            rows = [[a[0], e, *g] for a, e, g in zip(rows, slack, zip(*columns, strict=True), strict=True)]
        for text, _, begin, end in due:
            need(end <= (k - 1) * ONE or (end == math.inf and anchor and begin <= anchor[0]), f"no end of '{text:.99}'")
        if anchor: self.inside(rows, *anchor[1:])
    def inside(self, rows: Any, earlier: Any, basis: Any, inverse: Any, slack: Any) -> None:  # for all params
        apart = [add(a, [-x for x in b]) for a, b in zip(rows, earlier, strict=True)]  # so it holds all later sets
        columns, text = columns_of(apart, self.params), "the last set does not lie in the earlier one"
        cover([[a[0] for a in apart], *columns], basis, inverse, slack, text)
def check(data: Any) -> None:  # a whole file, and print its claims
    need(data["format"] == "fuzzyctl certificate 1" and data["parts"], "the file has another format, or no parts")
    for part in data["parts"]:
        loop, ranges = Loop(part), [*part["params"], *part["start"]]
        say(f"Loop {part['loop']:.99}, sampled every {part['period']} s. Its operations:")
        for i, node in enumerate(loop.nodes): say(f"  n{i} = {' '.join(map(str, node))}")
        for name, pair in zip(part["names"], ranges, strict=True): say(f"  {name:.99} begins in {pair}")
        for proof in part["proofs"]: loop.run(proof, [loop.claims[i] for i in proof["claims"]], ranges)
        for i, (text, clauses, begin, end) in enumerate(loop.claims):
            need(any(i in proof["claims"] for proof in part["proofs"]), f"'{text:.99}' has no proof")
            facts = (" or ".join(f"n{j} {'>' if mark == 1 else '>='} 0" for j, mark in c) for c in clauses)
            say(f"verified: {text:.99}: {'; '.join(facts)}; from {begin / ONE:.9g} to {end / ONE:.9g} periods")
def main(path: str) -> None:
    try:
        with open(path, "rb") as file: check(json.loads(file.read(1 << 26), parse_constant=lambda x: need(False, x)))
    except AssertionError as error: sys.exit(f"{path}: not verified: {error}")
    except (OSError, ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError) as error:
        sys.exit(f"{path}: not a certificate: {type(error).__name__} {error!s:.300}")
if __name__ == "__main__": main(sys.argv[1])
