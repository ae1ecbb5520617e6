"""Builder of syntax nodes, driven by the grammar."""

from __future__ import annotations

import dataclasses
import math
import re
import unicodedata
from collections.abc import Sequence
from typing import Any, Final, TypeVar

from lark import Token, Transformer, v_args

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.lines import LogicalLine
from fuzzyctl.lang.mistakes import form_of, repair, too_deep

#: The characters of a name.
NAME_RULE: Final = "a name begins with a letter or '_' and goes on with letters, digits and '_'"

#: The factors of units of time and of percentages, as quotients, so that 5 ms is the double nearest to 0.005.
_UNITS: Final = {"us": (1, 1e6), "ms": (1, 1e3), "s": (1, 1), "min": (60, 1), "h": (3600, 1), "%": (1, 100)}

_Tree = TypeVar("_Tree", ex.Expr, sx.Truth)


@v_args(inline=True)
class Builder(Transformer[Token, Any]):
    """Turns the matches of the grammar into syntax nodes, bottom-up and without recursion."""

    def __init__(self) -> None:
        super().__init__()
        self.source = SourceText("", "")
        self.base = 0

    def begin(self, source: SourceText, line: LogicalLine) -> None:
        """Say which line is parsed next; `problems` then gathers what the grammar accepts but the language does not."""
        self.source, self.base, self.logical = source, line.start, line
        self.line = line.place(source)
        self.problems: list[Diagnostic] = []
        #: Levels of the parts that are bounded already, by their identity, with the parts, which must live as long.
        self.levels: dict[int, tuple[Any, int]] = {}

    def _at(self, token: Token) -> Span:
        assert token.start_pos is not None
        assert token.end_pos is not None
        return Span(self.source, self.base + token.start_pos, self.base + token.end_pos)

    def _word(self, token: Token) -> sx.Word:
        if len(token) > sx.MAX_NAME:
            message = f"the name has {len(token)} characters, more than {sx.MAX_NAME}"
            self.problems.append(Diagnostic("FZ107", message, self._at(token), help="shorten it"))
        text = unicodedata.normalize("NFC", str(token))
        if token.type in ("NAME", "MEMBER") and not all(part.isidentifier() for part in text.split(".")):
            # Such as ½ and ², which are letters to a regular expression but not to a reader.
            self.problems.append(
                Diagnostic("FZ105", f"'{_short(text)}' is not a name", self._at(token), help=NAME_RULE)
            )
        return sx.Word(text, self._at(token))

    def _float(self, token: Token) -> float:
        """Read a number; one that a double cannot hold is a mistake, not an infinity or a zero."""
        value = float(token)
        lost = value == 0.0 and any(c in "123456789" for c in token.lower().split("e")[0])
        if value == float("inf") or lost:
            bound = "larger than 1.8e308" if not lost else "smaller than 5e-324"
            self.problems.append(
                Diagnostic(
                    "FZ108",
                    f"the number {_short(token)} is {bound}",
                    self._at(token),
                    help="scale it; only a foot of a term, and an end of a range, may be 'inf'"
                    if not lost
                    else "write 0",
                )
            )
        return value

    def _bounded(self, root: _Tree) -> _Tree:
        """Refuse an expression or antecedent nested too deeply for later readers; without recursion."""
        stack, deepest = [(root, 1)], 1
        while stack:
            node, depth = stack.pop()
            if id(node) in self.levels:
                depth += self.levels[id(node)][1] - 1
            elif isinstance(node, sx.Chain):
                # A chain is computed from left to right: each operand is one level.
                depth += len(node.operands)
            elif isinstance(node, sx.Literal):
                depth += len(node.hedges)
            deepest = max(deepest, depth)
            if depth > ex.MAX_DEPTH:
                self.problems.append(too_deep(isinstance(root, sx.Truth), self.line))
                return root
            if id(node) not in self.levels:
                stack.extend((child, depth + 1) for child in _parts(node))
        self.levels[id(root)] = root, deepest
        return root

    def _words(self, tokens: tuple[Token, ...]) -> tuple[sx.Word, ...]:
        return tuple(self._word(t) for t in tokens)

    @staticmethod
    def _string(token: Token | None) -> str:
        return unicodedata.normalize("NFC", str(token)[1:-1]) if token is not None else ""

    # -- statements

    def fz(self, _keyword: Token, number: Token) -> sx.Version:
        return sx.Version(self.line, self._word(number))

    def system(self, _keyword: Token, name: Token, title: Token | None) -> sx.System:
        return sx.System(self.line, self._word(name), self._string(title))

    def citation(self, _keyword: Token, text: Token) -> sx.Citation:
        return sx.Citation(self.line, self._string(text))

    def setting(self, keyword: Token, value: Token, *options: sx.Option | None) -> sx.Setting:
        return sx.Setting(self.line, self._word(keyword), self._word(value), _present(options))

    def own_setting(self, keyword: Token, value: Token, *options: sx.Option | None) -> sx.SettingClause:
        setting = self.setting(keyword, value, *options)
        end = setting.options[-1].value.span if setting.options else setting.value.span
        return sx.SettingClause(setting, setting.keyword.span.to(end))

    def semantics(self, keyword: Token, profile: Token, *options: sx.Option | None) -> sx.Semantics:
        return sx.Semantics(self.line, self._word(keyword), self._word(profile), _present(options))

    def activation(self, keyword: Token, kind: Token, *options: sx.ActivationOption | None) -> sx.Activation:
        return sx.Activation(self.line, self._word(keyword), self._word(kind), _present(options))

    def activation_option(self, name: Token, value: ex.Expr) -> sx.ActivationOption:
        return sx.ActivationOption(self._word(name), value)

    comparison_option = activation_option

    def hedge(self, _keyword: Token, name: Token, parameter: Token, value: ex.Expr) -> sx.Hedge:
        return sx.Hedge(self.line, self._word(name), self._word(parameter), value)

    def use(self, _keyword: Token, path: Token) -> sx.Use:
        return sx.Use(self.line, self._string(path), self._at(path))

    def allow(self, keyword: Token, *rest: Token | None) -> sx.Allow:
        *codes, reason = rest
        return sx.Allow(self.line, self._word(keyword), self._words(tuple(c for c in codes if c)), self._string(reason))

    def with_(self, _keyword: Token, condition: sx.Truth) -> sx.With:
        return sx.With(self.line, condition)

    def option(self, name: Token, value: Token) -> sx.Option:
        return sx.Option(self._word(name), self._word(value))

    def param(
        self,
        _keyword: Token,
        name: Token,
        _in: Token | None,
        bounds: sx.Bounds | None,
        value: ex.Expr,
        _unit: Token | None,
        unit: Token | None,
    ) -> sx.Param:
        return sx.Param(self.line, self._word(name), value, self._string(unit), bounds)

    def bounds(self, left: Token, lower: ex.Expr, upper: ex.Expr, right: Token) -> sx.Bounds:
        return sx.Bounds(lower, upper, left == "(", right == ")", self._at(left).to(self._at(right)))

    # -- statements of controllers, plants and loops

    def head(self, keyword: Token, name: Token, title: Token | None, formula: ex.Expr | None = None) -> sx.Head:
        return sx.Head(self.line, self._word(keyword), self._word(name), self._string(title), formula)

    formula_head = head

    def function(self, _keyword: Token, name: Token, parameters: tuple[sx.Word, ...], value: ex.Expr) -> sx.Function:
        return sx.Function(self.line, self._word(name), parameters, value)

    def signal(
        self,
        keyword: Token,
        name: Token,
        label: Token | None,
        _in: Token | None,
        bounds: sx.Bounds | None,
        _unit: Token | None,
        unit: Token | None,
        value: ex.Expr | None = None,
    ) -> sx.Signal:
        text = self._string
        return sx.Signal(self.line, self._word(keyword), self._word(name), text(label), bounds, text(unit), value)

    defined = signal

    def equation(self, keyword: Token, name: Token, value: ex.Expr) -> sx.Equation:
        return sx.Equation(self.line, self._word(keyword), self._word(name), value)

    def every(self, _keyword: Token, period: ex.Expr) -> sx.Every:
        return sx.Every(self.line, period)

    def measure(
        self, keyword: Token, name: Token, label: Token | None, _unit: Token | None, unit: Token | None, value: ex.Expr
    ) -> sx.Signal:
        return self.signal(keyword, name, label, None, None, _unit, unit, value)

    def run(self, _keyword: Token, duration: ex.Expr, _step: Token | None, step: ex.Expr | None) -> sx.Run:
        return sx.Run(self.line, duration, step)

    def varied(self, _keyword: Token, name: Token, _in: Token, bounds: sx.Bounds) -> sx.Varied:
        return sx.Varied(self.line, self._word(name), bounds)

    def input(self, keyword: Token, *parts: Any) -> sx.Variable:
        at = next(i for i, p in enumerate(parts) if isinstance(p, Token) and p.type == "IN")
        (lower, upper), *clauses = parts[at + 1 :]
        declared = zip(self._words(parts[:at:2]), map(self._string, parts[1:at:2]), strict=True)
        (name, label), *others = declared
        word, rest = self._word(keyword), tuple(others)
        return sx.Variable(self.line, word, name, label, lower, upper, tuple(clauses), others=rest)

    def output(self, keyword: Token, *parts: Any) -> sx.Variable:
        *before, value = parts
        return dataclasses.replace(self.input(keyword, *before), value=value)

    def let(
        self,
        keyword: Token,
        name: Token,
        label: Token | None,
        _in: Token | None,
        ends: tuple[ex.Expr, ex.Expr] | None,
        unit: Token | None,
        text: Token | None,
        value: ex.Expr,
    ) -> sx.Variable:
        lower, upper = ends or (ex.Number(-math.inf), ex.Number(math.inf))
        clauses = (self.unit(unit, text),) if unit is not None and text is not None else ()
        word, variable = self._word(keyword), self._word(name)
        return sx.Variable(
            self.line, word, variable, self._string(label), lower, upper, clauses, value=value, ranged=ends is not None
        )

    def range(self, lower: ex.Expr, upper: ex.Expr) -> tuple[ex.Expr, ex.Expr]:
        return lower, upper

    def shared_terms(self, keyword: Token, _of: Token, variable: Token) -> sx.TermsClause:
        return sx.TermsClause(self._word(variable), self._at(keyword).to(self._at(variable)))

    def unit(self, keyword: Token, text: Token) -> sx.UnitClause:
        return sx.UnitClause(self._string(text), self._at(keyword).to(self._at(text)))

    def extrapolate(self, keyword: Token) -> sx.ExtrapolateClause:
        return sx.ExtrapolateClause(self._at(keyword))

    def clamp(self, keyword: Token) -> sx.ClampClause:
        return sx.ClampClause(self._at(keyword))

    def adaptive(self, keyword: Token, _rate: Token, rate: ex.Expr) -> sx.AdaptiveClause:
        return sx.AdaptiveClause(rate, self._to_last(keyword, (rate,)))

    def held(self, keyword: Token, start: ex.Expr) -> sx.Held:
        return sx.Held(start, self._to_last(keyword, (start,)))

    def fallback(self, keyword: Token, value: ex.Expr | sx.Held | Token) -> sx.FallbackClause:
        what = self._word(value) if isinstance(value, Token) else value
        place = ex.span_of(what) if isinstance(what, ex.Expr) else what.span
        return sx.FallbackClause(what, self._at(keyword).to(place or self._at(keyword)))

    def terms(self, _keyword: Token, *items: sx.PartitionItem) -> sx.TermsLine:
        return sx.TermsLine(self.line, items)

    def item(self, name: Token, peak: ex.Expr | None) -> sx.PartitionItem:
        return sx.PartitionItem(self._word(name), peak, None)

    def item_value(self, name: Token, value: ex.Expr) -> sx.PartitionItem:
        return sx.PartitionItem(self._word(name), None, value)

    def item_number(self, sign: Token | None, first: ex.Expr, *rest: Any) -> ex.Expr:
        value = first if sign is None else self.signed(sign, first)
        for operator, factor in zip(rest[::2], rest[1::2], strict=True):
            value = self.sum(value, operator, factor)
        return self._bounded(value)

    def table(
        self,
        _keyword: Token,
        outputs: tuple[sx.Word, ...],
        first: Token,
        _x: Token | None,
        second: Token | None,
        _scale: Token | None,
        scale: ex.Expr | None,
        _from: Token | None,
        csv: Token | None,
    ) -> sx.Table:
        word = self._word(second) if second is not None else None
        place = self._at(csv) if csv is not None else None
        return sx.Table(self.line, outputs, self._word(first), word, self._string(csv), place, scale=scale)

    def rules(self, _keyword: Token, name: Token, *settings: sx.Setting | sx.Activation) -> sx.Rules:
        return sx.Rules(self.line, self._word(name), settings)

    def names(self, *names: Token) -> tuple[sx.Word, ...]:
        return self._words(names)

    def rule(self, _if: Token, *parts: Any) -> sx.Rule:
        *rest, _weight, weight = parts
        antecedent, *exceptions = (p for p in rest if isinstance(p, sx.Truth))
        for exception in exceptions:
            antecedent = self._bounded(_except(antecedent, exception))
        return sx.Rule(self.line, antecedent, _consequents(rest), weight)

    def otherwise(self, _otherwise: Token, *parts: Any) -> sx.Otherwise:
        *rest, _weight, weight = parts
        return sx.Otherwise(self.line, _consequents(rest), weight)

    def consequent(self, output: Token, _is: Token, *words: Token | ex.Expr | sx.FunctionTerm) -> sx.ConsequentText:
        if not isinstance(words[0], Token):
            return sx.ConsequentText(self._word(output), words[0])
        hedges, term = self._hedged(tuple(w for w in words if isinstance(w, Token)))
        return sx.ConsequentText(self._word(output), term, hedges)

    def function_term(self, kind: Token, *arguments: ex.Expr | None) -> sx.FunctionTerm:
        values = _present(arguments)
        return sx.FunctionTerm(self._word(kind), values, self._to_last(kind, values))

    def require(
        self, _keyword: Token, claim: ex.Expr, _w: Token | None, within: ex.Expr | None, _when: Token | None, when: Any
    ) -> sx.Require:
        return sx.Require(self.line, claim, within, when)

    def always(self, _require: Token, _always: Token, claim: ex.Expr, *parts: Any) -> sx.Always:
        _within, within, _from, begin, _until, end, forever = parts
        return sx.Always(self.line, claim, within, None, begin, end, forever is not None)

    # -- lines below a statement

    def term_line(self, name: Token, kind: Token, *arguments: sx.Argument | None) -> sx.TermLine:
        return sx.TermLine(self.line, self._word(name), self._word(kind), _present(arguments))

    def argument(self, value: ex.Expr) -> sx.Argument:
        return sx.Argument(value, None, ex.span_of(value) or self.line)

    def keyword_argument(self, keyword: Token, value: ex.Expr) -> sx.Argument:
        word = self._word(keyword)
        return sx.Argument(value, word, word.span.to(ex.span_of(value) or word.span))

    def header(self, *terms: Token | sx.Word) -> sx.HeaderLine:
        return sx.HeaderLine(self.line, tuple(map(self._label_word, terms)))

    def label(self, term: Token | sx.Word) -> sx.Word:
        return self._label_word(term)

    def _label_word(self, term: Token | sx.Word) -> sx.Word:
        return self._word(term) if isinstance(term, Token) else term

    def number_label(self, sign: Token | None, number: Token) -> sx.Word:
        value = self.signed_number(sign, number)
        return sx.Word(ex.to_text(value), value.span or self.line)

    def row(self, label: Token | sx.Word | None, *cells: sx.CellText) -> sx.RowLine:
        return sx.RowLine(self.line, self._label_word(label) if label is not None else None, cells)

    def cell(self, *parts: Any) -> sx.CellText:
        *words, weight = parts
        terms = tuple(self._word(t) if isinstance(t, Token) else t for t in words if not _is_slash(t))
        first, last = _place(terms[0]) or self.line, _place(terms[-1]) or self.line
        return sx.CellText(terms, weight, first.to(last))

    def hedged(self, *words: Token) -> sx.HedgedTerm:
        hedges, term = self._hedged(words)
        return sx.HedgedTerm(hedges, term, self._at(words[0]).to(term.span))

    def _hedged(self, words: tuple[Token, ...]) -> tuple[tuple[sx.Word, ...], sx.Word]:
        """Return the hedges before a term, and the term."""
        *hedges, term = self._words(words)
        if words[-1].type == "NOT":
            self.problems.append(Diagnostic("FZ102", "'not' needs a term behind it", term.span))
        return tuple(hedges), term

    def empty_cell(self, dot: Token) -> sx.CellText:
        return sx.CellText((), None, self._at(dot))

    # -- antecedents

    def truth(self, inner: sx.Truth) -> sx.Truth:
        return self._bounded(inner)

    def literal(self, variable: Token, _is: Token, *words: Token) -> sx.Literal:
        hedges, term = self._hedged(words)
        return sx.Literal(self._at(variable).to(term.span), self._word(variable), hedges, term)

    def alternative(self, *words: Token) -> tuple[Token, ...]:
        return words

    def alternatives(self, variable: Token, is_: Token, *parts: Any) -> sx.Truth:
        """Read `e is (A or B)` as `(e is A or e is B)`, and behind `not` as its negation."""
        before = [p for p in parts if isinstance(p, Token) and p.type in ("NOT", "NAME")]
        connective = next(p for p in parts if isinstance(p, Token) and p.type in ("OR", "AND"))
        operands = tuple(self.literal(variable, is_, *p) for p in parts if isinstance(p, tuple))
        whole: sx.Truth = sx.Chain(operands[0].span.to(operands[-1].span), str(connective), operands)
        whole = sx.Group(whole.span, whole)
        for word in reversed(before):
            if word.type == "NAME":
                message = f"'{_short(word)}' applies to one term, not to several in parentheses"
                help_text = f"put it before each term: ({_short(word)} {operands[0].term.text} {connective} ...)"
                self.problems.append(Diagnostic("FZ102", message, self._at(word), help=help_text))
            whole = self.negation(word, whole)
        return whole

    def negation(self, keyword: Token, operand: sx.Truth) -> sx.Negation:
        return sx.Negation(self._at(keyword).to(operand.span), operand)

    def group(self, operand: sx.Truth) -> sx.Group:
        return sx.Group(operand.span, operand)

    def conjunction(self, *parts: Any) -> sx.Chain:
        operands = parts[::2]
        return sx.Chain(operands[0].span.to(operands[-1].span), "and", operands)

    def disjunction(self, *parts: Any) -> sx.Chain:
        operands = parts[::2]
        span = operands[0].span.to(operands[-1].span)
        mixed = next((o for o in operands if isinstance(o, sx.Chain)), None)
        if mixed is not None:
            self.problems.append(
                Diagnostic(
                    "FZ109",
                    "AND and OR are mixed without parentheses",
                    mixed.span,
                    facts=("AND binds tighter than OR here, but tools differ, and so may readers",),
                    help=f"write ({mixed.span.text}), or put parentheses where they are meant",
                )
            )
        return sx.Chain(span, "or", operands)

    # -- expressions

    def number(self, token: Token) -> ex.Number:
        return ex.Number(self._float(token), str(token), self._at(token))

    def quantity(self, token: Token) -> ex.Number:
        """Read a number with a unit of time [s] or a percentage."""
        number = re.match(r"[\d.]+(?:[eE][+-]?\d+)?", token)
        assert number is not None, "the grammar lets nothing else pass"
        factor, divisor = _UNITS[token[number.end() :].strip()]
        value = self._float(token.update(value=number[0])) * factor / divisor
        return ex.Number(value, str(token), self._at(token))

    def keyword(self, name: Token, value: ex.Expr) -> ex.Keyword:
        return ex.Keyword(self._word(name).text, value, self._to_last(name, (value,)))

    def pair(self, key: ex.Expr, value: ex.Expr) -> ex.Pair:
        span = self._join(key, value)
        end = ex.span_of(key)
        self._only_in_blocks("FZ105", self.source.text.index(":", end.end if end is not None else self.base), 1)
        return ex.Pair(key, value, span)

    def list(self, *tokens: Any) -> ex.Items:
        items = tuple(t for t in tokens if isinstance(t, ex.Expr))
        span = self._at(tokens[0]).to(self._at(tokens[-1]))
        self._only_in_blocks("FZ102", span.start, 1)
        return ex.Items(items, span)

    def text(self, token: Token) -> ex.Text:
        span = self._at(token)
        self._only_in_blocks("FZ102", span.start, len(token))
        return ex.Text(self._string(token), span)

    def _only_in_blocks(self, code: str, start: int, length: int) -> None:
        """Refuse an argument that only lines of controllers, plants and loops may have."""
        if not self.logical.in_block:
            span = Span(self.source, start, start + length)
            is_first = self.source.text[:start].rstrip().endswith("(")
            sign = ("')', ", "") if is_first else ("", "+ or -, ")
            expected = f"expected '(', {sign[0]}'not', 'quantity', {sign[1]}a name or a number"
            facts = (expected,) if code == "FZ102" else ()
            help_text = repair(self.source, self.logical, start) or form_of(self.logical)
            self.problems.append(Diagnostic(code, f"unexpected '{span.text}'", span, facts=facts, help=help_text))

    def name(self, token: Token) -> ex.Name:
        return ex.Name(self._word(token).text, self._at(token))

    def arith(self, inner: ex.Expr) -> ex.Expr:
        return self._bounded(inner)

    def claim(self, inner: ex.Expr) -> ex.Expr:
        return self._bounded(inner)

    def parenthesis(self, inner: ex.Expr) -> ex.Expr:
        # A number in parentheses is not a literal that a sign could belong to: -(1) negates, -1 is a number.
        return dataclasses.replace(inner, text=f"({inner.text})") if isinstance(inner, ex.Number) else inner

    def call(self, function: Token, *arguments: ex.Expr | None) -> ex.Call:
        values = _present(arguments)
        return ex.Call(self._word(function).text, values, self._to_last(function, values))

    def _to_last(self, word: Token, values: tuple[ex.Expr, ...]) -> Span:
        """Return the location from a word to the last of the values after the word."""
        end = ex.span_of(values[-1]) if values else None
        return self._at(word).to(end or self._at(word))

    def signed(self, operator: Token, operand: ex.Expr) -> ex.Expr:
        if operator == "+":
            return operand
        span = self._to_last(operator, (operand,))
        if isinstance(operand, ex.Number) and not operand.text.startswith(("-", "(")):
            return ex.Number(-operand.value, f"-{operand.text}", span)
        return ex.Negate(operand, span)

    def sum(self, left: ex.Expr, operator: Token, right: ex.Expr) -> ex.Binary:
        op: Any = str(operator)
        return ex.Binary(op, left, right, self._join(left, right))

    product = sum
    power = sum

    def comparison(self, left: ex.Expr, operator: Token | None, right: ex.Expr | None) -> ex.Expr:
        if operator is None or right is None:
            return left
        op: Any = str(operator)
        return ex.Compare(op, left, right, self._join(left, right))

    def membership(self, value: ex.Expr, _in: Token, bounds: sx.Bounds) -> ex.Logic:
        """Read `x in [low, high]` as `x >= low and x <= high`."""
        first = ex.span_of(value)
        span = None if first is None else first.to(bounds.span)
        above = ex.Compare(">" if bounds.without_lower else ">=", value, bounds.lower, span)
        below = ex.Compare("<" if bounds.without_upper else "<=", value, bounds.upper, span)
        return ex.Logic("and", (above, below), span)

    def claim_not(self, keyword: Token, operand: ex.Expr) -> ex.Logic:
        return ex.Logic("not", (operand,), self._to_last(keyword, (operand,)))

    def claim_and(self, *parts: Any) -> ex.Logic:
        return ex.Logic("and", parts[::2], self._join(parts[0], parts[-1]))

    def claim_or(self, *parts: Any) -> ex.Logic:
        return ex.Logic("or", parts[::2], self._join(parts[0], parts[-1]))

    def signed_number(self, sign: Token | None, token: Token) -> ex.Number:
        value, span = self._float(token), self._at(token)
        if sign is not None and sign == "-":
            return ex.Number(-value, f"-{token}", self._at(sign).to(span))
        return ex.Number(value, str(token), span)

    def value_expression(self, inner: ex.Expr) -> ex.Expr:
        return inner

    def _join(self, left: ex.Expr, right: ex.Expr) -> Span | None:
        first, last = ex.span_of(left), ex.span_of(right)
        return first.to(last) if first is not None and last is not None else first or last


def _except(antecedent: sx.Truth, exception: sx.Truth) -> sx.Truth:
    """Return `A and not B` for `A unless B`."""
    denied = sx.Negation(exception.span, sx.Group(exception.span, exception))
    is_joined = isinstance(antecedent, sx.Chain) and antecedent.connective == "and"
    operands = antecedent.operands if isinstance(antecedent, sx.Chain) and is_joined else (antecedent,)
    return sx.Chain(antecedent.span.to(exception.span), "and", (*operands, denied))


def _present(parts: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the parts of a line without the optional ones that it lacks."""
    return tuple(p for p in parts if p is not None)


def _consequents(parts: Sequence[Any]) -> tuple[sx.ConsequentText, ...]:
    return tuple(p for p in parts if isinstance(p, sx.ConsequentText))


def _is_slash(part: Any) -> bool:
    return isinstance(part, Token) and part.type != "NAME"


def _place(term: sx.ConsequentTerm | sx.HedgedTerm) -> Span | None:
    return ex.span_of(term) if isinstance(term, ex.Expr) else term.span


def _parts(node: Any) -> tuple[Any, ...]:
    if isinstance(node, ex.Expr):
        return ex.children(node)
    if isinstance(node, sx.Chain):
        return node.operands
    return (node.operand,) if isinstance(node, sx.Negation | sx.Group) else ()


def _short(text: str) -> str:
    return text if len(text) <= 24 else f"{text[:20]}…"
