"""What statements read, write and contain, for every kind of statement."""

from typing import get_args

import pytest

from fuzzyctl import loads
from fuzzyctl.expr import Name, Number
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.program.program import (
    STATE,
    Accumulate,
    Assign,
    Between,
    Fold,
    Item,
    Locate,
    Offset,
    Place,
    Program,
    Quadrature,
    Refuse,
    Statement,
)
from fuzzyctl.kernels.program.traversal import (
    expressions,
    locals_of,
    map_expressions,
    map_names,
    parts,
    reads,
    rebuilt,
    statements,
    writes,
)
from tests.bench.growth import complete
from tests.frozen.systems import SYSTEMS

A, B, X = Name("a"), Name("b"), Name("x")
ONE_MORE = Assign("b", A + X)
LOOP_ITEM = Item("T", "k")

#: A statement of each kind, with what it writes, reads and names inside only.
KINDS = [
    (Assign("a", X + Item("T", Place("p"))), {"a"}, {"x", "T", "p"}, set()),
    (Locate("p", "r", X, "T", (0.0, 1.0), 1), {"p", "r"}, {"x", "T"}, set()),
    (Offset("q", (("p", 1), ("o", 3))), {"q"}, {"p", "o"}, set()),
    (Accumulate(3, "k", (Assign("a", LOOP_ITEM),), (Assign("s", A + X),)), {"s"}, {"T", "x"}, {"k", "a"}),
    (Fold(3, "k", (Assign("c", X),), (Assign("a", Name("c")),), (Assign("c", A),)), {"c"}, {"x"}, {"k", "a"}),
    (
        Between("v", "i", X, (Offset("q", (("p", 1), ("i", 2))),), Item("T", Place("q"))),
        {"v"},
        {"x", "p", "T"},
        {"i", "q"},
    ),
    (
        Quadrature("f", "s", "half", "x", (ONE_MORE,), B, ("a",), "T", (Name("m"),)),
        {"f", "s"},
        {"a", "T", "m"},
        {"x", "b"},
    ),
    (Refuse(X, "u"), set(), {"x"}, set()),
]
IDS = [type(case[0]).__name__ for case in KINDS]


def programs(text: str) -> list[Program]:
    planned = plan(loads(text))
    chosen = algorithm_of(planned)
    forms = [
        chosen.point,
        chosen.printed,
        chosen.interpreted,
        chosen.many,
        chosen.arrays,
    ]
    return [*forms, inference.trace(planned)]


def test_there_is_a_case_for_every_kind():
    assert {type(case[0]) for case in KINDS} == set(get_args(Statement))


@pytest.mark.parametrize(("statement", "given", "taken", "inside"), KINDS, ids=IDS)
class TestEveryKind:
    def test_writes(self, statement, given, taken, inside):
        assert writes(statement) == given

    def test_reads(self, statement, given, taken, inside):
        assert reads(statement) == taken

    def test_names_inside_only(self, statement, given, taken, inside):
        assert locals_of(statement) == inside

    def test_is_rebuilt_as_it_is(self, statement, given, taken, inside):
        assert rebuilt(statement, lambda value: value) == statement

    def test_all_its_names_can_be_changed(self, statement, given, taken, inside):
        (other,) = map_names(Program((), 0, (), (statement,), ()), "R".__add__).body
        assert (writes(other), reads(other), locals_of(other)) == tuple(
            {"R" + name for name in names} for names in (given, taken, inside)
        )

    def test_all_its_expressions_can_be_changed(self, statement, given, taken, inside):
        program = Program((), 0, (), (statement,), ())
        changed = map_expressions(program, lambda node: Number(7.0) if isinstance(node, Name | Item) else node)
        assert not [e for e in expressions(changed) if isinstance(e, Name | Item)]


@pytest.mark.parametrize("text", [*SYSTEMS.values(), complete(8, 2, "product", "weighted_average")])
def test_what_a_statement_reads_has_been_written_before(text):
    for program in programs(text):
        known = {*program.arguments, STATE, *(name for name, _ in program.tables)}
        for statement in program.body:
            assert reads(statement) <= known
            known |= writes(statement)
        assert all(reads(Assign("result", value)) <= known for value in program.results)


def test_statements_come_before_those_inside_them():
    loop = KINDS[IDS.index("Accumulate")][0]
    assert list(statements([loop, ONE_MORE])) == [loop, *parts(loop).inner, ONE_MORE]
