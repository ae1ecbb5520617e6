"""What a trace looks like: the text of `fuzzyctl why`, and the rule viewer in a notebook."""

from __future__ import annotations

import math

from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.display.markup import Markup, page, pairs, paragraph, picture_svg, table
from fuzzyctl.explain.trace import Contribution, Trace

#: Most rules of a text or a picture.
MOST = 12


def html(found: Trace) -> str:
    """Return the outputs, the rules that act and the slopes as tables, and the rule viewer."""
    from fuzzyctl.plot.figures import svg
    from fuzzyctl.plot.rule_viewer import viewer

    rules = [
        (r.number, f"{r.activation:.4g}", r.text, ", ".join(f"{c.output}: {c.share:.1%}" for c in r.contributions))
        for r in found.rules
    ]
    slopes = [(o, name, _slope(*pair)) for o, own in found.slopes.items() for name, pair in own.items()]
    return page(
        f"{_values(found.outputs, found)} at {_values(found.inputs, found)}",
        pairs("Lets", {name: f"{value:.6g}" for name, value in found.lets.items()}),
        table("Rules that act", ("rule", "activation", "text", "share"), rows=rules),
        paragraph(f"{counted(found.silent, 'rule')} silent" if found.silent else "", "note"),
        table("Change per unit of an input, to the left and to the right", ("output", "input", "change"), slopes),
        picture_svg(svg(viewer(found, MOST).figure), "rules that act, with their sets cut") if rules else Markup(""),
    )


def _values(numbers: dict[str, float], found: Trace) -> str:
    units = {v.name: v.unit for v in (*found.system.inputs, *found.system.outputs)}
    return ", ".join(f"{n} = {x:.6g} {units[n]}".rstrip() for n, x in numbers.items())


def text(found: Trace, most: int = MOST) -> str:
    """Return the rules that act, with what each contributes, and the slopes of the outputs.

    Args:
        found: What was traced.
        most: Most rules.
    """
    lines = []
    for output in found.system.outputs:
        unit = f" {output.unit}" if output.unit else ""
        lines.append(f"{output.name} = {found.outputs[output.name]!r}{unit}")
    if found.lets:
        units = {let.name: f" {let.unit}" if let.unit else "" for let in found.system.lets}
        lines += ["", "Lets", *(f"  {name} = {value:.6g}{units[name]}" for name, value in found.lets.items())]
    lines += ["", f"Degrees above 0 at {', '.join(f'{n} = {x:.6g}' for n, x in found.inputs.items())}"]
    for variable, degrees in found.degrees.items():
        above = [f"{term} {d:.4g}" for term, d in degrees.items() if d > 0.0]
        lines.append(f"  {variable}: {', '.join(above) or 'none'}")
    lines += ["", f"Rules that act: {len(found.rules)}; silent: {found.silent}"]
    for rule in found.rules[:most]:
        block = f"   (rules {rule.block})" if rule.block else ""
        lines.append(f"  {rule.activation:<8.4g}  {rule.text}{block}")
        lines += [f"            {_contribution(c)}" for c in rule.contributions]
    if len(found.rules) > most:
        lines.append(f"  and {len(found.rules) - most} more; --rules shows more of them")
    lines += ["", "Change per unit of an input, to the left and to the right"]
    for output_name, slopes in found.slopes.items():
        lines += [f"  {output_name} by {name}: {_slope(*pair)}" for name, pair in slopes.items()]
    return "\n".join(lines)


def _contribution(c: Contribution) -> str:
    text = f"{c.output}: {c.share:.1%} of the activation, for {c.term}"
    if c.value is not None:
        text += f" = {c.value:.6g}"
    return text if c.influence is None else f"{text}, which pulls it by {c.influence:+.6g}"


def _slope(left: float, right: float) -> str:
    if math.isnan(left) or math.isnan(right):
        return f"{left:.6g} and {right:.6g}"
    same = abs(left - right) <= 1e-4 * max(abs(left), abs(right), 1e-12)
    return f"{right:.6g}" if same else f"{left:.6g} and {right:.6g}"
