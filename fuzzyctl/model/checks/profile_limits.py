"""Limits of profiles: settings that a profile does not replace, and the version that it models."""

from __future__ import annotations

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.model.profiles import Profile, profile
from fuzzyctl.model.system import FuzzySystem


def kept(system: FuzzySystem, name: str) -> list[Diagnostic]:
    """Return hints at another version of the system's own tool, and at rule blocks that keep norms of their own.

    Norms are what a system says, numerics what a profile says, so blocks keep theirs under a profile whose tool has one
    norm for all rules.
    """
    new, old = profile(name), profile(system.method.semantics.profile)
    found = [_other_version(system, old, new)] if old.name.startswith(f"{name}_") else []
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
