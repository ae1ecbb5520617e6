"""Resolves a syntax tree into a fuzzy system."""

from __future__ import annotations

from typing import Final

from fuzzyctl.errors import Diagnostic, closest
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, DISJUNCTIONS, IMPLICATIONS
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.guarantee import Guarantee, Param
from fuzzyctl.model.method import DEFUZZIFIERS, Defuzzifier, Method
from fuzzyctl.model.rule import Rule, RuleTable
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Output
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.rules import MAX_RULES, resolve_require, resolve_rule, resolve_table
from fuzzyctl.resolve.variables import resolve_param, resolve_variable
from fuzzyctl.source import Span

_SETTINGS: Final[dict[str, tuple[str, tuple[str, ...]]]] = {
    "and": ("conjunction", tuple(CONJUNCTIONS)),
    "or": ("disjunction", tuple(DISJUNCTIONS)),
    "implication": ("implication", IMPLICATIONS),
    "aggregation": ("aggregation", AGGREGATIONS),
    "defuzzifier": ("defuzzifier", DEFUZZIFIERS),
}

#: Bounds of the number of samples of a sampled centroid.
RESOLUTIONS: Final = (2, 1_000_000)


def resolve(tree: sx.SyntaxTree, broken: bool) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Give a syntax tree its meaning.

    Args:
        tree: The statements that could be read.
        broken: Whether some lines could not be read; what is missing is then no mistake of its own.

    Returns:
        The system, or None when something has no meaning, and the diagnostics in order of their places.
    """
    context = Context(unread=tree.unread, lost_variable=tree.lost_variable)
    heads = _declare(context, tree)
    system = None
    if _has_heads(context, tree, heads, broken):
        system = _build(context, tree)
    context.diagnostics.sort(key=lambda d: d.span.start if d.span is not None else -1)
    failed = broken or any(d.severity == "error" for d in context.diagnostics)
    return (None if failed else system), context.diagnostics


def _declare(context: Context, tree: sx.SyntaxTree) -> list[sx.System]:
    """Enter all names first, so that statements may stand in any order."""
    heads: list[sx.System] = []
    for statement in tree.statements:
        match statement:
            case sx.System():
                heads.append(statement)
            case sx.Version(number=number) if number.text != "1":
                help_text = "this fuzzyctl reads version 1: write 'fz 1', or install a newer fuzzyctl"
                context.report("FZ111", f"language version {number.text} is not supported", number.span, help=help_text)
            case sx.Param(name=name) if context.declare(name, "a param"):
                context.params[name.text] = statement
            case sx.Variable(keyword=keyword, name=name) if context.declare(name, f"an {keyword.text}"):
                (context.inputs if keyword.text == "input" else context.outputs)[name.text] = statement
    return heads


def _has_heads(context: Context, tree: sx.SyntaxTree, heads: list[sx.System], broken: bool) -> bool:
    if not heads:
        if not broken:
            start = Span(tree.source, 0, 0)
            message = "the file declares no system" if tree.statements else "the file holds no statement"
            help_text = "begin with: system NAME \"title\"; 'docs/reference/language.md' shows a whole file"
            context.report("FZ004", message, start, help=help_text)
        return False
    if len(heads) > 1:
        context.report(
            "FZ215",
            "a second system begins here",
            heads[1].name.span,
            note=(heads[0].name.span, "the first one begins here"),
            help="this version reads one system a file; put it into a file of its own",
        )
    if not broken:
        for kind, among in (("input", context.inputs), ("output", context.outputs)):
            if not among:
                context.report("FZ212", f"the system has no {kind}", heads[0].name.span, help=f"add an '{kind}'")
        if not any(isinstance(s, sx.Rule | sx.Table) for s in tree.statements):
            context.report("FZ212", "the system has no rules", heads[0].name.span, help="add a 'table' or an 'if' line")
    return True


def _build(context: Context, tree: sx.SyntaxTree) -> FuzzySystem | None:
    head = next(s for s in tree.statements if isinstance(s, sx.System))
    params: list[Param | None] = []
    inputs: list[Input | None] = []
    outputs: list[Output | None] = []
    blocks: list[RuleTable | Rule | None] = []
    guarantees: list[Guarantee | None] = []
    for s in tree.statements:
        match s:
            case sx.Param(name=name) if context.params.get(name.text) is s:
                params.append(resolve_param(context, s))
            case sx.Variable():
                variable = resolve_variable(context, s)
                if isinstance(variable, Output):
                    outputs.append(variable)
                else:
                    inputs.append(variable)
            case sx.Rule():
                blocks.append(resolve_rule(context, s))
            case sx.Table():
                blocks.append(resolve_table(context, s))
            case sx.Require():
                guarantees.append(resolve_require(context, s))
    method = _method(context, tree)
    citation = _citation(context, tree)
    if any(part is None for parts in (params, inputs, outputs, blocks, guarantees) for part in parts):
        return None
    if not _few_enough(context, [b for b in blocks if b is not None], head):
        return None
    return FuzzySystem(
        name=head.name.text,
        title=head.title,
        citation=citation,
        params=tuple(p for p in params if p is not None),
        method=method,
        inputs=tuple(i for i in inputs if i is not None),
        outputs=tuple(o for o in outputs if o is not None),
        blocks=tuple(b for b in blocks if b is not None),
        guarantees=tuple(g for g in guarantees if g is not None),
        path=tree.source.name,
        span=head.name.span,
    )


def _few_enough(context: Context, blocks: list[RuleTable | Rule], head: sx.System) -> bool:
    count = sum(sum(map(len, b.cells)) if isinstance(b, RuleTable) else 1 for b in blocks)
    if count > MAX_RULES:
        context.report("FZ112", f"the system has {count} rules, more than {MAX_RULES}", head.name.span)
    return count <= MAX_RULES


def _citation(context: Context, tree: sx.SyntaxTree) -> str:
    citations = [s for s in tree.statements if isinstance(s, sx.Citation)]
    return "; ".join(c.text for c in citations)


def _method(context: Context, tree: sx.SyntaxTree) -> Method:
    chosen: dict[str, sx.Setting] = {}
    values: dict[str, str] = {}
    defuzzifier = Defuzzifier()
    for s in tree.statements:
        if not isinstance(s, sx.Setting):
            continue
        field, known = _SETTINGS[s.keyword.text]
        if s.keyword.text in chosen:
            context.report(
                "FZ215",
                f"'{s.keyword.text}' is given twice",
                s.keyword.span,
                note=(chosen[s.keyword.text].keyword.span, "first given here"),
                help="remove one of them",
            )
        chosen[s.keyword.text] = s
        if s.value.text not in known:
            near = closest(s.value.text, known)
            context.report(
                "FZ213",
                f"'{s.keyword.text}' knows no '{s.value.text}'",
                s.value.span,
                facts=(f"one of: {', '.join(known)}",),
                help=f"did you mean '{near}'?" if near else "",
            )
        elif field == "defuzzifier":
            defuzzifier = _defuzzifier(context, s)
        else:
            _no_options(context, s)
            values[field] = s.value.text
    if defuzzifier.averages:
        for keyword in ("implication", "aggregation"):
            if keyword in chosen:
                context.report(
                    "FZ214",
                    f"'{keyword}' has no effect: '{defuzzifier.kind}' sums over rules",
                    chosen[keyword].span,
                    help="remove it, or take 'defuzzifier centroid'",
                    warning=True,
                )
    return Method.model_validate({**values, "defuzzifier": defuzzifier})


def _no_options(context: Context, setting: sx.Setting) -> None:
    for option in setting.options:
        context.report("FZ213", f"'{setting.value.text}' takes no options", option.name.span, help="remove it")


def _defuzzifier(context: Context, setting: sx.Setting) -> Defuzzifier:
    fields: dict[str, int | str] = {}
    if setting.value.text != "centroid":
        _no_options(context, setting)
        return Defuzzifier(kind=setting.value.text)
    for option in setting.options:
        value = option.value.text
        if option.name.text == "resolution":
            low, high = RESOLUTIONS
            if not value.isdigit() or not low <= int(value) <= high:
                message = f"resolution = {value} is no whole number from {low} to {high}"
                context.report("FZ302", message, option.value.span)
            else:
                fields["resolution"] = int(value)
        elif option.name.text == "grid":
            if value not in ("midpoint", "endpoints"):
                context.report("FZ213", f"no grid '{value}'", option.value.span, facts=("one of: midpoint, endpoints",))
            else:
                fields["grid"] = value
        else:
            context.unknown("option", option.name, ("resolution", "grid"), "FZ213")
    if "grid" in fields and "resolution" not in fields:
        message = "'grid' needs 'resolution': the exact centroid has no grid"
        context.report(
            "FZ214", message, setting.span, help="write, for example, centroid(resolution=1000, grid=midpoint)"
        )
    return Defuzzifier.model_validate({"kind": "centroid", **fields})
