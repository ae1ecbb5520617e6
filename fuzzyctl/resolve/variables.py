"""Resolution of params, inputs, outputs and their terms."""

from __future__ import annotations

import contextlib
import dataclasses
import re
from collections import ChainMap
from collections.abc import Iterator, Sequence
from typing import Any, Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.fixes import respelt
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.expr import to_text
from fuzzyctl.formulas import MEMBERSHIP, MembershipFormula
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.foreign import PEER_KINDS, differing_order, known_kind
from fuzzyctl.model.block import Bounds, Param
from fuzzyctl.model.variable import Fallback, Hold, Input, Let, Membership, Output, Term
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.functions import applied, expanded
from fuzzyctl.resolve.rules import is_garbled, resolve_function, terms_of
from fuzzyctl.resolve.settings import resolve_own_setting

#: Most terms of one variable; more are not a linguistic variable but a mistake of a generator.
MAX_TERMS: Final = 1000

_FALLBACKS: Final[tuple[Fallback, ...]] = ("midpoint", "nan", "error")
_TWO_NUMBERS: Final = re.compile(r"([-+]?[\d.]+)\s+([-+][\d.]+)")
#: Replaces an expression without a meaning: an undeclared name, which has no value.
_NO_VALUE: Final = ex.Name("")


def resolve_param(context: Context, statement: sx.Param) -> Param | None:
    """Resolve a `param`; the names it uses may be declared further down."""
    if not context.check_names(statement.expression, context.params, "param"):
        return None
    return Param(
        name=statement.name.text,
        expression=statement.expression,
        unit=statement.unit,
        bounds=resolve_bounds(context, statement.bounds),
        span=statement.name.span,
    )


def resolve_bounds(context: Context, bounds: sx.Bounds | None) -> Bounds | None:
    """Resolve a range whose ends may use params; None for none, and after a mistake."""
    if bounds is None or not all(
        [context.check_names(e, context.params, "param") for e in (bounds.lower, bounds.upper)]
    ):
        return None
    return Bounds(
        lower=bounds.lower,
        upper=bounds.upper,
        without_lower=bounds.without_lower,
        without_upper=bounds.without_upper,
        span=bounds.span,
    )


def resolve_variable(context: Context, statement: sx.Variable) -> Input | Output | Let:
    """Resolve an `input`, `output` or `let` with its terms; parts without a meaning are reported and left out."""
    lower, upper = (_end(context, e) for e in (statement.lower, statement.upper))
    statement = dataclasses.replace(statement, lower=lower, upper=upper)
    terms = _terms(context, statement)
    fields: dict[str, Any] = {
        "name": statement.name.text,
        "label": statement.label,
        "lower": statement.lower,
        "upper": statement.upper,
        "terms": tuple(terms),
        "span": statement.span if context.foreign else statement.name.span,
    }
    _clauses(context, statement, fields)
    if statement.keyword.text == "input":
        return Input(**fields)
    if statement.value is not None:
        fields["value"] = _formula(context, statement, statement.value)
    if statement.keyword.text == "let":
        return Let(**fields)
    return Output(**{"otherwise": context.profile.otherwise, **fields})


def _formula(context: Context, statement: sx.Variable, value: ex.Expr) -> ex.Expr:
    """Return the expression of a `let` or an `output`; a let is known before any rule, so it reads no output."""
    whole = expanded(context, value)
    if whole is None:
        return _NO_VALUE
    if statement.keyword.text == "let":
        names = ChainMap[str, Any](context.inputs, context.lets, context.params)
        formula = context.check_formula(_arguments_of(whole), names, "param, input or let")
        return _NO_VALUE if formula is None else ex.as_number(whole)
    for clause in statement.clauses:
        if not isinstance(clause, sx.UnitClause | sx.ClampClause):
            word = clause.span.text.split("(")[0].split()[0]
            message = f"output '{statement.name.text}' is a formula, and '{word}' needs rules"
            context.report("FZ214", message, clause.span, help=f"remove '{word}', or let rules set the output")
    return context.check_formula(whole, context.read, "param, input or output") or _NO_VALUE


def _arguments_of(expr: ex.Expr) -> ex.Expr:
    """Return an expression in which the arguments of calls of other systems take the place of these.

    Whether there are such systems is seen when all of them are read.
    """
    parts = [_arguments_of(part) for part in ex.children(expr)]
    if isinstance(expr, ex.Call) and "." in expr.function:
        return ex.Call("max", tuple(parts), expr.span) if parts else ex.ZERO
    return ex.rebuilt(expr, parts) if parts else expr


def _end(context: Context, end: ex.Expr) -> ex.Expr:
    return end if context.check_names(end, context.params, "param") else _NO_VALUE


def _clauses(context: Context, statement: sx.Variable, fields: dict[str, Any]) -> None:
    is_input = statement.keyword.text == "input"
    seen: set[str] = set()
    for clause in statement.clauses:
        what = clause.setting.keyword.text if isinstance(clause, sx.SettingClause) else type(clause).__name__
        if what in seen:
            context.report("FZ215", "a clause is given twice", clause.span, help="remove one of them")
        seen.add(what)
        match clause:
            case sx.UnitClause(text=text):
                fields["unit"] = text
            case sx.ExtrapolateClause(span=span):
                if _only(context, is_input, "extrapolate", "an input", span):
                    fields["extrapolate"] = True
            case sx.ClampClause(span=span):
                if _only(context, not is_input, "clamp", "an output", span):
                    fields["clamped"] = True
            case sx.FallbackClause(value=value, span=span):
                if _only(context, not is_input, "else", "an output", span):
                    fields["otherwise"] = _fallback(context, value)
            case sx.SettingClause(setting=setting, span=span):
                if _only(context, not is_input, setting.keyword.text, "an output", span):
                    resolve_own_setting(context, setting, fields)
            case sx.AdaptiveClause(rate=rate, span=span):
                if _only(context, not is_input, "adaptive", "an output", span):
                    fields["adaptive"] = rate
                names = ChainMap[str, Any](context.inputs, context.lets, context.params)
                context.check_names(rate, names, "param or input")


def _only(context: Context, right: bool, word: str, what: str, span: Any) -> bool:
    if not right:
        context.report("FZ214", f"'{word}' belongs to {what}", span, help="remove it")
    return right


def _fallback(context: Context, value: ex.Expr | sx.Word | sx.Held) -> ex.Expr | Fallback | Hold | None:
    if isinstance(value, sx.Held) and value.start == ex.Name("nan") and "nan" not in context.params:
        return Hold(start="nan")
    if isinstance(value, sx.Held):
        return Hold(start=value.start) if context.check_names(value.start, context.params, "param") else None
    if isinstance(value, sx.Word):
        if value.text == "hold":
            return Hold()
        for word in _FALLBACKS:
            if value.text == word:
                return word
        help_text = f"for a param write: else ({value.text})" if value.text in context.params else ""
        near = closest(value.text, (*_FALLBACKS, "hold"))
        context.report(
            "FZ213",
            f"'{value.text}' is not a value for 'else'",
            value.span,
            facts=(f"a number, an expression in parentheses, or one of: {', '.join(_FALLBACKS)}, hold",),
            help=help_text or (f"did you mean '{near}'?" if near else ""),
            fix=None if help_text else respelt(value.span, value.text, near, (*_FALLBACKS, "hold")),
        )
        return None
    return value if context.check_names(value, context.params, "param") else None


def _terms(context: Context, statement: sx.Variable) -> list[Term]:
    terms: list[Term] = []
    seen: dict[str, sx.Word] = {}
    if _too_many_terms(context, statement):
        return []
    for line in statement.terms:
        if isinstance(line, sx.TermsLine):
            new = partition(context, statement, line)
            words = [item.name for item in line.items]
        else:
            new = [_term(context, statement, line)]
            words = [line.name]
        if is_garbled(line):
            continue  # one message is enough
        for word, term in zip(words, new, strict=True):
            terms.extend([term] if _is_new_term(context, word, seen) and term is not None else [])
    if statement.terms and not statement.ranged:
        message = f"let '{statement.name.text}' has terms and no range"
        help_text = f"write: let {statement.name.text} in [low, high] = EXPRESSION"
        context.report("FZ212", message, statement.name.span, help=help_text)
        return []
    # An output whose rules give numbers or functions needs none, nor does an input that only functions or rates read.
    is_bare = not statement.terms and not statement.incomplete and statement.keyword.text == "input"
    is_needed = not context.has_functions and not context.foreign
    if is_bare and is_needed and not _is_read_by_a_rate(context, statement.name.text):
        message = f"{statement.keyword.text} '{statement.name.text}' has no terms"
        context.report("FZ212", message, statement.name.span, help="add lines such as: NB = triangle(-2, -1, 0)")
    return terms


def _too_many_terms(context: Context, statement: sx.Variable) -> bool:
    """Report a variable with more terms than are read; none of them is looked at then."""
    count = len(terms_of(statement))
    is_crowded = count > MAX_TERMS and not context.foreign
    if is_crowded:
        message = f"'{statement.name.text}' has {count} terms, more than {MAX_TERMS}"
        help_text = f"keep {MAX_TERMS}, or write a 'function'"
        context.report("FZ112", message, statement.name.span, help=help_text)
    return is_crowded


def _is_read_by_a_rate(context: Context, name: str) -> bool:
    rates = (c.rate for o in context.outputs.values() for c in o.clauses if isinstance(c, sx.AdaptiveClause))
    return any(name == n.name for rate in rates for n in ex.names_in(rate))


def _is_new_term(context: Context, word: sx.Word, seen: dict[str, sx.Word]) -> bool:
    if not context.is_free(word, "a term"):
        return False
    if word.text in seen:
        first = seen[word.text].span
        context.report(
            "FZ201",
            f"term '{word.text}' is declared twice",
            word.span,
            note=(first, "first declared here"),
            help="rename one",
        )
        return False
    seen[word.text] = word
    return True


def _term(context: Context, statement: sx.Variable, line: sx.TermLine) -> Term | None:
    is_input = statement.keyword.text != "output"
    if line.kind.text in ("linear", "function"):
        membership = _function(context, statement, line)
        return Term(name=line.name.text, membership=membership, span=line.span) if membership is not None else None
    formula = MEMBERSHIP.get(line.kind.text)
    if formula is None and line.kind.text in context.functions:
        return _own_kind(context, statement, line)
    if formula is None:
        kinds = [*MEMBERSHIP, "function", *([] if is_input else ["linear"]), *context.functions]
        _report_unknown_kind(context, line.kind, kinds)
        return None
    arguments = _arguments(context, line, formula)
    if arguments is None:
        return None
    parameters, height = arguments
    membership = Membership(kind=formula.name, arguments=parameters, height=height, span=line.kind.span)
    return Term(name=line.name.text, membership=membership, span=line.span)


def _own_kind(context: Context, statement: sx.Variable, line: sx.TermLine) -> Term | None:
    """Resolve a term that is a function of the file: of the variable, then of the parameters given."""
    named = next((a for a in line.arguments if a.keyword is not None), None)
    if named is not None:
        context.report("FZ303", f"'{line.kind.text}' takes no named parameters", named.span, help="drop the name")
        return None
    variable = ex.Name(statement.name.text, line.kind.span)
    whole = applied(context, line.kind, [variable, *(a.value for a in line.arguments)])
    if whole is None:
        return None
    argument, word = sx.Argument(whole, None, line.kind.span), sx.Word("function", line.kind.span)
    membership = _function(context, statement, dataclasses.replace(line, kind=word, arguments=(argument,)))
    return Term(name=line.name.text, membership=membership, span=line.span) if membership is not None else None


def _report_unknown_kind(context: Context, word: sx.Word, known: list[str]) -> None:
    """Report a word that is not a membership function, with the form of the one that it most likely means."""
    near = context.near(word.text, [*known, *PEER_KINDS])
    kind = near if near is None or near in known else known_kind(near)
    facts, help_text = [f"membership functions: {', '.join(known)}"], f"did you mean '{kind}'?" if kind else ""
    if near is not None and kind in MEMBERSHIP:
        help_text += f" the form is: {_form(MEMBERSHIP[kind])}"
        facts += filter(None, [differing_order(kind, near)])
    # A name of another tool may have its parameters in another order.
    fix = respelt(word.span, word.text, near, [*known, *PEER_KINDS]) if near in known else None
    context.report("FZ202", f"no membership function '{word.text}'", word.span, facts=facts, help=help_text, fix=fix)


def _form(formula: MembershipFormula) -> str:
    return f"{formula.name}({', '.join(formula.parameters)}{', ...' if formula.variadic else ''})"


def _function(context: Context, statement: sx.Variable, line: sx.TermLine) -> Membership | None:
    """Resolve `function(...)` of an input or an output, and `linear(...)` of an output."""
    named = [a for a in line.arguments if a.keyword is not None]
    if named and (line.kind.text == "function" or statement.keyword.text == "input"):
        context.report("FZ303", f"'{line.kind.text}' takes no named parameters", named[0].span, help="drop the name")
        return None
    is_set = line.kind.text == "function" and statement.name.text in {
        n.name for a in line.arguments for n in ex.names_in(a.value)
    }
    if statement.keyword.text == "output" and not is_set:
        arguments = (
            a.value if a.keyword is None else ex.Keyword(a.keyword.text, a.value, a.span) for a in line.arguments
        )
        return resolve_function(context, sx.FunctionTerm(line.kind, tuple(arguments), line.span))
    name = statement.name.text
    if line.kind.text == "linear":
        help_text = f"write a membership function, or: function(expression over {name})"
        context.report("FZ214", "'linear' is a consequent, for terms of an output", line.kind.span, help=help_text)
        return None
    if len(line.arguments) != 1:
        form = f"function(expression over {name})"
        context.report("FZ303", "'function' takes one expression", line.kind.span, help=f"the form is: {form}")
        return None
    names = ChainMap[str, Any]({name: None}, context.params)
    whole = expanded(context, line.arguments[0].value)
    expression = context.check_formula(whole, names, f"a param nor '{name}' itself") if whole is not None else None
    if expression is None:
        return None
    kind = "formula" if is_set and statement.keyword.text == "output" else "function"
    return Membership(kind=kind, arguments=(expression,), span=line.kind.span)


def _find_missing_comma(context: Context, argument: sx.Argument) -> None:
    """Warn of `-100 -45`, a difference that is spaced like two numbers."""
    spaced = _TWO_NUMBERS.fullmatch(argument.span.text)
    if spaced is not None:
        first, second = spaced.groups()
        help_text = f"for two parameters write '{first}, {second}', for one '{first} {second[0]} {second[1:]}'"
        message = f"'{spaced[0]}' is one parameter, a sum that is spaced like two"
        context.report("FZ113", message, argument.span, help=help_text, warning=True)


def _arguments(
    context: Context, line: sx.TermLine, formula: MembershipFormula
) -> tuple[tuple[ex.Expr, ...], ex.Expr] | None:
    """Return the parameters of a term in order, and its height."""
    form = _form(formula)
    by_name: dict[str, ex.Expr] = {}
    rest: list[ex.Expr] = []
    height: ex.Expr = ex.ONE
    named = False
    for i, argument in enumerate(line.arguments):
        _find_missing_comma(context, argument)
        if argument.keyword is None and not named and (i < len(formula.parameters) or formula.variadic):
            if i >= len(formula.parameters):
                rest.append(argument.value)
                continue
            name = formula.parameters[i]
        elif argument.keyword is not None and argument.keyword.text in (*formula.parameters, "height"):
            name, named = argument.keyword.text, True
        elif argument.keyword is not None:
            context.unknown("parameter", argument.keyword, (*formula.parameters, "height"), "FZ303")
            return None
        else:
            what = "surplus" if i >= len(formula.parameters) else "positional after a named one"
            context.report("FZ303", f"a parameter is {what}", argument.span, help=f"the form is: {form}")
            return None
        if name in by_name:
            message = f"parameter '{name}' is given twice"
            context.report("FZ303", message, argument.span, help=f"the form is: {form}")
            return None
        by_name[name] = argument.value
    if not all([context.check_names(e, context.params, "param") for e in (*by_name.values(), *rest)]):
        return None
    height = by_name.pop("height", height)
    missing = [p for p in formula.parameters if p not in by_name]
    if missing:
        message = f"'{formula.name}' lacks its parameter{'' if len(missing) == 1 else 's'} {', '.join(missing)}"
        context.report("FZ303", message, line.kind.span.to(line.span), help=f"the form is: {form}")
        return None
    return (*(by_name[p] for p in formula.parameters), *rest), height


#: Most terms of a system that variables have in common with others, each counted for each further variable.
MAX_SHARED: Final = 20_000


def share_terms(context: Context, statements: Sequence[sx.Statement]) -> Iterator[sx.Statement]:
    """Yield the statements, those of variables that share terms with the lines that they take over.

    Args:
        context: The declarations; its variables change, too.
        statements: All statements of a system.
    """
    first: set[int] = set()
    count = 0
    for s in statements:
        if not isinstance(s, sx.Variable):
            yield s
            continue
        clause = _clause(s)
        lines = _lines(context, s, clause) if clause is not None else s.terms
        if lines and id(lines) in first:
            before, count = count, count + len(terms_of(dataclasses.replace(s, terms=lines)))
            if before <= MAX_SHARED < count:
                context.report("FZ112", f"variables share more than {MAX_SHARED} terms", s.name.span)
            lines = lines if count <= MAX_SHARED else None
        first.add(id(lines))
        yield s if lines is s.terms else _changed(context, s, lines)


def _changed(
    context: Context, variable: sx.Variable, lines: tuple[sx.TermLine | sx.TermsLine, ...] | None
) -> sx.Variable:
    """Return a variable with other term lines, which it has in the context from now on; None for lines not known."""
    changed = dataclasses.replace(variable, terms=lines or (), incomplete=variable.incomplete or lines is None)
    for variables in (context.inputs, context.lets, context.outputs):
        if variables.get(variable.name.text) is variable:
            variables[variable.name.text] = changed
    return changed


def _clause(statement: sx.Statement) -> sx.TermsClause | None:
    clauses = statement.clauses if isinstance(statement, sx.Variable) else ()
    return next((c for c in clauses if isinstance(c, sx.TermsClause)), None)


def _lines(
    context: Context, variable: sx.Variable, clause: sx.TermsClause
) -> tuple[sx.TermLine | sx.TermsLine, ...] | None:
    """Return the lines that a variable takes over; None where there is a mistake, or was one in those lines."""
    name = clause.variable.text
    variables = {**context.inputs, **context.lets, **context.outputs}
    other = variables.get(name)
    if other is None:
        context.unknown("input or output", clause.variable, variables)
        return None
    source = _clause(other)
    if source is not None:
        of_itself = source.variable.text == variable.name.text or name == variable.name.text
        help_text = "" if of_itself else f"write: terms of {source.variable.text}"
        message = f"'{name}' has no terms of its own"
        context.report("FZ214", message, clause.variable.span, help=help_text or "write its terms below it")
        return None
    if variable.terms:
        message = f"the terms are those of '{name}', and terms are given below"
        context.report("FZ215", message, clause.span, help="remove one of them")
        return None
    if not _fits(variable, other):
        ranges = [f"'{v.name.text}' is in [{to_text(v.lower)}, {to_text(v.upper)}]" for v in (variable, other)]
        help_text = "give both one range and scale by a gain, or write the terms of each"
        message = f"the terms of '{name}' have numbers for another range"
        context.report("FZ214", message, clause.span, facts=(", ".join(ranges),), help=help_text)
        return None
    return None if other.incomplete else other.terms


def _fits(variable: sx.Variable, other: sx.Variable) -> bool:
    """Whether the terms of a variable have the same meaning for another one: bare names follow any range."""
    if (variable.lower, variable.upper) == (other.lower, other.upper):
        return True
    lines = [line for line in other.terms if not isinstance(line, sx.TermsLine)]
    items = [i for line in other.terms if isinstance(line, sx.TermsLine) for i in line.items]
    return not lines and all(i.peak is None and i.value is None for i in items)


_INFINITY = ex.Name("inf")
_RUN_IN: Final = re.compile(r"(.*?\D)(\d+)")


def partition(context: Context, statement: sx.Variable, line: sx.TermsLine) -> list[Term | None]:
    """Expand a `terms` line: triangles by their peaks, uniform triangles over the range, or singletons by value."""
    items = line.items
    kinds = {_item_form(i) for i in items}
    if len(kinds) > 1:
        odd = next(i for i in items if _item_form(i) != _item_form(items[0]))
        context.report(
            "FZ214",
            "one 'terms' line mixes peaks (@), values (=) and bare names",
            odd.name.span,
            help=_joined(items) or "give every term a peak, or every term a value, or none of them anything",
        )
        return [None] * len(items)
    if any(
        e is not None and not context.check_names(e, context.params, "param") for i in items for e in (i.peak, i.value)
    ):
        return [None] * len(items)
    if kinds == {"="}:
        return [_made("singleton", (i.value,), i.name) for i in items]
    if len(items) == 1:
        context.report("FZ214", "a partition needs two terms or more", items[0].name.span, help="write triangle(...)")
        return [None]
    peaks = [i.peak for i in items] if kinds == {"@"} else _uniform(statement, len(items))
    return [
        _made(
            "triangle",
            (peaks[k - 1] if k else ex.Negate(_INFINITY), p, peaks[k + 1] if k + 1 < len(peaks) else _INFINITY),
            i.name,
        )
        for k, (i, p) in enumerate(zip(items, peaks, strict=True))
    ]


def _item_form(item: sx.PartitionItem) -> str:
    return "@" if item.peak is not None else "=" if item.value is not None else ""


def _joined(items: Sequence[sx.PartitionItem]) -> str:
    """Say how a name is written that ran into its number, such as Z0 for Z@0 or Z=0."""
    sign = next(form for form in map(_item_form, items) if form)
    run = next((match for i in items if not _item_form(i) and (match := _RUN_IN.fullmatch(i.name.text))), None)
    return f"write {run[1]}{sign}{run[2]}" if run is not None else ""


def _uniform(statement: sx.Variable, count: int) -> list[ex.Expr]:
    """Peaks from end to end of the range: lower + k (upper - lower) / (count - 1), the ends themselves exact."""
    lower, upper = statement.lower, statement.upper
    if not any(isinstance(n, ex.Name | ex.Call) for e in (lower, upper) for n in ex.walk(e)):
        with contextlib.suppress(ex.ExprError):  # a range without a value has another diagnostic
            # Numbers, so that the system reads well when it is printed; the same as those of the expressions below.
            low, high = ex.evaluate(lower, {}), ex.evaluate(upper, {})
            inner = [(low * (count - 1 - k) + high * k) / (count - 1) for k in range(1, count - 1)]
            return [lower, *map(ex.Number, inner), upper]
    peaks: list[ex.Expr] = [lower]
    for k in range(1, count - 1):
        # A weighted mean of the ends is symmetric if the range is: the middle of [-a, a] is exactly 0.
        peaks.append((lower * float(count - 1 - k) + upper * float(k)) / float(count - 1))
    peaks.append(upper)
    return peaks


def _made(kind: str, arguments: tuple[ex.Expr | None, ...], word: sx.Word) -> Term:
    parameters = tuple(a for a in arguments if a is not None)
    return Term(name=word.text, membership=Membership(kind=kind, arguments=parameters, span=word.span), span=word.span)
