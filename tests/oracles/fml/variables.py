"""Inputs, outputs and composed terms from an FML knowledge base."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import Expr, Number
from fuzzyctl.formats.common import ranges
from fuzzyctl.formats.common.report import Names
from fuzzyctl.model.method import Defuzzifier
from fuzzyctl.model.variable import Input, Membership, Output, Term
from tests.oracles.fml.document import Element
from tests.oracles.fml.names import ACCUMULATION_WORDS, DEFUZZIFIER_WORDS, SHAPES
from tests.oracles.fml.scope import Scope
from tests.oracles.fml.shapes import complement, shape_of

_VARIABLES: Final = (
    *("fuzzyvariable", "tskvariable", "tsukamotovariable", "aggregatedfuzzyvariable", "takagisugenovariable"),
    *("anyadatacloud",),
)
_TERMS: Final = ("fuzzyterm", "tsukamototerm")
_COMMON: Final = ("name", "scale", "type", "domainleft", "domainright")

#: What joins the parts of a definition.
_JOINED: Final = ("and", "or")

_AVERAGED: Final = ("singleton", "constant", "linear", "function")


@dataclass
class KnowledgeBase:
    """The variables of a system.

    Args:
        inputs: In the order written.
        outputs: In the order written.
        defined: Elements that define a term by others, by variable and term: circular definitions and aggregated terms.
        negated: Terms whose complement is meant, and that have no function of their own for it.
        terms: Names of the terms of every variable, those with mistakes included.
    """

    inputs: list[Input] = field(default_factory=list)
    outputs: list[Output] = field(default_factory=list)
    defined: dict[tuple[str, str], Element] = field(default_factory=dict)
    negated: set[tuple[str, str]] = field(default_factory=set)
    terms: dict[str, list[str]] = field(default_factory=dict)


class VariableReader:
    """Reads the variables of a knowledge base.

    Args:
        scope: Where mistakes go.
    """

    def __init__(self, scope: Scope) -> None:
        self._scope = scope
        self._base = KnowledgeBase()
        self._names: dict[str, Names] = {}

    def read(self, element: Element) -> KnowledgeBase:
        """Return the variables; functions of inputs come last, since they are over all inputs."""
        self._scope.known(element, ("name",), _VARIABLES)
        functions = ("tskvariable", "takagisugenovariable")
        for variable in element.all(*_VARIABLES):
            if variable.name not in functions:
                self._variable(variable)
        order = {" ".join(e.attributes.get("name", "").split()): i for i, e in enumerate(element.all(*_VARIABLES))}
        for variable in element.all(*functions):
            self._tsk(variable)
        self._base.outputs.sort(key=lambda o: order.get(o.name, 0))
        return self._base

    def _variable(self, element: Element) -> None:
        if element.name == "anyadatacloud":
            self._scope.error("FZ602", "AnYa data clouds are not available", element.span)
        elif element.name == "aggregatedfuzzyvariable":
            self._aggregated(element)
        else:
            self._fuzzy(element)

    def _name(self, element: Element) -> str | None:
        name = self._scope.required(element, "name")
        if name is not None and name in self._base.terms:
            message = f"'{name}' is declared twice"
            self._scope.error("FZ201", message, element.place("name"), help="rename one of them")
            return None
        if name is not None:
            self._base.terms[name] = []
        return name

    def _fuzzy(self, element: Element) -> None:
        tsukamoto = element.name == "tsukamotovariable"
        more = ("accumulation", "defuzzifier", "defaultvalue", "combination")
        self._scope.known(element, (*_COMMON, *more), ("tsukamototerm",) if tsukamoto else ("fuzzyterm",))
        name = self._name(element)
        low, high = self._scope.number(element, "domainleft"), self._scope.number(element, "domainright")
        if name is None:
            return
        lower, upper = low or Number(0.0), high or Number(1.0)
        # Places are clamped to the range, so that a consequent may be flat beyond it; only so it can be inverted.
        flat_up_to = (-math.inf, math.inf) if tsukamoto else (lower.value, upper.value)
        terms = self._terms(element, name, flat_up_to)
        unit = element.attributes.get("scale", "").strip()
        unit = "" if unit.lower() == "null" else unit
        kind = element.attributes.get("type", "output" if tsukamoto else "input").strip().lower()
        if kind == "input":
            self._base.inputs.append(
                Input(name=name, unit=unit, lower=lower, upper=upper, terms=terms, span=element.span)
            )
        elif kind == "output":
            self._base.outputs.append(self._output(element, name, unit, (lower, upper), terms))
        else:
            message = f"the type of '{name}' is '{kind}', neither input nor output"
            self._scope.error("FZ213", message, element.place("type"), help='write: type="input"')

    def _output(
        self, element: Element, name: str, unit: str, ends: tuple[Expr, Expr], terms: tuple[Term, ...]
    ) -> Output:
        kind = "tsukamoto"
        if element.name != "tsukamotovariable":
            kind = self._scope.choice(element, "defuzzifier", DEFUZZIFIER_WORDS, "centroid")
        else:
            self._require_average(element)
        if kind != "tsukamoto" and terms and all(t.membership.kind in _AVERAGED for t in terms):
            message = f"the terms of '{name}' are numbers, so their average is taken"
            self._scope.warning("FZ603", message, element.place("defuzzifier"), help="give it fuzzy sets, or tskTerms")
            kind = "weighted_average"
        return Output(
            name=name,
            unit=unit,
            lower=ends[0],
            upper=ends[1],
            terms=terms,
            otherwise=self._default(element),
            aggregation=self._accumulation(element),
            defuzzifier=Defuzzifier(kind=kind),
            span=element.span,
        )

    def _accumulation(self, element: Element) -> str:
        found = self._scope.choice(element, "accumulation", ACCUMULATION_WORDS, "max")
        if found == "sum":
            message = "SUM is the plain sum of sets, as in drafts of FML; the standard has BSUM, min(1, a + b)"
            self._scope.unsure.setdefault(message, element.place("accumulation"))
        return found

    def _require_average(self, element: Element) -> None:
        self._scope.choice(element, "combination", {"WA": "weighted_average"}, "weighted_average")

    def _default(self, element: Element) -> Expr:
        """Return what an output is where no rule fires; 0 where nothing is said, as the standard has it."""
        if not element.attributes.get("defaultvalue", "").strip():
            return Number(0.0)
        return self._scope.number(element, "defaultvalue") or Number(0.0)

    def _terms(self, element: Element, variable: str, domain: tuple[float, float]) -> tuple[Term, ...]:
        found: list[Term] = []
        for term in element.all(*_TERMS):
            name = self._term_name(term, variable, [c.name for c in term.children])
            if name is None:
                continue
            shapes = [c for c in term.children if not c.foreign or c.name in SHAPES]
            if len(shapes) != 1:
                message = f"term '{name}' has {'no shape' if not shapes else 'several shapes'}"
                self._scope.error("FZ601", message, term.span, help="give it one, such as <triangularShape .../>")
            elif shapes[0].name == "circulardefinition":
                self._scope.known(shapes[0], (), _JOINED)
                self._base.defined[variable, name] = shapes[0]
            else:
                self._shaped(term, shapes[0], (variable, name), domain, found)
        if not self._base.terms[variable]:
            self._scope.error("FZ212", f"'{variable}' has no terms", element.span, help="add: <fuzzyTerm ...>")
        return tuple(found)

    def _term_name(
        self, term: Element, variable: str, children: Sequence[str], attributes: Sequence[str] = ("complement", "order")
    ) -> str | None:
        """Return the name that a term has here; None, with an error, for one without."""
        name = self._scope.required(term, "name")
        self._scope.known(term, ("name", *attributes), children)
        if name is None:
            return None
        own = self._names.setdefault(variable, Names()).take(name)
        if own != name:
            message = f"'{variable}' has two terms '{name}'; rules mean the first one"
            help_text = f"the second is called '{own}' here; rename it"
            self._scope.warning("FZ604", message, term.place("name"), help=help_text)
        self._base.terms[variable].append(own)
        return own

    def _shaped(
        self, term: Element, shape: Element, key: tuple[str, str], domain: tuple[float, float], found: list[Term]
    ) -> None:
        membership = shape_of(shape, self._scope, domain)
        if membership is None:
            return
        complemented = term.attributes.get("complement", "false").strip().lower()
        if complemented not in ("true", "false", ""):
            message = f"'complement' is '{complemented}', neither true nor false"
            self._scope.error("FZ213", message, term.place("complement"))
        elif complemented == "true":
            other = complement(membership)
            if other is None:
                self._base.negated.add(key)
            membership = other or membership
        found.append(Term(name=key[1], membership=membership, span=term.span))

    def _aggregated(self, element: Element) -> None:
        self._scope.known(element, ("name", "type"), ("aggregatedfuzzyterm",))
        variable = self._name(element)
        if variable is None:
            return
        for term in element.all("aggregatedfuzzyterm"):
            name = self._term_name(term, variable, _JOINED)
            if name is not None:
                self._base.defined[variable, name] = term

    def _tsk(self, element: Element) -> None:
        """Read an output whose terms are functions of the inputs."""
        self._scope.known(element, (*_COMMON, "combination", "defaultvalue"), ("tskterm", "sugenoterm"))
        self._require_average(element)
        name = self._name(element)
        if name is None:
            return
        terms = []
        for term in element.all("tskterm", "sugenoterm"):
            term_name = self._function_name(term, name)
            made = self._function(term) if term_name is not None else None
            if term_name is not None and made is not None:
                terms.append(Term(name=term_name, membership=made, span=term.span))
        lower, upper = self._tsk_range(element, tuple(terms))
        self._base.outputs.append(
            Output(
                name=name,
                unit=element.attributes.get("scale", "").strip().replace("null", ""),
                lower=lower,
                upper=upper,
                terms=tuple(terms),
                otherwise=self._default(element),
                defuzzifier=Defuzzifier(kind="weighted_average"),
                span=element.span,
            )
        )

    def _function_name(self, term: Element, variable: str) -> str | None:
        if term.name == "tskterm":
            return self._term_name(term, variable, ("tskvalue",))
        return self._term_name(term, variable, (), [f"param{i}" for i in range(len(self._base.inputs) + 1)])

    def _function(self, term: Element) -> Membership | None:
        count = len(self._base.inputs)
        if term.name == "sugenoterm":
            written = [term.attributes[f"param{i}"] for i in range(count + 1) if f"param{i}" in term.attributes]
            values = [self._scope.parsed(v, "a parameter", term.span) for v in written]
            order = "1"
        else:
            values = [self._scope.parsed(v.text, "<tskValue>", v.span) for v in term.all("tskvalue")]
            order = term.attributes.get("order", "0" if len(values) == 1 else "1").strip()
        if any(v is None for v in values):
            return None
        given = [v for v in values if v is not None]
        if order == "0" and len(given) == 1:
            return Membership(kind="constant", arguments=(given[0],), span=term.span)
        if order == "1" and len(given) == count + 1:
            message = "terms of order 1: the first tskValue is the constant, as in JFML; FuzzyLogic.jl takes the last"
            if term.name == "tskterm":
                self._scope.unsure.setdefault(message, term.span)
            return Membership(kind="linear", arguments=(*given[1:], given[0]), span=term.span)
        if order not in ("0", "1"):
            self._scope.error("FZ602", f"a term of order {order} is not available", term.place("order"))
            return None
        wanted = "one tskValue" if order == "0" else f"a constant and a coefficient for each of {count} inputs"
        self._scope.error("FZ303", f"a term of order {order} takes {wanted}, got {len(given)}", term.span)
        return None

    def _tsk_range(self, element: Element, terms: tuple[Term, ...]) -> tuple[Expr, Expr]:
        """Return the range that is given, or the one of the functions over the ranges of the inputs."""
        if {"domainleft", "domainright"} <= element.attributes.keys():
            low, high = self._scope.number(element, "domainleft"), self._scope.number(element, "domainright")
            return low or Number(0.0), high or Number(1.0)
        ends = [
            (i.lower.value, i.upper.value)
            for i in self._base.inputs
            if isinstance(i.lower, Number) and isinstance(i.upper, Number)
        ]
        values = ([a.value for a in t.membership.arguments if isinstance(a, Number)] for t in terms)
        supports = [ranges.linear_range(given, ends) for given in values]
        low_end, high_end = ranges.of_terms(supports) or (0.0, 1.0)
        return Number(low_end), Number(high_end)


def unknown(kind: str, name: str, known: list[str]) -> tuple[str, tuple[str, ...], str]:
    """Return message, facts and help for a name that is not declared."""
    return f"no {kind} '{name}'", (f"{kind}s: {listed(known)}",) if known else (), did_you_mean(name, known)
