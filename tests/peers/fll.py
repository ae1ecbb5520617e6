"""Writes drawn systems as FLL, by hand: neither the package's writer nor its reader has a part in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fuzzyctl import (
    Activation,
    And,
    Antecedent,
    Defuzzifier,
    FuzzySystem,
    Hold,
    Input,
    Is,
    Method,
    Or,
    Output,
    Rule,
    RuleBlock,
    Term,
)
from fuzzyctl.expr import Expr, to_text

KINDS = {
    "triangle": "Triangle",
    "trapezoid": "Trapezoid",
    "rectangle": "Rectangle",
    "ramp": "Ramp",
    "piecewise": "Discrete",
    "gaussian": "Gaussian",
    "gaussian2": "GaussianProduct",
    "bell": "Bell",
    "sigmoid": "Sigmoid",
    "sigmoid_difference": "SigmoidDifference",
    "sigmoid_product": "SigmoidProduct",
    "s_shape": "SShape",
    "z_shape": "ZShape",
    "pi_shape": "PiShape",
    "cosine": "Cosine",
    "spike": "Spike",
    "concave": "Concave",
    "arc": "Arc",
    "semi_ellipse": "SemiEllipse",
    "constant": "Constant",
    "linear": "Linear",
    "function": "Function",
}
CONJUNCTIONS = {
    "min": "Minimum",
    "product": "AlgebraicProduct",
    "bounded_difference": "BoundedDifference",
    "drastic_product": "DrasticProduct",
    "einstein_product": "EinsteinProduct",
    "hamacher_product": "HamacherProduct",
    "nilpotent_minimum": "NilpotentMinimum",
}
DISJUNCTIONS = {
    "max": "Maximum",
    "probabilistic_sum": "AlgebraicSum",
    "bounded_sum": "BoundedSum",
    "drastic_sum": "DrasticSum",
    "einstein_sum": "EinsteinSum",
    "hamacher_sum": "HamacherSum",
    "nilpotent_maximum": "NilpotentMaximum",
    "normalized_sum": "NormalizedSum",
    "sum": "UnboundedSum",
}
DEFUZZIFIERS = {
    "centroid": "Centroid",
    "bisector": "Bisector",
    "som": "SmallestOfMaximum",
    "lom": "LargestOfMaximum",
    "mom": "MeanOfMaximum",
    "weighted_average": "WeightedAverage TakagiSugeno",
    "weighted_sum": "WeightedSum TakagiSugeno",
    "tsukamoto": "WeightedAverage Tsukamoto",
    "tsukamoto_sum": "WeightedSum Tsukamoto",
    "inverse_tsukamoto": "WeightedAverage TakagiSugeno",
    "inverse_tsukamoto_sum": "WeightedSum TakagiSugeno",
}


def text(system: FuzzySystem) -> str:
    """Return a system as FLL."""
    return "\n".join(_lines(system)) + "\n"


def _lines(system: FuzzySystem) -> Iterator[str]:
    yield f"Engine: {system.name}"
    for variable in system.inputs:
        yield f"InputVariable: {variable.name}"
        yield from _variable(variable, locked=not variable.extrapolate)
    for output in system.outputs:
        yield f"OutputVariable: {output.name}"
        yield from _variable(output, locked=output.clamped)
        own = output.defuzzifier or system.method.defuzzifier
        yield from _output(output, output.aggregation or system.method.aggregation, own)
        yield from (f"  term: {term.name} {_term(term)}" for term in output.terms)
    loose = [part for part in system.blocks if isinstance(part, Rule)]
    if loose:
        yield from _block("rules", system.method, system.method, loose)
    for block in system.rule_blocks:
        yield from _block(block.name, block, system.method, block.rules)


def _block(name: str, own: RuleBlock | Method, usual: Method, rules: Sequence[Rule]) -> Iterator[str]:
    yield f"RuleBlock: {name}"
    yield "  enabled: true"
    yield f"  conjunction: {CONJUNCTIONS[own.conjunction or usual.conjunction]}"
    yield f"  disjunction: {DISJUNCTIONS[own.disjunction or usual.disjunction]}"
    yield f"  implication: {CONJUNCTIONS[own.implication or usual.implication]}"
    yield f"  activation: {_activation(own.activation or usual.activation)}"
    yield from (f"  rule: {_rule(rule)}" for rule in rules)


def _variable(variable: Input | Output, *, locked: bool) -> Iterator[str]:
    yield "  enabled: true"
    yield f"  range: {_number(variable.lower)} {_number(variable.upper)}"
    yield f"  lock-range: {str(locked).lower()}"
    if isinstance(variable, Input):
        yield from (f"  term: {term.name} {_term(term)}" for term in variable.terms)


def _output(output: Output, aggregation: str, method: Defuzzifier) -> Iterator[str]:
    yield f"  aggregation: {'none' if method.over_rules and aggregation == 'sum' else DISJUNCTIONS[aggregation]}"
    yield f"  defuzzifier: {_defuzzifier(method)}"
    held = isinstance(output.otherwise, Hold)
    start = output.otherwise.start if isinstance(output.otherwise, Hold) else output.otherwise
    yield f"  default: {'nan' if start == 'nan' else _number(start)}"
    yield f"  lock-previous: {str(held).lower()}"


def _defuzzifier(method: Defuzzifier) -> str:
    resolution = f" {method.resolution}" if method.resolution is not None and not method.over_rules else ""
    return DEFUZZIFIERS[method.kind] + resolution


def _activation(method: Activation) -> str:
    words = [method.kind.capitalize()]
    if method.count is not None:
        words.append(str(method.count))
    if method.comparison is not None:
        words.append(method.comparison)
    if method.threshold is not None:
        words.append(_number(method.threshold))
    return " ".join(words)


def _term(term: Term) -> str:
    membership = term.membership
    if membership.kind == "function":
        return f"Function {to_text(membership.arguments[0])}"
    numbers = [_number(a) for a in membership.arguments]
    if _number(membership.height) != "1":
        numbers.append(_number(membership.height))
    return " ".join([KINDS[membership.kind], *numbers])


def _number(expr: Expr) -> str:
    value = float(to_text(expr))
    return repr(int(value)) if value.is_integer() else repr(value)


def _rule(rule: Rule) -> str:
    consequents = " and ".join(f"{c.output} is {' '.join([*c.hedges, c.term])}" for c in rule.consequents)
    weight = _number(rule.weight)
    return f"if {_antecedent(rule.antecedent)} then {consequents}" + (f" with {weight}" if weight != "1" else "")


def _antecedent(antecedent: Antecedent) -> str:
    match antecedent:
        case Is(variable=variable, term=term, hedges=hedges):
            return f"{variable} is {' '.join(hedges if 'any' in hedges else [*hedges, term])}"
        case And(operands=operands):
            return "(" + " and ".join(map(_antecedent, operands)) + ")"
        case Or(operands=operands):
            return "(" + " or ".join(map(_antecedent, operands)) + ")"
    raise TypeError(type(antecedent).__name__)
