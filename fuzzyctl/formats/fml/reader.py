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
from fuzzyctl.formats.fml.document import Element, Markup, one_line, parse_document
from fuzzyctl.formats.fml.rules import RuleReader, Variable
from fuzzyctl.formats.fml.shapes import SHAPE_NAMES, Ends, complement, read_shape
from fuzzyctl.formats.fml.vocabulary import ACCUMULATION_WORDS, DEFUZZIFIER_WORDS
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import OVER_RULES, Defuzzifier
from fuzzyctl.model.profiles import profile
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Membership, Term

_ROOTS: Final = ("fuzzysystem", "fuzzycontroller")
#: Names of the rule bases that the writer makes for rules in no block.
_WRITTEN: Final = re.compile(r"(rules\d*)?")
_RULE_BASES: Final = ("mamdanirulebase", "tskrulebase", "tsukamotorulebase", "rulebase", "anyarulebase")
_FUNCTIONS: Final = ("tskvariable", "takagisugenovariable")
_VARIABLES: Final = ("fuzzyvariable", "tsukamotovariable", "aggregatedfuzzyvariable", *_FUNCTIONS, "anyadatacloud")
_COMMON: Final = ("name", "scale", "type", "domainleft", "domainright")
_TYPES: Final = {"INPUT": "input", "OUTPUT": "output"}
_AVERAGE: Final = {"WA": "weighted_average"}

#: Elements that join the parts of a definition.
_JOINED: Final = ("and", "or")

_AVERAGED: Final = ("singleton", "constant", "linear", "function")

_SUM: Final = "SUM is the plain sum of sets, as in drafts of FML; the standard has BSUM, min(1, a + b)"
_ORDER: Final = "terms of order 1: the first tskValue is the constant, as in JFML; FuzzyLogic.jl takes the last"


def read(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Return the system of an FML document, None after errors, and all diagnostics."""
    root, diagnostics = parse_document(source)
    if root is None:
        return None, diagnostics
    tags = (e.tag for e in _all(root) if e.name in SHAPE_NAMES)
    markup = Markup(source, draft=next((tag[0].isupper() for tag in tags), False))
    if root.name not in _ROOTS:
        message = f"the document is <{root.tag}>, not <fuzzySystem>, so it is not FML"
        markup.error("FZ004", message, root.span, help="FML of IEEE 1855 begins with <fuzzySystem name=...>")
        return None, markup.diagnostics
    markup.check_parts(root, ("name",), ("knowledgebase", *_RULE_BASES, "inferenceengine"))
    bases = list(root.all("knowledgebase"))
    if len(bases) != 1:
        message = f"<{root.tag}> has {'no' if not bases else 'several'} <knowledgeBase>"
        markup.error("FZ212" if not bases else "FZ215", message, root.span, help="put all variables into one")
        return None, markup.in_order()
    _Document(root, bases[0], markup).translate()
    markup.report_doubts()
    return markup.system(), markup.in_order()


def _all(root: Element) -> Iterator[Element]:
    """Yield an element and all elements in it, in no order."""
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
        markup: Takes the statements and diagnostics.
    """

    def __init__(self, root: Element, base: Element, markup: Markup) -> None:
        self.root, self.markup = root, markup
        markup.check_parts(base, ("name",), _VARIABLES)
        elements = list(base.all(*_VARIABLES))
        # Functions come last, since they are over all inputs.
        sets = [self._variable(e) for e in elements if e.name not in _FUNCTIONS]
        self.ends = [(v.ends[0].value, v.ends[1].value) for v in sets if v is not None and v.keyword == "input"]
        functions = [self._functions(e) for e in elements if e.name in _FUNCTIONS]
        place = {id(e): k for k, e in enumerate(elements)}
        self.variables = [v for v in (*sets, *functions) if v is not None]
        self.variables.sort(key=lambda v: place[id(v.element)])

    def translate(self) -> None:
        """Add all statements."""
        root, markup, place = self.root, self.markup, self.root.span
        variables = {v.name.text: v for v in reversed(self.variables)}
        modifiers = {e.attributes.get("modifier", "").strip().lower() for e in _all(root)}
        rules = RuleReader(variables, markup, modifiers)
        for element in root.all(*_RULE_BASES):
            rules.read(element)
        outputs = [v for v in self.variables if v.keyword == "output"]
        self._require_parts(bool(rules.blocks))
        sets = [o.name.text for o in outputs if not o.method["defuzzifier"].over_rules]
        keep = not all(_WRITTEN.fullmatch(b.name) for b in rules.blocks)
        arrangement = arranged(rules.blocks, sets, keep=keep)
        markup.statements += rules.hedges()
        knobs = {"extremely": "cube"} if "extremely" in rules.modifiers else {}
        name = one_line(root.attributes.get("name", "")) or PurePath(markup.source.name).stem
        markup.head(name, "", place, profile("exact"), knobs)
        method = {**arrangement.method, **(outputs[0].method if outputs else {})}
        markup.statements += settings(method, place)
        method = {"implication": "min", **method}
        for variable in self.variables:
            implication = arrangement.implications.get(variable.name.text, method["implication"])
            fields = {"implication": implication, **variable.method}
            self._add(variable, {n: v for n, v in fields.items() if v != method.get(n)})
        markup.rules(arrangement)

    def _require_parts(self, has_rules: bool) -> None:
        markup, place = self.markup, self.root.span
        keywords = {v.keyword for v in self.variables}
        if any(e.name == "anyadatacloud" for e in _all(self.root)):  # reported instead of an input
            keywords.add("input")
        for keyword in ("input", "output"):
            if keyword not in keywords:
                help_text = f'add: <fuzzyVariable type="{keyword}" ...>'
                markup.error("FZ212", f"the knowledge base has no {keyword}", place, help=help_text)
        if not has_rules and not markup.failed:
            markup.error("FZ212", "the document has no rule", place, help="add: <mamdaniRuleBase ...>")

    def _add(self, variable: Variable, fields: dict[str, Any]) -> None:
        """Add a variable with settings; rules may name one of defined terms, which is not part of the system."""
        markup, element = self.markup, variable.element
        name, place = variable.name, element.span
        clauses = list[sx.Clause]()
        valid = {*(t.name for t in variable.terms), *(variable.defined if variable.keyword else ())}
        unread = [w for w in variable.words if w.text not in valid]
        if not variable.keyword:
            markup.left_out.add(name.text)
        else:
            scale = element.attributes.get("scale", "").strip()
            clauses.append(sx.UnitClause("" if scale.lower() == "null" else scale, place))
        if variable.keyword == "output":
            clauses += [sx.SettingClause(setting(n, v, place), place) for n, v in fields.items()]
            clauses.append(fallback(markup.number_of(element, "defaultvalue", Number(0.0)) or ZERO, place))
        keyword = variable.keyword or "output"
        markup.variable(keyword, name, variable.ends, variable.terms, clauses, unread=unread, place=place)

    # --- variables of sets -------------------------------------------------------------------------------------

    def _range(self, element: Element) -> tuple[Number, Number]:
        low, high = (self.markup.number_of(element, end) for end in ("domainleft", "domainright"))
        return low or ZERO, high or Number(1.0)

    def _variable(self, element: Element) -> Variable | None:
        markup = self.markup
        if element.name == "anyadatacloud":
            markup.error("FZ602", "AnYa data clouds are not available", element.span)
            return None
        is_defined, is_tsukamoto = (element.name == f"{k}variable" for k in ("aggregatedfuzzy", "tsukamoto"))
        more = () if is_defined else (*_COMMON, "accumulation", "defuzzifier", "defaultvalue", "combination")
        term_tag = element.name.replace("variable", "term")
        markup.check_parts(element, more or ("name", "type"), (term_tag,))
        name = markup.name_of(element)
        ends = (ZERO, Number(1.0)) if is_defined else self._range(element)
        if name is None:
            return None
        variable, names = Variable(element, name, "", ends), Names()
        if is_defined:
            for term in element.all(term_tag):
                word = self._term_name(term, variable, names, _JOINED)
                if word is not None:
                    variable.defined[word.text] = term
            return variable
        # Places are clamped to the range, so that a consequent may be flat beyond it; only so it can be inverted.
        limits = (-math.inf, math.inf) if is_tsukamoto else (ends[0].value, ends[1].value)
        for term in element.all("fuzzyterm", "tsukamototerm"):
            self._term(term, variable, names, limits)
        if not variable.words:
            markup.error("FZ212", f"'{name.text}' has no terms", element.span, help="add: <fuzzyTerm ...>")
        type_word = element.attributes.get("type", "output" if is_tsukamoto else "input").strip().upper()
        keyword = markup.look_up(element.place("type"), _TYPES, "type", word=type_word, code="FZ213")
        variable.keyword = keyword or _TYPES[closest(type_word, list(_TYPES)) or "INPUT"]
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
        aggregation = markup.choice(element, "accumulation", ACCUMULATION_WORDS, "max", "accumulation")
        if aggregation == "sum":
            markup.doubt(_SUM, element.place("accumulation"))
        aggregation = "sum" if kind in OVER_RULES else aggregation
        variable.method = {"aggregation": aggregation, "defuzzifier": Defuzzifier(kind=kind)}

    def _term_name(
        self,
        term: Element,
        variable: Variable,
        names: Names,
        children: Sequence[str],
        attributes: Sequence[str] = ("complement", "order"),
    ) -> sx.Word | None:
        """Return the unique name of a term; None, with an error, if it has no name."""
        name = self.markup.name_of(term)
        self.markup.check_parts(term, ("name", *attributes), children)
        if name is None:
            return None
        word = sx.Word(names.take(name.text), term.span)
        if word.text != name.text:
            message = f"'{variable.name.text}' has two terms '{name.text}'; rules mean the first one"
            help_text = f"the second is called '{word.text}' here; rename it"
            self.markup.warning("FZ604", message, name.span, help=help_text)
        variable.words.append(word)
        return word

    def _term(self, term: Element, variable: Variable, names: Names, limits: Ends) -> None:
        markup = self.markup
        name = self._term_name(term, variable, names, [c.name for c in term.children])
        if name is None:
            return
        shapes = [c for c in term.children if not c.foreign or c.name in SHAPE_NAMES]
        if len(shapes) != 1:
            message = f"term '{name.text}' has {'no shape' if not shapes else 'several shapes'}"
            markup.error("FZ601", message, term.span, help="give it one, such as <triangularShape .../>")
            return
        if shapes[0].name == "circulardefinition":
            markup.check_parts(shapes[0], (), _JOINED)
            variable.defined[name.text] = shapes[0]
            return
        membership = read_shape(shapes[0], markup, limits)
        if membership is None:
            return
        if markup.is_true(term, "complement"):
            opposite = complement(membership)
            if opposite is None:
                variable.negated.add(name.text)
            membership = opposite or membership
        variable.terms.append(Term(name=name.text, membership=membership, span=term.span))

    # --- variables whose terms are functions of the inputs -----------------------------------------------------

    def _functions(self, element: Element) -> Variable | None:
        markup = self.markup
        markup.check_parts(element, (*_COMMON, "combination", "defaultvalue"), ("tskterm", "sugenoterm"))
        markup.choice(element, "combination", _AVERAGE, "")
        name = markup.name_of(element)
        if name is None:
            return None
        variable, names = Variable(element, name, "output"), Names()
        params = [f"param{i}" for i in range(len(self.ends) + 1)]
        for term in element.all("tskterm", "sugenoterm"):
            parts = (("tskvalue",),) if term.name == "tskterm" else ((), params)
            word = self._term_name(term, variable, names, *parts)
            membership = self._function(term, params) if word is not None else None
            if word is not None and membership is not None:
                variable.terms.append(Term(name=word.text, membership=membership, span=term.span))
        if {"domainleft", "domainright"} <= element.attributes.keys():
            variable.ends = self._range(element)
        else:
            reached = [ranges.reached(t.membership, self.ends) for t in variable.terms]
            low, high = ranges.of_terms(reached) or (0.0, 1.0)
            variable.ends = Number(low), Number(high)
        return variable

    def _function(self, term: Element, params: Sequence[str]) -> Membership | None:
        markup, span = self.markup, term.span
        if term.name == "sugenoterm":
            texts = [term.attributes[p] for p in params if p in term.attributes]
            numbers = [markup.finite_number(text, "a parameter", span) for text in texts]
            order = "1"
        else:
            numbers = [markup.finite_number(v.text, "<tskValue>", v.span) for v in term.all("tskvalue")]
            order = term.attributes.get("order", "0" if len(numbers) == 1 else "1").strip()
        values = tuple(n for n in numbers if n is not None)
        if len(values) < len(numbers):
            return None
        if order == "0" and len(values) == 1:
            return Membership(kind="constant", arguments=values, span=span)
        if order == "1" and len(values) == len(params):
            if term.name == "tskterm":
                markup.doubt(_ORDER, span)
            return Membership(kind="linear", arguments=(*values[1:], values[0]), span=span)
        if order not in ("0", "1"):
            markup.error("FZ602", f"a term of order {order} is not available", term.place("order"))
            return None
        parts = f"a constant and a coefficient for each of {len(self.ends)} inputs"
        wanted = "one tskValue" if order == "0" else parts
        markup.error("FZ303", f"a term of order {order} takes {wanted}, got {len(values)}", span)
        return None
