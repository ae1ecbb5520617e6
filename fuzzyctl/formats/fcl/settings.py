"""Settings of FCL blocks: AND, OR, ACT and ACCU with their defaults, METHOD and ENABLED."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from fuzzyctl.diagnostics.diagnostic import Note
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted, listed
from fuzzyctl.formats.common.words import DUAL_OF
from fuzzyctl.formats.fcl.names import (
    ACCUMULATION_WORDS,
    CONJUNCTION_WORDS,
    DISJUNCTION_WORDS,
    JFUZZYLOGIC_DUAL_OF,
)
from fuzzyctl.formats.fcl.scope import Scope
from fuzzyctl.formats.fcl.syntax import RuleBlock, Setting


@dataclass(frozen=True)
class Norms:
    """The norms of a rule block.

    Args:
        conjunction: For AND.
        disjunction: For OR.
        implication: For ACT.
        accumulation: For ACCU, None where the block says nothing.
        span: The rule block.
    """

    conjunction: str
    disjunction: str
    implication: str
    accumulation: str | None
    span: Span


def norm_of(setting: Setting | None, words: Mapping[str, str], scope: Scope) -> str | None:
    """Return the norm that a setting names; None where it names none, and with an error one that there is not."""
    if setting is None:
        return None
    word = setting.word
    if word is None:
        facts = (f"values: {listed(words)}",)
        scope.error("FZ213", f"{setting.keyword.text} takes one word", setting.span, facts=facts)
        return None
    if word.upper == "NONE":
        return None
    if word.upper == "NSUM" and words is ACCUMULATION_WORDS:
        return _normalized_sum(setting, scope)
    return scope.look_up(word.span, words, setting.keyword.text, word=word.upper, code="FZ213")


def _normalized_sum(setting: Setting, scope: Scope) -> str:
    """Return what NSUM is: the standard divides the whole sum by its largest value, tools each degree by its own.

    No defuzzifier asks for the scale of a set, so that the standard's is the plain sum.
    """
    whole = scope.dialect.name == "standard"
    ways = "the plain sum, since the standard divides the whole set by one number", "min(1, a + b), as BSUM"
    here, there = ways if whole else ways[::-1]
    facts = (f"{'jFuzzyLogic and fuzzylite take' if whole else 'the standard has'} {there}",)
    help_text = "write SUM or BSUM to say which one is meant"
    scope.warning("FZ609", f"NSUM is read as {here}", setting.span, facts=facts, help=help_text)
    return "sum" if whole else "bounded_sum"


def norms(block: RuleBlock, scope: Scope, joins: Collection[str]) -> Norms:
    """Return the norms of a rule block; `joins` are those of `and` and `or` that its rules use."""
    given = {s.keyword.upper: s for s in block.settings}
    conjunction, disjunction = _connectives(block, scope, joins)
    implication = norm_of(given.get("ACT"), CONJUNCTION_WORDS, scope)
    accumulation = norm_of(given.get("ACCU"), ACCUMULATION_WORDS, scope)
    require_enabled(given.get("ENABLED"), scope)
    activation = given.get("ACTIVATION")
    word = activation.word if activation is not None else None
    if activation is not None and (word is None or word.upper not in ("GENERAL", "NONE")):
        message = "an activation method other than General is not available in FCL"
        scope.error("FZ602", message, activation.span)
    return Norms(conjunction, disjunction, implication or "min", accumulation, block.span)


def _connectives(block: RuleBlock, scope: Scope, joins: Collection[str]) -> tuple[str, str]:
    """Return the norms for AND and OR; one that is not given follows from the other by De Morgan's laws."""
    found: dict[str, tuple[str, Setting]] = {}
    for s in block.settings:
        word = s.keyword.upper
        if word not in ("AND", "OR"):
            continue
        name = norm_of(s, CONJUNCTION_WORDS if word == "AND" else DISJUNCTION_WORDS, scope)
        if name is not None:
            found.pop(word, None)
            found[word] = (name, s)
    if not found:
        return "min", "max"
    tool = scope.dialect.name
    dual = JFUZZYLOGIC_DUAL_OF if tool == "jfuzzylogic" else DUAL_OF
    last = list(found)[-1]
    name, setting = found[last]
    if len(found) == 2 and tool != "fuzzylite":
        other = found["AND" if last == "OR" else "OR"]
        if other[0] != dual[name]:
            _no_pair(scope, joins, other[1], setting)
    if len(found) == 2 and tool != "jfuzzylogic":
        return found["AND"][0], found["OR"][0]
    if len(found) == 1 and tool == "fuzzylite":
        return found["AND"][0] if "AND" in found else "min", found["OR"][0] if "OR" in found else "max"
    return (name, dual[name]) if last == "AND" else (dual[name], name)


def _no_pair(scope: Scope, joins: Collection[str], other: Setting, last: Setting) -> None:
    """Warn that AND and OR are no pair, where that has an effect."""
    jfuzzylogic = scope.dialect.name == "jfuzzylogic"
    if (other.keyword.text.lower() not in joins) if jfuzzylogic else len(joins) < 2:
        return
    taken = "the last one counts, and the other follows from it" if jfuzzylogic else "both are taken as they are"
    message = f"AND and OR are no pair by De Morgan's laws; here {taken}"
    help_text = "the standard wants MIN and MAX, PROD and ASUM, or BDIF and BSUM; jFuzzyLogic takes the last one"
    scope.warning("FZ609", message, last.span, notes=(Note(other.span, "the other one"),), help=help_text)


def is_switched_off(block: RuleBlock, scope: Scope) -> bool:
    """Return whether fuzzylite has switched a rule block off; its rules then have no effect, which is reported."""
    setting = next((s for s in block.settings if s.keyword.upper == "ENABLED"), None)
    if setting is None or setting.word is None or setting.word.upper != "FALSE":
        return False
    rules = counted(len(block.rules), "rule")
    message = f"the rule block is switched off; it is left out, and {rules} with it"
    scope.warning("FZ611", message, setting.span, help="remove it, or write: ENABLED : TRUE")
    return True


def require_enabled(setting: Setting | None, scope: Scope) -> None:
    """Refuse what fuzzylite has switched off, since leaving it out would change the system."""
    if setting is not None and (setting.word is None or setting.word.upper != "TRUE"):
        help_text = "remove the block, or write: ENABLED : TRUE"
        scope.error("FZ602", "a block that is switched off is not available", setting.span, help=help_text)
