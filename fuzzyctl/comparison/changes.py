"""Changes between two systems: settings, terms, rules and cells, not lines of text."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from fuzzyctl.comparison.rules import Matches, RulePair, flat_rules, matches, rule_pairs, with_blocks
from fuzzyctl.comparison.settings import defuzzifier_settings, otherwise_text, plain_text, settings
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import ExprError, to_text
from fuzzyctl.formats.fz import block_text, defuzzifier_text, let_lines, membership_text
from fuzzyctl.formats.fz_strings import guarantee_text
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.block import Hedge, Node
from fuzzyctl.model.method import KNOBS, Method
from fuzzyctl.model.rule import literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Let, LinguisticVariable, Output, Term
from fuzzyctl.support import arguments

if TYPE_CHECKING:
    from fuzzyctl.model.controller import EquationBlock

#: Positions of one rule in two systems.
Places = tuple[int, int]


def order_changed(a: FuzzySystem, b: FuzzySystem, pairs: Sequence[RulePair]) -> bool:
    """Return whether rules are in another order and that changes a result.

    Adaptive outputs have one state a rule, in the order written. Activation methods that choose rules go through those
    of their block. Where an antecedent reads how far the rules before it have activated an output, it matters which of
    the rules that set this output stand before.
    """
    places = sorted({pair.places for pair in pairs if pair.places})
    if any(o.adaptive is not None for s in (a, b) for o in s.outputs):
        return _inverted(places)
    return any(map(_inverted, _by_block(a, b, places))) or _reads_others(a, b, places)


def _inverted(places: Sequence[Places]) -> bool:
    return any(later < earlier for (_, earlier), (_, later) in itertools.pairwise(places))


def _by_block(a: FuzzySystem, b: FuzzySystem, places: Sequence[Places]) -> list[list[Places]]:
    """Return the places of rules that are chosen by their order, for each block of the first system."""
    by_block: dict[int, list[Places]] = {}
    for i, j in places:
        methods = a.rule_methods[i], b.rule_methods[j]
        if any(m.activation.compares and m.activation.kind != "proportional" for m in methods):
            by_block.setdefault(methods[0].block, []).append((i, j))
    return list(by_block.values())


def _reads_others(a: FuzzySystem, b: FuzzySystem, places: Sequence[Places]) -> bool:
    """Whether a rule reads an output whose rules stand before it in one system and behind it in the other."""
    if all(s.method.semantics.chained != "degree" for s in (a, b)):
        return False
    setting: dict[str, list[Places]] = {o.name: [] for o in a.outputs}
    for i, j in places:
        for output in {c.output for c in a.rules[i].consequents}:
            setting[output].append((i, j))
    for i, j in places:
        for output in {p.variable for p in literals(a.rules[i].antecedent)} & setting.keys():
            if any((p < i) != (q < j) for p, q in setting[output] if (p, q) != (i, j)):
                return True
    return False


_Key = TypeVar("_Key")
_Value = TypeVar("_Value")
Kind = Literal["added", "removed", "changed", "renamed", "rewritten"]


@dataclass(frozen=True)
class Change:
    """One thing that differs.

    Args:
        kind: `rewritten` for an expression that is written in another way and has the same value.
        what: What kind of thing it is: `term`, `cell`, `rule`, `input`, `setting` and so on.
        name: Which one, such as `NB of sigma`.
        before: How the first system writes it; None where it was added.
        after: How the second one does; None where it was removed.
        before_line: Line in the first file; None for a system that was not read from one.
        after_line: Line in the second file.
    """

    kind: Kind
    what: str
    name: str
    before: str | None
    after: str | None
    before_line: int | None = None
    after_line: int | None = None


def changes(a: FuzzySystem, b: FuzzySystem) -> tuple[Change, ...]:
    """Return the changes between two systems, in the order of a rule file; none for systems that mean the same.

    Spaces, comments and layout do not count. A variable or term whose name alone changed is `renamed`, and rules that
    name it are the same rules. Rules are matched by their antecedents, those of one antecedent by their consequents,
    whether they stand in a table or alone; where no activation method compares rules with each other, neither their
    order counts nor whether one rule says two things or two rules one each.

    Raises:
        ArgumentError: For anything but a FuzzySystem.
    """
    for system in (a, b):
        arguments.instance("what is compared", FuzzySystem, "a FuzzySystem", system)
    pairs = with_blocks(a, b, matches(a, b))
    return (
        *_named(a, b),
        *_settings(a, b),
        *_params(a, b),
        *_variables(a, b, pairs),
        *_blocks(a, b, pairs),
        *_rules(a, b, pairs),
        *_guarantees(a, b),
    )


def _line(node: Node | None) -> int | None:
    span: Span | None = node.span if node is not None else None
    return span.source.line_of(span.start) if span is not None else None


def _line_of(method: Method, setting: str) -> int | None:
    """Return the line of the statement that says a setting; None for a default."""
    word = "defuzzifier" if setting in defuzzifier_settings(method.defuzzifier) else setting
    span = method.semantics.span if word in ("profile", *KNOBS) else method.spans.get(word)
    return span.source.line_of(span.start) if span is not None else None


def _change(what: str, name: str, before: str | None, after: str | None, *nodes: Node | None) -> Change:
    first, second = nodes if nodes else (None, None)
    return Change(_kind(before, after), what, name, before, after, _line(first), _line(second))


def _kind(before: object, after: object) -> Kind:
    return "added" if before is None else "removed" if after is None else "changed"


def _differing(
    first: Mapping[_Key, _Value], second: Mapping[_Key, _Value]
) -> Iterator[tuple[_Key, _Value | None, _Value | None]]:
    """Yield the keys of different values with both values, None for a value that is missing."""
    for key in dict.fromkeys([*first, *second]):
        if first.get(key) != second.get(key):
            yield key, first.get(key), second.get(key)


def _named(a: FuzzySystem, b: FuzzySystem) -> Iterator[Change]:
    if a.name != b.name:
        yield Change("renamed", "system", a.name, a.name, b.name, _line(a), _line(b))
    for what in ("title", "citation"):
        if getattr(a, what) != getattr(b, what):
            yield _change(what, "", getattr(a, what) or None, getattr(b, what) or None)


def _settings(a: FuzzySystem, b: FuzzySystem) -> Iterator[Change]:
    for name, before, after in _differing(settings(a.method), settings(b.method)):
        lines = (_line_of(s.method, name) for s in (a, b))
        yield Change("changed", "setting", name, before, after, *lines)


def _params(a: FuzzySystem, b: FuzzySystem) -> Iterator[Change]:
    params = [{p.name: (to_text(p.expression), p.unit, p) for p in s.params} for s in (a, b)]
    for name in _union(*params):
        first, second = (p.get(name) for p in params)
        if first is None or second is None:
            yield _change(
                "param", name, first and first[0], second and second[0], first and first[2], second and second[2]
            )
        elif plain_text(first[2].expression) != plain_text(second[2].expression):
            kind: Kind = "rewritten" if a.values[name] == b.values[name] else "changed"
            yield Change(kind, "param", name, first[0], second[0], _line(first[2]), _line(second[2]))
        elif first[1] != second[1]:
            yield _change("unit", name, first[1] or None, second[1] or None, first[2], second[2])
    for name, before, after in _differing(*({h.name: h for h in s.hedges} for s in (a, b))):
        yield _change("hedge", name, _hedge(before), _hedge(after), before, after)
    for name, old, new in _differing(*({v.name: v for v in s.lets} for s in (a, b))):
        yield _change("let", name, _let(old), _let(new), old, new)


def _let(v: Let | None) -> str | None:
    return "; ".join(let_lines(v)) if v is not None else None


def _hedge(h: Hedge | None) -> str | None:
    return f"{h.name}({h.parameter}) = {to_text(h.expression)}" if h is not None else None


def _variables(a: FuzzySystem, b: FuzzySystem, pairs: Matches) -> Iterator[Change]:
    for what, one, other in (("input", a.inputs, b.inputs), ("output", a.outputs, b.outputs)):
        second = {pairs.variable(v.name): v for v in other}
        for v in one:
            if v.name not in second:
                yield _change(what, v.name, _head(v), None, v, None)
            else:
                yield from _variable(a, b, what, v, second[v.name], pairs)
        names = {v.name for v in one}
        for w in other:
            if pairs.variable(w.name) not in names:
                yield _change(what, w.name, None, _head(w), None, w)
        order = [pairs.variable(v.name) for v in other if pairs.variable(v.name) in names]
        if order != (common := [v.name for v in one if v.name in second]):
            yield Change("changed", f"order of {what}s", "", ", ".join(common), ", ".join(order))


def _head(v: LinguisticVariable) -> str:
    return f"in [{to_text(v.lower)}, {to_text(v.upper)}] with terms {', '.join(t.name for t in v.terms)}"


def _variable(
    a: FuzzySystem, b: FuzzySystem, what: str, v: LinguisticVariable, w: LinguisticVariable, pairs: Matches
) -> Iterator[Change]:
    if v.name != w.name:
        yield Change("renamed", what, v.name, v.name, w.name, _line(v), _line(w))
    before, after = (f"[{to_text(x.lower)}, {to_text(x.upper)}]" for x in (v, w))
    if [plain_text(x) for x in (v.lower, v.upper)] != [plain_text(x) for x in (w.lower, w.upper)]:
        same = (a.number(v.lower), a.number(v.upper)) == (b.number(w.lower), b.number(w.upper))
        kind: Kind = "rewritten" if same else "changed"
        yield Change(kind, "range", v.name, before, after, _line(v), _line(w))
    for feature, old, new in _differing(_features(v), _features(w)):
        yield _change(feature, v.name, old, new, v, w)
    yield from _terms(a, b, v, w, pairs)


def _features(v: LinguisticVariable) -> dict[str, str]:
    """Return the settings of a variable besides its range and terms, as texts."""
    features: dict[str, str | None] = {"label": v.label, "unit": v.unit}
    match v:
        case Input():
            features["outside"] = "extrapolated" if v.extrapolate else "clamped"
        case Output():
            features |= {
                "else": otherwise_text(v.otherwise),
                "adaptive rate": plain_text(v.adaptive) if v.adaptive is not None else None,
                "clamp": "clamped" if v.clamped else None,
                "formula": plain_text(v.value) if v.value is not None else None,
                "implication": v.implication,
                "aggregation": v.aggregation,
            }
            if v.defuzzifier is not None:
                features["defuzzifier"] = defuzzifier_text(v.defuzzifier)
    return {name: text for name, text in features.items() if text}


def _terms(
    a: FuzzySystem, b: FuzzySystem, v: LinguisticVariable, w: LinguisticVariable, pairs: Matches
) -> Iterator[Change]:
    second = {pairs.term(w.name, t.name): t for t in w.terms}
    for t in v.terms:
        u = second.get(t.name)
        if u is None:
            yield _change("term", f"{t.name} of {v.name}", membership_text(t.membership), None, t, None)
            continue
        if t.name != u.name:
            yield Change("renamed", "term", f"{t.name} of {v.name}", t.name, u.name, _line(t), _line(u))
        if _spelt(t) != _spelt(u):
            kind: Kind = "rewritten" if _numbers(a, t) == _numbers(b, u) else "changed"
            texts = membership_text(t.membership), membership_text(u.membership)
            yield Change(kind, "term", f"{t.name} of {v.name}", *texts, _line(t), _line(u))
    names = {t.name for t in v.terms}
    for u in w.terms:
        if pairs.term(w.name, u.name) not in names:
            yield _change("term", f"{u.name} of {v.name}", None, membership_text(u.membership), None, u)


def _spelt(term: Term) -> tuple[str, ...]:
    """Return a membership function as texts that do not depend on how its numbers are spelt."""
    m = term.membership
    return m.kind, *map(plain_text, m.arguments), plain_text(m.height)


def _numbers(system: FuzzySystem, term: Term) -> tuple[Any, ...]:
    """Return kind, numbers and height of a term; a function over inputs stands for itself."""
    m = term.membership
    try:
        return (m.kind, *(system.number(x) for x in m.arguments), system.number(m.height))
    except ExprError:
        return (m.kind, m.arguments, m.height)


def _blocks(a: FuzzySystem, b: FuzzySystem, pairs: Matches) -> Iterator[Change]:
    first = {block.name: block for block in a.rule_blocks}
    second = {pairs.block(block.name): block for block in b.rule_blocks}
    for name in _union(list(first), list(second)):
        before, after = first.get(name), second.get(name)
        if before and after and before.name != after.name:
            yield Change("renamed", "rule block", name, name, after.name, _line(before), _line(after))
            before = replace(before, name=after.name)
        one, other = (block_text(block) if block else None for block in (before, after))
        if one != other:
            yield _change("rule block", name, one, other, before, after)


def _rules(a: FuzzySystem, b: FuzzySystem, matched: Matches) -> Iterator[Change]:
    wholes = any(m.activation.compares for s in (a, b) for m in s.rule_methods)
    carried = all(s.method.semantics.consequent_hedges == "carried" for s in (a, b))
    rules = flat_rules(a, carried=carried), flat_rules(b, matched, carried=carried)
    pairs = list(rule_pairs(*rules, wholes=wholes))
    for pair in pairs:
        yield from _rule(pair)
    if order_changed(a, b, pairs):
        yield Change("changed", "order of rules", "", "as before", "another, which counts here")


def _rule(pair: RulePair) -> Iterator[Change]:
    before, after = pair.before, pair.after
    one = before or after
    assert one is not None
    nodes = before.rule if before else None, after.rule if after else None
    if pair.changed:
        for output, first, second in pair.changed:
            yield _change(one.what, f"{one.name} then {output}", first, second, *nodes)
    elif before is None or after is None:
        yield _change(one.what, one.name, before.text if before else None, after.text if after else None, *nodes)
    if before and after and before.block != after.block:
        blocks = before.block or "none", after.block or "none"
        yield Change("changed", "block of rule", one.name, *blocks, *map(_line, nodes))


def _guarantees(a: FuzzySystem, b: FuzzySystem) -> Iterator[Change]:
    first, second = Counter(a.guarantees), Counter(b.guarantees)
    for g in (first - second).elements():
        yield _change("guarantee", "", guarantee_text(g), None, g, None)
    for g in (second - first).elements():
        yield _change("guarantee", "", None, guarantee_text(g), None, g)


def _union(a: Mapping[str, Any] | Sequence[str], b: Mapping[str, Any] | Sequence[str]) -> list[str]:
    return list(dict.fromkeys([*a, *b]))


#: The lines of a file about each code: the text for the code alone, and the line.
Policy = dict[str, tuple[str | None, int | None]]


def policy_changes(first: Sequence[sx.Allow], second: Sequence[sx.Allow]) -> tuple[Change, ...]:
    """Return the changes of the codes that two rule files allow and deny, and of the reasons; one change a code.

    Where codes share a line, and in which order the lines stand, does not count. A code that is both allowed and denied
    is denied. Files of other tools have no such lines.
    """
    return tuple(_policy_changes(_policy(first), _policy(second)))


def _policy_changes(first: Policy, second: Policy) -> Iterator[Change]:
    for code in dict.fromkeys([*first, *second]):
        (before, line), (after, other_line) = first.get(code, (None, None)), second.get(code, (None, None))
        if before != after:
            yield Change(_kind(before, after), "diagnostic", code, before, after, line, other_line)


def _policy(lines: Sequence[sx.Allow]) -> Policy:
    policy: Policy = {}
    for line in lines:
        for code in (c.text for c in line.codes):
            word = line.keyword.text
            if code not in policy or word == "deny":
                policy[code] = f'{word} {code} "{line.reason}"' if line.reason else f"{word} {code}", line.span.line
    return policy


def block_changes(
    first: Sequence[EquationBlock], second: Sequence[EquationBlock]
) -> list[tuple[str, tuple[Change, ...]]]:
    """Return the changes of the blocks of the same kind and name, as `KIND NAME` with its changes.

    The order of statements does not count.
    """
    blocks = ({f"{b.kind} {b.name}": b for b in side} for side in (first, second))
    return [(name, tuple(_block_changes(name, one, other))) for name, one, other in _differing(*blocks)]


def _block_changes(name: str, one: EquationBlock | None, other: EquationBlock | None) -> Iterator[Change]:
    if one is None or other is None:
        keyword, _, rest = name.partition(" ")
        texts = (None, "in the second file only") if one is None else ("in the first file only", None)
        yield Change(_kind(one, other), keyword, rest, *texts)
        return
    for key, old, new in _differing(_statements(one), _statements(other)):
        yield Change(_kind(old, new), *key, old, new)


def _statements(block: EquationBlock) -> dict[tuple[str, str], str]:
    """Return the statements of a block by keyword and name; claims by their text."""
    from fuzzyctl.formats.fz_blocks import sections

    texts = {("title", ""): block.title, ("source", ""): block.citation}
    for line in sections(block):
        keyword, _, rest = line.partition(" ")
        name = rest.partition(" ")[0].partition("(")[0] if keyword not in ("every", "run", "require") else ""
        texts[keyword, rest if keyword == "require" else name] = line
    texts.pop(("", ""), None)
    return {key: text for key, text in texts.items() if text}
