"""Terms of fuzzylite and MATLAB: a word, then numbers or a formula."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import ONE, ZERO, Expr, Name, Number, names_in, replace_names, span_of
from fuzzyctl.formats.common.report import Findings, Names, ParseError
from fuzzyctl.formats.common.shape_words import ShapeWord
from fuzzyctl.formats.fll.formulas import read_formula
from fuzzyctl.formats.fuzzylite.degenerate_terms import NOT_BEYOND, membership_as_computed, step_to_itself, with_places
from fuzzyctl.model.variable import Membership, Term


@dataclass(frozen=True)
class Place:
    """Where a term stands: its variable, and what its formula may name.

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


@dataclass
class TermReader:
    """Makes terms of a file.

    Args:
        findings: Where mistakes go.
        fuzzylite: Whether terms are as fuzzylite computes them.
        fll: Whether a number behind the parameters is a height, linear consequents may lack their constant, and
            formulas may be sets.
    """

    findings: Findings
    fuzzylite: bool = True
    fll: bool = True
    padded: bool = False

    def shape(
        self, place: Place, kind: Span, word: ShapeWord, given: tuple[Expr, ...], span: Span
    ) -> Membership | None:
        """Return a term of numbers, or names of constants, None for one that is reported.

        Args:
            place: Where it stands.
            kind: What the file calls it.
            word: What that means.
            given: What stands behind it.
            span: All of it.
        """
        if word.kind == "linear":
            return self._linear(place, kind, given, span)
        listed = word.count is None
        count = word.count if word.count is not None else len(given) // 2 * 2 if self.fll else len(given)
        if len(given) < count or (listed and (len(given) < (2 if self.fll else 4) or count % 2)):
            due = f"instead of {count}" if not listed else "and takes pairs"
            help_text = f"they are: {word.form}{', and perhaps a height' if self.fll else ''}"
            message = f"'{kind.text}' has {counted(len(given), 'parameter')} {due}"
            self.findings.error("FZ303", message, span, help=help_text)
            return None
        most = count + (self.fll and word.kind != "constant")
        self._surplus(kind, given, most)
        height = given[count] if count < most and len(given) > count else ONE
        height = ONE if isinstance(height, Number) and height.value == 1 else height
        given = given[:count]
        numbers = tuple(n for n in given if isinstance(n, Number))
        if word.kind == "constant" and place.is_input and self.fuzzylite:  # its degree, whatever the input is
            beyond = next((n for n in numbers if not 0.0 <= n.value <= 1.0), None)
            if beyond is None:
                return Membership(kind="function", arguments=given, span=span)
            message = f"the degree {beyond.value:g} lies outside [0, 1]"
            self.findings.error("FZ302", message, beyond.span or span, help=NOT_BEYOND)
            return None
        if len(numbers) < len(given):
            return self._of_names(kind, word, given, height, span)
        if self.fuzzylite and word.form == "start direction" and given[0] == given[1]:
            return step_to_itself(place.input, span, self.findings, word=kind.text)
        own, parameters = word.shape(tuple(n.value for n in numbers))
        made = Membership(kind=own, arguments=with_places(parameters, numbers), height=height, span=span)
        if not self.fuzzylite:
            return made
        return membership_as_computed(made, place.input, self.findings, word=kind.text, python=place.python)

    def _of_names(
        self, kind: Span, word: ShapeWord, given: tuple[Expr, ...], height: Expr, span: Span
    ) -> Membership | None:
        """Return a term with constants by their names among its parameters; a step needs its direction as a number."""
        if word.form == "start direction":
            self.findings.error("FZ302", f"'{kind.text}' needs two numbers: {word.form}", span)
            return None
        ordered = enumerate(word.ordered(given))
        arguments = tuple(_doubled(a) if i in word.doubled else a for i, a in ordered)
        return Membership(kind=word.kind, arguments=arguments, height=height, span=span)

    def _surplus(self, kind: Span, given: Sequence[Expr], most: int) -> None:
        """Warn of numbers that have no effect; of the zeros that old versions of MATLAB fill up with only once."""
        surplus = given[most:]
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

    def _linear(self, place: Place, kind: Span, given: tuple[Expr, ...], span: Span) -> Membership | None:
        """Return a sum over the inputs: a coefficient for each, and a constant."""
        due = len(place.inputs) + 1
        if self.fll and len(given) == due - 1:
            given = (*given, ZERO)
        if len(given) < due or (self.fll and len(given) > due):
            message = f"'{kind.text}' has {counted(len(given), 'parameter')} for {counted(due - 1, 'input')}"
            constant = "perhaps" if self.fll else "then"
            help_text = f"they are: a coefficient for each input, and {constant} a constant"
            self.findings.error("FZ303", message, span, help=help_text)
            return None
        self._surplus(kind, given, due)
        return Membership(kind="linear", arguments=given[:due], span=span)

    def formula(self, place: Place, text: Span, span: Span) -> Membership | None:
        """Return a formula: of the variable itself in a term of an input, of the inputs in one of an output."""
        own_place = {"x"} - {*place.inputs}
        names = {place.variable, *own_place} if place.is_input else {*place.inputs, *place.earlier}
        known = {*names, "x", *place.inputs, *place.outputs} if self.fll else names
        try:
            formula = read_formula(text, known, python=place.python, differs=self.findings.differs)
        except ParseError as error:
            self.findings.refuse(error)
            return None
        if self.fll and place.is_own(formula):
            own = replace_names(formula, {"x": Name(place.variable)})
            return Membership(kind="formula", arguments=(own,), span=span)
        for name in names_in(formula):
            if name.name not in names and name.name != "pi":
                self._refuse_name(place, name)
                return None
        if place.is_input and own_place:
            formula = replace_names(formula, {"x": Name(place.variable)})
        return Membership(kind="function", arguments=(formula,), span=span)

    def _refuse_name(self, place: Place, name: Name) -> None:
        due = f"'{place.variable}' itself" if place.is_input else "inputs, and outputs declared before it"
        message = f"a formula of '{place.variable}' may name {due}, and this one names '{name.name}'"
        if name.name == "x":
            message = f"a formula of output '{place.variable}' names 'x', its place, beside other variables"
        self.findings.error("FZ602", message, name.span, help="write the set as another term, such as Discrete")


def _doubled(expr: Expr) -> Expr:
    return Number(2.0 * expr.value, "", expr.span) if isinstance(expr, Number) else 2.0 * expr


def told_apart(terms: Sequence[Term], variable: str, findings: Findings, help: str) -> list[Term]:
    """Return terms whose names differ; new names are reported once for a variable, as tools give all the same name."""
    names = Names()
    found = [t.model_copy(update={"name": names.take(t.name)}) for t in terms]
    again = [(old, new) for old, new in zip(terms, found, strict=True) if old.name != new.name]
    if again:
        (old, new), *others = again
        message = f"a second term of '{variable}' is called '{old.name}'; it becomes '{new.name}'"
        facts = (f"and so on, {counted(len(others), 'more term')}",) if others else ()
        findings.warning("FZ604", message, old.span, help=help, facts=facts)
    return found
