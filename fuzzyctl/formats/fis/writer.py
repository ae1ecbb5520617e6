"""Writer of `.fis` files."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.common.blocks import flattened
from fuzzyctl.formats.common.identifiers import name_before
from fuzzyctl.formats.common.losses import (
    aggregation_matters,
    cannot,
    defuzzifier_of,
    formula_sets,
    impossible,
    losses_of,
    used_hedges,
    used_norms,
    value_unfired,
    with_named_consequents,
    with_numbers_averaged,
)
from fuzzyctl.formats.common.ranges import with_shoulders
from fuzzyctl.formats.common.report import Findings
from fuzzyctl.formats.common.words import first_words
from fuzzyctl.formats.fis import dialects
from fuzzyctl.formats.fis.reader import read
from fuzzyctl.formats.fis.rules import RuleWriter
from fuzzyctl.formats.fis.sections import split
from fuzzyctl.formats.fis.shapes import OF_FUZZYLITE, number, written
from fuzzyctl.formats.fll.formulas import formula
from fuzzyctl.formats.fll.methods import KINDS, as_inverted_there, inferred_otherwise
from fuzzyctl.formats.registry import Loss
from fuzzyctl.model.method import MAXIMA
from fuzzyctl.model.profiles import Profile, profile
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, LinguisticVariable, Membership, Output, Term

_CONJUNCTIONS: Final = first_words(dialects.CONJUNCTION_WORDS)
_DISJUNCTIONS: Final = first_words(dialects.DISJUNCTION_WORDS)
_AGGREGATIONS: Final = first_words(dialects.AGGREGATION_WORDS)

#: Words of defuzzifiers; those of fuzzylite's methods are the same, and its type of the system tells them apart.
_DEFUZZIFIERS: Final[dict[str, str]] = {
    **first_words(dialects.DEFUZZIFIER_WORDS),
    "center_average": "wtaver",
    **{kind: word for pair in KINDS.values() for kind, word in zip(pair, ("wtaver", "wtsum"), strict=True)},
}

_OF_SETS: Final = ("centroid", "bisector", *MAXIMA)


def write(system: FuzzySystem) -> tuple[str, list[Loss]]:
    """Return a system as a text, with its losses.

    Raises:
        DiagnosticError: With all reasons, if no `.fis` file can hold the system.
    """
    if formulas := list(formula_sets(system)):
        raise cannot(system, ".fis", formulas)
    named, losses = with_named_consequents(system)
    averaged, more = with_numbers_averaged(named)
    # No key of a file holds inputs within their ranges, so shoulders do. (fuzzylite knows LockRange of outputs, and
    # refuses a file with that of an input.)
    shown = with_shoulders(averaged, points=False)
    writer = _Writer(flattened(shown))
    text = writer.text()
    back, _ = read(SourceText("written.fis", text))
    differences = losses_of(shown, back, nan_for_error=writer.is_fuzzylite)
    return text, sorted({*losses, *more, *writer.losses, *differences})


class _Writer:
    def __init__(self, system: FuzzySystem) -> None:
        self.losses: list[Loss] = []
        self.reasons: list[str] = []
        name = system.method.semantics.profile
        dialect = dialects.dialect_of_profile(name)
        #: Whether MATLAB cannot read the file, though the numerics are not those of another tool.
        self.beyond_matlab = dialect == "matlab" and _needs_octave(system)
        self.dialect: dialects.Dialect = "octave" if self.beyond_matlab else dialect
        self.profile: Profile = profile(name if dialect == self.dialect != "matlab" else self.dialect)
        self.is_fuzzylite = self.dialect == "fuzzylite"
        self.infinite = "inf" if self.is_fuzzylite else "Inf"
        self.system = system
        if self.is_fuzzylite:
            self.system, self.reasons = as_inverted_there(system)
            self.reasons += inferred_otherwise(self.system)

    def text(self) -> str:
        """Return the text."""
        self.reasons.extend(impossible(self.system))
        lines = [*self._head()]
        for kind, variables in (("Input", self.system.inputs), ("Output", self.system.outputs)):
            for i, variable in enumerate(variables, 1):
                lines += [f"[{kind}{i}]", *self._variable(variable), ""]
        rules = RuleWriter(self.system, self.dialect, self.beyond_matlab, self.reasons, self.losses)
        lines += ["[Rules]", *rules.lines()]
        if self.reasons:
            raise cannot(self.system, ".fis", self.reasons)
        text = "\n".join(lines) + "\n"
        if self.dialect == "matlab" and _seems_of_another(text):
            text = f"% numerics of matlab\n{text}"
        return text

    # --- the head ------------------------------------------------------------------------------------------------

    def _head(self) -> Iterator[str]:
        system, method = self.system, self.system.method
        type, defuzzifier = self._type_and_defuzzifier()
        if self.dialect != "matlab":
            yield f"% numerics of {self.profile.name}"
        yield "[System]"
        yield f"Name={_quoted(name_before(system.name, system.title))}"
        yield f"Type='{type}'"
        yield "Version=2.0"
        yield f"NumInputs={len(system.inputs)}"
        yield f"NumOutputs={len(system.outputs)}"
        yield f"NumRules={len(system.rules)}"
        yield f"AndMethod='{self._norm(method.conjunction, _CONJUNCTIONS)}'"
        yield f"OrMethod='{self._norm(method.disjunction, _DISJUNCTIONS)}'"
        yield f"ImpMethod='{self._norm(self._common('implication', 'rules'), _CONJUNCTIONS)}'"
        merge = self.profile.semantics.merge
        yield f"AggMethod='{self._norm(self._common('aggregation', merge), _AGGREGATIONS)}'"
        yield f"DefuzzMethod='{_DEFUZZIFIERS[defuzzifier]}'"
        yield ""

    def _type_and_defuzzifier(self) -> tuple[str, str]:
        """Return the type of the system, and the kind of the defuzzifier that the file names."""
        by_output = {o.name: defuzzifier_of(self.system, o).kind for o in self.system.outputs}
        kinds = list(dict.fromkeys(by_output.values()))
        of_sets = [k for k in kinds if k in _OF_SETS]
        if self.is_fuzzylite and len(of_sets) == 1 and set(kinds) == {of_sets[0], "weighted_average"}:
            why = f"fuzzylite takes the {of_sets[0]} of its terms as sets, mostly the middle of the range"
            for name, kind in by_output.items():
                if kind == "weighted_average":
                    self.losses.append(Loss(f"output '{name}'", "defuzzifier weighted_average", why))
            return "hybrid", of_sets[0]
        if len({_DEFUZZIFIERS[k] for k in kinds}) > 1:
            self.reasons.append(f"outputs have several defuzzifiers: {', '.join(sorted(kinds))}")
        kind = kinds[0]
        if kind in _OF_SETS or "tsukamoto" not in kind:
            return "mamdani" if kind in _OF_SETS else "sugeno", kind
        if not self.is_fuzzylite:
            self.reasons.append(f"'{kind}' is a defuzzifier that only fuzzylite has; see: semantics fuzzylite")
        return "inverse tsukamoto" if kind.startswith("inverse") else "tsukamoto", kind

    def _common(self, field: str, merge: str) -> str:
        """Return the norm of all outputs; if they differ, that of the first to which it matters."""
        norms = [(o, getattr(o, field) or getattr(self.system.method, field)) for o in self.system.outputs]
        mattering = [(o, norm) for o, norm in norms if aggregation_matters(self.system, o, merge)]
        first: str = (mattering or norms)[0][1]
        return first

    def _norm(self, norm: str, words: dict[str, str]) -> str:
        word = words.get(norm)
        if word is None:
            self.reasons.append(f"there is no norm '{norm}'")
            return norm
        if word in dialects.BEYOND_MATLAB and self.beyond_matlab:
            why = "MATLAB has none; Octave reads it"
            self.losses.append(Loss(f"system '{self.system.name}'", f"norm '{norm}'", why))
        return word

    # --- variables -----------------------------------------------------------------------------------------------

    def _variable(self, variable: LinguisticVariable) -> Iterator[str]:
        low, high = (self.system.number(end) for end in (variable.lower, variable.upper))
        yield f"Name={_quoted(name_before(variable.name, variable.label))}"
        yield f"Range=[{number(low)} {number(high)}]"
        if isinstance(variable, Output) and self.is_fuzzylite:  # no other tool lets a file say this
            start = value_unfired(self.system, variable)
            if start is not None:
                yield f"Default={number(start)}"
            if isinstance(variable.otherwise, Hold):
                yield "LockPrevious=1"
            if variable.clamped:
                yield "LockRange=1"
        yield f"NumMFs={len(variable.terms)}"
        for i, term in enumerate(variable.terms, 1):
            yield f"MF{i}={_quoted(term.name)}:{self._term(variable, term)}"

    def _term(self, variable: LinguisticVariable, term: Term) -> str:
        membership, where = term.membership, f"term '{term.name}' of '{variable.name}'"
        if membership.kind == "function":
            return self._formula(membership, where)
        kind, height = membership.kind, self.system.number(membership.height)
        parameters = tuple(self.system.number(a) for a in membership.arguments)
        if isinstance(variable, Input) and kind in ("singleton", "constant") and height == 1:
            # A constant is a consequent, and to fuzzylite a degree; a triangle without sides is 1 at one place.
            function, values = "trimf", parameters * 3
        elif shape := written(kind, parameters, height, fuzzylite=self.is_fuzzylite):
            function, values = shape
        else:
            self.reasons.append(
                f"{where} " + (f"has the height {height:.6g}" if height != 1 else f"is of the kind '{kind}'")
            )
            return ""
        if function in OF_FUZZYLITE and not self.is_fuzzylite:
            self.losses.append(Loss(where, f"the kind '{kind}'", f"only fuzzylite reads '{function}'"))
        return f"'{function}',[{' '.join(number(v, self.infinite) for v in values)}]"

    def _formula(self, membership: Membership, where: str) -> str:
        text = formula(membership.arguments[0], self.system.values)
        if not self.is_fuzzylite or text is None:
            self.reasons.append(f"{where} is a formula")
        elif "," in text:  # it parts terms at commas, so that it refuses the whole file
            self.reasons.append(f"{where} is a formula with a function of several numbers")
        return f"'function',[{text}]"


def _needs_octave(system: FuzzySystem) -> bool:
    """Whether a system has norms or hedges that MATLAB does not have, and Octave does."""
    norms, hedges = used_norms(system), set().union(*used_hedges(system))
    return bool(norms - {"min", "product", "max", "probabilistic_sum", "sum"} or hedges - {"not", "any"})


def _seems_of_another(text: str) -> bool:
    """Whether some word makes a file without a comment look like one of another tool than MATLAB."""
    source = SourceText("written.fis", text)
    return dialects.dialect_of(split(source, Findings(source)), hedges=False) != "matlab"


def _quoted(text: str) -> str:
    """Return a name between quotes; line ends become blanks, which no name of a file can hold."""
    return "'" + " ".join(text.split()).replace("'", "''") + "'"
