"""A system under the numerics of another tool."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.model.checks.checks import check_model
from fuzzyctl.model.method import Defuzzifier
from fuzzyctl.model.profiles import Profile, ProfileName, profile
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Output


def as_profile(system: FuzzySystem, name: ProfileName) -> FuzzySystem:
    """Return the same system under the numerics of a profile.

    Variables, terms, rules and norms stay. The knobs of the profile take the place of the system's, and so do its
    grid, rule, tolerance and number of samples; a profile whose tool lets a file set the number of samples leaves a
    number that the system sets. The value of an output without a firing rule changes if it was the default of the
    profile in force, unless the new one has none.

    Args:
        system: A well-formed system.
        name: A profile.

    Raises:
        UnknownNameError: For a name that no profile has.
        DiagnosticError: For a system that the tool cannot evaluate, or that has no meaning under the profile.
    """
    old, new = profile(system.method.semantics.profile), profile(name)
    mistakes = _not_evaluated(system, new)
    if mistakes:
        raise DiagnosticError(mistakes)
    method = system.method.model_copy(
        update={"semantics": new.semantics, "defuzzifier": _defuzzifier(system.method.defuzzifier, old, new)}
    )
    outputs = tuple(_output(o, old, new) for o in system.outputs)
    changed = system.model_copy(update={"method": method, "outputs": outputs})
    _require_as_sound(system, changed)
    return changed


def _require_as_sound(system: FuzzySystem, changed: FuzzySystem) -> None:
    """Refuse errors that a system has under its new numerics only, such as outputs that read each other in a circle."""
    mistakes = [d for d in check_model(changed, hints=False) if d.severity == "error"]
    before = {(d.code, d.message) for d in check_model(system, hints=False)} if mistakes else set()
    name = changed.method.semantics.profile
    anew = [
        replace(d, facts=(*d.facts, f"under profile '{name}'")) for d in mistakes if (d.code, d.message) not in before
    ]
    if anew:
        raise DiagnosticError(anew)


def _defuzzifier(defuzzifier: Defuzzifier, old: Profile, new: Profile) -> Defuzzifier:
    base = new.defuzzifier(defuzzifier.kind)
    usual = defuzzifier.resolution == old.defuzzifier(defuzzifier.kind).resolution
    # A file of fuzzylite that says the usual number says it still when another version reads it.
    is_set = defuzzifier.resolution is not None and (old.keeps_resolution or not usual)
    keeps = is_set and new.keeps_resolution and base.resolution is not None
    return base.model_copy(update={"resolution": defuzzifier.resolution}) if keeps else base


def _output(output: Output, old: Profile, new: Profile) -> Output:
    fields: dict[str, Any] = {}
    if output.defuzzifier is not None:
        fields["defuzzifier"] = _defuzzifier(output.defuzzifier, old, new)
    if output.otherwise == old.otherwise and new.otherwise is not None:
        fields["otherwise"] = new.otherwise
    return output.model_copy(update=fields) if fields else output


def _not_evaluated(system: FuzzySystem, new: Profile) -> list[Diagnostic]:
    """Report the parts of a system that the tool of a profile does not have."""
    results: dict[str, Diagnostic] = {}
    activations = (system.method.activation, *(m.activation for m in system.rule_methods))
    activation = next((a for a in activations if a.kind != "general"), None)
    if activation is not None and not new.has_activations:
        message = f"profile '{new.name}' cannot evaluate the system: {new.tool} has no activation '{activation.kind}'"
        results[""] = Diagnostic("FZ214", message, activation.span, help="use 'activation general'")
    for output in system.outputs:
        defuzzifier = output.defuzzifier or system.method.defuzzifier
        if new.evaluates is not None and defuzzifier.kind not in new.evaluates:
            message = (
                f"profile '{new.name}' cannot evaluate output '{output.name}': {new.tool} has no '{defuzzifier.kind}'"
            )
            facts = (f"it has: {', '.join(new.evaluates)}",)
            results.setdefault(output.name, Diagnostic("FZ214", message, output.span, facts=facts))
    return list(results.values())
