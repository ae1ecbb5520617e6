"""Reader of `.fis` files, with the settings of the tool that wrote them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import PurePath
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.expr import Expr, Number
from fuzzyctl.formats.common.ranges import linear_range
from fuzzyctl.formats.common.report import Findings, Reading
from fuzzyctl.formats.fll.methods import KINDS, profile_of_version, weighted_kinds
from fuzzyctl.model.method import Defuzzifier, Method
from fuzzyctl.model.profiles import Profile, profile
from fuzzyctl.model.rule import Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Fallback, Hold, Input, Membership, Output
from tests.oracles.fis import values
from tests.oracles.fis.rules import RuleReader, raw_rules
from tests.oracles.fis.sections import Section, Sections, split
from tests.oracles.fis.settings import Settings, dialect_of, fuzzylite_version, profile_of, read_settings
from tests.oracles.fis.variables import Variable, VariableReader, is_empty
from tests.oracles.fis.vocabulary import Dialect
from tests.oracles.fll.variables import corners, finite_range

#: A line that only FisPro's files have; they share the suffix and nothing else.
_FISPRO: Final = re.compile(r"^Ninputs[ \t]*=", re.MULTILINE)


def read(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Read a file.

    Returns:
        The system, None when there are errors, and all diagnostics in the order of their places.
    """
    findings = Findings(source)
    system = None
    if _FISPRO.search(source.text):
        message = "this is a file of FisPro, which has another form under the same suffix"
        findings.error("FZ602", message, None, help="files with [System], [Input1], [Output1] and [Rules] are read")
    else:
        system = _read(source, findings)
    return (None if findings.failed else system), findings.in_order()


def _read(source: SourceText, findings: Findings) -> FuzzySystem | None:
    file = split(source, findings)
    if not file.sections:
        if not findings.failed:
            findings.error("FZ004", "the file declares no system", None, help="a file begins with [System]")
        return None
    raw = raw_rules(file.of("rules"), findings)
    dialect = dialect_of(file, any(r.has_hedges for r in raw))
    settings = _settings(file, findings)
    inputs, outputs = _variables(file, dialect, findings)
    _check_counts(file, len(inputs), len(outputs), findings)
    rules = RuleReader(inputs, outputs, dialect, settings.kind == "sugeno", findings)
    blocks = tuple(rule for r in raw if (rule := rules.read(r)) is not None)
    if not raw and not findings.failed:
        header = file.of("rules")
        findings.error("FZ212", "the file has no rule", header[0].header if header else None)
    if findings.failed:
        return None
    assembly = _Assembly(file, settings, dialect, inputs, findings)
    return assembly.system(outputs, blocks, rules)


def _settings(file: Sections, findings: Findings) -> Settings:
    found = file.of("system")
    if not found:
        first = file.sections[0].header
        findings.error("FZ212", "there is no section [System]", first, help="a file begins with [System]")
        return read_settings(file, Section("system", 0, first), Findings(findings.source))
    for again in found[1:]:
        findings.given_twice("[System]", again.header, found[0].header)
    return read_settings(file, found[0], findings)


def _variables(file: Sections, dialect: Dialect, findings: Findings) -> tuple[list[Variable], list[Variable]]:
    found: dict[str, list[Variable]] = {}
    reader = VariableReader(len(file.of("input")), findings, dialect)
    for kind in ("input", "output"):
        sections = file.of(kind)
        if not sections:
            message = f"the file has no {kind}"
            findings.error("FZ212", message, None, help=f"write a section [{kind.title()}1]")
        numbers: dict[int, Section] = {}
        for section in sections:
            earlier = numbers.setdefault(section.number, section)
            if earlier is not section:
                findings.given_twice(section.header.text, section.header, earlier.header)
        found[kind] = [reader.read(s) for s in sections]
    return found["input"], found["output"]


def _check_counts(file: Sections, inputs: int, outputs: int, findings: Findings) -> None:
    """Compare the numbers that [System] says with those that are there."""
    rules = sum(len(s.entries) for s in file.of("rules"))
    for section in file.of("system")[:1]:
        for key, there in (("NumInputs", inputs), ("NumOutputs", outputs), ("NumRules", rules)):
            entry = section.entry(key)
            said = values.count(entry, findings) if entry is not None else None
            if entry is not None and said is not None and said != there:
                message = f"{key} says {said}, and there are {there}"
                findings.warning("FZ606", message, entry.value, help="all that are written count")


class _Assembly:
    """Put the parts of a file together.

    Args:
        file: The file.
        settings: What [System] says.
        dialect: Who wrote it.
        inputs: The inputs.
        findings: Where mistakes go.
    """

    def __init__(
        self, file: Sections, settings: Settings, dialect: Dialect, inputs: Sequence[Variable], findings: Findings
    ) -> None:
        self.file = file
        self.settings = settings
        self.dialect = dialect
        self.inputs = inputs
        self.findings = findings
        self.profile = _numerics(file, dialect)

    def system(self, outputs: Sequence[Variable], rules: tuple[Rule, ...], reader: RuleReader) -> FuzzySystem:
        """Return the system."""
        settings = self.settings
        sections = self.file.of("output")
        made = tuple(self._output(v, s) for v, s in zip(outputs, sections, strict=True))
        name = settings.name or PurePath(self.findings.source.name).stem
        common = {o.defuzzifier for o in made}
        method = Method(
            **settings.norms,
            defuzzifier=made[0].defuzzifier or self.profile.defuzzifier("centroid"),
            semantics=self.profile.semantics,
        )
        if len(common) == 1:
            made = tuple(o.model_copy(update={"defuzzifier": None}) for o in made)
        return FuzzySystem(
            name=name,
            hedges=tuple(reader.hedges.values()),
            method=method,
            inputs=tuple(self._input(v, s) for v, s in zip(self.inputs, self.file.of("input"), strict=True)),
            outputs=made,
            blocks=rules,
            path=self.findings.source.name,
        )

    def _input(self, variable: Variable, section: Section) -> Input:
        """Return an input; no tool clamps it to its range, except fuzzylite where the file says so."""
        terms = tuple(variable.terms[n] for n in sorted(variable.terms))
        lower, upper = variable.lower, variable.upper
        unbounded = self.dialect == "fuzzylite" and (math.isinf(lower.value) or math.isinf(upper.value))
        if unbounded:
            lower, upper = finite_range(variable, corners(t.membership for t in terms), self.findings)
        return Input(
            name=variable.name,
            lower=lower,
            upper=upper,
            terms=terms,
            extrapolate=not self._flag(section, "LockRange") or unbounded,
            span=variable.span,
        )

    def _output(self, variable: Variable, section: Section) -> Output:
        lower, upper = variable.lower, variable.upper
        otherwise = self._otherwise(section)
        if is_empty(variable) and self.settings.weighted:
            lower, upper = self._reached(variable)
        return Output(
            name=variable.name,
            lower=lower,
            upper=upper,
            terms=tuple(variable.terms[n] for n in sorted(variable.terms)),
            otherwise=otherwise,
            clamped=self._flag(section, "LockRange"),
            defuzzifier=self._defuzzifier(variable),
            span=variable.span,
        )

    def _reached(self, variable: Variable) -> tuple[Number, Number]:
        """Return a range for a Sugeno output that has none, such as [0 0].

        It reaches as far as its consequents do, and its middle is the number given: what MATLAB takes where no rule
        fires.
        """
        middle = variable.lower.value
        ends = [end for term in variable.terms.values() for end in self._ends(term.membership)]
        half = max((abs(e - middle) for e in ends if math.isfinite(e)), default=0.0) or 1.0
        low, high = middle - half, middle + half
        message = (
            f"the range of '{variable.name}' is empty; it becomes [{low:.6g}, {high:.6g}], as far as its terms reach"
        )
        help_text = "give it a range; only its middle counts, where no rule fires"
        self.findings.warning("FZ603", message, variable.lower.span, help=help_text)
        return Number(low), Number(high)

    def _ends(self, membership: Membership) -> tuple[float, ...]:
        """Return the least and largest value of a linear consequent within the ranges of the inputs."""
        given = [a.value for a in membership.arguments if isinstance(a, Number)]
        if membership.kind not in ("constant", "linear"):
            return tuple(given)
        return linear_range(given, [(v.lower.value, v.upper.value) for v in self.inputs])

    def _flag(self, section: Section, key: str) -> bool:
        """Return one of fuzzylite's switches, which other tools do not write."""
        entry = section.entry(key)
        if entry is None or self.dialect != "fuzzylite":
            return False
        return values.is_on(entry)

    def _otherwise(self, section: Section) -> Expr | Fallback | Hold | None:
        """Return what the output is where no rule fires."""
        entry = section.entry("Default")
        if self.dialect != "fuzzylite":
            return self.profile.otherwise
        default: Number | None = None
        if entry is not None and values.string(entry).text.lower() not in ("nan", "-nan"):
            found = values.vector(entry.value, self.findings)
            default = found[0] if found and len(found) == 1 else None
        if any(self._flag(section, key) for key in ("LockPrevious", "LockValid", "Lock")):
            return Hold(start=default if default is not None else "nan")
        return default if default is not None else "nan"

    def _defuzzifier(self, variable: Variable) -> Defuzzifier:
        """Return the defuzzifier of an output, with the samples of the tool."""
        kind = self.settings.defuzzifier
        entry = self.settings.entry
        place = entry.value if entry is not None else variable.span
        sums = kind.startswith("weighted")
        if self.settings.kind == "hybrid" and not sums and _is_sugeno(variable):
            self._warn_of_average(variable, kind, place)
            kind, sums = "weighted_average", True
        if self.dialect == "fuzzylite" and sums:
            return self.profile.defuzzifier(self._weighted(variable, kind))
        if sums and self.settings.kind == "mamdani":
            message = "'wtaver' and 'wtsum' defuzzify Sugeno systems, and this one is of type 'mamdani'"
            self.findings.error("FZ214", message, place, help="write: DefuzzMethod='centroid', or Type='sugeno'")
        elif not sums and self.settings.kind == "sugeno":
            message = "this is a Sugeno system, whose consequents are not sets"
            self.findings.error("FZ214", message, place, help="write: DefuzzMethod='wtaver'")
        return self.profile.defuzzifier(kind)

    def _warn_of_average(self, variable: Variable, kind: str, place: Span) -> None:
        """Say that numbers of a hybrid system, which the one defuzzifier of the file does not suit, are averaged."""
        message = f"the terms of '{variable.name}' are numbers or functions; their weighted average is taken"
        other = f"fuzzylite takes their {kind} as sets that do not depend on the output: mostly the middle of the range"
        way_out = "put this output into a file of its own with DefuzzMethod='wtaver'"
        self.findings.differs(Reading(message, other, way_out, place))

    def _weighted(self, variable: Variable, kind: str) -> str:
        """Return what fuzzylite's weighted defuzzifiers do with the terms of an output."""
        found = weighted_kinds((t.membership for t in variable.terms.values()), "Automatic") or {"function"}
        if len(found) > 1:
            message = f"the terms of '{variable.name}' are partly sets and partly numbers or functions"
            self.findings.error("FZ214", message, variable.span, help="use one sort of terms")
        return KINDS[min(found)][kind == "weighted_sum"]


def _is_sugeno(variable: Variable) -> bool:
    """Whether the terms of an output are numbers and functions; in a hybrid system one line names the defuzzifier."""
    kinds = {t.membership.kind for t in variable.terms.values()}
    return bool(kinds) and kinds <= {"constant", "linear", "function"}


def _numerics(file: Sections, dialect: Dialect) -> Profile:
    """Return how the tool computes that wrote a file, if no comment names other numerics."""
    said = profile_of(file)
    if said is None and dialect == "fuzzylite":
        return profile_of_version(fuzzylite_version(file))
    return profile(said or dialect)
