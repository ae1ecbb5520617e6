"""Reader of FCL: each function block becomes statements; all errors are reported at once."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from pathlib import PurePath
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.expr import ONE, Expr
from fuzzyctl.formats.common.blocks import FoundBlock, arranged
from fuzzyctl.formats.common.infix import InfixParser, Operator
from fuzzyctl.formats.common.translation import fallback, setting, settings
from fuzzyctl.formats.fcl import syntax as fcl
from fuzzyctl.formats.fcl.dialect import Dialect, dialect_of
from fuzzyctl.formats.fcl.parser import parse
from fuzzyctl.formats.fcl.scope import Scope
from fuzzyctl.formats.fcl.settings import Norms, is_switched_off, norms
from fuzzyctl.formats.fcl.variables import Variable, VariableReader
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import OVER_RULES, Activation
from fuzzyctl.model.system import FuzzySystem

#: The standard has AND before OR, jFuzzyLogic reads both from left to right.
_AND_FIRST: Final = {"AND": Operator(2, run=True), "OR": Operator(1, run=True)}
_FROM_THE_LEFT: Final = dict.fromkeys(("AND", "OR"), Operator(1, run=True))


class RuleReader:
    """Makes nodes of rules.

    Args:
        scope: Where mistakes go.
        inputs: Terms of each input.
        outputs: Terms of each output.

    Attributes:
        mixed: The first place where AND and OR stand beside each other without parentheses, and differ by dialect.
    """

    def __init__(self, scope: Scope, inputs: Mapping[str, Sequence[str]], outputs: Mapping[str, Sequence[str]]) -> None:
        self._scope, self._outputs = scope, outputs
        self._variables = {**inputs, **outputs}
        self.mixed: fcl.Joined | None = None

    def rule(self, line: fcl.RuleLine) -> sx.Rule | None:
        """Return a rule; None if its weight is no number, which is reported."""
        weight: Expr | None = ONE
        if line.weight is not None:
            weight = self._scope.constant(line.weight, "the weight")
        antecedent = self._truth(line.condition)
        consequents = []
        for clause in line.conclusions:
            output, hedges, term = self._clause(clause, self._outputs)
            consequents.append(sx.ConsequentText(output, term, hedges))
        return sx.Rule(line.span, antecedent, tuple(consequents), weight) if weight is not None else None

    def _truth(self, condition: fcl.Condition) -> sx.Truth:
        match condition:
            case fcl.Clause(span=span):
                return sx.Literal(span, *self._clause(condition, self._variables))
            case fcl.Negated(operand=operand, span=span):
                return sx.Negation(span, self._truth(operand))
            case fcl.Joined(operators=operators):
                words = [o.upper for o in operators]
                if "OR" in words and "AND" in words[words.index("OR") :]:
                    self.mixed = self.mixed or condition
                infix = _FROM_THE_LEFT if self._scope.dialect.name == "jfuzzylogic" else _AND_FIRST
                return _Joining(condition, [self._truth(o) for o in condition.operands], infix).parse()
        raise TypeError(type(condition).__name__)

    def _clause(
        self, clause: fcl.Clause, known: Mapping[str, Sequence[str]]
    ) -> tuple[sx.Word, tuple[sx.Word, ...], sx.Word]:
        """Return variable, hedges and term of a clause; `any` needs no term, since it is 1 for each."""
        scope, place = self._scope, clause.variable.span
        name = scope.spelt(clause.variable.text, known, place) or clause.variable.text
        terms, (*before, last) = known.get(name, ()), clause.words
        if last.text.lower() == "any" and last.text not in terms and terms:
            before, term = [*before, last], terms[0]
        else:
            term = scope.spelt(last.text, terms, last.span) or last.text
        hedges = tuple(sx.Word(w.text.lower(), w.span) for w in before)
        return sx.Word(name, place), hedges, sx.Word(term, last.span)


class _Joining(InfixParser[sx.Truth, None]):
    """Joins conditions by the precedence of a dialect; a run of one operator is one node."""

    def __init__(self, condition: fcl.Joined, operands: Sequence[sx.Truth], infix: Mapping[str, Operator]) -> None:
        self.infix, self._span = infix, condition.span
        self._operands = iter(operands)
        self._operators = deque(o.upper for o in condition.operators)

    def _peek(self) -> str:
        return self._operators[0] if self._operators else ""

    def _take(self) -> None:
        self._operators.popleft()

    def _atom(self) -> sx.Truth:
        return next(self._operands)

    def _joined(self, sign: str, operands: Sequence[sx.Truth], places: Sequence[None]) -> sx.Truth:
        return sx.Chain(self._span, sign.lower(), tuple(operands))


#: What a rule block may say, as fields of its norms and of a method.
_NORMS: Final = ("conjunction", "disjunction", "implication")


def read_all(source: SourceText) -> tuple[tuple[FuzzySystem, ...], list[Diagnostic]]:
    """Return the systems of an FCL file that have no errors, and all diagnostics."""
    file = parse(source)
    dialect = dialect_of(file)
    diagnostics = list(file.diagnostics)
    broken = any(d.severity == "error" for d in diagnostics)
    lost = _words_of([d.span for d in diagnostics if d.severity == "error" and d.span is not None])
    systems = []
    for block in file.blocks:
        scope = Scope(source, dialect)
        _FunctionBlock(block, scope).translate()
        found = scope.system()
        diagnostics.extend(d for d in scope.diagnostics if not (broken and _follows(d, lost)))
        if found is not None and not broken:
            systems.append(found)
    return tuple(systems), [*diagnostics, *_same_names(file.blocks)]


def _same_names(blocks: Sequence[fcl.FunctionBlock]) -> Iterator[Diagnostic]:
    """Find function blocks that no name tells apart, so that none of them can be chosen."""
    first: dict[str, fcl.FunctionBlock] = {}
    for block in blocks:
        earlier = first.setdefault(block.name, block)
        if earlier is not block:
            named = f"function block '{block.name}' is declared twice"
            message = named if block.name else "two function blocks have no name"
            notes = (Note(earlier.span, "first declared here"),)
            yield Diagnostic("FZ201", message, block.span, help="rename one of them", notes=notes)


def _words_of(spans: Sequence[Span]) -> set[str]:
    """Return the words on the lines of some places, in small letters."""
    lines = {span.source.line_text(n) for span in spans for n in range(span.line, span.end_line + 1)}
    return {word.lower() for line in lines for word in re.findall(r"\w+", line)}


def _follows(diagnostic: Diagnostic, broken: set[str]) -> bool:
    """Whether something is missing that stands in a statement which could not be read."""
    if diagnostic.code not in ("FZ202", "FZ203") or diagnostic.span is None:
        return diagnostic.code == "FZ212"
    return diagnostic.span.text.lower() in broken


def read(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Return the system of an FCL file; None where it has errors, or several systems."""
    systems, diagnostics = read_all(source)
    if len(systems) > 1:
        message = f"the file has {len(systems)} function blocks"
        diagnostics.append(Diagnostic("FZ502", message, file=source.name, help="choose one of them by its name"))
    return (systems[0] if len(systems) == 1 else None), diagnostics


class _FunctionBlock:
    """Translates one function block.

    Args:
        block: The function block.
        scope: Takes the statements, and mistakes.
    """

    def __init__(self, block: fcl.FunctionBlock, scope: Scope) -> None:
        self._block, self._scope = block, scope
        self._dialect: Dialect = scope.dialect
        #: The norms of each rule block that is not switched off, with the outputs that it sets.
        self._norms: list[tuple[Norms, set[str]]] = []

    def translate(self) -> None:
        """Add all statements."""
        block, scope, numerics = self._block, self._scope, self._dialect.numerics
        variables = VariableReader(block, scope)
        inputs = variables.inputs()
        outputs = variables.outputs(inputs)
        for variable in inputs:
            variable.add("input", [] if variable.clamped else [sx.ExtrapolateClause(variable.name.span)], scope)
        blocks = self._rules(inputs, outputs)
        self._require_parts(bool(inputs), bool(blocks))
        found = arranged(blocks, [v.name.text for v in outputs if v.method not in OVER_RULES], keep=True)
        aggregations = [self._aggregation(v) for v in outputs]
        # A norm that no rule needs is kept all the same.
        method = {n: getattr(self._norms[0][0], n) for n in _NORMS} if self._norms else {}
        method |= found.method
        if outputs:
            method |= {"aggregation": aggregations[0], "defuzzifier": numerics.defuzzifier(outputs[0].method)}
        scope.statements += settings(method, block.span)
        for variable, aggregation in zip(outputs, aggregations, strict=True):
            said = {
                "implication": found.implications.get(variable.name.text) or method.get("implication"),
                "aggregation": aggregation,
                "defuzzifier": numerics.defuzzifier(variable.method),
            }
            place = variable.name.span
            clauses: list[sx.Clause] = [
                sx.SettingClause(setting(n, v, place), place) for n, v in said.items() if v and v != method.get(n)
            ]
            otherwise = variable.otherwise if variable.otherwise is not None else numerics.otherwise or "nan"
            clauses += [fallback(otherwise, place), *([sx.ClampClause(place)] if variable.clamped else [])]
            variable.add("output", clauses, scope)
        scope.rules(found)
        name = block.name or PurePath(scope.source.name).stem
        scope.head(name, "", block.span, numerics, self._knobs(outputs, aggregations))

    def _rules(self, inputs: Sequence[Variable], outputs: Sequence[Variable]) -> list[FoundBlock]:
        scope, found = self._scope, list[FoundBlock]()
        reader = RuleReader(scope, {v.name.text: v.names for v in inputs}, {v.name.text: v.names for v in outputs})
        for part in self._block.rules:
            if is_switched_off(part, scope):
                continue
            rules = tuple(r for r in map(reader.rule, part.rules) if r is not None)
            # So the writer calls the rules of no block.
            name = "" if part.name == "rules" and not found else part.name
            made = FoundBlock(name, rules, None, None, None, Activation(), part.span)
            own = norms(part, scope, made.joins)
            self._norms.append((own, made.outputs))
            if rules:
                found.append(made.with_norms(own.conjunction, own.disjunction, own.implication))
        if reader.mixed is not None:
            left = self._dialect.name == "jfuzzylogic"
            order = "from left to right, as jFuzzyLogic does" if left else "AND first, as the standard has it"
            message = f"AND and OR are mixed without parentheses; they are read {order}"
            other = "the standard and fuzzylite read AND first" if left else "jFuzzyLogic reads them from left to right"
            scope.warning("FZ609", message, reader.mixed.span, facts=(other,), help="write parentheses")
        return found

    def _require_parts(self, inputs: bool, rules: bool) -> None:
        scope, block = self._scope, self._block
        if not inputs:
            scope.error("FZ212", "the function block has no VAR_INPUT", block.span, help="declare the inputs")
        if not scope.outputs:
            scope.error("FZ212", "the function block has no VAR_OUTPUT", block.span, help="declare the outputs")
        if not any(b.rules for b in block.rules):
            place = block.rules[0].span if block.rules else block.span
            message = "the rule block has no rule" if block.rules else "the function block has no RULEBLOCK"
            scope.error("FZ212", message, place, help="add, for example: RULE 1 : IF x IS low THEN y IS high;")
        elif not rules and not scope.failed:
            message = "every rule block with rules is switched off"
            scope.error("FZ212", message, block.rules[0].span, help="write in one of them: ENABLED : TRUE")

    def _knobs(self, outputs: Sequence[Variable], aggregations: Sequence[str]) -> dict[str, str]:
        """Return the knobs of the numerics that the file itself sets."""
        averaged = any(
            v.method in ("weighted_average", "weighted_sum") and a != "sum"
            for v, a in zip(outputs, aggregations, strict=True)
        )
        # The standard accumulates first: rules of one singleton are one.
        knobs = {"merge": "places"} if averaged and self._dialect.numerics.semantics.profile == "exact" else {}
        return knobs | ({"sigmoid_difference": "clamped"} if self._scope.clamped_differences else {})

    def _aggregation(self, variable: Variable) -> str:
        """Return the accumulation of an output: its own, or that of the rule blocks that conclude on it."""
        over_rules = variable.method in OVER_RULES
        own, name = variable.accumulation, variable.name.text
        said = [(n.accumulation, n) for n, outputs in self._norms if n.accumulation is not None and name in outputs]
        other = next((s for s in said if s[0] != (own or said[0][0])), None)
        if own is not None and other is not None and not over_rules:
            message = f"ACCU is given here and in RULEBLOCK, with another value: '{own}' is taken"
            place = variable.block.variable.span if variable.block is not None else variable.name.span
            self._scope.warning("FZ609", message, place, help="keep one of them")
        elif other is not None and not over_rules:
            message = f"rule blocks with different ACCU conclude on '{name}'"
            notes = (Note(said[0][1].span, f"ACCU is '{said[0][0]}' here"),)
            help_text = f"'{other[0]}' here; the rules of an output are joined in one way"
            self._scope.error("FZ602", message, other[1].span, notes=notes, help=help_text)
        found = own or (said[0][0] if said else None)
        return found or ("sum" if over_rules else self._dialect.numerics.method.aggregation)
