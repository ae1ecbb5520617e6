"""Params and free numbers of controllers from Python."""

import pytest

import fuzzyctl

LAW = """system rule
defuzzifier center_average
input e in [-1, 1]
  terms N P
output u in [-1, 1]
  terms N P
table u = e
  N P
| N P

controller law "A law"
input x in [0, 1]
param k in [0, 5] = 2
let a = k * rule(x)
output y = a
every 10 ms
"""


def test_numbers_of_a_called_system_are_refused_with_its_name():
    law = fuzzyctl.loads(LAW, block="law")
    with pytest.raises(fuzzyctl.UnknownNameError, match=r"no free number 'rule\.q'"):
        law.with_values({"rule.q": 1})
    with pytest.raises(fuzzyctl.UnknownNameError, match=r"'rule\.e\.N'; there are: rule\.e\.N\.left"):
        law.with_values({"rule.e.N": 1})
    with pytest.raises(fuzzyctl.ArgumentError, match="system 'rule': free number"):
        law.with_values({"rule.e.N.peak": None})
    with pytest.raises(fuzzyctl.ValueOutOfBoundsError, match="system 'rule': free number"):
        law.with_values({"rule.e.N.peak": float("nan")})


def test_params_are_set_by_one_method_for_every_block():
    law = fuzzyctl.loads(LAW, block="law")
    assert law.with_params(k=3).values == {"k": 3.0}
    with pytest.raises(fuzzyctl.DiagnosticError, match="outside of"):
        law.with_params(k=6)


def test_a_trace_of_a_tree_of_systems_is_the_step_of_the_kernel():
    one = LAW.split("controller")[0]
    tree = one + "controller tree\ninput e in [-1, 1]\nstate s = 0.5\nnext s = y\n"
    tree = fuzzyctl.loads(f"{tree}let middle = rule(e)\noutput y = rule(middle / 2) + s\nevery 1 s\n", block="tree")
    trace, kernel = fuzzyctl.why(tree, e=0.2), fuzzyctl.compile(tree, "python")
    outputs, state = kernel(0.2, kernel.start())
    assert trace.outputs == {"y": outputs}
    assert list(trace.next_state.values()) == state.tolist()
    assert trace.calls[0].trace.outputs == {"u": trace.lets["middle"]}
    assert "System rule" in str(trace)
