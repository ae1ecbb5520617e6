"""Limits of profiles: settings and readings that a profile does not replace, and the version that it models."""

from __future__ import annotations

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.model.profiles import Profile, profile
from fuzzyctl.model.rule import Is, Rule
from fuzzyctl.model.system import FuzzySystem


def kept(system: FuzzySystem, name: str) -> list[Diagnostic]:
    """Return what a profile leaves otherwise than its tool.

    These are hints at another version of the system's own tool and at rule blocks that keep norms of their own, and
    warnings of rules that the tool leaves out. Norms are what a system says, numerics what a profile says, so blocks
    keep theirs under a profile whose tool has one norm for all rules.
    """
    new, old = profile(name), profile(system.method.semantics.profile)
    found = [_other_version(system, old, new)] if old.name.startswith(f"{name}_") else []
    # The reader reports those of fuzzylite's own files.
    if new.name.startswith("fuzzylite") and "fuzzylite" not in old.name:
        found += [_always_acting(rule, new) for rule in system.rules if _has_no_condition(rule)]
    if new.has_blocks:
        return found
    for block in system.rule_blocks:
        norms = {n: getattr(block, n) for n in ("conjunction", "disjunction", "implication")}
        own = [f"{n} {norm}" for n, norm in norms.items() if norm not in (None, getattr(system.method, n))]
        if own:
            message = f"profile '{name}' leaves rule block '{block.name}' its own {', '.join(own)}"
            facts = (f"{new.tool} has one norm of each kind for all rules",)
            found.append(Diagnostic("FZ609", message, block.span, "hint", facts))
    return found


def _other_version(system: FuzzySystem, old: Profile, new: Profile) -> Diagnostic:
    message = f"profile '{new.name}' computes as {new.tool}, and '{system.name}' is of {old.tool}"
    help_text = f"for the numbers of {old.tool} leave the profile out, or name '{old.name}'"
    return Diagnostic("FZ609", message, system.span, "hint", help=help_text, file=system.path)


def _has_no_condition(rule: Rule) -> bool:
    """Whether the antecedent is no text of its own: the reader of a `.fis` file made it of the whole rule."""
    own = rule.antecedent
    return isinstance(own, Is) and own.hedges == ("any",) and own.span is not None and own.span == rule.span


def _always_acting(rule: Rule, new: Profile) -> Diagnostic:
    message = f"the rule has no condition; under profile '{new.name}' it acts all the same"
    facts = (f"{new.tool} leaves such a rule out; what only such rules set is 'nan' there",)
    help_text = "remove the rule, or give it a condition"
    return Diagnostic("FZ609", message, rule.span, "warning", facts=facts, help=help_text)
