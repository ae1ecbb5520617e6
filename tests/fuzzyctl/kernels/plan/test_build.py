import math

import pytest

from fuzzyctl import compile, loads
from fuzzyctl.diagnostics.diagnostic import DiagnosticError, UnknownNameError
from fuzzyctl.expr import Binary, Name
from fuzzyctl.kernels.plan.build import SetPlan, plan
from fuzzyctl.model.method import Defuzzifier
from fuzzyctl.model.rule import Is
from tests.own_fields import names_of


class TestPlan:
    def test_holds_each_degree_and_each_antecedent_once(self, ais):
        found = plan(ais)
        assert len(found.rules) == 25
        assert len(found.degrees) == 10
        assert len(found.strengths) == 25
        assert found.strengths[0] == Binary("*", Name("d0"), Name("d1"))

    def test_rules_with_the_same_antecedent_share_a_strength(self, gappy):
        found = plan(gappy())
        assert [r.weight for r in found.rules] == [1.0, 1.0, 0.5]
        assert [len(o.implied) for o in found.outputs] == [2, 2]

    def test_equal_systems_have_equal_plans_that_hash(self, gappy):
        assert plan(gappy()) == plan(gappy())
        assert hash(plan(gappy())) == hash(plan(gappy()))
        assert plan(gappy("else nan")) != plan(gappy("else 3"))

    def test_params_are_numbers_by_then(self):
        text = """
system s
defuzzifier weighted_average
param top = 2 * 3
input x in [0, top]
  a = triangle(-inf, 0, top)
  b = triangle(0, top, inf)
output u in [0, 1] else (top)
  A = singleton(top / 12)
if x is a then u is A weight (top / 12)
if x is b then u is A
"""
        found = plan(loads(text))
        assert found.inputs[0].upper == 6.0
        assert found.rules[0].weight == 0.5
        assert found.outputs[0].terms[0].parameters == (0.5,)
        assert found.outputs[0].otherwise == 6.0

    def test_the_peak_of_a_plateau_is_its_middle(self, tipper):
        found = plan(tipper)
        rancid = next(d.set for d in found.degrees if d.term == "rancid")
        assert rancid.peak == 0.5
        assert rancid.vertices[-1] == (3.0, 0.0)

    def test_else_has_one_form_each(self, gappy):
        assert plan(gappy("else midpoint")).outputs[0].otherwise == 50.0
        assert math.isnan(plan(gappy("else nan")).outputs[0].otherwise)
        assert plan(gappy("else error")).outputs[0].otherwise == "error"
        assert plan(gappy("")).outputs[0].otherwise is None

    def test_names_that_are_not_declared_are_refused(self, ais):
        from fuzzyctl.model.rule import Consequent, Rule

        def with_rule(antecedent, term="ZO"):
            rule = Rule(antecedent=antecedent, consequents=(Consequent(output="f", term=term),))
            return ais.model_copy(update={"blocks": (rule,)})

        fresh = type(ais)(**{k: getattr(ais, k) for k in names_of(type(ais))})
        assert plan(fresh) == plan(ais)
        for antecedent, term in (
            (Is(variable="sgma", term="NB"), "ZO"),
            (Is(variable="sigma", term="NM"), "ZO"),
            (Is(variable="sigma", term="NB"), "ZZ"),
        ):
            changed = with_rule(antecedent, term)
            changed = type(ais)(**{k: getattr(changed, k) for k in names_of(type(ais))})
            with pytest.raises(UnknownNameError):
                plan(changed)

    def test_adaptive_consequents_need_an_average(self, adaptive):
        method = adaptive.method.model_copy(update={"defuzzifier": Defuzzifier(kind="centroid", resolution=10)})
        with pytest.raises(DiagnosticError, match="adaptive"):
            plan(adaptive.model_copy(update={"method": method}))

    def test_a_centroid_needs_sets_with_area(self, gappy):
        method = gappy().method.model_copy(update={"defuzzifier": Defuzzifier(kind="centroid")})
        with pytest.raises(DiagnosticError, match="a singleton has no area"):
            plan(gappy().model_copy(update={"method": method}))

    def test_a_valley_between_tops_is_no_side(self):
        assert SetPlan("piecewise", (0.0, 0.0, 1.0, 1.0, 2.0, 1.0, 3.0, 0.0)).has_sides
        assert not SetPlan("piecewise", (0.0, 0.0, 1.0, 1.0, 2.0, 0.0, 3.0, 1.0)).has_sides
        assert not SetPlan("piecewise", (0.0, 1.0, 1.0, 0.0, 2.0, 1.0)).has_sides

    @pytest.mark.parametrize("corners", ["0, 0, 1, 1, 2, 0, 3, 1", "0, 1, 1, 0, 2, 1"])
    def test_a_batch_falls_into_valleys(self, corners):
        system = loads(
            f"""
system s
and einstein_product
input x in [0, 3]
  w = piecewise({corners})
output u in [0, 1] else nan
  A = triangle(0, 0.5, 1)
  B = triangle(0, 0, 0.5)
if x is w and x is very w then u is A
if x is somewhat w then u is B
"""
        )
        points = [[x / 10] for x in range(31)]
        kernel = compile(system, backend="numpy")
        alone = [compile(system, backend="python")(*p) for p in points]
        assert kernel.batch(points) == pytest.approx(alone, rel=1e-12, nan_ok=True)
