import dataclasses
import math

import pytest

from fuzzyctl.records import dataclass


@pytest.mark.parametrize(
    "options",
    [{}, {"frozen": True}, {"eq": False}, {"repr": False}, {"unsafe_hash": True}, {"frozen": True, "eq": False}],
)
@pytest.mark.parametrize("names", ["", "x", "x y"])
def test_a_dataclass_behaves_as_one_of_the_standard_library(options, names):
    def instances(decorator):
        body = {"__annotations__": dict.fromkeys(names.split(), "float")}
        kind = decorator(**options)(type("Kind", (), body))
        return [kind(*(value for _ in names.split())) for value in (1.0, 1.0, 2.0, math.nan)]

    def behaviour(a, b, c, d):
        seen = [a == b, a == c, a == 1, d == d, type(a).__hash__ is None, object.__repr__(a) == repr(a)]
        if type(a).__repr__ is not object.__repr__:
            seen.append(repr(a))
        if type(a).__hash__ not in (None, object.__hash__):
            seen += [hash(a), len({a, b, c})]
        try:
            a.x = 3.0
        except dataclasses.FrozenInstanceError as error:
            seen.append(str(error))
        return seen

    assert behaviour(*instances(dataclass)) == behaviour(*instances(dataclasses.dataclass))


def test_a_method_of_the_class_is_left_alone():
    @dataclass(frozen=True)
    class Named:
        name: str
        mark: object = dataclasses.field(default=None, compare=False, repr=False)

        def __repr__(self):
            return self.name

    assert (repr(Named("a")), Named("a", 1) == Named("a", 2), len({Named("a", 1), Named("a", 2)})) == ("a", True, 1)
