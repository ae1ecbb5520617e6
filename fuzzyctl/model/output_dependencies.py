"""Dependencies between outputs: which outputs the rules of an output read."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Expr, names_in, span_of
from fuzzyctl.model.method import Activation
from fuzzyctl.model.rule import Rule, RuleTable, literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Let, Membership, Output


def reads_of(system: FuzzySystem) -> Iterator[tuple[str, dict[str, Span | None]]]:
    """Yield for each consequent its output and the outputs that its rule waits for, each with its place.

    A rule waits for outputs in its antecedent, unless they count there with the degree that the rules before have
    reached; for outputs that its consequent is a function of; and where an activation method compares it with others,
    for what these wait for.
    """
    outputs = {o.name: o for o in system.outputs}
    for output in system.outputs:
        if output.value is not None:
            yield output.name, {n.name: span_of(n) for n in names_in(output.value) if n.name in outputs}
    waits = system.method.semantics.chained == "value"
    functions = {(o.name, t.name): t.membership for o in system.outputs for t in o.terms if _is_function(t.membership)}
    compares = any(b.activation is not None and b.activation.compares for b in system.rule_blocks)
    compared = _compared(system) if waits and (compares or system.method.activation.compares) else {}
    waits = waits and (bool(compared) or _reads_any(system, outputs))
    for rule, method in zip(system.rules, system.rule_methods, strict=True):
        read = _read(rule, outputs) if waits else {}
        if waits and method.activation.compares:
            read = compared[method.block] | read
        for consequent in rule.consequents:
            term = consequent.term
            membership = functions.get((consequent.output, term)) if isinstance(term, str) else term
            inside = _in_function(outputs, membership) if membership is not None and _is_function(membership) else {}
            yield consequent.output, read | inside


def ordered_lets(system: FuzzySystem) -> tuple[Let, ...]:
    """Return the lets each after those it reads; those of a circle, which is reported, come last."""
    order: dict[str, Let] = {}
    left = {v.name: v for v in system.lets}
    while left:
        ready = [v for v in left.values() if not any(n.name in left for n in names_in(v.value))]
        order |= {v.name: v for v in ready or left.values()}
        left = {name: v for name, v in left.items() if name not in order}
    return tuple(order.values())


def values_of(system: FuzzySystem) -> Iterator[Expr]:
    """Yield the expressions of lets, and of outputs that are formulas."""
    yield from (v.value for v in system.lets)
    yield from (o.value for o in system.outputs if o.value is not None)


def comparisons_that_wait(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find for each rule block whose activation method compares rules one that reads an output of another one."""
    blocks: dict[int, list[Rule]] = {}
    methods: dict[int, Activation] = {}
    for rule, method in zip(system.rules, system.rule_methods, strict=True):
        if method.activation.compares:
            blocks.setdefault(method.block, []).append(rule)
            methods[method.block] = method.activation
    for block, rules in blocks.items():
        yield from _comparison_that_waits(system, rules, methods[block])


def _comparison_that_waits(system: FuzzySystem, rules: Sequence[Rule], method: Activation) -> Iterator[Diagnostic]:
    """Find the same for the rules of one block, or of none."""
    concluded = {c.output for rule in rules for c in rule.consequents}
    reader = next((i for rule in rules for i in literals(rule.antecedent) if i.variable in concluded), None)
    if reader is not None:
        among = "all rules" if not system.rule_blocks else "the rules of a block"
        message = f"activation '{method.kind}' compares {among} at once, and some of them read an output"
        message += " that others set" if system.rule_blocks else ""
        note = (Note(reader.span, f"'{reader.variable}' is read here"),) if reader.span is not None else ()
        help_text = "use 'activation general', or put the rules that read it into a rule block of their own"
        yield Diagnostic("FZ214", message, method.span or reader.span, help=help_text, notes=note)


def _compared(system: FuzzySystem) -> dict[int, dict[str, Span | None]]:
    """Return for each rule block, and -1 for none, the outputs that its rules read and that it does not set itself."""
    outputs = {o.name: o for o in system.outputs}
    results: dict[int, dict[str, Span | None]] = {}
    for rule, method in zip(system.rules, system.rule_methods, strict=True):
        results[method.block] = results.get(method.block, {}) | _read(rule, outputs)
    for rule, method in zip(system.rules, system.rule_methods, strict=True):
        for consequent in rule.consequents:
            results[method.block].pop(consequent.output, None)
    return results


def _read(rule: Rule, outputs: Container[str]) -> dict[str, Span | None]:
    return {i.variable: i.span for i in literals(rule.antecedent) if i.variable in outputs}


def _reads_any(system: FuzzySystem, outputs: Container[str]) -> bool:
    """Whether any antecedent names an output; a table names its inputs in its head."""
    for part in system.tables_and_rules:
        heads = (part.condition,) if isinstance(part, RuleTable) else (part.antecedent,)
        if isinstance(part, RuleTable) and (part.rows in outputs or part.columns in outputs):
            return True
        if any(i.variable in outputs for head in heads if head is not None for i in literals(head)):
            return True
    return False


def _is_function(membership: Membership) -> bool:
    return membership.kind == "function"


def _in_function(outputs: dict[str, Output], membership: Membership) -> dict[str, Span | None]:
    return {n.name: span_of(n) for n in names_in(membership.arguments[0]) if n.name in outputs}
