"""Functions whose names are free for params and inputs: a parenthesis tells a function from a name."""

import pytest

from fuzzyctl import DiagnosticError, compile, dumps, loads
from fuzzyctl.expr import FUNCTIONS, SOFT

TEXT = """\
system t
defuzzifier weighted_average
param {name} = 2
input lt in [0, 4]
  floor = function(le(lt, {name}) / 2)
  gt = function(gt(lt, {name}) * {name} / 2)
input eq in [0, 4]
output u in [-9, 9]
if lt is floor then u is function({name} * lt({name}, eq) + floor(eq))
if lt is gt then u is function(ne(eq, lt))
"""


def test_names_and_functions_stand_beside_each_other():
    text = TEXT.format(name="floor")
    kernel = compile(loads(text), backend="python")
    assert [kernel(lt, eq) for lt, eq in ((1.0, 2.5), (1.0, 1.5), (3.0, 2.5), (3.0, 3.0))] == [4.0, 1.0, 1.0, 0.0]
    again = dumps(loads(text))
    assert loads(again) == loads(text)


@pytest.mark.parametrize("name", sorted(SOFT))
def test_params_may_have_any_of_their_names(name):
    if name not in ("lt", "eq"):
        assert compile(loads(TEXT.format(name=name)), backend="python")(1.0, 2.5) == 4.0


@pytest.mark.parametrize("name", sorted(SOFT))
def test_outputs_may_not_since_guarantees_call_them(name):
    with pytest.raises(DiagnosticError, match="FZ201"):
        loads(TEXT.format(name="a").replace("output u", f"output {name}").replace("then u", f"then {name}"))


@pytest.mark.parametrize("name", sorted(FUNCTIONS.keys() - SOFT))
def test_other_functions_name_nothing_else(name):
    with pytest.raises(DiagnosticError, match="FZ201"):
        loads(TEXT.format(name=name))
