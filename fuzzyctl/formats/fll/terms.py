"""Terms of fuzzylite and MATLAB: a word, then numbers or a formula."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import ONE, ZERO, Expr, Name, Number, names_in, replace_names, span_of
from fuzzyctl.formats.common.report import Findings, Names, ParseError
from fuzzyctl.formats.common.words import ShapeWord
from fuzzyctl.formats.fll.formulas import read_formula
from fuzzyctl.formats.fll.shapes import as_computed, corners, has_step, of_input, polygon, zero
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.model.variable import Membership, Term

#: Why degrees beyond 1, which fuzzylite computes with, are refused.
NOT_BEYOND: Final = "degrees are truths between 0 and 1, and norms and proofs hold for no others; scale the term down"


@dataclass(frozen=True)
class Place:
    """The variable of a term, and the names that its formula may use.

    Args:
        variable: The variable.
        inputs: The inputs in order.
        outputs: The outputs in order.
        is_input: Whether the variable is an input.
        python: Whether formulas are read as pyfuzzylite reads them.
    """

    variable: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    is_input: bool
    python: bool = False

    def is_set(self, formula: Expr) -> bool:
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
        return self.outputs[: self.outputs.index(self.variable)] if self.variable in self.outputs else ()


@dataclass
class TermReader:
    """Makes terms of a file.

    Args:
        findings: Takes mistakes.
        fuzzylite: Whether fuzzylite computes the terms.
        fll: Whether a number behind the parameters is a height, linear consequents may lack their constant, and
            formulas may be sets.
        padded: Whether a warning of surplus zeros was given.
    """

    findings: Findings
    fuzzylite: bool = True
    fll: bool = True
    padded: bool = False

    def shape(
        self, place: Place, kind: Span, word: ShapeWord, values: tuple[Expr, ...], span: Span
    ) -> Membership | None:
        """Return a term of numbers or names of constants; report a mistake and return None.

        Args:
            place: Its variable.
            kind: Its word in the file.
            word: The meaning of the word.
            values: The parameters behind the word.
            span: The text of the term.
        """
        if word.kind == "linear":
            return self._linear(place, kind, values, span)
        listed = word.count is None
        count = word.count if word.count is not None else len(values) // 2 * 2 if self.fll else len(values)
        if len(values) < count or (listed and (len(values) < (2 if self.fll else 4) or count % 2)):
            expected = f"instead of {count}" if not listed else "and takes pairs"
            help_text = f"they are: {word.form}{', and perhaps a height' if self.fll else ''}"
            message = f"'{kind.text}' has {counted(len(values), 'parameter')} {expected}"
            self.findings.error("FZ303", message, span, help=help_text)
            return None
        most = count + (self.fll and word.kind != "constant")
        self._surplus(kind, values, most)
        height = values[count] if count < most and len(values) > count else ONE
        height = ONE if isinstance(height, Number) and height.value == 1 else height
        values = values[:count]
        numbers = tuple(n for n in values if isinstance(n, Number))
        if word.kind == "constant" and place.is_input and self.fuzzylite:  # its degree, whatever the input is
            beyond = next((n for n in numbers if not 0.0 <= n.value <= 1.0), None)
            if beyond is None:
                return Membership(kind="function", arguments=values, span=span)
            message = f"the degree {beyond.value:g} lies outside [0, 1]"
            self.findings.error("FZ302", message, beyond.span or span, help=NOT_BEYOND)
            return None
        if len(numbers) < len(values):
            return self._of_names(kind, word, values, height, span)
        if self.fuzzylite and word.form == "start direction" and values[0] == values[1]:
            return step_to_itself(place.input, span, self.findings, word=kind.text)
        name, parameters = word.shape(tuple(n.value for n in numbers))
        membership = Membership(kind=name, arguments=with_places(parameters, numbers), height=height, span=span)
        if not self.fuzzylite:
            return membership
        return membership_as_computed(membership, place.input, self.findings, word=kind.text, python=place.python)

    def _of_names(
        self, kind: Span, word: ShapeWord, values: tuple[Expr, ...], height: Expr, span: Span
    ) -> Membership | None:
        """Return a term with names of constants among its parameters; a step needs its direction as a number."""
        if word.form == "start direction":
            self.findings.error("FZ302", f"'{kind.text}' needs two numbers: {word.form}", span)
            return None
        ordered = enumerate(word.ordered(values))
        arguments = tuple(_doubled(a) if i in word.doubled else a for i, a in ordered)
        return Membership(kind=word.kind, arguments=arguments, height=height, span=span)

    def _surplus(self, kind: Span, values: Sequence[Expr], most: int) -> None:
        """Warn of numbers without effect; of zeros with which old versions of MATLAB fill up only once."""
        surplus = values[most:]
        zeros = not self.fll and all(n == ZERO for n in surplus)
        if not surplus or (zeros and self.padded):
            return
        self.padded |= zeros
        first, last = span_of(surplus[0]), span_of(surplus[-1])
        assert first is not None
        place = first.to(last or first)
        message = f"'{kind.text}' takes {counted(most, 'number')}; '{place.text[:40]}' has no effect"
        facts = ("old versions fill up with zeros; those of other functions are not listed",) if zeros else ()
        self.findings.warning("FZ603", message, place, help="remove it", facts=facts)

    def _linear(self, place: Place, kind: Span, values: tuple[Expr, ...], span: Span) -> Membership | None:
        """Return a sum over the inputs: a coefficient for each, and a constant."""
        count = len(place.inputs) + 1
        if self.fll and len(values) == count - 1:
            values = (*values, ZERO)
        if len(values) < count or (self.fll and len(values) > count):
            message = f"'{kind.text}' has {counted(len(values), 'parameter')} for {counted(count - 1, 'input')}"
            constant = "perhaps" if self.fll else "then"
            help_text = f"they are: a coefficient for each input, and {constant} a constant"
            self.findings.error("FZ303", message, span, help=help_text)
            return None
        self._surplus(kind, values, count)
        return Membership(kind="linear", arguments=values[:count], span=span)

    def formula(self, place: Place, text: Span, span: Span) -> Membership | None:
        """Return a formula: of the variable itself in a term of an input, of the inputs in one of an output."""
        x = {"x"} - {*place.inputs}  # the place of the variable, unless an input has this name
        names = {place.variable, *x} if place.is_input else {*place.inputs, *place.earlier}
        readable = {*names, "x", *place.inputs, *place.outputs} if self.fll else names
        try:
            formula = read_formula(text, readable, python=place.python, differs=self.findings.differs)
        except ParseError as error:
            self.findings.refuse(error)
            return None
        if self.fll and place.is_set(formula):
            formula = replace_names(formula, {"x": Name(place.variable)})
            return Membership(kind="formula", arguments=(formula,), span=span)
        for name in names_in(formula):
            if name.name not in names and name.name != "pi":
                self._refuse_name(place, name)
                return None
        if place.is_input and x:
            formula = replace_names(formula, {"x": Name(place.variable)})
        return Membership(kind="function", arguments=(formula,), span=span)

    def _refuse_name(self, place: Place, name: Name) -> None:
        allowed = f"'{place.variable}' itself" if place.is_input else "inputs, and outputs declared before it"
        message = f"a formula of '{place.variable}' may name {allowed}, and this one names '{name.name}'"
        if name.name == "x":
            message = f"a formula of output '{place.variable}' names 'x', its place, beside other variables"
        self.findings.error("FZ602", message, name.span, help="write the set as another term, such as Discrete")


def _doubled(expr: Expr) -> Expr:
    return Number(2.0 * expr.value, "", expr.span) if isinstance(expr, Number) else 2.0 * expr


def told_apart(terms: Sequence[Term], variable: str, findings: Findings, help: str) -> list[Term]:
    """Return terms with different names; report new names once for a variable, as tools give all the same name."""
    names = Names()
    renamed = [t.model_copy(update={"name": names.take(t.name)}) for t in terms]
    changes = [(old, new) for old, new in zip(terms, renamed, strict=True) if old.name != new.name]
    if changes:
        (old, new), *others = changes
        message = f"a second term of '{variable}' is called '{old.name}'; it becomes '{new.name}'"
        facts = (f"and so on, {counted(len(others), 'more term')}",) if others else ()
        findings.warning("FZ604", message, old.span, help=help, facts=facts)
    return renamed


# --- terms as fuzzylite computes them ------------------------------------------------------------------------------


def membership_as_computed(
    membership: Membership, variable: str | None, findings: Findings, *, word: str, python: bool = False
) -> Membership | None:
    """Return a membership function as fuzzylite computes it, with a warning; report a mistake and return None.

    Args:
        membership: The membership function of the file.
        variable: The input of the term; None for a term of an output.
        findings: Takes the warning, or the mistake.
        word: Its word in the file.
        python: Whether pyfuzzylite computes it.
    """
    values = tuple(a.value for a in membership.arguments if isinstance(a, Number))
    if len(values) < len(membership.arguments) or not isinstance(membership.height, Number):
        return membership
    kind, height, span = membership.kind, membership.height.value, membership.span
    if not 0.0 <= height <= 1.0:
        message = f"the height {height:g} of '{word}' lies outside [0, 1]"
        findings.error("FZ302", message, membership.height.span or span, help=NOT_BEYOND)
        return None
    mistake = MEMBERSHIP[kind].mistake(values)
    substitute = of_input(zero, variable) if height == 0.0 else as_computed(kind, values, variable)
    if substitute is None and mistake is not None:
        return membership
    if substitute is None:
        return _with_jumps(membership, values, findings, word, python=python)
    reason = mistake or ("its height is 0" if height == 0.0 else "its left side has no width")
    message = f"'{word}': {reason}; it is read as fuzzylite computes it, {substitute.description}"
    findings.warning("FZ609", message, span, help="other tools refuse it, or take it for something else")
    kind, arguments, height = substitute.kind, substitute.arguments, height * substitute.share
    if kind == "function":  # formulas have no height
        arguments, height = (height * arguments[0] if height not in (0.0, 1.0) else arguments[0],), 1.0
    return Membership(kind=kind, arguments=arguments, height=Number(height) if height != 1.0 else ONE, span=span)


def _with_jumps(
    membership: Membership, values: tuple[float, ...], findings: Findings, word: str, *, python: bool
) -> Membership | None:
    """Return a term with the degrees of fuzzylite at its jumps; warn if its two engines differ."""
    if has_step(membership.kind, values):
        findings.error("FZ302", f"'{word}' has no width, so that it is 0 everywhere", membership.span)
        return None
    if membership.kind != "piecewise":
        return membership
    both = zip(corners(values, python=False), corners(values, python=True), strict=True)
    difference = next(((a, b) for a, b in both if a.degree != b.degree), None)
    if not python and difference is not None:
        corner, other = difference
        jump = f"'{word}' jumps at {corner.place:.6g} from {corner.first:.6g} to {corner.last:.6g}"
        message = f"{jump}; there it is {corner.degree:.6g}, as fuzzylite computes it"
        help_text = f"pyfuzzylite has {other.degree:.6g} there; move one of the points, if it is to be the same"
        findings.warning("FZ609", message, membership.span, help=help_text)
    points = polygon(values, python=python)
    return membership if points == values else membership.model_copy(update={"arguments": tuple(map(Number, points))})


def with_places(parameters: Sequence[float], numbers: Sequence[Number]) -> tuple[Number, ...]:
    """Return parameters with the places of the numbers in the file that they are, up to signs; each place once."""
    places: dict[float, deque[Span | None]] = defaultdict(deque)
    for number in numbers:
        places[number.value].append(number.span)
    result = []
    for value in parameters:
        spans = places.get(value) or places.get(-value)
        result.append(Number(value, span=spans.popleft() if spans else None))
    return tuple(result)


def step_to_itself(variable: str | None, span: Span, findings: Findings, *, word: str) -> Membership | None:
    """Return fuzzylite's step from a place towards that place, with a warning; it is a mistake in an output."""
    substitute, problem = of_input(zero, variable), f"'{word}' has its start as its direction"
    if substitute is None:
        findings.error("FZ302", f"{problem}, so that it is 0 everywhere", span)
        return None
    message = f"{problem}; it is read as fuzzylite computes it, {substitute.description}"
    findings.warning("FZ609", message, span)
    return Membership(kind=substitute.kind, arguments=substitute.arguments, span=span)
