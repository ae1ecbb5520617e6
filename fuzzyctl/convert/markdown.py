"""A system as a Markdown page: its settings, terms and rules in tables, its guarantees, and places for pictures."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

from fuzzyctl.comparison.differences import quiet
from fuzzyctl.comparison.settings import described, otherwise_text
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.expr import Expr, ExprError, number_text, to_text
from fuzzyctl.formats.fz import activation_text, antecedent_text, block_settings, cell_text, membership_text, rule_text
from fuzzyctl.formats.fz_strings import guarantee_text
from fuzzyctl.model.method import Method
from fuzzyctl.model.rule import Rule, RuleBlock, RuleTable
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import ANYWHERE, Input, Let, LinguisticVariable, Membership, Output
from fuzzyctl.plot.choices import file_part

#: Characters that mean something in Markdown's running text; bars do in tables only, which escape them.
_SPECIAL: Final = re.compile(r"([\\`*_{}\[\]<>#~$])")

Row = Sequence[str]


def page_text(system: FuzzySystem, pictures: Mapping[str, str]) -> str:
    """Return a Markdown page about a system.

    Args:
        system: The system.
        pictures: Paths of pictures, as the page links them: of the terms of variables by their names, of surfaces by
            `surface NAME` with the name of the output.
    """
    lines = [f"# {_plain(system.title or system.name)}", ""]
    if system.citation:
        lines += [f"Source: {_plain(system.citation)}", ""]
    for title, body in (
        ("Method", _method(system.method)),
        ("Params", _params(system)),
        ("Hedges", [f"- {_code(f'{h.name}({h.parameter}) = {to_text(h.expression)}')}" for h in system.hedges]),
    ):
        lines += _section(title, body)
    for kind, variables in (("Input", system.inputs), ("Let", system.lets), ("Output", system.outputs)):
        for v in variables:
            lines += _section(f"{kind} {_plain(v.name)}", _variable(system, v, pictures))
    lines += _section("Rules", _rules(system))
    lines += _section("Guarantees", [f"- {_code(guarantee_text(g))}" for g in system.guarantees])
    return "\n".join(lines).rstrip("\n") + "\n"


def _section(title: str, body: Sequence[str] | Iterator[str]) -> list[str]:
    lines = list(body)
    return [f"## {title}", "", *lines, ""] if lines else []


def _plain(text: str) -> str:
    return _SPECIAL.sub(r"\\\1", text)


def _code(text: str) -> str:
    return f"`{text}`"


def _table(head: Row, rows: Sequence[Row]) -> list[str]:
    """Return a table, its columns aligned in the text as well."""
    cells = [[text.replace("|", "\\|") for text in row] for row in (head, *rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(head))]
    lines = ["| " + " | ".join(f"{text:{w}}" for text, w in zip(row, widths, strict=True)) + " |" for row in cells]
    return [lines[0], "|" + "|".join("-" * (w + 2) for w in widths) + "|", *lines[1:]]


def _method(method: Method) -> list[str]:
    rows = [
        ("semantics", method.semantics.profile),
        ("and", method.conjunction),
        ("or", method.disjunction),
    ]
    if not method.defuzzifier.over_rules:
        rows += [("implication", method.implication), ("aggregation", method.aggregation)]
    rows += [("activation", activation_text(method.activation)), ("defuzzifier", described(method.defuzzifier))]
    return _table(("setting", "value"), rows)


def _params(system: FuzzySystem) -> list[str]:
    rows = [
        (_code(p.name), _number(system.values[p.name]), _code(to_text(p.expression)), _plain(p.unit))
        for p in system.params
    ]
    return _table(("param", "value", "as written", "unit"), rows) if rows else []


def _number(value: float) -> str:
    text = f"{value:.6g}"
    return text if float(text) == value else number_text(value)


def _variable(system: FuzzySystem, v: LinguisticVariable, pictures: Mapping[str, str]) -> Iterator[str]:
    low, high = _number(system.number(v.lower)), _number(system.number(v.upper))
    unit = f" {_plain(v.unit)}" if v.unit else ""
    label = f"{_plain(v.label)}, " if v.label else ""
    ends = "" if (v.lower, v.upper) == ANYWHERE else f"from {low} to {high}{unit}."
    yield f"{label}{ends} {_besides(v)}".strip()
    yield ""
    if v.terms:
        rows = [(_plain(t.name), _code(_membership(system, t.membership))) for t in v.terms]
        yield from _table(("term", "consequent" if isinstance(v, Output) else "membership function"), rows)
    for key, what in ((v.name, f"Terms of {v.name}"), (f"surface {v.name}", f"{v.name} over its inputs")):
        if key in pictures and (isinstance(v, Output) or key == v.name):
            yield ""
            yield f"![{_plain(what)}]({pictures[key]})"


def _besides(v: LinguisticVariable) -> str:
    """Return what else there is to say of a variable, in sentences."""
    match v:
        case Input():
            return "Values outside go through the formulas." if v.extrapolate else "Values outside are clamped."
        case Let(value=value):
            return f"It is {_code(to_text(value))}."
        case Output(value=value) if value is not None:
            clamped = " The value is clamped to this range." if v.clamped else ""
            return f"It is {_code(to_text(value))}.{clamped}"
        case Output():
            otherwise = otherwise_text(v.otherwise)
            parts = [f"Where no rule fires: {_code(otherwise)}." if otherwise else "Some rule always fires."]
            if v.clamped:
                parts.append("The value is clamped to this range.")
            if v.adaptive is not None:
                parts.append(f"Its consequents adapt at the rate {_code(to_text(v.adaptive))}.")
            norms = [getattr(v, n) for n in ("implication", "aggregation") if getattr(v, n) is not None]
            norms += [described(v.defuzzifier)] if v.defuzzifier is not None else []
            if norms:
                parts.append(f"It has its own {', '.join(map(_code, norms))}.")
            return " ".join(parts)
    return ""


def _membership(system: FuzzySystem, membership: Membership) -> str:
    """Return a membership function with its numbers computed where they can be."""
    if not any(_computable(system, a) for a in membership.arguments):
        return membership_text(membership)
    numbers = [_number(system.number(a)) if _computable(system, a) else to_text(a) for a in membership.arguments]
    height = system.number(membership.height)
    return f"{membership.kind}({', '.join(numbers)})" + (f" of height {_number(height)}" if height != 1.0 else "")


def _computable(system: FuzzySystem, expr: Expr) -> bool:
    try:
        system.number(expr)
    except ExprError:
        return False
    return True


def _rules(system: FuzzySystem) -> Iterator[str]:
    of_none = list(_parts([b for b in system.blocks if not isinstance(b, RuleBlock)]))
    yield from of_none
    for block in system.rule_blocks:
        if of_none or block is not system.rule_blocks[0]:
            yield ""
        yield from [f"### Rule block {_plain(block.name)}", ""]
        words = [_code(f"{keyword} {value}") for keyword, value in block_settings(block)]
        if words:
            yield from [f"It has its own {', '.join(words)}.", ""]
        yield from _parts(block.rules)


def _parts(parts: Sequence[RuleTable | Rule]) -> Iterator[str]:
    number = 0
    for part in parts:
        if isinstance(part, RuleTable):
            yield from ([""] if number else [])
            yield from _rule_table(part)
            yield ""
            number = 0
            continue
        number += 1
        yield f"{number}. {_code(rule_text(part))}"


def _rule_table(table: RuleTable) -> Iterator[str]:
    condition = f" if {_code(antecedent_text(table.condition, top=True))}" if table.condition is not None else ""
    across = f"{table.rows} (rows) and {table.columns} (columns)" if table.rows else table.columns
    yield f"{_plain(', '.join(table.outputs))} by {_plain(across)}{condition}:"
    yield ""
    head = ["", *map(_plain, table.column_terms)] if table.rows else list(map(_plain, table.column_terms))
    rows = []
    for k, row in enumerate(table.cells):
        cells = [_plain(cell_text(c)) for c in row]
        rows.append([f"**{_plain(table.row_terms[k])}**", *cells] if table.rows else cells)
    yield from _table(head, rows)


def pictures_folder(page: Path) -> Path:
    """Return the folder of the pictures of a page."""
    return page.with_name(f"{page.stem}-pictures")


def picture_files(system: FuzzySystem, page: Path) -> dict[str, Path]:
    """Return the files of the pictures of a page, by what `markdown.page` calls them.

    Args:
        system: The system.
        page: The page's file; pictures go to a folder called after it, such as `tipper-pictures`.
    """
    folder = pictures_folder(page)
    parts: dict[str, str] = {}
    for v in system.variables:
        parts[v.name] = file_part(v.name, parts.values())
    terms = {v.name: folder / f"{parts[v.name]}.svg" for v in system.variables if v.terms}
    return terms | {f"surface {o.name}": folder / f"surface-{parts[o.name]}.svg" for o in system.outputs}


def refuse_to_replace(files: dict[str, Path]) -> None:
    """Refuse pictures in the place of files that are there.

    Raises:
        DiagnosticError: With the files.
    """
    there = [path for path in files.values() if path.exists()]
    if there:
        what = "a file of this name exists" if len(there) == 1 else f"this file and {len(there) - 1} more exist"
        help_text = "name another page, whose pictures get a folder of their own, or add --force"
        raise DiagnosticError([Diagnostic("FZ005", what, file=str(there[0]), help=help_text)])


def page_files(system: FuzzySystem, page: Path) -> dict[Path, str]:
    """Return the texts of a Markdown page and of its pictures by file.

    Args:
        system: The system.
        page: The page's file.
    """
    from fuzzyctl.plot.memberships import draw_variable
    from fuzzyctl.plot.style import svg
    from fuzzyctl.plot.surfaces import draw_surface

    files, texts = picture_files(system, page), dict[Path, str]()
    # A surface has a hole where no rule fires, whatever calls of the system do there.
    drawn, axes = quiet(system), [v.name for v in system.inputs[:2]]

    def terms(figure: Any, variable: LinguisticVariable) -> None:
        figure.set_size_inches(7.5, 2.6)
        draw_variable(figure.subplots(), system, variable)

    for variable in system.variables:
        if variable.name in files:
            texts[files[variable.name]] = svg(partial(terms, variable=variable))
    for output in system.outputs:
        surface = partial(draw_surface, system=drawn, axes=axes, fixed={}, output=output.name, resolution=61)
        texts[files[f"surface {output.name}"]] = svg(surface)
    links = {key: f"{path.parent.name}/{path.name}" for key, path in files.items()}
    return {**texts, page: page_text(system, links)}
