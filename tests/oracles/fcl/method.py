"""Methods of FCL rule blocks: those of the system, and those of single outputs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Note
from fuzzyctl.model.method import TSUKAMOTO, Activation, Method, Semantics
from fuzzyctl.model.rule import And, Antecedent, Or, Rule, parts_of
from fuzzyctl.model.variable import Output
from tests.oracles.blocks import Combined, FoundBlock, combined, without_common
from tests.oracles.fcl import syntax as sx
from tests.oracles.fcl.rules import RuleResolver, Vocabulary, same_either_way
from tests.oracles.fcl.scope import Scope
from tests.oracles.fcl.settings import Norms, is_switched_off, norms
from tests.oracles.fcl.variables import OutputDraft

#: Defuzzifiers over rules, for which implication has no effect, and accumulation only where terms are merged.
_OVER_RULES: Final = frozenset({"weighted_average", "weighted_sum", *TSUKAMOTO})


#: What a rule block may say, as fields of its norms and of a method.
_NORMS: Final = ("conjunction", "disjunction", "implication")

#: The word for each kind of antecedent that joins others.
_JOINS: Final[dict[type[Antecedent], str]] = {And: "AND", Or: "OR"}


class BlockRules:
    """The rules of a function block with the norms of their rule blocks.

    Args:
        block: The function block.
        scope: Where mistakes go.
        vocabulary: What rules may name.

    Attributes:
        found: All rules without mistakes, in the order written.
        norms: The norms of each rule block that is not switched off, with its rules.
        blocks: The rule blocks that have rules, with the norms that these need.
    """

    def __init__(self, block: sx.FunctionBlock, scope: Scope, vocabulary: Vocabulary) -> None:
        self.found: list[Rule] = []
        self.norms: list[tuple[Norms, list[Rule]]] = []
        self.blocks: list[FoundBlock] = []
        resolver = RuleResolver(scope, vocabulary)
        for part in block.rules:
            if is_switched_off(part, scope):
                continue
            rules = [r for r in map(resolver.rule, part.rules) if r is not None]
            joins = frozenset(_JOINS[type(p)] for r in rules for p in parts_of(r.antecedent) if type(p) in _JOINS)
            own = norms(part, scope, joins=joins)
            self.norms.append((own, rules))
            self.found.extend(rules)
            if rules:
                # So the writer calls the rules of no block.
                name = "" if part.name == "rules" and not self.blocks else part.name
                self.blocks.append(
                    FoundBlock(
                        name, tuple(rules), own.conjunction, own.disjunction, own.implication, Activation(), part.span
                    )
                )
        if resolver.mixed is not None and not same_either_way(resolver.mixed):
            _tell_mixed(resolver.mixed, scope)


def _tell_mixed(condition: sx.Joined, scope: Scope) -> None:
    left = scope.dialect.name == "jfuzzylogic"
    order = "from left to right, as jFuzzyLogic does" if left else "AND first, as the standard has it"
    message = f"AND and OR are mixed without parentheses; they are read {order}"
    other = "the standard and fuzzylite read AND first" if left else "jFuzzyLogic reads them from left to right"
    scope.warning("FZ609", message, condition.span, facts=(other,), help="write parentheses")


def method_of(drafts: list[OutputDraft], rules: BlockRules, scope: Scope) -> tuple[list[Output], Method, Combined]:
    """Return the outputs with their own norms, the method of the system, and the rules in their blocks."""
    numerics = scope.dialect.numerics
    made = [_with_norms(d, rules, scope) for d in drafts]
    found = combined(rules.blocks, [d.name.text for d in drafts if d.method not in _OVER_RULES], keep=True)
    if not made:
        return [], Method(), found
    first = made[0]
    # A norm that no rule needs is kept all the same.
    usual = {n: getattr(rules.norms[0][0], n) for n in _NORMS} if rules.norms else {}
    method = Method(
        aggregation=first.aggregation or "max",
        defuzzifier=first.defuzzifier or numerics.defuzzifier("centroid"),
        semantics=_semantics(drafts, made, scope),
        **usual | found.method,
    )
    made = [o.model_copy(update={"implication": found.implications.get(o.name)}) for o in made]
    return [without_common(o, method) for o in made], method, found


def _semantics(drafts: list[OutputDraft], made: list[Output], scope: Scope) -> Semantics:
    """Return the knobs of the numerics, with those that the file itself sets."""
    semantics = scope.dialect.numerics.semantics
    averaged = any(
        d.method in ("weighted_average", "weighted_sum") and o.aggregation != "sum"
        for d, o in zip(drafts, made, strict=True)
    )
    changes: dict[str, str] = {}
    if averaged and semantics.profile == "exact":
        # The standard accumulates first: rules of one singleton are one.
        changes["merge"] = "places"
    if scope.clamped_differences:
        changes["sigmoid_difference"] = "clamped"
    return semantics.model_copy(update=changes) if changes else semantics


def _with_norms(draft: OutputDraft, rules: BlockRules, scope: Scope) -> Output:
    """Return an output with the norms of the rule blocks that conclude on it."""
    blocks = [n for n, found in rules.norms if any(c.output == draft.name.text for r in found for c in r.consequents)]
    numerics = scope.dialect.numerics
    over_rules = draft.method in _OVER_RULES
    said = [(n.accumulation, n) for n in blocks if n.accumulation is not None]
    if draft.accumulation is not None:
        said = [s for s in said if s[0] != draft.accumulation]
        if said and not over_rules:
            message = f"ACCU is given here and in RULEBLOCK, with another value: '{draft.accumulation}' is taken"
            scope.warning("FZ609", message, draft.block.variable.span, help="keep one of them")
        aggregation: str | None = draft.accumulation
    else:
        aggregation = _agreed(said, draft, scope, needed=not over_rules)
    return Output(
        name=draft.name.text,
        lower=draft.lower,
        upper=draft.upper,
        terms=draft.terms,
        otherwise=draft.otherwise if draft.otherwise is not None else numerics.otherwise or "nan",
        clamped=draft.clamped,
        aggregation=aggregation or ("sum" if over_rules else numerics.method.aggregation),
        defuzzifier=numerics.defuzzifier(draft.method),
        span=draft.name.span,
    )


def _agreed(said: Sequence[tuple[str | None, Norms]], draft: OutputDraft, scope: Scope, *, needed: bool) -> str | None:
    """Return the accumulation that all rule blocks of an output name; an error where they differ and it matters."""
    first = said[0] if said else None
    other = next((s for s in said if first is not None and s[0] != first[0]), None)
    if first is not None and other is not None and needed:
        message = f"rule blocks with different ACCU conclude on '{draft.name.text}'"
        note = (Note(first[1].span, f"ACCU is '{first[0]}' here"),)
        help_text = f"'{other[0]}' here; the rules of an output are joined in one way"
        scope.error("FZ602", message, other[1].span, notes=note, help=help_text)
    return first[0] if first is not None else None
