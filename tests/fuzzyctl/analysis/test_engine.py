"""Coverage and bounds of what is more than a table of fuzzy sets."""

import math

import pytest

from fuzzyctl import FuzzySystem, output_bounds
from fuzzyctl import compile as compile_system
from fuzzyctl.analysis.coverage.box_search import Hole, Undecided
from fuzzyctl.analysis.coverage.coverage import uncovered
from fuzzyctl.expr import Binary, Call, Name, Number
from fuzzyctl.model.method import Activation, Defuzzifier, Method
from fuzzyctl.model.rule import And, Consequent, Is, Or, Rule
from fuzzyctl.model.variable import Input, Membership, Output, Term
from tests.own_fields import names_of


def mf(kind, *numbers, height=1.0):
    return Membership(kind=kind, arguments=tuple(Number(float(n)) for n in numbers), height=Number(height))


def function(expr):
    return Membership(kind="function", arguments=(expr,))


X, Y = Name("x"), Name("y")
TERMS = {"up": mf("ramp", 0, 1), "down": mf("ramp", 1, 0), "all": mf("rectangle", -1, 2), "late": mf("s_shape", 0.5, 1)}
LINE = mf("linear", 2, 0, 1)


def system(rules, kind="weighted_average", otherwise=None, method=None, terms=None, extrapolate=False, **own):
    inputs = tuple(
        Input(
            name=n,
            lower=Number(0.0),
            upper=Number(1.0),
            extrapolate=extrapolate,
            terms=tuple(Term(name=k, membership=m) for k, m in TERMS.items()),
        )
        for n in ("x", "y")
    )
    output = Output(
        name="u",
        lower=Number(0.0),
        upper=Number(4.0),
        terms=tuple(Term(name=k, membership=m) for k, m in ({"set": mf("triangle", 0, 1, 2)} | (terms or {})).items()),
        otherwise=otherwise,
        defuzzifier=Defuzzifier(kind=kind, resolution=8 if kind == "centroid" else None),
        **own,
    )
    made = tuple(
        Rule(antecedent=a, consequents=(Consequent(output="u", term=t),), weight=Number(w)) for a, t, w in rules
    )
    return FuzzySystem(name="s", inputs=inputs, outputs=(output,), blocks=made, method=method or Method())


def is_(variable, term, *hedges):
    return Is(variable=variable, term=term, hedges=hedges)


EVERYWHERE = [(is_("x", "up"), LINE, 1.0), (is_("x", "down"), mf("constant", 5), 1.0)]


class TestBounds:
    def test_linear_consequents_are_bounded_by_their_ends(self):
        bound = output_bounds(system(EVERYWHERE))["u"]
        assert (bound.lo, bound.hi) == (1.0, 5.0)

    def test_functions_are_bounded_by_intervals(self):
        rules = [
            (is_("x", "all"), function(Binary("*", X, X)), 1.0),
            (is_("x", "up"), function(Call("exp", (Y,))), 1.0),
        ]
        bound = output_bounds(system(rules))["u"]
        assert bound.lo == 0.0
        assert math.e <= bound.hi < math.e * (1 + 1e-14)

    def test_a_linear_one_of_an_unbounded_input_is_unbounded(self):
        bound = output_bounds(system(EVERYWHERE, extrapolate=True))["u"]
        assert (bound.lo, bound.hi) == (-math.inf, math.inf)

    def test_a_weighted_sum_adds_what_each_rule_can_add(self):
        bound = output_bounds(system([(is_("x", "up"), LINE, 0.5), *EVERYWHERE[1:]], "weighted_sum"))["u"]
        assert bound.lo == pytest.approx(0.0, abs=1e-13)
        assert bound.hi == pytest.approx(1.5 + 5.0)
        assert bound.lo <= 0.0
        assert bound.hi >= 6.5

    def test_a_weighted_sum_of_shares_is_bounded_by_the_largest_shares(self):
        method = Method(activation=Activation(kind="proportional"))
        bound = output_bounds(system(EVERYWHERE, "weighted_sum", method=method))["u"]
        assert bound.hi == pytest.approx(3.0 + 5.0)

    def test_tsukamoto_stays_within_the_places_in_the_range(self):
        terms = {"s": mf("sigmoid", 1, 3), "r": mf("ramp", 3, 2)}
        bound = output_bounds(system([(is_("x", "all"), "r", 1.0)], "tsukamoto", terms=terms))["u"]
        assert (bound.lo, bound.hi) == (2.0, 3.0)
        bound = output_bounds(
            system([(is_("x", "all"), "r", 1.0), (is_("x", "up"), "s", 1.0)], "tsukamoto", terms=terms)
        )["u"]
        assert (bound.lo, bound.hi) == (0.0, 4.0)

    def test_rules_that_cannot_reach_a_threshold_do_not_count(self):
        method = Method(activation=Activation(kind="threshold", comparison=">=", threshold=Number(0.5)))
        rules = [(is_("x", "all"), mf("constant", 1), 1.0), (is_("x", "up"), mf("constant", 9), 0.25)]
        assert output_bounds(system(rules, method=method))["u"].hi == pytest.approx(1.0)

    def test_where_a_tiny_rule_may_be_chosen_the_bound_is_that_of_all_rules(self):
        never = And(operands=(is_("x", "late"), is_("x", "any", "not", "any")))
        rules = [*EVERYWHERE, (never, mf("constant", 9), 1.0)]
        rules[0] = (is_("x", "up"), mf("constant", 1), 1.0)
        for kind, hi in (("general", 5.0), ("lowest", 9.0)):
            method = Method(activation=Activation(kind=kind, count=1 if kind == "lowest" else None))
            changed = [
                (a if k < 2 else And(operands=(is_("x", "up"), is_("x", "up", "not", "any"))), t, w)
                for k, (a, t, w) in enumerate(rules)
            ]
            assert output_bounds(system(changed, method=method))["u"].hi == pytest.approx(hi)


class TestCoverage:
    def test_holds_for_functions(self):
        assert uncovered(system(EVERYWHERE)) == {"u": None}

    def test_hedges_keep_zero_degrees(self):
        rules = [(is_("x", "late", h), LINE, 1.0) for h in ("very", "somewhat", "extremely", "slightly", "seldom")]
        hole = uncovered(system(rules))["u"]
        assert isinstance(hole, Hole)
        assert hole.region["x"].upper == 0.5
        assert uncovered(system([(is_("x", "late", "any"), LINE, 1.0)])) == {"u": None}
        assert uncovered(system([(is_("x", "late", "not"), LINE, 1.0), *EVERYWHERE])) == {"u": None}

    @pytest.mark.parametrize("norm", ["einstein_product", "hamacher_product", "product", "min"])
    def test_strict_norms_need_both_operands(self, norm):
        both = [(And(operands=(is_("x", t), is_("y", "all"))), LINE, 1.0) for t in ("up", "down")]
        assert uncovered(system(both, method=Method(conjunction=norm))) == {"u": None}

    def test_norms_that_are_not_strict_leave_holes(self):
        both = [(And(operands=(is_("x", "up"), is_("y", "up"))), LINE, 1.0)]
        for norm in ("bounded_difference", "drastic_product", "nilpotent_minimum"):
            verdict = uncovered(system(both, method=Method(conjunction=norm)))["u"]
            assert isinstance(verdict, Hole)

    @pytest.mark.parametrize("norm", ["max", "einstein_sum", "hamacher_sum", "nilpotent_maximum", "drastic_sum"])
    def test_disjunctions_need_one_operand(self, norm):
        either = [(Or(operands=(is_("x", "up"), is_("x", "down"))), LINE, 1.0)]
        assert uncovered(system(either, method=Method(disjunction=norm))) == {"u": None}

    def test_an_implication_may_cut_a_set_away(self):
        rules = [(is_("x", "up"), "set", 1.0), (is_("x", "down"), "set", 1.0)]
        assert uncovered(system(rules, "centroid")) == {"u": None}
        cut = uncovered(system(rules, "centroid", implication="bounded_difference"))["u"]
        assert cut is None
        low = uncovered(
            system(
                rules, "centroid", terms={"set": mf("triangle", 0, 1, 2, height=0.4)}, implication="bounded_difference"
            )
        )["u"]
        assert isinstance(low, Hole)
        at = low.witness
        quiet = system(
            rules,
            "centroid",
            otherwise="nan",
            terms={"set": mf("triangle", 0, 1, 2, height=0.4)},
            implication="bounded_difference",
        )
        assert math.isnan(compile_system(quiet, "python")(at["x"], at["y"]))

    def test_a_threshold_leaves_out_low_activations(self):
        method = Method(activation=Activation(kind="threshold", comparison=">", threshold=Number(0.5)))
        hole = uncovered(system(EVERYWHERE, method=method))["u"]
        assert isinstance(hole, Hole)
        assert hole.witness["x"] == pytest.approx(0.5)
        method = Method(activation=Activation(kind="threshold", comparison=">=", threshold=Number(0.5)))
        assert uncovered(system(EVERYWHERE, method=method)) == {"u": None}

    @pytest.mark.parametrize("kind", ["first", "last", "highest", "lowest", "proportional"])
    def test_methods_that_choose_leave_at_least_one_rule(self, kind):
        method = Method(activation=Activation(kind=kind, count=1))
        assert uncovered(system(EVERYWHERE, method=method)) == {"u": None}

    def test_methods_that_choose_may_choose_rules_of_another_output(self):
        made = system(EVERYWHERE, method=Method(activation=Activation(kind="highest", count=1)))
        other = Output(
            name="v",
            lower=Number(0.0),
            upper=Number(1.0),
            terms=(),
            otherwise="nan",
            defuzzifier=Defuzzifier(kind="weighted_sum"),
        )
        extra = Rule(antecedent=is_("y", "up"), consequents=(Consequent(output="v", term=mf("constant", 1)),))
        changed = FuzzySystem(
            **{k: getattr(made, k) for k in names_of(type(made))}
            | {"outputs": (*made.outputs, other), "blocks": (*made.blocks, extra)}
        )
        assert isinstance(uncovered(changed)["u"], Undecided)

    def test_of_outputs_that_are_read_the_range_is_known(self):
        def chain(term, otherwise):
            made = system(
                EVERYWHERE[:1], otherwise=otherwise, terms={"low": mf("ramp", 9, 8), "some": mf("ramp", 4, 0)}
            )
            last = Output(
                name="v", lower=Number(0.0), upper=Number(1.0), terms=(), defuzzifier=Defuzzifier(kind="weighted_sum")
            )
            extra = Rule(antecedent=is_("u", term), consequents=(Consequent(output="v", term=mf("constant", 1)),))
            fields = {k: getattr(made, k) for k in names_of(type(made))}
            return FuzzySystem(**fields | {"outputs": (*made.outputs, last), "blocks": (*made.blocks, extra)})

        assert uncovered(chain("low", Number(0.0)))["v"] is None
        undecided = uncovered(chain("some", Number(0.0)))["v"]
        assert isinstance(undecided, Undecided)
        assert "all that is known of u" in undecided.reason
        undecided = uncovered(chain("low", "nan"))["v"]
        assert isinstance(undecided, Undecided)
        assert "'u', which may have no value" in undecided.reason
        assert output_bounds(chain("low", "nan"))["v"].hi == pytest.approx(1.0)

    def test_a_function_on_an_unbounded_input_is_known_to_be_a_degree(self):
        made = system([(is_("x", "f"), LINE, 1.0)], extrapolate=True)
        wave = Term(name="f", membership=function(Binary("+", Number(2.0), Binary("*", Number(0.0), X))))
        inputs = tuple(i.model_copy(update={"terms": (*i.terms, wave)}) if i.name == "x" else i for i in made.inputs)
        changed = FuzzySystem(**{k: getattr(made, k) for k in names_of(type(made))} | {"inputs": inputs})
        assert isinstance(uncovered(changed)["u"], Undecided)
