"""Resolution of `rules NAME` lines: tables and rules of each rule block, and its settings."""

from __future__ import annotations

from collections.abc import Sequence

from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.rule import Antecedent, Rule, RuleBlock, RuleTable, rules_of
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.rules import resolve_otherwise, resolve_rule
from fuzzyctl.resolve.settings import resolve_rule_settings
from fuzzyctl.resolve.tables import resolve_table

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
