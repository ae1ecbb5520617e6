"""Blocks as the text of `fuzzyctl show`, and as tables in a notebook."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final

from fuzzyctl.diagnostics.terminal import for_terminal
from fuzzyctl.display.layout import laid_out, membership_form, number_text, output_facts, table_frame
from fuzzyctl.display.markup import Markup, lines, page, pairs, paragraph, plain, table
from fuzzyctl.display.summary import block_summary, summary
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.plant import Plant
from fuzzyctl.model.system import FuzzySystem

#: Width of the text where it does not go to a terminal.
WIDTH: Final = 120


def system_text(system: FuzzySystem) -> str:
    """Return the text of `fuzzyctl show`."""
    return page_text(summary(system))


def page_text(data: dict[str, Any], bold: Callable[[str], str] = str) -> str:
    """Return a summary as text, as wide as the terminal and in its characters.

    Args:
        data: As `summary` or `block_summary` returns it.
        bold: Marks headings.
    """
    width = shutil.get_terminal_size((WIDTH, 24)).columns
    return laid_out(for_terminal(data, sys.stdout.encoding), width, bold)


def system_html(system: FuzzySystem) -> str:
    """Return the variables with their terms, the rules, the method in effect and the claims, as tables."""
    data = summary(system)
    knobs = ", ".join(f"{knob} {value}" for knob, value in data["knobs"].items())
    return page(
        f"{data['system']}: {data['title']}" if data["title"] else data["system"],
        paragraph(data["source"], "note"),
        paragraph(data["file"], "note"),
        params_table(data["params"]),
        pairs("Hedges", {h["name"]: h["meaning"] for h in data["hedges"]}),
        table("Inputs", ("input", "range", "terms", "values outside"), [_input(v) for v in data["inputs"]]),
        table("Lets", ("let", "range", "terms", "formula"), [(*_variable(v), v["formula"]) for v in data["lets"]]),
        table("Outputs", ("output", "range", "terms", "how"), [_output(v) for v in data["outputs"]]),
        *_rules(data["rules"], f"Rules: {data['rule_count']}"),
        pairs("Method", data["method"] | {"knobs": knobs}),
        table("Guarantees, not proved here", (), [(g,) for g in data["guarantees"]], headed_rows=False),
    )


def params_table(params: Sequence[dict[str, Any]]) -> Markup:
    """Return the params with their values and how they are computed."""
    rows = [(p["name"], number_text(p["value"]), p["unit"], p["expression"]) for p in params]
    return table("Params", ("param", "value", "unit", "expression"), rows)


def _variable(v: dict[str, Any]) -> tuple[object, ...]:
    label = f"{v['name']} \N{EN DASH} {v['label']}" if v["label"] else v["name"]
    ends = f"[{number_text(v['low'])}, {number_text(v['high'])}]" if v["low"] != "-inf" else "anywhere"
    terms = lines(f"{t['name']} = {membership_form(t)}" for t in v["terms"])
    return label, f"{ends} {v['unit']}".strip(), terms


def _input(v: dict[str, Any]) -> tuple[object, ...]:
    return (*_variable(v), v["outside"])


def _output(v: dict[str, Any]) -> tuple[object, ...]:
    facts = [f"= {v['formula']}"] if v["formula"] is not None else []
    for name, text in output_facts(v).items():
        facts.append("clamped within the range" if name == "clamped" else f"{name}: {text}")
    return (*_variable(v), lines(facts))


def _rules(blocks: Sequence[dict[str, Any]], caption: str) -> Iterator[Markup]:
    """Yield rule tables as tables, and single rules between them as a table of rules."""
    single: list[tuple[str]] = []
    for block in blocks:
        if "rule" in block:
            single.append((block["rule"],))
            continue
        if single:
            yield table(caption, (), single, headed_rows=False)
            single = []
        if "block" in block:
            settings = "".join(f" {keyword} {value}" for keyword, value in block["method"].items())
            yield from _rules(block["rules"], f"{caption}: rules {block['block']}{settings}")
        else:
            yield _table(block, caption)
    if single:
        yield table(caption, (), single, headed_rows=False)


def _table(block: dict[str, Any], caption: str) -> Markup:
    title, corner, labels = table_frame(block, "×")
    rows = [(label, *map(plain, cells)) for label, cells in zip(labels, block["cells"], strict=True)]
    return table(f"{caption}: {title}", (corner, *block["column_terms"]), rows)


def block_text(block: Controller | Plant | Loop) -> str:
    """Return the text of `fuzzyctl show`."""
    return page_text(block_summary(block))


def block_html(block: Controller | Plant | Loop) -> str:
    """Return params, signals and equations in the order in which they are computed, as tables."""
    data = block_summary(block)
    title = f": {data['title']}" if data["title"] else ""
    times = [f"{word} {number_text(data[word])} s" for word in ("period", "duration", "step") if data.get(word)]
    return page(
        f"{data['kind']} {data['name']}{title}",
        paragraph(data["source"], "note"),
        paragraph(data["file"], "note"),
        paragraph(", ".join(times)),
        params_table(data["params"]),
        *(
            table(heading, (), [(s,) for s in statements], headed_rows=False)
            for heading, statements in data["statements"].items()
        ),
    )
