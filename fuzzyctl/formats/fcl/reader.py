"""Reader of FCL: each function block becomes statements; all errors are reported at once."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import PurePath

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import ONE
from fuzzyctl.formats.common.blocks import FoundBlock, arranged, joins_of
from fuzzyctl.formats.common.translation import fallback, setting, settings
from fuzzyctl.formats.common.words import DUAL_OF
from fuzzyctl.formats.fcl.parser import Block, FunctionBlock, Joined, Parser, Setting
from fuzzyctl.formats.fcl.scope import Scope, dialect_of
from fuzzyctl.formats.fcl.variables import Variable, VariableReader
from fuzzyctl.formats.fcl.words import JFUZZYLOGIC_DUAL_OF
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import OVER_RULES, Activation
from fuzzyctl.model.system import FuzzySystem


def read(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Return the system of an FCL file; None if it has errors or several systems."""
    systems, diagnostics = read_all(source)
    if len(systems) > 1:
        message = f"the file has {len(systems)} function blocks"
        diagnostics.append(Diagnostic("FZ502", message, file=source.name, help="choose one of them by its name"))
    return (systems[0] if len(systems) == 1 else None), diagnostics


def read_all(source: SourceText) -> tuple[tuple[FuzzySystem, ...], list[Diagnostic]]:
    """Return the systems of an FCL file that have no errors, and all diagnostics."""
    parser = Parser(source)
    blocks = parser.parse()
    dialect = dialect_of(parser.comments, blocks)
    diagnostics = list(parser.diagnostics)
    is_broken = any(d.severity == "error" for d in diagnostics)
    unread = _words_of([d.span for d in diagnostics if d.severity == "error" and d.span is not None])
    systems = []
    for block in blocks:
        scope = Scope(source, dialect)
        _Translator(block, scope).translate()
        system = scope.system()
        diagnostics.extend(d for d in scope.diagnostics if not (is_broken and _follows(d, unread)))
        if system is not None and not is_broken:
            systems.append(system)
    return tuple(systems), [*diagnostics, *_same_names(blocks)]


def _same_names(blocks: Sequence[FunctionBlock]) -> Iterator[Diagnostic]:
    """Yield an error for each function block with the name of an earlier one."""
    first: dict[str, FunctionBlock] = {}
    for block in blocks:
        earlier = first.setdefault(block.name, block)
        if earlier is not block:
            message = f"function block '{block.name}' is declared twice"
            message = message if block.name else "two function blocks have no name"
            notes = (Note(earlier.span, "first declared here"),)
            yield Diagnostic("FZ201", message, block.span, help="rename one of them", notes=notes)


def _words_of(spans: Sequence[Span]) -> set[str]:
    """Return the words on the lines of some spans, in small letters."""
    lines = {span.source.line_text(n) for span in spans for n in range(span.line, span.end_line + 1)}
    return {word.lower() for line in lines for word in re.findall(r"\w+", line)}


def _follows(diagnostic: Diagnostic, unread: set[str]) -> bool:
    """Whether a part is missing that is in a statement which could not be read."""
    if diagnostic.code not in ("FZ202", "FZ203") or diagnostic.span is None:
        return diagnostic.code == "FZ212"
    return diagnostic.span.text.lower() in unread


class _Translator:
    """Translator of one function block.

    Args:
        block: The function block.
        scope: Takes the statements and diagnostics.
    """

    def __init__(self, block: FunctionBlock, scope: Scope) -> None:
        self._block, self._scope, self._dialect = block, scope, scope.dialect
        #: The accumulations of rule blocks, with the outputs that these set.
        self._accumulations: list[tuple[str, Span, set[str]]] = []
        #: The norms of the first rule block that is not switched off, which stay even if no rule needs them.
        self._norms: dict[str, object] = {}
        #: The first mix of AND and OR without parentheses that differs by dialect.
        self._mixed: Joined | None = None

    def translate(self) -> None:
        """Add all statements."""
        block, scope, numerics = self._block, self._scope, self._dialect.numerics
        variables = VariableReader(block, scope)
        inputs, outputs = variables.inputs, variables.outputs
        for variable in inputs:
            variable.add([] if variable.clamped else [sx.ExtrapolateClause(variable.name.span)], scope)
        blocks = self._rule_blocks(inputs, outputs)
        self._require_parts(bool(inputs), bool(blocks))
        arrangement = arranged(blocks, [v.name.text for v in outputs if v.method not in OVER_RULES], keep=True)
        aggregations = [self._aggregation(v) for v in outputs]
        method = self._norms | arrangement.method
        if outputs:
            method |= {"aggregation": aggregations[0], "defuzzifier": numerics.defuzzifier(outputs[0].method)}
        scope.statements += settings(method, block.span)
        for variable, aggregation in zip(outputs, aggregations, strict=True):
            span = variable.name.span
            fields = {
                "implication": arrangement.implications.get(variable.name.text),
                "aggregation": aggregation,
                "defuzzifier": numerics.defuzzifier(variable.method),
            }
            clauses: list[sx.Clause] = [
                sx.SettingClause(setting(n, v, span), span) for n, v in fields.items() if v and v != method.get(n)
            ]
            otherwise = variable.otherwise if variable.otherwise is not None else numerics.otherwise or "nan"
            clauses += [fallback(otherwise, span), *([sx.ClampClause(span)] if variable.clamped else [])]
            variable.add(clauses, scope)
        scope.rules(arrangement)
        name = block.name or PurePath(scope.source.name).stem
        scope.head(name, "", block.span, numerics, self._knobs(outputs, aggregations))

    def _require_parts(self, has_inputs: bool, has_rules: bool) -> None:
        scope, block = self._scope, self._block
        if not has_inputs:
            scope.error("FZ212", "the function block has no VAR_INPUT", block.span, help="declare the inputs")
        if not scope.outputs:
            scope.error("FZ212", "the function block has no VAR_OUTPUT", block.span, help="declare the outputs")
        parts = block.of("RULEBLOCK")
        if not any(part.rules for part in parts):
            span = parts[0].keyword.span if parts else block.span
            message = "the rule block has no rule" if parts else "the function block has no RULEBLOCK"
            scope.error("FZ212", message, span, help="add, for example: RULE 1 : IF x IS low THEN y IS high;")
        elif not has_rules and not scope.failed:
            message = "every rule block with rules is switched off"
            scope.error("FZ212", message, parts[0].keyword.span, help="write in one of them: ENABLED : TRUE")

    def _knobs(self, outputs: Sequence[Variable], aggregations: Sequence[str]) -> dict[str, str]:
        """Return the knobs of the numerics that the file itself sets."""
        is_averaged = any(
            v.method in ("weighted_average", "weighted_sum") and a != "sum"
            for v, a in zip(outputs, aggregations, strict=True)
        )
        # The standard accumulates first: rules of one singleton are one.
        is_merged = is_averaged and self._dialect.numerics.semantics.profile == "exact"
        knobs = {"merge": "places"} if is_merged else {}
        return knobs | ({"sigmoid_difference": "clamped"} if self._scope.clamped_differences else {})

    def _aggregation(self, variable: Variable) -> str:
        """Return the accumulation of an output; without one, that of the rule blocks that set it."""
        scope, name, norm = self._scope, variable.name.text, variable.accumulation
        of_rules = [(a, span) for a, span, outputs in self._accumulations if name in outputs]
        first = norm or (of_rules[0][0] if of_rules else None)
        other = next((pair for pair in of_rules if pair[0] != first), None)
        if variable.method in OVER_RULES:
            return first or "sum"
        if norm is not None and other is not None:
            message = f"ACCU is given here and in RULEBLOCK, with another value: '{norm}' is taken"
            scope.warning("FZ609", message, variable.block.name.span, help="keep one of them")
        elif other is not None:
            message = f"rule blocks with different ACCU conclude on '{name}'"
            notes = (Note(of_rules[0][1], f"ACCU is '{first}' here"),)
            help_text = f"'{other[0]}' here; the rules of an output are joined in one way"
            scope.error("FZ602", message, other[1], notes=notes, help=help_text)
        return first or self._dialect.numerics.method.aggregation

    # --- rule blocks -----------------------------------------------------------------------------------------------

    def _rule_blocks(self, inputs: Sequence[Variable], outputs: Sequence[Variable]) -> list[FoundBlock]:
        scope, blocks = self._scope, list[FoundBlock]()
        terms_of_outputs = {v.name.text: v.names for v in outputs}
        terms = {v.name.text: v.names for v in inputs} | terms_of_outputs
        for part in self._block.of("RULEBLOCK"):
            if self._is_switched_off(part):
                continue
            rules = tuple(r for rule in part.rules if (r := self._rule(rule, terms, terms_of_outputs)) is not None)
            joins = {word for rule in rules for word in joins_of(rule)}
            conjunction, disjunction = self._connectives(part, joins)
            implication = scope.meaning(part.setting("ACT")) or "min"
            # The writer calls the rules outside of blocks so.
            name = "" if part.name.text == "rules" and not blocks else part.name.text
            span = part.keyword.span
            block = FoundBlock(name, rules, conjunction, disjunction, implication, Activation(), span)
            accumulation = scope.meaning(part.setting("ACCU"))
            if accumulation is not None:
                self._accumulations.append((accumulation, span, block.outputs))
            scope.require_enabled(part.setting("ENABLED"))
            self._require_general(part.setting("ACTIVATION"))
            if not self._norms:
                self._norms |= {"conjunction": conjunction, "disjunction": disjunction, "implication": implication}
            if rules:
                blocks.append(block)
        if self._mixed is not None:
            from_left = self._dialect.name == "jfuzzylogic"
            order = "from left to right, as jFuzzyLogic does" if from_left else "AND first, as the standard has it"
            message = f"AND and OR are mixed without parentheses; they are read {order}"
            orders = "jFuzzyLogic reads them from left to right", "the standard and fuzzylite read AND first"
            scope.warning("FZ609", message, self._mixed.span, facts=(orders[from_left],), help="write parentheses")
        return blocks

    def _is_switched_off(self, block: Block) -> bool:
        """Return whether fuzzylite has switched a rule block off, and report it; its rules have no effect."""
        setting = next((s for s in block.settings if s.keyword.text.upper() == "ENABLED"), None)
        if setting is None or setting.word is None or setting.word.text.upper() != "FALSE":
            return False
        message = f"the rule block is switched off; it is left out, and {counted(len(block.rules), 'rule')} with it"
        self._scope.warning("FZ611", message, setting.span, help="remove it, or write: ENABLED : TRUE")
        return True

    def _require_general(self, activation: Setting | None) -> None:
        word = activation.word if activation is not None else None
        if activation is not None and (word is None or word.text.upper() not in ("GENERAL", "NONE")):
            message = "an activation method other than General is not available in FCL"
            self._scope.error("FZ602", message, activation.span)

    def _connectives(self, block: Block, joins: Collection[str]) -> tuple[str, str]:
        """Return the norms for AND and OR; a missing one follows from the other by De Morgan's laws."""
        norms: dict[str, tuple[str, Setting]] = {}
        for line in block.settings:
            word = line.keyword.text.upper()
            norm = self._scope.meaning(line) if word in ("AND", "OR") else None
            if norm is not None:
                norms.pop(word, None)
                norms[word] = (norm, line)
        tool = self._dialect.name
        pairs = JFUZZYLOGIC_DUAL_OF if tool == "jfuzzylogic" else DUAL_OF
        if len(norms) == 2 and tool != "fuzzylite":
            (first, first_line), (last, last_line) = norms.values()
            if first != pairs[last]:
                self._warn_of_no_pair(joins, first_line, last_line)
        # jFuzzyLogic takes the last one of two, fuzzylite knows no pairs.
        if not norms or tool == "fuzzylite" or (tool == "standard" and len(norms) == 2):
            return norms.get("AND", ("min",))[0], norms.get("OR", ("max",))[0]
        word, (norm, _) = list(norms.items())[-1]
        return (norm, pairs[norm]) if word == "AND" else (pairs[norm], norm)

    def _warn_of_no_pair(self, joins: Collection[str], other: Setting, last: Setting) -> None:
        """Warn that AND and OR are not a pair, if that has an effect."""
        from_last = self._dialect.name == "jfuzzylogic"
        if (other.keyword.text.lower() not in joins) if from_last else len(joins) < 2:
            return
        effect = "the last one counts, and the other follows from it" if from_last else "both are taken as they are"
        message = f"AND and OR are not a pair by De Morgan's laws; here {effect}"
        help_text = "the standard wants MIN and MAX, PROD and ASUM, or BDIF and BSUM; jFuzzyLogic takes the last one"
        self._scope.warning("FZ609", message, last.span, notes=(Note(other.span, "the other one"),), help=help_text)

    # --- rules -----------------------------------------------------------------------------------------------------

    def _rule(
        self, rule: sx.Rule, terms: Mapping[str, Sequence[str]], terms_of_outputs: Mapping[str, Sequence[str]]
    ) -> sx.Rule | None:
        """Return a rule with the declared names; None if its weight is not a number, which is reported."""
        weight = rule.weight
        if weight is not None and weight is not ONE:
            weight = self._scope.constant(weight, "the weight")
        antecedent = self._truth(rule.antecedent, terms)
        consequents = []
        for c in rule.consequents:
            assert isinstance(c.term, sx.Word)
            output, hedges, term = self._names(c.output, c.hedges, c.term, terms_of_outputs)
            consequents.append(sx.ConsequentText(output, term, hedges))
        return sx.Rule(rule.span, antecedent, tuple(consequents), weight) if weight is not None else None

    def _truth(self, truth: sx.Truth, terms: Mapping[str, Sequence[str]]) -> sx.Truth:
        match truth:
            case sx.Literal(span=span, variable=variable, hedges=hedges, term=term):
                return sx.Literal(span, *self._names(variable, hedges, term, terms))
            case sx.Negation(operand=operand):
                return replace(truth, operand=self._truth(operand, terms))
            case Joined(operators=operators):
                if "OR" in operators and "AND" in operators[operators.index("OR") :]:
                    self._mixed = self._mixed or truth
                return self._chain(truth, [self._truth(o, terms) for o in truth.operands])
        raise TypeError(type(truth).__name__)

    def _chain(self, joined: Joined, operands: Sequence[sx.Truth]) -> sx.Truth:
        """Join conditions by the precedence of the dialect; a run of one operator is one node."""
        if self._dialect.name == "jfuzzylogic":  # from left to right
            truth = operands[0]
            pairs = zip(joined.operators, operands[1:], strict=True)
            for operator, run in groupby(pairs, key=lambda pair: pair[0]):
                truth = sx.Chain(joined.span, operator.lower(), (truth, *(operand for _, operand in run)))
            return truth
        groups = [[operands[0]]]
        for operator, operand in zip(joined.operators, operands[1:], strict=True):
            if operator == "OR":
                groups.append([operand])
            else:
                groups[-1].append(operand)
        parts = [sx.Chain(joined.span, "and", tuple(group)) if len(group) > 1 else group[0] for group in groups]
        return sx.Chain(joined.span, "or", tuple(parts)) if len(parts) > 1 else parts[0]

    def _names(
        self, variable: sx.Word, hedges: Sequence[sx.Word], term: sx.Word, terms: Mapping[str, Sequence[str]]
    ) -> tuple[sx.Word, tuple[sx.Word, ...], sx.Word]:
        """Return variable, hedges and term in their declared spelling; `any` is 1 for each term, so needs none."""
        name = self._scope.spelt(variable.text, terms, variable.span) or variable.text
        names = terms.get(name, ())
        if term.text.lower() == "any" and term.text not in names and names:
            hedges, spelling = [*hedges, term], names[0]
        else:
            spelling = self._scope.spelt(term.text, names, term.span) or term.text
        lower = tuple(sx.Word(hedge.text.lower(), hedge.span) for hedge in hedges)
        return sx.Word(name, variable.span), lower, sx.Word(spelling, term.span)
