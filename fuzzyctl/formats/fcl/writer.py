"""Writer of FCL: the standard's words where they suffice, else those of a dialect."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from typing import Final

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.diagnostics.terminal import in_ascii
from fuzzyctl.expr import (
    COMPARISONS,
    Call,
    Expr,
    Name,
    Negate,
    Number,
    number_text,
    replace,
    replace_names,
    to_text,
    walk,
)
from fuzzyctl.formats.common import losses as numerics
from fuzzyctl.formats.common.blocks import BlockPart, block_parts
from fuzzyctl.formats.common.identifiers import with_names
from fuzzyctl.formats.common.losses import losses_of, with_named_consequents, with_numbers_averaged
from fuzzyctl.formats.common.ranges import with_shoulders
from fuzzyctl.formats.common.report import Names
from fuzzyctl.formats.common.words import up_to_any, words_by_kind
from fuzzyctl.formats.fcl.reader import read
from fuzzyctl.formats.fcl.words import (
    JFUZZYLOGIC_SHAPES,
    MEANINGS,
    METHOD_WORDS,
    SHAPE_WORDS,
    USUAL_NUMERICS,
    DialectName,
    norm_word,
)
from fuzzyctl.formats.fll.formulas import formula
from fuzzyctl.formats.fll.methods import as_inverted_there, inferred_otherwise
from fuzzyctl.formats.fll.shapes import TERMS, as_written
from fuzzyctl.formats.registry import Loss
from fuzzyctl.formulas import HEDGES, MEMBERSHIP, is_number, is_straight
from fuzzyctl.model.method import TSUKAMOTO
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule, is_joined_by, literals, parts_of
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, Membership, Output

#: Words that are not names in FCL; jFuzzyLogic takes none of them for one in any place.
_RESERVED: Final = frozenset(
    {
        *("AND", "OR", "NOT", "IF", "THEN", "IS", "WITH", "RULE", "TERM", "RANGE", "METHOD", "ACCU", "ACT", "DEFAULT"),
        *("NC", "NAN", "INF", "INFINITY", "REAL", "LOCK", "ENABLED", "FUZZIFY", "DEFUZZIFY", "RULEBLOCK", "OPTIONS"),
        *("VAR", "VAR_INPUT", "VAR_OUTPUT", "FUNCTION_BLOCK", "EXP", "LN", "LOG", "SIN", "COS", "TAN", "ABS", "NONE"),
        *("END_VAR", "END_FUZZIFY", "END_DEFUZZIFY", "END_RULEBLOCK", "END_FUNCTION_BLOCK", "END_OPTIONS", "PI"),
        *(word for meanings in MEANINGS.values() for word in meanings),
        *SHAPE_WORDS,
        *map(str.upper, HEDGES),
    }
)

_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")

_TITLES: Final[dict[DialectName, str]] = {
    "standard": "Fuzzy Control Language of IEC 61131-7",
    "jfuzzylogic": "Fuzzy Control Language with the extensions of jFuzzyLogic",
    "fuzzylite": "Fuzzy Control Language in the dialect of fuzzylite",
}

#: Functions of expressions that jFuzzyLogic has, by its words.
_JFUZZYLOGIC_FUNCTIONS: Final = {"exp": "EXP", "log": "LN", "sin": "SIN", "cos": "COS", "tan": "TAN", "abs": "ABS"}

#: Functions of expressions that fuzzylite has besides, or that are expressions of others there.
_FUZZYLITE_FUNCTIONS: Final = frozenset(
    {*_JFUZZYLOGIC_FUNCTIONS, "sqrt", "min", "max", "atan2", "floor", "ceil", "fmod", "sign", *COMPARISONS}
)

_JFUZZYLOGIC: Final = words_by_kind(JFUZZYLOGIC_SHAPES)
_FUZZYLITE: Final = {kind: word for kind, (word, _) in words_by_kind(TERMS).items()} | {"rectangle": "Rectangle"}

#: Kinds that some dialect has words for, points and numbers included.
_SPELT: Final = frozenset({*_JFUZZYLOGIC, *_FUZZYLITE, *(k for k in MEMBERSHIP if is_straight(k) or is_number(k))})

#: Norms of the standard, and norms that only fuzzylite has.
_ONLY_FUZZYLITE: Final = frozenset({"einstein_product", "hamacher_sum"})
_STANDARD: Final = frozenset({"min", "max", "product", "probabilistic_sum", "bounded_difference", "bounded_sum"})


def write(system: FuzzySystem) -> tuple[str, list[Loss]]:
    """Return a system as FCL, with its losses.

    The dialect is the plainest one that has words for all of it, and its numerics are those of the tool that reads it:
    others are among the losses. No word holds inputs within their ranges: fuzzylite, which reads LOCK of outputs,
    refuses a file with LOCK of an input. Shoulders do if they can.

    Raises:
        DiagnosticError: With all reasons, for a system of Tsukamoto's method that fuzzylite would take for another one.
    """
    norms = {*MEANINGS["ACT"].values(), *MEANINGS["ACCU"].values()}
    if reasons := [*numerics.formula_sets(system), *numerics.missing_words(system, _SPELT, norms)]:
        raise numerics.cannot(system, ".fcl", reasons)
    named, losses = with_named_consequents(system, "c", fold=str.upper)
    named, averaged = with_numbers_averaged(named)
    named = with_shoulders(named, points=True)
    if _dialect_for(named) == "fuzzylite":
        named, reasons = as_inverted_there(named)
        if reasons := [*reasons, *inferred_otherwise(named)]:
            raise numerics.cannot(system, ".fcl", reasons)
    named, renamed = with_names(named, _spelt, str.upper)
    writer = _Writer(named)
    text = "\n".join(writer.lines()) + "\n"
    back, _ = read(SourceText("written.fcl", text))
    rules = [r for part in writer.parts for r, _ in part.rules]
    changes = losses_of(named.model_copy(update={"title": ""}), back, rules)
    return text, sorted({*losses, *averaged, *renamed, *changes, *writer.losses()})


def _spelt(name: str, where: str = "") -> str:
    """Return a name that FCL can hold."""
    if _NAME.fullmatch(name) and name.upper() not in _RESERVED:
        return name
    spelling = re.sub(r"_+", "_", in_ascii(name)).strip("_") or "unnamed"
    if not spelling[0].isalpha():
        spelling = f"n_{spelling}"
    return f"{spelling}_" if spelling.upper() in _RESERVED else spelling


# --- dialects ------------------------------------------------------------------------------------------------------


def _dialect_for(system: FuzzySystem) -> DialectName:
    """Return the plainest dialect that has words for a system; that of its numerics if these are of a tool."""
    profile = system.method.semantics.profile
    memberships = [t.membership for v in (*system.inputs, *system.outputs) for t in v.terms]
    norms = _norms(system)
    if profile in ("fuzzylite", "fuzzylite_6", "pyfuzzylite") or _needs_fuzzylite(system, norms, memberships):
        return "fuzzylite"
    # The standard alone has points and singletons only.
    is_plain = all(is_number(m.kind) or is_straight(m.kind) for m in memberships)
    return "standard" if profile != "jfuzzylogic" and is_plain and norms <= _STANDARD else "jfuzzylogic"


def _needs_fuzzylite(system: FuzzySystem, norms: set[str], memberships: Sequence[Membership]) -> bool:
    aggregations = {o.aggregation or system.method.aggregation for o in system.outputs}
    return (
        bool(set().union(*numerics.used_hedges(system)) - {"not"})
        or bool((norms | aggregations) & _ONLY_FUZZYLITE)
        or any(o.clamped for o in system.outputs)
        or any(isinstance(o.otherwise, Hold) and isinstance(o.otherwise.start, Expr) for o in system.outputs)
        or any(numerics.defuzzifier_of(system, o).kind in TSUKAMOTO for o in system.outputs)
        or any(_is_of_fuzzylite(system, m) for m in memberships)
    )


def _norms(system: FuzzySystem) -> set[str]:
    """Return the norms of rule blocks for AND, OR and ACT."""
    method = system.method
    if not system.rule_blocks:
        return {method.conjunction, method.disjunction, *(o.implication or method.implication for o in system.outputs)}
    return {n for p in block_parts(system) for n in (p.method.conjunction, p.method.disjunction, p.implication)}


def _is_of_fuzzylite(system: FuzzySystem, membership: Membership) -> bool:
    """Return whether only fuzzylite has a word for a term."""
    kind = membership.kind
    if kind in ("function", "linear"):
        return any(name not in _JFUZZYLOGIC_FUNCTIONS for name in _functions(membership))
    numbers = _numbers(system, membership)
    if _is_as_points(membership, numbers, "jfuzzylogic") or kind in ("singleton", "constant", "piecewise"):
        return False
    if system.number(membership.height) != 1.0 or kind not in _JFUZZYLOGIC:
        return True
    # Of the words without a foot jFuzzyLogic has none for a term that never ends on one side.
    return kind == "gaussian2" and (numbers[0] > numbers[2] or any(map(math.isinf, numbers)))


def _is_as_points(membership: Membership, numbers: Sequence[float], dialect: DialectName) -> bool:
    """Return whether a straight term is written as points, as a dialect has no word for it; the standard has none."""
    kind = membership.kind
    if not is_straight(kind) or kind == "piecewise" or dialect == "fuzzylite":
        return False
    has_word = dialect == "jfuzzylogic" and kind in _JFUZZYLOGIC
    return not has_word or any(map(math.isinf, numbers)) or membership.height != Number(1.0)


def _numbers(system: FuzzySystem, membership: Membership) -> tuple[float, ...]:
    return tuple(map(system.number, membership.arguments))


def _functions(membership: Membership) -> set[str]:
    """Return the functions of an expression."""
    nodes = walk(membership.arguments[0]) if membership.kind == "function" else []
    return {node.function for node in nodes if isinstance(node, Call)}


# --- text ----------------------------------------------------------------------------------------------------------


class _Writer:
    """Writer of a system whose names are those of the file.

    Attributes:
        parts: The rule blocks of the text, each with one implication.
    """

    def __init__(self, system: FuzzySystem) -> None:
        self._system = system
        self.parts = block_parts(system)
        self._dialect = _dialect_for(system)
        self._is_fuzzylite = self._dialect == "fuzzylite"
        self._accumulations = {o.name: self._accumulation(o) for o in system.outputs}
        #: Whether all outputs have one accumulation, so that rule blocks name it.
        self._is_common = len(set(self._accumulations.values())) == 1

    def losses(self) -> Iterator[Loss]:
        """Yield the parts of terms and rules that are written in another way, or that only fuzzyctl reads."""
        system = self._system
        whole = f"system '{system.name}'"
        if system.title:
            yield Loss(whole, "the title", "it is a comment", exact=True)
        for hedge in system.hedges:
            yield Loss(whole, f"hedge '{hedge.name}'", "FCL has no hedges of one's own; it is left out")
        for variable in (*system.inputs, *system.outputs):
            where = f"{'input' if isinstance(variable, Input) else 'output'} '{variable.name}'"
            for term in variable.terms:
                membership = term.membership
                is_set = membership.kind not in ("function", "linear", "singleton", "constant")
                if is_set and _is_as_points(membership, _numbers(system, membership), self._dialect):
                    yield Loss(where, f"term '{term.name}'", f"the {membership.kind} is written as points", exact=True)
                for name in _functions(membership) - _FUZZYLITE_FUNCTIONS:
                    yield Loss(f"{where}, term '{term.name}'", f"function '{name}'", "no FCL tool has it")
        for number, rule in enumerate(system.rules, 1):
            yield from self._losses_of_rule(f"rule {number}", rule)

    def _losses_of_rule(self, where: str, rule: Rule) -> Iterator[Loss]:
        hedges = [h for i in literals(rule.antecedent) for h in i.hedges]
        for hedge in {*hedges, *(h for c in rule.consequents for h in c.hedges)}:
            if hedge not in HEDGES:
                yield Loss(where, f"hedge '{hedge}'", "no FCL tool has it; it is left out")
            elif hedge == "slightly" and self._is_fuzzylite:
                yield Loss(where, f"hedge '{hedge}'", "no FCL tool has it; only fuzzyctl reads it")
        if self._is_fuzzylite and any(isinstance(part, Not) for part in parts_of(rule.antecedent)):
            yield Loss(where, "not", "fuzzylite does not read NOT before a condition", exact=True)

    def lines(self) -> Iterator[str]:
        """Yield the lines of the text."""
        system, profile = self._system, self._system.method.semantics.profile
        yield f"// {_TITLES[self._dialect]}"
        if system.title:
            yield f"// {' '.join(system.title.split())}"
        if self._is_fuzzylite and profile == "fuzzylite_6":
            yield f"// numerics of {profile}"
        elif self._dialect == "standard":
            yield f"// numerics of {USUAL_NUMERICS['standard']}"
        yield from (f"FUNCTION_BLOCK {system.name}", "")
        # jFuzzyLogic takes the range of an input here, fuzzylite in FUZZIFY.
        ranges = ["" if self._is_fuzzylite else f" {self._range(i)}" for i in system.inputs]
        yield from ("VAR_INPUT", *(f"  {i.name} : REAL;{r}" for i, r in zip(system.inputs, ranges, strict=True)))
        yield from ("END_VAR", "", "VAR_OUTPUT", *(f"  {o.name} : REAL;" for o in system.outputs), "END_VAR", "")
        for variable in system.inputs:
            if variable.terms or self._is_fuzzylite:
                ranges = [f"  {self._range(variable)}"] if self._is_fuzzylite else []
                yield from (f"FUZZIFY {variable.name}", *ranges, *self._terms(variable), "END_FUZZIFY", "")
        for output in system.outputs:
            yield from (f"DEFUZZIFY {output.name}", f"  {self._range(output)}", *self._terms(output))
            yield from (*self._output(output), "END_DEFUZZIFY", "")
        others = Names(b.name for b in system.rule_blocks)
        for part in self.parts:
            name = system.rule_blocks[part.block].name if part.block >= 0 else "rules"
            name = name if part.block >= 0 and part.number == 1 else others.take(name)
            yield from (f"RULEBLOCK {name}", *self._rule_block(part), "END_RULEBLOCK", "")
        yield "END_FUNCTION_BLOCK"

    def _range(self, variable: Input | Output) -> str:
        low, high = (number_text(self._system.number(end)) for end in (variable.lower, variable.upper))
        return f"RANGE := ({low} .. {high});"

    def _output(self, output: Output) -> Iterator[str]:
        defuzzifier, accumulation = numerics.defuzzifier_of(self._system, output), self._accumulations[output.name]
        yield f"  METHOD : {METHOD_WORDS.get(defuzzifier.kind, 'COG')};"
        # Without an accumulation fuzzylite does not aggregate before averaging.
        is_plain_sum = accumulation == "UnboundedSum" and defuzzifier.over_rules
        if not is_plain_sum and (self._is_fuzzylite or not self._is_common):
            yield f"  ACCU : {accumulation};"
        if output.clamped and self._is_fuzzylite:
            # Before DEFAULT: fuzzylite takes from LOCK whether the previous value is held, too.
            yield "  LOCK : RANGE;"
        start = numerics.value_unfired(self._system, output)
        text = "nan" if start is None else number_text(start)
        if isinstance(output.otherwise, Hold):
            yield f"  DEFAULT := {f'{text} | NC' if self._is_fuzzylite else 'NC'};"
        elif start is not None or self._is_fuzzylite:
            yield f"  DEFAULT := {text};"

    def _accumulation(self, output: Output) -> str:
        method = self._system.method
        aggregation = output.aggregation or method.aggregation
        if numerics.defuzzifier_of(self._system, output).over_rules and method.semantics.merge == "rules":
            aggregation = "sum"  # each rule counts for itself
        return norm_word("ACCU", aggregation, self._dialect)

    # --- terms -----------------------------------------------------------------------------------------------------

    def _terms(self, variable: Input | Output) -> Iterator[str]:
        for term in variable.terms:
            yield f"  TERM {term.name} := {self._shape(term.membership)};"

    def _shape(self, membership: Membership) -> str:
        """Return the text behind `TERM name :=`."""
        kind = membership.kind
        if kind == "function":
            return f"{'Function' if self._is_fuzzylite else 'FUNCTION'} {self._formula(membership.arguments[0])}"
        numbers, height = _numbers(self._system, membership), self._system.number(membership.height)
        if kind == "linear" and not self._is_fuzzylite:  # a sum over all inputs in order reads back as one
            pairs = zip(numbers, self._system.inputs, strict=False)
            products = [f"{number_text(factor)} * {i.name}" for factor, i in pairs]
            return f"FUNCTION {' + '.join([*products, number_text(numbers[-1])])}"
        if kind in ("singleton", "constant"):
            return number_text(numbers[0])
        is_points = kind == "piecewise" or _is_as_points(membership, numbers, self._dialect)
        if is_points:
            corners = zip(numbers[::2], numbers[1::2], strict=True)
            points = corners if kind == "piecewise" else MEMBERSHIP[kind].vertices(numbers)
            return " ".join(f"({number_text(x)}, {number_text(y * height)})" for x, y in points)
        if self._is_fuzzylite:
            word, parameters = _FUZZYLITE[kind], as_written(kind, numbers)
            parameters = parameters if height == 1.0 or kind == "linear" else (*parameters, height)
        else:
            word, shape = _JFUZZYLOGIC[kind]
            parameters = shape.parameters(numbers)
        return " ".join([word, *map(number_text, parameters)])

    def _formula(self, expression: Expr) -> str:
        """Return an expression with the names of the file, without params."""
        expression = replace_names(expression, {name: Number(v) for name, v in self._system.values.items()})
        text = formula(expression, {}) if self._is_fuzzylite else None
        return text if text is not None else to_text(replace(expression, _as_in_jfuzzylogic))

    # --- rules -----------------------------------------------------------------------------------------------------

    def _rule_block(self, part: BlockPart) -> Iterator[str]:
        """Yield AND and OR, the one that rules use last, as jFuzzyLogic takes the last of two that are not a pair."""
        method = part.method
        connectives = [("OR", method.disjunction), ("AND", method.conjunction)]
        if not any(is_joined_by(And, rule.antecedent) for _, rule in part.rules):
            connectives.reverse()
        for keyword, norm in (*connectives, ("ACT", part.implication)):
            yield f"  {keyword} : {norm_word(keyword, norm, self._dialect)};"
        if not self._is_fuzzylite and self._is_common:
            yield f"  ACCU : {next(iter(self._accumulations.values()))};"
        for position, rule in part.rules:
            yield f"  RULE {position + 1} : {self._rule(rule)}"

    def _rule(self, rule: Rule) -> str:
        """Return a rule; fuzzylite reads its words in small letters, and a semicolon as a part of the term."""
        weight = self._system.number(rule.weight)
        tail = f" {self._word('WITH')} {number_text(weight)}" if weight != 1.0 else ""
        conclusions = [self._proposition(c.output, c.hedges, (str(c.term),)) for c in rule.consequents]
        conclusion = (" and " if self._is_fuzzylite else ", ").join(conclusions)
        condition = self._condition(rule.antecedent)
        end = "" if self._is_fuzzylite else ";"
        return f"{self._word('IF')} {condition} {self._word('THEN')} {conclusion}{tail}{end}"

    def _word(self, word: str) -> str:
        return word.lower() if self._is_fuzzylite else word

    def _proposition(self, variable: str, hedges: tuple[str, ...], term: tuple[str, ...]) -> str:
        words = [self._word("NOT") if h == "not" else h for h in hedges if h in HEDGES]
        return f"{variable} {self._word('IS')} {' '.join([*words, *term])}"

    def _condition(self, antecedent: Antecedent, *, is_inner: bool = False) -> str:
        match antecedent:
            case Is(variable=variable, term=term, hedges=hedges):
                return self._proposition(variable, *up_to_any(hedges, term))
            case Not(operand=operand):
                return f"{self._word('NOT')} ({self._condition(operand)})"
            case And(operands=operands) | Or(operands=operands):
                word = self._word("AND" if isinstance(antecedent, And) else "OR")
                text = f" {word} ".join(self._condition(o, is_inner=True) for o in operands)
                return f"({text})" if is_inner else text
        raise TypeError(type(antecedent).__name__)


def _as_in_jfuzzylogic(node: Expr) -> Expr:
    """Return a part of an expression in the words of jFuzzyLogic, which has signs at numbers only."""
    if isinstance(node, Negate):
        return -1.0 * node.operand
    if isinstance(node, Call) and node.function in _JFUZZYLOGIC_FUNCTIONS:
        return Call(_JFUZZYLOGIC_FUNCTIONS[node.function], node.arguments)
    if isinstance(node, Number):
        return Number(node.value)
    return Number(math.pi) if node == Name("pi") else node
