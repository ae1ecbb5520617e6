"""Rules from FML rule bases; composed terms are replaced by their definitions."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final, Literal

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import ONE, ZERO, Number
from fuzzyctl.formats.common.blocks import FoundBlock
from fuzzyctl.formats.common.report import Names
from fuzzyctl.formats.fml.document import MAX_DEPTH, Element
from fuzzyctl.formats.fml.hedges import NEED_ONE, OWN_HEDGES, reaches_one, up_to
from fuzzyctl.formats.fml.markup import Markup, one_line
from fuzzyctl.formats.fml.vocabulary import CONJUNCTION_WORDS, MODIFIERS, NORMS
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import Activation, Defuzzifier
from fuzzyctl.model.variable import Term

_RULES: Final = ("rule", "tskrule")
_METHODS: Final = ("andmethod", "ormethod")
_BASE: Final = ("name", "type", "activationmethod", *_METHODS, "inferenceengine")
_CLAUSES: Final = ("clause", "tskclause")
_CONNECTORS: Final = {"AND": "and", "OR": "or"}
_AVERAGE: Final = Defuzzifier(kind="weighted_average")
_USUAL: Final = {"and": "min", "or": "max"}

#: Modifiers that are a set beside the term, not a function of its degree.
_BESIDE: Final = ("above", "below")

#: All modifiers with their hedges; those that are none stand for themselves.
_MODIFIERS: Final = {**{w: w for w in (*OWN_HEDGES, *_BESIDE, "norm")}, **MODIFIERS}

_SLIGHTLY: Final = "'slightly' is plus and not very by the smaller degree, made to reach 1; JFML takes their product"
_MEANT: Final = "write the set that is meant as a term of its own"

#: Hedges that only rise with the degree, so that they can change places with MIN and MAX.
_RISING: Final = frozenset({"very", "somewhat", "extremely", "slightly", "seldom", "any", "plus", "intensify"})

#: Most conditions that one rule may become: definitions may use each other, and grow by that.
_MOST_CONDITIONS: Final = 1000


@dataclass
class Variable:
    """A variable of the document.

    Args:
        element: Where it stands.
        name: Its name.
        keyword: Which it is; empty for one whose terms are all defined by others.
        ends: Its range.
        terms: Its terms that could be read; rules add those for what is `above` or `below` one.
        words: The names of all its terms.
        defined: Elements that define a term by others, by its name.
        negated: Terms whose complement is meant, and that have no function of their own for it.
        method: How its sets are joined, and what makes a number of them, by the fields of a method.
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


def _put(blocks: list[FoundBlock], new: FoundBlock) -> None:
    """Add rules to the first block whose rules join by the same norms, as far as they join at all."""
    for k, block in enumerate(blocks):
        if all(a is None or b is None or a == b for a, b in zip(_norms(block), _norms(new), strict=True)):
            conjunction, disjunction = (a or b for a, b in zip(_norms(block), _norms(new), strict=True))
            both = (*block.rules, *new.rules)
            blocks[k] = replace(block, rules=both, conjunction=conjunction, disjunction=disjunction)
            return
    blocks.append(new)


def _norms(block: FoundBlock) -> tuple[str | None, str | None]:
    return block.conjunction, block.disjunction


class RuleReader:
    """Reads rule bases.

    Args:
        variables: The variables by name; terms are added to them for what is `above` or `below` a term.
        markup: Where mistakes go.
        used: The modifiers that the document has.

    Attributes:
        blocks: The rule bases, and those of their rules that join by other norms, as blocks of their own.
        modifiers: The modifiers that are used.
    """

    def __init__(self, variables: Mapping[str, Variable], markup: Markup, used: Collection[str]) -> None:
        self._variables, self._markup = variables, markup
        # `intensify` is the hedge `extremely`, unless that is the standard's.
        self._own = {w: h for w, h in OWN_HEDGES.items() if w in used and (w != "intensify" or "extremely" in used)}
        self._beside: dict[tuple[str, str, str], str] = {}
        self._made = 0
        #: Norms that the rule being read joins by, and how.
        self._joins: dict[str, str] = {}
        self.blocks: list[FoundBlock] = []
        self.modifiers: dict[str, Span] = {}

    @property
    def hedges(self) -> list[sx.Hedge]:
        """The hedges of the system's own that rules use."""
        own = ((h, self.modifiers[w]) for w, h in self._own.items() if w in self.modifiers)
        return [sx.Hedge(p, sx.Word(h.name, p), sx.Word(h.parameter, p), h.expression) for h, p in own]

    def read(self, base: Element) -> None:
        """Read one rule base."""
        if base.name == "anyarulebase":
            help_text = "write fuzzyTerms for what the clouds stand for, and rules over these"
            self._markup.error("FZ602", "AnYa rule bases are not available", base.span, help=help_text)
            return
        self._markup.known(base, _BASE, _RULES)
        implication = self._markup.choice(base, "activationmethod", CONJUNCTION_WORDS, "min")
        name = one_line(base.attributes.get("name", ""))
        # So the writer calls the rules of no block.
        name = "" if name == "rules1" and not self.blocks else name
        own: list[FoundBlock] = []
        for element in base.all(*_RULES):
            rules = self._rule(element, base)
            joins = self._joins.get("and"), self._joins.get("or")
            place = element.span if own else base.span  # further blocks are rules that join by other norms
            _put(own, FoundBlock(name, rules, *joins, implication, Activation(), place))
        self.blocks.extend(own)

    def _rule(self, element: Element, base: Element) -> tuple[sx.Rule, ...]:
        """Return a rule; after a mistake, which is reported, what else it has, so that names are checked."""
        markup = self._markup
        attributes = ("name", "connector", "operator", "weight", *_METHODS)
        markup.known(element, attributes, ("antecedent", "consequent", "tskconsequent"))
        self._made, self._joins = 0, {}
        antecedent = self._antecedent(element, base)
        weight = markup.value(element, "weight", ONE)
        consequent = markup.only(element, "consequent", "tskconsequent")
        if consequent is None:
            markup.error("FZ601", f"<{element.tag}> has no consequent", element.span)
            return (sx.Rule(element.span, antecedent, (), weight),)
        then = markup.only(consequent, "then", "tskthen")
        markup.known(consequent, (), ("then", "else", "tskthen", "tskelse", *(_CLAUSES if then is None else ())))
        rule = sx.Rule(element.span, antecedent, self._conclusions(consequent if then is None else then), weight)
        otherwise = markup.only(consequent, "else", "tskelse")
        return (rule,) if otherwise is None else (rule, self._else(otherwise, rule))

    def _else(self, element: Element, rule: sx.Rule) -> sx.Rule:
        """Return the rule for where the antecedent does not hold; a weight would make that 1 - the weighted truth."""
        if rule.weight not in (None, ONE):
            message = "<else> of a rule with a weight is not available"
            self._markup.error("FZ602", message, element.span, help="write a rule of its own for it")
        conclusions = self._conclusions(element)
        return sx.Rule(element.span, sx.Negation(rule.span, rule.antecedent), conclusions, ONE)

    def _antecedent(self, rule: Element, base: Element) -> sx.Truth:
        markup, nothing = self._markup, sx.Chain(rule.span, "and", ())
        element = markup.only(rule, "antecedent")
        if element is not None:
            markup.known(element, (), ("clause",))
        clauses = [self._clause(c) for c in element.all("clause")] if element is not None else []
        if not clauses:
            markup.error("FZ601", f"<{rule.tag}> has no antecedent", rule.span)
        operands = tuple(c for c in clauses if c is not None)
        connector = markup.choice(rule, "connector", _CONNECTORS, "and", "connector")
        if len(operands) < 2:
            return operands[0] if operands else nothing
        words, usual = NORMS[connector][0], _USUAL[connector]
        # Its own norm, the one of its connector as drafts have it, or the rule base's.
        for owner, attribute in ((base, f"{connector}method"), (rule, "operator"), (rule, f"{connector}method")):
            usual = markup.choice(owner, attribute, words, usual)
        self._note_norm(connector, usual, rule.span)
        return sx.Chain(rule.span, connector, operands)

    def _note_norm(self, connector: str, norm: str, span: Span) -> None:
        first = self._joins.setdefault(connector, norm)
        if norm != first:
            message = f"a rule with different methods for {connector.upper()}: '{first}' and '{norm}'"
            self._markup.error("FZ602", message, span, help="one method within a rule is available")

    def _named(self, clause: Element, what: str, *attributes: str) -> sx.Word | None:
        """Return what a clause names in an element, or in an attribute as an older dialect has it."""
        element = self._markup.only(clause, what)
        attribute = next((a for a in attributes if a in clause.attributes), what)
        text = one_line(element.text if element is not None else clause.attributes.get(attribute, ""))
        if not text:
            self._markup.error("FZ601", f"<{clause.tag}> names no {what}", clause.span)
            return None
        return sx.Word(text, element.span if element is not None else clause.place(attribute))

    def _clause(self, clause: Element, depth: int = 0) -> sx.Truth | None:
        literal = self._literal(clause)
        return None if literal is None else self._meaning(literal, depth)

    def _literal(self, clause: Element) -> sx.Literal | None:
        """Return a clause as it is written, but for modifiers that are other terms; None after a mistake."""
        self._markup.known(clause, ("modifier", "var", "variable", "term", "not"), ("variable", "term"))
        variable = self._named(clause, "variable", "variable", "var")
        term = self._named(clause, "term", "term") if variable is not None else None
        word = clause.attributes.get("modifier", "").strip().lower()
        place = clause.place("modifier")
        hedge = self._markup.look_up(place, _MODIFIERS, "modifier", word=word) if word else ""
        if variable is None or term is None or hedge is None:
            return None
        hedges = ("not",) if clause.attributes.get("not", "false").strip().lower() == "true" else ()
        literal = sx.Literal(clause.span, variable, tuple(sx.Word(h, place) for h in hedges), term)
        if not word or not self._declares(literal):
            return literal
        self.modifiers.setdefault(word, place)
        if word == "slightly":
            self._markup.unsure.setdefault(_SLIGHTLY, place)
        applied = sx.Word(self._own[word].name if word in self._own else hedge, place)
        if word in (*_BESIDE, *NEED_ONE):
            return self._applied(literal, word, applied)
        return replace(literal, hedges=(*literal.hedges, applied))

    def _declares(self, literal: sx.Literal) -> bool:
        """Whether a term is one of the document."""
        owner = self._variables.get(literal.variable.text)
        return owner is not None and any(w.text == literal.term.text for w in owner.words)

    def _require_term(self, literal: sx.Literal) -> None:
        """Report a term that a variable does not have."""
        variable, term = literal.variable.text, literal.term
        if variable in self._variables and not self._declares(literal):
            self._markup.error("FZ203", f"'{variable}' has no term '{term.text}'", term.span)

    def _applied(self, literal: sx.Literal, word: str, hedge: sx.Word) -> sx.Literal | None:
        """Return the term and the hedges that a modifier of a term is; None, with an error, where it is none."""
        owner, name = self._variables[literal.variable.text], literal.term.text
        term = next((t for t in owner.terms if t.name == name), None)
        if term is None:  # its shape has a mistake, or other terms define it
            if name in owner.defined:
                message = f"the modifier '{word}' of '{name}', which is defined by others, is not available"
                self._markup.error("FZ602", message, hedge.span)
            return None
        if name in owner.negated or (word in NEED_ONE and not reaches_one(term.membership)):
            message = f"'{word}' of '{name}', whose degrees do not reach 1, is not available"
            self._markup.error("FZ602", message, hedge.span, help=_MEANT)
            return None
        if word in NEED_ONE:  # `norm` of what reaches 1 already is nothing
            return replace(literal, hedges=(*literal.hedges, *([hedge] if word == "slightly" else ())))
        beside = self._beside_term(owner, term, "above" if word == "above" else "below", hedge.span)
        if beside is None:
            return None
        negation = sx.Word("not", hedge.span)
        return replace(literal, hedges=(*literal.hedges, negation), term=sx.Word(beside, literal.term.span))

    def _beside_term(self, owner: Variable, term: Term, side: Literal["above", "below"], place: Span) -> str | None:
        """Return the name of the term whose complement is `above` or `below` another one; it is added once."""
        key = (owner.name.text, term.name, side)
        if key not in self._beside:
            membership = up_to(term.membership, side)
            if membership is None:
                message = f"'{side}' of '{term.name}', which has several peaks or none of 1, is not available"
                self._markup.error("FZ602", message, place, help=_MEANT)
                return None
            other = "below" if side == "above" else "above"
            self._beside[key] = name = Names(t.name for t in owner.terms).take(f"{term.name} or {other}")
            owner.terms.append(Term(name=name, membership=membership, span=term.span))
        return self._beside[key]

    def _negated(self, literal: sx.Literal) -> sx.Literal:
        """Return a literal with `not` for a term whose complement is meant."""
        owner = self._variables.get(literal.variable.text)
        if owner is None or literal.term.text not in owner.negated:
            return literal
        return replace(literal, hedges=(*literal.hedges, sx.Word("not", literal.span)))

    def _meaning(self, literal: sx.Literal, depth: int) -> sx.Truth | None:
        """Return what `variable is term` stands for."""
        name, span, markup = literal.term.text, literal.span, self._markup
        self._made += 1
        if depth > MAX_DEPTH or self._made > _MOST_CONDITIONS:
            markup.error("FZ106", f"the definition of '{name}' uses itself, or too many others", span)
            return None
        owner = self._variables.get(literal.variable.text)
        definition = owner.defined.get(name) if owner is not None else None
        if definition is None:
            if name == "any":  # which rule files need not declare
                self._require_term(literal)
            return self._negated(literal)
        parts = list(definition.all("and", "or"))
        if len(parts) != 1:
            markup.error("FZ601", f"'{name}' is defined by one <and> or <or>", definition.span)
            return None
        whole = self._joined(parts[0], literal.variable, depth + 1, hedged=bool(literal.hedges))
        for hedge in reversed(literal.hedges) if whole is not None else ():
            modified = self._with_hedge(whole, hedge)
            if modified is None:
                message = f"the modifier '{hedge.text}' of '{name}', which is defined by others, is not available"
                help_text = "with MIN and MAX those that only rise with the degree are, and 'not' is with any"
                markup.error("FZ602", message, span, help=help_text)
                return None
            whole = modified
        return whole

    def _with_hedge(self, truth: sx.Truth | None, hedge: sx.Word) -> sx.Truth | None:
        """Return a hedge of a condition: of several joined by MIN and MAX it is that of each, where it only rises."""
        if isinstance(truth, sx.Literal):
            return replace(truth, hedges=(hedge, *truth.hedges))
        if hedge.text == "not" and truth is not None:
            return sx.Negation(hedge.span, truth)
        usual = all(self._joins.get(c, norm) == norm for c, norm in _USUAL.items())
        if hedge.text not in _RISING or not usual or not isinstance(truth, sx.Chain):
            return None
        operands = [self._with_hedge(o, hedge) for o in truth.operands]
        known = tuple(o for o in operands if o is not None)
        return replace(truth, operands=known) if len(known) == len(operands) else None

    def _joined(self, element: Element, variable: sx.Word, depth: int, *, hedged: bool = False) -> sx.Truth | None:
        """Return what <and> and <or> of a definition stand for.

        A condition joined with itself by MIN or MAX is itself; a modifier of it comes before its own.
        """
        markup = self._markup
        markup.known(element, ("t-norm", "t-conorm"), ("and", "or", "termname", "clause"))
        if depth > MAX_DEPTH:
            markup.error("FZ106", "definitions are nested too deeply", element.span)
            return None
        parts = [self._part(child, variable, depth) for child in element.children if not child.foreign]
        operands = tuple(p for p in parts if p is not None)
        if len(parts) < 2:
            markup.error("FZ601", f"<{element.tag}> joins two conditions or more", element.span)
        if not operands:
            return None
        words, attribute = NORMS[element.name]
        norm = markup.choice(element, attribute, words, _USUAL[element.name])
        words_of = {_words(o) for o in operands}
        if hedged and norm in ("min", "max") and len(words_of) == 1 and () not in words_of:
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
        negated = child.attributes.get("complement", "false").strip().lower() == "true"
        hedges = (sx.Word("not", child.span),) if negated else ()
        term = sx.Word(one_line(child.text), child.span)
        return self._meaning(sx.Literal(child.span, sx.Word(variable.text, child.span), hedges, term), depth + 1)

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
        literal = self._negated(literal)
        owner = self._variables.get(literal.variable.text)
        if owner is not None and literal.term.text in owner.defined:
            place = clause.span if owner.keyword else literal.variable.span
            message = f"a conclusion on '{literal.term.text}', which is defined by others"
            self._markup.error("FZ602", message, place)
        if owner is not None and owner.keyword == "input":
            self._require_term(literal)
        return sx.ConsequentText(literal.variable, literal.term, literal.hedges)


def _words(truth: sx.Truth) -> tuple[str, ...]:
    """Return the words of a literal, which are the same for the same condition; none for any other condition."""
    if not isinstance(truth, sx.Literal):
        return ()
    return truth.variable.text, *(h.text for h in truth.hedges), truth.term.text
