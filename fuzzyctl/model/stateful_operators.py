"""Operators of controllers that keep a state."""

from __future__ import annotations

from typing import Final

from fuzzyctl.records import record


@record(frozen=True)
class Operator:
    """An operator with state.

    Args:
        settings: Names of its arguments behind the first one, in order; each may be given by name.
        needed: How many of them must be given.
        form: How it is written.
        what: Its result.
    """

    settings: tuple[str, ...]
    needed: int
    form: str
    what: str


#: The operators by name.
OPERATORS: Final[dict[str, Operator]] = {
    "previous": Operator(("start",), 0, "previous(x, start=0)", "x of the step before"),
    "difference": Operator((), 0, "difference(x)", "x minus x of the step before, 0 at the first step"),
    "derivative": Operator(("filter",), 0, "derivative(x, filter=0 s)", "difference(x) / dt through a lag"),
    "integral": Operator(
        ("start", "hold"), 0, "integral(x, start=0, hold=CONDITION)", "the sum of dt x of the steps before"
    ),
    "lowpass": Operator(("time",), 1, "lowpass(x, time)", "x through a lag of first order"),
    "rate_limit": Operator(("rate",), 1, "rate_limit(x, rate)", "x with a bounded change per second"),
    "hysteresis": Operator(
        ("low", "high", "start"), 2, "hysteresis(x, low, high, start=0)", "1 from x >= high until x <= low, else 0"
    ),
    "delay": Operator(("samples", "start"), 1, "delay(x, samples, start=0)", "x of some steps before"),
}
