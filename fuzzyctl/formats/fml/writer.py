"""Writer of FML of IEEE 1855."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final
from xml.sax.saxutils import escape, quoteattr

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import ONE, Expr, number_text
from fuzzyctl.formats.common import losses as numerics
from fuzzyctl.formats.common.identifiers import name_before, with_names
from fuzzyctl.formats.common.losses import losses_of, with_named_consequents, with_numbers_averaged
from fuzzyctl.formats.common.report import Names
from fuzzyctl.formats.fml.hedges import own_modifier
from fuzzyctl.formats.fml.reader import read
from fuzzyctl.formats.fml.vocabulary import (
    CONJUNCTION_WORDS,
    DEFUZZIFIER_WORDS,
    DISJUNCTION_WORDS,
    MODIFIERS,
    NORMS,
    word_for,
)
from fuzzyctl.formats.fml.written_shapes import WrittenShape, written_consequent, written_shape
from fuzzyctl.formats.registry import Loss
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.model.method import OVER_RULES, TSUKAMOTO, RuleMethod
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Membership, Output


@dataclass(frozen=True)
class RuleBase:
    """A rule base as it is written.

    Args:
        name: Its name.
        kind: `mamdani`, `tsk` or `tsukamoto`.
        implication: Its activation method.
        method: How its rules join.
        rules: Its rules with their numbers in the system, each with the consequents that belong here.
    """

    name: str
    kind: str
    implication: str
    method: RuleMethod
    rules: tuple[tuple[int, Rule], ...]


class WrittenRules:
    """The rules of a system as FML has them.

    Args:
        system: The system.

    Attributes:
        losses: What of them FML cannot express.
        variable: Name of the variable whose terms are nested conditions.
    """

    def __init__(self, system: FuzzySystem) -> None:
        self._system = system
        self.losses: list[Loss] = []
        taken = {v.name for v in (*system.inputs, *system.outputs)}
        self.variable = "conditions"
        while self.variable in taken:
            self.variable += "_"
        self._defined: dict[str, list[str]] = {}
        self._composed: dict[tuple[str, str, tuple[str, ...]], str] = {}

    def kind(self, output: Output) -> str:
        """Return what sort of rules conclude on an output: `mamdani`, `tsk` or `tsukamoto`."""
        defuzzifier = output.defuzzifier or self._system.method.defuzzifier
        if defuzzifier.kind == "tsukamoto":
            return "tsukamoto"
        return "tsk" if defuzzifier.kind in OVER_RULES else "mamdani"

    def groups(self) -> Iterator[RuleBase]:
        """Yield the rule bases: of the rules of one block, or of none, one sort and one activation method."""
        found: dict[tuple[int, str, str], list[tuple[int, Rule]]] = {}
        for index, (rule, method) in enumerate(zip(self._system.rules, self._system.rule_methods, strict=True)):
            parts: dict[tuple[int, str, str], list[object]] = {}
            for c in rule.consequents:
                output = self._system.output(c.output)
                kind = self.kind(output)
                implication = self._system.implication_of(index, output) if kind == "mamdani" else "min"
                parts.setdefault((method.block, kind, implication), []).append(c)
            for key, consequents in parts.items():
                part = rule.model_copy(update={"consequents": tuple(consequents)})
                found.setdefault(key, []).append((index + 1, part))
        names = Names(b.name for b in self._system.rule_blocks)
        named: set[int] = set()
        for number, ((block, kind, implication), rules) in enumerate(found.items(), 1):
            own = f"rules{number}" if block < 0 else self._system.rule_blocks[block].name
            first = block >= 0 and block not in named
            named.add(block)
            method = self._system.rule_methods[rules[0][0] - 1]
            yield RuleBase(own if first else names.take(own), kind, implication, method, tuple(rules))

    def condition(self, index: int, rule: Rule) -> tuple[str, list[str]]:
        """Return the connector of a rule and its clauses; what is joined in itself is a term of its own."""
        self._method = self._system.rule_methods[index - 1]
        clauses = [self._part(p, f"rule{index}_{k}") for k, p in enumerate(_parts(rule.antecedent), 1)]
        return ("or" if isinstance(rule.antecedent, Or) else "and"), clauses

    def _part(self, antecedent: Antecedent, name: str) -> str:
        """Return a condition as a clause; one of several is a term of that name, negated by a modifier."""
        inner, negated = _stripped(antecedent)
        if not isinstance(inner, And | Or):
            return self._literal(antecedent)
        self._defined[name] = list(self._tree(inner, name))
        return self._clause(self.variable, name, "not" if negated else "")

    def definitions(self) -> Iterator[str]:
        """Yield the variable whose terms are the conditions that rules needed until now, where there are such."""
        if not self._defined:
            return
        yield f'<aggregatedFuzzyVariable name={quoteattr(self.variable)} type="input">'
        for name, lines in self._defined.items():
            yield f'  <aggregatedFuzzyTerm name="{name}">'
            yield from (f"    {line}" for line in lines)
            yield "  </aggregatedFuzzyTerm>"
        yield "</aggregatedFuzzyVariable>"

    def _tree(self, antecedent: And | Or, name: str) -> Iterator[str]:
        """Yield a condition as a tree of pairs, since the schema joins two at a time."""
        tag = "and" if isinstance(antecedent, And) else "or"
        method = self._method
        words, attribute = NORMS[tag]
        norm = method.conjunction if tag == "and" else method.disjunction
        word = word_for(words, norm, next(iter(words)))
        *before, last = antecedent.operands
        yield f'<{tag} {attribute}="{word}">'
        first = before[0] if len(before) == 1 else antecedent.model_copy(update={"operands": tuple(before)})
        for k, part in enumerate((first, last), 1):
            inner, negated = _stripped(part)
            if isinstance(inner, And | Or) and not negated:
                yield from (f"  {line}" for line in self._tree(inner, f"{name}_{k}"))
            else:
                yield f"  {self._part(part, f'{name}_{k}')}"
        yield f"</{tag}>"

    def _literal(self, antecedent: Antecedent) -> str:
        hedges: tuple[str, ...] = ()
        while isinstance(antecedent, Not):
            hedges = ("not",) if not hedges else ()
            antecedent = antecedent.operand
        assert isinstance(antecedent, Is)
        hedges = (*hedges, *antecedent.hedges)
        while hedges[:2] == ("not", "not"):
            hedges = hedges[2:]
        modifiers = tuple(m for m in map(self._modifier, hedges) if m)
        return self._modified(antecedent.variable, antecedent.term, modifiers)

    def _modified(self, variable: str, term: str, modifiers: tuple[str, ...]) -> str:
        """Return a clause; as it has one modifier, the others are those of a term that it names.

        That term is the condition joined with itself by MIN, since a term is defined by a pair.
        """
        if len(modifiers) > 1:
            key = (variable, term, modifiers[1:])
            if key not in self._composed:
                clause = self._modified(*key)
                self._composed[key] = name = f"modified{len(self._composed) + 1}"
                self._defined[name] = ['<and t-norm="MIN">', f"  {clause}", f"  {clause}", "</and>"]
            variable, term = self.variable, self._composed[key]
        return self._clause(variable, term, modifiers[0] if modifiers else "")

    def conclusion(self, variable: str, term: str, hedges: tuple[str, ...], tag: str) -> str:
        """Return the clause of a conclusion, which has one modifier and cannot name terms that others define."""
        if len(hedges) > 1:
            # A conclusion that is negated says the opposite of one that is not: of all hedges this one is kept.
            kept = hedges[:1] if hedges[0] == "not" else ()
            why = f"FML has one modifier for a conclusion; {'only not is kept' if kept else 'they are left out'}"
            self.losses.append(Loss("rules", f"hedges '{' '.join(hedges)}'", why))
            hedges = kept
        return self._clause(variable, term, self._modifier(hedges[0]) if hedges else "", tag)

    def _clause(self, variable: str, term: str, modifier: str, tag: str = "clause") -> str:
        said = f' modifier="{modifier}"' if modifier else ""
        named = f"<variable>{escape(variable)}</variable><term>{escape(term)}</term>"
        return f"<{tag}{said}>{named}</{tag}>"

    def _modifier(self, hedge: str) -> str:
        if hedge == "extremely":
            return "extremely" if self._system.method.semantics.extremely == "cube" else "intensify"
        own = next((h for h in self._system.hedges if h.name == hedge), None)
        word = own_modifier(own) if own is not None else word_for(MODIFIERS, hedge) or None
        if word is None:
            self.losses.append(Loss("rules", f"hedge '{hedge}'", "FML has no such modifier; it is left out"))
        return word or ""


def _parts(antecedent: Antecedent) -> tuple[Antecedent, ...]:
    """Return what the connector of a rule joins."""
    return antecedent.operands if isinstance(antecedent, And | Or) else (antecedent,)


def _stripped(antecedent: Antecedent) -> tuple[Antecedent, bool]:
    """Return a condition without the negations before it, and whether they negate it."""
    negated = False
    while isinstance(antecedent, Not):
        antecedent, negated = antecedent.operand, not negated
    return antecedent, negated


_RULE_BASES: Final = {"mamdani": "mamdaniRuleBase", "tsk": "tskRuleBase", "tsukamoto": "tsukamotoRuleBase"}


def write(system: FuzzySystem) -> tuple[str, list[Loss]]:
    """Return a system as FML, and what FML cannot express of it.

    Raises:
        DiagnosticError: With all reasons, for a system that no `.fml` file can hold.
    """
    if reasons := (*_impossible(system), *numerics.formula_sets(system)):
        raise numerics.cannot(system, ".fml", reasons)
    named, losses = with_named_consequents(system, "c")
    named, averaged = with_numbers_averaged(_with_names_before(named))
    writer = _Writer(named)
    text = "\n".join(writer.lines()) + "\n"
    back, _ = read(SourceText("written.fml", text))
    found = losses_of(named, back, writer.order)
    return text, sorted({*losses, *averaged, *writer.losses, *writer.rules.losses, *found})


def _with_names_before(system: FuzzySystem) -> FuzzySystem:
    """Return a system whose variables are called as in the file that it was read from."""
    before = {v.name: name_before(v.name, v.label) for v in (*system.inputs, *system.outputs)}

    def spelt(name: str, where: str) -> str:
        if where == "variable":
            return before[name]
        return name_before(name, system.title) if where.startswith("system ") else name

    return with_names(system, spelt)[0]


class _Writer:
    def __init__(self, system: FuzzySystem) -> None:
        self._system = system
        self.losses: list[Loss] = []
        self.rules = WrittenRules(system)
        #: Positions of the rules in the order of the text.
        self.order: list[int] = []

    def lines(self) -> Iterator[str]:
        yield '<?xml version="1.0" encoding="UTF-8"?>'
        yield f'<fuzzySystem xmlns="http://www.ieee1855.org" name={_quoted(self._system.name)}>'
        yield "  <knowledgeBase>"
        for variable in self._system.inputs:
            yield from self._sets(variable, "fuzzyVariable", "fuzzyTerm", 'type="input"')
        for output in self._system.outputs:
            yield from self._output(output)
        rule_bases = list(self._rule_bases())  # which say what conditions are to be defined
        yield from (f"    {line}" for line in self.rules.definitions())
        yield "  </knowledgeBase>"
        yield from rule_bases
        yield "</fuzzySystem>"

    def _domain(self, variable: Input | Output) -> tuple[float, float]:
        return self._system.number(variable.lower), self._system.number(variable.upper)

    def _head(self, variable: Input | Output, tag: str, more: str, *, domain: bool = True) -> str:
        low, high = self._domain(variable)
        ends = f' domainleft="{number_text(low)}" domainright="{number_text(high)}"' if domain else ""
        return f"    <{tag} name={_quoted(variable.name)}{ends} scale={_quoted(variable.unit)} {more}>"

    def _sets(self, variable: Input | Output, tag: str, term_tag: str, more: str) -> Iterator[str]:
        yield self._head(variable, tag, more)
        where = f"{'input' if isinstance(variable, Input) else 'output'} '{variable.name}'"
        for term in variable.terms:
            shape = self._shape(variable, term.membership)
            if shape.said:
                self.losses.append(Loss(where, f"term '{term.name}'", shape.said, exact=shape.exact))
            yield f'      <{term_tag} name={_quoted(term.name)} complement="false">'
            yield from (f"        {line}" for line in _shape_lines(shape))
            yield f"      </{term_tag}>"
        yield f"    </{tag}>"

    def _shape(self, variable: Input | Output, membership: Membership) -> WrittenShape:
        if isinstance(variable, Output) and self.rules.kind(variable) == "tsukamoto":
            return written_consequent(membership, self._system.values, self._domain(variable))
        if membership.kind in MEMBERSHIP:
            return written_shape(membership, self._system.values, self._domain(variable))
        said = "FML has no function as a term; a single number stands for it"
        return WrittenShape("singletonShape", (self._domain(variable)[0],), said, exact=False)

    def _output(self, output: Output) -> Iterator[str]:
        default = f'defaultValue="{number_text(self._default(output))}"'
        kind = self.rules.kind(output)
        if kind == "tsk":
            yield from self._tsk(output, default)
            return
        if kind == "tsukamoto":
            more = f'type="output" combination="WA" {default}'
            yield from self._sets(output, "tsukamotoVariable", "tsukamotoTerm", more)
            return
        defuzzifier = output.defuzzifier or self._system.method.defuzzifier
        aggregation = output.aggregation or self._system.method.aggregation
        word = word_for(DISJUNCTION_WORDS, aggregation, "MAX")
        method = word_for(DEFUZZIFIER_WORDS, defuzzifier.kind, "COG")
        more = f'type="output" accumulation="{word}" defuzzifier="{method}" {default}'
        yield from self._sets(output, "fuzzyVariable", "fuzzyTerm", more)

    def _tsk(self, output: Output, default: str) -> Iterator[str]:
        # The range is no attribute of the standard, but no reader minds it, and no other place says it.
        more = f'type="output" combination="WA" {default}'
        yield self._head(output, "tskVariable", more)
        for term in output.terms:
            order, coefficients = self._coefficients(output, term.name, term.membership)
            yield f'      <tskTerm name={_quoted(term.name)} order="{order}">'
            yield from (f"        <tskValue>{number_text(c)}</tskValue>" for c in coefficients)
            yield "      </tskTerm>"
        yield "    </tskVariable>"

    def _coefficients(self, output: Output, name: str, membership: Membership) -> tuple[int, list[float]]:
        where = f"output '{output.name}'"
        if membership.kind == "linear":
            *factors, constant = (self._system.number(a) for a in membership.arguments)
            return 1, [constant, *factors]
        if membership.kind == "function":
            self.losses.append(Loss(where, f"term '{name}'", "FML has linear functions only; 0 stands for it"))
            return 0, [0.0]
        return 0, [self._system.number(membership.arguments[0])]

    def _default(self, output: Output) -> float:
        if isinstance(output.otherwise, Expr):
            return self._system.number(output.otherwise)
        return sum(self._domain(output)) / 2

    def _rule_bases(self) -> Iterator[str]:
        for base in self.rules.groups():
            tag = _RULE_BASES[base.kind]
            act = word_for(CONJUNCTION_WORDS, base.implication, "MIN")
            conjunction = word_for(CONJUNCTION_WORDS, base.method.conjunction, "MIN")
            disjunction = word_for(DISJUNCTION_WORDS, base.method.disjunction, "MAX")
            norms = f'activationMethod="{act}" andMethod="{conjunction}" orMethod="{disjunction}"'
            yield f"  <{tag} name={_quoted(base.name)} {norms}>"
            for index, rule in base.rules:
                self.order.append(index - 1)
                yield from self._rule(index, rule, tsk=base.kind == "tsk")
            yield f"  </{tag}>"

    def _rule(self, index: int, rule: Rule, *, tsk: bool) -> Iterator[str]:
        connector, clauses = self.rules.condition(index, rule)
        tag, prefix = ("tskRule", "tsk") if tsk else ("rule", "")
        consequent, then, clause_tag = (
            ("tskConsequent", "tskThen", "tskClause") if tsk else ("consequent", "then", "clause")
        )
        weight = number_text(self._system.number(rule.weight)) if rule.weight != ONE else "1"
        yield f'    <{tag} name="rule{index}{prefix}" connector="{connector}" weight="{weight}">'
        yield "      <antecedent>"
        yield from (f"        {c}" for c in clauses)
        yield "      </antecedent>"
        yield f"      <{consequent}><{then}>"
        for c in rule.consequents:
            yield f"        {self.rules.conclusion(c.output, str(c.term), c.hedges, clause_tag)}"
        yield f"      </{then}></{consequent}>"
        yield f"    </{tag}>"


def _impossible(system: FuzzySystem) -> Iterator[str]:
    """Yield why no file can hold a system, not even with losses."""
    for variable in system.inputs:
        if not variable.terms:
            yield f"input '{variable.name}' has no terms, and every fuzzyVariable has some"
    kinds = {o.name: numerics.defuzzifier_of(system, o).kind for o in system.outputs}
    for name, kind in kinds.items():
        if kind in TSUKAMOTO and kind != "tsukamoto":
            yield f"output '{name}': there is no defuzzifier '{kind}'"
    for number, rule in enumerate(system.rules, 1):
        for c in rule.consequents:
            if c.hedges and kinds[c.output] in OVER_RULES:
                yield f"rule {number}: a consequent of an average, '{c.output}', has no modifiers"


def _shape_lines(shape: WrittenShape) -> Iterator[str]:
    if shape.tag.startswith("pointSet"):
        yield f'<{shape.tag} interpolationMethod="linear">'
        for x, y in zip(shape.parameters[::2], shape.parameters[1::2], strict=True):
            yield f'  <point x="{number_text(x)}" y="{number_text(y)}"/>'
        yield f"</{shape.tag}>"
        return
    given = " ".join(f'param{i}="{number_text(v)}"' for i, v in enumerate(shape.parameters, 1))
    yield f"<{shape.tag} {given}/>"


def _quoted(text: str) -> str:
    """Return a text as an attribute; line ends would be read as blanks."""
    return quoteattr(text, {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"})
