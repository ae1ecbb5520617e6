"""Writer of `.fis` files."""

from __future__ import annotations

import math
from collections.abc import Iterator
from decimal import Decimal
from typing import Final

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import Binary, Expr, Name, Number
from fuzzyctl.formats.common.blocks import flattened
from fuzzyctl.formats.common.clamped_inputs import with_shoulders
from fuzzyctl.formats.common.identifiers import name_before
from fuzzyctl.formats.common.losses import (
    cannot,
    defuzzifier_of,
    formula_sets,
    impossible,
    losses_of,
    shares_terms,
    used_hedges,
    used_norms,
    value_unfired,
    with_named_consequents,
    with_numbers_averaged,
)
from fuzzyctl.formats.common.report import Findings
from fuzzyctl.formats.common.words import first_words
from fuzzyctl.formats.fis import vocabulary
from fuzzyctl.formats.fis.memberships import as_matlab_has_it, is_of_matlab, number, vector, written
from fuzzyctl.formats.fis.reader import read
from fuzzyctl.formats.fis.sections import split
from fuzzyctl.formats.fis.settings import dialect_of, family
from fuzzyctl.formats.fis.vocabulary import HEDGES, Dialect
from fuzzyctl.formats.fll.formulas import formula
from fuzzyctl.formats.fll.methods import as_inverted_there, inferred_otherwise
from fuzzyctl.formats.registry import Loss
from fuzzyctl.model.method import MAXIMA
from fuzzyctl.model.profiles import Profile, profile
from fuzzyctl.model.rule import And, Antecedent, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, LinguisticVariable, Membership, Output, Term


class WrittenRules:
    """The rules of a system.

    Args:
        system: The system, every consequent a term.
        dialect: Of the tool that is to read them.
        beyond_matlab: Whether it has what MATLAB cannot read anyway.
        reasons: Takes why they cannot be written.
        losses: Takes what they do not say.
    """

    def __init__(
        self, system: FuzzySystem, dialect: Dialect, beyond_matlab: bool, reasons: list[str], losses: list[Loss]
    ) -> None:
        self._system, self._dialect, self._beyond_matlab = system, dialect, beyond_matlab
        self._reasons, self._losses = reasons, losses
        self._powers = {h.name: power for h in system.hedges if (power := _power(h.expression)) is not None}

    def line(self, i: int, rule: Rule) -> str:
        """Return the line of a rule; `i` counts from 1."""
        where = f"rule {i}"
        connective, codes = self._antecedent(rule.antecedent, where)
        if not codes and self._dialect == "fuzzylite" and not self._reasons:
            # It reads no rule without a condition, and has a number for "any".
            connective, codes = 1, {self._some_input(): "0.99" if connective == 1 else "-0.99"}
        if_part = " ".join(codes.get(v.name, "0") for v in self._system.inputs)
        then_part = " ".join(self._consequent(o, rule, where) for o in self._system.outputs)
        return f"{if_part}, {then_part} ({number(self._system.number(rule.weight))}) : {connective}"

    def _some_input(self) -> str:
        return next((v for v in self._system.inputs if v.terms), self._system.inputs[0]).name

    def _antecedent(self, antecedent: Antecedent, where: str) -> tuple[int, dict[str, str]]:
        """Return the connective and the numbers of terms by variable."""
        connective = 2 if isinstance(antecedent, Or) else 1
        operands = antecedent.operands if isinstance(antecedent, And | Or) else (antecedent,)
        codes: dict[str, str] = {}
        for operand in _flat(operands, type(antecedent)):
            literal = _literal(operand)
            if literal is None:
                self._reasons.append(f"{where} mixes 'and', 'or' and 'not' of groups")
                continue
            if literal.hedges == ("any",) and connective == 1:
                continue
            if literal.variable in codes:
                self._reasons.append(f"{where} names '{literal.variable}' twice")
            if literal.variable not in [v.name for v in self._system.inputs]:
                self._reasons.append(f"{where} reads output '{literal.variable}'")
                continue
            if literal.hedges == ("not", "any"):
                connective = 2
                continue
            variable = self._system.input(literal.variable)
            codes[literal.variable] = self._code(variable, literal.term, literal.hedges, where)
        return connective, codes

    def _consequent(self, output: Output, rule: Rule, where: str) -> str:
        found = [c for c in rule.consequents if c.output == output.name]
        if not found:
            return "0"
        if len(found) > 1:
            self._reasons.append(f"{where} sets '{output.name}' twice")
        first: Consequent = found[0]
        assert isinstance(first.term, str)
        return self._code(output, first.term, first.hedges, where)

    def _code(self, variable: LinguisticVariable, term: str, hedges: tuple[str, ...], where: str) -> str:
        place = [t.name for t in variable.terms].index(term) + 1
        sign = ""
        while hedges and hedges[0] == "not":
            sign, hedges = "" if sign else "-", hedges[1:]
        fraction = self._fraction(hedges)
        if fraction is None:
            self._reasons.append(f"{where} has the hedges '{' '.join(hedges)}'")
            return "0"
        if fraction and self._beyond_matlab:
            self._losses.append(Loss(where, f"hedges '{' '.join(hedges)}'", "MATLAB has none; Octave reads them"))
        return f"{sign}{place + fraction:f}" if fraction else f"{sign}{place}"

    def _fraction(self, hedges: tuple[str, ...]) -> Decimal | None:
        if not hedges or hedges in HEDGES:
            return HEDGES.get(hedges, Decimal(0))
        if len(hedges) == 1 and hedges[0] in self._powers and self._dialect != "fuzzylite":
            return self._powers[hedges[0]] / 10
        return None


def _flat(operands: tuple[Antecedent, ...], kind: type[Antecedent]) -> Iterator[Antecedent]:
    """Yield the operands of a group, those of groups of the same kind within it as its own."""
    for operand in operands:
        if isinstance(operand, And | Or) and type(operand) is kind:
            yield from _flat(operand.operands, kind)
        else:
            yield operand


def _literal(antecedent: Antecedent) -> Is | None:
    """Return a proposition, with `not` before it as its first hedge; None for a group."""
    hedges: tuple[str, ...] = ()
    while isinstance(antecedent, Not):
        hedges, antecedent = (*hedges, "not"), antecedent.operand
    if not isinstance(antecedent, Is):
        return None
    return antecedent.model_copy(update={"hedges": (*hedges, *antecedent.hedges)})


def _power(expression: Expr) -> Decimal | None:
    """Return k for a hedge x^k that the digits behind a point can say."""
    match expression:
        case Binary(op="^", left=Name(), right=Number(value=exponent)):
            found = Decimal(repr(exponent))
            return found if 0 < found < 10 and found == round(found, 6) else None
    return None


_DEFUZZIFIERS: Final = {
    "centroid": "centroid",
    "bisector": "bisector",
    "mom": "mom",
    "som": "som",
    "lom": "lom",
    "weighted_average": "wtaver",
    "center_average": "wtaver",
    "weighted_sum": "wtsum",
    "tsukamoto": "wtaver",
    "inverse_tsukamoto": "wtaver",
    "tsukamoto_sum": "wtsum",
    "inverse_tsukamoto_sum": "wtsum",
}

_OF_SETS: Final = ("centroid", "bisector", *MAXIMA)


_CONJUNCTIONS: Final = first_words(vocabulary.CONJUNCTION_WORDS)
_DISJUNCTIONS: Final = first_words(vocabulary.DISJUNCTION_WORDS)
_AGGREGATIONS: Final = first_words(vocabulary.AGGREGATION_WORDS)


def write(system: FuzzySystem) -> tuple[str, list[Loss]]:
    """Return a system as a text, with what the text does not say.

    Raises:
        DiagnosticError: With all reasons, for a system that no `.fis` file can hold.
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
    found = losses_of(shown, back, nan_for_error=writer.dialect == "fuzzylite")
    return text, sorted({*losses, *more, *writer.losses, *found})


class _Writer:
    def __init__(self, system: FuzzySystem) -> None:
        self.losses: list[Loss] = []
        self.reasons: list[str] = []
        own = system.method.semantics.profile
        #: Whether MATLAB cannot read the file, though the numerics are not those of another tool.
        self.beyond_matlab = family(own) == "matlab" and _needs_octave(system)
        self.dialect: Dialect = "octave" if self.beyond_matlab else family(own)
        self.profile: Profile = profile(own if family(own) == self.dialect != "matlab" else self.dialect)
        self.system = system
        if self.dialect == "fuzzylite":
            self.system, self.reasons = as_inverted_there(self.system)
            self.reasons += inferred_otherwise(self.system)

    def text(self) -> str:
        """Return the text."""
        system = self.system
        self.reasons.extend(impossible(system))
        lines = [*self._head(), *self._variables(), "[Rules]"]
        rules = WrittenRules(system, self.dialect, self.beyond_matlab, self.reasons, self.losses)
        lines.extend(rules.line(i, rule) for i, rule in enumerate(system.rules, 1))
        if self.reasons:
            raise cannot(system, ".fis", self.reasons)
        text = "\n".join(lines) + "\n"
        if self.dialect == "matlab" and _seems_of_another(text):
            text = f"% numerics of matlab\n{text}"
        return text

    # --- the head ------------------------------------------------------------------------------------------------

    def _head(self) -> Iterator[str]:
        system, method = self.system, self.system.method
        if self.dialect != "matlab":
            yield f"% numerics of {self.profile.name}"
        yield "[System]"
        yield f"Name={_quoted(name_before(system.name, system.title))}"
        yield f"Type='{self._type()}'"
        yield "Version=2.0"
        yield f"NumInputs={len(system.inputs)}"
        yield f"NumOutputs={len(system.outputs)}"
        yield f"NumRules={len(system.rules)}"
        yield f"AndMethod='{self._norm(method.conjunction, _CONJUNCTIONS)}'"
        yield f"OrMethod='{self._norm(method.disjunction, _DISJUNCTIONS)}'"
        yield f"ImpMethod='{self._norm(self._common('implication'), _CONJUNCTIONS)}'"
        yield f"AggMethod='{self._norm(self._common('aggregation'), _AGGREGATIONS)}'"
        yield f"DefuzzMethod='{_DEFUZZIFIERS[self._kind()]}'"
        yield ""

    def _kinds(self) -> list[str]:
        return list(dict.fromkeys(defuzzifier_of(self.system, o).kind for o in self.system.outputs))

    def _is_hybrid(self) -> bool:
        """Whether some outputs are sets and others averages of numbers, which fuzzylite calls a hybrid system."""
        kinds = self._kinds()
        of_sets = [k for k in kinds if k in _OF_SETS]
        return self.dialect == "fuzzylite" and len(of_sets) == 1 and set(kinds) == {of_sets[0], "weighted_average"}

    def _kind(self) -> str:
        """Return the defuzzifier that the file names."""
        kinds = self._kinds()
        if self._is_hybrid():
            return next(k for k in kinds if k in _OF_SETS)
        if len({_DEFUZZIFIERS[k] for k in kinds}) > 1:
            self.reasons.append(f"outputs have several defuzzifiers: {', '.join(sorted(kinds))}")
        return kinds[0]

    def _type(self) -> str:
        kind = self._kind()
        if self._is_hybrid():
            for output in self.system.outputs:
                if defuzzifier_of(self.system, output).kind == "weighted_average":
                    reason = f"fuzzylite takes the {kind} of its terms as sets, mostly the middle of the range"
                    self._lose(f"output '{output.name}'", "defuzzifier weighted_average", reason)
            return "hybrid"
        if kind in _OF_SETS:
            return "mamdani"
        if "tsukamoto" not in kind:
            return "sugeno"
        if self.dialect != "fuzzylite":
            self.reasons.append(f"'{kind}' is a defuzzifier that only fuzzylite has; see: semantics fuzzylite")
        return "inverse tsukamoto" if kind.startswith("inverse") else "tsukamoto"

    def _common(self, field: str) -> str:
        """Return a norm that all outputs have; where they differ, that of the first to which it matters."""
        norms = [(o, getattr(o, field) or getattr(self.system.method, field)) for o in self.system.outputs]
        mattering = [(o, norm) for o, norm in norms if self._matters(o, field)]
        first: str = (mattering or norms)[0][1]
        return first

    def _matters(self, output: Output, field: str) -> bool:
        """Whether an output of sums over rules has a norm, too: some tools join those of one term first."""
        if not defuzzifier_of(self.system, output).over_rules:
            return True
        merge = self.profile.semantics.merge if field == "aggregation" else "rules"
        return merge == "places" or (merge == "terms" and shares_terms(self.system, output))

    def _norm(self, own: str, known: dict[str, str]) -> str:
        word = known.get(own)
        if word is None:
            self.reasons.append(f"there is no norm '{own}'")
            return own
        if word in vocabulary.BEYOND_MATLAB and self.beyond_matlab:
            self._lose(f"system '{self.system.name}'", f"norm '{own}'", "MATLAB has none; Octave reads it")
        return word

    def _lose(self, where: str, what: str, why: str, *, exact: bool = False) -> None:
        self.losses.append(Loss(where, what, why, exact))

    # --- variables -----------------------------------------------------------------------------------------------

    def _variables(self) -> Iterator[str]:
        for i, variable in enumerate(self.system.inputs, 1):
            yield f"[Input{i}]"
            yield from self._variable(variable)
            yield ""
        for i, output in enumerate(self.system.outputs, 1):
            yield f"[Output{i}]"
            yield from self._variable(output)
            yield ""

    def _variable(self, variable: LinguisticVariable) -> Iterator[str]:
        low, high = (self.system.number(end) for end in (variable.lower, variable.upper))
        yield f"Name={_quoted(name_before(variable.name, variable.label))}"
        yield f"Range={vector((low, high))}"
        if isinstance(variable, Output):
            yield from self._fallback(variable)
            if variable.clamped and self.dialect == "fuzzylite":
                yield "LockRange=1"
        yield f"NumMFs={len(variable.terms)}"
        for i, term in enumerate(variable.terms, 1):
            yield f"MF{i}={_quoted(term.name)}:{self._term(variable, term)}"

    def _fallback(self, output: Output) -> Iterator[str]:
        """Write what the output is where no rule fires, as far as the tool lets a file say so."""
        if self.dialect != "fuzzylite":
            return
        start = value_unfired(self.system, output)
        if start is not None:
            yield f"Default={number(start)}"
        if isinstance(output.otherwise, Hold):
            yield "LockPrevious=1"

    def _term(self, variable: LinguisticVariable, term: Term) -> str:
        membership = term.membership
        where = f"term '{term.name}' of '{variable.name}'"
        if membership.kind == "function":
            text = formula(membership.arguments[0], self.system.values)
            if self.dialect != "fuzzylite" or text is None:
                self.reasons.append(f"{where} is a formula")
            elif "," in text:  # it parts terms at commas, so that it refuses the whole file
                self.reasons.append(f"{where} is a formula with a function of several numbers")
            return f"'function',[{text}]"
        parameters = [self.system.number(a) for a in membership.arguments]
        height = self.system.number(membership.height)
        if membership.kind == "piecewise" and height == 1 and self.dialect != "fuzzylite":
            membership, height = as_matlab_has_it(membership, parameters)
            parameters = [self.system.number(a) for a in membership.arguments]
        if height != 1:
            return self._low(membership, parameters, height, where)
        if isinstance(variable, Input) and membership.kind in ("singleton", "constant"):
            # A constant is a consequent, and to fuzzylite a degree; a triangle without sides is 1 at one place.
            return f"'trimf',{vector(parameters * 3)}"
        found = written(membership.kind, parameters, fuzzylite=self.dialect == "fuzzylite")
        if found is None:
            self.reasons.append(f"{where} is of the kind '{membership.kind}'")
            return ""
        function, values = found
        if not is_of_matlab(function) and self.dialect != "fuzzylite":
            self._lose(where, f"the kind '{membership.kind}'", f"only fuzzylite reads '{function}'")
        return f"'{function}',{vector(values, 'inf' if self.dialect == 'fuzzylite' else 'Inf')}"

    def _low(self, membership: Membership, parameters: list[float], height: float, where: str) -> str:
        """Return a triangle below 1: a trapezoid whose tops are in reverse order, so that its sides cross before."""
        if membership.kind != "triangle" or not all(map(math.isfinite, parameters)):
            self.reasons.append(f"{where} has the height {height:.6g}")
            return ""
        left, peak, right = parameters
        return f"'trapmf',{vector((left, left + (peak - left) / height, right - (right - peak) / height, right))}"


def _needs_octave(system: FuzzySystem) -> bool:
    """Whether a system has norms or hedges that MATLAB does not have, and Octave does."""
    norms, hedges = used_norms(system), set().union(*used_hedges(system))
    return bool(norms - {"min", "product", "max", "probabilistic_sum", "sum"} or hedges - {"not", "any"})


def _seems_of_another(text: str) -> bool:
    """Whether a file without a comment would be taken for one of another tool than MATLAB, for a word that it has."""
    source = SourceText("written.fis", text)
    return dialect_of(split(source, Findings(source)), hedged=False) != "matlab"


def _quoted(text: str) -> str:
    """Return a name between quotes; line ends become blanks, which no name of a file can hold."""
    return "'" + " ".join(text.split()).replace("'", "''") + "'"
