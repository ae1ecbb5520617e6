"""Inputs, outputs and terms from VAR, FUZZIFY and DEFUZZIFY blocks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

from fuzzyctl.diagnostics.diagnostic import Note
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import Expr, Number
from fuzzyctl.formats.common import ranges
from fuzzyctl.formats.common.ranges import warn_of_degrees_beyond
from fuzzyctl.formats.fcl import syntax as fcl
from fuzzyctl.formats.fcl.names import ACCUMULATION_WORDS, METHOD_WORDS
from fuzzyctl.formats.fcl.scope import Scope
from fuzzyctl.formats.fcl.settings import norm_of, require_enabled
from fuzzyctl.formats.fcl.shapes import membership
from fuzzyctl.formats.fll.methods import KINDS, weighted_kinds
from fuzzyctl.formats.fll.terms import Place, told_apart
from fuzzyctl.formulas import MEMBERSHIP, is_monotone
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.variable import Fallback, Hold, Term

#: Kinds of terms that are numbers or functions, not sets.
SHARP: Final = frozenset({"singleton", "constant", "linear", "function"})

_AVERAGES: Final = {"weighted_average": "tsukamoto", "weighted_sum": "tsukamoto_sum"}

_NOWHERE: Final = (Number(0.0), Number(1.0))


@dataclass(frozen=True)
class Variable:
    """A variable of a function block.

    Args:
        name: Its name.
        ends: Its range.
        terms: Its terms.
        block: Its FUZZIFY or DEFUZZIFY block, None for none.
        clamped: Whether it is held within its range.
        method: Of an output the kind of its defuzzifier.
        accumulation: Of an output what its own ACCU says.
        otherwise: Of an output what it is where no rule fires; None where nothing is said.
    """

    name: fcl.Word
    ends: tuple[Expr, Expr]
    terms: Sequence[Term]
    block: fcl.FuzzyBlock | None
    clamped: bool
    method: str = ""
    accumulation: str | None = None
    otherwise: Expr | Fallback | Hold | None = None

    @property
    def unread(self) -> list[Span]:
        """Names of terms that could not be read."""
        read = {t.name for t in self.terms}
        written = self.block.terms if self.block is not None else ()
        return [t.name.span for t in written if t.name.text not in read]

    @property
    def names(self) -> list[str]:
        """Names of all terms, those included that could not be read."""
        written = self.block.terms if self.block is not None else ()
        return list(dict.fromkeys((*(t.name.text for t in written), *(t.name for t in self.terms))))

    def add(self, keyword: str, clauses: Sequence[sx.Clause], scope: Scope) -> None:
        """Add the statement of the variable."""
        word = sx.Word(self.name.text, self.name.span)
        scope.variable(keyword, word, self.ends, self.terms, clauses, unread=self.unread)


class VariableReader:
    """Reads the variables of a function block.

    Args:
        block: The function block.
        scope: Takes the names declared, params, and mistakes.
    """

    def __init__(self, block: fcl.FunctionBlock, scope: Scope) -> None:
        self._block, self._scope = block, scope
        self._ranges: dict[str, fcl.Range] = {}
        self._estimated: dict[str, fcl.Word] = {}
        for variables in block.variables:
            for declaration in variables.declarations:
                self._declare(variables.keyword, declaration)

    def _declare(self, keyword: fcl.Word, declaration: fcl.Declaration) -> None:
        scope, name = self._scope, declaration.name
        word = sx.Word(name.text, name.span)
        if keyword.upper == "VAR_IN_OUT":
            message = f"'{name.text}' is input and output at once, which is not available"
            scope.error("FZ602", message, name.span, help="declare an input and an output")
        elif name.text in scope.inputs or name.text in scope.outputs or name.text in scope.params:
            scope.variable("input", word, _NOWHERE, ())  # which is one name too many
        elif keyword.upper == "VAR":
            self._local(declaration, word)
        else:
            (scope.inputs if keyword.upper == "VAR_INPUT" else scope.outputs)[name.text] = name
            if declaration.range is not None:
                self._ranges[name.text] = declaration.range
            if declaration.initial is not None:
                message = f"the initial value of '{name.text}' has no effect"
                help_text = "DEFAULT says what an output is where no rule fires"
                scope.warning("FZ603", message, name.span, help=help_text)

    def _local(self, declaration: fcl.Declaration, word: sx.Word) -> None:
        value = declaration.initial
        if isinstance(value, Number) and math.isfinite(value.value):
            self._scope.params[word.text] = value.value
            self._scope.statements.append(sx.Param(word.span, word, value, ""))
            return
        message = f"'{word.text}' is neither input nor output nor a constant, so it has no effect"
        self._scope.warning("FZ603", message, word.span, help="give it a value: ':= 5'")

    def _blocks(self, keyword: Literal["FUZZIFY", "DEFUZZIFY"]) -> dict[str, fcl.FuzzyBlock]:
        """Return the blocks of one kind by the variable they belong to."""
        scope = self._scope
        known, others = (scope.inputs, scope.outputs) if keyword == "FUZZIFY" else (scope.outputs, scope.inputs)
        declared, other = ("VAR_INPUT", "VAR_OUTPUT") if keyword == "FUZZIFY" else ("VAR_OUTPUT", "VAR_INPUT")
        found: dict[str, fcl.FuzzyBlock] = {}
        for block in self._block.fuzzy:
            if block.keyword.upper != keyword or not block.variable.text:
                continue
            text, place = block.variable.text, block.variable.span
            name = scope.spelt(text, known, place)
            if name is None:
                message = f"{keyword} of '{text}', which {declared} does not declare"
                facts = (f"{declared}: {listed(known)}",) if known else ()
                help_text = f"it stands in {other}" if text in others else did_you_mean(text, known)
                scope.error("FZ202", message, place, facts=facts, help=help_text)
            elif name in found:
                message = f"a second {keyword} of '{name}'"
                notes = (Note(found[name].keyword.span, "the first one"),)
                scope.error("FZ215", message, block.keyword.span, help="put all terms into one", notes=notes)
            else:
                found[name] = block
        return found

    def inputs(self) -> list[Variable]:
        """Return the inputs, in the order declared."""
        blocks = self._blocks("FUZZIFY")
        found = [self._input(word, blocks.get(name)) for name, word in self._scope.inputs.items()]
        if self._estimated:  # one warning for all: the standard gives inputs none
            message = f"inputs without RANGE: their terms lie in {listed(self._estimated, 6)}"
            first = next(iter(self._estimated.values()))
            help_text = "plots and proofs look at this range; values outside it are computed all the same"
            self._scope.warning("FZ610", message, first.span, help=help_text)
        return found

    def _input(self, word: fcl.Word, block: fcl.FuzzyBlock | None) -> Variable:
        scope, name = self._scope, word.text
        scope.readable = {name: name} | ({} if "x" in scope.inputs else {"x": name})
        place = Place(name, tuple(scope.inputs), (), True)
        terms = self._terms(block, place) if block is not None else []
        clamped = [self._input_setting(s) for s in (block.settings if block is not None else ())]
        ends = self._range(word, block, terms, held=any(clamped))
        low, high = (scope.value(e) for e in ends)
        if low is not None and high is not None:
            warn_of_degrees_beyond(terms, name, (low, high), scope, params=scope.params)
        return Variable(word, ends, terms, block, any(clamped))

    def _input_setting(self, setting: fcl.Setting) -> bool:
        """Return whether a setting holds the input within its range."""
        if setting.keyword.upper == "LOCK":
            return _says(setting, "RANGE")
        if setting.keyword.upper == "ENABLED":
            require_enabled(setting, self._scope)
        else:
            help_text = "remove it, or declare the variable in VAR_OUTPUT"
            message = f"{setting.keyword.text} belongs to DEFUZZIFY"
            self._scope.error("FZ214", message, setting.span, help=help_text)
        return False

    def outputs(self, inputs: Sequence[Variable]) -> list[Variable]:
        """Return the outputs that have a DEFUZZIFY block, in the order declared."""
        scope, blocks = self._scope, self._blocks("DEFUZZIFY")
        found: list[Variable] = []
        for name, word in scope.outputs.items():
            block = blocks.get(name)
            if block is None:
                help_text = f"add: DEFUZZIFY {name} ... END_DEFUZZIFY"
                scope.error("FZ212", f"output '{name}' has no DEFUZZIFY block", word.span, help=help_text)
                continue
            if not block.terms:
                help_text = "add, for example: TERM low := 0;"
                scope.error("FZ212", f"output '{name}' has no terms", block.variable.span, help=help_text)
            scope.readable = {n: n for n in (*scope.inputs, *(v.name.text for v in found))}
            found.append(self._output(word, block, inputs))
        return found

    def _output(self, word: fcl.Word, block: fcl.FuzzyBlock, inputs: Sequence[Variable]) -> Variable:
        terms = self._terms(block, Place(word.text, tuple(self._scope.inputs), (), False))
        given = {s.keyword.upper: s for s in block.settings}
        lock = given.get("LOCK")
        clamped = lock is not None and _says(lock, "RANGE")
        ends = self._range(word, block, terms, inputs, held=clamped)
        require_enabled(given.get("ENABLED"), self._scope)
        method = self._method(given.get("METHOD"), block, terms)
        accumulation = norm_of(given.get("ACCU"), ACCUMULATION_WORDS, self._scope)
        otherwise = self._otherwise(given.get("DEFAULT"), holds=lock is not None and _says(lock, "PREVIOUS"))
        return Variable(word, ends, terms, block, clamped, method, accumulation, otherwise)

    def _method(self, setting: fcl.Setting | None, block: fcl.FuzzyBlock, terms: Sequence[Term]) -> str:
        """Return the kind of the defuzzifier; report one of sets for numbers, or the other way round."""
        kind = norm_of(setting, METHOD_WORDS, self._scope) or "centroid"
        sharp = [t.membership.kind in SHARP for t in terms]
        word = setting.word if setting is not None else None
        text = word.text if word is not None else "COG"
        place = setting.span if setting is not None else block.variable.span
        if kind not in _AVERAGES and terms and all(sharp):
            message = f"'{text}' is for sets; the terms of '{block.variable.text}' are numbers or functions"
            self._scope.warning("FZ603", message, place, help="their average is taken; write: METHOD : COGS;")
            return "weighted_average"
        if kind not in _AVERAGES or all(sharp):
            return kind
        # Of sets fuzzylite takes their inverses or degrees, other tools the inverses of monotone ones.
        fuzzylite = self._scope.dialect.name == "fuzzylite"
        found = weighted_kinds((t.membership for t in terms), "Automatic") if not any(sharp) else set()
        if fuzzylite and len(found) == 1:
            return KINDS[min(found)][kind == "weighted_sum"]
        if not fuzzylite and not any(sharp) and all(map(self._monotone, terms)):
            return _AVERAGES[kind]
        message = f"'{text}' is for numbers; the terms of '{block.variable.text}' are sets"
        self._scope.error("FZ214", message, place, help="write METHOD : COG; or make the terms numbers")
        return kind

    def _monotone(self, term: Term) -> bool:
        given = [self._scope.value(a) for a in term.membership.arguments]
        known = tuple(g for g in given if g is not None)
        return len(known) == len(given) and is_monotone(term.membership.kind, known)

    def _otherwise(self, setting: fcl.Setting | None, *, holds: bool) -> Expr | Fallback | Hold | None:
        value: Expr | None = None
        for part in setting.values if setting is not None else ():
            if isinstance(part, fcl.Word) and part.upper in ("NC", "NAN"):
                holds = holds or part.upper == "NC"
            elif isinstance(part, fcl.Word):
                message = f"DEFAULT is a number or NC, not '{part.text}'"
                self._scope.error("FZ213", message, part.span, help="NC keeps the previous value")
            elif not (isinstance(part, Number) and math.isnan(part.value)):
                value = self._scope.constant(part, "DEFAULT")
        if holds:
            return Hold(start=value if value is not None else "nan")
        return "nan" if value is None and setting is not None else value

    def _terms(self, block: fcl.FuzzyBlock, place: Place) -> list[Term]:
        self._scope.empty_sets.clear()
        made = [(line, membership(line, self._scope, place)) for line in block.terms]
        found = [Term(name=line.name.text, membership=m, span=line.name.span) for line, m in made if m is not None]
        help_text = "rules mean the first one; rename it"
        spans = [line.span for line, m in made if m is not None]
        named = told_apart(found, block.variable.text, self._scope, help_text)
        return [replace(t, span=span) for t, span in zip(named, spans, strict=True)]

    def _range(
        self,
        word: fcl.Word,
        block: fcl.FuzzyBlock | None,
        terms: Sequence[Term],
        inputs: Sequence[Variable] | None = None,
        *,
        held: bool = False,
    ) -> tuple[Expr, Expr]:
        """Return the range that is given, or one estimated from the terms; one to be held within is never estimated."""
        scope = self._scope
        given = (block.range if block is not None else None) or self._ranges.get(word.text)
        if given is not None:
            low, high = scope.constant(given.low, "the lower end"), scope.constant(given.high, "the upper end")
            is_needed = held or not terms or (inputs is not None and not _all_sharp(terms))
            first, last = (scope.value(e) if e is not None else None for e in (low, high))
            if is_needed or first is None or first != last:
                return low or Number(0.0), high or Number(1.0)
        start, end = self._estimate(terms, inputs or [])
        taken = f"[{start:.6g}, {end:.6g}]"
        if given is not None:
            message = f"the RANGE of '{word.text}' is one point; its terms lie in {taken}"
            help_text = "this is taken, which changes no value: nothing is held within it"
            scope.warning("FZ610", message, given.span, help=help_text)
        elif block is not None and len(terms) < len(block.terms):
            pass  # terms with mistakes have their own diagnostics
        elif inputs is None and not terms:
            message = f"input '{word.text}' has neither terms nor a range; [0, 1] is taken"
            scope.warning("FZ610", message, word.span, help=f"add: FUZZIFY {word.text} ... END_FUZZIFY")
        elif inputs is None:
            self._estimated[f"{word.text} {taken}"] = word
        elif terms:
            message = f"'{word.text}' has no RANGE; its terms lie in {taken}, which is taken"
            if any(t.membership.kind == "function" for t in terms):
                # Between the points its values may lie beyond, which no few points can tell.
                message = f"'{word.text}' has no RANGE; {taken} is taken, estimated from a few points of its functions"
            scope.warning("FZ610", message, word.span, help=f"write: RANGE := ({start:.6g} .. {end:.6g});")
        return Number(start), Number(end)

    def _estimate(self, terms: Sequence[Term], inputs: Sequence[Variable]) -> tuple[float, float]:
        supports = [*self._scope.empty_sets] if terms else []
        for term in terms:
            own = term.membership
            if own.kind in ("linear", "function"):
                image = self._image(term, inputs) if inputs else None
                supports += [image] if image is not None else []
                continue
            given = [a.value if isinstance(a, Number) else self._scope.value(a) for a in own.arguments]
            known = tuple(g for g in given if g is not None)
            supports += [MEMBERSHIP[own.kind].extent(known)] if len(known) == len(given) else []
        return ranges.of_terms(supports) or (0.0, 1.0)

    def _image(self, term: Term, inputs: Sequence[Variable]) -> tuple[float, float] | None:
        """Return what values a consequent has that is a function."""
        ends: dict[str, tuple[float, float]] = {}
        for variable in inputs:
            low, high = (self._scope.value(e) for e in variable.ends)
            ends[variable.name.text] = (low if low is not None else 0.0, high if high is not None else 1.0)
        arguments = term.membership.arguments
        if term.membership.kind == "function":
            return ranges.of_function(arguments[0], ends, self._scope.params)
        return ranges.linear_range([self._scope.value(a) or 0.0 for a in arguments], ends.values())


def _all_sharp(terms: Sequence[Term]) -> bool:
    """Return whether all terms are numbers or functions; an average of these needs no range."""
    return all(t.membership.kind in SHARP for t in terms)


def _says(setting: fcl.Setting, word: str) -> bool:
    return any(isinstance(v, fcl.Word) and v.upper == word for v in setting.values)
