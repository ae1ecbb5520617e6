"""Writer of FML of IEEE 1855."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final
from xml.sax.saxutils import escape, quoteattr

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import Expr, number_text
from fuzzyctl.formats.common import losses as numerics
from fuzzyctl.formats.common.identifiers import name_before, with_names
from fuzzyctl.formats.common.losses import losses_of, with_named_consequents, with_numbers_averaged
from fuzzyctl.formats.common.report import Names
from fuzzyctl.formats.fml.reader import read
from fuzzyctl.formats.fml.shapes import WrittenShape, written_shape
from fuzzyctl.formats.fml.vocabulary import (
    CONJUNCTION_WORDS,
    DEFUZZIFIER_WORDS,
    DISJUNCTION_WORDS,
    NORMS,
    modifier_of,
    word_for,
)
from fuzzyctl.formats.registry import Loss
from fuzzyctl.model.method import OVER_RULES, TSUKAMOTO, RuleMethod
from fuzzyctl.model.rule import And, Antecedent, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Output

#: Prefixes of element names by kind of the rules: `mamdaniRuleBase`, `tskVariable`.
_VARIABLES: Final = {"mamdani": "fuzzy", "tsk": "tsk", "tsukamoto": "tsukamoto"}


def write(system: FuzzySystem) -> tuple[str, list[Loss]]:
    """Return a system as FML, with all losses.

    Raises:
        DiagnosticError: With all reasons, if no `.fml` file can hold the system.
    """
    if reasons := (*_impossible(system), *numerics.formula_sets(system)):
        raise numerics.cannot(system, ".fml", reasons)
    named, losses = with_named_consequents(system, "c")
    named, averaged = with_numbers_averaged(_with_names_before(named))
    writer = _Writer(named)
    text = "\n".join(writer.lines()) + "\n"
    back, _ = read(SourceText("written.fml", text))
    numeric = losses_of(named, back, writer.order)
    return text, sorted({*losses, *averaged, *writer.losses, *numeric})


def _impossible(system: FuzzySystem) -> Iterator[str]:
    """Yield the reasons why no file can hold a system, not even with losses."""
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


def _with_names_before(system: FuzzySystem) -> FuzzySystem:
    """Return a system with the names of variables in the file that it was read from."""
    before = {v.name: name_before(v.name, v.label) for v in (*system.inputs, *system.outputs)}

    def spelling(name: str, where: str) -> str:
        if where == "variable":
            return before[name]
        return name_before(name, system.title) if where.startswith("system ") else name

    return with_names(system, spelling)[0]


class _Writer:
    """Writes a system.

    Args:
        system: The system.

    Attributes:
        losses: Parts that FML cannot express.
        order: Positions of the rules in the order of the text.
    """

    def __init__(self, system: FuzzySystem) -> None:
        self._system = system
        self.losses: list[Loss] = []
        self._conditions = _Conditions(system, self.losses)
        self.order: list[int] = []

    def lines(self) -> Iterator[str]:
        """Yield the lines of the file."""
        yield '<?xml version="1.0" encoding="UTF-8"?>'
        yield f'<fuzzySystem xmlns="http://www.ieee1855.org" name={_quoted(self._system.name)}>'
        yield "  <knowledgeBase>"
        for variable in self._system.inputs:
            yield from self._sets(variable, "fuzzy", 'type="input"')
        for output in self._system.outputs:
            yield from self._output(output)
        rule_bases = list(self._rule_bases())  # these collect the definitions
        yield from (f"    {line}" for line in self._conditions.definitions())
        yield "  </knowledgeBase>"
        yield from rule_bases
        yield "</fuzzySystem>"

    # --- variables -----------------------------------------------------------------------------------------------

    def _kind(self, output: Output) -> str:
        """Return the kind of rules that conclude on an output: `mamdani`, `tsk` or `tsukamoto`."""
        kind = numerics.defuzzifier_of(self._system, output).kind
        return "tsukamoto" if kind == "tsukamoto" else "tsk" if kind in OVER_RULES else "mamdani"

    def _head(self, variable: Input | Output, tag: str, more: str) -> str:
        low, high = (number_text(self._system.number(end)) for end in (variable.lower, variable.upper))
        ends = f'domainleft="{low}" domainright="{high}" scale={_quoted(variable.unit)}'
        return f"    <{tag}Variable name={_quoted(variable.name)} {ends} {more}>"

    def _sets(self, variable: Input | Output, tag: str, more: str) -> Iterator[str]:
        yield self._head(variable, tag, more)
        where = f"{'input' if isinstance(variable, Input) else 'output'} '{variable.name}'"
        for term in variable.terms:
            shape = written_shape(self._system, variable, term, monotone=tag == "tsukamoto")
            if shape.note:
                self.losses.append(Loss(where, f"term '{term.name}'", shape.note, exact=shape.exact))
            yield f'      <{tag}Term name={_quoted(term.name)} complement="false">'
            yield from (f"        {line}" for line in _shape_lines(shape))
            yield f"      </{tag}Term>"
        yield f"    </{tag}Variable>"

    def _output(self, output: Output) -> Iterator[str]:
        system, kind = self._system, self._kind(output)
        otherwise = output.otherwise
        default = system.number(otherwise) if isinstance(otherwise, Expr) else numerics.middle_of(system, output)
        methods = 'combination="WA"'
        if kind == "mamdani":
            accumulation = word_for(DISJUNCTION_WORDS, output.aggregation or system.method.aggregation)
            defuzzifier = word_for(DEFUZZIFIER_WORDS, numerics.defuzzifier_of(system, output).kind)
            methods = f'accumulation="{accumulation}" defuzzifier="{defuzzifier}"'
        more = f'type="output" {methods} defaultValue="{number_text(default)}"'
        yield from self._functions(output, more) if kind == "tsk" else self._sets(output, _VARIABLES[kind], more)

    def _functions(self, output: Output, more: str) -> Iterator[str]:
        # The range is not an attribute of the standard, but readers ignore it, and no other place has it.
        yield self._head(output, "tsk", more)
        for term in output.terms:
            order, coefficients = "0", [0.0]
            if term.membership.kind == "function":
                why = "FML has linear functions only; 0 stands for it"
                self.losses.append(Loss(f"output '{output.name}'", f"term '{term.name}'", why))
            else:
                *factors, constant = (self._system.number(a) for a in term.membership.arguments)
                order, coefficients = "1" if term.membership.kind == "linear" else "0", [constant, *factors]
            yield f'      <tskTerm name={_quoted(term.name)} order="{order}">'
            yield from (f"        <tskValue>{number_text(c)}</tskValue>" for c in coefficients)
            yield "      </tskTerm>"
        yield "    </tskVariable>"

    # --- rules ---------------------------------------------------------------------------------------------------

    def _rule_bases(self) -> Iterator[str]:
        """Yield the rule bases: for each block, or outside of blocks, one for each kind and activation method."""
        system = self._system
        bases: dict[tuple[int, str, str], list[tuple[int, Rule]]] = {}
        for index, (rule, method) in enumerate(zip(system.rules, system.rule_methods, strict=True)):
            parts: dict[tuple[int, str, str], list[Consequent]] = {}
            for c in rule.consequents:
                output = system.output(c.output)
                kind = self._kind(output)
                implication = system.implication_of(index, output) if kind == "mamdani" else "min"
                parts.setdefault((method.block, kind, implication), []).append(c)
            for key, consequents in parts.items():
                bases.setdefault(key, []).append((index, rule.model_copy(update={"consequents": tuple(consequents)})))
        names, named = Names(b.name for b in system.rule_blocks), {-1}
        for number, ((block, kind, implication), rules) in enumerate(bases.items(), 1):
            name = system.rule_blocks[block].name if block >= 0 else f"rules{number}"
            name = names.take(name) if block in named else name
            named.add(block)
            method = system.rule_methods[rules[0][0]]
            activation = word_for(CONJUNCTION_WORDS, implication)
            conjunction = word_for(CONJUNCTION_WORDS, method.conjunction)
            disjunction = word_for(DISJUNCTION_WORDS, method.disjunction)
            norms = f'activationMethod="{activation}" andMethod="{conjunction}" orMethod="{disjunction}"'
            yield f"  <{kind}RuleBase name={_quoted(name)} {norms}>"
            for index, rule in rules:
                self.order.append(index)
                yield from self._rule(index, rule, method, is_tsk=kind == "tsk")
            yield f"  </{kind}RuleBase>"

    def _rule(self, index: int, rule: Rule, method: RuleMethod, *, is_tsk: bool) -> Iterator[str]:
        tags = ("rule", "consequent", "then", "clause")
        tag, consequent, then, clause = (f"tsk{t.capitalize()}" for t in tags) if is_tsk else tags
        name = f"rule{index + 1}{'tsk' if is_tsk else ''}"
        connector = "or" if isinstance(rule.antecedent, Or) else "and"
        weight = number_text(self._system.number(rule.weight))
        yield f'    <{tag} name="{name}" connector="{connector}" weight="{weight}">'
        yield "      <antecedent>"
        parts = rule.antecedent.operands if isinstance(rule.antecedent, And | Or) else (rule.antecedent,)
        for k, part in enumerate(parts, 1):
            yield f"        {self._conditions.clause(part, f'rule{index + 1}_{k}', method)}"
        yield "      </antecedent>"
        yield f"      <{consequent}><{then}>"
        for c in rule.consequents:
            yield f"        {self._conditions.conclusion(c, clause)}"
        yield f"      </{then}></{consequent}>"
        yield f"    </{tag}>"


class _Conditions:
    """Writes clauses; terms of a further variable express conditions within conditions, and several hedges.

    Args:
        system: The system.
        losses: Takes the losses.
    """

    def __init__(self, system: FuzzySystem, losses: list[Loss]) -> None:
        self._system, self._losses = system, losses
        names = {v.name for v in (*system.inputs, *system.outputs)}
        self._variable = "conditions"
        while self._variable in names:
            self._variable += "_"
        self._definitions: dict[str, list[str]] = {}
        self._modified: dict[tuple[str, str, tuple[str, ...]], str] = {}

    def clause(self, antecedent: Antecedent, name: str, method: RuleMethod) -> str:
        """Return a condition as a clause; a joined one becomes a term with a name."""
        inner, is_negated = antecedent, False
        while isinstance(inner, Not):
            inner, is_negated = inner.operand, not is_negated
        if isinstance(inner, And | Or):
            self._definitions[name] = list(self._joined(inner, name, method))
            return _clause(self._variable, name, "not" if is_negated else "")
        assert isinstance(inner, Is)
        hedges = ("not", *inner.hedges) if is_negated else inner.hedges
        while hedges[:2] == ("not", "not"):
            hedges = hedges[2:]
        modifiers = tuple(m for m in map(self._modifier, hedges) if m)
        return self._with_modifiers(inner.variable, inner.term, modifiers)

    def _joined(self, antecedent: And | Or, name: str, method: RuleMethod) -> Iterator[str]:
        """Yield a condition as a tree of pairs, since the schema joins two at a time."""
        tag = "and" if isinstance(antecedent, And) else "or"
        words, _, attribute = NORMS[tag]
        *before, last = antecedent.operands
        yield f'<{tag} {attribute}="{word_for(words, method.conjunction if tag == "and" else method.disjunction)}">'
        first = before[0] if len(before) == 1 else antecedent.model_copy(update={"operands": tuple(before)})
        for k, part in enumerate((first, last), 1):
            inner = part
            while isinstance(inner, Not) and isinstance(inner.operand, Not):
                inner = inner.operand.operand
            if isinstance(inner, And | Or):
                yield from (f"  {line}" for line in self._joined(inner, f"{name}_{k}", method))
            else:
                yield f"  {self.clause(part, f'{name}_{k}', method)}"
        yield f"</{tag}>"

    def _with_modifiers(self, variable: str, term: str, modifiers: tuple[str, ...]) -> str:
        """Return a clause with one modifier; a term that it names has the others.

        That term is the condition joined with itself by MIN, since a term is defined by a pair.
        """
        if len(modifiers) > 1:
            key = (variable, term, modifiers[1:])
            if key not in self._modified:
                clause = self._with_modifiers(*key)
                self._modified[key] = name = f"modified{len(self._modified) + 1}"
                self._definitions[name] = ['<and t-norm="MIN">', f"  {clause}", f"  {clause}", "</and>"]
            variable, term = self._variable, self._modified[key]
        return _clause(variable, term, modifiers[0] if modifiers else "")

    def conclusion(self, consequent: Consequent, tag: str) -> str:
        """Return a conclusion as a clause, which has one modifier and cannot name defined terms."""
        hedges = consequent.hedges
        if len(hedges) > 1:
            # Without its `not` a conclusion would say the opposite: of all hedges this one remains.
            remaining = hedges[:1] if hedges[0] == "not" else ()
            why = f"FML has one modifier for a conclusion; {'only not is kept' if remaining else 'they are left out'}"
            self._losses.append(Loss("rules", f"hedges '{' '.join(hedges)}'", why))
            hedges = remaining
        return _clause(consequent.output, str(consequent.term), self._modifier(hedges[0]) if hedges else "", tag)

    def definitions(self) -> Iterator[str]:
        """Yield the variable of the defined terms, if there are any."""
        if not self._definitions:
            return
        yield f'<aggregatedFuzzyVariable name={quoteattr(self._variable)} type="input">'
        for name, lines in self._definitions.items():
            yield f'  <aggregatedFuzzyTerm name="{name}">'
            yield from (f"    {line}" for line in lines)
            yield "  </aggregatedFuzzyTerm>"
        yield "</aggregatedFuzzyVariable>"

    def _modifier(self, hedge: str) -> str:
        if hedge == "extremely":
            return "extremely" if self._system.method.semantics.extremely == "cube" else "intensify"
        word = modifier_of(hedge, next((h for h in self._system.hedges if h.name == hedge), None))
        if not word:
            self._losses.append(Loss("rules", f"hedge '{hedge}'", "FML has no such modifier; it is left out"))
        return word


def _clause(variable: str, term: str, modifier: str, tag: str = "clause") -> str:
    attribute = f' modifier="{modifier}"' if modifier else ""
    return f"<{tag}{attribute}><variable>{escape(variable)}</variable><term>{escape(term)}</term></{tag}>"


def _shape_lines(shape: WrittenShape) -> Iterator[str]:
    if shape.tag.startswith("pointSet"):
        yield f'<{shape.tag} interpolationMethod="linear">'
        for x, y in zip(shape.parameters[::2], shape.parameters[1::2], strict=True):
            yield f'  <point x="{number_text(x)}" y="{number_text(y)}"/>'
        yield f"</{shape.tag}>"
        return
    parameters = " ".join(f'param{i}="{number_text(v)}"' for i, v in enumerate(shape.parameters, 1))
    yield f"<{shape.tag} {parameters}/>"


def _quoted(text: str) -> str:
    """Return a text as an attribute; line ends would be read as blanks."""
    return quoteattr(text, {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"})
