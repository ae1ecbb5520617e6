"""Picture of a term as SVG, for hovers: its degrees over the range of its variable, the other terms beside it."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from typing import Final
from xml.sax.saxutils import escape

from fuzzyctl.formulas import is_number
from fuzzyctl.kernels.compile import degree_function
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable, Term

_WIDTH, _HEIGHT, _MARGIN, _POINTS = 260, 80, 14, 131
_STRONG, _PALE, _GREY = "#2b7bba", "#9aa7b0", "#808080"
#: Most other terms that are drawn.
_MOST: Final = 15


def picture(system: FuzzySystem, variable: LinguisticVariable, term: Term) -> str:
    """Return the picture of a term as an SVG; an empty text for a function of the inputs."""
    low, high = system.number(variable.lower), system.number(variable.upper)
    if not high - low > 0.0 or high - low == float("inf"):
        return ""
    xs = [low + (high - low) * k / (_POINTS - 1) for k in range(_POINTS)]
    if not _line(system, variable, term, xs, (low, high)):
        return ""
    lines = []
    for other in (*[t for t in variable.terms if t is not term][:_MOST], term):
        points = _line(system, variable, other, xs, (low, high))
        color, width = (_STRONG, 2.5) if other is term else (_PALE, 1)
        if points:
            lines.append(f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="{width}"/>')
    base = _HEIGHT - _MARGIN
    style = f'font-family="sans-serif" font-size="10" fill="{_GREY}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH}" height="{_HEIGHT}">'
        f'<path d="M0 {base}H{_WIDTH}" stroke="{_GREY}" stroke-width="0.5"/>{"".join(lines)}'
        f'<text x="1" y="{_HEIGHT - 3}" {style}>{low:.6g}</text>'
        f'<text x="{_WIDTH / 2}" y="{_HEIGHT - 3}" text-anchor="middle" {style}>{escape(variable.axis_label)}</text>'
        f'<text x="{_WIDTH - 1}" y="{_HEIGHT - 3}" text-anchor="end" {style}>{high:.6g}</text></svg>'
    )


def _line(
    system: FuzzySystem, variable: LinguisticVariable, term: Term, xs: Sequence[float], ends: tuple[float, float]
) -> str:
    """Return the points of a term's line in the picture."""
    scale = (_WIDTH - 2) / (ends[1] - ends[0])
    base, height = _HEIGHT - _MARGIN, _HEIGHT - _MARGIN - 4
    if is_number(term.membership.kind):
        at = 1 + (system.number(term.membership.arguments[0]) - ends[0]) * scale
        return f"{at:.1f},{base} {at:.1f},{base - height * system.number(term.membership.height):.1f}"
    degree = degree_function(system, variable, term)
    if degree is None:
        return ""
    return " ".join(f"{1 + (x - ends[0]) * scale:.1f},{base - height * degree(x):.1f}" for x in xs)


def as_markdown(svg: str, name: str) -> str:
    """Return a picture as part of a Markdown text."""
    return f"![{name}](data:image/svg+xml;base64,{b64encode(svg.encode()).decode()})"
