"""Resolution of a syntax tree to a fuzzy system, with its rule blocks."""

from __future__ import annotations

import dataclasses
from collections import ChainMap
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import CODES, WARNINGS, Diagnostic
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Call, names_in, walk
from fuzzyctl.formulas import HEDGES
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.block import Guarantee, Hedge, Param
from fuzzyctl.model.checks.checks import check_values, in_order
from fuzzyctl.model.rule import Antecedent, Rule, RuleBlock, RuleTable, literals, rules_of
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Let, Output
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.functions import declare_function
from fuzzyctl.resolve.rules import MAX_OUTPUTS, MAX_RULES, resolve_otherwise, resolve_require, resolve_rule, terms_of
from fuzzyctl.resolve.settings import find_idle_settings, resolve_method, resolve_rule_settings, resolve_semantics
from fuzzyctl.resolve.tables import resolve_table
from fuzzyctl.resolve.variables import resolve_param, resolve_variable, share_terms

#: Most inputs and outputs of a system together, those shared with other systems included.
MAX_VARIABLES: Final = 2000
#: Most terms of all variables of a system together; each variable may have 1000.
MAX_TERMS_IN_ALL: Final = 25_000
#: Most guarantees of a system.
MAX_GUARANTEES: Final = 1000


def resolve(
    tree: sx.SyntaxTree, shared: Sequence[sx.Statement], broken: bool, *, foreign: bool = False
) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Give a syntax tree its meaning.

    Args:
        tree: The statements of one system that could be read.
        shared: Statements that belong to other systems as well; inputs and outputs among them that no rule of this
            system names are left out.
        broken: Whether some lines could not be read; missing parts are then not reported.
        foreign: Whether it is a translation of a file of another tool, whose reader has reported missing parts.

    Returns:
        The system, or None when something has no meaning, and the diagnostics in order of their places.
    """
    context = Context(
        unread=tree.unread,
        lost_variable=tree.lost_variable,
        lost_input=tree.lost_input,
        lost_file=tree.lost_file,
        nameless=tree.nameless,
        foreign=foreign,
    )
    settings = (sx.Setting, sx.Activation, sx.Semantics)
    keywords = {s.keyword.text for s in tree.statements if isinstance(s, settings)}
    shared = [s for s in shared if not (isinstance(s, settings) and s.keyword.text in keywords)]
    whole = dataclasses.replace(tree, statements=(*shared, *tree.statements))
    crowd = _crowded(whole) if not foreign else None
    if crowd is not None:
        return None, [crowd]
    heads = _declare(context, whole)
    whole = dataclasses.replace(whole, statements=tuple(share_terms(context, whole.statements)))
    _check_heads(context, whole, heads, broken or foreign)
    system = _build(context, whole, shared, heads[0] if heads else None, broken=broken)
    if broken or any(d.severity == "error" for d in context.diagnostics):
        # One mistake must not hide another: numbers are checked as far as they can be.
        return None, in_order([*context.diagnostics, *check_values(system)])
    if shared:
        system = _without_idle(system, {s.name.text for s in shared if isinstance(s, sx.Variable)})
    return system, in_order(context.diagnostics)


def _crowded(tree: sx.SyntaxTree) -> Diagnostic | None:
    """Report a system with more variables, terms or guarantees than any controller has, before they are resolved."""
    variables = [s for s in tree.statements if isinstance(s, sx.Variable)]
    if len(variables) > MAX_VARIABLES:
        message = f"the system has {len(variables)} inputs, outputs and lets, more than {MAX_VARIABLES}"
        help_text = "spread them over several systems"
        return Diagnostic("FZ112", message, variables[MAX_VARIABLES].name.span, help=help_text)
    terms = sum(len(terms_of(v)) for v in variables)
    if terms > MAX_TERMS_IN_ALL:
        message = f"the variables of the system have {terms} terms, more than {MAX_TERMS_IN_ALL}"
        return Diagnostic("FZ112", message, variables[0].name.span, help="give them fewer terms, or write a 'function'")
    guarantees = [s for s in tree.statements if isinstance(s, sx.Require)]
    if len(guarantees) > MAX_GUARANTEES:
        message = f"the system has {len(guarantees)} guarantees, more than {MAX_GUARANTEES}"
        help_text = "keep those that imply the others"
        return Diagnostic("FZ112", message, guarantees[MAX_GUARANTEES].span, help=help_text)
    return None


#: The kinds of variables, for people.
KINDS: Final = {"input": "an input", "output": "an output", "let": "a let"}


def _declare(context: Context, tree: sx.SyntaxTree) -> list[sx.System]:
    """Enter all names first, so that statements may be in any order."""
    heads: list[sx.System] = []
    for statement in tree.statements:
        match statement:
            case sx.System(name=name):
                context.is_free(name, "a system")
                heads.append(statement)
            case sx.Version() if not _begins(context, tree, statement):
                pass
            case sx.Allow(keyword=keyword, codes=codes) if keyword.text == "allow":
                _only_warnings(context, codes)
            case sx.Version(number=number) if number.text != "1":
                help_text = "this fuzzyctl reads version 1: write 'fz 1', or install a newer fuzzyctl"
                context.report("FZ111", f"language version {number.text} is not supported", number.span, help=help_text)
            case sx.Param(name=name) if context.declare(name, "a param"):
                context.params[name.text] = statement
            case sx.Function():
                declare_function(context, statement)
            case sx.Hedge(name=name, parameter=parameter):
                for word, what in ((name, "a hedge"), (parameter, "the variable of a hedge")):
                    context.is_free(word, what)
                if name.text in HEDGES or name.text in context.hedges:
                    hedge = context.hedges.get(name.text)
                    note = (hedge.name.span, "first declared here") if hedge is not None else None
                    message = f"there is a hedge '{name.text}' already"
                    context.report("FZ201", message, name.span, note=note, help="rename it")
                context.hedges.setdefault(name.text, statement)
            case sx.Variable(keyword=keyword, name=name) if context.declare(name, KINDS[keyword.text]):
                places = {"input": context.inputs, "output": context.outputs, "let": context.lets}
                places[keyword.text][name.text] = statement
    return heads


def _begins(context: Context, tree: sx.SyntaxTree, version: sx.Version) -> bool:
    """Check that the version is the first statement of its file."""
    first = next(s for s in tree.statements if s.span.source is version.span.source)
    if first is version:
        return True
    if isinstance(first, sx.Version):
        note = (first.span, "first given here")
        context.report("FZ215", "'fz' is given twice", version.span, note=note, help="remove one of them")
    else:
        context.report(
            "FZ214", "expected 'fz' before all other statements", version.span, help="move it to the first line"
        )
    return False


def _only_warnings(context: Context, codes: Sequence[sx.Word]) -> None:
    """Check that codes to be allowed are those of warnings; codes that do not exist are found where they act."""
    for code in codes:
        if code.text in CODES and code.text[2] in "01234" and code.text not in WARNINGS:
            facts = (f"warnings are: {', '.join(sorted(WARNINGS))}",)
            message = f"{code.text} is an error and cannot be allowed"
            context.report("FZ213", message, code.span, facts=facts, help="fix what it names")


def _check_heads(context: Context, tree: sx.SyntaxTree, heads: list[sx.System], broken: bool) -> None:
    """Check that the statements are there which every system needs; a missing one may be a line that is broken."""
    if broken:
        return
    if not heads:
        start = Span(tree.source, 0, 0)
        message = "the file declares no system" if tree.statements else "the file holds no statement"
        help_text = "begin with: system NAME \"title\"; 'fuzzyctl new NAME' writes a whole file"
        context.report("FZ004", message, start, help=help_text)
    else:
        declared = {s.keyword.text for s in tree.statements if isinstance(s, sx.Variable)}
        has_values = any(s.value is not None for s in context.outputs.values())
        missing = {
            "no input": "an 'input'" if "input" not in declared else "",
            "no output": "an 'output'" if "output" not in declared else "",
            "no rules": "a 'table' or an 'if' line"
            if not has_values and not any(isinstance(s, sx.Rule | sx.Table) for s in tree.statements)
            else "",
        }
        lacking = [what for what, repair in missing.items() if repair]
        if lacking:
            repairs = " and ".join(missing[what] for what in lacking)
            context.report(
                "FZ212", f"the system has {' and '.join(lacking)}", heads[0].name.span, help=f"add {repairs}"
            )


def _has_functions(statement: sx.Statement) -> bool:
    """Return whether a statement has consequents that read inputs."""
    kinds: list[str] = []
    match statement:
        case sx.Variable(value=value) if value is not None:
            return True
        case sx.Variable(keyword=keyword, terms=lines) if keyword.text == "output":
            kinds = [line.kind.text for line in lines if isinstance(line, sx.TermLine)]
        case sx.Rule(consequents=consequents) | sx.Otherwise(consequents=consequents):
            kinds = [c.term.kind.text for c in consequents if isinstance(c.term, sx.FunctionTerm)]
        case sx.Table(rows=rows):
            terms = [t for row in rows for cell in row.cells for t in cell.terms]
            kinds = [t.kind.text for t in terms if isinstance(t, sx.FunctionTerm)]
    return "linear" in kinds or "function" in kinds


def _build(
    context: Context, tree: sx.SyntaxTree, shared: Sequence[sx.Statement], head: sx.System | None, *, broken: bool
) -> FuzzySystem:
    """Build the system from all statements that have a meaning."""
    params: list[Param | None] = []
    inputs: list[Input] = []
    outputs: list[Output] = []
    lets: list[Let] = []
    guarantees: list[Guarantee | None] = []
    hedges: list[Hedge | None] = []
    semantics = resolve_semantics(context, tree.statements)
    context.has_functions = any(map(_has_functions, tree.statements))
    for s in tree.statements:
        match s:
            case sx.Param(name=name) if context.params.get(name.text) is s:
                params.append(resolve_param(context, s))
            case sx.Hedge(name=name) if context.hedges.get(name.text) is s:
                hedges.append(_hedge(context, s))
            case sx.Variable():
                variable = resolve_variable(context, s)
                if isinstance(variable, Output):
                    outputs.append(variable)
                elif isinstance(variable, Let):
                    lets.append(variable)
                else:
                    inputs.append(variable)
            case sx.Require():
                guarantees.append(resolve_require(context, s))
    method = replace(resolve_method(context, tree.statements), semantics=semantics)
    place = head.name.span if head is not None else None
    known_blocks: tuple[Block, ...] = ()
    if context.foreign or _few_rules(context, tree.statements, place):
        known_blocks = resolve_blocks(context, tree.statements, len(shared), broken=broken)
        if not context.foreign:
            find_idle_settings(context, tree.statements, shared, method, outputs, known_blocks)
    few = context.foreign or _few_outputs(context, len(outputs), place)
    return FuzzySystem(
        name=head.name.text if head is not None else "",
        title=head.title if head is not None else "",
        citation=_citation(context, tree),
        params=tuple(p for p in params if p is not None),
        hedges=tuple(h for h in hedges if h is not None),
        method=method,
        inputs=tuple(inputs),
        outputs=tuple(outputs),
        blocks=known_blocks if few else (),
        guarantees=tuple(g for g in guarantees if g is not None),
        path=tree.source.name,
        lets=tuple(lets),
        span=place,
    )


def _without_idle(system: FuzzySystem, shared: set[str]) -> FuzzySystem:
    """Leave out shared variables that the rules of this system do not name."""
    memberships = [t.membership for o in system.outputs for t in o.terms]
    memberships += [c.term for rule in system.rules for c in rule.consequents if not isinstance(c.term, str)]
    calls = [n for g in system.guarantees for n in walk(g.claim) if isinstance(n, Call)]
    if any(m.kind == "linear" for m in memberships) or any(
        c.function in {o.name for o in system.outputs} for c in calls
    ):
        return system  # these have been counted against all inputs
    named = {i.variable for rule in system.rules for i in literals(rule.antecedent)}
    named |= {c.output for rule in system.rules for c in rule.consequents}
    functions = [c.term for rule in system.rules for c in rule.consequents if not isinstance(c.term, str)]
    functions += [t.membership for o in system.outputs if o.name in named for t in o.terms]
    expressions = [a for m in functions for a in m.arguments]
    expressions += [e for o in system.outputs for e in (o.adaptive, o.value) if e is not None]
    expressions += [v.value for v in system.lets]
    expressions += [e for g in system.guarantees for e in (g.claim, g.when) if e is not None]
    named |= {n.name for e in expressions for n in names_in(e)}

    named |= {v.name for v in system.outputs if v.value is not None}

    def keep(name: str) -> bool:
        return name in named or name not in shared

    return replace(
        system,
        inputs=tuple(v for v in system.inputs if keep(v.name)),
        outputs=tuple(v for v in system.outputs if keep(v.name)),
    )


def _hedge(context: Context, s: sx.Hedge) -> Hedge | None:
    names = ChainMap[str, Any]({s.parameter.text: s}, context.params)
    expression = context.check_formula(s.expression, names, f"a param nor '{s.parameter.text}'")
    if expression is None:
        return None
    return Hedge(name=s.name.text, parameter=s.parameter.text, expression=expression, span=s.name.span)


def _few_rules(context: Context, statements: Sequence[sx.Statement], place: Span | None) -> bool:
    """Check the number of rules before any is resolved, so that no file keeps a reader waiting."""
    cells = sum(len(row.cells) for s in statements if isinstance(s, sx.Table) for row in s.rows)
    rules = cells + sum(isinstance(s, sx.Rule | sx.Otherwise) for s in statements)
    if rules > MAX_RULES:
        context.report("FZ112", f"the system has {rules} rules, more than {MAX_RULES}", place)
    return rules <= MAX_RULES


def _few_outputs(context: Context, outputs: int, place: Span | None) -> bool:
    """Check the number of outputs."""
    if outputs > MAX_OUTPUTS:
        help_text = "spread them over several systems"
        context.report("FZ112", f"the system has {outputs} outputs, more than {MAX_OUTPUTS}", place, help=help_text)
    return outputs <= MAX_OUTPUTS


def _citation(context: Context, tree: sx.SyntaxTree) -> str:
    citations = [s for s in tree.statements if isinstance(s, sx.Citation)]
    return "; ".join(c.text for c in citations)


Block = RuleTable | Rule | RuleBlock

#: An `otherwise` line waits until all rules of its block are resolved.
_Part = RuleTable | Rule | sx.Otherwise


def resolve_blocks(
    context: Context, statements: Sequence[sx.Statement], shared: int = 0, *, broken: bool = False
) -> tuple[Block, ...]:
    """Resolve all tables, rules and rule blocks.

    Args:
        context: The declarations; collects mistakes.
        statements: All statements of a system.
        shared: How many of them, from the first on, belong to other systems as well: a block among them ends there.
        broken: Whether some lines could not be read, so that a block without rules is not reported.

    Returns:
        Tables and rules of no block, then the blocks that have some rule with a meaning.
    """
    loose: list[_Part] = []
    blocks: list[tuple[sx.Rules, list[_Part]]] = []
    empty: list[sx.Rules] = []
    members, lost = loose, broken
    for position, s in enumerate(statements):
        if position == shared:
            members = loose
        match s:
            case sx.Rules():
                members = []
                blocks.append((s, members))
                empty.append(s)
            case sx.Rule() | sx.Table() | sx.Otherwise():
                if blocks and members is blocks[-1][1] and blocks[-1][0] in empty:
                    empty.remove(blocks[-1][0])
                before = len(context.diagnostics)
                part = _part(context, s)
                members.extend([part] if part is not None else [])
                lost = lost or any(d.severity == "error" for d in context.diagnostics[before:])
    if not broken:
        _tell_empty(context, empty)
    results = [
        _block(context, head, _complete(context, parts, broken=lost)) for head, parts in _each_once(context, blocks)
    ]
    return (*_complete(context, loose, broken=lost), *(b for b in results if b is not None))


def _part(context: Context, statement: sx.Rule | sx.Table | sx.Otherwise) -> _Part | None:
    match statement:
        case sx.Rule():
            return resolve_rule(context, statement)
        case sx.Table():
            return resolve_table(context, statement)
    return statement


def _complete(context: Context, parts: Sequence[_Part], *, broken: bool) -> list[RuleTable | Rule]:
    """Resolve the `otherwise` lines of a block, which need all of its rules, wherever these are written."""
    resolved = [p for p in parts if not isinstance(p, sx.Otherwise)]
    if len(resolved) == len(parts):
        return resolved
    others: dict[str, list[Antecedent]] = {}
    for rule in (rule for part in resolved for rule in rules_of(part)):
        for output in dict.fromkeys(c.output for c in rule.consequents):
            others.setdefault(output, []).append(rule.antecedent)
    first: dict[str, sx.Word] = {}
    parts_and_defaults: list[RuleTable | Rule] = []
    for part in parts:
        if not isinstance(part, sx.Otherwise):
            parts_and_defaults.append(part)
        elif all([context.is_first(c.output, first, f"'otherwise' of '{c.output.text}'") for c in part.consequents]):
            parts_and_defaults.extend(resolve_otherwise(context, part, others, broken=broken))
    return parts_and_defaults


def _tell_empty(context: Context, empty: Sequence[sx.Rules]) -> None:
    for head in empty:
        message = f"rule block '{head.name.text}' has no rules"
        help_text = "put its tables and 'if' lines below it, or remove it"
        context.report("FZ212", message, head.name.span, help=help_text)


def _each_once(context: Context, blocks: Sequence[tuple[sx.Rules, list[_Part]]]) -> list[tuple[sx.Rules, list[_Part]]]:
    """Return the blocks whose names are taken by no block before."""
    first: dict[str, sx.Rules] = {}
    results = []
    for head, parts in blocks:
        context.is_free(head.name, "a rule block")
        earlier = first.setdefault(head.name.text, head)
        if earlier is head:
            results.append((head, parts))
            continue
        note = (earlier.name.span, "first declared here")
        message = f"there is a rule block '{head.name.text}' already"
        context.report("FZ201", message, head.name.span, note=note, help="rename it, or move its rules there")
    return results


def _block(context: Context, head: sx.Rules, parts: Sequence[RuleTable | Rule]) -> RuleBlock | None:
    values = resolve_rule_settings(context, head)
    return RuleBlock(name=head.name.text, rules=tuple(parts), span=head.name.span, **values) if parts else None
