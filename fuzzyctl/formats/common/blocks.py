"""Rules and rule blocks of other tools' files: their methods when read, and the forms in which formats have them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.formats.common.report import Names
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import Activation, RuleMethod
from fuzzyctl.model.rule import Consequent, Rule, RuleBlock, RuleTable
from fuzzyctl.model.system import FuzzySystem

# --- read ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class FoundBlock:
    """A rule block of a file.

    Args:
        name: Its name, or nothing; the rules of the first block without a name belong to no block.
        rules: Its rules.
        conjunction: The norm of `and`, which counts only if a rule joins by it.
        disjunction: The norm of `or`, which counts only if a rule joins by it.
        implication: The norm that activations change sets by; None without sets.
        activation: Its activation method.
        span: The place of its beginning.
    """

    name: str
    rules: tuple[sx.Rule, ...]
    conjunction: str | None
    disjunction: str | None
    implication: str | None
    activation: Activation
    span: Span | None = None

    @property
    def outputs(self) -> set[str]:
        """The outputs that its rules set."""
        return {c.output.text for rule in self.rules for c in rule.consequents}

    @property
    def joins(self) -> set[str]:
        """The words, `and` or `or`, by which its rules join their conditions."""
        return {word for rule in self.rules for word in joins_of(rule)}

    def with_norms(self, conjunction: str | None, disjunction: str | None, implication: str | None) -> FoundBlock:
        """Return the block with other norms."""
        return replace(self, conjunction=conjunction, disjunction=disjunction, implication=implication)


@dataclass(frozen=True)
class Arrangement:
    """The rules of a file, in blocks only if these have a meaning.

    Args:
        loose: The rules of no block.
        blocks: The name of each block, the block, and the fields of its method that differ from the system's.
        method: The fields `conjunction`, `disjunction`, `implication`, `activation` of the system's method that some
            rule needs.
        implications: The implications of outputs, if there are no blocks that have them.
    """

    loose: tuple[sx.Rule, ...]
    blocks: tuple[tuple[str, FoundBlock, dict[str, Any]], ...] = ()
    method: dict[str, Any] = field(default_factory=dict)
    implications: dict[str, str] = field(default_factory=dict)


#: The fields of a block that are fields of a method, too.
_FIELDS = ("conjunction", "disjunction", "implication", "activation")


def arranged(file: Sequence[FoundBlock], sets: Collection[str], *, keep: bool) -> Arrangement:
    """Return the rules of a file, in blocks only if these have a meaning.

    Args:
        file: The blocks, each with some rule.
        sets: The outputs whose defuzzifiers look at sets; implication matters to no others.
        keep: Whether several blocks without a difference stay blocks.
    """
    blocks = [_without_idle(block, sets) for block in file]
    values = {name: [v for b in blocks if (v := getattr(b, name)) is not None] for name in _FIELDS}
    method = {name: first for name, (first, *_) in ((n, v) for n, v in values.items() if v)}
    by_output = {o: dict.fromkeys(b.implication for b in blocks if b.implication and o in b.outputs) for o in sets}
    same = all(len(set(values[n])) < 2 for n in ("conjunction", "disjunction", "activation"))
    same = same and all(len(implications) < 2 for implications in by_output.values())
    if len(blocks) < 2 or (same and not any(b.activation.compares for b in blocks) and not keep):
        implications = {o: next(iter(i)) for o, i in by_output.items() if i}
        return Arrangement(tuple(r for b in blocks for r in b.rules), (), method, implications)
    # The first block has the methods of the system, so that without a name it need not be a block.
    loose = blocks[0].rules if not blocks[0].name else ()
    names = Names(b.name for b in blocks)
    used: set[str] = set()
    named: list[tuple[str, FoundBlock, dict[str, Any]]] = []
    for k, block in enumerate(blocks[1:] if loose else blocks, 2 if loose else 1):
        name = block.name if block.name and block.name not in used else names.take(block.name or f"block{k}")
        used.add(name)
        fields = {n: getattr(block, n) for n in _FIELDS}
        named.append((name, block, {n: None if v == method.get(n) else v for n, v in fields.items()}))
    return Arrangement(loose, tuple(named), method)


def _without_idle(block: FoundBlock, sets: Collection[str]) -> FoundBlock:
    """Return a block without norms by which no rule joins, and without an implication if its rules set no sets."""
    joins = block.joins
    return block.with_norms(
        block.conjunction if "and" in joins else None,
        block.disjunction if "or" in joins else None,
        block.implication if any(o in sets for o in block.outputs) else None,
    )


def joins_of(rule: sx.Rule) -> set[str]:
    """Return the words, `and` or `or`, by which a rule joins its conditions."""
    words: set[str] = set()
    truths = [rule.antecedent]
    while truths:
        truth = truths.pop()
        if isinstance(truth, sx.Chain):
            words.add(truth.connective)
            truths += truth.operands
        elif isinstance(truth, sx.Negation | sx.Group):
            truths.append(truth.operand)
    return words


# --- written -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class BlockPart:
    """A rule block in formats whose blocks have one implication.

    Args:
        block: Position of the rule block of the system, -1 for the rules of none.
        number: Its number among the parts of one block, from 1 on.
        method: The method of its rules.
        implication: The norm that activations change sets by.
        rules: Its rules with their positions in the system, each with the consequents that have this implication.
    """

    block: int
    number: int
    method: RuleMethod
    implication: str
    rules: tuple[tuple[int, Rule], ...]


def block_parts(system: FuzzySystem) -> list[BlockPart]:
    """Return the rules of a system in blocks of one implication; consequents of averages stay with the first."""
    parts: list[BlockPart] = []
    for block in sorted({m.block for m in system.rule_methods}):
        positions = [r for r, m in enumerate(system.rule_methods) if m.block == block]
        method = system.rule_methods[positions[0]]
        for number, (implication, outputs) in enumerate(_by_implication(system, positions).items(), 1):
            rules = []
            for r in positions:
                consequents = tuple(c for c in system.rules[r].consequents if c.output in outputs)
                if consequents:
                    rules.append((r, system.rules[r].model_copy(update={"consequents": consequents})))
            parts.append(BlockPart(block, number, method, implication, tuple(rules)))
    return parts


def _by_implication(system: FuzzySystem, rules: Sequence[int]) -> dict[str, list[str]]:
    """Return the outputs of the rules of one block by their implication; outputs over rules go with the first."""
    concluded = {c.output for r in rules for c in system.rules[r].consequents}
    outputs: dict[str, list[str]] = {}
    over_rules: list[str] = []
    for output in (o for o in system.outputs if o.name in concluded):
        if (output.defuzzifier or system.method.defuzzifier).over_rules:
            over_rules.append(output.name)
        else:
            outputs.setdefault(system.implication_of(rules[0], output), []).append(output.name)
    if not outputs:
        return {system.rule_methods[rules[0]].implication or system.method.implication: over_rules}
    next(iter(outputs.values())).extend(over_rules)
    return outputs


def flattened(system: FuzzySystem) -> FuzzySystem:
    """Return a system whose rules all have the methods of the first one, for formats without blocks.

    The implication of a block becomes that of the outputs that its rules set, as far as they agree.
    """
    if not system.rule_blocks:
        return system
    first = system.rule_methods[0]
    fields = {n: getattr(first, n) for n in ("conjunction", "disjunction", "activation")}
    outputs = tuple(o.model_copy(update={"implication": system.implications_of(o)[0]}) for o in system.outputs)
    update = {"blocks": system.rules, "method": system.method.model_copy(update=fields), "outputs": outputs}
    return system.model_copy(update=update)


def without_repeated_outputs(system: FuzzySystem) -> FuzzySystem:
    """Return a system whose rules set each output once, with equal numbers.

    Raises:
        DiagnosticError: With the places of rules that cannot be written as several, since their activation method
            counts or compares rules.
    """
    repeating = [(rule, m) for rule, m in zip(system.rules, system.rule_methods, strict=True) if _repeats(rule)]
    if not repeating:
        return system
    counts = system.method.semantics.total == "all_rules"
    refusals = [_refusal(system, rule) for rule, method in repeating if counts or method.activation.compares]
    if refusals:
        raise DiagnosticError(refusals)
    carried = system.method.semantics.consequent_hedges == "carried"
    blocks: list[Rule | RuleTable | RuleBlock] = []
    for block in system.blocks:
        if isinstance(block, RuleBlock):
            parts = tuple(piece for part in block.rules for piece in _split(part, carried))
            blocks.append(block.model_copy(update={"rules": parts}))
        else:
            blocks += _split(block, carried)
    return system.model_copy(update={"blocks": tuple(blocks)})


def _repeats(rule: Rule) -> bool:
    return len({c.output for c in rule.consequents}) < len(rule.consequents)


def _refusal(system: FuzzySystem, rule: Rule) -> Diagnostic:
    message = (
        "a rule that sets an output twice can be written as two rules only where rules are not compared or counted"
    )
    place = next((c.span for c in rule.consequents if c.span is not None), rule.span)
    file = "" if place is not None else system.path
    return Diagnostic("FZ608", message, place, help="convert it to .fll, or let the rules set it once", file=file)


def _split(part: Rule | RuleTable, carried: bool) -> Iterator[Rule | RuleTable]:
    """Yield a table, or a rule as several: each takes the first remaining consequents of each output."""
    if isinstance(part, RuleTable) or not _repeats(part):
        yield part
        return
    rest = _with_hedges(part.consequents) if carried else list(part.consequents)
    while rest:
        outputs = dict.fromkeys(c.output for c in rest)
        firsts = [next(c for c in rest if c.output == output) for output in outputs]
        if carried:
            # A hedge would be carried on within the rule once more.
            firsts = firsts[:1]
        rest = [c for c in rest if all(c is not first for first in firsts)]
        yield part.model_copy(update={"consequents": tuple(firsts)})


def _with_hedges(consequents: Sequence[Consequent]) -> list[Consequent]:
    """Return consequents with the hedges that earlier ones carry on: the nearest to a term acts first."""
    changed, before = [], tuple[str, ...]()
    for c in consequents:
        before = (*c.hedges, *before)
        changed.append(c.model_copy(update={"hedges": before}))
    return changed
