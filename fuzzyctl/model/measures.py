"""Measures of loops: numbers that a run is judged by."""

from __future__ import annotations

from typing import Final

from fuzzyctl.model.forms import Form


def _measure(form: str, what: str, *signals: str, **settings: float) -> Form:
    """Return a measure; each may be limited to the samples with begin <= t <= end."""
    return Form(form, what, signals, {**settings, "begin": 0.0, "end": float("inf")})


_BOTH = ("y", "reference")

#: The measures by name. Every one takes `begin=` and `end=` as well: only samples between these times count.
MEASURES: Final[dict[str, Form]] = {
    "overshoot": _measure(
        "overshoot(y, reference)",
        "how far y goes beyond the last value of the reference, as a part of the step from the first value of y to it; "
        "0 where it does not",
        *_BOTH,
    ),
    "rise_time": _measure(
        "rise_time(y, reference, low=10 %, high=90 %)",
        "the time from low to high, parts of the step from the first value of y to the last one of the reference [s]",
        *_BOTH,
        low=0.1,
        high=0.9,
    ),
    "settling": _measure(
        "settling(y, reference, band=2 %)",
        "the time from begin until y stays within the band around the last value of the reference, the band as a part "
        "of the step from the first value of y to it [s]; inf where it does not settle",
        *_BOTH,
        band=0.02,
    ),
    "steady_state_error": _measure(
        "steady_state_error(y, reference)", "the mean of reference - y over the last twentieth of the time", *_BOTH
    ),
    "iae": _measure("iae(y, reference)", "the integral of abs(reference - y)", *_BOTH),
    "ise": _measure("ise(y, reference)", "the integral of (reference - y)^2", *_BOTH),
    "itae": _measure("itae(y, reference)", "the integral of (t - begin) abs(reference - y)", *_BOTH),
    "integral": _measure("integral(x)", "the integral of x", "x"),
    "effort": _measure("effort(u)", "the integral of u^2", "u"),
    "maximum": _measure("maximum(x)", "the largest value of x", "x"),
    "minimum": _measure("minimum(x)", "the smallest value of x", "x"),
    "final": _measure("final(x)", "the last value of x", "x"),
    "mean": _measure("mean(x)", "the integral of x divided by the time", "x"),
    "rms": _measure("rms(x)", "the root of the mean of x^2", "x"),
}
