"""Resolution of rules and of the claims of `require` lines."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.fixes import Fix, Replacement, respelt, respelt_as_suggested, with_decimal_points
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import closest, counted, did_you_mean, listed, look_alikes
from fuzzyctl.formulas import HEDGES
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.mistakes import FORMS, RULE_WORDS, capital_keyword
from fuzzyctl.model.block import Guarantee
from fuzzyctl.model.rule import And, Antecedent, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.variable import Membership
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.functions import expanded

#: Most rules of one system, tables included.
MAX_RULES: Final = 20_000

#: Most outputs of one system; each may read others, and they are put in order before anything is computed.
MAX_OUTPUTS: Final = 200

#: Most operands of a disjunction that `otherwise` makes.
_BROAD: Final = 20

#: Words that end a rule elsewhere.
_ENDS: Final = frozenset({"end", "endif", "end_if"})

#: Placeholder for an unresolved antecedent in a system with errors; only its numbers are checked.
_UNKNOWN: Final = And(operands=())


def resolve_function(context: Context, term: sx.FunctionTerm) -> Membership | None:
    """Resolve a Takagi-Sugeno consequent: `constant(c)`, `linear(a, b, ..., c)`, `function(expression)`."""
    kind = term.kind.text
    arguments = _by_name(context, term) if any(isinstance(a, ex.Keyword) for a in term.arguments) else term.arguments
    if arguments is None:
        return None
    due = {"constant": 1, "function": 1}.get(kind, len(context.inputs) + 1)
    if len(arguments) != due and not (kind == "linear" and context.lost_input):
        form = f"linear({', '.join([*(f'per {name}' for name in context.inputs), 'constant'])})"
        help_text = f"the form is: {form if kind == 'linear' else kind + '(expression)'}"
        message = f"'{kind}' takes {counted(due, 'parameter')}, not {len(arguments)}"
        fix = with_decimal_points(term.span, len(arguments), due)
        context.report("FZ303", message, term.span, help=help_text, fix=fix)
        return None
    if kind == "function":
        whole = expanded(context, arguments[0])
        formula = context.check_formula(whole, context.read, "param, input or output") if whole is not None else None
        return None if formula is None else Membership(kind=kind, arguments=(formula,), span=term.span)
    if not all([context.check_names(a, context.params, "param") for a in arguments]):
        return None
    return Membership(kind=kind, arguments=arguments, span=term.span)


def _by_name(context: Context, term: sx.FunctionTerm) -> tuple[ex.Expr, ...] | None:
    """Return the parameters of `linear(1, x=2)` in order: factors, 0 where left out, and the constant."""
    named = [a for a in term.arguments if isinstance(a, ex.Keyword)]
    constants = [a for a in term.arguments if not isinstance(a, ex.Keyword)]
    if term.kind.text != "linear":
        context.report("FZ303", f"'{term.kind.text}' takes no named parameters", named[0].span, help="drop the name")
        return None
    if len(constants) > 1:
        help_text = "the form is: linear(constant, INPUT=factor, ...)"
        context.report("FZ303", "beside named factors 'linear' takes one constant", term.span, help=help_text)
        return None
    factors: dict[str, ex.Expr] = {}
    for a in named:
        if a.name not in context.inputs:
            context.unknown("input", ex.Name(a.name, a.span), context.inputs)
            return None
        if a.name in factors:
            context.report("FZ303", f"the factor of '{a.name}' is given twice", a.span, help="remove one of them")
            return None
        factors[a.name] = a.value
    return (*(factors.get(name, ex.ZERO) for name in context.inputs), *(constants or [ex.ZERO]))


def resolve_value(context: Context, output: sx.Variable, term: ex.Expr | sx.FunctionTerm) -> Membership | None:
    """Resolve a consequent without a name: a number, or a function."""
    if isinstance(term, sx.FunctionTerm):
        return resolve_function(context, term)
    if isinstance(term, ex.Name) and term.name not in context.params and term.name in terms_of(output):
        help_text = f"write the term without parentheses: {term.name}"
        context.report("FZ202", f"no param '{term.name}'", term.span, help=help_text)
        return None
    if not context.check_names(term, context.params, "param"):
        return None
    return Membership(kind="constant", arguments=(term,), span=ex.span_of(term))


def terms_of(variable: sx.Variable) -> list[str]:
    """Return the names of the terms written below a variable."""
    names: list[str] = []
    for line in variable.terms:
        names.extend([i.name.text for i in line.items] if isinstance(line, sx.TermsLine) else [line.name.text])
    return names


def is_garbled(line: sx.TermLine | sx.TermsLine) -> bool:
    """Whether a `terms` line mixes its forms or holds one name alone, so that its terms are ambiguous."""
    if not isinstance(line, sx.TermsLine):
        return False
    kinds = {"@" if i.peak is not None else "=" if i.value is not None else "" for i in line.items}
    return len(kinds) > 1 or (len(line.items) == 1 and kinds != {"="})


def is_unsure(variable: sx.Variable) -> bool:
    """Whether a variable may have other terms than those that could be read."""
    names = terms_of(variable)
    # If a name is given twice the slip is most likely in the name, so that another one is missing now.
    is_repeated = len(set(names)) < len(names)
    return variable.incomplete or is_repeated or any(is_garbled(line) for line in variable.terms)


def resolve_rule(context: Context, statement: sx.Rule) -> Rule | None:
    """Resolve an `if ... then ...` line; of one that has no meaning its numbers are kept, for the checks of numbers."""
    antecedent = resolve_antecedent(context, statement.antecedent)
    return _concluding(context, statement, antecedent if antecedent is not None else _UNKNOWN)


def resolve_otherwise(
    context: Context, statement: sx.Otherwise, others: Mapping[str, Sequence[Antecedent]], *, broken: bool = False
) -> list[Rule]:
    """Resolve an `otherwise` line: for each output one rule, whose antecedent denies those of the other rules.

    Args:
        context: The declarations; collects mistakes.
        statement: The line.
        others: The antecedents of the `if` lines and cells of its block, by output.
        broken: Whether some lines could not be read, so that missing rules are not reported.
    """
    whole = _concluding(context, statement, _UNKNOWN)
    rules: list[Rule] = []
    for consequent in whole.consequents:
        output = consequent.output
        antecedents = others.get(output, ())
        if not antecedents and broken:
            continue
        if not antecedents:
            message = f"no other rule sets '{output}'"
            help_text = f"for a rule that always fires write: if INPUT is any then {output} is ..."
            context.report("FZ212", message, consequent.span, help=help_text)
            continue
        antecedent = Not(operand=_any_of(antecedents), span=statement.span)
        rules.append(dataclasses.replace(whole, antecedent=antecedent, consequents=(consequent,)))
    return rules


def _any_of(antecedents: Sequence[Antecedent]) -> Antecedent:
    """Return a disjunction, of many operands as a tree, since a chain of them would nest too deeply to be read."""
    if len(antecedents) == 1:
        return antecedents[0]
    size = -(-len(antecedents) // _BROAD)
    parts = [antecedents[k : k + size] for k in range(0, len(antecedents), size)]
    return Or(operands=tuple(map(_any_of, parts)))


def _concluding(context: Context, statement: sx.Rule | sx.Otherwise, antecedent: Antecedent) -> Rule:
    """Resolve consequents and weight of a rule."""
    consequents = [_consequent(context, c) for c in statement.consequents]
    ok = statement.weight is None or context.check_names(statement.weight, context.params, "param")
    named: dict[str, sx.Word] = {}
    for c in statement.consequents:
        first = named.setdefault(c.output.text, c.output)
        if first is not c.output and not context.foreign:
            message, note = f"the rule sets '{first.text}' twice", (first.span, "first set here")
            context.report("FZ215", message, c.output.span, note=note, help="remove one of them, or write two rules")
            break
    return Rule(
        antecedent=antecedent,
        consequents=tuple(c for c in consequents if c is not None),
        weight=statement.weight if statement.weight is not None and ok else ex.ONE,
        span=statement.span,
    )


def resolve_antecedent(context: Context, truth: sx.Truth) -> Antecedent | None:
    """Resolve an antecedent, or the condition behind `with`; None when a part of it has no meaning."""
    match truth:
        case sx.Literal(variable=variable, hedges=hedges, term=term, span=span):
            if _runs_on(context, hedges):
                return None
            hedges, term = _any(context, variable, hedges, term)
            hedged = all([known_hedge(context, h) for h in hedges])
            places = (context.outputs, context.lets, context.inputs)
            among = next((p for p in places if variable.text in p), context.inputs)
            if not _known_term(context, variable, term, among, "input or output") or not hedged:
                return None
            return Is(variable=variable.text, term=term.text, hedges=tuple(h.text for h in hedges), span=span)
        case sx.Negation(operand=operand, span=span):
            inner = resolve_antecedent(context, operand)
            return None if inner is None else Not(operand=inner, span=span)
        case sx.Group(operand=operand):
            return resolve_antecedent(context, operand)
        case sx.Chain(connective=connective, operands=operands, span=span):
            parts = [resolve_antecedent(context, o) for o in operands]
            antecedents = tuple(p for p in parts if p is not None)
            if len(antecedents) < len(parts):
                return None
            return And(operands=antecedents, span=span) if connective == "and" else Or(operands=antecedents, span=span)
    raise TypeError(type(truth).__name__)


def _any(
    context: Context, variable: sx.Word, hedges: tuple[sx.Word, ...], term: sx.Word
) -> tuple[tuple[sx.Word, ...], sx.Word]:
    """Give `is any` the first term of the variable, since the degree is 1 whatever the term."""
    declared = {**context.inputs, **context.lets, **context.outputs}.get(variable.text)
    names = terms_of(declared) if declared is not None and term.text == "any" else []
    if not names or "any" in names:
        return hedges, term
    return (*hedges, term), sx.Word(names[0], term.span)


def _runs_on(context: Context, hedges: Sequence[sx.Word]) -> bool:
    """Report words of the language between `is` and the term: the antecedent has run on."""
    for k, (before, word) in enumerate(zip((None, *hedges), hedges if not context.foreign else (), strict=False)):
        small = word.text.lower()
        if small not in RULE_WORDS or word.text in HEDGES or word.text in context.hedges:
            continue
        if word.text != small:
            context.diagnostics.append(capital_keyword(word.text, word.span))
        elif small == "is" and k >= 2 and hedges[k - 2].text.lower() == "xor":
            help_text = "'A xor B' is written: (A or B) and not (A and B), each of them INPUT is TERM"
            context.report("FZ102", "there is no connective 'xor'", hedges[k - 2].span, help=help_text)
        elif small == "is":
            place = before or word
            context.report("FZ102", f"'and' or 'or' is missing before '{place.text}'", place.span)
        else:
            context.report("FZ102", f"a term is missing before '{word.text}'", word.span)
        return True
    return False


def known_hedge(context: Context, hedge: sx.Word) -> bool:
    """Check that a hedge is one of the language or of the file."""
    is_hedge = hedge.text in HEDGES or hedge.text in context.hedges
    if not is_hedge:
        context.unknown("hedge", hedge, [*HEDGES, *context.hedges])
    return is_hedge


def _consequent(context: Context, text: sx.ConsequentText) -> Consequent | None:
    hedged = not text.hedges or (not _term_runs_on(context, text) and all(known_hedge(context, h) for h in text.hedges))
    if text.output.text in context.inputs or text.output.text in context.lets:
        kind = "an input" if text.output.text in context.inputs else "a let"
        message = f"'{text.output.text}' is {kind}; a consequent sets an output"
        context.report("FZ214", message, text.output.span, facts=(f"outputs: {', '.join(context.outputs)}",))
        return None
    term: str | Membership | None
    if not hedged:
        term = None
    elif isinstance(text.term, sx.Word):
        is_known = _known_term(context, text.output, text.term, context.outputs, "output")
        term = text.term.text if is_known else None
    else:
        declared = context.outputs.get(text.output.text)
        if declared is None and text.output.text not in context.where:
            context.unknown("output", text.output, context.outputs)
        term = resolve_value(context, declared, text.term) if declared is not None else None
    if term is None:
        return None
    hedges = tuple(h.text for h in text.hedges)
    end = ex.span_of(text.term) if isinstance(text.term, ex.Expr) else text.term.span
    span = text.output.span.to(end or text.output.span)
    return Consequent(output=text.output.text, term=term, hedges=hedges, span=span)


def _term_runs_on(context: Context, text: sx.ConsequentText) -> bool:
    """Report a word behind the term of a consequent, which makes the term look like a hedge."""
    declared = context.outputs.get(text.output.text)
    terms = terms_of(declared) if declared is not None else []
    assert isinstance(text.term, sx.Word)
    for word, after in pairwise((*text.hedges, text.term)):
        if word.text in terms and word.text not in HEDGES and word.text not in context.hedges:
            help_text = f"a rule ends with its last term: {FORMS['if']}"
            if after.span.source.text.startswith(" weight ", after.span.end):
                help_text = f"remove '{after.text}'"
            elif closest(after.text, ["weight"]):
                help_text = "did you mean 'weight'?"
            fix = None
            if after is text.term and after.text.lower() in _ENDS:
                fix = Fix((Replacement(Span(after.span.source, word.span.end, after.span.end), ""),), "sure")
            context.report("FZ102", f"unexpected '{after.text}'", after.span, help=help_text, fix=fix)
            return True
    return False


def _known_term(context: Context, variable: sx.Word, term: sx.Word, among: dict[str, sx.Variable], kind: str) -> bool:
    declared = among.get(variable.text)
    if declared is None:
        # A variable whose own line was broken is not a mistake of the rule's.
        if variable.text not in context.where:
            variables = among if kind == "output" else {**context.inputs, **context.outputs, **context.lets}
            context.unknown(kind, variable, variables)
        elif variable.text in context.params:
            context.report("FZ214", f"'{variable.text}' is a param, not an {kind}", variable.span)
        return False
    return known_term(context, declared, term, f"for the param write: ({term.text})" if kind == "output" else "")


def known_term(context: Context, variable: sx.Variable, term: sx.Word, param_help: str = "") -> bool:
    """Check that a variable has a term; silent where the variable's own lines could not all be read.

    `param_help` says how a param is written in the place of the term.
    """
    # Asked for every cell; the list is long to make and never changes.
    names = context.terms.get(id(variable))
    if names is None:
        names = context.terms[id(variable)] = dict.fromkeys(terms_of(variable))
    if term.text in names:
        return True
    is_termless = not names and not context.foreign
    if is_termless and variable.keyword.text == "output" and not is_unsure(variable):
        _report_termless(context, variable, term)
    elif (not is_termless or context.has_functions) and not is_unsure(variable):  # else an input that lacks terms
        near = context.near(term.text, names)
        is_param = term.text in context.params
        help_text = param_help if is_param else f"did you mean '{near}'?" if near else ""
        context.report(
            "FZ203",
            f"{variable.keyword.text} '{variable.name.text}' has no term '{term.text}'",
            term.span,
            facts=(
                *look_alikes(term.text),
                f"terms of '{variable.name.text}': {listed(names) or 'none'} (line {variable.name.span.line})",
            ),
            help=help_text,
            fix=None if is_param else respelt(term.span, term.text, near, names),
        )
    return False


def _report_termless(context: Context, output: sx.Variable, term: sx.Word) -> None:
    """Report an output without terms once, at the first rule that names one."""
    name = output.name.text
    if name not in context.termless:
        context.termless.add(name)
        note = (term.span, f"'{term.text}' is named here")
        help_text = "add lines such as: NB = triangle(-2, -1, 0)"
        context.report("FZ212", f"output '{name}' has no terms", output.name.span, note=note, help=help_text)


def resolve_require(context: Context, statement: sx.Require) -> Guarantee | None:
    """Resolve a `require`: its form and its names are checked here, its truth is for the proof."""
    ok = check_claim(context, statement.claim, truth=True)
    if statement.when is not None:
        ok = check_condition(context, statement.when) and ok
    if statement.within is not None:
        ok = check_tolerance(context, statement.claim, statement.within) and ok
    if not ok:
        return None
    if not names_output(context, statement.claim):
        help_text = "it says nothing about the rules; name an output, or remove it"
        context.report("FZ214", "the guarantee does not name an output", statement.span, help=help_text, warning=True)
    return Guarantee(claim=statement.claim, within=statement.within, when=statement.when, span=statement.span)


#: The claims of a guarantee on an output: the forms, and whether the word is a condition by itself.
CLAIM_FORMS: Final[dict[str, tuple[str, bool]]] = {
    "total": ("total(OUTPUT), or total(OUTPUT) >= STRENGTH", True),
    "bounded": ("bounded(OUTPUT, LOW, HIGH)", True),
    "increasing": ("increasing(OUTPUT, INPUT)", True),
    "decreasing": ("decreasing(OUTPUT, INPUT)", True),
    "lipschitz": ("lipschitz(OUTPUT, INPUT) <= BOUND", False),
}


def check_claim(context: Context, claim: ex.Expr, *, truth: bool) -> bool:
    """Check a claim or a part of one.

    Args:
        context: Where to report.
        claim: The expression.
        truth: Whether a condition is expected, else a number.
    """
    match claim:
        case ex.Compare(op="<=", left=ex.Call(function="lipschitz") as slope, right=bound, span=span):
            parts = all([_check_form(context, slope, False), context.check_names(bound, context.params, "param")])
            return _due(context, truth, "a number", "a comparison", span) and parts
        case ex.Compare(op=">=", left=ex.Call(function="total") as total, right=least, span=span):
            parts = all([_check_form(context, total, True), context.check_names(least, context.params, "param")])
            return _due(context, truth, "a number", "a comparison", span) and parts
        case ex.Compare(left=left, right=right, span=span):
            parts = all([check_claim(context, p, truth=False) for p in (left, right)])
            return _due(context, truth, "a number", "a comparison", span) and parts
        case ex.Logic(op=op, operands=operands, span=span):
            parts = all([check_claim(context, p, truth=True) for p in operands])
            return _due(context, truth, "a number", f"'{op}'", span) and parts
        case ex.Call(function="lipschitz", span=span) if not truth:
            facts = (f"the form is: {CLAIM_FORMS['lipschitz'][0]}",)
            context.report("FZ303", "expected 'lipschitz' alone on the left of '<='", span, facts=facts)
            return False
        case ex.Call(function=function) if function in CLAIM_FORMS:
            return _check_form(context, claim, truth)
        case ex.Call(function=function) if not _is_known(context, function):
            _unknown_function(context, claim)
            return False
        case ex.Call(function=function, span=span):
            parts = all([check_claim(context, p, truth=False) for p in claim.arguments])
            is_due = not truth or context.is_condition(claim)
            return _due(context, is_due, "a condition", "a number", span) and _check_call(context, claim) and parts
        case ex.Name(name=name, span=span):
            names = context.read
            if name not in names and name not in ex.CONSTANTS and "." not in name:
                context.unknown("name", claim, names)
                return False
            return _due(context, not truth or context.is_condition(claim), "a condition", "a number", span)
    parts = all([check_claim(context, p, truth=False) for p in ex.children(claim)])
    return _due(context, not truth, "a condition", "a number", ex.span_of(claim)) and parts


def names_output(context: Context, claim: ex.Expr) -> bool:
    """Whether a claim speaks of any output."""
    named = [
        n.name if isinstance(n, ex.Name) else n.function for n in ex.walk(claim) if isinstance(n, ex.Name | ex.Call)
    ]
    return any(name in context.outputs or "." in name for name in named)


def check_condition(context: Context, condition: ex.Expr) -> bool:
    """Check the condition behind `when`: it holds at a point or not, so that a claim about all points is refused."""
    form = next((n for n in ex.walk(condition) if isinstance(n, ex.Call) and n.function in CLAIM_FORMS), None)
    if form is not None:
        message = f"expected a condition, found '{form.function}', a claim about all points"
        context.report("FZ214", message, form.span, help="compare expressions, such as: when e >= 0")
        return False
    return check_claim(context, condition, truth=True)


def check_tolerance(context: Context, claim: ex.Expr, within: ex.Expr) -> bool:
    """Check the tolerance behind `within`, which only comparisons of numbers take."""
    if isinstance(claim, ex.Call) and claim.function == "total":
        help_text = "remove it: an output is defined everywhere or it is not"
        context.report("FZ214", "'within' does not go with 'total'", ex.span_of(within), help=help_text)
        return False
    return context.check_names(within, context.params, "param")


def _due(context: Context, right: bool, due: str, given: str, span: Span | None) -> bool:
    if not right:
        help_text = "compare it, such as: f <= 1" if due == "a condition" else ""
        context.report("FZ307", f"expected {due}, found {given}", span, help=help_text)
    return right


def _is_known(context: Context, function: str) -> bool:
    return function in ex.FUNCTIONS or function in context.outputs or "." in function


def _check_call(context: Context, call: ex.Call) -> bool:
    if "." in call.function:
        return True
    if call.function in context.outputs:
        due = len(context.inputs)
        if len(call.arguments) == due or context.lost_input:
            return True
        message = f"'{call.function}' takes {counted(due, 'argument')}, not {len(call.arguments)}"
        help_text = f"the form is: {call.function}({', '.join(context.inputs)})"
        fix = with_decimal_points(call.span, len(call.arguments), due)
        context.report("FZ303", message, call.span, help=help_text, fix=fix)
        return False
    return context.check_call(call)


def _unknown_function(context: Context, call: ex.Call) -> None:
    if call.function in context.unread or context.lost_variable or "output" in context.nameless:
        return
    names = [*ex.FUNCTIONS, *CLAIM_FORMS, *context.outputs]
    context.report(
        "FZ202",
        f"no function or output '{call.function}'",
        call.span,
        facts=(f"functions: {', '.join(names)}",),
        help=did_you_mean(call.function, names),
        fix=respelt_as_suggested(call.span, call.function, names),
    )


def _check_form(context: Context, call: ex.Call, truth: bool) -> bool:
    form, is_truth = CLAIM_FORMS[call.function]
    help_text = f"the form is: {form}"
    due = form.split(")")[0].count(",") + 1
    if len(call.arguments) != due:
        message = f"'{call.function}' takes {counted(due, 'argument')}, not {len(call.arguments)}"
        fix = with_decimal_points(call.span, len(call.arguments), due)
        context.report("FZ303", message, call.span, help=help_text, fix=fix)
        return False
    ok = _names(context, call.arguments[0], context.outputs, "output", help_text)
    if call.function == "bounded":
        ok = all([context.check_names(a, context.params, "param") for a in call.arguments[1:]]) and ok
    elif due == 2:
        ok = _names(context, call.arguments[1], context.inputs, "input", help_text) and ok
    if is_truth != truth:
        kind = "a condition" if is_truth else "a number"
        context.report("FZ307", f"'{call.function}' is {kind}", call.span, help=help_text)
        return False
    return ok


def _names(context: Context, given: ex.Expr, among: Mapping[str, object], kind: str, help_text: str) -> bool:
    if isinstance(given, ex.Name):
        if given.name not in among:
            context.unknown(kind, given, among)
        return given.name in among
    context.report("FZ303", f"expected the name of an {kind}", ex.span_of(given), help=help_text)
    return False


def resolve_claim(context: Context, statement: sx.Require, formula: Callable[..., bool]) -> Guarantee | None:
    """Check a `require` line of a controller.

    Args:
        context: Where to report.
        statement: The line.
        formula: Checks an expression over the names of the controller.
    """
    parts = [p for p in (statement.claim, statement.when) if p is not None]
    fine = all([_is_pointwise(context, p) and _is_condition(p, formula) for p in parts])
    if statement.within is not None:
        fine = context.check_names(statement.within, context.params, "param") and fine
    if not fine:
        return None
    return Guarantee(claim=statement.claim, within=statement.within, when=statement.when, span=statement.span)


def _is_pointwise(context: Context, claim: ex.Expr) -> bool:
    """Report words about all points of a system, which a claim about a step does not have."""
    for node in ex.walk(claim):
        if not isinstance(node, ex.Call) or node.function not in CLAIM_FORMS:
            continue
        form = CLAIM_FORMS[node.function][0]
        if node.function != "bounded":
            message = f"'{node.function}' is a claim about a system, not about a step of a controller"
            help_text = f"compare values of a step, or claim it in the system: require {form}"
            context.report("FZ214", message, node.span, help=help_text)
            return False
        if len(node.arguments) != 3:
            message = f"'bounded' takes {counted(3, 'argument')}, not {len(node.arguments)}"
            context.report("FZ303", message, node.span, help=f"the form is: {form}")
            return False
    return True


def _is_condition(claim: ex.Expr, formula: Callable[..., bool]) -> bool:
    """Check a condition, `bounded` among its parts."""
    match claim:
        case ex.Logic(operands=operands):
            return all([_is_condition(o, formula) for o in operands])
        case ex.Call(function="bounded", arguments=arguments):
            return all([formula(a, truth=False, pure=True) for a in arguments])
    return formula(claim, truth=True, pure=True)
