"""Linguistic variables from the sections `[Input1]` and `[Output1]`."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Name, Number, replace_names
from fuzzyctl.formats.common.ranges import warn_of_degrees_beyond
from fuzzyctl.formats.common.report import Findings, Names, ParseError, meant
from fuzzyctl.formats.common.words import Shape, ShapeWord, Values
from fuzzyctl.formats.fll.terms import NOT_BEYOND, membership_as_computed, step_to_itself
from fuzzyctl.model.variable import Membership, Term
from tests.oracles.fis import values
from tests.oracles.fis.sections import Entry, Section
from tests.oracles.fis.values import RawTerm, Text
from tests.oracles.fis.vocabulary import MEMBERSHIP_WORDS, Dialect
from tests.oracles.fll.functions import read_formula
from tests.oracles.fll.vocabulary import TERM_WORDS

#: The key of a membership function: its number, and U or L of interval type-2 sets.
_NUMBERED: Final = re.compile(r"mf *([0-9]{1,6}) *([ul]?)$", re.IGNORECASE)

#: Keys in small letters; those after the first three are fuzzylite's.
_KEYS: Final = (
    "name", "range", "nummfs", "enabled", "default", "lock", "lockvalid", "lockprevious", "lockrange",
)  # fmt: skip


@dataclass(frozen=True)
class Variable:
    """A variable as read.

    Args:
        name: Its name, distinct from all others.
        lower: The lower end of its range as written.
        upper: The upper end.
        terms: Its terms by their numbers.
        span: Where its name stands, or its header.
        written: How many terms are written, those included that could not be read.
    """

    name: str
    lower: Number
    upper: Number
    terms: dict[int, Term]
    span: Span
    written: int


class VariableReader:
    """Read the variables of a file.

    Args:
        inputs: Number of inputs, for linear consequents.
        findings: Where mistakes go.
        dialect: Who wrote the file.
    """

    def __init__(self, inputs: int, findings: Findings, dialect: Dialect) -> None:
        self.inputs = inputs
        self.dialect = dialect
        self.findings = findings
        self.names = Names()
        self.input_names: list[str] = []
        self.output_names: list[str] = []
        self.reading = ""
        self.padded = False

    def read(self, section: Section) -> Variable:
        """Read one variable; what cannot be read is reported and replaced by something harmless."""
        self._check_keys(section)
        name = self._name(section)
        self.reading = name.text
        (self.input_names if section.kind == "input" else self.output_names).append(name.text)
        lower, upper = self._range(section, name.text)
        terms = self._terms(section, name.text)
        if section.kind == "input":
            warn_of_degrees_beyond(terms.values(), name.text, (lower.value, upper.value), self.findings)
        written = sum(bool(_NUMBERED.match(e.key)) for e in section.entries)
        self._check_count(section, written)
        self._refuse_disabled(section)
        return Variable(name.text, lower, upper, terms, name.span, written)

    def _check_keys(self, section: Section) -> None:
        seen: dict[str, Entry] = {}
        for entry in section.entries:
            key = entry.key.lower()
            earlier = seen.setdefault(key, entry) if not _NUMBERED.match(key) else entry
            if earlier is not entry:
                self.findings.given_twice(f"'{entry.key}'", entry.key_span, earlier.span)
            elif key not in _KEYS and not _NUMBERED.match(key):
                known = ["Name", "Range", "NumMFs", "MF1"]
                help_text = meant(entry.key, known) or f"keys of a variable: {', '.join(known)}"
                self.findings.warning("FZ603", f"nothing reads '{entry.key}'", entry.key_span, help=help_text)

    def _refuse_disabled(self, section: Section) -> None:
        """Refuse what fuzzylite has switched off, since its rules would mean something else."""
        entry = section.entry("Enabled") if self.dialect == "fuzzylite" else None
        if entry is not None and not values.is_on(entry):
            message = f"a variable that is switched off is not available: '{self.reading}'"
            self.findings.error("FZ602", message, entry.value, help="write: Enabled=1; or remove it and its rules")

    def _name(self, section: Section) -> Text:
        entry = section.entry("Name")
        given = values.string(entry) if entry is not None else Text("", section.header)
        wanted = given.text or f"{section.kind}{section.number or 1}"
        name = self.names.take(wanted)
        if not given.text:
            message = f"the {section.kind} has no name; it is called '{name}'"
            self.findings.warning("FZ604", message, section.header, help=f"write: Name='{name}'")
        elif name != wanted:
            message = f"a second variable is called '{wanted}'; it becomes '{name}'"
            self.findings.warning("FZ604", message, given.span, help="give it a name of its own")
        return Text(name, given.span)

    def _range(self, section: Section, name: str) -> tuple[Number, Number]:
        entry = section.entry("Range")
        found = values.vector(entry.value, self.findings) if entry is not None else None
        if entry is None:
            message = f"'{name}' has no range"
            self.findings.error("FZ212", message, section.header, help="write, for example: Range=[0 10]")
        elif found is not None and len(found) != 2:
            message = f"the range of '{name}' has {counted(len(found), 'number')} instead of two"
            self.findings.error("FZ601", message, entry.value, help="write, for example: Range=[0 10]")
        if found is None or len(found) != 2:
            return Number(0.0), Number(1.0)
        return found[0], found[1]

    def _terms(self, section: Section, variable: str) -> dict[int, Term]:
        terms: dict[int, Term] = {}
        names = Names()
        again: list[tuple[Text, str]] = []
        number = 0
        for entry in section.entries:
            match = _NUMBERED.match(entry.key)
            if match is None:
                continue
            if match.group(2):
                self._refuse_type_2(entry)
                continue
            number += 1
            if int(match.group(1)) != number:
                message = f"expected MF{number}, found '{entry.key}'; it counts as MF{number}"
                help_text = "rules number terms in the order written"
                self.findings.warning("FZ606", message, entry.key_span, help=help_text)
            raw = values.term(entry, self.findings)
            membership = self._membership(raw) if raw is not None else None
            if raw is None or membership is None:
                continue
            name = self._term_name(raw.name, number, variable, names)
            if raw.name.text and name != raw.name.text:
                again.append((raw.name, name))
            terms[number] = Term(name=name, membership=membership, span=raw.name.span)
        self._warn_of_names(variable, again)
        return terms

    def _warn_of_names(self, variable: str, again: list[tuple[Text, str]]) -> None:
        """Warn of terms that have the name of another, once for a variable: tools give all the same name."""
        if not again:
            return
        (first, name), *others = again
        message = f"a second term of '{variable}' is called '{first.text}'; it becomes '{name}'"
        facts = (f"and so on, {counted(len(others), 'more term')}",) if others else ()
        help_text = "rules name terms by their numbers, so nothing else changes"
        self.findings.warning("FZ604", message, first.span, help=help_text, facts=facts)

    def _refuse_type_2(self, entry: Entry) -> None:
        message = f"'{entry.key}' is one side of an interval type-2 fuzzy set"
        self.findings.error("FZ602", message, entry.key_span, help="only type-1 sets are computed")

    def _term_name(self, given: Text, number: int, variable: str, names: Names) -> str:
        wanted = given.text or f"mf{number}"
        name = names.take(wanted)
        if not given.text:
            message = f"term {number} of '{variable}' has no name; it is called '{name}'"
            self.findings.warning("FZ604", message, given.span)
        return name

    def _membership(self, raw: RawTerm) -> Membership | None:
        function = raw.function.text.lower()
        if function == "linear":
            return self._linear(raw)
        if function == "function":
            return self._formula(raw)
        word = MEMBERSHIP_WORDS.get(function)
        if word is None:
            self._refuse_function(raw)
            return None
        given = self._counted(raw, word)
        if given is None:
            return None
        if function == "constant" and self.dialect == "fuzzylite" and self.reading in self.input_names:
            if not 0.0 <= given[0].value <= 1.0:
                message = f"the degree {given[0].value:g} lies outside [0, 1]"
                self.findings.error("FZ302", message, given[0].span or raw.span, help=NOT_BEYOND)
                return None
            # To fuzzylite a constant is its own degree, whatever the input is.
            return Membership(kind="function", arguments=given, span=raw.span)
        if self.dialect != "fuzzylite":
            return _shaped(raw, given, word.shape)
        variable = self.reading if self.reading in self.input_names else None
        if function == "binarymf" and given[0] == given[1]:
            return step_to_itself(variable, raw.span, self.findings, word=raw.function.text)
        made = _shaped(raw, given, _OF_FUZZYLITE.get(function, word.shape))
        return membership_as_computed(made, variable, self.findings, word=raw.function.text)

    def _refuse_function(self, raw: RawTerm) -> None:
        name = raw.function.text
        help_text = meant(name, MEMBERSHIP_WORDS) or "a function of one's own is a program, which cannot be read here"
        message = f"there is no membership function '{name}'"
        facts = (f"functions: {', '.join((*MEMBERSHIP_WORDS, 'linear'))}",)
        self.findings.error("FZ602", message, raw.function.span, help=help_text, facts=facts)

    def _counted(self, raw: RawTerm, word: ShapeWord) -> tuple[Number, ...] | None:
        """Return as many parameters as the function takes; surplus ones are left out with a warning."""
        given, name = raw.parameters, raw.function.text
        if word.count is None:
            return self._pairs(raw)
        if len(given) < word.count:
            message = f"'{name}' of '{raw.name.text}' has {counted(len(given), 'parameter')} instead of {word.count}"
            self.findings.error("FZ303", message, raw.span, help=f"they are: [{word.form}]")
            return None
        if len(given) > word.count:
            self._warn_of_surplus(raw, word.count)
        return given[: word.count]

    def _warn_of_surplus(self, raw: RawTerm, due: int) -> None:
        """Warn of parameters that nothing reads; of the zeros that old versions fill up with only once."""
        surplus = raw.parameters[due:]
        zeros = all(n.value == 0 for n in surplus)
        if zeros and self.padded:
            return
        self.padded |= zeros
        first, last = surplus[0].span, surplus[-1].span
        place = first.to(last) if first is not None and last is not None else raw.span
        message = f"'{raw.function.text}' takes {counted(due, 'parameter')}; '{place.text}' has no effect"
        facts = ("old versions fill up with zeros; those of other functions are not listed",) if zeros else ()
        self.findings.warning("FZ603", message, place, help="remove it", facts=facts)

    def _pairs(self, raw: RawTerm) -> tuple[Number, ...] | None:
        if len(raw.parameters) < 4 or len(raw.parameters) % 2:
            message = f"'{raw.function.text}' of '{raw.name.text}' takes pairs of numbers, two or more"
            self.findings.error("FZ303", message, raw.span, help="they are: [x1 y1 x2 y2 ...]")
            return None
        return raw.parameters

    def _linear(self, raw: RawTerm) -> Membership | None:
        """Return a linear consequent: a coefficient for each input and a constant."""
        due = self.inputs + 1
        given = raw.parameters
        if len(given) < due:
            message = f"'linear' of '{raw.name.text}' has {counted(len(given), 'parameter')} instead of {due}"
            help_text = "they are: a coefficient for each input, then a constant"
            self.findings.error("FZ303", message, raw.span, help=help_text)
            return None
        surplus = given[due:]
        if surplus:
            place = surplus[0].span
            message = f"'linear' takes {due} parameters here; {counted(len(surplus), 'more number')} have no effect"
            self.findings.warning("FZ603", message, place, help="remove them")
        return Membership(kind="linear", arguments=given[:due], span=raw.span)

    def _formula(self, raw: RawTerm) -> Membership | None:
        """Return a formula of fuzzylite: over the variable itself in a term of an input, else over the inputs."""
        of_input = self.reading in self.input_names
        # An output sees the outputs declared before it.
        names = {self.reading, "x"} if of_input else {*self.input_names, *self.output_names[:-1]}
        try:
            formula = read_formula(raw.formula or raw.span, names, differs=self.findings.differs)
        except ParseError as error:
            self.findings.refuse(error)
            return None
        if of_input and "x" not in self.input_names:
            formula = replace_names(formula, {"x": Name(self.reading)})
        return Membership(kind="function", arguments=(formula,), span=raw.span)

    def _check_count(self, section: Section, written: int) -> None:
        entry = section.entry("NumMFs")
        said = values.count(entry, self.findings) if entry is not None else None
        if entry is not None and said is not None and said != written:
            message = f"NumMFs says {said}, and there are {written}"
            self.findings.warning("FZ606", message, entry.value, help="all that are written count")


#: Functions whose parameters, where they are out of order, mean something else to fuzzylite than to MATLAB.
_OF_FUZZYLITE: Final = {
    function: TERM_WORDS[word].shape
    for function, word in (("trapmf", "Trapezoid"), ("smf", "SShape"), ("zmf", "ZShape"))
}


def _shaped(raw: RawTerm, given: tuple[Number, ...], shape: Callable[[Values], Shape]) -> Membership:
    """Return a membership with the parameters in the model's order; each keeps the place of an equal one as written."""
    kind, parameters = shape(tuple(n.value for n in given))
    places = {n.value: n.span for n in given}
    arguments = tuple(Number(v, span=places.get(v) or places.get(-v)) for v in parameters)
    return Membership(kind=kind, arguments=arguments, span=raw.span)


def is_empty(variable: Variable) -> bool:
    """Whether the ends of the range are equal, as MATLAB writes for Sugeno outputs without a range."""
    return variable.lower.value == variable.upper.value and math.isfinite(variable.lower.value)
