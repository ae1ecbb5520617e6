"""Reader of FML: elements of XML become statements."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from pathlib import PurePath
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.expr import ZERO, Number
from fuzzyctl.formats.common import ranges
from fuzzyctl.formats.common.blocks import arranged
from fuzzyctl.formats.common.report import Names
from fuzzyctl.formats.common.translation import fallback, setting, settings
from fuzzyctl.formats.fml.document import Element, parse_document
from fuzzyctl.formats.fml.markup import Markup, one_line
from fuzzyctl.formats.fml.rules import RuleReader, Variable
from fuzzyctl.formats.fml.shapes import complement, shape_of
from fuzzyctl.formats.fml.vocabulary import ACCUMULATION_WORDS, DEFUZZIFIER_WORDS, POINT_SETS, SHAPES
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import OVER_RULES, Defuzzifier
from fuzzyctl.model.profiles import profile
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Membership, Term

_ROOTS: Final = ("fuzzysystem", "fuzzycontroller")
#: What fuzzyctl calls the rule bases of rules that stand in no block.
_WRITTEN: Final = re.compile(r"(rules\d*)?")
_RULE_BASES: Final = ("mamdanirulebase", "tskrulebase", "tsukamotorulebase", "rulebase", "anyarulebase")
_FUNCTIONS: Final = ("tskvariable", "takagisugenovariable")
_VARIABLES: Final = ("fuzzyvariable", "tsukamotovariable", "aggregatedfuzzyvariable", *_FUNCTIONS, "anyadatacloud")
_TERMS: Final = ("fuzzyterm", "tsukamototerm")
_COMMON: Final = ("name", "scale", "type", "domainleft", "domainright")
_TYPES: Final = {"INPUT": "input", "OUTPUT": "output"}
_AVERAGE: Final = {"WA": "weighted_average"}

#: What joins the parts of a definition.
_JOINED: Final = ("and", "or")

_AVERAGED: Final = ("singleton", "constant", "linear", "function")

_SUM: Final = "SUM is the plain sum of sets, as in drafts of FML; the standard has BSUM, min(1, a + b)"
_ORDER: Final = "terms of order 1: the first tskValue is the constant, as in JFML; FuzzyLogic.jl takes the last"


def read(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Return the system of an FML document, None where it has errors, and all diagnostics."""
    root, diagnostics = parse_document(source)
    if root is None:
        return None, diagnostics
    markup = Markup(source, draft=_is_draft(root))
    if root.name not in _ROOTS:
        message = f"the document is <{root.tag}>, not <fuzzySystem>, so it is no FML"
        markup.error("FZ004", message, root.span, help="FML of IEEE 1855 begins with <fuzzySystem name=...>")
        return None, markup.diagnostics
    markup.known(root, ("name",), ("knowledgebase", *_RULE_BASES, "inferenceengine"))
    bases = list(root.all("knowledgebase"))
    if len(bases) != 1:
        message = f"<{root.tag}> has {'no' if not bases else 'several'} <knowledgeBase>"
        markup.error("FZ212" if not bases else "FZ215", message, root.span, help="put all variables into one")
        return None, markup.in_order()
    _Document(root, bases[0], markup).translate()
    markup.tell_unsure()
    return markup.system(), markup.in_order()


def _is_draft(root: Element) -> bool:
    """Whether shapes are spelt with a capital, as before the standard."""
    shapes = (e for e in _all(root) if e.name in SHAPES or e.name in POINT_SETS)
    return next((e.tag[0].isupper() for e in shapes), False)


def _all(root: Element) -> Iterator[Element]:
    """Yield an element and all that are in it, in no order."""
    elements = [root]
    while elements:
        element = elements.pop()
        yield element
        elements.extend(element.children)


class _Document:
    """Translate a document.

    Args:
        root: Its root element.
        base: Its knowledge base.
        markup: Takes the statements, and mistakes.
    """

    def __init__(self, root: Element, base: Element, markup: Markup) -> None:
        self.root, self.markup = root, markup
        markup.known(base, ("name",), _VARIABLES)
        elements = list(base.all(*_VARIABLES))
        # Functions of inputs come last, since they are over all inputs.
        sets = [self._variable(e) for e in elements if e.name not in _FUNCTIONS]
        self.ends = [(v.ends[0].value, v.ends[1].value) for v in sets if v is not None and v.keyword == "input"]
        functions = [self._functions(e) for e in elements if e.name in _FUNCTIONS]
        place = {id(e): k for k, e in enumerate(elements)}
        self.variables = [v for v in (*sets, *functions) if v is not None]
        self.variables.sort(key=lambda v: place[id(v.element)])

    def translate(self) -> None:
        """Add all statements."""
        root, markup = self.root, self.markup
        variables = {v.name.text: v for v in reversed(self.variables)}
        used = {e.attributes.get("modifier", "").strip().lower() for e in _all(root)}
        rules = RuleReader(variables, markup, used)
        for element in root.all(*_RULE_BASES):
            rules.read(element)
        inputs, outputs = ([v for v in self.variables if v.keyword == k] for k in ("input", "output"))
        self._require_parts(bool(inputs), bool(outputs), bool(rules.blocks))
        sets = [o.name.text for o in outputs if not o.method["defuzzifier"].over_rules]
        keep = not all(_WRITTEN.fullmatch(b.name) for b in rules.blocks)
        found = arranged(rules.blocks, sets, keep=keep)
        place = root.span
        markup.statements += rules.hedges
        knobs = {"extremely": "cube"} if "extremely" in rules.modifiers else {}
        name = one_line(root.attributes.get("name", "")) or PurePath(markup.source.name).stem
        markup.head(name, "", place, profile("exact"), knobs)
        shared = {"implication": "min", **found.method, **(outputs[0].method if outputs else {})}
        markup.statements += settings({**found.method, **(outputs[0].method if outputs else {})}, place)
        for variable in self.variables:
            own = {"implication": found.implications.get(variable.name.text, shared["implication"]), **variable.method}
            self._add(variable, {n: v for n, v in own.items() if v != shared.get(n)})
        markup.rules(found)

    def _require_parts(self, inputs: bool, outputs: bool, rules: bool) -> None:
        markup, place = self.markup, self.root.span
        if not inputs and not any(e.name == "anyadatacloud" for e in _all(self.root)):
            help_text = 'add: <fuzzyVariable type="input" ...>'
            markup.error("FZ212", "the knowledge base has no input", place, help=help_text)
        if not outputs:
            help_text = 'add: <fuzzyVariable type="output" ...>'
            markup.error("FZ212", "the knowledge base has no output", place, help=help_text)
        if not rules and not markup.failed:
            markup.error("FZ212", "the document has no rule", place, help="add: <mamdaniRuleBase ...>")

    def _add(self, variable: Variable, own: dict[str, Any]) -> None:
        """Add a variable; one whose terms others define is there for rules, and is no part of the system."""
        markup, element = self.markup, variable.element
        name, place = variable.name, element.span
        clauses = list[sx.Clause]()
        known = {*(t.name for t in variable.terms), *(variable.defined if variable.keyword else ())}
        unread = [w for w in variable.words if w.text not in known]
        if not variable.keyword:
            markup.left_out.add(name.text)
        else:
            scale = element.attributes.get("scale", "").strip()
            clauses.append(sx.UnitClause("" if scale.lower() == "null" else scale, place))
        if variable.keyword == "output":
            clauses += [sx.SettingClause(setting(n, v, place), place) for n, v in own.items()]
            clauses.append(fallback(markup.value(element, "defaultvalue", Number(0.0)) or ZERO, place))
        keyword = variable.keyword or "output"
        markup.variable(keyword, name, variable.ends, variable.terms, clauses, unread=unread, place=place)

    # --- variables of sets -------------------------------------------------------------------------------------

    def _variable(self, element: Element) -> Variable | None:
        markup = self.markup
        if element.name == "anyadatacloud":
            markup.error("FZ602", "AnYa data clouds are not available", element.span)
            return None
        is_defined, is_tsukamoto = (element.name == f"{k}variable" for k in ("aggregatedfuzzy", "tsukamoto"))
        more = () if is_defined else (*_COMMON, "accumulation", "defuzzifier", "defaultvalue", "combination")
        term_tag = element.name.replace("variable", "term")
        markup.known(element, more or ("name", "type"), (term_tag,))
        name = markup.name(element)
        low, high = (None, None) if is_defined else (markup.value(element, e) for e in ("domainleft", "domainright"))
        if name is None:
            return None
        variable = Variable(element, name, "", (low or Number(0.0), high or Number(1.0)))
        names = Names()
        if is_defined:
            for term in element.all(term_tag):
                word = self._term_name(term, variable, names, _JOINED)
                if word is not None:
                    variable.defined[word.text] = term
            return variable
        # Places are clamped to the range, so that a consequent may be flat beyond it; only so it can be inverted.
        ends = (-math.inf, math.inf) if is_tsukamoto else (variable.ends[0].value, variable.ends[1].value)
        for term in element.all(*_TERMS):
            self._term(term, variable, names, ends)
        if not variable.words:
            markup.error("FZ212", f"'{name.text}' has no terms", element.span, help="add: <fuzzyTerm ...>")
        said = element.attributes.get("type", "output" if is_tsukamoto else "input").strip().upper()
        keyword = markup.look_up(element.place("type"), _TYPES, "type", word=said, code="FZ213")
        variable.keyword = keyword or _TYPES[closest(said, list(_TYPES)) or "INPUT"]
        if variable.keyword == "output":
            self._method(variable, is_tsukamoto)
        return variable

    def _method(self, variable: Variable, is_tsukamoto: bool) -> None:
        markup, element, kind = self.markup, variable.element, "tsukamoto"
        if is_tsukamoto:
            markup.choice(element, "combination", _AVERAGE, "")
        else:
            kind = markup.choice(element, "defuzzifier", DEFUZZIFIER_WORDS, "centroid", "defuzzifier")
            if variable.terms and all(t.membership.kind in _AVERAGED for t in variable.terms):
                message = f"the terms of '{variable.name.text}' are numbers, so their average is taken"
                help_text = "give it fuzzy sets, or tskTerms"
                markup.warning("FZ603", message, element.place("defuzzifier"), help=help_text)
                kind = "weighted_average"
        joined = markup.choice(element, "accumulation", ACCUMULATION_WORDS, "max", "accumulation")
        if joined == "sum":
            markup.unsure.setdefault(_SUM, element.place("accumulation"))
        joined = "sum" if kind in OVER_RULES else joined
        variable.method = {"aggregation": joined, "defuzzifier": Defuzzifier(kind=kind)}

    def _term_name(
        self,
        term: Element,
        variable: Variable,
        names: Names,
        children: Sequence[str],
        attributes: Sequence[str] = ("complement", "order"),
    ) -> sx.Word | None:
        """Return the name that a term has here; None, with an error, for one without."""
        name = self.markup.name(term)
        self.markup.known(term, ("name", *attributes), children)
        if name is None:
            return None
        own = sx.Word(names.take(name.text), term.span)
        if own.text != name.text:
            message = f"'{variable.name.text}' has two terms '{name.text}'; rules mean the first one"
            help_text = f"the second is called '{own.text}' here; rename it"
            self.markup.warning("FZ604", message, name.span, help=help_text)
        variable.words.append(own)
        return own

    def _term(self, term: Element, variable: Variable, names: Names, ends: tuple[float, float]) -> None:
        markup = self.markup
        name = self._term_name(term, variable, names, [c.name for c in term.children])
        if name is None:
            return
        shapes = [c for c in term.children if not c.foreign or c.name in SHAPES]
        if len(shapes) != 1:
            message = f"term '{name.text}' has {'no shape' if not shapes else 'several shapes'}"
            markup.error("FZ601", message, term.span, help="give it one, such as <triangularShape .../>")
            return
        if shapes[0].name == "circulardefinition":
            markup.known(shapes[0], (), _JOINED)
            variable.defined[name.text] = shapes[0]
            return
        membership = shape_of(shapes[0], markup, ends)
        if membership is None:
            return
        if markup.flag(term, "complement"):
            other = complement(membership)
            if other is None:
                variable.negated.add(name.text)
            membership = other or membership
        variable.terms.append(Term(name=name.text, membership=membership, span=term.span))

    # --- variables whose terms are functions of the inputs -----------------------------------------------------

    def _functions(self, element: Element) -> Variable | None:
        markup = self.markup
        markup.known(element, (*_COMMON, "combination", "defaultvalue"), ("tskterm", "sugenoterm"))
        markup.choice(element, "combination", _AVERAGE, "")
        name = markup.name(element)
        if name is None:
            return None
        variable, names = Variable(element, name, "output"), Names()
        for term in element.all("tskterm", "sugenoterm"):
            params = [f"param{i}" for i in range(len(self.ends) + 1)]
            expected = (("tskvalue",),) if term.name == "tskterm" else ((), params)
            word = self._term_name(term, variable, names, *expected)
            membership = self._function(term) if word is not None else None
            if word is not None and membership is not None:
                variable.terms.append(Term(name=word.text, membership=membership, span=term.span))
        variable.ends = self._reach(variable)
        return variable

    def _function(self, term: Element) -> Membership | None:
        markup, count = self.markup, len(self.ends)
        if term.name == "sugenoterm":
            written = [term.attributes[f"param{i}"] for i in range(count + 1) if f"param{i}" in term.attributes]
            values = [markup.parsed(v, "a parameter", term.span) for v in written]
            order = "1"
        else:
            values = [markup.parsed(v.text, "<tskValue>", v.span) for v in term.all("tskvalue")]
            order = term.attributes.get("order", "0" if len(values) == 1 else "1").strip()
        given = tuple(v for v in values if v is not None)
        if len(given) < len(values):
            return None
        if order == "0" and len(given) == 1:
            return Membership(kind="constant", arguments=given, span=term.span)
        if order == "1" and len(given) == count + 1:
            if term.name == "tskterm":
                markup.unsure.setdefault(_ORDER, term.span)
            return Membership(kind="linear", arguments=(*given[1:], given[0]), span=term.span)
        if order not in ("0", "1"):
            markup.error("FZ602", f"a term of order {order} is not available", term.place("order"))
            return None
        wanted = "one tskValue" if order == "0" else f"a constant and a coefficient for each of {count} inputs"
        markup.error("FZ303", f"a term of order {order} takes {wanted}, got {len(given)}", term.span)
        return None

    def _reach(self, variable: Variable) -> tuple[Number, Number]:
        """Return the range that is given, or the one of the functions over the ranges of the inputs."""
        element = variable.element
        if {"domainleft", "domainright"} <= element.attributes.keys():
            low, high = (self.markup.value(element, e) for e in ("domainleft", "domainright"))
            return low or Number(0.0), high or Number(1.0)
        supports = [ranges.reached(t.membership, self.ends) for t in variable.terms]
        low_end, high_end = ranges.of_terms(supports) or (0.0, 1.0)
        return Number(low_end), Number(high_end)
