"""Terms from lines `term: NAME Triangle 0 1 2`."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import ONE, Expr, Name, Number, names_in, replace_names
from fuzzyctl.formats.common.report import Findings, Names, ParseError, meant
from fuzzyctl.formats.common.words import ShapeWord
from fuzzyctl.formats.fll.terms import NOT_BEYOND, membership_as_computed, step_to_itself, with_places
from fuzzyctl.model.variable import Membership, Term
from fuzzyctl.support.shipped import TOO_LARGE, to_number
from tests.oracles.fll.functions import read_formula
from tests.oracles.fll.lines import Line
from tests.oracles.fll.vocabulary import TERM_WORDS, TERMS

_WORD: Final = re.compile(r"\S+")

_FORM: Final = "a term is written: term: NAME Triangle 0 1 2"


@dataclass(frozen=True)
class Place:
    """Where a term stands: its variable, and what its formula may name.

    Args:
        variable: The variable.
        inputs: The inputs in order.
        outputs: The outputs in order.
        is_input: Whether the variable is an input.
        python: Whether pyfuzzylite's numerics are asked for, and formulas are read as it reads them.
    """

    variable: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    is_input: bool
    python: bool = False

    def is_own(self, formula: Expr) -> bool:
        """Return whether a formula of an output is a fuzzy set: it names `x`, and no variable."""
        free = {*self.inputs, *self.outputs}
        return not self.is_input and "x" not in free and {n.name for n in names_in(formula)} - {"pi"} == {"x"}

    @property
    def input(self) -> str | None:
        """The variable if it is an input, over which formulas of its terms are."""
        return self.variable if self.is_input else None

    @property
    def earlier(self) -> tuple[str, ...]:
        """The outputs declared before the variable, whose values of the same step its formulas may use."""
        names = tuple(self.outputs)
        return names[: names.index(self.variable)] if self.variable in names else ()


def words(span: Span) -> list[Span]:
    """Return the words of a text with their places."""
    return [Span(span.source, m.start(), m.end()) for m in _WORD.finditer(span.source.text, span.start, span.end)]


def number(span: Span, findings: Findings) -> Number | None:
    """Return a number, which may be infinite; None for what is none."""
    try:
        value = to_number(span.text)
    except OverflowError:
        findings.error("FZ108", TOO_LARGE, span, help="write 'inf'")
        return None
    except ValueError:
        value = math.nan
    if math.isnan(value):
        findings.error("FZ601", f"'{span.text[:40]}' is not a number", span)
        return None
    return Number(value, span=span)


class TermReader:
    """Read the terms of a variable.

    Args:
        place: Where they stand.
        findings: Where mistakes go.
    """

    def __init__(self, place: Place, findings: Findings) -> None:
        self.place = place
        self.findings = findings
        self.names = Names()

    def read(self, line: Line) -> Term | None:
        """Return a term; None for one that is reported."""
        found = words(line.value)
        if len(found) < 2:
            self.findings.error("FZ601", "the term has no name or no kind", line.span, help=_FORM)
            return None
        name, kind, *rest = found
        membership = self._membership(kind, rest, line)
        if membership is None:
            return None
        return Term(name=self._name(name), membership=membership, span=name)

    def _name(self, name: Span) -> str:
        own = self.names.take(name.text)
        if own != name.text:
            message = f"a second term of '{self.place.variable}' is called '{name.text}'; it becomes '{own}'"
            self.findings.warning("FZ604", message, name, help="rules mean the first; give it a name of its own")
        return own

    def _membership(self, kind: Span, rest: list[Span], line: Line) -> Membership | None:
        if kind.text == "Function":
            return self._function(rest, line)
        if kind.text in ("Constant", "Linear", "Discrete"):
            given = self._numbers(rest)
            return None if given is None else self._special(kind.text, given, line)
        word = TERM_WORDS.get(kind.text)
        if word is None:
            message = f"there is no term '{kind.text[:40]}'"
            facts = (f"terms: {', '.join(TERMS)}",)
            self.findings.error("FZ602", message, kind, help=meant(kind.text, TERMS), facts=facts)
            return None
        given = self._numbers(rest)
        return None if given is None else self._shape(word, kind.text, given, line)

    def _numbers(self, rest: list[Span]) -> tuple[Number, ...] | None:
        given = [number(span, self.findings) for span in rest]
        return None if any(n is None for n in given) else tuple(n for n in given if n is not None)

    def _shape(self, word: ShapeWord, kind: str, given: tuple[Number, ...], line: Line) -> Membership | None:
        count = len(word.form.split())
        if len(given) < count:
            self._too_few(kind, given, word.form, line)
            return None
        self._surplus(kind, given, count + 1)
        height = given[count] if len(given) > count else ONE
        own, parameters = word.shape(tuple(n.value for n in given[:count]))
        arguments = with_places(parameters, given[:count])
        if kind == "Binary" and given[0] == given[1]:
            return step_to_itself(self.place.input, line.value, self.findings, word=kind)
        found = Membership(kind=own, arguments=arguments, height=_height(height), span=line.value)
        return self._computed(found, kind)

    def _computed(self, found: Membership, kind: str) -> Membership | None:
        return membership_as_computed(found, self.place.input, self.findings, word=kind, python=self.place.python)

    def _too_few(self, kind: str, given: tuple[Number, ...], form: str, line: Line) -> None:
        message = f"'{kind}' has {counted(len(given), 'parameter')} instead of {len(form.split())}"
        self.findings.error("FZ303", message, line.value, help=f"they are: {form}, and perhaps a height")

    def _surplus(self, kind: str, given: tuple[Number, ...], most: int) -> None:
        for extra in given[most : most + 1]:
            message = f"'{kind}' takes {counted(most, 'number')} at most; what follows has no effect"
            self.findings.warning("FZ603", message, extra.span, help="remove it")

    def _special(self, kind: str, given: tuple[Number, ...], line: Line) -> Membership | None:
        if kind == "Discrete":
            return self._discrete(given, line)
        if kind == "Constant":
            if not given:
                self._too_few(kind, given, "value", line)
                return None
            self._surplus(kind, given, 1)
            if self.place.is_input and not 0.0 <= given[0].value <= 1.0:
                message = f"the degree {given[0].value:g} lies outside [0, 1]"
                self.findings.error("FZ302", message, given[0].span or line.value, help=NOT_BEYOND)
                return None
            if self.place.is_input:  # its degree is its value, whatever the input is
                return Membership(kind="function", arguments=given[:1], span=line.value)
            return Membership(kind="constant", arguments=given[:1], span=line.value)
        due = len(self.place.inputs)
        if len(given) == due:
            given = (*given, Number(0.0))  # the constant may be left out
        if len(given) != due + 1:
            message = f"'Linear' has {counted(len(given), 'parameter')} for {counted(due, 'input')}"
            help_text = "they are: a coefficient for each input, and perhaps a constant"
            self.findings.error("FZ303", message, line.value, help=help_text)
            return None
        return Membership(kind="linear", arguments=given, span=line.value)

    def _discrete(self, given: tuple[Number, ...], line: Line) -> Membership | None:
        """Return a polygon; an odd number behind its pairs is the height."""
        if len(given) < 2:
            self._too_few("Discrete", given, "x1 y1 x2 y2", line)
            return None
        pairs = len(given) // 2 * 2
        height = given[pairs] if len(given) > pairs else ONE
        found = Membership(kind="piecewise", arguments=given[:pairs], height=_height(height), span=line.value)
        return self._computed(found, "Discrete")

    def _function(self, rest: list[Span], line: Line) -> Membership | None:
        """Return a formula: of the variable itself in a term of an input, of the inputs in one of an output."""
        if not rest:
            self.findings.error("FZ303", "'Function' has no formula", line.value, help="write, for example: sin(x) / x")
            return None
        span = rest[0].to(rest[-1])
        place = self.place
        names = {place.variable, "x"} if place.is_input else {*place.inputs, *place.earlier}
        try:
            known = {*names, "x", *place.inputs, *place.outputs}
            formula = read_formula(span, known, python=place.python, differs=self.findings.differs)
        except ParseError as error:
            self.findings.refuse(error)
            return None
        if names_in(formula) and place.is_own(formula):
            own = replace_names(formula, {"x": Name(place.variable)})
            return Membership(kind="formula", arguments=(own,), span=line.value)
        for name in names_in(formula):
            if name.name not in names and name.name != "pi":
                due = f"'{place.variable}' itself" if place.is_input else "inputs, and outputs declared before it"
                message = f"a formula of '{place.variable}' may name {due}, and this one names '{name.name}'"
                if name.name == "x":
                    message = f"a formula of output '{place.variable}' names 'x', its place, beside other variables"
                self.findings.error("FZ602", message, name.span, help="write the set as another term, such as Discrete")
                return None
        if place.is_input and "x" not in place.inputs:
            formula = replace_names(formula, {"x": Name(place.variable)})
        return Membership(kind="function", arguments=(formula,), span=line.value)


def _height(height: Number) -> Number:
    return ONE if height.value == 1 else height
