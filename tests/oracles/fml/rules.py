"""Rules from FML rule bases: clauses are resolved, and composed terms replaced by their definitions."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Final, Literal

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import ONE, Number
from fuzzyctl.formats.common.report import Names
from fuzzyctl.model.block import Hedge
from fuzzyctl.model.method import Activation
from fuzzyctl.model.rule import And, Antecedent, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.variable import Input, Output, Term
from tests.oracles.blocks import FoundBlock
from tests.oracles.fml.document import MAX_DEPTH, Element
from tests.oracles.fml.hedges import NEED_ONE, OWN_HEDGES, reaches_one, up_to
from tests.oracles.fml.names import CONJUNCTION_WORDS, DISJUNCTION_WORDS, MODIFIERS
from tests.oracles.fml.scope import Scope
from tests.oracles.fml.variables import KnowledgeBase, unknown

_RULES: Final = ("rule", "tskrule")
_METHODS: Final = ("andmethod", "ormethod")
_BASE: Final = ("name", "type", "activationmethod", *_METHODS, "inferenceengine")
_CLAUSES: Final = ("clause", "tskclause")

#: Modifiers that are a set beside the term, not a function of its degree.
_BESIDE: Final = ("above", "below")

#: All modifiers, for messages.
_MODIFIERS: Final = tuple(sorted({*MODIFIERS, *OWN_HEDGES, *_BESIDE, "norm"}))

_SLIGHTLY: Final = "'slightly' is plus and not very by the smaller degree, made to reach 1; JFML takes their product"

#: Hedges that only rise with the degree, so that they can change places with MIN and MAX.
_RISING: Final = frozenset({"very", "somewhat", "extremely", "slightly", "seldom", "any", "plus", "intensify"})

#: Most conditions that one rule may become: definitions may use each other, and grow by that.
_MOST_CONDITIONS: Final = 1000


def _put(blocks: list[FoundBlock], new: FoundBlock) -> None:
    """Add rules to the first block whose rules join by the same norms, as far as they join at all."""
    for k, block in enumerate(blocks):
        if all(a is None or b is None or a == b for a, b in zip(_norms(block), _norms(new), strict=True)):
            conjunction, disjunction = (a or b for a, b in zip(_norms(block), _norms(new), strict=True))
            both = (*block.rules, *new.rules)
            blocks[k] = replace(block, rules=both, conjunction=conjunction, disjunction=disjunction)
            return
    if new.rules:
        blocks.append(new)


def _norms(block: FoundBlock) -> tuple[str | None, str | None]:
    return block.conjunction, block.disjunction


class RuleReader:
    """Reads rule bases.

    Args:
        base: The variables; terms are added to them for what is `above` or `below` a term.
        scope: Where mistakes go.
        used: The modifiers that the document has.

    Attributes:
        rules: The rules in order.
        blocks: The rule bases, and those of their rules that join by other norms, as blocks of their own.
        modifiers: The modifiers that are used.
    """

    def __init__(self, base: KnowledgeBase, scope: Scope, used: Collection[str]) -> None:
        self._base, self._scope = base, scope
        # `intensify` is the hedge `extremely`, unless that is the standard's.
        self._own = {w: h for w, h in OWN_HEDGES.items() if w in used and (w != "intensify" or "extremely" in used)}
        self._beside: dict[tuple[str, str, str], str] = {}
        self._inputs = {i.name for i in base.inputs}
        self._outputs = {o.name for o in base.outputs}
        self._made = 0
        self.rules: list[Rule] = []
        self.blocks: list[FoundBlock] = []
        #: Norms that the rule being read joins by, and how.
        self._joins: dict[str, str] = {}
        self.modifiers: dict[str, Span] = {}

    @property
    def hedges(self) -> tuple[Hedge, ...]:
        """The hedges of the system's own that rules use."""
        return tuple(hedge for word, hedge in self._own.items() if word in self.modifiers)

    def read(self, base: Element) -> None:
        """Read one rule base."""
        if base.name == "anyarulebase":
            help_text = "write fuzzyTerms for what the clouds stand for, and rules over these"
            self._scope.error("FZ602", "AnYa rule bases are not available", base.span, help=help_text)
            return
        self._scope.known(base, _BASE, _RULES)
        implication = self._scope.choice(base, "activationmethod", CONJUNCTION_WORDS, "min")
        name = " ".join(base.attributes.get("name", "").split())
        # So the writer calls the rules of no block.
        name = "" if name == "rules1" and not self.blocks else name
        own: list[FoundBlock] = []
        for element in base.all(*_RULES):
            made = self._rule(element, base)
            self.rules.extend(made)
            joins = self._joins.get("and"), self._joins.get("or")
            place = element.span if own else base.span  # further blocks are rules that join by other norms
            _put(own, FoundBlock(name, made, *joins, implication, Activation(), place))
        self.blocks.extend(own)

    def _rule(self, element: Element, base: Element) -> tuple[Rule, ...]:
        attributes = ("name", "connector", "operator", "weight", *_METHODS)
        self._scope.known(element, attributes, ("antecedent", "consequent", "tskconsequent"))
        self._made = 0
        self._joins = {}
        antecedent = self._antecedent(element, base)
        weight = self._weight(element)
        consequent = self._scope.only(element, "consequent", "tskconsequent")
        if consequent is None:
            self._scope.error("FZ601", f"<{element.tag}> has no consequent", element.span)
            return ()
        then = self._scope.only(consequent, "then", "tskthen")
        self._scope.known(consequent, (), ("then", "else", "tskthen", "tskelse", *(_CLAUSES if then is None else ())))
        conclusions = self._conclusions(consequent if then is None else then)
        otherwise = self._scope.only(consequent, "else", "tskelse")
        if antecedent is None or weight is None or conclusions is None:
            return ()
        rule = Rule(antecedent=antecedent, consequents=conclusions, weight=weight, span=element.span)
        return (rule, *self._else(otherwise, antecedent, weight)) if otherwise is not None else (rule,)

    def _else(self, element: Element, antecedent: Antecedent, weight: Number) -> tuple[Rule, ...]:
        """Return the rule for where the antecedent does not hold; a weight would make that 1 - the weighted truth."""
        conclusions = self._conclusions(element)
        if weight != ONE:
            message = "<else> of a rule with a weight is not available"
            self._scope.error("FZ602", message, element.span, help="write a rule of its own for it")
        elif conclusions is not None:
            return (Rule(antecedent=Not(operand=antecedent), consequents=conclusions, span=element.span),)
        return ()

    def _weight(self, element: Element) -> Number | None:
        if not element.attributes.get("weight", "").strip():
            return ONE
        return self._scope.number(element, "weight")

    def _antecedent(self, rule: Element, base: Element) -> Antecedent | None:
        element = self._scope.only(rule, "antecedent")
        if element is None or not element.children:
            self._scope.error("FZ601", f"<{rule.tag}> has no antecedent", rule.span)
            return None
        self._scope.known(element, (), ("clause",))
        clauses = [self._clause(c) for c in element.all("clause")]
        if not clauses or any(c is None for c in clauses):
            return None
        operands = tuple(c for c in clauses if c is not None)
        connector = rule.attributes.get("connector", "and").strip().lower() or "and"
        if connector not in ("and", "or"):
            message = f"the connector is '{connector}', neither and nor or"
            self._scope.error("FZ213", message, rule.place("connector"))
            return None
        if len(operands) == 1:
            return operands[0]
        self._note_norm(connector, self._norm(rule, base, connector), rule.span)
        return And(operands=operands) if connector == "and" else Or(operands=operands)

    def _norm(self, rule: Element, base: Element, connector: str) -> str:
        """Return the norm of a rule: its own, the one of its connector as drafts have it, or the rule base's."""
        words = CONJUNCTION_WORDS if connector == "and" else DISJUNCTION_WORDS
        usual = self._scope.choice(base, f"{connector}method", words, "min" if connector == "and" else "max")
        usual = self._scope.choice(rule, "operator", words, usual)
        return self._scope.choice(rule, f"{connector}method", words, usual)

    def _note_norm(self, connector: str, norm: str, span: Span) -> None:
        first = self._joins.setdefault(connector, norm)
        if norm != first:
            message = f"a rule with different methods for {connector.upper()}: '{first}' and '{norm}'"
            self._scope.error("FZ602", message, span, help="one method within a rule is available")

    def _named(self, clause: Element) -> tuple[str, str, Span, Span] | None:
        """Return variable and term of a clause, which are elements in it, or attributes in an older dialect."""
        self._scope.known(clause, ("modifier", "var", "variable", "term", "not"), ("variable", "term"))
        found: list[tuple[str, Span]] = []
        for what, attributes in (("variable", ("variable", "var")), ("term", ("term",))):
            element = self._scope.only(clause, what)
            attribute = next((a for a in attributes if a in clause.attributes), None)
            text = element.text if element is not None else clause.attributes.get(attribute or "", "")
            if not text.strip():
                self._scope.error("FZ601", f"<{clause.tag}> names no {what}", clause.span)
                return None
            place = element.span if element is not None else clause.place(attribute or what)
            found.append((" ".join(text.split()), place))
        return found[0][0], found[1][0], found[0][1], found[1][1]

    def _clause(self, clause: Element, depth: int = 0) -> Antecedent | None:
        found = self._resolved(clause)
        return None if found is None else self._meaning(*found, clause.span, depth)

    def _resolved(self, clause: Element, *, concludes: bool = False) -> tuple[tuple[str, str], tuple[str, ...]] | None:
        """Return variable and term of a clause, and its hedges; None, with an error, where it has none."""
        named, hedges = self._named(clause), self._modifier(clause)
        if named is None or hedges is None or not self._declared(*named):
            return None
        key = named[:2]
        if concludes and not self._is_output(key, named[2], clause):
            return None
        applied = self._applied(key, hedges, clause)
        return None if applied is None else ((key[0], applied[0]), applied[1])

    def _is_output(self, key: tuple[str, str], place: Span, clause: Element) -> bool:
        variable, term = key
        if variable not in self._outputs:
            message, facts, help_text = unknown("output", variable, sorted(self._outputs))
            if variable in self._inputs:
                message = f"'{variable}' is an input, and rules conclude on outputs"
                help_text = 'declare it: type="output"'
            self._scope.error("FZ202", message, place, facts=facts, help=help_text)
            return False
        if key in self._base.defined:
            self._scope.error("FZ602", f"a conclusion on '{term}', which is defined by others", clause.span)
        return key not in self._base.defined

    def _declared(self, variable: str, term: str, place: Span, term_place: Span) -> bool:
        terms = self._base.terms.get(variable)
        if terms is None:
            message, facts, help_text = unknown("variable", variable, list(self._base.terms))
            self._scope.error("FZ202", message, place, facts=facts, help=help_text)
            return False
        if term not in terms:
            _, facts, help_text = unknown("term", term, terms)
            self._scope.error("FZ203", f"'{variable}' has no term '{term}'", term_place, facts=facts, help=help_text)
            return False
        return True

    def _modifier(self, clause: Element) -> tuple[str, ...] | None:
        """Return the hedges of a clause; None, with an error, for one that is not available."""
        negated = clause.attributes.get("not", "false").strip().lower() == "true"
        word = clause.attributes.get("modifier", "").strip().lower()
        first = ("not",) if negated else ()
        if not word:
            return first
        place = clause.place("modifier")
        if word not in _MODIFIERS:
            facts = (f"modifiers: {', '.join(_MODIFIERS)}",)
            self._scope.error("FZ602", f"the modifier '{word}' is not available", place, facts=facts)
            return None
        self.modifiers.setdefault(word, place)
        if word == "slightly":
            self._scope.unsure.setdefault(_SLIGHTLY, place)
        return (*first, self._own[word].name if word in self._own else MODIFIERS.get(word, word))

    def _applied(
        self, key: tuple[str, str], hedges: tuple[str, ...], clause: Element
    ) -> tuple[str, tuple[str, ...]] | None:
        """Return the term and the hedges that modifiers of a term are; None, with an error, where they are none."""
        word = clause.attributes.get("modifier", "").strip().lower()
        if word not in (*_BESIDE, *NEED_ONE):
            return key[1], hedges
        owner = self._owner(key[0])
        term = next((t for t in owner.terms if t.name == key[1]), None) if owner is not None else None
        place = clause.place("modifier")
        if term is None or owner is None:  # its shape has a mistake, or other terms define it
            if key in self._base.defined:
                message = f"the modifier '{word}' of '{key[1]}', which is defined by others, is not available"
                self._scope.error("FZ602", message, place)
            return None
        if key in self._base.negated or (word in NEED_ONE and not reaches_one(term.membership)):
            message = f"'{word}' of '{key[1]}', whose degrees do not reach 1, is not available"
            self._scope.error("FZ602", message, place, help="write the set that is meant as a term of its own")
            return None
        if word == "norm":  # it reaches 1 already
            return key[1], hedges[:-1]
        if word == "slightly":
            return key[1], hedges
        side: Literal["above", "below"] = "above" if word == "above" else "below"
        found = self._beside_term(owner, term, side, place)
        return (found, (*hedges[:-1], "not")) if found is not None else None

    def _beside_term(
        self, owner: Input | Output, term: Term, side: Literal["above", "below"], place: Span
    ) -> str | None:
        """Return the name of the term whose complement is `above` or `below` another one; it is added once."""
        key = (owner.name, term.name, side)
        if key not in self._beside:
            membership = up_to(term.membership, side)
            if membership is None:
                message = f"'{side}' of '{term.name}', which has several peaks or none of 1, is not available"
                self._scope.error("FZ602", message, place, help="write the set that is meant as a term of its own")
                return None
            other = "below" if side == "above" else "above"
            name = Names(t.name for t in owner.terms).take(f"{term.name} or {other}")
            self._beside[key] = name
            made = Term(name=name, membership=membership, span=term.span)
            self._replace(owner, owner.model_copy(update={"terms": (*owner.terms, made)}))
        return self._beside[key]

    def _owner(self, variable: str) -> Input | Output | None:
        variables: list[Input | Output] = [*self._base.inputs, *self._base.outputs]
        return next((v for v in variables if v.name == variable), None)

    def _replace(self, old: Input | Output, new: Input | Output) -> None:
        if isinstance(new, Input):
            self._base.inputs = [new if i is old else i for i in self._base.inputs]
        else:
            self._base.outputs = [new if o is old else o for o in self._base.outputs]

    def _meaning(self, key: tuple[str, str], hedges: tuple[str, ...], span: Span, depth: int) -> Antecedent | None:
        """Return what `variable is term` stands for."""
        self._made += 1
        if depth > MAX_DEPTH or self._made > _MOST_CONDITIONS:
            self._scope.error("FZ106", f"the definition of '{key[1]}' uses itself, or too many others", span)
            return None
        definition = self._base.defined.get(key)
        if definition is None:
            hedges = (*hedges, "not") if key in self._base.negated else hedges
            return Is(variable=key[0], term=key[1], hedges=hedges, span=span)
        parts = list(definition.all("and", "or"))
        if len(parts) != 1:
            self._scope.error("FZ601", f"'{key[1]}' is defined by one <and> or <or>", definition.span)
            return None
        found = self._joined(parts[0], key[0], depth + 1, hedged=bool(hedges))
        if found is None or not hedges:
            return found
        if isinstance(found, Is):
            return found.model_copy(update={"hedges": (*hedges, *found.hedges)})
        for hedge in reversed(hedges):
            modified = self._with_hedge(found, hedge, span)
            if modified is None:
                message = f"the modifier '{hedge}' of '{key[1]}', which is defined by others, is not available"
                help_text = "with MIN and MAX those that only rise with the degree are, and 'not' is with any"
                self._scope.error("FZ602", message, span, help=help_text)
                return None
            found = modified
        return found

    def _with_hedge(self, antecedent: Antecedent, hedge: str, span: Span) -> Antecedent | None:
        """Return a hedge of a condition: of several joined by MIN and MAX it is that of each, where it only rises."""
        if isinstance(antecedent, Is):
            return antecedent.model_copy(update={"hedges": (hedge, *antecedent.hedges)})
        if hedge == "not":
            return Not(operand=antecedent, span=span)
        usual = self._joins.get("and", "min") == "min" and self._joins.get("or", "max") == "max"
        if hedge not in _RISING or not usual or not isinstance(antecedent, And | Or):
            return None
        operands = [self._with_hedge(o, hedge, span) for o in antecedent.operands]
        if any(o is None for o in operands):
            return None
        return antecedent.model_copy(update={"operands": tuple(o for o in operands if o is not None)})

    def _joined(self, element: Element, variable: str, depth: int, *, hedged: bool = False) -> Antecedent | None:
        """Return what <and> and <or> of a definition stand for.

        A condition joined with itself by MIN or MAX is itself; a modifier of it comes before its own.
        """
        self._scope.known(element, ("t-norm", "t-conorm"), ("and", "or", "termname", "clause"))
        if depth > MAX_DEPTH:
            self._scope.error("FZ106", "definitions are nested too deeply", element.span)
            return None
        found = [self._part(child, variable, depth) for child in element.children if not child.foreign]
        if len(found) < 2 or any(f is None for f in found):
            if len(found) < 2:
                self._scope.error("FZ601", f"<{element.tag}> joins two conditions or more", element.span)
            return None
        operands = tuple(f for f in found if f is not None)
        connector = element.name
        words, attribute = (CONJUNCTION_WORDS, "t-norm") if connector == "and" else (DISJUNCTION_WORDS, "t-conorm")
        usual = "min" if connector == "and" else "max"
        norm = self._scope.choice(element, attribute, words, usual)
        if hedged and norm in ("min", "max") and isinstance(operands[0], Is) and len(set(operands)) == 1:
            return operands[0]
        self._note_norm(connector, norm, element.span)
        return And(operands=operands) if connector == "and" else Or(operands=operands)

    def _part(self, child: Element, variable: str, depth: int) -> Antecedent | None:
        if child.name in ("and", "or"):
            return self._joined(child, variable, depth + 1)
        if child.name == "clause":
            return self._clause(child, depth + 1)
        term = " ".join(child.text.split())
        if child.name != "termname" or not self._declared(variable, term, child.span, child.span):
            return None
        negated = child.attributes.get("complement", "false").strip().lower() == "true"
        return self._meaning((variable, term), ("not",) if negated else (), child.span, depth + 1)

    def _conclusions(self, element: Element) -> tuple[Consequent, ...] | None:
        found = [self._conclusion(c) for c in element.all(*_CLAUSES)]
        if not found:
            self._scope.error("FZ601", f"<{element.tag}> concludes nothing", element.span, help="add a <clause>")
            return None
        return None if any(f is None for f in found) else tuple(f for f in found if f is not None)

    def _conclusion(self, clause: Element) -> Consequent | None:
        found = self._resolved(clause, concludes=True)
        if found is None:
            return None
        key, hedges = found
        hedges = (*hedges, "not") if key in self._base.negated else hedges
        return Consequent(output=key[0], term=key[1], hedges=hedges, span=clause.span)
