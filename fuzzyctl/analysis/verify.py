"""Check a certificate of `fuzzyctl prove`: python verify.py FILE.json. It needs Python alone, and searches for nothing.

Numbers are integers in units of 2^-96. A form [c, r, g1, ..., gm] is the set of c + r e + g1 e1 + ... + gm em for all
e in [-1, 1]; forms share the symbols e1, ..., em. All operations round outward: r grows by the units that shifts drop.
docs/explanation/proofs.md, "Certificates", walks through this file.
"""
# fmt: off
import hashlib
import json
import math
import sys
from itertools import product, zip_longest
from typing import Any

Form = list[int]
BITS, SLABS = 96, 12  # binary digits after the point; slabs into which the inputs of a table are cut
ONE, WORK = 1 << BITS, [0, 2 * 10**8]  # 1; the work so far, and the most that a file may cause

def need(condition: bool, text: str) -> None:  # all that is checked is checked by this function
    if not condition: raise AssertionError(text)

def number(x: Any) -> Form:  # a number of the file as a form; r = 1 if it is no multiple of the unit
    need(type(x) in (int, float) and abs(x) < 2**64, f"{x!r:.40} is no number below 2^64")
    n, d = x.as_integer_ratio()
    return [(n << BITS) // d, int((n << BITS) % d > 0)]

def ends(a: Form) -> tuple[int, int]: return a[0] - sum(map(abs, a[1:])), a[0] + sum(map(abs, a[1:]))

def between(low: int, high: int) -> Form:  # all numbers from one to another
    need(low <= high, "a range is empty")
    return [(low + high) >> 1, high - ((low + high) >> 1)]

def add(a: Form, b: Form) -> Form: return [x + y for x, y in zip_longest(a, b, fillvalue=0)]  # exact

def times(a: Form, b: Form) -> Form:  # squares of symbols lie in [0, 1] = 1/2 + [-1/2, 1/2], other products in [-1, 1]
    if not (any(a) and any(b)): return [0, 0]
    both, ra, rb = [x * y for x, y in zip(a[2:], b[2:])], sum(map(abs, a[1:])), sum(map(abs, b[1:]))  # noqa: B905
    r = abs(a[0]) * b[1] + abs(b[0]) * a[1] + ra * rb - sum(map(abs, both)) // 2
    g = [(a[0] * y + b[0] * x) >> BITS for x, y in zip_longest(a[2:], b[2:], fillvalue=0)]
    WORK[0] += 20 + len(g)
    need(WORK[0] < WORK[1], "the file causes too much work")
    return [(2 * a[0] * b[0] + sum(both)) >> (BITS + 1), (r >> BITS) + len(g) + 3, *g]  # each shift drops below 1 unit

def minus(a: Form, b: Form) -> Form: return add(a, times(b, [-ONE, 0]))

def wave(x: int, signs: tuple[int, ...]) -> int:  # the sum of signs[n % 4] x^n / n!, wrong by less than a unit
    need(abs(x) < 16 * ONE, "the argument of sin, cos or exp is beyond 16")
    x, term, total = x << 64, 1 << (BITS + 64), 0  # 64 further digits; after 160 terms less than 2^-200 is left
    for n in range(160): total, term = total + signs[n % 4] * term, term * x // ((n + 1) << (BITS + 64))
    return total >> 64

E, SIN, COS = (1, 1, 1, 1), (0, 1, 0, -1), (1, 0, -1, 0)
FUNCTIONS: dict[str, Any] = {  # at a point m: the value and the slope, both wrong by less than 2 units
    "exp": (lambda m: wave(m, E), lambda m, low, high: wave(m, E)),
    "sin": (lambda m: wave(m, SIN), lambda m, low, high: wave(m, COS)),
    "cos": (lambda m: wave(m, COS), lambda m, low, high: -wave(m, SIN)),
    "sqrt": (lambda m: math.isqrt(m << BITS), lambda m, low, high: math.isqrt(ONE**3 // (4 * m))),
    "inverse": (lambda m: ONE**2 // m, lambda m, low, high: -(ONE**3 // m**2)),
    "abs": (abs, lambda m, low, high: (abs(high) - abs(low)) * ONE // max(high - low, 1)),
}

def applied(name: str, a: Form) -> Form:  # f(x) = f(m) + s (x - m) + rest over the ends of a form, m its middle
    (low, high), (value, slope), m = ends(a), FUNCTIONS[name], a[0]
    low, r = max(low, 0) if name == "sqrt" else low, high - m  # the root of a negative number counts as 0
    need(m > 0 if name == "sqrt" else name != "inverse" or low > 0 or high < 0, f"{name} of a set that holds 0")
    f, s = value(m), slope(m, low, high)
    # exp, sqrt, 1/x are convex or concave: the rest is 0 at m and largest at an end. |x| is straight but for a bend at 0.
    rest = [0, *(value(x) - f - (s * (x - m) >> BITS) for x in (low, min(max(low, 0), high), high))]
    if name in ("sin", "cos"): rest = [-(r * r >> BITS) // 2 - 1, (r * r >> BITS) // 2 + 1]  # |f''| <= 1
    return add(times([0, *a[1:]], [s, 0]), add([f, 9 + (r >> (BITS - 1))], between(min(rest), max(rest))))

def looked_up(knots: Any, values: Any, point: Any) -> int:  # linear in each input between knots; wrong by 1 unit for each
    if not knots: return int(values)
    k, x = knots[0], min(max(point[0], knots[0][0]), knots[0][-1])
    i = max(j for j in range(len(k) - 1) if k[j] <= x)
    first, last = (looked_up(knots[1:], values[j], point[1:]) for j in (i, i + 1))
    return int(first + (last - first) * (x - k[i]) // (k[i + 1] - k[i]))

def corners(knots: Any, inputs: list[Form], shears: Form) -> Any:  # of boxes, cut at knots, that hold the set of the inputs
    low, high = ends(inputs[0])
    cuts = sorted({low, high, *(low + (high - low) * i // SLABS for i in range(SLABS)), *knots[0]})
    bounds = [[(s, *ends(minus(y, times(inputs[0], [s, 0])))) for s in (0, *shears)] for y in inputs[1:]]
    for a, b in zip(cuts, [*cuts[1:], high]):  # noqa: B905
        if not low <= a <= b <= high: continue
        axes = [[a, b]]  # a slab of the first input; in it y = s x + rest bounds each other input y, for all shears s
        for k, bound in zip(knots[1:], bounds, strict=True):
            least = max(rest + (min(s * a, s * b) >> BITS) for s, rest, _ in bound)
            most = min(rest + (max(s * a, s * b) >> BITS) + 1 for s, _, rest in bound)
            axes.append([least, most, *(x for x in k if least < x < most)] if least <= most else [])
        WORK[0] += 99 * math.prod(map(len, axes))
        yield from product(*axes)

def tabulated(knots: Any, values: Any, inputs: list[Form], slopes: Form, shears: Form) -> Form:
    total, rest = [0, 0], []  # a plane, and how far the table is from it: between knots that is multilinear, most at corners
    for p in corners(knots, inputs, shears):
        plane = sum(s * (x - y[0]) >> BITS for s, x, y in zip(slopes, p, inputs, strict=True))
        rest.append(looked_up(knots, values, p) - plane)
    for s, y in zip(slopes, inputs, strict=True): total = add(total, times([0, *y[1:]], [s, 0]))
    return add(total, between(min(rest) - 3 * len(knots), max(rest) + 3 * len(knots)))

def whole(x: Any) -> Any:  # lists of numbers, each a multiple of the unit
    if isinstance(x, list): return [whole(y) for y in x]
    need(number(x)[1] == 0, f"{x!r:.40} is no multiple of 2^-96")
    return number(x)[0]

def rough(x: Any) -> Any: return [rough(y) for y in x] if isinstance(x, list) else number(x)[0]

def cover(columns: Any, basis: Any, inverse: Any, slack: Any, text: str) -> None:
    """Check that each sum of columns, times numbers in [-1, 1], is basis y + rest with |y| <= 1 and |rest| <= slack."""
    y = [[sum(a * b for a, b in zip(row, g, strict=True)) >> BITS for row in inverse] for g in columns]
    back = [[sum(a * b for a, b in zip(row, z, strict=True)) >> BITS for row in basis] for z in y]
    for i, error in enumerate(slack):
        need(sum(abs(z[i]) for z in y) <= ONE, text)
        need(sum(abs(g[i] - b[i]) + 1 for g, b in zip(columns, back, strict=True)) <= error, text)

class Values:
    """Taylor coefficients in time of the nodes of a loop, for given inputs; each is computed once."""

    def __init__(self, loop: "Loop", inputs: Any, seeds: Any = None, hints: Any = ()) -> None:
        self.loop, self.inputs, self.seeds, self.hints, self.known = loop, inputs, seeds, hints, dict[Any, Form]()

    def __call__(self, i: Any, k: int = 0) -> Form:  # that of node i, of order k
        if (i, k) not in self.known: self.known[i, k] = self.computed(i, k, *self.loop.nodes[i])
        return self.known[i, k]

    def folded(self, a: int, b: int, k: int, first: int = 0, last: int = 0, weighted: bool = False) -> Form:
        total = [0, 0]  # the sum of a[j] b[k - j], or of j a[j] b[k - j]
        for j in range(first, k + 1 - last):
            part = times(self(a, j), self(b, k - j))
            total = add(total, [x * j for x in part] if weighted else part)
        return total

    def computed(self, i: int, k: int, op: str, *rest: Any) -> Form:
        if op == "+": return add(self(rest[0], k), self(rest[1], k))
        if op == "*": return self.folded(*rest, k)
        if op == "const": return [0, 0] if k else number(*rest)
        if op in FUNCTIONS and k == 0: return applied(op, self(rest[0]))
        if op in ("exp", "sin", "cos"):  # y' = slope x' with the node of the slope: k y[k] = sum of j x[j] slope[k - j]
            slope, sign = (i, 1) if op == "exp" else (rest[1], 1 if op == "sin" else -1)
            need(op == "exp" or self.loop.nodes[slope][:2] == [{"sin": "cos", "cos": "sin"}[op], rest[0]], "a wrong slope")
            return times(self.folded(rest[0], slope, k, 1, 0, True), [sign * ONE // k, 1])
        if op == "inverse": return times(self(i), times(self.folded(rest[0], i, k, 1), [-ONE, 0]))  # x y = 1
        if op == "sqrt": return times(minus(self(rest[0], k), self.folded(i, i, k, 1, 1)), applied("inverse", add(self(i), self(i))))
        if op == "abs":
            low, high = ends(self(rest[0]))
            need(low >= 0 or high <= 0, "an absolute value is not smooth over the set")
            return times(self(rest[0], k), [ONE if low >= 0 else -ONE, 0])
        if op == "error" and not k: return [0, number(*rest)[0] + 1]
        if op == "table" and not k:
            slopes, shears = self.hints[str(i)] if str(i) in self.hints else ([0] * len(rest[1:]), [])
            numbers = [[number(x)[0] for x in numbers] for numbers in (slopes, shears)]
            return tabulated(*self.loop.tables[rest[0]], [self(p) for p in rest[1:]], *numbers)
        if k and self.seeds is not None: return self.seeds.get((op, *rest), [0, 0])  # derivatives along a direction
        if op == "state" and k: return times(self(self.loop.rates[rest[0]], k - 1), [ONE // k, 1])  # x' = rate
        need(not k or op in ("time", "memory", "held", "param", "disturbance"), f"{op} is not smooth over the set")
        return [ONE if (op, k) == ("time", 1) else 0, 0] if k else self.inputs[op, *rest]

def truth(condition: Any, values: Values) -> bool:  # whether it holds for all that the values may be
    op, *parts = condition
    if op in (">", ">="): return ends(values(parts[0]))[0] >= (op == ">")
    need(op in ("and", "or"), f"{op!r:.40} is no condition")
    return (all if op == "and" else any)([truth(c, values) for c in parts])

class Loop:
    """x' = rates(x, memory, held, ...); at each multiple of the period held = values(x, memory), memory = next(...)."""

    def __init__(self, data: Any) -> None:
        self.nodes, self.rates, self.values, self.next = (data[k] for k in ("nodes", "rates", "held", "next"))
        self.tables = [whole([t["knots"], t["values"]]) for t in data["tables"]]
        rising = all(len(k) > 1 and all(a < b for a, b in zip(k, k[1:])) for t in self.tables for k in t[0])  # noqa: B905
        self.period, self.claims, self.params = whole(data["period"]), data["claims"], len(data["params"])
        need(rising and self.period > 0, "the knots of a table do not rise, or the period is not above 0")
        self.noise = [between(number(a)[0], number(b)[0] + 1) for a, b in data["disturbances"]]

    def advance(self, inputs: Any, x: list[Form], begin: int, step: int, hint: Any) -> Any:
        """Return the states at the end of a step and over it, and the times of the step."""
        tube = {("state", i): between(number(a)[0], number(b)[0]) for i, (a, b) in enumerate(hint["tube"])}
        over_tube, own = Values(self, inputs | tube | {("time",): between(begin, begin + step)}), Values(self, inputs | {
            ("time",): [begin, 0], **{("state", i): a for i, a in enumerate(x)},
            **{("disturbance", i): [w[0], 0] for i, w in enumerate(self.noise)}})
        for i, r in enumerate(self.rates):  # Picard: solutions stay in the tube, as x + [0, step] rates(tube) does
            (low, high), (slow, fast), (least, most) = ends(x[i]), ends(over_tube(r)), ends(tube["state", i])
            held = least <= low + min(0, slow * step >> BITS) and high + max(0, (fast * step >> BITS) + 1) <= most
            need(held, f"the tube of state {i} from t = {begin / ONE:.9g} s on does not hold its solutions")
        order, symbols = hint["order"], max(map(len, own.inputs.values()))
        need(order in range(9), "the order is not from 0 to 8")
        time, end, over = [step >> 1, 0, *[0] * (symbols - 2), step - (step >> 1)], [], []
        for i in range(len(x)):  # x + x[1] t + ... + x[order] t^order + rest t^(order + 1), rest that over the tube
            for results, at in ((end, [step, 0]), (over, time)):
                total = between(*ends(over_tube.computed(0, order + 1, "state", i)))
                for k in range(order, -1, -1): total = add(times(total, at), own.computed(0, k, "state", i))
                results.append(total)
        if not self.noise: return end, over, add([begin, 0], time)
        # A disturbance moves a solution by y, |y|' <= M |y| + b: |y| <= apart if step (M apart + b) <= apart (Gronwall).
        apart, moved = [number(a)[0] for a in hint["apart"]], [0] * len(x)
        sizes = {("state", j): a for j, a in enumerate(apart)} | {("disturbance", j): w[1] for j, w in enumerate(self.noise)}
        for key, size in sizes.items():
            slope = Values(self, over_tube.inputs, {key: [ONE, 0]})
            moved = [m + (max(map(abs, ends(slope(r, 1)))) * size >> BITS) + 1 for m, r in zip(moved, self.rates, strict=True)]
        need(all((m * step >> BITS) + 1 <= a for m, a in zip(moved, apart, strict=True)), "a disturbance moves a state further")
        end, over = ([add(a, [0, d]) for a, d in zip(rows, apart, strict=True)] for rows in (end, over))
        return end, over, add([begin, 0], time)

    def show(self, due: Any, inputs: Any, first: int, last: int, parts: int) -> None:  # claims from first to last / parts
        for c in due:
            begin, end = number(c["from"])[0] * parts, math.inf if c["until"] is None else sum(number(c["until"])) * parts
            if (last * ONE > begin or first == last and first * ONE >= begin) and first * ONE <= end:
                need(truth(c["condition"], Values(self, inputs)), f"'{c['text']}' is not shown at sample {first / parts:.9g}")

    def run(self, proof: Any, ranges: Any) -> None:
        """Check that the claims of a proof hold for all members in some ranges: of the params, then of the states."""
        if "cut" in proof:  # both halves
            (side, value), (low, high) = proof["cut"], ranges[proof["cut"][0]]
            for half, part in zip(([low, value], [value, high]), proof["halves"], strict=True):
                self.run({"claims": proof["claims"], **part}, [*ranges[:side], half, *ranges[side + 1:]])
            return
        box = [between(number(low)[0], number(high)[0] + 1) for low, high in ranges]
        box = [[a[0], 0, *[0] * i, a[1]] for i, a in enumerate(box)]  # a symbol for each
        p, n, due, anchor = self.params, len(self.rates), [self.claims[c] for c in proof["claims"]], None
        fixed, rows = {("param", i): a for i, a in enumerate(box[:p])}, box[p:]
        fixed |= {("disturbance", i): w for i, w in enumerate(self.noise)}
        for k, hint in enumerate(proof["steps"]):
            x, parts = rows[:n], hint.get("parts", [])
            inputs = fixed | {("state", i): a for i, a in enumerate(x)} | {("memory", i): a for i, a in enumerate(rows[n:])}
            sample = Values(self, inputs | {("time",): [k * self.period, 0]}, None, hint["tables"])
            inputs = sample.inputs | {("held", i): sample(v) for i, v in enumerate(self.values)}
            if not parts: self.show(due, inputs, k, k, 1)
            for j, part in enumerate(parts):
                a, b = ((k * len(parts) + i) * self.period // len(parts) for i in (j, j + 1))
                x, over, time = self.advance(inputs, x, a, b - a, part)
                states = {("time",): time, **{("state", i): a for i, a in enumerate(over)}}
                self.show(due, inputs | states, k * len(parts) + j, k * len(parts) + j + 1, len(parts))
            rows = [*x, *(sample(v) for v in self.next)]
            width = max(map(len, rows))  # the error of each state becomes a symbol
            rows = [[a[0], 0, *a[2:], *[0] * (width - len(a) + i), a[1], *[0] * (len(rows) - 1 - i)] for i, a in enumerate(rows)]
            if "set" in hint:  # a parallelotope that holds all columns but those of the params
                basis, inverse, slack = (rough(hint["set"][key]) for key in ("basis", "inverse", "slack"))
                cover([*zip(*(a[2 + p:] for a in rows), strict=True)], basis, inverse, slack, f"sample {k + 1}: the set is not in the given one")
                rows = [[a[0], e, *a[2: 2 + p], *row] for a, e, row in zip(rows, slack, basis, strict=True)]
                if hint["set"].get("anchor"): anchor = k + 1, rows, basis, inverse, slack
        for c in due:
            if c["until"] is not None:
                need(sum(number(c["until"])) <= k * ONE and not parts, "the steps end before the claim")
                continue
            need(anchor is not None and number(c["from"])[0] <= anchor[0] * ONE and ["time"] not in self.nodes, "not for ever")
            apart = [add(a, [-x for x in b[: 2 + p]]) for a, b in zip(rows, anchor[1], strict=True)]
            cover([*zip(*([a[0], *a[2:]] for a in apart), strict=True)], *anchor[2:], "the last set is not in the earlier one")

def check(data: Any) -> None:
    """Check a file, and print what it claims."""
    need(data["format"] == "fuzzyctl certificate 1", "the file is no certificate of this kind")
    for part in data["parts"]:
        loop, ranges = Loop(part), [*part["params"], *part["start"]]
        print(f"loop {part['loop']!s:.80}, sampled every {part['period']} s; its equations as operations:")
        for i, (op, *rest) in enumerate(loop.nodes): print(f"  n{i} = {op} {', '.join(map(str, rest))}")
        for proof in part["proofs"]: loop.run(proof, ranges)
        need({c for proof in part["proofs"] for c in proof["claims"]} == {*range(len(loop.claims))}, "a claim has no proof")
        for c in loop.claims: print(f"verified: {c['text']}")

def main(path: str, option: str = "", source: str = "") -> int:
    """Check a file; with `--source FILE` also that the certificate is about this rule file. Return the exit code."""
    try:
        with open(path, "rb") as file: data = json.loads(file.read(1 << 26), parse_constant=lambda x: need(False, f"{x} is no number"))
        check(data)
        if option:
            with open(source, "rb") as file: own = hashlib.sha256(file.read()).hexdigest()
            need(all(own in part["sha256"].values() for part in data["parts"]), f"{source} is not the file that was proved")
    except AssertionError as error: print(f"not verified: {error}")
    except (OSError, ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError, MemoryError) as error:
        print(f"{path}: no certificate: {type(error).__name__} {error!s:.200}")
    else: return 0
    return 1

if __name__ == "__main__": sys.exit(main(*sys.argv[1:4]))
