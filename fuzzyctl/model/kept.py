"""What a system keeps under a profile although the tool has no such thing."""

from __future__ import annotations

from fuzzyctl.errors import Diagnostic
from fuzzyctl.model.profiles import profile
from fuzzyctl.model.system import FuzzySystem


def kept(system: FuzzySystem, name: str) -> list[Diagnostic]:
    """Return hints at rule blocks that keep norms of their own under a profile whose tool has one norm for all rules.

    Norms are what a system says, numerics what a profile says, so blocks keep theirs under every profile.
    """
    new = profile(name)
    if new.has_blocks:
        return []
    found = []
    for block in system.rule_blocks:
        norms = {n: getattr(block, n) for n in ("conjunction", "disjunction", "implication")}
        own = [f"{n} {norm}" for n, norm in norms.items() if norm not in (None, getattr(system.method, n))]
        if own:
            message = f"profile '{name}' leaves rule block '{block.name}' its own {', '.join(own)}"
            facts = (f"{new.tool} has one norm of each kind for all rules",)
            found.append(Diagnostic("FZ609", message, block.span, "hint", facts))
    return found
