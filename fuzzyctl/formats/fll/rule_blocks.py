"""Blocks `RuleBlock` of `.fll` files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.formats.common.blocks import FoundBlock
from fuzzyctl.formats.common.report import Findings
from fuzzyctl.formats.fll.lines import Block
from fuzzyctl.formats.fll.methods import activation, is_none, norm
from fuzzyctl.formats.fll.rules import Read, RuleReader
from fuzzyctl.formats.fll.variables import flag
from fuzzyctl.formats.fll.vocabulary import T_NORMS
from fuzzyctl.model.method import Activation


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
            name = block.head.value.text[:60]
            named = f"rule block '{name}'" if name else "the rule block"
            message = f"{named} is disabled; it is left out, and {counted(len(block.all('rule')), 'rule')} with it"
            findings.warning("FZ611", message, block.head.span, help="enable it, or remove it")
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


def require_norms(blocks: Sequence[RuleBlock], sets: Sequence[str], findings: Findings) -> None:
    """Report blocks that lack a norm which their rules need.

    Args:
        blocks: The blocks.
        sets: The outputs whose defuzzifiers look at sets, which need an implication.
        findings: Where it goes.
    """
    for block in blocks:
        for key, own in (("conjunction", block.conjunction), ("disjunction", block.disjunction)):
            word = "and" if key == "conjunction" else "or"
            joining = next((r for r in block.rules if _joins(r, key)), None)
            if joining is not None and own is None and is_none(block.block.line(key)):
                message = f"the rule joins by '{word}', and its rule block has no {key}"
                usual = "Minimum" if word == "and" else "Maximum"
                findings.error("FZ212", message, joining.rule.span, help=f"write: {key}: {usual}")
        lacks = block.implication is None and is_none(block.block.line("implication"))
        for output in sets if lacks else ():
            if output in block.outputs:
                message = f"the rule block sets '{output}', which is a fuzzy set, and has no implication"
                if not is_none(block.block.line("activation")):
                    message += " that is available"
                findings.error("FZ212", message, block.block.head.span, help="write: implication: Minimum")


def _joins(read: Read, key: str) -> bool:
    return read.uses_and if key == "conjunction" else read.uses_or


def found_block(block: RuleBlock) -> FoundBlock:
    """Return a block with the norms that its rules need."""
    return FoundBlock(
        block.block.head.value.text,
        tuple(r.rule for r in block.rules),
        block.conjunction if any(r.uses_and for r in block.rules) else None,
        block.disjunction if any(r.uses_or for r in block.rules) else None,
        block.implication,
        block.activation,
        block.block.head.span,
    )


def report_no_rule(blocks: Sequence[Block], first: Block, findings: Findings) -> None:
    """Report that no rule acts: there is no rule block, all are disabled, none has a rule, or none has an effect."""
    enabled = [b for b in blocks if flag(b.line("enabled"), True, findings)]
    rule = "write, for example: rule: if A is x then C is z"
    if not blocks:
        findings.error("FZ212", "the file has no RuleBlock", first.head.span, help="write: RuleBlock: NAME, with rules")
    elif not enabled:
        message = "all rule blocks are disabled" if len(blocks) > 1 else "the only rule block is disabled"
        findings.error("FZ212", message, blocks[0].head.span, help="enable one")
    elif any(b.all("rule") for b in enabled):
        findings.error("FZ212", "no rule sets an output that is enabled", enabled[0].head.span, help=rule)
    else:
        message = "the rule block has no rule" if len(enabled) == 1 else "the rule blocks have no rule"
        findings.error("FZ212", message, enabled[0].head.span, help=rule)
