"""Writer of FCL: the standard's words where they suffice, else those of a dialect."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.diagnostics.transliterate import in_ascii
from fuzzyctl.expr import Expr, Number, number_text, replace_names
from fuzzyctl.formats.common import losses as numerics
from fuzzyctl.formats.common.blocks import BlockPart, block_parts
from fuzzyctl.formats.common.identifiers import with_names
from fuzzyctl.formats.common.losses import losses_of, with_named_consequents, with_numbers_averaged
from fuzzyctl.formats.common.ranges import with_shoulders
from fuzzyctl.formats.common.report import Names
from fuzzyctl.formats.common.words import up_to_any
from fuzzyctl.formats.fcl.dialect import USUAL_NUMERICS, DialectName
from fuzzyctl.formats.fcl.names import (
    ACCUMULATION_WORDS,
    CONJUNCTION_WORDS,
    DISJUNCTION_WORDS,
    METHOD_WORDS,
    SHAPE_WORDS,
)
from fuzzyctl.formats.fcl.reader import read
from fuzzyctl.formats.fcl.written_shapes import (
    SPELT,
    linear_text,
    needs_fuzzylite,
    needs_jfuzzylogic,
    says_otherwise,
    shape_text,
    unknown_functions,
)
from fuzzyctl.formats.fll.methods import as_inverted_there, inferred_otherwise
from fuzzyctl.formats.registry import Loss
from fuzzyctl.formulas import HEDGES
from fuzzyctl.model.method import TSUKAMOTO
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule, is_joined_by, literals, parts_of
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, Membership, Output

#: Words that are no names in FCL; jFuzzyLogic takes none of them for one, wherever it stands.
RESERVED: Final = frozenset(
    {
        *("AND", "OR", "NOT", "IF", "THEN", "IS", "WITH", "RULE", "TERM", "RANGE", "METHOD", "ACCU", "ACT", "DEFAULT"),
        *("NC", "NAN", "INF", "INFINITY", "REAL", "LOCK", "ENABLED", "FUZZIFY", "DEFUZZIFY", "RULEBLOCK", "OPTIONS"),
        *("VAR", "VAR_INPUT", "VAR_OUTPUT", "FUNCTION_BLOCK", "EXP", "LN", "LOG", "SIN", "COS", "TAN", "ABS", "NONE"),
        *("END_VAR", "END_FUZZIFY", "END_DEFUZZIFY", "END_RULEBLOCK", "END_FUNCTION_BLOCK", "END_OPTIONS", "PI"),
        *CONJUNCTION_WORDS,
        *ACCUMULATION_WORDS,
        *METHOD_WORDS,
        *SHAPE_WORDS,
        *(h.upper() for h in HEDGES),
    }
)

_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def spelt(name: str, where: str = "") -> str:
    """Return a name that FCL can hold."""
    if _NAME.fullmatch(name) and name.upper() not in RESERVED:
        return name
    found = re.sub(r"_+", "_", in_ascii(name)).strip("_") or "unnamed"
    if not found[0].isalpha():
        found = f"n_{found}"
    return f"{found}_" if found.upper() in RESERVED else found


def without_words(system: FuzzySystem, dialect: DialectName) -> Iterator[Loss]:
    """Yield what of terms and rules is written in another way, or that only fuzzyctl reads."""
    whole = f"system '{system.name}'"
    if system.title:
        yield Loss(whole, "the title", "it is a comment", exact=True)
    for hedge in system.hedges:
        yield Loss(whole, f"hedge '{hedge.name}'", "FCL has no hedges of one's own; it is left out")
    for variable in (*system.inputs, *system.outputs):
        where = f"{'input' if isinstance(variable, Input) else 'output'} '{variable.name}'"
        for term in variable.terms:
            if says_otherwise(term.membership, system.values, dialect):
                why = f"the {term.membership.kind} is written as points"
                yield Loss(where, f"term '{term.name}'", why, exact=True)
            for name in unknown_functions(term.membership):
                yield Loss(f"{where}, term '{term.name}'", f"function '{name}'", "no FCL tool has it")
    yield from _of_rules(system, dialect)


def _of_rules(system: FuzzySystem, dialect: DialectName) -> Iterator[Loss]:
    own = {h.name for h in system.hedges}
    no_tool = {"slightly"} if dialect == "fuzzylite" else set()
    for number, rule in enumerate(system.rules, 1):
        hedges = {h for i in literals(rule.antecedent) for h in i.hedges}
        hedges |= {h for c in rule.consequents for h in c.hedges}
        for hedge in sorted(hedges & (own | no_tool) | (hedges - set(HEDGES))):
            why = "it is left out" if hedge not in HEDGES else "only fuzzyctl reads it"
            yield Loss(f"rule {number}", f"hedge '{hedge}'", f"no FCL tool has it; {why}")
        if dialect == "fuzzylite" and any(isinstance(part, Not) for part in parts_of(rule.antecedent)):
            yield Loss(f"rule {number}", "not", "fuzzylite does not read NOT before a condition", exact=True)


_TITLES: Final[dict[DialectName, str]] = {
    "standard": "Fuzzy Control Language of IEC 61131-7",
    "jfuzzylogic": "Fuzzy Control Language with the extensions of jFuzzyLogic",
    "fuzzylite": "Fuzzy Control Language in the dialect of fuzzylite",
}

#: Versions of fuzzylite with numerics of their own, which a comment names.
_OLDER_FUZZYLITE: Final = ("fuzzylite_6",)

#: Words for norms: of each dialect those it has, and the first that any has.
_FUZZYLITE_NORMS: Final = {
    "drastic_product": "DPROD",
    "einstein_product": "EPROD",
    "hamacher_product": "HPROD",
    "nilpotent_minimum": "NMIN",
    "drastic_sum": "DSUM",
    "einstein_sum": "ESUM",
    "hamacher_sum": "HSUM",
    "nilpotent_maximum": "NMAX",
    "sum": "UnboundedSum",
}
_ONLY_FUZZYLITE: Final = frozenset({"einstein_product", "hamacher_sum"})

#: Words for defuzzifiers; what sums over rules is COGS whatever it takes of them.
_METHODS: Final = {
    "centroid": "COG",
    "bisector": "COA",
    "som": "LM",
    "lom": "RM",
    "mom": "MM",
    "weighted_average": "COGS",
    "center_average": "COGS",
    "tsukamoto": "COGS",
    "inverse_tsukamoto": "COGS",
    "weighted_sum": "COGSS",
    "tsukamoto_sum": "COGSS",
    "inverse_tsukamoto_sum": "COGSS",
}


def write(system: FuzzySystem) -> tuple[str, list[Loss]]:
    """Return a system as FCL, and what FCL cannot express of it.

    The dialect is the plainest one that has words for all of it, and its numerics are those of the tool that reads it:
    others are among what changes. No word holds inputs within their ranges: fuzzylite, which reads LOCK of outputs,
    refuses a file that says it of an input. Shoulders do where they can.

    Raises:
        DiagnosticError: With all reasons, for a system of Tsukamoto's method that fuzzylite would take for another one.
    """
    norms = {*CONJUNCTION_WORDS.values(), *ACCUMULATION_WORDS.values(), *_FUZZYLITE_NORMS}
    if reasons := [*numerics.formula_sets(system), *numerics.missing_words(system, SPELT, norms)]:
        raise numerics.cannot(system, ".fcl", reasons)
    named, losses = with_named_consequents(system, "c", fold=str.upper)
    named, averaged = with_numbers_averaged(named)
    named = with_shoulders(named, points=True)
    if dialect_for(named) == "fuzzylite":
        named, reasons = as_inverted_there(named)
        if reasons := [*reasons, *inferred_otherwise(named)]:
            raise numerics.cannot(system, ".fcl", reasons)
    named, renamed = with_names(named, spelt, str.upper)
    writer = _Writer(named)
    text = "\n".join(writer.lines()) + "\n"
    back, _ = read(SourceText("written.fcl", text))
    rules = [r for part in writer.parts for r, _ in part.rules]
    found = (*losses_of(named.model_copy(update={"title": ""}), back, rules), *without_words(named, writer.dialect))
    return text, sorted({*losses, *averaged, *renamed, *found})


def dialect_for(system: FuzzySystem) -> DialectName:
    """Return the plainest dialect that has words for a system; the one of its own numerics, where it says whose."""
    if system.method.semantics.profile in ("fuzzylite", "fuzzylite_6", "pyfuzzylite") or _needs_fuzzylite(system):
        return "fuzzylite"
    if system.method.semantics.profile == "jfuzzylogic" or any(map(needs_jfuzzylogic, _memberships(system))):
        return "jfuzzylogic"
    norms = _norms(system)
    usual = {"min", "max", "product", "probabilistic_sum", "bounded_difference", "bounded_sum"}
    return "standard" if norms <= usual else "jfuzzylogic"


def _needs_fuzzylite(system: FuzzySystem) -> bool:
    hedges = set().union(*numerics.used_hedges(system))
    if hedges - {"not"} or any(o.clamped for o in system.outputs):
        return True
    if any(isinstance(o.otherwise, Hold) and isinstance(o.otherwise.start, Expr) for o in system.outputs):
        return True
    if any((o.defuzzifier or system.method.defuzzifier).kind in TSUKAMOTO for o in system.outputs):
        return True
    norms = _norms(system) | set(_per_output(system, "aggregation"))
    if norms & _ONLY_FUZZYLITE:
        return True
    return any(needs_fuzzylite(m, system.values) for m in _memberships(system) if m.kind != "linear")


def _memberships(system: FuzzySystem) -> list[Membership]:
    return [t.membership for v in (*system.inputs, *system.outputs) for t in v.terms]


def _norms(system: FuzzySystem) -> set[str]:
    """Return what rule blocks say for AND, OR and ACT."""
    parts = block_parts(system)
    joins = {n for p in parts for n in (p.method.conjunction, p.method.disjunction)}
    usual = {system.method.conjunction, system.method.disjunction, *_per_output(system, "implication")}
    return joins | {p.implication for p in parts} if system.rule_blocks else usual


def _per_output(system: FuzzySystem, field: str) -> list[str]:
    return [getattr(o, field) or getattr(system.method, field) for o in system.outputs]


class _Writer:
    def __init__(self, system: FuzzySystem) -> None:
        self._system = system
        #: The rule blocks of the text: none of them has two implications.
        self.parts = block_parts(system)
        self.dialect = dialect_for(system)

    def lines(self) -> Iterator[str]:
        own = self._system.method.semantics.profile
        yield f"// {_TITLES[self.dialect]}"
        if self._system.title:
            yield f"// {' '.join(self._system.title.split())}"
        if self.dialect == "fuzzylite" and own in _OLDER_FUZZYLITE:
            yield f"// numerics of {own}"
        elif self.dialect == "standard":
            yield f"// numerics of {USUAL_NUMERICS['standard']}"
        yield f"FUNCTION_BLOCK {self._system.name}"
        yield ""
        yield from self._declarations("VAR_INPUT", self._system.inputs)
        yield from self._declarations("VAR_OUTPUT", self._system.outputs)
        for variable in self._system.inputs:
            yield from self._fuzzify(variable)
        for output in self._system.outputs:
            yield from self._defuzzify(output)
        others = Names(b.name for b in self._system.rule_blocks)
        for part in self.parts:
            own = self._system.rule_blocks[part.block].name if part.block >= 0 else "rules"
            yield from self._rule_block(part, own if part.block >= 0 and part.number == 1 else others.take(own))
        yield "END_FUNCTION_BLOCK"

    def _declarations(self, keyword: str, variables: tuple[Input, ...] | tuple[Output, ...]) -> Iterator[str]:
        yield keyword
        for variable in variables:
            # jFuzzyLogic takes the range of an input here, fuzzylite in FUZZIFY.
            here = isinstance(variable, Input) and self.dialect != "fuzzylite"
            yield f"  {variable.name} : REAL;{' ' + self._range(variable) if here else ''}"
        yield "END_VAR"
        yield ""

    def _range(self, variable: Input | Output) -> str:
        ends = (self._system.number(variable.lower), self._system.number(variable.upper))
        return f"RANGE := ({number_text(ends[0])} .. {number_text(ends[1])});"

    def _fuzzify(self, variable: Input) -> Iterator[str]:
        if not variable.terms and self.dialect != "fuzzylite":
            return
        yield f"FUZZIFY {variable.name}"
        if self.dialect == "fuzzylite":
            yield f"  {self._range(variable)}"
        yield from self._terms(variable)
        yield "END_FUZZIFY"
        yield ""

    def _terms(self, variable: Input | Output) -> Iterator[str]:
        for term in variable.terms:
            yield f"  TERM {term.name} := {self._shape(term.membership)};"

    def _shape(self, membership: Membership) -> str:
        values = self._system.values
        if membership.kind == "linear":
            return linear_text(membership, values, [i.name for i in self._system.inputs], self.dialect)
        params: dict[str, Expr] = {n: Number(v) for n, v in values.items()}
        arguments = tuple(replace_names(a, params) for a in membership.arguments)
        return shape_text(membership.model_copy(update={"arguments": arguments}), values, self.dialect)

    def _defuzzify(self, output: Output) -> Iterator[str]:
        yield f"DEFUZZIFY {output.name}"
        yield f"  {self._range(output)}"
        yield from self._terms(output)
        defuzzifier = output.defuzzifier or self._system.method.defuzzifier
        yield f"  METHOD : {_METHODS.get(defuzzifier.kind, 'COG')};"
        over_rules = self._accumulation(output) == _FUZZYLITE_NORMS["sum"] and defuzzifier.over_rules
        # fuzzylite joins nothing before an average where nothing is said.
        if not over_rules and (self.dialect == "fuzzylite" or self._accumulations_differ()):
            yield f"  ACCU : {self._accumulation(output)};"
        if output.clamped and self.dialect == "fuzzylite":
            # Before DEFAULT: fuzzylite takes from LOCK whether the previous value is held, too.
            yield "  LOCK : RANGE;"
        default = self._default(output)
        if default:
            yield f"  DEFAULT := {default};"
        yield "END_DEFUZZIFY"
        yield ""

    def _accumulation(self, output: Output) -> str:
        aggregation = output.aggregation or self._system.method.aggregation
        defuzzifier = output.defuzzifier or self._system.method.defuzzifier
        if defuzzifier.over_rules and self._system.method.semantics.merge == "rules":
            aggregation = "sum"  # each rule counts for itself
        return self._norm(aggregation, ACCUMULATION_WORDS)

    def _accumulations_differ(self) -> bool:
        return len({self._accumulation(o) for o in self._system.outputs}) > 1

    def _norm(self, norm: str, words: dict[str, str]) -> str:
        if self.dialect == "fuzzylite" and norm in _FUZZYLITE_NORMS:
            return _FUZZYLITE_NORMS[norm]
        if norm == "probabilistic_sum" and words is ACCUMULATION_WORDS and self.dialect != "fuzzylite":
            return "PROBOR"
        if norm == "hamacher_product":
            return "HAMACHER"
        if norm == "einstein_sum":
            return "EINSTEIN" if words is not ACCUMULATION_WORDS else "ESUM"
        return next((word for word, name in words.items() if name == norm), next(iter(words)))

    def _default(self, output: Output) -> str:
        """Return what stands behind DEFAULT, nothing where it says what the numerics say anyway."""
        start = numerics.value_unfired(self._system, output)
        text = "nan" if start is None else number_text(start)
        if isinstance(output.otherwise, Hold):
            return f"{text} | NC" if self.dialect == "fuzzylite" else "NC"
        return text if start is not None or self.dialect == "fuzzylite" else ""

    def _rule_block(self, part: BlockPart, name: str) -> Iterator[str]:
        yield f"RULEBLOCK {name}"
        yield from self._connectives(part)
        yield f"  ACT : {self._norm(part.implication, CONJUNCTION_WORDS)};"
        if self.dialect != "fuzzylite" and self._system.outputs and not self._accumulations_differ():
            yield f"  ACCU : {self._accumulation(self._system.outputs[0])};"
        for position, rule in part.rules:
            # fuzzylite wants the words of rules in small letters, and takes a semicolon for a part of the term.
            end = "" if self.dialect == "fuzzylite" else ";"
            yield f"  RULE {position + 1} : {self._rule(rule)}{end}"
        yield "END_RULEBLOCK"
        yield ""

    def _connectives(self, part: BlockPart) -> Iterator[str]:
        """Yield AND and OR, the one that rules use last: of two that are no pair jFuzzyLogic takes the last."""
        lines = [
            f"  OR : {self._norm(part.method.disjunction, DISJUNCTION_WORDS)};",
            f"  AND : {self._norm(part.method.conjunction, CONJUNCTION_WORDS)};",
        ]
        uses_and = any(is_joined_by(And, rule.antecedent) for _, rule in part.rules)
        yield from lines if uses_and else reversed(lines)

    def _word(self, word: str) -> str:
        return word.lower() if self.dialect == "fuzzylite" else word

    def _rule(self, rule: Rule) -> str:
        joint = " and " if self.dialect == "fuzzylite" else ", "
        conclusions = joint.join(self._conclusion(rule, i) for i in range(len(rule.consequents)))
        weight = self._system.number(rule.weight)
        tail = f" {self._word('WITH')} {number_text(weight)}" if weight != 1.0 else ""
        condition = self._antecedent(rule.antecedent, top=True)
        return f"{self._word('IF')} {condition} {self._word('THEN')} {conclusions}{tail}"

    def _conclusion(self, rule: Rule, index: int) -> str:
        c = rule.consequents[index]
        return self._clause(c.output, c.hedges, (str(c.term),))

    def _clause(self, variable: str, hedges: tuple[str, ...], term: tuple[str, ...]) -> str:
        words = [self._word("NOT") if h == "not" else h for h in hedges if h in HEDGES]
        return f"{variable} {self._word('IS')} {' '.join([*words, *term])}"

    def _antecedent(self, antecedent: Antecedent, *, top: bool = False) -> str:
        match antecedent:
            case Is(variable=variable, term=term, hedges=hedges):
                return self._clause(variable, *up_to_any(hedges, term))
            case Not(operand=operand):
                return f"{self._word('NOT')} ({self._antecedent(operand, top=True)})"
            case And(operands=operands) | Or(operands=operands):
                word = self._word("AND" if isinstance(antecedent, And) else "OR")
                text = f" {word} ".join(self._antecedent(o) for o in operands)
                return text if top else f"({text})"
        raise TypeError(type(antecedent).__name__)
