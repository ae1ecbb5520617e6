import pytest

from tests.fuzzyctl.codegen.steps.targets import unit_of


def slots(lines):
    unit = unit_of(f"controller c\ninput x\n{lines}\nevery 1 s\n")
    return [(s.name, s.start, s.length) for s in unit.slots]


def test_a_delay_is_one_slot():
    assert slots("output y = delay(x, 4, start=-1)") == [("delay#1", -1.0, 4)]


def test_a_short_delay_is_shifted():
    assert slots("output y = delay(x, 3)") == [(f"delay#1.{k}", 0.0, 1) for k in range(3)]


def test_delays_of_each_other_are_one():
    ((*_, length),) = slots("output y = delay(delay(x, 3), 2)")
    assert length == 5


@pytest.mark.parametrize(
    ("lines", "lengths"),
    [
        ("state a = 0\nstate b = 0\nstate d = 0\nstate f = 0\nnext a = x\nnext b = a\nnext d = b\nnext f = d", [4]),
        ("state a = 0\nstate b = 0\nstate d = 1\nstate f = 0\nnext a = x\nnext b = a\nnext d = b\nnext f = d", [1] * 4),
        (
            "state a = 0\nstate b = -0.0\nstate d = 0\nstate f = 0\nnext a = x\nnext b = a\nnext d = b\nnext f = d",
            [1] * 4,
        ),
        ("state a = 0\nstate b = 0\nstate d = 0\nstate f = 0\nnext a = f\nnext b = a\nnext d = b\nnext f = d", [4]),
    ],
)
def test_states_that_pass_a_number_on_from_one_start_are_one_slot(lines, lengths):
    assert [length for *_, length in slots(f"{lines}\noutput y = f")] == lengths


def test_a_chain_ends_where_a_number_inside_it_is_read():
    lines = "state a = 0\nstate b = 0\nstate d = 0\nstate f = 0\nstate g = 0\n"
    lines += "next a = x\nnext b = a\nnext d = b\nnext f = d\nnext g = f\noutput y = g + a"
    assert [(name, length) for name, _, length in slots(lines)] == [("a", 1), ("b", 4)]
