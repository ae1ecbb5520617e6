"""Traces as the text of `fuzzyctl why`, and as the rule viewer in a notebook."""

from __future__ import annotations

import math

from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.display.markup import Markup, page, pairs, paragraph, picture_svg, table
from fuzzyctl.explain.block_trace import BlockTrace
from fuzzyctl.explain.trace import Contribution, Trace
from fuzzyctl.kernels.plan.equations import DT
from fuzzyctl.model.block import Block

#: Most rules of a text or a picture.
MOST = 12


def trace_html(trace: Trace | BlockTrace) -> str:
    """Return the outputs, the rules that act and the slopes as tables, and the rule viewer."""
    if isinstance(trace, BlockTrace):
        parts = {"State before": trace.state, "Lets": trace.lets, "Next state": trace.next_state}
        return page(
            f"{_values(trace.outputs, trace.block)} at {_values(trace.inputs, trace.block)}",
            *(pairs(name, {n: f"{x:.6g}" for n, x in part.items()}) for name, part in parts.items()),
            *(Markup(trace_html(call.trace)) for call in trace.calls),
        )
    from fuzzyctl.plot.figures import svg
    from fuzzyctl.plot.rule_viewer import viewer

    rules = [
        (r.number, f"{r.activation:.4g}", r.text, ", ".join(f"{c.output}: {c.share:.1%}" for c in r.contributions))
        for r in trace.rules
    ]
    slopes = [(o, name, _slope(*pair)) for o, by_input in trace.slopes.items() for name, pair in by_input.items()]
    return page(
        f"{_values(trace.outputs, trace.system)} at {_values(trace.inputs, trace.system)}",
        pairs("Lets", {name: f"{value:.6g}" for name, value in trace.lets.items()}),
        table("Rules that act", ("rule", "activation", "text", "share"), rows=rules),
        paragraph(f"{counted(trace.silent, 'rule')} silent" if trace.silent else "", "note"),
        table("Change per unit of an input, to the left and to the right", ("output", "input", "change"), slopes),
        picture_svg(svg(viewer(trace, MOST).figure), "rules that act, with their sets cut") if rules else Markup(""),
    )


def _values(numbers: dict[str, float], block: Block) -> str:
    units = {v.name: v.unit for v in (*block.inputs, *block.outputs)} | {DT: "s"}
    return ", ".join(f"{n} = {x:.6g} {units[n]}".rstrip() for n, x in numbers.items())


def trace_text(trace: Trace | BlockTrace, most: int = MOST) -> str:
    """Return the rules that act, with their contributions, and the slopes of the outputs.

    Args:
        trace: The trace.
        most: Most rules of a system.
    """
    return _text_of_step(trace, most) if isinstance(trace, BlockTrace) else _text_of_system(trace, most)


def _text_of_step(trace: BlockTrace, most: int) -> str:
    lines = []
    for output in trace.block.outputs:
        unit = f" {output.unit}" if output.unit else ""
        lines.append(f"{output.name} = {trace.outputs[output.name]!r}{unit}")
    lines += ["", f"At {_values(trace.inputs, trace.block)}"] if trace.inputs else []
    for title, part in (("Lets", trace.lets), ("State, and the next one", trace.state)):
        after = trace.next_state if part is trace.state else {}
        rows = [f"  {n} = {x:.6g}{f', then {after[n]:.6g}' if after else ''}" for n, x in part.items()]
        lines += ["", title, *rows] if rows else []
    for call in trace.calls:
        name = call.name if call.name == call.trace.system.name else f"{call.name} = {call.trace.system.name}(...)"
        lines += [
            "",
            f"System {name}",
            *(f"  {line}".rstrip() for line in _text_of_system(call.trace, most).split("\n")),
        ]
    return "\n".join(lines)


def _text_of_system(trace: Trace, most: int) -> str:
    lines = []
    for output in trace.system.outputs:
        unit = f" {output.unit}" if output.unit else ""
        lines.append(f"{output.name} = {trace.outputs[output.name]!r}{unit}")
    if trace.lets:
        units = {let.name: f" {let.unit}" if let.unit else "" for let in trace.system.lets}
        lines += ["", "Lets", *(f"  {name} = {value:.6g}{units[name]}" for name, value in trace.lets.items())]
    lines += ["", f"Degrees above 0 at {', '.join(f'{n} = {x:.6g}' for n, x in trace.inputs.items())}"]
    for variable, degrees in trace.degrees.items():
        above = [f"{term} {d:.4g}" for term, d in degrees.items() if d > 0.0]
        lines.append(f"  {variable}: {', '.join(above) or 'none'}")
    lines += ["", f"Rules that act: {len(trace.rules)}; silent: {trace.silent}"]
    for rule in trace.rules[:most]:
        block = f"   (rules {rule.block})" if rule.block else ""
        lines.append(f"  {rule.activation:<8.4g}  {rule.text}{block}")
        lines += [f"            {_contribution(c)}" for c in rule.contributions]
    if len(trace.rules) > most:
        lines.append(f"  and {len(trace.rules) - most} more; --rules shows more of them")
    lines += ["", "Change per unit of an input, to the left and to the right"]
    for output_name, slopes in trace.slopes.items():
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
