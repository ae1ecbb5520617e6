"""Blocks `RuleBlock` of `.fll` files."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.formats.common.report import Findings
from fuzzyctl.model.rule import And, Or, is_joined_by
from tests.oracles.blocks import FoundBlock
from tests.oracles.fll.lines import Block
from tests.oracles.fll.methods import activation, is_none, norm
from tests.oracles.fll.rules import RuleReader
from tests.oracles.fll.variables import flag
from tests.oracles.fll.vocabulary import T_NORMS

#: What joins the conditions of a rule: its key, its word, its kind and a norm to suggest.
_CONNECTIVES: Final[tuple[tuple[str, str, type[And] | type[Or], str], ...]] = (
    ("conjunction", "and", And, "Minimum"),
    ("disjunction", "or", Or, "Maximum"),
)


def read_rule_blocks(blocks: Sequence[Block], rules: RuleReader, findings: Findings) -> list[tuple[Block, FoundBlock]]:
    """Return the blocks that are enabled and have rules; the norms are None where a block has none."""
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
            found.append((block, made))
    return found


def _rule_block(block: Block, rules: RuleReader, findings: Findings) -> FoundBlock:
    read = [rules.read(line.value) for line in block.all("rule")]
    implication, method = block.line("implication"), block.line("activation")
    if implication is None and method is not None and method.value.text in T_NORMS:
        implication, method = method, None  # fuzzylite 4 and 5 called the implication so
    return FoundBlock(
        block.head.value.text,
        tuple(r for r in read if r is not None),
        norm(block.line("conjunction"), findings, kind="and"),
        norm(block.line("disjunction"), findings, kind="or"),
        norm(implication, findings, kind="and"),
        activation(method, findings),
        block.head.span,
    )


def require_norms(blocks: Sequence[tuple[Block, FoundBlock]], sets: Sequence[str], findings: Findings) -> None:
    """Report blocks that lack a norm which their rules need.

    Args:
        blocks: The blocks.
        sets: The outputs whose defuzzifiers look at sets, which need an implication.
        findings: Where it goes.
    """
    for block, found in blocks:
        for key, word, kind, usual in _CONNECTIVES:
            joining = next((r for r in found.rules if is_joined_by(kind, r.antecedent)), None)
            if joining is not None and getattr(found, key) is None and is_none(block.line(key)):
                message = f"the rule joins by '{word}', and its rule block has no {key}"
                findings.error("FZ212", message, joining.span, help=f"write: {key}: {usual}")
        lacks = found.implication is None and is_none(block.line("implication"))
        for output in sets if lacks else ():
            if output in found.outputs:
                message = f"the rule block sets '{output}', which is a fuzzy set, and has no implication"
                if not is_none(block.line("activation")):
                    message += " that is available"
                findings.error("FZ212", message, block.head.span, help="write: implication: Minimum")


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
