"""Reads FML: from XML to a fuzzy system, with all mistakes at once."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePath
from typing import Any, Final

from fuzzyctl.errors import Diagnostic
from fuzzyctl.formats.fml.document import Element, parse_document
from fuzzyctl.formats.fml.names import POINT_SETS, SHAPES
from fuzzyctl.formats.fml.rules import RuleReader
from fuzzyctl.formats.fml.scope import Scope
from fuzzyctl.formats.fml.variables import KnowledgeBase, VariableReader
from fuzzyctl.model.method import Method
from fuzzyctl.model.semantics import Semantics
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Output
from fuzzyctl.source import SourceText, Span

_ROOTS: Final = ("fuzzysystem", "fuzzycontroller")
_RULE_BASES: Final = ("mamdanirulebase", "tskrulebase", "tsukamotorulebase", "rulebase", "anyarulebase")


def read(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Return the system of an FML document, None where it has errors, and all diagnostics."""
    root, diagnostics = parse_document(source)
    if root is None:
        return None, diagnostics
    scope = Scope(draft=_is_draft(root))
    if root.name not in _ROOTS:
        message = f"the document is <{root.tag}>, not <fuzzySystem>, so it is no FML"
        scope.error("FZ004", message, root.span, help="FML of IEEE 1855 begins with <fuzzySystem name=...>")
        return None, scope.diagnostics
    system = _system(root, scope, source)
    scope.tell_unsure()
    failed = any(d.severity == "error" for d in scope.diagnostics)
    return (None if failed else system), scope.diagnostics


def _is_draft(root: Element) -> bool:
    """Whether shapes are spelt with a capital, as before the standard."""
    shapes = (e for e in _all(root) if e.name in SHAPES or e.name in POINT_SETS)
    return next((e.tag[0].isupper() for e in shapes), False)


def _all(root: Element) -> Iterator[Element]:
    """Yield an element and all that are in it, in no order."""
    elements = [root]
    while elements:
        element = elements.pop()
        yield element
        elements.extend(element.children)


def _system(root: Element, scope: Scope, source: SourceText) -> FuzzySystem | None:
    scope.known(root, ("name",), ("knowledgebase", *_RULE_BASES, "inferenceengine"))
    bases = list(root.all("knowledgebase"))
    if len(bases) != 1:
        message = f"<{root.tag}> has {'no' if not bases else 'several'} <knowledgeBase>"
        scope.error("FZ212" if not bases else "FZ215", message, root.span, help="put all variables into one")
        return None
    base = VariableReader(scope).read(bases[0])
    rules = RuleReader(base, scope, {e.attributes.get("modifier", "").strip().lower() for e in _all(root)})
    for element in root.all(*_RULE_BASES):
        rules.read(element)
    _require_parts(root, base, rules, scope)
    conjunction = _one(rules.conjunctions, "AND", scope, "min")
    disjunction = _one(rules.disjunctions, "OR", scope, "max")
    method = Method(conjunction=conjunction, disjunction=disjunction, semantics=_semantics(rules))
    outputs = [_with_implication(o, rules, scope) for o in base.outputs]
    if any(d.severity == "error" for d in scope.diagnostics) or not outputs:
        return None
    return FuzzySystem(
        name=" ".join(root.attributes.get("name", "").split()) or PurePath(source.name).stem,
        hedges=rules.hedges,
        method=_method(method, outputs),
        inputs=tuple(base.inputs),
        outputs=tuple(_without_common(o, _method(method, outputs)) for o in outputs),
        blocks=tuple(rules.rules),
        path=source.name,
        span=root.span,
    )


def _require_parts(root: Element, base: KnowledgeBase, rules: RuleReader, scope: Scope) -> None:
    if not base.inputs and not any(e.name == "anyadatacloud" for e in _all(root)):
        scope.error("FZ212", "the knowledge base has no input", root.span, help='add: <fuzzyVariable type="input" ...>')
    if not base.outputs:
        help_text = 'add: <fuzzyVariable type="output" ...>'
        scope.error("FZ212", "the knowledge base has no output", root.span, help=help_text)
    if not rules.rules and not any(d.severity == "error" for d in scope.diagnostics):
        scope.error("FZ212", "the document has no rule", root.span, help="add: <mamdaniRuleBase ...>")


def _one(norms: dict[str, Span], word: str, scope: Scope, usual: str) -> str:
    """Return the one norm that all rules use."""
    if len(norms) > 1:
        first, second = list(norms)[:2]
        message = f"rules with different methods for {word}: '{first}' and '{second}'"
        scope.error("FZ602", message, norms[second], help="one method for all rules is available")
    return next(iter(norms), usual)


def _semantics(rules: RuleReader) -> Semantics:
    """Return the knobs: the standard's `extremely` is the cube."""
    return Semantics(extremely="cube") if "extremely" in rules.modifiers else Semantics()


def _with_implication(output: Output, rules: RuleReader, scope: Scope) -> Output:
    """Return an output with the activation method of its rules."""
    found = rules.implications.get(output.name, {})
    over_rules = output.defuzzifier is not None and output.defuzzifier.over_rules
    if len(found) > 1 and not over_rules:
        second = list(found)[1]
        message = f"rule bases with different activation methods conclude on '{output.name}'"
        scope.error("FZ602", message, found[second], help="one method for an output is available")
    update: dict[str, Any] = {"implication": next(iter(found), "min")}
    if output.aggregation is None or over_rules:
        update["aggregation"] = "sum" if over_rules else "max"
    return output.model_copy(update=update)


def _method(method: Method, outputs: list[Output]) -> Method:
    first = outputs[0]
    shared = {n: getattr(first, n) for n in ("implication", "aggregation", "defuzzifier")}
    return method.model_copy(update=shared)


def _without_common(output: Output, method: Method) -> Output:
    """Return an output without what it shares with the system."""
    shared = {
        n: None for n in ("implication", "aggregation", "defuzzifier") if getattr(output, n) == getattr(method, n)
    }
    return output.model_copy(update=shared)
