"""Check a certificate of `fuzzyctl prove`: python verify.py FILE.json. It needs Python alone and searches for nothing.
It lies beside `verify_numbers.py`, its arithmetic. docs/explanation/proofs.md, "Certificates", walks through both."""
import json, math, sys
from functools import cache, partial
from itertools import product
from typing import TYPE_CHECKING, Any
if TYPE_CHECKING or __package__:
    from fuzzyctl.analysis.verify_numbers import (
        BITS, FUNCTIONS, MINUS, ONE, WORK, add, applied, at_ends, ball_box, between, chords, columns_of, cover, either,
        enclosed, ends, evolved, exact, hinted, hull, keyed, least_stretch, length, minus, multiplied, need, number,
        say, shrinks, table_of, tabulated, times, total, unit)
else:  # the two files alone
    sys.path.append(__file__.rpartition("verify.py")[0] or ".")
    globals().update((k, v) for k, v in vars(__import__("verify_numbers")).items() if k[0] != "_")
CONVERGES = "converges"  # in place of the clauses of a claim: of all runs from the start, at samples
class Loop:  # x' = rates(x, held, memory); every period held = values(x, memory), memory = next(x, memory)
    def __init__(self, data: Any) -> None:
        self.nodes, self.rates, self.values, self.next = (data[k] for k in ("nodes", "rates", "held", "next"))
        self.tables: Any = [table_of(t) for t in data["tables"]]
        need(all(self.nodes[i] == ["state", i] for i in range(len(self.rates))), "the first nodes are not the states")
        self.period, self.params = number(data["period"]), len(data["params"])
        self.claims = [(t, c, hinted(a), math.inf if b is None else -hinted(-b)) for t, c, a, b in data["claims"]]
        need(self.period > 0 and self.claims, "no period, or no claims")
        need(all(c and t.isprintable() and max(a, 0) <= b for t, c, a, b in self.claims), "an unreadable, empty claim")
        need(all(b == math.inf for _, c, _, b in self.claims if c == CONVERGES), "a claim of convergence has an end")
        self.noise = [enclosed(*pair) for pair in data["disturbances"]]
        self.given = [[enclosed(x, x) for x in row] for row in data.get("given", [])]  # known, by period
    def series(self, inputs: Any, seeds: Any = None, hints: Any = ()) -> Any:  # Taylor coefficients in time, of node i
        @cache
        def v(i: int, k: int = 0) -> Any:
            op, *rest = self.nodes[i]
            need(not k or op not in ("error", "table", "abs"), f"the derivative of {op} is not known", 100)
            if op == "+": return add(*(v(j, k) for j in rest))
            if op == "*": return folded(range(k + 1), k, *rest)
            if op == "const": return [0, 0] if k else enclosed(*rest, *rest)
            if op == "error": return [0, sum(enclosed(0, *rest))]
            if op == "table": return tabulated(self.tables[rest[0]], [v(j) for j in rest[1:]], hinted(hints[str(i)]))
            if op == "choice":  # the second if the first is at least 0, or above 0 if marked by 1, else the third
                (low, high), (_, m, yes, no) = ends(v(rest[0])), rest
                need(m in (0, 1) and (not k or low >= m or high < m), "the derivative of a choice is not known")
                return either(*(v(j, k) for j in (yes, no)[high < m:1 + (low < m)]))
            if op in FUNCTIONS and not k: return applied(op, v(rest[0]))
            if op in ("exp", "sin", "cos"):  # y' = slope x', so that k y[k] = sum of j x[j] slope[k - j]
                need(self.nodes[rest[1]] == [{"sin": "cos", "cos": "sin"}.get(op, op), rest[0], i], "a wrong slope")
                terms = ([x * j for x in times(v(rest[0], j), v(rest[1], k - j))] for j in range(1, k + 1))
                return times(total(terms), [(-ONE if op == "cos" else ONE) // k, 1])
            if op == "inverse": return times(times(v(i), MINUS), folded(range(1, k + 1), k, rest[0], i))  # x y = 1
            if op == "sqrt":  # y y = x, so that 2 y[0] y[k] = x[k] - the sum of y[j] y[k - j]
                return times(minus(v(rest[0], k), folded(range(1, k), k, i, i)), applied("inverse", add(v(i), v(i))))
            if k and seeds is not None: return seeds.get((op, *rest), [0, 0])  # a derivative by inputs, not by time
            if op == "state" and k: return times(v(self.rates[rest[0]], k - 1), [ONE // k, 1])  # x' = rate
            return [ONE if (op, k) == ("time", 1) else 0, 0] if k else inputs[op, *rest]
        def folded(js: Any, k: int, a: int, b: int) -> Any: return total(times(v(a, j), v(b, k - j)) for j in js)
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
            spread = keyed(state=(apart := [+a for a in hinted(hint["apart"])]), disturbance=[w[1] for w in self.noise])
            slopes = [(self.series(span, {key: [ONE, 0]}), s) for key, s in spread.items()]
            for r, a in zip(self.rates, apart, strict=True):
                moved = sum((max(map(abs, ends(slope(r, 1)))) * s >> BITS) + 1 for slope, s in slopes)
                need(0 <= moved * step >> BITS < a, f"disturbances move a state by more {where}")
            results = [[add(rows[i], [0, apart[i]]) for i in n] for rows in results]
        return *results, add([begin, 0], time)
    def show(self, due: Any, inputs: Any, a: int, b: int) -> None:  # the claims about times from a to b, in periods
        v, WORK[0] = self.series(inputs), WORK[0] + 10 * len(due)
        for text, clauses, _, _ in (c for c in due if c[1] != CONVERGES and a <= c[3] and (b > c[2] or a == b == c[2])):
            holds = all(any(ends(v(i))[0] >= (mark == 1) for i, mark in clause) for clause in clauses)  # 1: above 0
            need(holds, f"'{text:.99}' is not shown from sample {a / ONE:.9g} on")
    def pass_by(self, k: int, rows: Any, hint: Any, fixed: Any, due: Any) -> Any:  # period k: the states after it, the
        n, parts, m = len(self.rates), hint["parts"], len(hint["parts"])           # values at its begin, and its parts
        x, results, signals = rows[:n], [], self.given[k - 1] if self.given else []
        inputs = fixed | keyed(state=x, memory=rows[n:], given=signals)
        v = self.series(inputs | {("time",): [(k - 1) * self.period, 0]}, None, hint["tables"])
        inputs |= keyed(held=[v(i) for i in self.values])
        self.show(due, inputs | {("time",): [(k - 1) * self.period, 0]}, (k - 1) * ONE, (k - 1) * ONE)
        for j, part in enumerate(parts, (k - 1) * m):
            a, b = j * self.period // m, (j + 1) * self.period // m
            x, over, time = self.advance(inputs, x, a, b - a, part)
            results.append((inputs | keyed(state=over) | {("time",): time}, b - a))
            self.show(due, results[-1][0], j * ONE // m, -(-(j + 1) * ONE // m))
        return [*x, *(v(i) for i in self.next)], v, results
    def run(self, proof: Any, due: Any, ranges: Any) -> Any:  # claims about all params and starts in some ranges
        if "cut" in proof:  # in two halves
            side, middle = proof["cut"]
            parts = [ranges[side][0], middle], [middle, ranges[side][1]]
            return [self.run(proof["halves"][i], due, [*ranges[:side], parts[i], *ranges[side + 1:]]) for i in (0, 1)]
        p, k, still, anchor = self.params, 0, not {"time", "given"} & {op for op, *_ in self.nodes}, None
        need(len(ranges) + len(self.next) + len(self.values) < 1000, "too many states")
        box = [[a[0], 0, *[0] * i, a[1]] for i, a in enumerate(enclosed(*r) for r in ranges)]
        rows, fixed = box[p:], keyed(param=box[:p], disturbance=self.noise)
        for k, hint in enumerate(proof["steps"], 1):
            done = k == len(proof["steps"]) and all(c[3] < math.inf for c in due)
            need(hint["parts"] or done, f"no time passes in period {k}", len(ranges) * len(hint["parts"]))
            rows, slack = self.pass_by(k, rows, hint, fixed, due)[0], [0] * len(rows)
            columns = columns_of(rows, p)  # each error is a new symbol
            need(len(columns) * len(self.nodes) < 10**7, "too many symbols", len(columns) * len(rows))
            if "set" in hint:  # but for those of the params and some others they lie in a parallelotope and some slack
                (basis, inverse, slack), keep = hinted(hint["set"]), [*range(p), *hint["keep"]]
                cover([c for i, c in enumerate(columns) if i not in keep], basis, inverse, slack, f"set {k} is small")
                columns = [*(columns[i] for i in keep), *zip(*basis, strict=True)]
                if still and "anchor" in hint and not hint["keep"] and k < len(proof["steps"]):
                    anchor = k * ONE, [[a[0], 0, *g[:p]] for a, g in zip(rows, zip(*columns))], basis, inverse, slack
            rows = [[a[0], e, *g] for a, e, g in zip(rows, slack, zip(*columns, strict=True), strict=True)]
        if "ball" in proof: self.contract(k + 1, rows, proof["ball"], fixed, [c for c in due if c[3] == math.inf])
        for text, clauses, begin, end in due:
            ever = "ball" in proof or (clauses != CONVERGES and anchor and begin <= anchor[0])
            need(ever if end == math.inf else end <= (k - 1) * ONE, f"no end of '{text:.99}'")
        if anchor: self.inside(rows, *anchor[1:])
    def inside(self, rows: Any, earlier: Any, basis: Any, inverse: Any, slack: Any) -> None:  # for all params
        apart = [add(a, [-x for x in b]) for a, b in zip(rows, earlier, strict=True)]  # so it holds all later sets
        cover([[a[0] for a in apart], *columns_of(apart, self.params)], basis, inverse, slack, "a set does not return")
    def slopes(self, x: Any, y: Any, i: int) -> Any:  # node i at x less that at y is the sum of these slopes times
        op, *p = self.nodes[i]                        # the same of its parts; intervals, as x and y are any two points
        if op == "+": return [(j, [ONE, 0]) for j in p[:2]]
        if op == "table":
            return [*zip(p[1:], chords(self.tables[p[0]], *([v(j) for j in p[1:]] for v in (x, y))), strict=True)]
        if op == "*":  # a b - c d = (a - c) d + a (b - d) = (a - c) b + c (b - d)
            a, b = (x, y) if hull(x(p[0]))[1] >= hull(x(p[1]))[1] else (y, x)
            return [(p[0], hull(a(p[1]))), (p[1], hull(b(p[0])))]
        if op == "abs":
            m = 1 + max(abs(e) for v in (x, y) for e in ends(v(p[0])))
            return [(p[0], *chords(([[-m, 0, m]], [m, 0, m]), [x(p[0])], [y(p[0])]))]
        if op == "inverse": return [(p[0], times(times(hull(x(i)), hull(y(i))), MINUS))]
        if op == "sqrt" and min(ends(x(p[0]))[0], ends(y(p[0]))[0]) >= 0:  # 1 / (sqrt x + sqrt y)
            return [(p[0], applied("inverse", add(hull(x(i)), hull(y(i)))))]
        if op in ("exp", "sin", "cos"):  # the derivative between them
            need(self.nodes[p[1]] == [{"sin": "cos", "cos": "sin"}.get(op, op), p[0], i], "a wrong slope")
            return [(p[0], times(hull(x(p[1])), MINUS) if op == "cos" else hull(x(p[1])))]
        return need(op in ("const", "param", "error", "disturbance"), f"the slope of {op} is not known") or []
    def moved(self, wanted: Any, seeds: Any, local: Any) -> Any:  # the chain rule: how nodes change with some inputs
        @cache
        def row(i: int) -> Any:
            if tuple(self.nodes[i]) in seeds: return seeds[tuple(self.nodes[i])]
            rows = [[times(slope, g) for g in row(j)] for j, slope in local(i)]
            return [total(column) for column in zip([[0, 0]] * len(next(iter(seeds.values()))), *rows)]
        return [row(i) for i in wanted]
    def contract(self, k: int, rows: Any, hint: Any, fixed: Any, due: Any) -> None:  # a ball |inverse (z - centre)| <=
        n, size, read = len(self.rates), len(rows), len(self.values)                 # radius that holds the rows
        changing = {"time", "given"} | ({"error", "disturbance"} if any(c[1] == CONVERGES for c in due) else set())
        need(not changing & {op for op, *_ in self.nodes}, f"{' and '.join(sorted(changing))} keep runs apart")
        basis, inverse, centre, (radius, near, rate) = map(hinted, hint["form"])
        stretch, turned, text = least_stretch(inverse, basis), exact(inverse), "distances are not shown to shrink"
        need(len(basis) == len(centre) == size == n + len(self.next), "a ball of others", 10**4 * len(hint["vary"]))
        def away(z: Any) -> int: return length(*zip(*multiplied(turned, [[add(a, [-c])] for a, c in zip(z, centre)])))
        need(0 <= near <= radius and rate < ONE and away(rows) <= radius, "the set does not lie in the ball")
        due, runs = [(text, clauses, 0, end) for text, clauses, _, end in due], list[Any]()
        for r in (0, near, radius):  # the centre, and boxes that hold balls
            box = ball_box(centre, basis, r, stretch, self.params)
            runs.append(self.pass_by(k, box, hint["periods"][r == radius], fixed, due if len(runs) == 2 else []))
        drift = away(runs[0][0])
        need(all(run[2] for run in runs) and drift + (rate * near >> BITS) + 1 <= near, "the centre moves too far")
        # Distances between points of the near ball and of the ball shrink by the rate, for the same errors: both are
        # mapped into themselves. Without errors the near one has a fixed point (Banach), to which the ball converges.
        names, whole = [*keyed(state=self.rates, held=self.values, memory=self.next)], unit(size + read)
        for (y, step), (x, _) in zip(runs[1][2], runs[2][2], strict=True):
            local = partial(self.slopes, self.series(x), self.series(y))
            rates = self.moved(self.rates, dict(zip(names, unit(size + read))), local)
            whole = multiplied(evolved([*rates, *([[0, 0]] * len(names) for _ in names[n:])], step), whole)
        begin, options = cache(partial(self.slopes, runs[2][1], runs[1][1])), []
        seeds = dict(zip([*names[:n], *names[n + read:]], unit(size)))
        for i in hint["vary"]:  # slopes are means of those at corners; those of the whole are affine in each
            options.append(at_ends(begin(i)))
        for corner in product(*options):
            picked = dict(zip(hint["vary"], corner))
            inner = self.moved([*self.values, *self.next], seeds, lambda i: picked.get(i) or begin(i))  # noqa: B023
            matrix = multiplied(whole[:n], [*unit(size)[:n], *inner[:read], *unit(size)[n:]]) + inner[read:]
            need(shrinks(multiplied(multiplied(turned, matrix), exact(basis)), rate * stretch >> BITS), text, 1000)
def check(data: Any) -> None:  # a whole file, and print its claims
    need(data["format"] == "fuzzyctl certificate 2" and data["parts"], "the file has another format, or no parts")
    for part in data["parts"]:
        loop, ranges = Loop(part), [*part["params"], *part["start"]]
        say(f"Loop {part['loop']:.99}, sampled every {part['period']} s. Its operations:")
        for i, node in enumerate(loop.nodes): say(f"  n{i} = {' '.join(map(str, node))}")
        for name, pair in zip(part["names"], ranges, strict=True): say(f"  {name:.99} begins in {pair}")
        for proof in part["proofs"]: loop.run(proof, [loop.claims[i] for i in proof["claims"]], ranges)
        for i, (text, clauses, begin, end) in enumerate(loop.claims):
            need(any(i in proof["claims"] for proof in part["proofs"]), f"'{text:.99}' has no proof")
            facts = ["all runs converge"] if clauses == CONVERGES else (" or ".join(
                f"n{j} {'>' if mark == 1 else '>='} 0" for j, mark in c) for c in clauses)
            say(f"verified: {text:.99}: {'; '.join(facts)}; from {begin / ONE:.9g} to {end / ONE:.9g} periods")
def main(path: str) -> None:
    try:
        with open(path, "rb") as file: check(json.loads(file.read(1 << 24), parse_constant=lambda x: need(False, x)))
    except AssertionError as error: sys.exit(f"{path}: not verified: {error}")
    except Exception as error:  # noqa: BLE001
        sys.exit(f"{path}: not a certificate: {type(error).__name__} {error!s:.300}")
if __name__ == "__main__": main(sys.argv[1])
