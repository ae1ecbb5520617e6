"""Every system prints as a rule file that reads back as the same system."""

import keyword
import unicodedata

from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.fz import dumps
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, DISJUNCTIONS, HEDGES, IMPLICATIONS, MEMBERSHIP
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.lang.syntax import RESERVED
from fuzzyctl.loading.load import loads
from fuzzyctl.model.guarantee import Guarantee, Hedge, Param
from fuzzyctl.model.method import Activation, Defuzzifier, Method
from fuzzyctl.model.rule import And, Cell, Consequent, Is, Not, Or, Rule, RuleBlock, RuleTable
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, Membership, Output, Term
from fuzzyctl.resolve.context import CLAIM_FUNCTIONS
from tests.sizes import examples

TAKEN = RESERVED | set(ex.FUNCTIONS) | set(CLAIM_FUNCTIONS) | set(HEDGES) | {"hold", "midpoint", "nan", "error"}
WORDS = [*keyword.kwlist, "input", "table", "x", "in", "σ", "é", "unit", "linear", "terms", "NB", "PB", "a1", "_"]
NAMES = st.one_of(st.sampled_from(WORDS), st.from_regex(r"[A-Za-zσωéλ_][A-Za-z0-9_σ]{0,6}", fullmatch=True)).filter(
    lambda n: n not in TAKEN and n.isidentifier()
)
TEXTS = st.text(alphabet=st.characters(exclude_characters='"\n\r', exclude_categories=["Cs", "Cc"]), max_size=12).map(
    lambda t: unicodedata.normalize("NFC", t)
)
NUMBERS = st.floats(-1e6, 1e6, allow_nan=False).map(lambda x: ex.Number(x + 0.0))


def expressions(names):
    leaves = st.one_of(NUMBERS, st.sampled_from([ex.Name(n) for n in names])) if names else NUMBERS

    def grow(inner):
        return st.one_of(
            st.builds(ex.Binary, st.sampled_from(["+", "-", "*"]), inner, inner),
            inner.map(ex.Negate),
            st.builds(lambda a, b: ex.Call("max", (a, b)), inner, inner),
        )

    return st.recursive(leaves, grow, max_leaves=5)


@st.composite
def memberships(draw, kinds):
    formula = MEMBERSHIP[draw(st.sampled_from(sorted(kinds)))]
    values = sorted(draw(st.lists(st.floats(0.1, 5), min_size=4, max_size=4, unique=True)))
    count = len(formula.parameters)
    numbers = values[:count] if not formula.variadic else [values[0], 0.25, values[1], 0.75]
    assume(formula.mistake(tuple(numbers)) is None)
    height = draw(st.sampled_from([ex.ONE, ex.ONE, ex.Number(0.5)]))
    return Membership(kind=formula.name, arguments=tuple(map(ex.Number, numbers)), height=height)


SETS = sorted(set(MEMBERSHIP) - {"singleton", "constant"})


@st.composite
def variables(draw, kind, name, membership):
    lower = draw(st.floats(-10, 0))
    terms = draw(st.lists(NAMES, min_size=1, max_size=4, unique=True))
    fields = {
        "name": name,
        "label": draw(TEXTS),
        "unit": draw(TEXTS),
        "lower": ex.Number(lower + 0.0),
        "upper": ex.Number(draw(st.floats(6, 10))),
        "terms": tuple(Term(name=t, membership=draw(membership)) for t in terms),
    }
    return kind(**fields | ({"extrapolate": draw(st.booleans())} if kind is Input else {}))


def fallbacks(param):
    """What an output may be where no rule fires."""
    values = expressions([param])
    return st.sampled_from([None, "midpoint", "nan", "error"]) | values | st.builds(Hold, start=st.none() | values)


def activations(param):
    return st.sampled_from(
        [
            Activation(),
            Activation(kind="proportional"),
            Activation(kind="highest", count=2),
            Activation(kind="first", count=1, threshold=ex.Number(0.25)),
            Activation(kind="threshold", comparison=">=", threshold=ex.Name(param)),
        ]
    )


def weights_of(param):
    return st.one_of(st.just(ex.ONE), st.floats(0, 1).map(lambda x: ex.Number(x + 0.0)), st.just(ex.Name(param)))


@st.composite
def outputs_of(draw, names, param, averages):
    consequents = memberships(["singleton", "constant"] if averages else ["triangle", "trapezoid"])
    own = st.sampled_from([None, Defuzzifier(kind="weighted_average")]) if averages else st.none()
    return tuple(
        draw(variables(Output, n, consequents)).model_copy(
            update={
                "otherwise": draw(fallbacks(param)),
                "defuzzifier": draw(own),
                "aggregation": draw(st.sampled_from([None, "max", "sum"])),
            }
        )
        for n in names
    )


@st.composite
def methods(draw, param, averages):
    resolution = None if averages else draw(st.sampled_from([2, 7, 100]))
    return Method(
        conjunction=draw(st.sampled_from(sorted(CONJUNCTIONS))),
        disjunction=draw(st.sampled_from(sorted(DISJUNCTIONS))),
        implication=draw(st.sampled_from(sorted(IMPLICATIONS))),
        aggregation=draw(st.sampled_from(sorted(AGGREGATIONS))),
        activation=draw(activations(param)),
        defuzzifier=Defuzzifier(
            kind="center_average" if averages else "centroid",
            resolution=resolution,
            grid=draw(st.sampled_from(["midpoint", "endpoints"])) if resolution else "midpoint",
        ),
    )


def antecedents_of(inputs, hedge):
    literals = st.one_of(
        [
            st.builds(
                lambda t, h, v=v: Is(variable=v.name, term=t.name, hedges=tuple(h)),
                st.sampled_from(v.terms),
                st.lists(st.sampled_from([*sorted(HEDGES), hedge]), max_size=2),
            )
            for v in inputs
        ]
    )

    def grow(inner):
        pair = st.lists(inner, min_size=2, max_size=3).map(tuple)
        return st.one_of(
            inner.map(lambda o: Not(operand=o)),
            pair.map(lambda p: And(operands=p)),
            pair.map(lambda p: Or(operands=p)),
        )

    return st.recursive(literals, grow, max_leaves=5)


def consequents_of(outputs, averages):
    def one(output):
        named = st.sampled_from([t.name for t in output.terms])
        functions = st.lists(NUMBERS, min_size=3, max_size=3).map(
            lambda a: Membership(kind="linear", arguments=tuple(a))
        )
        constants = NUMBERS.map(lambda a: Membership(kind="constant", arguments=(a,)))
        return st.one_of(named, functions, constants) if averages else named

    return st.tuples(*[one(o) for o in outputs])


def rules_of(outputs, antecedents, consequents, weights):
    return st.builds(
        lambda a, t, w: Rule(
            antecedent=a,
            consequents=tuple(Consequent(output=o.name, term=x) for o, x in zip(outputs, t, strict=True)),
            weight=w,
        ),
        antecedents,
        consequents,
        weights,
    )


@st.composite
def tables(draw, inputs, outputs, consequents, conditions, weights):
    cells = st.just(Cell(terms=())) | st.builds(lambda t, w: Cell(terms=t, weight=w), consequents, weights)
    one_way = draw(st.booleans())
    rows = () if one_way else tuple(t.name for t in inputs[0].terms)
    columns = tuple(t.name for t in inputs[1].terms)
    return RuleTable(
        outputs=tuple(o.name for o in outputs),
        rows=None if one_way else inputs[0].name,
        columns=inputs[1].name,
        row_terms=rows,
        column_terms=columns,
        cells=tuple(tuple(draw(cells) for _ in columns) for _ in (rows or (0,))),
        condition=draw(st.none() | conditions),
    )


@st.composite
def blocks_of(draw, inputs, outputs, hedge, param, averages):
    antecedents, consequents = antecedents_of(inputs, hedge), consequents_of(outputs, averages)
    rules = rules_of(outputs, antecedents, consequents, weights_of(param))
    table = draw(tables(inputs, outputs, consequents, antecedents, weights_of(param)))
    return (draw(rules), table, draw(rules), *_rule_blocks(draw, param, draw(rules), table))


@st.composite
def guarantees(draw, claimed, given, param):
    claim = ex.Compare("<=", ex.Call(claimed, (ex.Name(given), ex.ZERO)), draw(expressions([param])))
    return Guarantee(claim=claim, within=ex.Number(1e-9), when=draw(st.none() | st.just(claim)))


@st.composite
def systems(draw):
    names = draw(st.lists(NAMES, min_size=7, max_size=7, unique=True))
    param, averages = names[0], draw(st.booleans())
    hedge = Hedge(name=names[6], parameter=names[5], expression=draw(expressions([names[5], param])))
    inputs = tuple(draw(variables(Input, n, memberships(SETS))) for n in names[1:3])
    outputs = draw(outputs_of(names[3:5], param, averages))
    return FuzzySystem(
        name=draw(NAMES),
        title=draw(TEXTS),
        citation=draw(TEXTS),
        params=(Param(name=param, expression=draw(expressions([])), unit=draw(TEXTS)),),
        hedges=(hedge,),
        method=draw(methods(param, averages)),
        inputs=inputs,
        outputs=outputs,
        blocks=draw(blocks_of(inputs, outputs, hedge.name, param, averages)),
        guarantees=(draw(guarantees(outputs[0].name, inputs[0].name, param)),),
    )


def _rule_blocks(draw, param, rule, table):
    """Return no rule block, or one with a rule and one with a table, each with some settings of its own."""
    settings = st.fixed_dictionaries(
        {},
        optional={
            "conjunction": st.sampled_from(list(CONJUNCTIONS)),
            "disjunction": st.sampled_from(list(DISJUNCTIONS)),
            "implication": st.sampled_from(list(CONJUNCTIONS)),
            "activation": activations(param),
        },
    )
    names = draw(st.lists(NAMES, max_size=2, unique=True))
    parts = [(rule,), (table, rule)]
    return [RuleBlock(name=n, rules=r, **draw(settings)) for n, r in zip(names, parts, strict=False)]


def well_formed(system):
    from fuzzyctl.model.checks.checks import check_model

    return not any(d.severity == "error" for d in check_model(system))


@settings(
    max_examples=examples(40, 6),
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
    deadline=None,
)
@given(systems())
def test_what_is_printed_reads_back_as_the_same_system(system):
    assume(well_formed(system))
    text = dumps(system)
    assert loads(text) == system
    assert format_source(SourceText("t", text)) == text
    assert dumps(loads(text)) == text
