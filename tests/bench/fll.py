"""The workloads in fuzzylite's language, for the comparison with its own engine."""

from __future__ import annotations

from tests.bench.workloads import LINES, SEVEN

FIVE = "NB NS ZO PS PB".split()
TABLE = ("NB NM NM NS NS", "NM NS ZO PS ZO", "ZO PS PM PS ZO", "ZO PS ZO NS NM", "NS NS NM NM NB")
PEAKS = {"NB": -1.0, "NM": -0.66, "NS": -0.33, "ZO": 0.0, "PS": 0.09, "PM": 0.18}


def _input(name: str, low: float, high: float, terms: list[str]) -> list[str]:
    return [f"InputVariable: {name}", "  enabled: true", f"  range: {low} {high}", "  lock-range: false", *terms]


def _output(name: str, low: float, high: float, defuzzifier: str, aggregation: str, terms: list[str]) -> list[str]:
    head = [f"OutputVariable: {name}", "  enabled: true", f"  range: {low} {high}", "  lock-range: false"]
    rest = [
        f"  aggregation: {aggregation}",
        f"  defuzzifier: {defuzzifier}",
        "  default: nan",
        "  lock-previous: false",
    ]
    return [*head, *rest, *terms]


def _rules(conjunction: str, disjunction: str, implication: str, rules: list[str]) -> list[str]:
    norms = [f"  conjunction: {conjunction}", f"  disjunction: {disjunction}", f"  implication: {implication}"]
    return ["RuleBlock: rules", "  enabled: true", *norms, "  activation: General", *(f"  rule: {r}" for r in rules)]


def _partition(names: list[str], low: float, high: float) -> list[str]:
    last = len(names) - 1
    peaks = [low + (high - low) * k / last for k in range(last + 1)]
    inner = [f"  term: {names[k]} Triangle {peaks[k - 1]} {peaks[k]} {peaks[k + 1]}" for k in range(1, last)]
    first = f"  term: {names[0]} Ramp {peaks[1]} {peaks[0]}"
    return [first, *inner, f"  term: {names[-1]} Ramp {peaks[-2]} {peaks[-1]}"]


def _w1() -> list[str]:
    terms = [f"  term: {n} Constant {p}" for n, p in PEAKS.items()]
    cells = [(FIVE[i], FIVE[j], t) for i, row in enumerate(TABLE) for j, t in enumerate(row.split())]
    rules = [f"if s is {a} and d is {b} then f is {t}" for a, b, t in cells]
    return [
        *_input("s", -0.06, 0.06, _partition(FIVE, -0.03, 0.03)),
        *_input("d", -1, 1, _partition(FIVE, -0.5, 0.5)),
        *_output("f", -1, 0.18, "WeightedAverage TakagiSugeno", "none", terms),
        *_rules("AlgebraicProduct", "none", "none", rules),
    ]


def _w2(resolution: int) -> list[str]:
    cells = [(SEVEN[i], SEVEN[j], SEVEN[min(max(i + j - 3, 0), 6)]) for i in range(7) for j in range(7)]
    return [
        *_input("e", -1, 1, _partition(SEVEN, -1, 1)),
        *_input("d", -1, 1, _partition(SEVEN, -1, 1)),
        *_output("u", -1, 1, f"Centroid {resolution}", "Maximum", _partition(SEVEN, -1, 1)),
        *_rules("Minimum", "none", "Minimum", [f"if e is {a} and d is {b} then u is {c}" for a, b, c in cells]),
    ]


def _w3(resolution: int) -> list[str]:
    service = ["poor Gaussian 0 1.5", "good Gaussian 5 1.5", "excellent Gaussian 10 1.5"]
    food = ["rancid Trapezoid -2 0 1 3", "delicious Trapezoid 7 9 10 12"]
    tip = ["cheap Triangle 0 5 10", "average Triangle 10 15 20", "generous Triangle 20 25 30"]
    rules = [
        "if service is poor or food is rancid then tip is cheap",
        "if service is good then tip is average",
        "if service is excellent or food is delicious then tip is generous",
    ]
    return [
        *_input("service", 0, 10, [f"  term: {t}" for t in service]),
        *_input("food", 0, 10, [f"  term: {t}" for t in food]),
        *_output("tip", 0, 30, f"Centroid {resolution}", "Maximum", [f"  term: {t}" for t in tip]),
        *_rules("Minimum", "Maximum", "Minimum", rules),
    ]


def _w4() -> list[str]:
    terms = [f"  term: {n} Gaussian {m} 0.5" for n, m in zip("NZP", (-1, 0, 1), strict=True)]
    lines = [f"  term: c{k} Linear {a} {b} {c}" for k, (a, b, c) in enumerate(LINES)]
    rules = [
        f"if a is {x} and b is {y} then u is c{3 * i + j}" for i, x in enumerate("NZP") for j, y in enumerate("NZP")
    ]
    return [
        *_input("a", -2, 2, terms),
        *_input("b", -2, 2, terms),
        *_output("u", -5, 5, "WeightedAverage TakagiSugeno", "none", lines),
        *_rules("AlgebraicProduct", "none", "none", rules),
    ]


def texts() -> dict[str, str]:
    """Return each workload by name; centroids with 101 samples, since fuzzylite has no exact one."""
    made = {"W1": _w1(), "W2": _w2(101), "W3": _w3(101), "W4": _w4()}
    return {name: "\n".join([f"Engine: {name}", *lines]) + "\n" for name, lines in made.items()}
