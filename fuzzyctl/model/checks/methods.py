"""Methods of inference that a system cannot use, and limits of the profile of a tool."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.formulas import IMPLICATIONS, inverse_hedge
from fuzzyctl.model.method import Defuzzifier
from fuzzyctl.model.profiles import Profile, profile
from fuzzyctl.model.rule import Is, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Output

#: Implications under which a scaled set that is cut is a cut set that is scaled.
SCALABLE = tuple(name for name, norm in IMPLICATIONS.items() if norm.straight)


def misfitting_semantics(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find knobs under which parts of a system have no meaning."""
    for output in system.outputs:
        yield from _sampled(system, output)
        yield from _adaptive(system, output)
        yield from _weighted_after(system, output)
        yield from _divided(system, output)
    yield from _hedged(system)


def _defuzzifier(system: FuzzySystem, output: Output) -> Defuzzifier:
    return output.defuzzifier or system.method.defuzzifier


def _sampled(system: FuzzySystem, output: Output) -> Iterator[Diagnostic]:
    """Find options of a defuzzifier that exclude each other."""
    defuzzifier = _defuzzifier(system, output)
    if defuzzifier.rule == "running" and defuzzifier.by == "magnitude":
        message = f"output '{output.name}': 'rule=running' goes from left to right, and not by magnitude"
        yield Diagnostic("FZ214", message, output.span, help="leave one of them out")
    if defuzzifier.kind == "bisector" and defuzzifier.tolerance is not None and defuzzifier.rule != "between":
        message = f"output '{output.name}': a bisector has a tolerance with 'rule=between' only"
        yield Diagnostic("FZ214", message, output.span, help="leave it out")


def _adaptive(system: FuzzySystem, output: Output) -> Iterator[Diagnostic]:
    """An adaptive output has a state for each rule, and its rates are shares of activations."""
    semantics = system.method.semantics
    usual = semantics.merge == "rules" and semantics.total == "activations"
    if output.adaptive is not None and not usual:
        message = f"output '{output.name}' is adaptive, which the semantics '{semantics.profile}' do not know"
        help_text = "write: semantics exact, or merge=rules and total=activations behind the profile"
        yield Diagnostic("FZ214", message, output.span, help=help_text)


def _weighted_after(system: FuzzySystem, output: Output) -> Iterator[Diagnostic]:
    """A weight after implication is computed as a scaled set, which some implications do not allow."""
    if system.method.semantics.weight != "after" or _defuzzifier(system, output).over_rules:
        return
    other = next((i for i in system.implications_of(output) if i not in SCALABLE), None)
    if other is not None:
        message = f"output '{output.name}': 'weight=after' goes with the implications {' and '.join(SCALABLE)}"
        yield Diagnostic("FZ214", message, output.span, facts=(f"its implication is '{other}'",))


def _divided(system: FuzzySystem, output: Output) -> Iterator[Diagnostic]:
    """An average that divides by something else than it sums over must not make its parts larger than that."""
    semantics = system.method.semantics
    if semantics.total == "activations" or not _defuzzifier(system, output).averages:
        return
    if semantics.merge != "rules":
        message = f"output '{output.name}': 'total={semantics.total}' goes with 'merge=rules' only"
        yield Diagnostic("FZ214", message, semantics.span or output.span, help="leave one of them out")
    hedged = [c for rule in system.rules for c in rule.consequents if c.output == output.name and c.hedges]
    if hedged:
        message = f"'total={semantics.total}' does not know what hedges make of the activation of '{output.name}'"
        yield Diagnostic("FZ214", message, hedged[0].span, help="leave the hedge out, or say 'total=activations'")


def _hedged(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find hedges in consequents that change nothing there is."""
    how = system.method.semantics.consequent_hedges
    outputs = {o.name: o for o in system.outputs}
    hedges = {h.name for h in system.hedges}
    for rule in system.rules:
        for c in rule.consequents:
            if not c.hedges or c.output not in outputs:
                continue
            kind = _defuzzifier(system, outputs[c.output]).kind
            over_rules = _defuzzifier(system, outputs[c.output]).over_rules
            if outputs[c.output].adaptive is not None:
                yield Diagnostic("FZ214", f"output '{c.output}' is adaptive, so nothing hedges it", c.span)
            elif over_rules and how == "set":
                message = f"a hedge changes the set of a consequent, and '{kind}' of '{c.output}' looks at no set"
                help_text = "leave the hedge out, or say what it changes: semantics exact(consequent_hedges=activation)"
                yield Diagnostic("FZ214", message, c.span, help=help_text)
            elif over_rules and how == "undone":
                for name in c.hedges:
                    if name in hedges or inverse_hedge(name) is None:
                        message = f"hedge '{name}' of a consequent has no inverse, and '{kind}' needs it"
                        yield Diagnostic("FZ214", message, c.span)


def kept(system: FuzzySystem, name: str) -> list[Diagnostic]:
    """Return hints at the parts that a profile leaves otherwise than its tool.

    These are hints at another version of the system's tool and at rule blocks that keep other norms, and
    warnings of rules that the tool leaves out. A system sets norms and a profile sets numerics, so blocks keep their
    norms under a profile whose tool has one norm for all rules.
    """
    new, old = profile(name), profile(system.method.semantics.profile)
    result = [_other_version(system, old, new)] if old.name.startswith(f"{name}_") else []
    # The reader reports those of fuzzylite's own files.
    if new.name.startswith("fuzzylite") and "fuzzylite" not in old.name:
        result += [_always_acting(rule, new) for rule in system.rules if _has_no_condition(rule)]
    if new.has_blocks:
        return result
    for block in system.rule_blocks:
        norms = {n: getattr(block, n) for n in ("conjunction", "disjunction", "implication")}
        norms_of_block = [f"{n} {norm}" for n, norm in norms.items() if norm not in (None, getattr(system.method, n))]
        if norms_of_block:
            message = f"profile '{name}' leaves rule block '{block.name}' its own {', '.join(norms_of_block)}"
            facts = (f"{new.tool} has one norm of each kind for all rules",)
            result.append(Diagnostic("FZ609", message, block.span, "hint", facts))
    return result


def _other_version(system: FuzzySystem, old: Profile, new: Profile) -> Diagnostic:
    message = f"profile '{new.name}' computes as {new.tool}, and '{system.name}' is of {old.tool}"
    help_text = f"for the numbers of {old.tool} leave the profile out, or name '{old.name}'"
    return Diagnostic("FZ609", message, system.span, "hint", help=help_text, file=system.path)


def _has_no_condition(rule: Rule) -> bool:
    """Whether the antecedent is not a part of the text: the reader of a `.fis` file made it from the whole rule."""
    antecedent = rule.antecedent
    return (
        isinstance(antecedent, Is)
        and antecedent.hedges == ("any",)
        and antecedent.span is not None
        and antecedent.span == rule.span
    )


def _always_acting(rule: Rule, new: Profile) -> Diagnostic:
    message = f"the rule has no condition; under profile '{new.name}' it acts all the same"
    facts = (f"{new.tool} leaves such a rule out; what only such rules set is 'nan' there",)
    help_text = "remove the rule, or give it a condition"
    return Diagnostic("FZ609", message, rule.span, "warning", facts=facts, help=help_text)
