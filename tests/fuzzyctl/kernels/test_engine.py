"""What the whole language means, one construct after the other, on small systems with numbers worked out by hand."""

import math

import numpy as np
import pytest

from fuzzyctl.diagnostics.diagnostic import DiagnosticError, NoRuleFiresError, UnknownNameError
from fuzzyctl.expr import COMPARISONS, FUNCTIONS, Binary, Call, Name, Number
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.compile import degrees
from fuzzyctl.kernels.plan.build import OutputCycleError, plan
from fuzzyctl.model.block import Hedge, Param
from fuzzyctl.model.method import Activation, Defuzzifier, Method
from fuzzyctl.model.rule import And, Cell, Consequent, Is, Rule, RuleTable
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Membership, Output, Term
from tests import sizes

UP = Membership(kind="ramp", arguments=(Number(0.0), Number(1.0)))
DOWN = Membership(kind="ramp", arguments=(Number(1.0), Number(0.0)))
MIDDLE = Membership(kind="triangle", arguments=(Number(0.0), Number(0.5), Number(1.0)))
AVERAGE = Defuzzifier(kind="weighted_average")


def mf(kind, *numbers, height=1.0):
    return Membership(kind=kind, arguments=tuple(Number(float(n)) for n in numbers), height=Number(height))


def input_(name, **terms):
    own = tuple(Term(name=n, membership=m) for n, m in ({"up": UP, "down": DOWN, "middle": MIDDLE} | terms).items())
    return Input(name=name, lower=Number(0.0), upper=Number(1.0), terms=own)


def output(name="u", lower=-10.0, upper=10.0, otherwise="nan", terms=None, **own):
    made = tuple(Term(name=n, membership=m) for n, m in (terms or {}).items())
    return Output(name=name, lower=Number(lower), upper=Number(upper), terms=made, otherwise=otherwise, **own)


def rule(antecedent, *consequents, weight=1.0):
    made = tuple(Consequent(output=o, term=t) for o, t in consequents)
    return Rule(antecedent=antecedent, consequents=made, weight=Number(weight))


def is_(variable, term, *hedges):
    return Is(variable=variable, term=term, hedges=hedges)


def build(rules, outputs=None, inputs=("x", "y"), method=None, **rest):
    variables = tuple(input_(i) if isinstance(i, str) else i for i in inputs)
    return FuzzySystem(
        name="s",
        inputs=variables,
        outputs=tuple(outputs or (output(),)),
        method=method or Method(defuzzifier=AVERAGE),
        blocks=tuple(rules),
        **rest,
    )


@pytest.fixture(params=["python", "numpy"])
def value(request):
    """Evaluate at one point, by a scalar call and as a batch of one, which must agree."""

    def evaluate(system, *point):
        kernel = compile_system(system, request.param)
        single, batch = kernel(*point), kernel.batch([list(point)])[0]
        np.testing.assert_allclose(single, batch, rtol=1e-13)
        return single

    return evaluate


class TestConsequents:
    def test_linear_ones_have_a_coefficient_for_each_input_and_a_constant(self, value):
        system = build(
            [rule(is_("x", "up"), ("u", mf("linear", 2, -1, 3))), rule(is_("x", "down"), ("u", mf("constant", 7)))]
        )
        assert value(system, 0.25, 0.5) == pytest.approx(0.25 * (0.5 - 0.5 + 3) + 0.75 * 7)

    def test_functions_are_expressions_of_inputs_and_params(self, value):
        expr = Binary("+", Binary("*", Name("k"), Name("x")), Call("max", (Name("y"), Number(0.5), Name("x"))))
        term = Membership(kind="function", arguments=(expr,))
        system = build(
            [rule(is_("x", "up"), ("u", "f"))],
            [output(terms={"f": term})],
            params=(Param(name="k", expression=Number(4.0)),),
        )
        assert value(system, 0.25, 0.125) == pytest.approx(1.5)

    def test_they_take_the_clamped_inputs(self, value):
        system = build([rule(is_("x", "up"), ("u", mf("linear", 1, 1, 0)))])
        assert value(system, 1e9, 1e9) == 2.0

    def test_a_rule_that_does_not_fire_may_have_no_value(self, value):
        inverse = Membership(kind="function", arguments=(Binary("/", Number(1.0), Name("x")),))
        system = build([rule(is_("x", "up"), ("u", inverse)), rule(is_("x", "down"), ("u", mf("constant", 2)))])
        assert value(system, 0.0, 0.0) == 2.0
        assert value(system, 0.5, 0.0) == 2.0

    def test_one_that_fires_without_a_value_gives_none(self, value):
        root = Membership(kind="function", arguments=(Call("sqrt", (Binary("-", Name("x"), Number(2.0)),)),))
        assert math.isnan(value(build([rule(is_("x", "up"), ("u", root))]), 0.5, 0.0))

    def test_a_sum_does_not_divide(self, value):
        method = Method(defuzzifier=Defuzzifier(kind="weighted_sum"))
        system = build(
            [
                rule(is_("x", "up"), ("u", mf("linear", 0, 1, 3))),
                rule(is_("x", "down"), ("u", mf("constant", 7)), weight=0.5),
            ],
            method=method,
        )
        assert value(system, 0.25, 0.5) == pytest.approx(0.25 * 3.5 + 0.375 * 7)

    def test_fuzzy_sets_count_with_the_middle_of_their_core(self, value):
        terms = {
            "flat": mf("trapezoid", 0, 1, 3, 9),
            "edge": mf("s_shape", 0, 5),
            "hill": mf("gaussian", 4, 1, height=0.5),
        }
        system = build(
            [
                rule(is_("x", "up"), ("u", "flat")),
                rule(is_("x", "down"), ("u", "edge")),
                rule(is_("y", "up"), ("u", "hill")),
            ],
            [output(terms=terms)],
        )
        assert value(system, 0.25, 0.5) == pytest.approx((0.25 * 2 + 0.75 * 5 + 0.5 * 4) / 1.5)

    def test_an_average_never_leaves_what_it_averages(self):
        share = Membership(kind="function", arguments=(Binary("*", Number(0.3), Name("y")),))
        kernel = compile_system(build([rule(is_("x", "up"), ("u", share))] * 2), "python")
        for x in np.geomspace(5e-324, 1.0, 200):
            assert kernel(float(x), 1.0) == 0.3

    def test_an_average_of_lines_never_leaves_what_they_reach(self):
        line = mf("linear", 0, 0.3, 0)
        kernel = compile_system(build([rule(is_("x", "up"), ("u", line))] * 2), "python")
        for x in np.geomspace(5e-324, 1.0, 200):  # below 1e-300 products of activations lose digits
            assert kernel(float(x), 1.0) == pytest.approx(0.3, rel=1e-15 if x > 1e-290 else 0.5)
            assert 0.0 <= kernel(float(x), 1.0) <= 0.3

    def test_cells_of_tables_may_hold_them(self, value):
        table = RuleTable(
            outputs=("u",),
            rows=None,
            columns="x",
            row_terms=(),
            column_terms=("up", "down"),
            cells=((Cell(terms=(mf("linear", 1, 0, 0),)), Cell(terms=(mf("constant", 4),))),),
        )
        assert value(build([table]), 0.25, 0.0) == pytest.approx(0.25 * 0.25 + 0.75 * 4)

    def test_names_must_be_inputs_or_params(self):
        term = Membership(kind="function", arguments=(Name("z"),))
        with pytest.raises(UnknownNameError):
            plan(build([rule(is_("x", "up"), ("u", term))]))

    def test_compiled_code_knows_every_function_of_the_language(self):
        x, y = Name("x"), Name("y")
        calls = [Call(f, (x,)) for f in ("abs", "sqrt", "exp", "log", "sin", "cos", "tan", "sign")]
        calls += [Call("atan2", (x, y)), Call("min", (x, y, Number(0.5))), Call("max", (x, y, Number(0.5)))]
        calls += [Call(f, (Binary("*", Number(3.0), x),)) for f in ("floor", "ceil", "round")]
        calls += [Call(f, (x, y)) for f in ("mod", "fmod", *COMPARISONS)]
        calls += [Binary("/", x, y), Binary("^", x, y), Binary("/", Call("log", (x,)), y)]
        soft = Hedge(name="soft", parameter="m", expression=Call("sqrt", (Name("m"),)))
        outputs = [output(f"u{k}", otherwise=Number(-1.0)) for k in range(len(calls))]
        terms = [Membership(kind="function", arguments=(c,)) for c in calls]
        rules = [rule(is_("x", "any", "soft"), *((o.name, t) for o, t in zip(outputs, terms, strict=True)))]
        inputs = (input_("x", any=mf("trapezoid", -math.inf, 0, 1, math.inf)), input_("y"))
        system = build(rules, outputs, inputs=inputs, hedges=(soft,))
        python, compiled = compile_system(system, "python"), compile_system(system, "numba")
        assert {c.function for c in calls if isinstance(c, Call)} == set(FUNCTIONS)
        for point in ((0.25, 0.75), (0.75, 0.25), (0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (0.5, 0.5)):
            np.testing.assert_allclose(python(*point), compiled(*point), rtol=1e-13)
            if sizes.LONG:  # another compilation of five seconds
                np.testing.assert_allclose(python(*point), compiled.batch([point])[0], rtol=1e-13)


class TestTsukamoto:
    METHOD = Method(defuzzifier=Defuzzifier(kind="tsukamoto"))

    def test_takes_the_place_where_the_set_has_the_activation(self, value):
        terms = {"more": mf("ramp", 0, 8), "less": mf("ramp", 4, 0), "tall": mf("ramp", 0, 8, height=0.5)}
        rules = [rule(is_("x", "up"), ("u", "more")), rule(is_("x", "down"), ("u", "less"))]
        assert value(build(rules, [output(terms=terms)], method=self.METHOD), 0.25, 0) == pytest.approx(
            0.25 * 2 + 0.75 * 1
        )
        rules = [rule(is_("x", "up"), ("u", "tall"))]
        # Relative to the height 0.5, and no more than it.
        assert value(build(rules, [output(terms=terms)], method=self.METHOD), 0.25, 0) == pytest.approx(4)
        assert value(build(rules, [output(terms=terms)], method=self.METHOD), 0.75, 0) == pytest.approx(8)

    def test_places_stay_in_the_range(self, value):
        system = build(
            [rule(is_("x", "up"), ("u", "s"))], [output(terms={"s": mf("sigmoid", 1, 2)})], method=self.METHOD
        )
        assert value(system, 0.5, 0) == pytest.approx(1.0)
        assert value(system, 1.0, 0) == 10.0
        assert value(system, 1e-300, 0) == -10.0

    @pytest.mark.parametrize(
        "term", [mf("triangle", 0, 1, 2), mf("gaussian", 0, 1), mf("constant", 1), mf("linear", 1, 1, 0)]
    )
    def test_needs_monotone_sets(self, term):
        with pytest.raises(DiagnosticError, match="not monotone"):
            plan(build([rule(is_("x", "up"), ("u", term))], method=self.METHOD))


class TestHybrid:
    def test_each_output_may_have_its_own_method(self, value):
        box = {"low": mf("rectangle", 0, 2), "high": mf("rectangle", 2, 4)}
        outputs = [
            output("u", 0.0, 4.0, terms=box, defuzzifier=Defuzzifier(), implication="product", aggregation="sum"),
            output("v", terms={"c": mf("constant", 5)}),
            output("w", 0.0, 4.0, terms=box, defuzzifier=Defuzzifier(resolution=4), implication="hamacher_product"),
        ]
        rules = [
            rule(is_("x", "up"), ("u", "low"), ("v", "c"), ("w", "low")),
            rule(is_("x", "down"), ("u", "high"), ("w", "high")),
        ]
        found = value(build(rules, outputs), 0.25, 0)
        assert found == pytest.approx((0.25 * 1 + 0.75 * 3, 5.0, 0.25 * 1 + 0.75 * 3))

    def test_maxima_need_a_resolution_with_other_norms(self):
        own = {"implication": "einstein_product", "defuzzifier": Defuzzifier(kind="mom")}
        with pytest.raises(DiagnosticError, match="with 'einstein_product' and 'max' has no closed form"):
            plan(build([rule(is_("x", "up"), ("u", "m"))], [output(terms={"m": MIDDLE}, **own)]))

    def test_averages_need_finite_peaks(self):
        with pytest.raises(DiagnosticError, match="no finite peak"):
            plan(build([rule(is_("x", "up"), ("u", mf("sigmoid", 0, 1)))]))

    def test_heights_lower_consequent_sets(self, value):
        sets = {"low": mf("rectangle", 0, 2, height=0.5), "high": mf("rectangle", 2, 4)}
        rules = [rule(is_("x", "up"), ("u", "low")), rule(is_("x", "up"), ("u", "high"))]
        for defuzzifier in (Defuzzifier(), Defuzzifier(resolution=4)):
            system = build(rules, [output("u", 0.0, 4.0, terms=sets, defuzzifier=defuzzifier)])
            assert value(system, 1.0, 0.0) == pytest.approx((0.5 * 1 + 3) / 1.5)


class TestAntecedents:
    def test_heights_lower_degrees(self, value):
        low = input_("x", low=mf("ramp", 0, 1, height=0.5))
        rules = [rule(is_("x", "low"), ("u", mf("constant", 1))), rule(is_("y", "up"), ("u", mf("constant", 0)))]
        assert value(build(rules, inputs=(low, "y")), 1.0, 1.0) == pytest.approx(0.5 / 1.5)

    @pytest.mark.parametrize(
        ("hedges", "expected"),
        [
            (("very",), 0.0625),
            (("not", "very"), 0.9375),
            (("very", "not"), 0.5625),
            (("any",), 1.0),
            (("half",), 0.125),
        ],
    )
    def test_hedges_apply_from_the_term_outwards(self, value, hedges, expected):
        half = Hedge(name="half", parameter="m", expression=Binary("/", Name("m"), Name("two")))
        params = (Param(name="two", expression=Number(2.0)),)
        method = Method(defuzzifier=Defuzzifier(kind="weighted_sum"))
        rules = [rule(is_("x", "up", *hedges), ("u", mf("constant", 1)))]
        assert value(build(rules, method=method, hedges=(half,), params=params), 0.25, 0.0) == pytest.approx(expected)

    def test_hedges_of_the_users_own_are_held_between_zero_and_one(self, value):
        wild = Hedge(name="wild", parameter="m", expression=Call("log", (Binary("-", Name("m"), Number(0.5)),)))
        twice = Hedge(name="twice", parameter="m", expression=Binary("*", Number(2.0), Name("m")))
        method = Method(defuzzifier=Defuzzifier(kind="weighted_sum"))
        rules = [rule(is_("x", "up", h), ("u", mf("constant", c))) for h, c in (("wild", 100), ("twice", 1))]
        system = build(rules, [output(otherwise=Number(0.0))], method=method, hedges=(wild, twice))
        assert [value(system, x, 0.0) for x in (0.0, 0.25, 0.75)] == [0.0, 0.5, 1.0]

    def test_unknown_hedges_are_refused(self):
        with pytest.raises(UnknownNameError):
            plan(build([rule(is_("x", "up", "vry"), ("u", mf("constant", 1)))]))

    def test_terms_may_be_functions_of_their_variable(self, value):
        wave = Membership(kind="function", arguments=(Binary("*", Number(2.0), Name("x")),), height=Number(0.8))
        method = Method(defuzzifier=Defuzzifier(kind="weighted_sum"))
        system = build([rule(is_("x", "f"), ("u", mf("constant", 1)))], inputs=(input_("x", f=wave),), method=method)
        assert [value(system, x) for x in (0.25, 0.75)] == pytest.approx([0.4, 0.8])

    def test_long_conjunctions_of_any_norm_stay_short_programs(self):
        both = And(operands=tuple(is_(v, t) for v in ("x", "y") for t in ("up", "middle", "down")) * 4)
        for norm in ("hamacher_product", "einstein_product", "nilpotent_minimum"):
            method = Method(conjunction=norm, defuzzifier=AVERAGE)
            kernel = compile_system(build([rule(both, ("u", mf("constant", 1)))], method=method), "python")
            assert len(kernel.source) < 12_000
            assert kernel(0.5, 0.5) in (1.0, pytest.approx(1.0)) or math.isnan(kernel(0.5, 0.5))


class TestChains:
    def chain(self, otherwise="nan", last=None):
        terms = {"small": DOWN, "large": UP}
        outputs = [
            output("v", terms={"n": mf("constant", 1), "p": mf("constant", 3)}, otherwise=last),
            output("u", 0.0, 1.0, terms=terms, otherwise=otherwise),
        ]
        rules = [
            rule(is_("u", "small"), ("v", "n")),
            rule(is_("u", "large"), ("v", "p")),
            rule(is_("x", "middle"), ("u", mf("linear", 1, 0, 0))),
        ]
        return build(rules, outputs, inputs=("x", "y"))

    def test_an_output_in_an_antecedent_is_its_value_of_this_evaluation(self, value):
        assert value(self.chain(), 0.25, 0.0) == pytest.approx((0.75 * 1 + 0.25 * 3, 0.25))
        assert plan(self.chain()).order == (1, 0)

    def test_its_value_counts_within_its_range(self, value):
        system = self.chain(otherwise=Number(7.0))
        assert value(system, 0.0, 0.0) == (3.0, 7.0)

    def test_no_value_goes_on_to_those_that_read_it(self, value):
        assert np.isnan(value(self.chain(), 0.0, 0.0)).all()
        assert np.isnan(value(self.chain(last="error"), 0.0, 0.0)).all()
        assert np.isnan(value(self.chain(last=Number(2.0)), 0.0, 0.0)).all()

    def test_compiled_code_chains_as_well(self):
        python, compiled = (compile_system(self.chain(last=Number(2.0)), b) for b in ("python", "numba"))
        for x in (0.0, 0.25, 0.5, math.nan):
            np.testing.assert_array_equal(python(x, 0.0), compiled(x, 0.0))
            np.testing.assert_array_equal(python(x, 0.0), compiled.batch([[x, 0.0]])[0])
        with pytest.raises(NoRuleFiresError, match="'u'"):
            compile_system(self.chain(otherwise="error"), "numba").batch([[0.5, 0.0], [0.0, 0.0]])

    def test_a_broken_promise_is_reported_with_the_system_that_broke_it(self, value):
        with pytest.raises(NoRuleFiresError, match="'u'"):
            value(self.chain(otherwise=None), 0.0, 0.0)
        with pytest.raises(NoRuleFiresError, match="'u'"):
            value(self.chain(otherwise="error"), 0.0, 0.0)

    def test_circles_are_refused(self):
        terms = {"a": UP}
        outputs = [output("u", terms=terms), output("v", terms=terms), output("w", terms=terms)]
        rules = [rule(is_("v", "a"), ("u", "a")), rule(is_("u", "a"), ("v", "a")), rule(is_("x", "up"), ("w", "a"))]
        with pytest.raises(OutputCycleError, match="u → v → u"):
            plan(build(rules, outputs))

    def test_methods_that_compare_rules_do_not_go_with_chains(self):
        method = Method(defuzzifier=AVERAGE, activation=Activation(kind="highest", count=1))
        with pytest.raises(DiagnosticError, match="compares all rules"):
            plan(self.chain().model_copy(update={"method": method}))

    def test_terms_read_must_be_fuzzy_sets(self):
        outputs = [output("u", terms={"f": mf("linear", 1, 1, 0)}), output("v")]
        rules = [rule(is_("x", "up"), ("u", "f")), rule(is_("u", "f"), ("v", mf("constant", 1)))]
        with pytest.raises(DiagnosticError, match="function of the inputs"):
            plan(build(rules, outputs))

    def test_an_adaptive_output_may_read_another(self, tmp_path):
        own = {"terms": {"n": mf("constant", -1), "p": mf("constant", 1)}, "adaptive": Name("x")}
        outputs = [output("u", 0.0, 1.0, terms={"small": DOWN, "large": UP}), output("v", **own)]
        rules = [
            rule(is_("x", "up"), ("u", mf("linear", 1, 0, 0))),
            rule(is_("u", "small"), ("v", "n")),
            rule(is_("u", "large"), ("v", "p")),
        ]
        kernel = compile_system(build(rules, outputs), "numpy")
        assert kernel(0.25, 0.0, kernel.start())[1] == pytest.approx(-0.5)
        xi = np.empty(2)
        kernel.jit_strengths(0.25, 0.0, xi)
        assert xi == pytest.approx([0.75, 0.25])


class TestActivation:
    """Four rules with activations x, 0.5, y and 0.25 and the consequents 1, 10, 100 and 1000 of a weighted sum."""

    def system(self, **activation):
        fixed = Membership(kind="function", arguments=(Number(0.5),))
        inputs = (input_("x", half=fixed), input_("y"))
        strengths = [(is_("x", "up"), 1.0), (is_("x", "half"), 1.0), (is_("y", "up"), 1.0), (is_("x", "half"), 0.5)]
        rules = [
            rule(antecedent, ("u", mf("constant", 10**k)), weight=weight)
            for k, (antecedent, weight) in enumerate(strengths)
        ]
        method = Method(defuzzifier=Defuzzifier(kind="weighted_sum"), activation=Activation(**activation))
        return build(rules, [output(otherwise=Number(0.0))], inputs=inputs, method=method)

    @pytest.mark.parametrize(
        ("activation", "point", "acting"),
        [
            ({"kind": "general"}, (0.3, 0.7), [0.3, 0.5, 0.7, 0.25]),
            ({"kind": "first", "count": 1}, (0.3, 0.7), [0.3, 0, 0, 0]),
            ({"kind": "first", "count": 2}, (0.0, 0.7), [0, 0.5, 0.7, 0]),
            ({"kind": "first", "count": 2, "threshold": Number(0.5)}, (0.3, 0.7), [0, 0.5, 0.7, 0]),
            ({"kind": "first", "count": 9}, (0.3, 0.7), [0.3, 0.5, 0.7, 0.25]),
            ({"kind": "last", "count": 1}, (0.3, 0.7), [0, 0, 0, 0.25]),
            ({"kind": "last", "count": 2, "threshold": Number(0.3)}, (0.3, 0.7), [0, 0.5, 0.7, 0]),
            ({"kind": "highest", "count": 1}, (0.3, 0.7), [0, 0, 0.7, 0]),
            ({"kind": "highest", "count": 2}, (0.3, 0.7), [0, 0.5, 0.7, 0]),
            ({"kind": "highest", "count": 1}, (0.5, 0.5), [0.5, 0, 0, 0]),
            ({"kind": "highest", "count": 4}, (0.3, 0.7), [0.3, 0.5, 0.7, 0.25]),
            ({"kind": "lowest", "count": 1}, (0.0, 0.7), [0, 0, 0, 0.25]),
            ({"kind": "lowest", "count": 2}, (0.5, 0.0), [0.5, 0, 0, 0.25]),
            ({"kind": "proportional"}, (0.5, 0.75), [0.25, 0.25, 0.375, 0.125]),
            ({"kind": "threshold", "comparison": ">=", "threshold": Number(0.5)}, (0.3, 0.7), [0, 0.5, 0.7, 0]),
            ({"kind": "threshold", "comparison": ">", "threshold": Number(0.5)}, (0.3, 0.7), [0, 0, 0.7, 0]),
            ({"kind": "threshold", "comparison": "<", "threshold": Number(0.5)}, (0.3, 0.7), [0.3, 0, 0, 0.25]),
            ({"kind": "threshold", "comparison": "!=", "threshold": Number(0.5)}, (0.3, 0.7), [0.3, 0, 0.7, 0.25]),
        ],
    )
    def test_lets_those_rules_act(self, value, activation, point, acting):
        expected = sum(a * 10**k for k, a in enumerate(acting))
        assert value(self.system(**activation), *point) == pytest.approx(expected, rel=1e-12)


class TestDegrees:
    def test_are_those_of_any_term_with_its_height(self):
        wave = Membership(kind="function", arguments=(Call("sign", (Name("x"),)),), height=Number(0.5))
        x = input_("x", f=wave, s=mf("s_shape", 0, 1, height=0.5))
        system = build([rule(is_("x", "f"), ("u", "k"))], [output(terms={"k": mf("linear", 1, 0)})], inputs=(x,))
        assert degrees(system, x, x.term("f"), [-1.0, 0.0, 0.5]).tolist() == [0.0, 0.0, 0.5]
        assert degrees(system, x, x.term("s"), [0.0, 0.5, 1.0]).tolist() == [0.0, 0.25, 0.5]
        assert degrees(system, system.outputs[0], system.outputs[0].terms[0], [0.0]) is None
