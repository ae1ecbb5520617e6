"""Parser of `.fz` fragments given as Python strings: terms, rules, expressions, settings."""

from __future__ import annotations

import dataclasses
import re
import unicodedata
from typing import Final, TypeVar

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.expr import FUNCTIONS, ONE, Expr, Name, Number, as_number, replace
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.parser import parse
from fuzzyctl.model.block import Guarantee, Hedge
from fuzzyctl.model.method import Activation, Defuzzifier, Method, Semantics
from fuzzyctl.model.profiles import PROFILES, Profile
from fuzzyctl.model.rule import And, Antecedent, Cell, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.variable import Hold, Membership, Output
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.settings import resolve_method, resolve_semantics
from fuzzyctl.resolve.variables import resolve_variable
from fuzzyctl.support import arguments

#: A text that begins like a membership function or another consequent: a kind and its parameters.
_KIND: Final = re.compile(r"\s*([^\W\d]\w*)\s*\(.*\)\s*", re.DOTALL)

_RULE: Final = re.compile(r"\s*if\b")

_Statement = TypeVar("_Statement", bound=sx.Statement)


@dataclasses.dataclass(frozen=True)
class _Form:
    """A kind of fragment, and the statement around it that makes it a line of a file.

    Args:
        what: Its name in messages.
        written: How it is written: the help of a broken one.
        before: The text before it.
        after: The text after it.
    """

    what: str
    written: str
    before: str = ""
    after: str = ""


_EXPRESSION: Final = _Form("expression", "(k - 1) / 2", "param _ = ")
_RULE_FORM: Final = _Form("rule", "if INPUT is TERM and INPUT is TERM then OUTPUT is TERM weight 0.5")
_CONDITION: Final = _Form("condition", "INPUT is TERM and INPUT is TERM", "if ", " then _ is _")
_CELLS: Final = _Form("table row", "cells separated by blanks, such as: NB PS*0.5 . 0.25", "table _ = _\n  _\n  | ")
_GUARANTEE: Final = _Form("guarantee", "EXPRESSION >= EXPRESSION within 1e-12 when CONDITION", "require ")
_TERM: Final = _Form("term", "triangle(left, peak, right)", "output _ in [0, 1]\n  _ = ")
_HOLD: Final = _Form("value for 'otherwise'", "hold(START)", "output _ in [0, 1] else ")
_ACTIVATION: Final = _Form(
    "activation", "general | first(count=2, threshold=0.1) | highest(count=1) | threshold(>= 0.5)", "activation "
)
_SEMANTICS: Final = _Form("profile of numerics", "matlab | fuzzylite(least=0)", "semantics ")
_DEFUZZIFIER: Final = _Form("defuzzifier", "centroid | centroid(resolution=1000) | weighted_average", "defuzzifier ")


def _statement(form: _Form, text: str, kind: type[_Statement]) -> _Statement:
    """Parse the statement around a fragment.

    Raises:
        DiagnosticError: For an invalid text.
        ArgumentError: For several, for one of another kind, or for none at all.
    """
    text = arguments.text(f"the text of {_a(form.what)}", text)
    if not text.strip():
        raise ArgumentError(f"expected {_a(form.what)}, got an empty text; the form is: {form.written}")
    if arguments.no_character(text) is not None:
        raise _no(form, text)
    # A comment would swallow the text after it.
    tree, mistakes = parse(SourceText(f"<{form.what}>", f"{form.before}{text}{form.after}"))
    _refuse(form, text, mistakes)
    if len(tree.statements) != 1 or not isinstance(tree.statements[0], kind) or (form.after and "#" in text):
        raise _no(form, text)
    return tree.statements[0]


def _no(form: _Form, text: str) -> ArgumentError:
    return ArgumentError(f"{text!r} is not {_a(form.what)}; the form is: {form.written}")


def _a(what: str) -> str:
    return f"an {what}" if what[0] in "aeiou" else f"a {what}"


def _refuse(form: _Form, text: str, mistakes: list[Diagnostic]) -> None:
    """Raise the mistakes of a fragment, placed in the fragment alone."""
    if mistakes:
        raise DiagnosticError([_as_fragment(form, SourceText(f"<{form.what}>", text), d) for d in mistakes])


def _as_fragment(form: _Form, source: SourceText, d: Diagnostic) -> Diagnostic:
    if d.span is not None and form.after and d.span.start >= len(form.before) + len(source.text):
        d = dataclasses.replace(d, message=f"the {form.what} ends too early", facts=())
    # The help for `activation highest` is `activation highest(count=1)`; only the part behind the keyword belongs here.
    help_text = d.help.replace(f": {form.before}", ": ") if form.before else d.help
    if help_text.startswith("write: "):
        # The repaired line holds the text around the fragment.
        line = help_text.removeprefix("write: ").removeprefix(form.before.rpartition("\n")[2].lstrip())
        help_text = f"write: {line.removesuffix(form.after)}"
    if help_text.startswith("the form is: "):
        help_text = f"the form is: {form.written}"
    return dataclasses.replace(d, span=_moved(form, source, d.span), help=help_text, notes=())


def _moved(form: _Form, source: SourceText, span: Span | None) -> Span | None:
    if span is None:
        return None
    start, end = (min(max(at - len(form.before), 0), len(source.text)) for at in (span.start, span.end))
    return Span(source, min(start, max(len(source.text) - 1, 0)), end)


def _context(text: str) -> Context:
    """Return a context that knows every name of a text: whether there are such params is for the checks of a system."""
    words = re.findall(sx.NAME, unicodedata.normalize("NFC", text))
    nowhere = Span(SourceText("", ""), 0, 0)
    param = sx.Param(nowhere, sx.Word("_", nowhere), ONE, "")
    return Context(lost_input=True, params=dict.fromkeys(words, param))


def _placeless(expr: Expr) -> Expr:
    """Return an expression without locations, which would point into a generated statement."""
    return replace(expr, lambda n: dataclasses.replace(n, span=None) if isinstance(n, Number | Name) else n)


def expression(text: str) -> Expr:
    """Parse an expression such as `(k - 1) / 2`."""
    statement = _statement(_EXPRESSION, text, sx.Param)
    if statement.unit:
        raise _no(_EXPRESSION, text)
    return _placeless(statement.expression)


def membership(text: str) -> Membership | None:
    """Parse a kind with its parameters, such as `triangle(0, 1, 2, height=0.5)`; None for an expression."""
    kind = _KIND.fullmatch(text)
    if kind is None or kind[1] in FUNCTIONS:
        return None
    output = _output(_TERM, text)
    if len(output.terms) != 1:
        raise _no(_TERM, text)
    written = output.terms[0].membership
    return Membership(
        kind=written.kind, arguments=tuple(map(_placeless, written.arguments)), height=_placeless(written.height)
    )


def hold(text: str) -> Hold | None:
    """Parse `hold` and `hold(0.5)`; None for what else may stand behind `else`."""
    if text.strip() == "hold":
        return Hold()
    kind = _KIND.fullmatch(text)
    if kind is None or kind[1] != "hold":
        return None
    clauses = _statement(_HOLD, text, sx.Variable).clauses
    if len(clauses) != 1 or not isinstance(clauses[0], sx.FallbackClause) or not isinstance(clauses[0].value, sx.Held):
        raise _no(_HOLD, text)
    start = clauses[0].value.start
    return Hold(start="nan" if start == Name("nan") else _placeless(start))


def _output(form: _Form, text: str) -> Output:
    statement = _statement(form, text, sx.Variable)
    context = _context(text)
    output = resolve_variable(context, statement)
    _refuse(form, text, context.diagnostics)
    if not isinstance(output, Output):
        raise _no(form, text)
    return output


def activation(text: str) -> Activation:
    """Parse an activation method such as `highest(count=1)`."""
    method = _method(_ACTIVATION, text, sx.Activation).activation
    threshold = None if method.threshold is None else _placeless(method.threshold)
    return Activation(kind=method.kind, count=method.count, threshold=threshold, comparison=method.comparison)


def defuzzifier(text: str, profile: Profile = PROFILES["exact"]) -> Defuzzifier:
    """Parse a defuzzifier such as `centroid(resolution=1000)`; missing settings come from a profile."""
    return _method(_DEFUZZIFIER, text, sx.Setting, profile).defuzzifier


def semantics(text: str) -> Semantics:
    """Parse a profile with its knobs, such as `fuzzylite(least=0)`."""
    statement = _statement(_SEMANTICS, text, sx.Semantics)
    context = _context(text)
    result = resolve_semantics(context, [statement])
    _refuse(_SEMANTICS, text, context.diagnostics)
    return dataclasses.replace(result, span=None)


def _method(form: _Form, text: str, kind: type[sx.Statement], profile: Profile = PROFILES["exact"]) -> Method:
    statement = _statement(form, text, kind)
    context = _context(text)
    context.profile = profile
    method = resolve_method(context, [statement])
    _refuse(form, text, context.diagnostics)
    return method


def rule(text: str) -> Rule:
    """Parse a rule such as `if a is NB then f is NS weight 0.5`."""
    if _no_rule(text):
        raise _no(_RULE_FORM, text)
    statement = _statement(_RULE_FORM, text, sx.Rule)
    consequents = []
    for c in statement.consequents:
        term = _cell_term(c.term)
        consequents.append(Consequent(output=c.output.text, term=term, hedges=tuple(h.text for h in c.hedges)))
    weight = ONE if statement.weight is None else _placeless(statement.weight)
    return Rule(antecedent=_antecedent(statement.antecedent), consequents=tuple(consequents), weight=weight)


def _no_rule(text: object) -> bool:
    """Return whether a text begins like another line, whose own mistakes would not help."""
    return isinstance(text, str) and bool(text.strip()) and not _RULE.match(text)


def antecedent(text: str) -> Antecedent:
    """Parse the condition between `if` and `then`, or after `with`."""
    statement = _statement(_CONDITION, text, sx.Rule)
    if len(statement.consequents) != 1:
        raise _no(_CONDITION, text)
    return _antecedent(statement.antecedent)


def cells(text: str) -> tuple[Cell, ...]:
    """Parse the cells of one table row, such as `NB PS*0.5 . NB/PB 0.25 linear(1, 2, 3)`."""
    statement = _statement(_CELLS, text, sx.Table)
    if len(statement.rows) != 1:
        raise _no(_CELLS, text)
    return tuple(_cell(c) for c in statement.rows[0].cells)


def guarantee(text: str) -> Guarantee:
    """Parse the claim after `require`."""
    statement = _statement(_GUARANTEE, text, sx.Require)
    within, when = (None if e is None else _placeless(e) for e in (statement.within, statement.when))
    return Guarantee(claim=_placeless(statement.claim), within=within, when=when)


def hedge(name: str, text: str) -> Hedge:
    """Parse a hedge as an expression over `x`, such as `x ^ 3`."""
    return Hedge(name=name, parameter="x", expression=as_number(expression(text)))


def _cell(cell: sx.CellText) -> Cell:
    weight = ONE if cell.weight is None else _placeless(cell.weight)
    hedged = [t if isinstance(t, sx.HedgedTerm) else None for t in cell.terms]
    terms = tuple(_cell_term(t.term if isinstance(t, sx.HedgedTerm) else t) for t in cell.terms)
    hedges = tuple(() if h is None else tuple(w.text for w in h.hedges) for h in hedged)
    return Cell(terms=terms, weight=weight, hedges=hedges if any(hedges) else ())


def _cell_term(term: sx.ConsequentTerm) -> str | Membership:
    match term:
        case sx.Word():
            return term.text
        case sx.FunctionTerm():
            return _function(term)
    return Membership(kind="constant", arguments=(_placeless(term),))


def _function(term: sx.FunctionTerm) -> Membership:
    return Membership(kind=term.kind.text, arguments=tuple(as_number(_placeless(a)) for a in term.arguments))


def _antecedent(truth: sx.Truth) -> Antecedent:
    match truth:
        case sx.Literal(variable=variable, hedges=hedges, term=term):
            return Is(variable=variable.text, term=term.text, hedges=tuple(h.text for h in hedges))
        case sx.Negation(operand=operand):
            return Not(operand=_antecedent(operand))
        case sx.Group(operand=operand):
            return _antecedent(operand)
        case sx.Chain(connective=connective, operands=operands):
            parts = tuple(_antecedent(o) for o in operands)
            return And(operands=parts) if connective == "and" else Or(operands=parts)
    raise TypeError(type(truth).__name__)
