"""Reader of FML: from XML to a fuzzy system, with all errors at once."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import PurePath
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.model.method import Method, Semantics
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Output
from tests.oracles.blocks import combined, without_common
from tests.oracles.fml.document import Element, parse_document
from tests.oracles.fml.names import POINT_SETS, SHAPES
from tests.oracles.fml.rules import RuleReader
from tests.oracles.fml.scope import Scope
from tests.oracles.fml.variables import KnowledgeBase, VariableReader

_ROOTS: Final = ("fuzzysystem", "fuzzycontroller")
#: What fuzzyctl calls the rule bases of rules that stand in no block.
_WRITTEN: Final = re.compile(r"(rules\d*)?")
_RULE_BASES: Final = ("mamdanirulebase", "tskrulebase", "tsukamotorulebase", "rulebase", "anyarulebase")


def read(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Return the system of an FML document, None where it has errors, and all diagnostics."""
    root, diagnostics = parse_document(source)
    if root is None:
        return None, diagnostics
    scope = Scope(draft=_is_draft(root))
    if root.name not in _ROOTS:
        message = f"the document is <{root.tag}>, not <fuzzySystem>, so it is not FML"
        scope.error("FZ004", message, root.span, help="FML of IEEE 1855 begins with <fuzzySystem name=...>")
        return None, scope.diagnostics
    system = _system(root, scope, source)
    scope.tell_unsure()
    failed = scope.failed
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
    outputs = [_with_aggregation(o) for o in base.outputs]
    sets = [o.name for o in outputs if o.defuzzifier is None or not o.defuzzifier.over_rules]
    keep = not all(_WRITTEN.fullmatch(b.name) for b in rules.blocks)
    found = combined(rules.blocks, sets, keep=keep)
    outputs = [o.model_copy(update={"implication": found.implications.get(o.name)}) for o in outputs]
    if scope.failed or not outputs:
        return None
    method = _method(Method(semantics=_semantics(rules), **found.method), outputs)
    return FuzzySystem(
        name=" ".join(root.attributes.get("name", "").split()) or PurePath(source.name).stem,
        hedges=rules.hedges,
        method=method,
        inputs=tuple(base.inputs),
        outputs=tuple(without_common(o, method) for o in outputs),
        blocks=found.blocks,
        path=source.name,
        span=root.span,
    )


def _require_parts(root: Element, base: KnowledgeBase, rules: RuleReader, scope: Scope) -> None:
    if not base.inputs and not any(e.name == "anyadatacloud" for e in _all(root)):
        scope.error("FZ212", "the knowledge base has no input", root.span, help='add: <fuzzyVariable type="input" ...>')
    if not base.outputs:
        help_text = 'add: <fuzzyVariable type="output" ...>'
        scope.error("FZ212", "the knowledge base has no output", root.span, help=help_text)
    if not rules.rules and not scope.failed:
        scope.error("FZ212", "the document has no rule", root.span, help="add: <mamdaniRuleBase ...>")


def _semantics(rules: RuleReader) -> Semantics:
    """Return the knobs: the standard's `extremely` is the cube."""
    return Semantics(extremely="cube") if "extremely" in rules.modifiers else Semantics()


def _with_aggregation(output: Output) -> Output:
    """Return an output with the accumulation that it has if it says none, and that of rules for an average."""
    over_rules = output.defuzzifier is not None and output.defuzzifier.over_rules
    if output.aggregation is not None and not over_rules:
        return output
    return output.model_copy(update={"aggregation": "sum" if over_rules else "max"})


def _method(method: Method, outputs: list[Output]) -> Method:
    first = outputs[0]
    shared = {n: getattr(first, n) for n in ("aggregation", "defuzzifier")}
    return method.model_copy(update=shared)
