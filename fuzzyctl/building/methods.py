"""Defuzzifiers, activation and methods of systems from what Python calls give: objects or texts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from fuzzyctl.building import fragments, values
from fuzzyctl.model.method import Activation, Defuzzifier, Method, Semantics
from fuzzyctl.model.profiles import PROFILES, Profile
from fuzzyctl.support import arguments


def defuzzifier_of(given: object, profile: Profile = PROFILES["exact"]) -> Defuzzifier:
    """Return a defuzzifier; whether there is one of that name is for the checks, which find all mistakes at once."""
    if isinstance(given, Defuzzifier):
        return given
    name = arguments.instance("'defuzzifier'", str, "the text of a defuzzifier, or a Defuzzifier", given)
    return fragments.defuzzifier(name, profile) if "(" in name else profile.defuzzifier(name)


def method_of(semantics: object, defuzzifier: object, activation: object, norms: Mapping[str, str | None]) -> Method:
    """Return a method: what is given, and what the profile in force has for the rest."""
    knobs = semantics
    if not isinstance(knobs, Semantics):
        knobs = fragments.semantics(
            arguments.instance("'semantics'", str, "the text of a profile, or a Semantics", knobs)
        )
    profile = PROFILES[knobs.profile]
    own = profile.defuzzifier("centroid") if defuzzifier is None else defuzzifier_of(defuzzifier, profile)
    given = values.texts(**{name: norm for name, norm in norms.items() if norm is not None})
    return replace(profile.method, **given, semantics=knobs, defuzzifier=own, activation=activation_of(activation))


def activation_of(given: object) -> Activation:
    """Return an activation method; that of all systems for None."""
    if given is None or isinstance(given, Activation):
        return given or Activation()
    due = "the text of an activation method, or an Activation"
    return fragments.activation(arguments.instance("'activation'", str, due, given))
