"""Text layout of a system summary within the width of a terminal."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final

#: Marks a line as a heading, a plain line or a line of a table, which must not be broken.
Line = tuple[str, str]

NO_EFFECT: Final = "no effect: the defuzzifier sums over rules"


def laid_out(data: dict[str, Any], width: int, bold: Callable[[str], str] = str) -> str:
    """Return the summary of a system as text.

    Args:
        data: As `summary.summary` returns it.
        width: Columns of the terminal; lines are broken there, and tables are cut into groups of columns.
        bold: Marks headings.
    """
    out: list[str] = []
    for kind, text in _lines(data, width):
        if kind == "heading":
            out.extend(bold(line) for line in _broken(text, width))
        else:
            out.extend(_broken(text, width) if kind == "text" else [text])
    return "\n".join(out) + "\n"


def _broken(text: str, width: int) -> list[str]:
    if len(text) <= width:
        return [text]
    indent = " " * (len(text) - len(text.lstrip()))
    return textwrap.wrap(text, max(width, 20), subsequent_indent=f"{indent}    ", break_long_words=False) or [text]


def _lines(data: dict[str, Any], width: int) -> Iterator[Line]:
    if "kind" in data:
        yield from _block(data)
        return
    yield "heading", f"{data['system']}: {data['title']}" if data["title"] else data["system"]
    for word in ("source", "file"):
        if data[word]:
            yield "text", f"{word}: {data[word]}"
    knobs = ", ".join(f"{knob} {value}" for knob, value in data["knobs"].items())
    yield from _section("Method", _pairs((data["method"] | {"knobs": knobs}).items()))
    yield from _section("Params", _params(data["params"]))
    yield from _section("Hedges", [("text", f"  {h['meaning']}") for h in data["hedges"]])
    yield from _section("Inputs", [line for v in data["inputs"] for line in _input(v)])
    yield from _section("Lets", [line for v in data["lets"] for line in _let(v)])
    yield from _section("Outputs", [line for v in data["outputs"] for line in _output(v)])
    yield from _section(f"Rules: {data['rule_count']}", list(_rules(data["rules"], width)))
    yield from _section("Guarantees, not proved here", [("text", f"  {g}") for g in data["guarantees"]])


def _block(data: dict[str, Any]) -> Iterator[Line]:
    """Yield the lines of a controller, plant or loop."""
    title = f": {data['title']}" if data["title"] else ""
    yield "heading", f"{data['kind']} {data['name']}{title}"
    for word in ("source", "file", "period", "duration", "step"):
        if data.get(word):
            yield "text", f"{word}: {data[word] if isinstance(data[word], str) else f'{number_text(data[word])} s'}"
    yield from _section("Params", _params(data["params"]))
    for heading, statements in data["statements"].items():
        yield from _section(heading, [("text", f"  {statement}") for statement in statements])


def _section(title: str, lines: Sequence[Line]) -> Iterator[Line]:
    if lines:
        yield "table", ""
        yield "heading", title
        yield from lines


def _pairs(pairs: Any, indent: str = "  ") -> list[Line]:
    pairs = list(pairs)
    width = max((len(name) for name, _ in pairs), default=0)
    return [("text", f"{indent}{name:<{width}}  {value}") for name, value in pairs]


def _params(params: Sequence[dict[str, Any]]) -> list[Line]:
    width = max((len(p["name"]) for p in params), default=0)
    lines: list[Line] = []
    for p in params:
        value = number_text(p["value"])
        unit = f" {p['unit']}" if p["unit"] else ""
        how = (
            ""
            if p["expression"] in (value, repr(p["value"])) or _is_number(p["expression"])
            else f" = {p['expression']}"
        )
        lines.append(("text", f"  {p['name']:<{width}} = {value}{unit}{how and '   ' + how.strip()}"))
    return lines


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _input(v: dict[str, Any]) -> Iterator[Line]:
    yield "text", f"{_head(v)}; values outside are {v['outside']}"
    yield from _terms(v["terms"])


def _let(v: dict[str, Any]) -> Iterator[Line]:
    yield "text", f"{_head(v)} = {v['formula']}"
    yield from _terms(v["terms"])


def _output(v: dict[str, Any]) -> Iterator[Line]:
    if v["formula"] is not None:
        yield "text", f"{_head(v)} = {v['formula']}"
        yield from _terms(v["terms"])
        yield from _pairs([("values", _values_text(v["bounds"]))], "    ")
        return
    yield "text", _head(v)
    yield from _terms(v["terms"])
    yield from _pairs(output_facts(v).items(), "    ")


def output_facts(v: dict[str, Any]) -> dict[str, str]:
    """Return the settings of an output and the proofs of it, by name."""
    facts: dict[str, str] = {}
    if v["formula"] is None:
        facts |= {name: value or NO_EFFECT for name, value in v["method"].items()}
        if v["adaptive"] is not None:
            facts["adaptive"] = f"rate {v['adaptive']}"
        facts["else"] = _otherwise_text(v["else"], v["held_at_first"])
    if v["clamped"]:
        facts["clamped"] = "the value is held within the range"
    facts["values"] = _values_text(v["bounds"])
    if v["formula"] is None:
        facts["coverage"] = _coverage_text(v["coverage"], v["else"] is not None)
    return facts


def _head(v: dict[str, Any]) -> str:
    label = f' "{v["label"]}"' if v["label"] else ""
    unit = f" {v['unit']}" if v["unit"] else ""
    ends = f" in [{number_text(v['low'])}, {number_text(v['high'])}]" if v["low"] != "-inf" else ""
    return f"  {v['name']}{label}{ends}{unit}"


def _terms(terms: Sequence[dict[str, Any]]) -> list[Line]:
    return _pairs([(t["name"], membership_form(t)) for t in terms], "    ")


def membership_form(t: dict[str, Any]) -> str:
    """Return the membership function of a term with its numbers."""
    parameters = [number_text(p) for p in t["parameters"]]
    if t["height"] != 1.0:
        parameters.append(f"height={number_text(t['height'])}")
    return f"{t['kind']}({', '.join(parameters)})"


def number_text(value: float | str) -> str:
    """Return a number with the digits that people read; `--format json` has all of them."""
    return value if isinstance(value, str) else f"{value:.12g}"


def _otherwise_text(value: float | str | None, held_at_first: float | str | None) -> str:
    """Return the value of an output if no rule fires, as text."""
    if held_at_first is not None:
        return f"hold: the previous value, {number_text(held_at_first)} at first"
    return "nothing: some rule must fire everywhere" if value is None else number_text(value)


def _values_text(bounds: dict[str, Any] | None) -> str:
    """Return the proved bounds of an output."""
    if bounds is None:
        return "not known"
    how = "both are attained" if bounds["attained"] else "proved, perhaps wider than need be"
    return f"from {number_text(bounds['low'])} to {number_text(bounds['high'])}; {how}"


def _coverage_text(coverage: dict[str, Any], has_else: bool) -> str:
    """Return where some rule fires."""
    if coverage["verdict"] == "proved":
        return "some rule fires everywhere; proved"
    then = "; 'else' counts there" if has_else else ""
    if coverage["verdict"] == "hole":
        return f"no rule fires where {coverage['region']}{then}"
    return f"undecided: {coverage['reason']}"


def _rules(blocks: Sequence[dict[str, Any]], width: int) -> Iterator[Line]:
    for i, block in enumerate(blocks):
        if "rule" in block:
            yield "text", f"  {block['rule']}"
            continue
        if "block" in block:
            yield from [("table", "")] if i else []
            settings = "".join(f" {keyword} {value}" for keyword, value in block["method"].items())
            yield "heading", f"  rules {block['block']}{settings}"
            yield from _rules(block["rules"], width)
            continue
        if i:
            yield "table", ""
        yield from _table(block, width)
        if i + 1 < len(blocks) and "rule" in blocks[i + 1]:
            yield "table", ""


def _table(block: dict[str, Any], width: int) -> Iterator[Line]:
    """Draw a rule table; one that is too wide is cut into groups of columns."""
    title, corner, labels = table_frame(block, "x")
    yield "text", f"  {title}"
    first = max(len(corner), *map(len, labels))
    for group in _groups(block, width - first - 7):
        header = [block["column_terms"][k] for k in group]
        rows = [[row[k] for k in group] for row in block["cells"]]
        widths = [max(len(row[k]) for row in [header, *rows]) for k in range(len(group))]
        yield "table", _row(corner, header, first, widths)
        yield "table", f"    {'─' * first}─┼─{'─' * (sum(widths) + 2 * len(widths) - 2)}"
        for label, row in zip(labels, rows, strict=True):
            yield "table", _row(label, row, first, widths)


def table_frame(block: dict[str, Any], times: str) -> tuple[str, str, list[str]]:
    """Return the title of a rule table, with a sign between its variables, its corner, and the labels of its rows."""
    outputs, rows, columns = ", ".join(block["table"]), block["rows"], block["columns"]
    condition = f" with {block['with']}" if block["with"] else ""
    across, corner = (f"{rows} {times} {columns}", f"{rows} \\ {columns}") if rows else (columns, columns)
    return f"{outputs} = {across}{condition}", corner, block["row_terms"] or [outputs]


def _groups(block: dict[str, Any], room: int) -> Iterator[list[int]]:
    """Yield the columns that fit beside each other, at least one at a time."""
    group: list[int] = []
    used = 0
    for k, term in enumerate(block["column_terms"]):
        size = max(len(term), *(len(row[k]) for row in block["cells"])) + 2
        if group and used + size > room + 2:
            yield group
            group, used = [], 0
        group.append(k)
        used += size
    yield group


def _row(label: str, cells: Sequence[str], first: int, widths: Sequence[int]) -> str:
    body = "  ".join(f"{cell:<{width}}" for cell, width in zip(cells, widths, strict=True))
    return f"    {label:<{first}} │ {body}".rstrip()
