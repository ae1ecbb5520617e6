"""The same statements in another order: the same numbers, and fewer of them at the same time."""

from __future__ import annotations

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl.expr import Binary, Name, Number, names_in
from fuzzyctl.kernels.backends.numpy.backend import _most_alive, compile_batch
from fuzzyctl.kernels.program.passes.schedule import late
from fuzzyctl.kernels.program.program import Assign, Program, Refuse
from tests.shipped import SYSTEMS


def program(*body: Assign | Refuse) -> Program:
    return Program(("x0",), 0, (), body, (Name("v9"),))


def test_a_value_stands_right_before_it_is_needed() -> None:
    a, b, unused = (Assign(f"v{k}", Binary("*", Number(float(k)), Name("x0"))) for k in (1, 2, 3))
    last = Assign("v9", Binary("-", Binary("/", Name("v2"), Name("v4")), Name("v1")))
    middle = Assign("v4", Binary("*", Name("v2"), Name("v2")))
    assert late(program(a, b, unused, middle, last)).body == (b, middle, a, last)


def test_summands_do_not_wait_for_each_other() -> None:
    parts = [Assign(f"v{k}", Binary("*", Number(float(k)), Name("x0"))) for k in (1, 2, 3, 4)]
    total = Name("v1")
    for part in parts[1:]:
        total = Binary("+", total, Name(part.name))
    found = late(program(*parts, Assign("v9", total)))
    assert [s.name for s in found.body] == ["v1", "v2", "v9_0", "v3", "v9_1", "v4", "v9"]
    assert _most_alive(found) < _most_alive(program(*parts, Assign("v9", total)))


def test_a_refusal_keeps_its_place() -> None:
    given = program(Assign("v1", Number(1.0)), Refuse(Name("v1"), "u"), Assign("v9", Name("x0")))
    assert late(given) is given


def test_a_long_chain_needs_no_recursion() -> None:
    body = [Assign("v0", Name("x0"))]
    body += [Assign(f"v{k + 1}", Binary("*", Name(f"v{k}"), Number(1.0))) for k in range(5000)]
    long = Program(("x0",), 0, (), tuple(reversed(body)), (Name("v5000"),))
    assert late(long).body == tuple(body)


@pytest.mark.parametrize("path", SYSTEMS, ids=lambda p: p.stem)
def test_shipped_systems_compute_the_same_bit_for_bit(path: object, monkeypatch: pytest.MonkeyPatch) -> None:
    kernel = fuzzyctl.compile(fuzzyctl.load(str(path)), "numpy", algorithm="rules")
    given = kernel.algorithm.many
    found = late(given)
    written = set(given.arguments)
    for s in found.body:
        if isinstance(s, Assign):
            assert {n.name for n in names_in(s.value)} <= written
            written.add(s.name)
    if kernel.n_states:
        return
    points = np.random.default_rng(1).uniform(-1.5, 1.5, (1000, len(kernel.input_names)))
    as_given, as_found = np.empty((1000, 1)), np.empty((1000, 1))
    compile_batch(given, kernel.input_names)(points, None, as_found)
    monkeypatch.setattr("fuzzyctl.kernels.backends.numpy.backend.late", lambda p: p)
    compile_batch(given, kernel.input_names)(points, None, as_given)
    np.testing.assert_array_equal(as_found, as_given)
