"""Reader of `.fis` files, with the settings of the tool that wrote them: sections become statements."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import Final, Literal

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.ranges import corners, finite_range, reached, warn_of_degrees_beyond
from fuzzyctl.formats.common.report import Names, Reading, meant
from fuzzyctl.formats.common.translation import Translation, fallback, setting, settings
from fuzzyctl.formats.fis import dialects
from fuzzyctl.formats.fis.rules import RuleReader, Variable, coded_rules
from fuzzyctl.formats.fis.sections import NUMBERED, Entry, Section, Sections, TermText, Text, split, term_text, vector
from fuzzyctl.formats.fis.shapes import MEMBERSHIPS, MEMBERSHIPS_OF_FUZZYLITE
from fuzzyctl.formats.fll.methods import KINDS, weighted
from fuzzyctl.formats.fll.terms import Place, TermReader, told_apart
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import Defuzzifier
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Membership, Term

#: A line that only FisPro's files have; they share only the suffix.
_FISPRO: Final = re.compile(r"^Ninputs[ \t]*=", re.MULTILINE)


def read(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Read a file.

    Returns:
        The system, None if there are errors, and all diagnostics in the order of their places.
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


class _File:
    """Translates the sections of a file.

    Args:
        file: The sections.
        translation: Takes the statements, and mistakes.
    """

    def __init__(self, file: Sections, translation: Translation) -> None:
        self.file, self.translation = file, translation
        self.rules = coded_rules(file.of("rules"), translation)
        dialect = dialects.dialect_of(file, hedges=any(rule.has_hedges for rule in self.rules))
        self.dialect, self.is_fuzzylite = dialect, dialect == "fuzzylite"
        self.profile = dialects.numerics(file, dialect)
        self.terms = TermReader(translation, fuzzylite=self.is_fuzzylite, fll=False)
        self.system = self._system()
        self.type = self._type()
        self.names = Names()

    def translate(self) -> None:
        """Add all statements."""
        place = self.system.header
        name = self.system.string("Name") or PurePath(self.translation.source.name).stem
        self.translation.head(name, "", place, self.profile)
        self._methods()
        inputs = self._variables("input", ())
        outputs = self._variables("output", tuple(v.name.text for v in inputs))
        rules = sum(len(s.entries) for s in self.file.of("rules"))
        for key, count in (("NumInputs", len(inputs)), ("NumOutputs", len(outputs)), ("NumRules", rules)):
            self._check_count(self.system, key, count)
        for variable in inputs:
            self._input(variable)
        defuzzifiers = [self._defuzzifier(v) for v in outputs]
        is_common = len(set(defuzzifiers)) == 1
        self.translation.statements += settings({"defuzzifier": defuzzifiers[0] if outputs else None}, place)
        for variable, defuzzifier in zip(outputs, defuzzifiers, strict=True):
            self._output(variable, None if is_common else defuzzifier, inputs)
        reader = RuleReader(inputs, outputs, self.dialect, self.type == "sugeno", self.translation)
        for rule in self.rules:
            reader.read(rule)
        if not self.rules and not self.translation.failed:
            header = self.file.of("rules")
            self.translation.error("FZ212", "the file has no rule", header[0].header if header else None)

    # --- [System] ------------------------------------------------------------------------------------------------

    def _system(self) -> Section:
        sections = self.file.of("system")
        if not sections:
            first = self.file.sections[0].header
            help_text = "a file begins with [System]"
            self.translation.error("FZ212", "there is no section [System]", first, help=help_text)
            return Section("system", 0, first)
        for second in sections[1:]:
            self.translation.given_twice("[System]", second.header, sections[0].header)
        self._check_keys(sections[0], dialects.SYSTEM_KEYS)
        return sections[0]

    def _check_keys(self, section: Section, known: Mapping[str, str]) -> None:
        """Report repeated keys, and warn of unknown ones; `known` has them in small letters."""
        entries: dict[str, Entry] = {}
        for entry in section.entries:
            key = entry.key.lower()
            if NUMBERED.match(key):
                continue
            earlier = entries.setdefault(key, entry)
            if earlier is not entry:
                self.translation.given_twice(f"'{entry.key}'", entry.key_span, earlier.span)
            elif key.startswith("typered"):
                message = f"'{entry.key}' belongs to type-2 systems"
                self.translation.error("FZ602", message, entry.span, help="only type-1 systems are computed")
            elif key not in known:
                listed = [k for k in known.values() if k]
                help_text = meant(entry.key, listed) or f"keys of [{section.kind.title()}]: {', '.join(listed)}"
                self.translation.warning("FZ603", f"'{entry.key}' has no effect", entry.key_span, help=help_text)

    def _type(self) -> str:
        entry = self.system.entry("Type")
        if entry is None:
            return "mamdani"
        word = entry.string.text.lower().replace("-", " ")
        help_text = "only type-1 systems are computed" if "2" in word else ""
        type = self.translation.look_up(entry.value, dialects.TYPES, "type", word=word, otherwise=help_text)
        return type or "mamdani"

    def _methods(self) -> None:
        """Add the norms and set the defuzzifier; those that the file does not say are as in MATLAB."""
        sugeno = self.type not in ("mamdani", "hybrid")
        aggregations, version = dict(dialects.AGGREGATION_WORDS), dialects.fuzzylite_version(self.file)
        if version is not None and version < 6:
            aggregations["sum"] = "probabilistic_sum"  # its exporter called the algebraic sum so
        conjunctions, disjunctions = dialects.CONJUNCTION_WORDS, dialects.DISJUNCTION_WORDS
        t_norm, s_norm, aggregation = ("product", "probabilistic_sum", "sum") if sugeno else ("min", "max", "max")
        norms = {
            "conjunction": self._method("AndMethod", conjunctions, t_norm),
            "disjunction": self._method("OrMethod", disjunctions, s_norm),
            "implication": self._method("ImpMethod", conjunctions, t_norm),
            "aggregation": self._method("AggMethod", aggregations, aggregation),
        }
        self.translation.statements += settings(norms, self.system.header)
        kind = "weighted_average" if sugeno else "centroid"
        self.defuzzifier = self._method("DefuzzMethod", dialects.DEFUZZIFIER_WORDS, kind)

    def _method(self, key: str, known: Mapping[str, str], usual: str) -> str:
        """Return a method of the model; `usual` for a missing one, and an empty one as fuzzylite writes for none."""
        entry, word = self.system.entry(key), self.system.string(key).lower()
        if entry is None or not word:
            return usual
        otherwise = "a method of your own is a program, which cannot be read here"
        return self.translation.look_up(entry.value, known, entry.key, word=word, otherwise=otherwise) or usual

    def _check_count(self, section: Section, key: str, count: int) -> None:
        """Warn of a key whose number is not the count."""
        entry = section.entry(key)
        number = entry.count(self.translation) if entry is not None else None
        if entry is not None and number is not None and number != count:
            message = f"{key} says {number}, and there are {count}"
            self.translation.warning("FZ606", message, entry.value, help="all that are written count")

    # --- variables of the file -----------------------------------------------------------------------------------

    def _variables(self, kind: str, inputs: tuple[str, ...]) -> list[Variable]:
        sections = self.file.of(kind)
        if not sections:
            help_text = f"write a section [{kind.title()}1]"
            self.translation.error("FZ212", f"the file has no {kind}", None, help=help_text)
        numbers: dict[int, Section] = {}
        for section in sections:
            earlier = numbers.setdefault(section.number, section)
            if earlier is not section:
                self.translation.given_twice(section.header.text, section.header, earlier.header)
        words = [self._name(s) for s in sections]
        names = tuple(word.text for word in words)
        place = Place("", names, (), True) if kind == "input" else Place("", inputs, names, False)
        return [self._variable(s, word, place) for s, word in zip(sections, words, strict=True)]

    def _name(self, section: Section) -> sx.Word:
        entry = section.entry("Name")
        text = entry.string if entry is not None else Text("", section.header)
        first_choice = text.text or f"{section.kind}{section.number or 1}"
        name = self.names.take(first_choice)
        if not text.text:
            message = f"the {section.kind} has no name; it is called '{name}'"
            self.translation.warning("FZ604", message, section.header, help=f"write: Name='{name}'")
        elif name != first_choice:
            message = f"a second variable is called '{first_choice}'; it becomes '{name}'"
            self.translation.warning("FZ604", message, text.span, help="give it a name of its own")
        return sx.Word(name, text.span)

    def _variable(self, section: Section, name: sx.Word, place: Place) -> Variable:
        self._check_keys(section, dialects.VARIABLE_KEYS)
        ends = self._range(section, name.text)
        terms = self._terms(section, replace(place, variable=name.text))
        variable = Variable(section, name, ends, terms)
        if place.is_input:
            warn_of_degrees_beyond(variable.sound, name.text, (ends[0].value, ends[1].value), self.translation)
        self._check_count(section, "NumMFs", sum(bool(NUMBERED.match(e.key)) for e in section.entries))
        entry = section.entry("Enabled") if self.is_fuzzylite else None
        if entry is not None and not entry.is_on:  # its rules would mean something else
            message = f"a variable that is switched off is not available: '{name.text}'"
            help_text = "write: Enabled=1; or remove it and its rules"
            self.translation.error("FZ602", message, entry.value, help=help_text)
        return variable

    def _range(self, section: Section, name: str) -> tuple[Number, Number]:
        entry, help_text = section.entry("Range"), "write, for example: Range=[0 10]"
        numbers = vector(entry.value, self.translation) if entry is not None else None
        if numbers is not None and len(numbers) == 2:
            return numbers[0], numbers[1]
        if entry is None:
            self.translation.error("FZ212", f"'{name}' has no range", section.header, help=help_text)
        elif numbers is not None:
            message = f"the range of '{name}' has {counted(len(numbers), 'number')} instead of two"
            self.translation.error("FZ601", message, entry.value, help=help_text)
        return Number(0.0), Number(1.0)

    def _terms(self, section: Section, place: Place) -> list[Term | None]:
        terms: list[Term | None] = []
        for entry in section.entries:
            match = NUMBERED.match(entry.key)
            if match is None:
                continue
            if match.group(2):
                message = f"'{entry.key}' is one side of an interval type-2 fuzzy set"
                self.translation.error("FZ602", message, entry.key_span, help="only type-1 sets are computed")
                continue
            number = len(terms) + 1
            if int(match.group(1)) != number:
                message = f"expected MF{number}, found '{entry.key}'; it counts as MF{number}"
                help_text = "rules number terms in the order written"
                self.translation.warning("FZ606", message, entry.key_span, help=help_text)
            terms.append(self._term(entry, number, place))
        help_text = "rules name terms by their numbers, so nothing else changes"
        sound = [t for t in terms if t is not None]
        renamed = iter(told_apart(sound, place.variable, self.translation, help_text))
        return [t if t is None else next(renamed) for t in terms]

    def _term(self, entry: Entry, number: int, place: Place) -> Term | None:
        text = term_text(entry, self.translation)
        membership = self._membership(text, place) if text is not None else None
        if text is None or membership is None:
            return None
        name = text.name.text or f"mf{number}"
        if not text.name.text:
            message = f"term {number} of '{place.variable}' has no name; it is called '{name}'"
            self.translation.warning("FZ604", message, text.name.span)
        return Term(name=name, membership=membership, span=text.name.span)

    def _membership(self, text: TermText, place: Place) -> Membership | None:
        table = MEMBERSHIPS_OF_FUZZYLITE if self.is_fuzzylite else MEMBERSHIPS
        kind, name = text.function.span, text.function.text.lower()
        otherwise = "a function of your own is a program, which cannot be read here"
        word = self.translation.look_up(kind, table, "membership function", word=name, otherwise=otherwise)
        if word is None:
            return None
        if text.formula is not None:
            return self.terms.formula(place, text.formula, text.span)
        return self.terms.shape(place, kind, word, text.parameters, text.span)

    # --- variables of the system ---------------------------------------------------------------------------------

    def _input(self, variable: Variable) -> None:
        """Add an input; only fuzzylite clamps it to its range, if the file says so."""
        ends, span = variable.ends, variable.name.span
        is_free = not self._switch(variable.section, "LockRange")
        if self.is_fuzzylite and not all(math.isfinite(e.value) for e in ends):
            is_free, places = True, corners(variable.memberships)
            ends = finite_range(variable.name.text, ends, places, span, self.translation)
        clauses = [sx.ExtrapolateClause(span)] if is_free else []
        self.translation.variable("input", variable.name, ends, variable.sound, clauses)

    def _output(self, variable: Variable, defuzzifier: Defuzzifier | None, inputs: Sequence[Variable]) -> None:
        span, section = variable.name.span, variable.section
        low, high = variable.ends
        if low.value == high.value and math.isfinite(low.value) and self.defuzzifier.startswith("weighted"):
            low, high = self._range_of_terms(variable, inputs)
        clauses: list[sx.Clause] = []
        if defuzzifier is not None:
            clauses.append(sx.SettingClause(setting("defuzzifier", defuzzifier, span), span))
        if self._switch(section, "LockRange"):
            clauses.append(sx.ClampClause(span))
        if self.is_fuzzylite:
            entry, default = section.entry("Default"), None
            if entry is not None and entry.string.text.lower() not in ("nan", "-nan"):
                numbers = vector(entry.value, self.translation)
                default = numbers[0] if numbers and len(numbers) == 1 else None
            holds = any(self._switch(section, key) for key in ("LockPrevious", "LockValid", "Lock"))
            start: Number | Literal["nan"] = default if default is not None else "nan"
            clauses.append(fallback(Hold(start=start) if holds else start, span))
        self.translation.variable("output", variable.name, (low, high), variable.sound, clauses)

    def _range_of_terms(self, variable: Variable, inputs: Sequence[Variable]) -> tuple[Number, Number]:
        """Return a range for a Sugeno output with an empty one, such as [0 0].

        It reaches as far as its consequents do, and its middle is the number of the file, which MATLAB takes if no rule
        fires.
        """
        middle = variable.ends[0]
        ranges = [(v.ends[0].value, v.ends[1].value) for v in inputs]
        sets = [m for m in variable.memberships if m.kind not in ("constant", "linear")]
        places = [*(end for m in variable.memberships for end in reached(m, ranges)), *corners(sets)]
        half = max((abs(x - middle.value) for x in places if math.isfinite(x)), default=0.0) or 1.0
        first, last = middle.value - half, middle.value + half
        reach = f"[{first:.6g}, {last:.6g}], as far as its terms reach"
        message = f"the range of '{variable.name.text}' is empty; it becomes {reach}"
        help_text = "give it a range; only its middle counts, where no rule fires"
        self.translation.warning("FZ603", message, middle.span, help=help_text)
        return Number(first), Number(last)

    def _switch(self, section: Section, key: str) -> bool:
        """Return the value of one of fuzzylite's switches, which other tools do not write."""
        entry = section.entry(key)
        return entry is not None and self.is_fuzzylite and entry.is_on

    def _defuzzifier(self, variable: Variable) -> Defuzzifier:
        """Return the defuzzifier of an output, with the samples of the tool."""
        kind, entry, name = self.defuzzifier, self.system.entry("DefuzzMethod"), variable.name.text
        place, is_weighted = entry.value if entry is not None else variable.name.span, kind.startswith("weighted")
        kinds = {m.kind for m in variable.memberships}
        if self.type == "hybrid" and not is_weighted and kinds and kinds <= {"constant", "linear", "function"}:
            # Numbers of a hybrid system, which the one defuzzifier of the file does not suit.
            message = f"the terms of '{name}' are numbers or functions; their weighted average is taken"
            sets = f"fuzzylite takes their {kind} as sets that do not depend on the output"
            way_out = "put this output into a file of its own with DefuzzMethod='wtaver'"
            self.translation.differs(Reading(message, f"{sets}: mostly the middle of the range", way_out, place))
            kind, is_weighted = "weighted_average", True
        if self.is_fuzzylite and is_weighted:
            quantity = weighted(variable.sound, "Automatic", name, variable.name.span, self.translation)
            return self.profile.defuzzifier(KINDS[quantity][kind == "weighted_sum"])
        if is_weighted and self.type == "mamdani":
            message = "'wtaver' and 'wtsum' defuzzify Sugeno systems, and this one is of type 'mamdani'"
            help_text = "write: DefuzzMethod='centroid', or Type='sugeno'"
            self.translation.error("FZ214", message, place, help=help_text)
        elif not is_weighted and self.type == "sugeno":
            message = "this is a Sugeno system, whose consequents are not sets"
            self.translation.error("FZ214", message, place, help="write: DefuzzMethod='wtaver'")
        return self.profile.defuzzifier(kind)
