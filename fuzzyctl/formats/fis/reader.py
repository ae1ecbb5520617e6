"""Reader of `.fis` files, with the settings of the tool that wrote them: sections become statements."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath
from typing import Final, Literal

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.ranges import corners, finite_range, reached, warn_of_degrees_beyond
from fuzzyctl.formats.common.report import Names, Reading
from fuzzyctl.formats.common.translation import Translation, fallback, setting, settings
from fuzzyctl.formats.fis import values
from fuzzyctl.formats.fis import vocabulary as words
from fuzzyctl.formats.fis.rules import Numbered, RuleReader, has_hedges, raw_rules
from fuzzyctl.formats.fis.sections import Entry, Section, Sections, split
from fuzzyctl.formats.fis.settings import check_keys, dialect_of, fuzzylite_version, kind_of, method, numerics
from fuzzyctl.formats.fll.methods import KINDS, weighted
from fuzzyctl.formats.fll.terms import Place, TermReader, told_apart
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import Defuzzifier
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Membership, Term

#: A line that only FisPro's files have; they share the suffix and nothing else.
_FISPRO: Final = re.compile(r"^Ninputs[ \t]*=", re.MULTILINE)


def read(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Read a file.

    Returns:
        The system, None when there are errors, and all diagnostics in the order of their places.
    """
    translation = Translation(source)
    if _FISPRO.search(source.text):
        message = "this is a file of FisPro, which has another form under the same suffix"
        help_text = "files with [System], [Input1], [Output1] and [Rules] are read"
        translation.error("FZ602", message, None, help=help_text)
        return None, translation.in_order()
    file = split(source, translation)
    if not file.sections:
        if not translation.failed:
            translation.error("FZ004", "the file declares no system", None, help="a file begins with [System]")
        return None, translation.in_order()
    _File(file, translation).translate()
    return translation.system(), translation.in_order()


@dataclass(frozen=True)
class _Variable:
    """A variable of the file; terms that could not be read are None."""

    section: Section
    name: sx.Word
    ends: tuple[Number, Number]
    terms: tuple[Term | None, ...]

    @property
    def read(self) -> list[Term]:
        return [t for t in self.terms if t is not None]

    @property
    def memberships(self) -> list[Membership]:
        return [t.membership for t in self.read]


class _File:
    """Translate the sections of a file.

    Args:
        file: The sections.
        translation: Takes the statements, and mistakes.
    """

    def __init__(self, file: Sections, translation: Translation) -> None:
        self.file, self.translation = file, translation
        self.raw = raw_rules(file.of("rules"), translation)
        self.dialect = dialect_of(file, has_hedges(self.raw))
        self.profile = numerics(file, self.dialect)
        self.is_fuzzylite = self.dialect == "fuzzylite"
        self.terms = TermReader(translation, fuzzylite=self.is_fuzzylite, fll=False)
        self.system = self._system()
        self.kind = kind_of(self.system, translation)
        self.names = Names()

    def translate(self) -> None:
        """Add all statements."""
        entry = self.system.entry("Name")
        name = values.string(entry).text if entry is not None else ""
        place = self.system.header
        self.translation.head(name or PurePath(self.translation.source.name).stem, "", place, self.profile)
        self._norms()
        inputs = self._variables("input", ())
        outputs = self._variables("output", tuple(v.name.text for v in inputs))
        self._check_counts(len(inputs), len(outputs))
        for variable in inputs:
            self._input(variable)
        own = [self._defuzzifier(v) for v in outputs]
        is_common = len(set(own)) == 1
        self.translation.statements += settings({"defuzzifier": own[0] if own else None}, place)
        for variable, defuzzifier in zip(outputs, own, strict=True):
            self._output(variable, None if is_common else defuzzifier, inputs)
        self._rules([Numbered(v.name.text, v.terms) for v in inputs], [Numbered(v.name.text, v.terms) for v in outputs])

    def _system(self) -> Section:
        found = self.file.of("system")
        if not found:
            first = self.file.sections[0].header
            help_text = "a file begins with [System]"
            self.translation.error("FZ212", "there is no section [System]", first, help=help_text)
            return Section("system", 0, first)
        for again in found[1:]:
            self.translation.given_twice("[System]", again.header, found[0].header)
        check_keys(found[0], words.SYSTEM_KEYS, self.translation)
        return found[0]

    def _norms(self) -> None:
        """Add the norms; those that the file does not say are as in MATLAB."""
        sugeno = self.kind not in ("mamdani", "hybrid")
        aggregations, version = dict(words.AGGREGATION_WORDS), fuzzylite_version(self.file)
        if version is not None and version < 6:
            aggregations["sum"] = "probabilistic_sum"  # its exporter called the algebraic sum so
        known = {
            "conjunction": ("AndMethod", words.CONJUNCTION_WORDS, "product" if sugeno else "min"),
            "disjunction": ("OrMethod", words.DISJUNCTION_WORDS, "probabilistic_sum" if sugeno else "max"),
            "implication": ("ImpMethod", words.CONJUNCTION_WORDS, "product" if sugeno else "min"),
            "aggregation": ("AggMethod", aggregations, "sum" if sugeno else "max"),
        }
        said = {
            field: method(self.system.entry(key), table, usual, self.translation)
            for field, (key, table, usual) in known.items()
        }
        self.translation.statements += settings(said, self.system.header)
        usual = "weighted_average" if sugeno else "centroid"
        self.named = method(self.system.entry("DefuzzMethod"), words.DEFUZZIFIER_WORDS, usual, self.translation)

    def _check_counts(self, inputs: int, outputs: int) -> None:
        """Compare the numbers that [System] says with those that are there."""
        rules = sum(len(s.entries) for s in self.file.of("rules"))
        for key, there in (("NumInputs", inputs), ("NumOutputs", outputs), ("NumRules", rules)):
            self._check_count(self.system, key, there)

    def _check_count(self, section: Section, key: str, there: int) -> None:
        entry = section.entry(key)
        said = values.count(entry, self.translation) if entry is not None else None
        if entry is not None and said is not None and said != there:
            message = f"{key} says {said}, and there are {there}"
            self.translation.warning("FZ606", message, entry.value, help="all that are written count")

    # --- variables ---------------------------------------------------------------------------------------------

    def _variables(self, kind: str, inputs: tuple[str, ...]) -> list[_Variable]:
        sections = self.file.of(kind)
        if not sections:
            help_text = f"write a section [{kind.title()}1]"
            self.translation.error("FZ212", f"the file has no {kind}", None, help=help_text)
        numbers: dict[int, Section] = {}
        for section in sections:
            earlier = numbers.setdefault(section.number, section)
            if earlier is not section:
                self.translation.given_twice(section.header.text, section.header, earlier.header)
        named = [self._name(s) for s in sections]
        known = tuple(n.text for n in named)
        place = Place("", known, (), True) if kind == "input" else Place("", inputs, known, False)
        return [self._variable(s, n, place) for s, n in zip(sections, named, strict=True)]

    def _name(self, section: Section) -> sx.Word:
        entry = section.entry("Name")
        given = values.string(entry) if entry is not None else values.Text("", section.header)
        wanted = given.text or f"{section.kind}{section.number or 1}"
        name = self.names.take(wanted)
        if not given.text:
            message = f"the {section.kind} has no name; it is called '{name}'"
            self.translation.warning("FZ604", message, section.header, help=f"write: Name='{name}'")
        elif name != wanted:
            message = f"a second variable is called '{wanted}'; it becomes '{name}'"
            self.translation.warning("FZ604", message, given.span, help="give it a name of its own")
        return sx.Word(name, given.span)

    def _variable(self, section: Section, name: sx.Word, place: Place) -> _Variable:
        check_keys(section, words.VARIABLE_KEYS, self.translation)
        ends = self._range(section, name.text)
        place = replace(place, variable=name.text)
        terms = self._terms(section, place)
        if place.is_input:
            low, high = ends
            read = [t for t in terms if t is not None]
            warn_of_degrees_beyond(read, name.text, (low.value, high.value), self.translation)
        self._check_count(section, "NumMFs", sum(bool(values.NUMBERED.match(e.key)) for e in section.entries))
        entry = section.entry("Enabled") if self.is_fuzzylite else None
        if entry is not None and not values.is_on(entry):  # its rules would mean something else
            message = f"a variable that is switched off is not available: '{name.text}'"
            help_text = "write: Enabled=1; or remove it and its rules"
            self.translation.error("FZ602", message, entry.value, help=help_text)
        return _Variable(section, name, ends, tuple(terms))

    def _range(self, section: Section, name: str) -> tuple[Number, Number]:
        entry, help_text = section.entry("Range"), "write, for example: Range=[0 10]"
        found = values.vector(entry.value, self.translation) if entry is not None else None
        if entry is None:
            self.translation.error("FZ212", f"'{name}' has no range", section.header, help=help_text)
        elif found is not None and len(found) != 2:
            message = f"the range of '{name}' has {counted(len(found), 'number')} instead of two"
            self.translation.error("FZ601", message, entry.value, help=help_text)
        return (found[0], found[1]) if found is not None and len(found) == 2 else (Number(0.0), Number(1.0))

    def _terms(self, section: Section, place: Place) -> list[Term | None]:
        found: list[Term | None] = []
        for entry in section.entries:
            match = values.NUMBERED.match(entry.key)
            if match is None:
                continue
            if match.group(2):
                message = f"'{entry.key}' is one side of an interval type-2 fuzzy set"
                self.translation.error("FZ602", message, entry.key_span, help="only type-1 sets are computed")
                continue
            number = len(found) + 1
            if int(match.group(1)) != number:
                message = f"expected MF{number}, found '{entry.key}'; it counts as MF{number}"
                help_text = "rules number terms in the order written"
                self.translation.warning("FZ606", message, entry.key_span, help=help_text)
            found.append(self._term(entry, number, place))
        read = [t for t in found if t is not None]
        help_text = "rules name terms by their numbers, so nothing else changes"
        renamed = iter(told_apart(read, place.variable, self.translation, help_text))
        return [t if t is None else next(renamed) for t in found]

    def _term(self, entry: Entry, number: int, place: Place) -> Term | None:
        raw = values.term(entry, self.translation)
        membership = self._membership(raw, place) if raw is not None else None
        if raw is None or membership is None:
            return None
        name = raw.name.text or f"mf{number}"
        if not raw.name.text:
            message = f"term {number} of '{place.variable}' has no name; it is called '{name}'"
            self.translation.warning("FZ604", message, raw.name.span)
        return Term(name=name, membership=membership, span=raw.name.span)

    def _membership(self, raw: values.RawTerm, place: Place) -> Membership | None:
        table = words.MEMBERSHIPS_OF_FUZZYLITE if self.is_fuzzylite else words.MEMBERSHIPS
        otherwise = "a function of your own is a program, which cannot be read here"
        kind = raw.function.span
        word = self.translation.look_up(
            kind, table, "membership function", word=raw.function.text.lower(), otherwise=otherwise
        )
        if word is None:
            return None
        if raw.formula is not None:
            return self.terms.formula(place, raw.formula, raw.span)
        return self.terms.shape(place, kind, word, raw.parameters, raw.span)

    def _input(self, variable: _Variable) -> None:
        """Add an input; no tool clamps it to its range, except fuzzylite where the file says so."""
        ends, span = variable.ends, variable.name.span
        is_free = not self._flag(variable.section, "LockRange")
        if self.is_fuzzylite and not all(math.isfinite(e.value) for e in ends):
            is_free, needed = True, corners(variable.memberships)
            ends = finite_range(variable.name.text, ends, needed, span, self.translation)
        clauses = [sx.ExtrapolateClause(span)] if is_free else []
        self.translation.variable("input", variable.name, ends, variable.read, clauses)

    def _output(self, variable: _Variable, own: Defuzzifier | None, inputs: Sequence[_Variable]) -> None:
        span, section = variable.name.span, variable.section
        low, high = variable.ends
        if low.value == high.value and math.isfinite(low.value) and self.named.startswith("weighted"):
            low, high = self._reached(variable, inputs)
        clauses: list[sx.Clause] = []
        if own is not None:
            clauses.append(sx.SettingClause(setting("defuzzifier", own, span), span))
        if self._flag(section, "LockRange"):
            clauses.append(sx.ClampClause(span))
        if self.is_fuzzylite:
            entry, default = section.entry("Default"), None
            if entry is not None and values.string(entry).text.lower() not in ("nan", "-nan"):
                found = values.vector(entry.value, self.translation)
                default = found[0] if found and len(found) == 1 else None
            locked = any(self._flag(section, key) for key in ("LockPrevious", "LockValid", "Lock"))
            start: Number | Literal["nan"] = default if default is not None else "nan"
            clauses.append(fallback(Hold(start=start) if locked else start, span))
        self.translation.variable("output", variable.name, (low, high), variable.read, clauses)

    def _reached(self, variable: _Variable, inputs: Sequence[_Variable]) -> tuple[Number, Number]:
        """Return a range for a Sugeno output that has none, such as [0 0].

        It reaches as far as its consequents do, and its middle is the number given: what MATLAB takes where no rule
        fires.
        """
        low, _ = variable.ends
        ranges = [(v.ends[0].value, v.ends[1].value) for v in inputs]
        ends = [e for m in variable.memberships for e in (*reached(m, ranges), *_places(m))]
        half = max((abs(e - low.value) for e in ends if math.isfinite(e)), default=0.0) or 1.0
        first, last = low.value - half, low.value + half
        reach = f"[{first:.6g}, {last:.6g}], as far as its terms reach"
        message = f"the range of '{variable.name.text}' is empty; it becomes {reach}"
        help_text = "give it a range; only its middle counts, where no rule fires"
        self.translation.warning("FZ603", message, low.span, help=help_text)
        return Number(first), Number(last)

    def _flag(self, section: Section, key: str) -> bool:
        """Return one of fuzzylite's switches, which other tools do not write."""
        entry = section.entry(key)
        return entry is not None and self.is_fuzzylite and values.is_on(entry)

    def _defuzzifier(self, variable: _Variable) -> Defuzzifier:
        """Return the defuzzifier of an output, with the samples of the tool."""
        kind, entry, name = self.named, self.system.entry("DefuzzMethod"), variable.name.text
        place, sums = entry.value if entry is not None else variable.name.span, kind.startswith("weighted")
        kinds = {m.kind for m in variable.memberships}
        if self.kind == "hybrid" and not sums and kinds and kinds <= {"constant", "linear", "function"}:
            # Numbers of a hybrid system, which the one defuzzifier of the file does not suit.
            message = f"the terms of '{name}' are numbers or functions; their weighted average is taken"
            taken = f"fuzzylite takes their {kind} as sets that do not depend on the output"
            other, way_out = f"{taken}: mostly the middle of the range", "with DefuzzMethod='wtaver'"
            way_out = f"put this output into a file of its own {way_out}"
            self.translation.differs(Reading(message, other, way_out, place))
            kind, sums = "weighted_average", True
        if self.is_fuzzylite and sums:
            sort = weighted(variable.read, "Automatic", name, variable.name.span, self.translation)
            return self.profile.defuzzifier(KINDS[sort][kind == "weighted_sum"])
        if sums and self.kind == "mamdani":
            message = "'wtaver' and 'wtsum' defuzzify Sugeno systems, and this one is of type 'mamdani'"
            help_text = "write: DefuzzMethod='centroid', or Type='sugeno'"
            self.translation.error("FZ214", message, place, help=help_text)
        elif not sums and self.kind == "sugeno":
            message = "this is a Sugeno system, whose consequents are no sets"
            self.translation.error("FZ214", message, place, help="write: DefuzzMethod='wtaver'")
        return self.profile.defuzzifier(kind)

    def _rules(self, inputs: Sequence[Numbered], outputs: Sequence[Numbered]) -> None:
        reader = RuleReader(inputs, outputs, self.dialect, self.kind == "sugeno", self.translation)
        for raw in self.raw:
            reader.read(raw)
        if not self.raw and not self.translation.failed:
            header = self.file.of("rules")
            self.translation.error("FZ212", "the file has no rule", header[0].header if header else None)


def _places(membership: Membership) -> list[float]:
    """Return the numbers of a term that is a set, which lie about where it matters."""
    return [] if membership.kind in ("constant", "linear") else corners([membership])
