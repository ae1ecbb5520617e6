"""Inputs, outputs and terms from VAR, FUZZIFY and DEFUZZIFY blocks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal

from fuzzyctl.diagnostics.diagnostic import Note
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import Expr, Number
from fuzzyctl.formats.common import ranges
from fuzzyctl.formats.common.ranges import warn_of_degrees_beyond
from fuzzyctl.formats.common.report import Names
from fuzzyctl.formats.fll.methods import KINDS, weighted_kinds
from fuzzyctl.formulas import MEMBERSHIP, is_monotone
from fuzzyctl.model.block import Param, ParamValues
from fuzzyctl.model.variable import Fallback, Hold, Input, Term
from tests.oracles.fcl import syntax as sx
from tests.oracles.fcl.names import METHOD_WORDS
from tests.oracles.fcl.scope import Scope
from tests.oracles.fcl.settings import accumulation_of, norm_of, require_enabled
from tests.oracles.fcl.shapes import membership

#: Kinds of terms that are numbers or functions, not sets.
SHARP: Final = frozenset({"singleton", "constant", "linear", "function"})

_AVERAGES: Final = {"weighted_average": "tsukamoto", "weighted_sum": "tsukamoto_sum"}


@dataclass(frozen=True)
class OutputDraft:
    """An output before its norms are known.

    Args:
        name: Its name.
        lower: Lower end of its range.
        upper: Upper end.
        terms: Its terms.
        method: Kind of its defuzzifier.
        accumulation: What its own ACCU says.
        otherwise: What it is where no rule fires; None where nothing is said.
        clamped: Whether it is held within its range.
        block: The DEFUZZIFY block.
    """

    name: sx.Word
    lower: Expr
    upper: Expr
    terms: tuple[Term, ...]
    method: str
    accumulation: str | None
    otherwise: Expr | Fallback | Hold | None
    clamped: bool
    block: sx.FuzzyBlock


class VariableResolver:
    """Resolves the variables of a function block.

    Args:
        block: The function block.
        scope: Filled with the names declared, and with mistakes.
    """

    def __init__(self, block: sx.FunctionBlock, scope: Scope) -> None:
        self._block, self._scope = block, scope
        self._ranges: dict[str, sx.Range] = {}
        self._estimated: dict[str, sx.Word] = {}

    def declare(self) -> None:
        """Fill the scope with the declared names."""
        for block in self._block.variables:
            for declaration in block.declarations:
                self._declare(block.keyword, declaration)

    def _declare(self, keyword: sx.Word, declaration: sx.Declaration) -> None:
        scope, name = self._scope, declaration.name
        if keyword.upper == "VAR_IN_OUT":
            message = f"'{name.text}' is input and output at once, which is not available"
            scope.error("FZ602", message, name.span, help="declare an input and an output")
            return
        if name.text in scope.inputs or name.text in scope.outputs or name.text in scope.params:
            earlier = scope.inputs.get(name.text) or scope.outputs.get(name.text)
            notes = (Note(earlier.span, "first declared here"),) if earlier is not None else ()
            scope.error("FZ201", f"'{name.text}' is declared twice", name.span, help="rename one of them", notes=notes)
            return
        if declaration.range is not None:
            self._ranges[name.text] = declaration.range
        if keyword.upper == "VAR":
            self._local(declaration)
            return
        (scope.inputs if keyword.upper == "VAR_INPUT" else scope.outputs)[name.text] = name
        if declaration.initial is not None:
            message = f"the initial value of '{name.text}' has no effect"
            scope.warning("FZ603", message, name.span, help="DEFAULT says what an output is where no rule fires")

    def _local(self, declaration: sx.Declaration) -> None:
        name = declaration.name
        if isinstance(declaration.initial, Number) and math.isfinite(declaration.initial.value):
            self._scope.params[name.text] = Param(name=name.text, expression=declaration.initial, span=name.span)
            return
        message = f"'{name.text}' is neither input nor output nor a constant, so it has no effect"
        self._scope.warning("FZ603", message, name.span, help="give it a value: ':= 5'")

    def blocks(self, keyword: Literal["FUZZIFY", "DEFUZZIFY"]) -> dict[str, sx.FuzzyBlock]:
        """Return the blocks of one kind by the variable they belong to."""
        scope = self._scope
        known, others = (scope.inputs, scope.outputs) if keyword == "FUZZIFY" else (scope.outputs, scope.inputs)
        declared = "VAR_INPUT" if keyword == "FUZZIFY" else "VAR_OUTPUT"
        found: dict[str, sx.FuzzyBlock] = {}
        for block in self._block.fuzzy:
            if block.keyword.upper != keyword or not block.variable.text:
                continue
            name = scope.spelt(block.variable.text, known, block.variable.span)
            if name is None:
                text = block.variable.text
                hint = f"it stands in {'VAR_OUTPUT' if keyword == 'FUZZIFY' else 'VAR_INPUT'}" if text in others else ""
                message = f"{keyword} of '{text}', which {declared} does not declare"
                facts = (f"{declared}: {listed(known)}",) if known else ()
                help_text = hint or did_you_mean(text, known)
                scope.error("FZ202", message, block.variable.span, facts=facts, help=help_text)
            elif name in found:
                note = (Note(found[name].keyword.span, "the first one"),)
                message = f"a second {keyword} of '{name}'"
                scope.error("FZ215", message, block.keyword.span, help="put all terms into one", notes=note)
            else:
                found[name] = block
        return found

    def inputs(self) -> list[Input]:
        """Return the inputs, in the order declared."""
        blocks = self.blocks("FUZZIFY")
        found = []
        for name, word in self._scope.inputs.items():
            block = blocks.get(name)
            self._scope.readable = {name: name} | ({} if "x" in self._scope.inputs else {"x": name})
            terms = self._terms(block, of_output=False) if block is not None else ()
            clamped = False
            for setting in block.settings if block is not None else ():
                clamped = self._input_setting(setting) or clamped
            lower, upper = self._range(word, block, terms, held=clamped)
            self._warn_of_degrees_beyond(name, terms, lower, upper)
            found.append(
                Input(name=name, lower=lower, upper=upper, terms=terms, extrapolate=not clamped, span=word.span)
            )
        self._tell_estimated()
        return found

    def _warn_of_degrees_beyond(self, name: str, terms: tuple[Term, ...], lower: Expr, upper: Expr) -> None:
        low, high = self._scope.value(lower), self._scope.value(upper)
        if low is not None and high is not None:
            params = ParamValues(tuple(self._scope.params.values())).values
            warn_of_degrees_beyond(terms, name, (low, high), self._scope, params=params)

    def _input_setting(self, setting: sx.Setting) -> bool:
        """Return whether a setting holds the input within its range."""
        if setting.keyword.upper == "LOCK":
            return _says(setting, "RANGE")
        if setting.keyword.upper == "ENABLED":
            require_enabled(setting, self._scope)
        else:
            message = f"{setting.keyword.text} belongs to DEFUZZIFY"
            self._scope.error("FZ214", message, setting.span, help="remove it, or declare the variable in VAR_OUTPUT")
        return False

    def outputs(self, inputs: list[Input]) -> list[OutputDraft]:
        """Return the outputs that have a DEFUZZIFY block, in the order declared."""
        blocks = self.blocks("DEFUZZIFY")
        found: list[OutputDraft] = []
        for name, word in self._scope.outputs.items():
            block = blocks.get(name)
            if block is None:
                help_text = f"add: DEFUZZIFY {name} ... END_DEFUZZIFY"
                self._scope.error("FZ212", f"output '{name}' has no DEFUZZIFY block", word.span, help=help_text)
                continue
            if not block.terms:
                message = f"output '{name}' has no terms"
                self._scope.error("FZ212", message, block.variable.span, help="add, for example: TERM low := 0;")
            self._scope.readable = {n: n for n in (*self._scope.inputs, *(d.name.text for d in found))}
            found.append(self._output(word, block, inputs))
        return found

    def _output(self, word: sx.Word, block: sx.FuzzyBlock, inputs: list[Input]) -> OutputDraft:
        terms = self._terms(block, of_output=True)
        given = {s.keyword.upper: s for s in block.settings}
        lock, accu = given.get("LOCK"), given.get("ACCU")
        clamped = lock is not None and _says(lock, "RANGE")
        lower, upper = self._range(word, block, terms, inputs, held=clamped)
        if "ENABLED" in given:
            require_enabled(given["ENABLED"], self._scope)
        return OutputDraft(
            name=word,
            lower=lower,
            upper=upper,
            terms=terms,
            method=self._method(given.get("METHOD"), block, terms),
            accumulation=accumulation_of(accu, self._scope) if accu is not None else None,
            otherwise=self._otherwise(given.get("DEFAULT"), holds=lock is not None and _says(lock, "PREVIOUS")),
            clamped=clamped,
            block=block,
        )

    def _method(self, setting: sx.Setting | None, block: sx.FuzzyBlock, terms: tuple[Term, ...]) -> str:
        """Return the kind of the defuzzifier; report one of sets for numbers, or the other way round."""
        kind = norm_of(setting, METHOD_WORDS, self._scope) if setting is not None else None
        sharp = [t.membership.kind in SHARP for t in terms]
        kind = kind or "centroid"
        word = setting.word if setting is not None else None
        text = word.text if word is not None else "COG"
        place = setting.span if setting is not None else block.variable.span
        if kind not in _AVERAGES and terms and all(sharp):
            message = f"'{text}' is for sets; the terms of '{block.variable.text}' are numbers or functions"
            self._scope.warning("FZ603", message, place, help="their average is taken; write: METHOD : COGS;")
            return "weighted_average"
        if kind in _AVERAGES and not all(sharp):
            return self._of_sets(kind, text, block, terms, place)
        return kind

    def _of_sets(self, kind: str, text: str, block: sx.FuzzyBlock, terms: tuple[Term, ...], place: Span) -> str:
        """Return what an average takes of terms that are sets: their inverses, in fuzzylite else their degrees."""
        mixed = any(t.membership.kind in SHARP for t in terms)
        found = set() if mixed else weighted_kinds((t.membership for t in terms), "Automatic")
        if self._scope.dialect.name == "fuzzylite" and len(found) == 1:
            return KINDS[min(found)][kind == "weighted_sum"]
        if not mixed and self._scope.dialect.name != "fuzzylite" and all(self._monotone(t) for t in terms):
            return _AVERAGES[kind]
        message = f"'{text}' is for numbers; the terms of '{block.variable.text}' are sets"
        self._scope.error("FZ214", message, place, help="write METHOD : COG; or make the terms numbers")
        return kind

    def _monotone(self, term: Term) -> bool:
        given = [self._scope.value(a) for a in term.membership.arguments]
        return all(g is not None for g in given) and is_monotone(
            term.membership.kind, tuple(g for g in given if g is not None)
        )

    def _otherwise(self, setting: sx.Setting | None, *, holds: bool) -> Expr | Fallback | Hold | None:
        value: Expr | None = None
        for part in setting.values if setting is not None else ():
            if isinstance(part, sx.Word) and part.upper in ("NC", "NAN"):
                holds = holds or part.upper == "NC"
            elif isinstance(part, sx.Word):
                message = f"DEFAULT is a number or NC, not '{part.text}'"
                self._scope.error("FZ213", message, part.span, help="NC keeps the previous value")
            elif not (isinstance(part, Number) and math.isnan(part.value)):
                value = self._scope.number(part, "DEFAULT")
        if holds:
            return Hold(start=value if value is not None else "nan")
        if value is None and setting is not None:
            return "nan"
        return value

    def _terms(self, block: sx.FuzzyBlock, *, of_output: bool) -> tuple[Term, ...]:
        found: list[Term] = []
        first: dict[str, sx.Word] = {}
        names = Names()
        self._scope.empty_sets.clear()
        for line in block.terms:
            made = membership(line, self._scope, of_output=of_output)
            name = names.take(line.name.text)
            first.setdefault(line.name.text, line.name)
            if name != line.name.text:
                message = f"'{block.variable.text}' has two terms '{line.name.text}'; rules mean the first one"
                note = (Note(first[line.name.text].span, "the first one"),)
                help_text = f"the second is called '{name}' here; rename it"
                self._scope.warning("FZ604", message, line.name.span, help=help_text, notes=note)
            if made is not None:
                found.append(Term(name=name, membership=made, span=line.span))
        return tuple(found)

    def _range(
        self,
        word: sx.Word,
        block: sx.FuzzyBlock | None,
        terms: tuple[Term, ...],
        inputs: list[Input] | None = None,
        *,
        held: bool = False,
    ) -> tuple[Expr, Expr]:
        """Return the range that is given, or one estimated from the terms; one to be held within is never estimated."""
        given = (block.range if block is not None else None) or self._ranges.get(word.text)
        if given is not None:
            low = self._scope.number(given.low, "the lower end")
            high = self._scope.number(given.high, "the upper end")
            needs_range = held or not terms or (inputs is not None and not _all_sharp(terms))
            if needs_range or not self._is_point(low, high):
                return low or Number(0.0), high or Number(1.0)
        ends = self._estimate(terms, inputs or [])
        if given is not None:
            message = f"the RANGE of '{word.text}' is one point; its terms lie in [{ends[0]:.6g}, {ends[1]:.6g}]"
            help_text = "this is taken, which changes no value: nothing is held within it"
            self._scope.warning("FZ610", message, given.span, help=help_text)
            return Number(ends[0]), Number(ends[1])
        if block is not None and len(terms) < len(block.terms):
            return Number(ends[0]), Number(ends[1])  # terms with mistakes have their own diagnostics
        if inputs is None and not terms:
            message = f"input '{word.text}' has neither terms nor a range; [0, 1] is taken"
            self._scope.warning("FZ610", message, word.span, help=f"add: FUZZIFY {word.text} ... END_FUZZIFY")
        elif inputs is None:
            self._estimated[f"{word.text} [{ends[0]:.6g}, {ends[1]:.6g}]"] = word
        elif terms:
            taken = f"[{ends[0]:.6g}, {ends[1]:.6g}]"
            message = f"'{word.text}' has no RANGE; its terms lie in {taken}, which is taken"
            if any(t.membership.kind == "function" for t in terms):
                # Between the points its values may lie beyond, which no few points can tell.
                message = f"'{word.text}' has no RANGE; {taken} is taken, estimated from a few points of its functions"
            help_text = f"write: RANGE := ({ends[0]:.6g} .. {ends[1]:.6g});"
            self._scope.warning("FZ610", message, word.span, help=help_text)
        return Number(ends[0]), Number(ends[1])

    def _is_point(self, low: Expr | None, high: Expr | None) -> bool:
        """Return whether both ends of a range are the same number."""
        ends = [self._scope.value(e) if e is not None else None for e in (low, high)]
        return ends[0] is not None and ends[0] == ends[1]

    def _estimate(self, terms: tuple[Term, ...], inputs: list[Input]) -> tuple[float, float]:
        supports = [*self._scope.empty_sets] if terms else []
        for term in terms:
            if term.membership.kind in ("linear", "function"):
                found = self._image(term, inputs) if inputs else None
                supports.extend([found] if found is not None else [])
                continue
            given = [self._parameter(a) for a in term.membership.arguments]
            if all(g is not None for g in given):
                supports.append(MEMBERSHIP[term.membership.kind].extent(tuple(g for g in given if g is not None)))
        return ranges.of_terms(supports) or (0.0, 1.0)

    def _parameter(self, expr: Expr) -> float | None:
        return expr.value if isinstance(expr, Number) else self._scope.value(expr)

    def _image(self, term: Term, inputs: list[Input]) -> tuple[float, float] | None:
        """Return what values a consequent has that is a function."""
        ends: dict[str, tuple[float, float]] = {}
        for variable in inputs:
            low, high = self._scope.value(variable.lower), self._scope.value(variable.upper)
            ends[variable.name] = (low if low is not None else 0.0, high if high is not None else 1.0)
        values = {n: v for n, p in self._scope.params.items() if (v := self._scope.value(p.expression)) is not None}
        arguments = term.membership.arguments
        if term.membership.kind == "function":
            return ranges.of_function(arguments[0], ends, values)
        coefficients = [self._scope.value(a) or 0.0 for a in arguments]
        return ranges.linear_range(coefficients, ends.values())

    def _tell_estimated(self) -> None:
        """Say in one warning which ranges of inputs were estimated: the standard gives inputs none."""
        if self._estimated:
            message = f"inputs without RANGE: their terms lie in {listed(self._estimated, 6)}"
            first = next(iter(self._estimated.values()))
            help_text = "plots and proofs look at this range; values outside it are computed all the same"
            self._scope.warning("FZ610", message, first.span, help=help_text)


def _all_sharp(terms: tuple[Term, ...]) -> bool:
    """Return whether all terms are numbers or functions; an average of these needs no range."""
    return all(t.membership.kind in SHARP for t in terms)


def _says(setting: sx.Setting, word: str) -> bool:
    return any(isinstance(v, sx.Word) and v.upper == word for v in setting.values)
