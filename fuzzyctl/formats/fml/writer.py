"""Writer of FML of IEEE 1855."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final
from xml.sax.saxutils import quoteattr

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import ONE, Expr, number_text
from fuzzyctl.formats.common import numerics
from fuzzyctl.formats.common.consequents import with_named_consequents, with_numbers_averaged
from fuzzyctl.formats.common.identifiers import name_before, with_names
from fuzzyctl.formats.common.read_back import losses_of
from fuzzyctl.formats.fml.reader import read
from fuzzyctl.formats.fml.vocabulary import CONJUNCTION_WORDS, DEFUZZIFIER_WORDS, DISJUNCTION_WORDS, word_for
from fuzzyctl.formats.fml.written_rules import WrittenRules
from fuzzyctl.formats.fml.written_shapes import WrittenShape, written_consequent, written_shape
from fuzzyctl.formats.losses import Loss
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.model.method import OVER_RULES, TSUKAMOTO
from fuzzyctl.model.rule import Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Membership, Output

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
