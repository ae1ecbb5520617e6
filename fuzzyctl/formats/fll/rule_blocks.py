"""Reads the blocks `RuleBlock`, and finds the methods that all of them agree on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fuzzyctl.errors import Note
from fuzzyctl.formats.findings import Findings
from fuzzyctl.formats.fll.lines import Block, Line
from fuzzyctl.formats.fll.methods import activation, is_none, norm
from fuzzyctl.formats.fll.rules import Read, RuleReader
from fuzzyctl.formats.fll.variables import flag
from fuzzyctl.formats.fll.words import T_NORMS
from fuzzyctl.model.method import Activation
from fuzzyctl.source import Span


@dataclass(frozen=True)
class RuleBlock:
    """A block of rules; the norms are None where the block has none."""

    block: Block
    rules: tuple[Read, ...]
    conjunction: str | None
    disjunction: str | None
    implication: str | None
    activation: Activation

    @property
    def outputs(self) -> set[str]:
        """The outputs that its rules set."""
        return {c.output for read in self.rules for c in read.rule.consequents}


def read_rule_blocks(blocks: Sequence[Block], rules: RuleReader, findings: Findings) -> list[RuleBlock]:
    """Return the blocks that are enabled and have rules."""
    found = []
    for block in blocks:
        if not flag(block.line("enabled"), True, findings):
            message = "the rule block is disabled, so its rules have no effect"
            findings.warning("FZ603", message, block.head.span, help="enable it, or remove it")
            continue
        made = _rule_block(block, rules, findings)
        if made.rules:
            found.append(made)
    return found


def _rule_block(block: Block, rules: RuleReader, findings: Findings) -> RuleBlock:
    read = [rules.read(line.value) for line in block.all("rule")]
    implication, method = block.line("implication"), block.line("activation")
    if implication is None and method is not None and method.value.text in T_NORMS:
        implication, method = method, None  # fuzzylite 4 and 5 called the implication so
    return RuleBlock(
        block,
        tuple(r for r in read if r is not None),
        norm(block.line("conjunction"), findings, kind="and"),
        norm(block.line("disjunction"), findings, kind="or"),
        norm(implication, findings, kind="and"),
        activation(method, findings),
    )


def common_norm(blocks: Sequence[RuleBlock], key: str, findings: Findings) -> str | None:
    """Return the norm by which all blocks join whose rules join at all; None where none does.

    Args:
        blocks: The blocks.
        key: `conjunction` or `disjunction`.
        findings: Where it goes when blocks differ, or lack the norm that their rules need.
    """
    word = "and" if key == "conjunction" else "or"
    first: tuple[RuleBlock, str] | None = None
    for block in blocks:
        joining = next((r for r in block.rules if (r.uses_and if word == "and" else r.uses_or)), None)
        own = block.conjunction if word == "and" else block.disjunction
        if joining is None:
            continue
        if own is None:
            if is_none(block.block.line(key)):
                message = f"the rule joins by '{word}', and its rule block has no {key}"
                findings.error("FZ212", message, joining.rule.span, help=f"write: {key}: {_usual(word)}")
        elif first is None:
            first = (block, own)
        elif own != first[1]:
            _differ(key, block, first[0], findings)
    return first[1] if first is not None else None


def _usual(word: str) -> str:
    return "Minimum" if word == "and" else "Maximum"


def _differ(key: str, block: RuleBlock, earlier: RuleBlock, findings: Findings) -> None:
    place = _place(block, key)
    message = f"rule blocks differ in their {key}"
    help_text = "a system has one here; split the file into engines, or make them equal"
    findings.error("FZ602", message, place, help=help_text, note=Note(_place(earlier, key), "another one here"))


def _place(block: RuleBlock, key: str) -> Span:
    line: Line | None = block.block.line(key)
    return line.span if line is not None else block.block.head.span


def common_activation(blocks: Sequence[RuleBlock], findings: Findings) -> Activation:
    """Return the activation method of all blocks; other methods than `General` choose among the rules of one block."""
    found = {b.activation for b in blocks}
    if len(found) > 1:
        other = next(b for b in blocks if b.activation != blocks[0].activation)
        _differ("activation", other, blocks[0], findings)
    elif len(blocks) > 1 and next(iter(found)).kind not in ("general", "threshold"):
        message = "the activation method chooses among the rules of each block by itself, and there are several"
        note = Note(_place(blocks[0], "activation"), "the first one is here")
        help_text = "put all rules into one block, or use: activation: General"
        findings.error("FZ602", message, _place(blocks[1], "activation"), help=help_text, note=note)
    return blocks[0].activation if blocks else Activation()


def implication_of(output: str, blocks: Sequence[RuleBlock], findings: Findings) -> str | None:
    """Return the implication by which all blocks set an output; None where none sets it, or after an error."""
    first: RuleBlock | None = None
    for block in blocks:
        if output not in block.outputs:
            continue
        if block.implication is None and is_none(block.block.line("implication")):
            message = f"the rule block sets '{output}', which is a fuzzy set, and has no implication"
            if not is_none(block.block.line("activation")):
                message += " that is available"
            findings.error("FZ212", message, block.block.head.span, help="write: implication: Minimum")
        elif first is None:
            first = block
        elif block.implication != first.implication:
            _differ("implication", block, first, findings)
    return first.implication if first is not None else None
