"""Rule blocks of other tools' files: settings of the system, and those of each block."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.formats.common.report import Names
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import Activation, RuleMethod
from fuzzyctl.model.rule import Consequent, Rule, RuleBlock, RuleTable
from fuzzyctl.model.system import FuzzySystem


@dataclass(frozen=True)
class FoundBlock:
    """A rule block of a file.

    Args:
        name: Its name, empty for none; the first of several that has none is no block then.
        rules: Its rules, as nodes of the syntax tree or of the model.
        conjunction: How they join by `and`; it counts only where one does.
        disjunction: How they join by `or`; it counts only where one does.
        implication: What activations make of the sets that they conclude, None where they conclude none.
        activation: Which of them act.
        span: Where it begins.
    """

    name: str
    rules: tuple[Any, ...]
    conjunction: str | None
    disjunction: str | None
    implication: str | None
    activation: Activation
    span: Span | None = None

    @property
    def outputs(self) -> set[str]:
        """The outputs that its rules set."""
        named = (c.output for rule in self.rules for c in rule.consequents)
        return {o.text if isinstance(o, sx.Word) else o for o in named}

    def with_norms(self, conjunction: str | None, disjunction: str | None, implication: str | None) -> FoundBlock:
        """Return the block with other norms."""
        return replace(self, conjunction=conjunction, disjunction=disjunction, implication=implication)

    @property
    def joins(self) -> set[str]:
        """What its rules join their conditions by."""
        return {word for rule in self.rules for word in joins_of(rule)}


@dataclass(frozen=True)
class Arrangement:
    """The rules of a file, in blocks only where these have a meaning.

    Args:
        loose: The rules of no block, as the file's reader made them.
        blocks: The blocks: the name of each, the block, and the fields of its method that differ from the system's.
        method: What the system says: the fields `conjunction`, `disjunction`, `implication`, `activation` of its
            method, without those that no rule needs.
        implications: Implications that outputs say themselves, since no block does.
    """

    loose: tuple[Any, ...]
    blocks: tuple[tuple[str, FoundBlock, dict[str, Any]], ...] = ()
    method: dict[str, Any] = field(default_factory=dict)
    implications: dict[str, str] = field(default_factory=dict)


#: What rule blocks may say, as fields of a block and of a method.
_FIELDS = ("conjunction", "disjunction", "implication", "activation")


def arranged(found: Sequence[FoundBlock], sets: Collection[str], *, keep: bool) -> Arrangement:
    """Return the rules of a file, in blocks only where these have a meaning.

    Args:
        found: The blocks, each with some rule.
        sets: The outputs whose defuzzifiers look at sets; implication matters to no others.
        keep: Whether several blocks stay blocks though they differ in nothing.
    """
    own = [_without_idle(block, sets) for block in found]
    method = {name: first for name in _FIELDS if (first := _first(own, name)) is not None}
    by_output = {o: dict.fromkeys(b.implication for b in own if b.implication and o in b.outputs) for o in sets}
    same = all(len({getattr(b, n) for b in own} - {None}) < 2 for n in ("conjunction", "disjunction", "activation"))
    told_by_outputs = all(len(implications) < 2 for implications in by_output.values())
    compares = len(own) > 1 and any(b.activation.compares for b in own)
    if len(own) < 2 or (same and told_by_outputs and not compares and not keep):
        said = {o: next(iter(i)) for o, i in by_output.items() if i}
        return Arrangement(tuple(r for b in own for r in b.rules), (), method, said)
    # The first block has the methods of the system, so that without a name it need be none.
    loose = own[0].rules if not own[0].name else ()
    names = Names(b.name for b in own)
    used: set[str] = set()
    made: list[tuple[str, FoundBlock, dict[str, Any]]] = []
    for k, block in enumerate(own[1:] if loose else own, 2 if loose else 1):
        name = block.name if block.name and block.name not in used else names.take(block.name or f"block{k}")
        used.add(name)
        fields = {n: getattr(block, n) for n in _FIELDS}
        made.append((name, block, {n: None if v == method.get(n) else v for n, v in fields.items()}))
    return Arrangement(loose, tuple(made), method)


def _without_idle(block: FoundBlock, sets: Collection[str]) -> FoundBlock:
    """Return a block without norms by which no rule joins, and an implication that no output of its rules heeds."""
    joins = block.joins
    return replace(
        block,
        conjunction=block.conjunction if "and" in joins else None,
        disjunction=block.disjunction if "or" in joins else None,
        implication=block.implication if any(o in sets for o in block.outputs) else None,
    )


def joins_of(rule: sx.Rule) -> set[str]:
    """Return which of `and` and `or` a rule joins its conditions by."""
    found: set[str] = set()
    left = [rule.antecedent]
    while left:
        truth = left.pop()
        if isinstance(truth, sx.Chain):
            found.add(truth.connective)
            left += truth.operands
        elif isinstance(truth, sx.Negation | sx.Group):
            left.append(truth.operand)
    return found


def _first(blocks: Iterable[FoundBlock], name: str) -> Any:
    return next((value for b in blocks if (value := getattr(b, name)) is not None), None)


@dataclass(frozen=True)
class BlockPart:
    """A rule block as formats have it that know one implication for all that it concludes.

    Args:
        block: Position of the rule block of the system, -1 for the rules of none.
        number: Its number among the parts of one block, from 1 on.
        method: What its rules have.
        implication: What activations make of the sets that its rules conclude.
        rules: Its rules with their positions in the system, each with the consequents that have this implication.
    """

    block: int
    number: int
    method: RuleMethod
    implication: str
    rules: tuple[tuple[int, Rule], ...]


def block_parts(system: FuzzySystem) -> list[BlockPart]:
    """Return the rules of a system in blocks of one implication; consequents of averages stay with the first."""
    found: list[BlockPart] = []
    for block in sorted({m.block for m in system.rule_methods}):
        positions = [r for r, m in enumerate(system.rule_methods) if m.block == block]
        method = system.rule_methods[positions[0]]
        for number, (implication, outputs) in enumerate(by_implication(system, positions).items(), 1):
            rules = []
            for r in positions:
                consequents = tuple(c for c in system.rules[r].consequents if c.output in outputs)
                if consequents:
                    rules.append((r, system.rules[r].model_copy(update={"consequents": consequents})))
            found.append(BlockPart(block, number, method, implication, tuple(rules)))
    return found


def by_implication(system: FuzzySystem, rules: Sequence[int]) -> dict[str, list[str]]:
    """Return the outputs that rules of one block set by their implication; outputs over rules go with the first."""
    concluded = {c.output for r in rules for c in system.rules[r].consequents}
    found: dict[str, list[str]] = {}
    over_rules: list[str] = []
    for output in (o for o in system.outputs if o.name in concluded):
        if (output.defuzzifier or system.method.defuzzifier).over_rules:
            over_rules.append(output.name)
        else:
            found.setdefault(system.implication_of(rules[0], output), []).append(output.name)
    if not found:
        return {system.rule_methods[rules[0]].implication or system.method.implication: over_rules}
    next(iter(found.values())).extend(over_rules)
    return found


def flattened(system: FuzzySystem) -> FuzzySystem:
    """Return a system whose rules all have the methods of the first one, for formats without blocks.

    An implication that a block says is said by the outputs that its rules set, as far as they agree.
    """
    if not system.rule_blocks:
        return system
    first = system.rule_methods[0]
    method = system.method.model_copy(
        update={n: getattr(first, n) for n in ("conjunction", "disjunction", "activation")}
    )
    outputs = tuple(o.model_copy(update={"implication": system.implications_of(o)[0]}) for o in system.outputs)
    return system.model_copy(update={"blocks": system.rules, "method": method, "outputs": outputs})


def without_repeated_outputs(system: FuzzySystem) -> FuzzySystem:
    """Return a system whose rules set each output once, of the same numbers.

    Raises:
        DiagnosticError: With the places of rules that cannot be written as several, since their activation method
            counts or compares rules.
    """
    doubled = [(rule, m) for rule, m in zip(system.rules, system.rule_methods, strict=True) if _repeats(rule)]
    if not doubled:
        return system
    counted = system.method.semantics.total == "all_rules"
    refused = [_refusal(system, rule) for rule, method in doubled if counted or method.activation.compares]
    if refused:
        raise DiagnosticError(refused)
    carried = system.method.semantics.consequent_hedges == "carried"
    blocks: list[Rule | RuleTable | RuleBlock] = []
    for block in system.blocks:
        if isinstance(block, RuleBlock):
            parts = tuple(own for part in block.rules for own in _split(part, carried))
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
    """Yield a part as it is, or a rule as several: each takes the first consequents that are left of each output."""
    if isinstance(part, RuleTable) or not _repeats(part):
        yield part
        return
    left = _with_hedges(part.consequents) if carried else list(part.consequents)
    while left:
        outputs = list(dict.fromkeys(c.output for c in left))
        taken = [next(c for c in left if c.output == output) for output in outputs]
        if carried:
            # A hedge would be carried on within the rule once more.
            taken = taken[:1]
        left = [c for c in left if all(c is not t for t in taken)]
        yield part.model_copy(update={"consequents": tuple(taken)})


def _with_hedges(consequents: Sequence[Consequent]) -> list[Consequent]:
    """Return consequents with the hedges that those before them carry on: the nearest to a term acts first."""
    found, before = [], tuple[str, ...]()
    for c in consequents:
        before = (*c.hedges, *before)
        found.append(c.model_copy(update={"hedges": before}))
    return found
