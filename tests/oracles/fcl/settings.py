"""Settings of FCL rule blocks: AND, OR, ACT and ACCU, and their defaults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from fuzzyctl.diagnostics.diagnostic import Note
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted, did_you_mean, listed
from fuzzyctl.formats.common.words import DUAL_OF
from tests.oracles.fcl.names import (
    ACCUMULATION_WORDS,
    CONJUNCTION_WORDS,
    DISJUNCTION_WORDS,
    JFUZZYLOGIC_DUAL_OF,
)
from tests.oracles.fcl.scope import Scope
from tests.oracles.fcl.syntax import RuleBlock, Setting, Word


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


def norm_of(setting: Setting, words: Mapping[str, str], scope: Scope) -> str | None:
    """Return the norm that a setting names; None where it names none, and with an error one that there is not."""
    word = setting.word
    if word is None:
        facts = (f"values: {listed(words)}",)
        scope.error("FZ213", f"{setting.keyword.text} takes one word", setting.span, facts=facts)
        return None
    if word.upper == "NONE":
        return None
    if word.upper not in words:
        message = f"no value '{word.text}' of {setting.keyword.text}"
        help_text = did_you_mean(word.upper, words)
        scope.error("FZ213", message, word.span, facts=(f"values: {listed(words)}",), help=help_text)
        return None
    return words[word.upper]


def accumulation_of(setting: Setting, scope: Scope) -> str | None:
    """Return what ACCU says."""
    found = norm_of(setting, ACCUMULATION_WORDS, scope)
    if setting.word is not None and setting.word.upper == "NSUM":
        return _normalized_sum(setting, scope)
    return found


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


def norms(block: RuleBlock, scope: Scope, *, joins: frozenset[str]) -> Norms:
    """Return the norms of a rule block.

    Args:
        block: The rule block.
        scope: Where mistakes go.
        joins: Which of `AND` and `OR` its rules use.
    """
    given = {s.keyword.upper: s for s in block.settings}
    conjunction, disjunction = _connectives(block, scope, joins)
    act = given.get("ACT")
    implication = norm_of(act, CONJUNCTION_WORDS, scope) if act is not None else None
    accu = given.get("ACCU")
    accumulation = accumulation_of(accu, scope) if accu is not None else None
    _other_settings(given, scope)
    return Norms(conjunction, disjunction, implication or "min", accumulation, block.span)


def _connectives(block: RuleBlock, scope: Scope, joins: frozenset[str]) -> tuple[str, str]:
    """Return the norms for AND and OR; one that is not given follows from the other by De Morgan's laws."""
    said = [s for s in block.settings if s.keyword.upper in ("AND", "OR")]
    found: dict[str, tuple[str, Setting]] = {}
    for s in said:
        word = s.keyword.upper
        name = norm_of(s, CONJUNCTION_WORDS if word == "AND" else DISJUNCTION_WORDS, scope)
        if name is not None:
            found.pop(word, None)
            found[word] = (name, s)
    dual = JFUZZYLOGIC_DUAL_OF if scope.dialect.name == "jfuzzylogic" else DUAL_OF
    if not found:
        return "min", "max"
    last = list(found)[-1]
    name, setting = found[last]
    if len(found) == 2 and scope.dialect.name != "fuzzylite":
        other = found["AND" if last == "OR" else "OR"]
        if other[0] != dual[name]:
            _no_pair(scope, joins, other, setting)
    if len(found) == 2 and scope.dialect.name != "jfuzzylogic":
        return found["AND"][0], found["OR"][0]
    if len(found) == 1 and scope.dialect.name == "fuzzylite":
        return found["AND"][0] if "AND" in found else "min", found["OR"][0] if "OR" in found else "max"
    return (name, dual[name]) if last == "AND" else (dual[name], name)


def _no_pair(scope: Scope, joins: frozenset[str], other: tuple[str, Setting], last: Setting) -> None:
    """Warn that AND and OR are no pair, where that has an effect."""
    jfuzzylogic = scope.dialect.name == "jfuzzylogic"
    if (other[1].keyword.upper not in joins) if jfuzzylogic else (joins != {"AND", "OR"}):
        return
    taken = "the last one counts, and the other follows from it" if jfuzzylogic else "both are taken as they are"
    message = f"AND and OR are not a pair by De Morgan's laws; here {taken}"
    help_text = "the standard wants MIN and MAX, PROD and ASUM, or BDIF and BSUM; jFuzzyLogic takes the last one"
    note = (Note(other[1].span, "the other one"),)
    scope.warning("FZ609", message, last.span, notes=note, help=help_text)


def is_switched_off(block: RuleBlock, scope: Scope) -> bool:
    """Return whether fuzzylite has switched a rule block off; its rules then have no effect, which is reported."""
    setting = next((s for s in block.settings if s.keyword.upper == "ENABLED"), None)
    word = setting.word if setting is not None else None
    if setting is None or not (isinstance(word, Word) and word.upper == "FALSE"):
        return False
    rules = counted(len(block.rules), "rule")
    message = f"the rule block is switched off; it is left out, and {rules} with it"
    scope.warning("FZ611", message, setting.span, help="remove it, or write: ENABLED : TRUE")
    return True


def _other_settings(given: Mapping[str, Setting], scope: Scope) -> None:
    """Refuse what changes the rules in a way that is not available."""
    require_enabled(given.get("ENABLED"), scope)
    activation = given.get("ACTIVATION")
    word = activation.word if activation is not None else None
    if activation is not None and (word is None or word.upper not in ("GENERAL", "NONE")):
        message = "an activation method other than General is not available in FCL"
        scope.error("FZ602", message, activation.span)


def require_enabled(setting: Setting | None, scope: Scope) -> None:
    """Refuse what fuzzylite has switched off, since leaving it out would change the system."""
    word = setting.word if setting is not None else None
    if setting is not None and not (isinstance(word, Word) and word.upper == "TRUE"):
        help_text = "remove the block, or write: ENABLED : TRUE"
        scope.error("FZ602", "a block that is switched off is not available", setting.span, help=help_text)
