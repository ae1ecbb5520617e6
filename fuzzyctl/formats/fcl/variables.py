"""Inputs, outputs and their terms from VAR, FUZZIFY and DEFUZZIFY blocks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Note
from fuzzyctl.diagnostics.suggestions import counted, did_you_mean, listed
from fuzzyctl.expr import ONE, ZERO, Binary, Expr, Name, Number
from fuzzyctl.formats.common import ranges
from fuzzyctl.formats.common.ranges import warn_of_degrees_beyond
from fuzzyctl.formats.fcl.parser import VARIABLES, Block, Declaration, FunctionBlock, Range, Setting, TermLine
from fuzzyctl.formats.fcl.scope import Scope
from fuzzyctl.formats.fcl.words import JFUZZYLOGIC_SHAPES, SHAPE_WORDS, fuzzylite_word
from fuzzyctl.formats.fll.methods import KINDS, weighted_kinds
from fuzzyctl.formats.fll.shapes import TERMS
from fuzzyctl.formats.fll.terms import Place, TermReader, told_apart
from fuzzyctl.formulas import MEMBERSHIP, is_monotone
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.variable import Fallback, Hold, Membership, Term

#: Kinds of terms that are numbers or functions, not sets.
_CRISP: Final = frozenset({"singleton", "constant", "linear", "function"})

#: Averages and sums over rules, each with the one that inverts sets.
_AVERAGES: Final = {"weighted_average": "tsukamoto", "weighted_sum": "tsukamoto_sum"}


@dataclass
class Variable:
    """A variable of a function block.

    Args:
        name: Its name.
        is_input: Whether it is an input.
        block: Its FUZZIFY or DEFUZZIFY block; an empty one for an input without it.
        ends: Its range.
        terms: Its terms.
        supports: First and last point of each term that is 0 everywhere.
        clamped: Whether it is held within its range.
        method: The kind of the defuzzifier of an output.
        accumulation: The norm of ACCU in the block of an output.
        otherwise: The value of an output if no rule fires; None if the file does not name one.
    """

    name: sx.Word
    is_input: bool
    block: Block
    ends: tuple[Expr, Expr] = (ZERO, ONE)
    terms: list[Term] = field(default_factory=list)
    supports: list[tuple[float, float]] = field(default_factory=list)
    clamped: bool = False
    method: str = ""
    accumulation: str | None = None
    otherwise: Expr | Fallback | Hold | None = None

    @property
    def is_crisp(self) -> bool:
        """Whether all terms are numbers or functions; an average of these needs no range."""
        return all(t.membership.kind in _CRISP for t in self.terms)

    @property
    def names(self) -> list[str]:
        """Names of all terms, those included that could not be read."""
        return list(dict.fromkeys((*(line.name.text for line in self.block.terms), *(t.name for t in self.terms))))

    def add(self, clauses: Sequence[sx.Clause], scope: Scope) -> None:
        """Add the statement of the variable."""
        read = {t.name for t in self.terms}
        unread = [line.name for line in self.block.terms if line.name.text not in read]
        scope.variable("input" if self.is_input else "output", self.name, self.ends, self.terms, clauses, unread=unread)


class VariableReader:
    """Reader of the variables of a function block.

    Args:
        block: The function block.
        scope: Takes the declared names, params and diagnostics.

    Attributes:
        inputs: The inputs, in the order declared.
        outputs: The outputs that have a DEFUZZIFY block, in the order declared.
    """

    def __init__(self, block: FunctionBlock, scope: Scope) -> None:
        self._block, self._scope = block, scope
        self._ranges: dict[str, Range] = {}
        self._estimated: dict[str, sx.Word] = {}
        self.inputs: list[Variable] = []
        self.outputs: list[Variable] = []
        for part in block.of(*VARIABLES):
            for declaration in part.declarations:
                self._declare(part.keyword.text.upper(), declaration)
        self._read_inputs()
        self._read_outputs()

    def _declare(self, keyword: str, declaration: Declaration) -> None:
        scope, name = self._scope, declaration.name
        if keyword == "VAR_IN_OUT":
            message = f"'{name.text}' is input and output at once, which is not available"
            scope.error("FZ602", message, name.span, help="declare an input and an output")
        elif name.text in scope.inputs or name.text in scope.outputs or name.text in scope.params:
            scope.variable("input", name, (ZERO, ONE), ())  # a second one, which is an error
        elif keyword == "VAR":
            self._local(declaration)
        else:
            (scope.inputs if keyword == "VAR_INPUT" else scope.outputs)[name.text] = name
            if declaration.range is not None:
                self._ranges[name.text] = declaration.range
            if declaration.initial is not None:
                message = f"the initial value of '{name.text}' has no effect"
                help_text = "DEFAULT says what an output is where no rule fires"
                scope.warning("FZ603", message, name.span, help=help_text)

    def _local(self, declaration: Declaration) -> None:
        value, name = declaration.initial, declaration.name
        if isinstance(value, Number) and math.isfinite(value.value):
            self._scope.params[name.text] = value.value
            self._scope.statements.append(sx.Param(name.span, name, value, ""))
            return
        message = f"'{name.text}' is neither input nor output nor a constant, so it has no effect"
        self._scope.warning("FZ603", message, name.span, help="give it a value: ':= 5'")

    def _blocks(self, keyword: str) -> dict[str, Block]:
        """Return the blocks of a keyword by their variables."""
        scope, kinds = self._scope, [("VAR_INPUT", self._scope.inputs), ("VAR_OUTPUT", self._scope.outputs)]
        (keyword_here, variables), (keyword_there, others) = kinds if keyword == "FUZZIFY" else reversed(kinds)
        blocks: dict[str, Block] = {}
        for block in self._block.of(keyword):
            text, span = block.name.text, block.name.span
            if not text:
                continue
            name = scope.spelt(text, variables, span)
            if name is None:
                message = f"{keyword} of '{text}', which {keyword_here} does not declare"
                facts = (f"{keyword_here}: {listed(variables)}",) if variables else ()
                help_text = f"it stands in {keyword_there}" if text in others else did_you_mean(text, variables)
                scope.error("FZ202", message, span, facts=facts, help=help_text)
            elif name in blocks:
                notes = (Note(blocks[name].keyword.span, "the first one"),)
                message, help_text = f"a second {keyword} of '{name}'", "put all terms into one"
                scope.error("FZ215", message, block.keyword.span, help=help_text, notes=notes)
            else:
                blocks[name] = block
        return blocks

    # --- inputs and outputs ----------------------------------------------------------------------------------------

    def _read(self, name: sx.Word, block: Block, *, is_input: bool) -> Variable:
        """Return a variable with its terms and its range."""
        variable = Variable(name, is_input=is_input, block=block, clamped=block.has("LOCK", "RANGE"))
        self._terms(variable)
        self._range(variable)
        return variable

    def _read_inputs(self) -> None:
        scope, blocks = self._scope, self._blocks("FUZZIFY")
        for name, word in scope.inputs.items():
            scope.readable = {name: name} | ({} if "x" in scope.inputs else {"x": name})
            variable = self._read(word, blocks.get(name) or Block(word, word), is_input=True)
            self.inputs.append(variable)
            for setting in variable.block.settings:
                self._check_input_setting(setting)
            ends = scope.values(variable.ends)
            if ends is not None:
                warn_of_degrees_beyond(variable.terms, name, (ends[0], ends[1]), scope, params=scope.params)
        if self._estimated:  # one warning for all: the standard gives inputs no range
            message = f"inputs without RANGE: their terms lie in {listed(self._estimated, 6)}"
            help_text = "plots and proofs look at this range; values outside it are computed all the same"
            scope.warning("FZ610", message, next(iter(self._estimated.values())).span, help=help_text)

    def _check_input_setting(self, setting: Setting) -> None:
        keyword = setting.keyword.text
        if keyword.upper() == "ENABLED":
            self._scope.require_enabled(setting)
        elif keyword.upper() != "LOCK":
            help_text = "remove it, or declare the variable in VAR_OUTPUT"
            self._scope.error("FZ214", f"{keyword} belongs to DEFUZZIFY", setting.span, help=help_text)

    def _read_outputs(self) -> None:
        scope, blocks = self._scope, self._blocks("DEFUZZIFY")
        for name, word in scope.outputs.items():
            block = blocks.get(name)
            if block is None:
                help_text = f"add: DEFUZZIFY {name} ... END_DEFUZZIFY"
                scope.error("FZ212", f"output '{name}' has no DEFUZZIFY block", word.span, help=help_text)
                continue
            if not block.terms:
                help_text = "add, for example: TERM low := 0;"
                scope.error("FZ212", f"output '{name}' has no terms", block.name.span, help=help_text)
            scope.readable = {n: n for n in (*scope.inputs, *(v.name.text for v in self.outputs))}
            variable = self._read(word, block, is_input=False)
            self.outputs.append(variable)
            scope.require_enabled(block.setting("ENABLED"))
            variable.method = self._method(variable)
            variable.accumulation = scope.meaning(block.setting("ACCU"))
            variable.otherwise = self._otherwise(block.setting("DEFAULT"), holds=block.has("LOCK", "PREVIOUS"))

    def _method(self, variable: Variable) -> str:
        """Return the kind of the defuzzifier; report one of sets for numbers, or the other way round."""
        scope, terms, block = self._scope, variable.terms, variable.block
        setting = block.setting("METHOD")
        kind = scope.meaning(setting) or "centroid"
        text = setting.word.text if setting is not None and setting.word is not None else "COG"
        span = setting.span if setting is not None else block.name.span
        if kind not in _AVERAGES and terms and variable.is_crisp:
            message = f"'{text}' is for sets; the terms of '{block.name.text}' are numbers or functions"
            scope.warning("FZ603", message, span, help="their average is taken; write: METHOD : COGS;")
            return "weighted_average"
        if kind not in _AVERAGES or variable.is_crisp:
            return kind
        # Of sets fuzzylite takes their inverses or degrees, other tools the inverses of monotone ones.
        if not any(t.membership.kind in _CRISP for t in terms):
            kinds = weighted_kinds((t.membership for t in terms), "Automatic")
            if scope.dialect.name == "fuzzylite" and len(kinds) == 1:
                return KINDS[min(kinds)][kind == "weighted_sum"]
            if scope.dialect.name != "fuzzylite" and all(self._is_monotone(t.membership) for t in terms):
                return _AVERAGES[kind]
        message = f"'{text}' is for numbers; the terms of '{block.name.text}' are sets"
        scope.error("FZ214", message, span, help="write METHOD : COG; or make the terms numbers")
        return kind

    def _is_monotone(self, membership: Membership) -> bool:
        values = self._scope.values(membership.arguments)
        return values is not None and all(map(math.isfinite, values)) and is_monotone(membership.kind, values)

    def _otherwise(self, setting: Setting | None, *, holds: bool) -> Expr | Fallback | Hold | None:
        value: Expr | None = None
        for part in setting.values if setting is not None else ():
            if isinstance(part, sx.Word) and part.text.upper() in ("NC", "NAN"):
                holds = holds or part.text.upper() == "NC"
            elif isinstance(part, sx.Word):
                message = f"DEFAULT is a number or NC, not '{part.text}'"
                self._scope.error("FZ213", message, part.span, help="NC keeps the previous value")
            elif not (isinstance(part, Number) and math.isnan(part.value)):
                value = self._scope.constant(part, "DEFAULT")
        if holds:
            return Hold(start=value if value is not None else "nan")
        return "nan" if value is None and setting is not None else value

    # --- ranges ----------------------------------------------------------------------------------------------------

    def _range(self, variable: Variable) -> None:
        """Set the range to that of the file, or estimate it from the terms if the variable is not held within it."""
        scope, name, terms = self._scope, variable.name, variable.terms
        file_range = variable.block.range or self._ranges.get(name.text)
        if file_range is not None:
            low = scope.constant(file_range.low, "the lower end")
            high = scope.constant(file_range.high, "the upper end")
            is_needed = variable.clamped or not terms or not (variable.is_input or variable.is_crisp)
            first, last = (scope.value(e) if e is not None else None for e in (low, high))
            if is_needed or first is None or first != last:
                variable.ends = (low or ZERO, high or ONE)
                return
        start, end = self._estimate(variable)
        variable.ends = (Number(start), Number(end))
        interval = f"[{start:.6g}, {end:.6g}]"
        if file_range is not None:
            message = f"the RANGE of '{name.text}' is one point; its terms lie in {interval}"
            help_text = "this is taken, which changes no value: nothing is held within it"
            scope.warning("FZ610", message, file_range.span, help=help_text)
        elif len(terms) < len(variable.block.terms):
            pass  # terms with mistakes are reported
        elif variable.is_input and terms:
            self._estimated[f"{name.text} {interval}"] = name
        elif variable.is_input:
            message = f"input '{name.text}' has neither terms nor a range; [0, 1] is taken"
            scope.warning("FZ610", message, name.span, help=f"add: FUZZIFY {name.text} ... END_FUZZIFY")
        elif terms:
            reason = f"its terms lie in {interval}, which is taken"
            if any(t.membership.kind == "function" for t in terms):  # whose values may lie beyond between the points
                reason = f"{interval} is taken, estimated from a few points of its functions"
            help_text = f"write: RANGE := ({start:.6g} .. {end:.6g});"
            scope.warning("FZ610", f"'{name.text}' has no RANGE; {reason}", name.span, help=help_text)

    def _estimate(self, variable: Variable) -> tuple[float, float]:
        intervals = [*variable.supports] if variable.terms else []
        for membership in (t.membership for t in variable.terms):
            if membership.kind in ("linear", "function"):
                image = None if variable.is_input or not self.inputs else self._image(membership)
            else:
                values = self._scope.values(membership.arguments)
                image = MEMBERSHIP[membership.kind].extent(values) if values is not None else None
            intervals += [image] if image is not None else []
        return ranges.of_terms(intervals) or (0.0, 1.0)

    def _image(self, membership: Membership) -> tuple[float, float] | None:
        """Return the range of the values of a consequent that is a function."""
        ends: dict[str, tuple[float, float]] = {}
        for variable in self.inputs:
            low, high = (self._scope.value(e) for e in variable.ends)
            ends[variable.name.text] = (low if low is not None else 0.0, high if high is not None else 1.0)
        if membership.kind == "function":
            return ranges.of_function(membership.arguments[0], ends, self._scope.params)
        return ranges.linear_range([self._scope.value(a) or 0.0 for a in membership.arguments], ends.values())

    # --- terms -----------------------------------------------------------------------------------------------------

    def _terms(self, variable: Variable) -> None:
        scope = self._scope
        pairs = [(line, self._membership(line, variable)) for line in variable.block.terms]
        read = [(line, membership) for line, membership in pairs if membership is not None]
        terms = [Term(name=line.name.text, membership=m, span=line.name.span) for line, m in read]
        renamed = told_apart(terms, variable.block.name.text, scope, "rules mean the first one; rename it")
        variable.terms = [t.model_copy(update={"span": line.span}) for t, (line, _) in zip(renamed, read, strict=True)]

    def _membership(self, line: TermLine, variable: Variable) -> Membership | None:
        """Return the membership function of a term; report a mistake and return None."""
        scope, shape = self._scope, line.shape
        if line.formula is not None:
            return self._function(line, variable)
        subject = f"of '{line.name.text}'"
        constants = [scope.constant(a, f"parameter {i} {subject}") for i, a in enumerate(line.arguments, 1)]
        arguments = tuple(a for a in constants if a is not None)
        if len(arguments) < len(constants):
            return None
        if line.points and (line.kind is None or line.kind.text.upper() == "SINGLETONS"):
            return self._points(line, arguments, variable)
        if line.kind is None and len(arguments) == 1:
            return Membership(kind="singleton", arguments=arguments, span=shape)
        shapes = (f"shapes: {listed(SHAPE_WORDS)}",)
        if line.kind is None:
            message = f"{counted(len(arguments), 'number')} without the word of a shape"
            scope.error("FZ601", message, shape, facts=shapes)
            return None
        text = line.kind.text
        word = fuzzylite_word(text)
        meaning = TERMS[word] if word is not None else JFUZZYLOGIC_SHAPES.get(text.upper())
        if meaning is None or line.points:
            help_text = did_you_mean(text.upper(), SHAPE_WORDS)
            scope.error("FZ601", f"there is no shape '{text}'", line.kind.span, facts=shapes, help=help_text)
            return None
        most = {"Constant": 1, "Binary": 3}.get(word or "", len(arguments))
        if len(arguments) > most:
            scope.error("FZ303", f"'{word}' takes {counted(most, 'number')}, got {len(arguments)}", shape)
            return None
        scope.clamped_differences |= meaning is JFUZZYLOGIC_SHAPES["DSIGM"]
        place = Place(variable.name.text, tuple(scope.inputs), (), variable.is_input)
        reader = TermReader(scope, fuzzylite=word is not None, fll=word is not None)
        membership = reader.shape(place, line.kind.span, meaning, arguments, shape)
        if membership is not None and membership.kind == "constant":
            return membership.model_copy(update={"kind": "singleton"})
        return membership

    def _points(self, line: TermLine, arguments: tuple[Expr, ...], variable: Variable) -> Membership | None:
        scope, span = self._scope, line.shape
        if line.kind is not None:
            if len(arguments) == 2 and arguments[1] == ONE:
                return Membership(kind="singleton", arguments=arguments[:1], span=span)
            message = "a term of several singletons is not available"
            scope.error("FZ602", message, span, help="make a term of each point")
            return None
        values = [a.value for a in arguments if isinstance(a, Number)]
        if variable.is_input and len(values) == len(arguments) and not any(values[1::2]):
            variable.supports.append((min(values[::2]), max(values[::2])))
            message = "the term is 0 everywhere, so that no value belongs to it"
            scope.warning("FZ603", message, span, help="remove it, unless it is there to widen the range")
            return Membership(kind="function", arguments=(ZERO,), span=span)
        if len(arguments) == 2:  # constant from end to end
            x, y = arguments
            arguments = (x, y, Number(x.value + 1.0) if isinstance(x, Number) else x + 1.0, y)
        return Membership(kind="piecewise", arguments=arguments, span=span)

    def _function(self, line: TermLine, variable: Variable) -> Membership | None:
        assert line.formula is not None
        expression = self._scope.function(line.formula)
        if expression is None:
            return None
        coefficients = None if variable.is_input else linear_coefficients(expression, list(self._scope.inputs))
        if coefficients is not None:
            return Membership(kind="linear", arguments=coefficients, span=line.shape)
        return Membership(kind="function", arguments=(expression,), span=line.shape)


def linear_coefficients(expression: Expr, inputs: list[str]) -> tuple[Expr, ...] | None:
    """Return the coefficients of `a * x + b * y + c` with every input in order, as `write` writes a linear consequent.

    Any other sum stays a function, so that it is computed in the order in which it is written.
    """
    products: list[Expr] = []
    rest = expression
    while isinstance(rest, Binary) and rest.op == "+" and len(products) < len(inputs):
        products.append(rest.right)
        rest = rest.left
    constant, *products = [*products, rest]
    coefficients: list[Expr] = []
    for name, product in zip(inputs, reversed(products), strict=False):
        match product:
            case Binary(op="*", left=Number() as coefficient, right=Name(name=variable)) if variable == name:
                coefficients.append(coefficient)
    is_linear = isinstance(constant, Number) and len(products) == len(coefficients) == len(inputs)
    return (*coefficients, constant) if is_linear else None
