"""Writes drawn systems as `.fis` files for Octave by hand: the package's writer and reader have no part in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fuzzyctl import And, Antecedent, FuzzySystem, Is, LinguisticVariable, Or, Rule, Term

#: Kinds with the positions of their parameters in the order of the file.
KINDS: dict[str, tuple[str, tuple[int, ...] | None]] = {
    "triangle": ("trimf", None),
    "trapezoid": ("trapmf", None),
    "gaussian": ("gaussmf", (1, 0)),
    "gaussian2": ("gauss2mf", (1, 0, 3, 2)),
    "bell": ("gbellmf", (1, 2, 0)),
    "sigmoid": ("sigmf", (1, 0)),
    "sigmoid_difference": ("dsigmf", (1, 0, 2, 3)),
    "sigmoid_product": ("psigmf", (1, 0, 2, 3)),
    "s_shape": ("smf", None),
    "z_shape": ("zmf", None),
    "pi_shape": ("pimf", None),
    "constant": ("constant", None),
    "linear": ("linear", None),
}
NORMS = {
    "min": "min",
    "product": "prod",
    "bounded_difference": "bounded_difference",
    "drastic_product": "drastic_product",
    "einstein_product": "einstein_product",
    "hamacher_product": "hamacher_product",
    "max": "max",
    "sum": "sum",
    "probabilistic_sum": "algebraic_sum",
    "bounded_sum": "bounded_sum",
    "drastic_sum": "drastic_sum",
    "einstein_sum": "einstein_sum",
    "hamacher_sum": "hamacher_sum",
}
DEFUZZIFIERS = {"weighted_average": "wtaver", "weighted_sum": "wtsum"}
#: The two digits behind the number of a term.
HEDGES = {(): "", ("somewhat",): ".05", ("very",): ".20", ("extremely",): ".30", ("very", "very"): ".40"}


def text(system: FuzzySystem) -> str:
    """Return a system as a `.fis` file."""
    return "\n".join(_lines(system)) + "\n"


def _lines(system: FuzzySystem) -> Iterator[str]:
    method = system.method
    kind = method.defuzzifier.kind
    yield "[System]"
    yield f"Name = '{system.name}'"
    yield f"Type = '{'sugeno' if method.defuzzifier.over_rules else 'mamdani'}'"
    yield "Version = 1.0"
    yield f"NumInputs = {len(system.inputs)}"
    yield f"NumOutputs = {len(system.outputs)}"
    yield f"NumRules = {len(system.rules)}"
    yield f"AndMethod = '{NORMS[method.conjunction]}'"
    yield f"OrMethod = '{NORMS[method.disjunction]}'"
    yield f"ImpMethod = '{NORMS[method.implication]}'"
    yield f"AggMethod = '{NORMS[method.aggregation]}'"
    yield f"DefuzzMethod = '{DEFUZZIFIERS.get(kind, kind)}'"
    for word, variables in (("Input", system.inputs), ("Output", system.outputs)):
        for k, variable in enumerate(variables):
            yield from ("", f"[{word}{k + 1}]", f"Name = '{variable.name}'")
            yield f"Range = [{_number(variable.lower.value)} {_number(variable.upper.value)}]"
            yield f"NumMFs = {len(variable.terms)}"
            yield from (f"MF{m + 1} = '{t.name}' : {_term(t)}" for m, t in enumerate(variable.terms))
    yield from ("", "[Rules]")
    yield from (_rule(system, rule) for rule in system.rules)


def _number(value: float) -> str:
    return repr(int(value)) if value.is_integer() else repr(value)


def _term(term: Term) -> str:
    name, order = KINDS[term.membership.kind]
    values = [a.value for a in term.membership.arguments]
    values = values if order is None else [values[i] for i in order]
    return f"'{name}', [{' '.join(map(_number, values))}]"


def _rule(system: FuzzySystem, rule: Rule) -> str:
    parts, connection = _parts(rule.antecedent)
    before = " ".join(_of(v, [p for p in parts if p.variable == v.name]) for v in system.inputs)
    after = " ".join(_of(v, [c for c in rule.consequents if c.output == v.name]) for v in system.outputs)
    return f"{before}, {after} ({_number(rule.weight.value)}) : {connection}"


def _parts(antecedent: Antecedent) -> tuple[Sequence[Is], int]:
    match antecedent:
        case Is():
            return (antecedent,), 1
        case And(operands=operands):
            return operands, 1
        case Or(operands=operands):
            return operands, 2
    raise TypeError(type(antecedent).__name__)


def _of(variable: LinguisticVariable, named: Sequence) -> str:
    if not named:
        return "0"
    number = [t.name for t in variable.terms].index(named[0].term) + 1
    hedges = named[0].hedges
    negated = hedges[:1] == ("not",)
    return ("-" if negated else "") + str(number) + HEDGES[hedges[1:] if negated else hedges]
