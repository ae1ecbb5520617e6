"""Rules from FML rule bases; composed terms are replaced by their definitions."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import ONE, ZERO, Number
from fuzzyctl.formats.common.blocks import FoundBlock
from fuzzyctl.formats.common.report import Names
from fuzzyctl.formats.fml.document import MAX_DEPTH, Element, Markup, one_line
from fuzzyctl.formats.fml.shapes import reaches_one, up_to
from fuzzyctl.formats.fml.vocabulary import CONJUNCTION_WORDS, HEDGES, MODIFIERS, NEED_ONE, NORMS
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import Activation, Defuzzifier
from fuzzyctl.model.variable import Term

_RULES: Final = ("rule", "tskrule")
_METHODS: Final = ("andmethod", "ormethod")
_BASE: Final = ("name", "type", "activationmethod", *_METHODS, "inferenceengine")
_CLAUSES: Final = ("clause", "tskclause")
_CONNECTORS: Final = {"AND": "and", "OR": "or"}
_AVERAGE: Final = Defuzzifier(kind="weighted_average")

_SLIGHTLY: Final = "'slightly' is plus and not very by the smaller degree, made to reach 1; JFML takes their product"
_MEANT: Final = "write the set that is meant as a term of its own"

#: Largest number of conditions in a rule, since definitions may use each other.
_MOST_CONDITIONS: Final = 1000


@dataclass
class Variable:
    """A variable of the document.

    Args:
        element: Its element.
        name: Its name.
        keyword: `input` or `output`; empty if other terms define all its terms.
        ends: Its range.
        terms: Its valid terms; rules add sets for `above` and `below`.
        words: The names of all its terms.
        defined: Elements that define a term by others, by its name.
        negated: Terms with a complement that no kind expresses.
        method: Aggregation and defuzzifier, by the fields of a method.
    """

    element: Element
    name: sx.Word
    keyword: str
    ends: tuple[Number, Number] = (ZERO, Number(1.0))
    terms: list[Term] = field(default_factory=list)
    words: list[sx.Word] = field(default_factory=list)
    defined: dict[str, Element] = field(default_factory=dict)
    negated: set[str] = field(default_factory=set)
    method: dict[str, Any] = field(default_factory=lambda: {"aggregation": "sum", "defuzzifier": _AVERAGE})


def _add_rules(blocks: list[FoundBlock], block: FoundBlock) -> None:
    """Add rules to the first block with the same norms, as far as either uses a norm."""
    norms = block.conjunction, block.disjunction
    for k, other in enumerate(blocks):
        pairs = list(zip((other.conjunction, other.disjunction), norms, strict=True))
        if all(a is None or b is None or a == b for a, b in pairs):
            conjunction, disjunction = (a or b for a, b in pairs)
            rules = (*other.rules, *block.rules)
            blocks[k] = replace(other, rules=rules, conjunction=conjunction, disjunction=disjunction)
            return
    blocks.append(block)


class RuleReader:
    """Reads rule bases.

    Args:
        variables: The variables by name; terms are added to them for `above` and `below`.
        markup: Takes the diagnostics.
        modifiers: All modifiers of the document.

    Attributes:
        blocks: The rule bases; rules with other norms are in further blocks.
        modifiers: The modifiers of declared terms, each with its first place.
    """

    def __init__(self, variables: Mapping[str, Variable], markup: Markup, modifiers: Collection[str]) -> None:
        self._variables, self._markup = variables, markup
        # `intensify` is the hedge `extremely`, unless that is the standard's.
        self._hedges = MODIFIERS if "extremely" in modifiers else {**MODIFIERS, "intensify": "extremely"}
        self._side_terms: dict[tuple[str, str, str], str] = {}
        self._conditions = 0
        #: Norms of the current rule by connector.
        self._norms: dict[str, str] = {}
        self.blocks: list[FoundBlock] = []
        self.modifiers: dict[str, Span] = {}

    def hedges(self) -> Iterator[sx.Hedge]:
        """Yield definitions of the hedges that rules use."""
        places = {self._hedges[word]: place for word, place in self.modifiers.items()}
        for name, hedge in HEDGES.items():
            if (p := places.get(name)) is not None:
                yield sx.Hedge(p, sx.Word(name, p), sx.Word(hedge.parameter, p), hedge.expression)

    def read(self, base: Element) -> None:
        """Read a rule base."""
        markup = self._markup
        if base.name == "anyarulebase":
            help_text = "write fuzzyTerms for what the clouds stand for, and rules over these"
            markup.error("FZ602", "AnYa rule bases are not available", base.span, help=help_text)
            return
        markup.check_parts(base, _BASE, _RULES)
        implication = markup.choice(base, "activationmethod", CONJUNCTION_WORDS, "min")
        name = one_line(base.attributes.get("name", ""))
        name = "" if name == "rules1" and not self.blocks else name  # the writer's name for rules in no block
        blocks: list[FoundBlock] = []
        for element in base.all(*_RULES):
            self._conditions, self._norms = 0, {}
            rules = tuple(self._rules(element, base))
            norms = self._norms.get("and"), self._norms.get("or")
            place = element.span if blocks else base.span
            _add_rules(blocks, FoundBlock(name, rules, *norms, implication, Activation(), place))
        self.blocks.extend(blocks)

    def _rules(self, element: Element, base: Element) -> Iterator[sx.Rule]:
        """Yield a rule and its else; invalid parts are reported and left out, so that all names are checked."""
        markup, span = self._markup, element.span
        attributes = ("name", "connector", "operator", "weight", *_METHODS)
        markup.check_parts(element, attributes, ("antecedent", "consequent", "tskconsequent"))
        antecedent = self._antecedent(element, base)
        weight = markup.number_of(element, "weight", ONE)
        consequent = markup.only_child(element, "consequent", "tskconsequent")
        if consequent is None:
            markup.error("FZ601", f"<{element.tag}> has no consequent", span)
            yield sx.Rule(span, antecedent, (), weight)
            return
        then = markup.only_child(consequent, "then", "tskthen")
        clauses = _CLAUSES if then is None else ()
        markup.check_parts(consequent, (), ("then", "else", "tskthen", "tskelse", *clauses))
        yield sx.Rule(span, antecedent, self._conclusions(then or consequent), weight)
        otherwise = markup.only_child(consequent, "else", "tskelse")
        if otherwise is not None:
            if weight not in (None, ONE):  # the rule would fire with 1 - the weighted truth
                message = "<else> of a rule with a weight is not available"
                markup.error("FZ602", message, otherwise.span, help="write a rule of its own for it")
            yield sx.Rule(span, sx.Negation(span, antecedent), self._conclusions(otherwise), ONE)

    def _antecedent(self, rule: Element, base: Element) -> sx.Truth:
        markup = self._markup
        element = markup.only_child(rule, "antecedent")
        if element is not None:
            markup.check_parts(element, (), ("clause",))
        clauses = [self._clause(c) for c in element.all("clause")] if element is not None else []
        if not clauses:
            markup.error("FZ601", f"<{rule.tag}> has no antecedent", rule.span)
        operands = tuple(c for c in clauses if c is not None)
        connector = markup.choice(rule, "connector", _CONNECTORS, "and", "connector")
        if len(operands) < 2:
            return operands[0] if operands else sx.Chain(rule.span, "and", ())
        words, norm, _ = NORMS[connector]
        # The norm of the rule, of its connector as in drafts, or of the rule base.
        for owner, attribute in ((base, f"{connector}method"), (rule, "operator"), (rule, f"{connector}method")):
            norm = markup.choice(owner, attribute, words, norm)
        self._note_norm(connector, norm, rule.span)
        return sx.Chain(rule.span, connector, operands)

    def _note_norm(self, connector: str, norm: str, span: Span) -> None:
        first = self._norms.setdefault(connector, norm)
        if norm != first:
            message = f"a rule with different methods for {connector.upper()}: '{first}' and '{norm}'"
            self._markup.error("FZ602", message, span, help="one method within a rule is available")

    def _conclusions(self, element: Element) -> tuple[sx.ConsequentText, ...]:
        clauses = list(element.all(*_CLAUSES))
        if not clauses:
            self._markup.error("FZ601", f"<{element.tag}> concludes nothing", element.span, help="add a <clause>")
        conclusions = [self._conclusion(c) for c in clauses]
        return tuple(c for c in conclusions if c is not None)

    def _conclusion(self, clause: Element) -> sx.ConsequentText | None:
        literal = self._literal(clause)
        if literal is None:
            return None
        literal = self._with_complement(literal)
        owner = self._variables.get(literal.variable.text)
        if owner is not None and literal.term.text in owner.defined:
            place = clause.span if owner.keyword else literal.variable.span
            message = f"a conclusion on '{literal.term.text}', which is defined by others"
            self._markup.error("FZ602", message, place)
        if owner is not None and owner.keyword == "input":
            self._require_term(literal)
        return sx.ConsequentText(literal.variable, literal.term, literal.hedges)

    # --- clauses and their modifiers -----------------------------------------------------------------------------

    def _name(self, clause: Element, part: str, *attributes: str) -> sx.Word | None:
        """Return a name in a clause: an element, or an attribute as in an older dialect."""
        element = self._markup.only_child(clause, part)
        attribute = next((a for a in attributes if a in clause.attributes), part)
        text = one_line(element.text if element is not None else clause.attributes.get(attribute, ""))
        if not text:
            self._markup.error("FZ601", f"<{clause.tag}> names no {part}", clause.span)
            return None
        return sx.Word(text, element.span if element is not None else clause.place(attribute))

    def _literal(self, clause: Element) -> sx.Literal | None:
        """Return a clause before definitions are inserted; None after an error."""
        markup = self._markup
        markup.check_parts(clause, ("modifier", "var", "variable", "term", "not"), ("variable", "term"))
        variable = self._name(clause, "variable", "variable", "var")
        term = self._name(clause, "term", "term") if variable is not None else None
        word, place = clause.attributes.get("modifier", "").strip().lower(), clause.place("modifier")
        hedge = markup.look_up(place, self._hedges, "modifier", word=word) if word else ""
        if variable is None or term is None or hedge is None:
            return None
        hedges = (sx.Word("not", place),) if _is_set(clause, "not") else ()
        literal = sx.Literal(clause.span, variable, hedges, term)
        if not word or not self._declares(literal):
            return literal
        self.modifiers.setdefault(word, place)
        if word == "slightly":
            markup.doubt(_SLIGHTLY, place)
        return self._with_modifier(literal, word, sx.Word(hedge, place))

    def _declares(self, literal: sx.Literal) -> bool:
        owner = self._variables.get(literal.variable.text)
        return owner is not None and any(w.text == literal.term.text for w in owner.words)

    def _require_term(self, literal: sx.Literal) -> None:
        """Report a term that its variable does not declare."""
        variable, term = literal.variable.text, literal.term
        if variable in self._variables and not self._declares(literal):
            self._markup.error("FZ203", f"'{variable}' has no term '{term.text}'", term.span)

    def _with_modifier(self, literal: sx.Literal, word: str, hedge: sx.Word) -> sx.Literal | None:
        """Return a literal of a declared term with a modifier; None, with an error, if that is not available."""
        hedged = replace(literal, hedges=(*literal.hedges, hedge))
        if word not in ("above", "below", *NEED_ONE):
            return hedged
        owner, name = self._variables[literal.variable.text], literal.term.text
        term = next((t for t in owner.terms if t.name == name), None)
        if term is None:  # its shape is invalid, or other terms define it
            if name in owner.defined:
                message = f"the modifier '{word}' of '{name}', which is defined by others, is not available"
                self._markup.error("FZ602", message, hedge.span)
            return None
        if name in owner.negated or (word in NEED_ONE and not reaches_one(term.membership)):
            message = f"'{word}' of '{name}', whose degrees do not reach 1, is not available"
            self._markup.error("FZ602", message, hedge.span, help=_MEANT)
            return None
        if word in NEED_ONE:
            return literal if word == "norm" else hedged
        side_term = self._side_term(owner, term, word, hedge.span)
        if side_term is None:
            return None
        negation = sx.Word("not", hedge.span)
        return replace(literal, hedges=(*literal.hedges, negation), term=sx.Word(side_term, literal.term.span))

    def _side_term(self, owner: Variable, term: Term, word: str, place: Span) -> str | None:
        """Return the name of the term whose complement is `above` or `below` another one; it is added once."""
        key = (owner.name.text, term.name, word)
        if key not in self._side_terms:
            membership = up_to(term.membership, above=word == "above")
            if membership is None:
                message = f"'{word}' of '{term.name}', which has several peaks or none of 1, is not available"
                self._markup.error("FZ602", message, place, help=_MEANT)
                return None
            other = "below" if word == "above" else "above"
            self._side_terms[key] = name = Names(t.name for t in owner.terms).take(f"{term.name} or {other}")
            owner.terms.append(Term(name=name, membership=membership, span=term.span))
        return self._side_terms[key]

    def _with_complement(self, literal: sx.Literal) -> sx.Literal:
        """Return a literal, with `not` for a term with a complement that no kind expresses."""
        owner = self._variables.get(literal.variable.text)
        if owner is None or literal.term.text not in owner.negated:
            return literal
        return replace(literal, hedges=(*literal.hedges, sx.Word("not", literal.span)))

    # --- definitions ---------------------------------------------------------------------------------------------

    def _clause(self, clause: Element, depth: int = 0) -> sx.Truth | None:
        literal = self._literal(clause)
        return None if literal is None else self._expanded(literal, depth)

    def _expanded(self, literal: sx.Literal, depth: int) -> sx.Truth | None:
        """Return a literal, or the definition of its term; None after an error."""
        name, span, markup = literal.term.text, literal.span, self._markup
        self._conditions += 1
        if depth > MAX_DEPTH or self._conditions > _MOST_CONDITIONS:
            markup.error("FZ106", f"the definition of '{name}' uses itself, or too many others", span)
            return None
        owner = self._variables.get(literal.variable.text)
        definition = owner.defined.get(name) if owner is not None else None
        if definition is None:
            if name == "any":  # which rule files need not declare
                self._require_term(literal)
            return self._with_complement(literal)
        parts = list(definition.all("and", "or"))
        if len(parts) != 1:
            markup.error("FZ601", f"'{name}' is defined by one <and> or <or>", definition.span)
            return None
        truth = self._joined(parts[0], literal.variable, depth + 1, hedged=bool(literal.hedges))
        for hedge in reversed(literal.hedges) if truth is not None else ():
            truth = self._with_hedge(truth, hedge)
            if truth is None:
                message = f"the modifier '{hedge.text}' of '{name}', which is defined by others, is not available"
                help_text = "with MIN and MAX those that only rise with the degree are, and 'not' is with any"
                markup.error("FZ602", message, span, help=help_text)
                return None
        return truth

    def _with_hedge(self, truth: sx.Truth | None, hedge: sx.Word) -> sx.Truth | None:
        """Return a condition with a hedge: each part of MIN and MAX gets it, since all hedges but `not` only rise."""
        if isinstance(truth, sx.Literal):
            return replace(truth, hedges=(hedge, *truth.hedges))
        if hedge.text == "not" and truth is not None:
            return sx.Negation(hedge.span, truth)
        if not isinstance(truth, sx.Chain) or any(n != NORMS[c].default for c, n in self._norms.items()):
            return None
        operands = [self._with_hedge(o, hedge) for o in truth.operands]
        hedged = tuple(o for o in operands if o is not None)
        return replace(truth, operands=hedged) if len(hedged) == len(operands) else None

    def _joined(self, element: Element, variable: sx.Word, depth: int, *, hedged: bool = False) -> sx.Truth | None:
        """Return the condition of <and> and <or> in a definition.

        A condition joined with itself by MIN or MAX is itself; a modifier of it comes before the modifiers in it.
        """
        markup = self._markup
        markup.check_parts(element, ("t-norm", "t-conorm"), ("and", "or", "termname", "clause"))
        if depth > MAX_DEPTH:
            markup.error("FZ106", "definitions are nested too deeply", element.span)
            return None
        parts = [self._part(child, variable, depth) for child in element.children if not child.foreign]
        operands = tuple(p for p in parts if p is not None)
        if len(parts) < 2:
            markup.error("FZ601", f"<{element.tag}> joins two conditions or more", element.span)
        if not operands:
            return None
        words, default, attribute = NORMS[element.name]
        norm = markup.choice(element, attribute, words, default)
        texts = {_words(o) for o in operands}
        if hedged and norm in ("min", "max") and len(texts) == 1 and () not in texts:
            return operands[0]
        self._note_norm(element.name, norm, element.span)
        return sx.Chain(element.span, element.name, operands)

    def _part(self, child: Element, variable: sx.Word, depth: int) -> sx.Truth | None:
        if child.name in ("and", "or"):
            return self._joined(child, variable, depth + 1)
        if child.name == "clause":
            return self._clause(child, depth + 1)
        if child.name != "termname":
            return None
        span = child.span
        hedges = (sx.Word("not", span),) if _is_set(child, "complement") else ()
        term = sx.Word(one_line(child.text), span)
        return self._expanded(sx.Literal(span, sx.Word(variable.text, span), hedges, term), depth + 1)


def _is_set(element: Element, attribute: str) -> bool:
    return element.attributes.get(attribute, "false").strip().lower() == "true"


def _words(truth: sx.Truth) -> tuple[str, ...]:
    """Return the words of a literal, which are equal for equal conditions; empty for other conditions."""
    if not isinstance(truth, sx.Literal):
        return ()
    return truth.variable.text, *(h.text for h in truth.hedges), truth.term.text
