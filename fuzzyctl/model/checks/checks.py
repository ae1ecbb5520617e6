"""Lists of all checks of a model, each a function from a system or its numbers to diagnostics; checks of methods."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, Note
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Expr, Number, names_in, span_of
from fuzzyctl.formulas import IMPLICATIONS, MEMBERSHIP, inverse_hedge
from fuzzyctl.model.checks.parameters import VALUE_CHECKS, computed_numbers
from fuzzyctl.model.checks.partitions import helps_by_line, removal
from fuzzyctl.model.checks.terms import SHAPE_CHECKS, SHAPE_HINTS
from fuzzyctl.model.checks.units import unlike_units
from fuzzyctl.model.computed_numbers import Numbers
from fuzzyctl.model.method import OVER_MIDDLES, Defuzzifier
from fuzzyctl.model.profiles import Profile, profile
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule, RuleTable, literals
from fuzzyctl.model.system import FuzzySystem, comparisons_that_wait, reads_of, values_of
from fuzzyctl.model.variable import LinguisticVariable, Membership, Output

Check = Callable[[FuzzySystem], Iterator[Diagnostic]]


def check_model(system: FuzzySystem, *, hints: bool = True) -> list[Diagnostic]:
    """Return all diagnostics of a system, in the order of their places.

    A number that cannot be computed, or a shape with bad parameters, costs only the checks that would look at it.

    Args:
        system: The system.
        hints: Whether to run the checks that give nothing but warnings.
    """
    numbers = Numbers(system)
    results = [d for check in (*CHECKS, *(HINTS if hints else ())) for d in check(system)]
    number_checks = (*VALUE_CHECKS, *SHAPE_CHECKS, *(SHAPE_HINTS if hints else ()))
    results += [d for number_check in number_checks for d in number_check(numbers)]
    return in_order(results)


def check_values(system: FuzzySystem) -> list[Diagnostic]:
    """Return the diagnostics of single numbers of a system whose file is partly unreadable or unresolved."""
    numbers = Numbers(system, partial=True)
    return in_order(d for check in VALUE_CHECKS for d in check(numbers))


def in_order(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Sort by place."""
    return sorted(diagnostics, key=lambda d: d.span.start if d.span is not None else -1)


def require_well_formed(system: FuzzySystem) -> None:
    """Raise `DiagnosticError` when a system has errors; warnings pass."""
    errors = [d for d in check_model(system, hints=False) if d.severity == "error"]
    if errors:
        raise DiagnosticError(errors)


def circular_lets(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find lets whose values depend on themselves."""
    needs = {v.name: {n.name: span_of(n) for n in names_in(v.value)} for v in system.lets}
    needs = {name: {n: place for n, place in read.items() if n in needs} for name, read in needs.items()}
    for let in system.lets:
        path = _circle(let.name, needs)
        if path and let.name == min(path):
            message = f"lets depend on each other in a circle: {' → '.join(path)}"
            yield Diagnostic("FZ217", message, needs[path[0]][path[1]] or let.span, help="let one read inputs only")


def unused_lets(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find unused lets."""
    used = {i.variable for rule in system.rules for i in literals(rule.antecedent)}
    used |= {n.name for e in _functions(system) for n in names_in(e)}
    used |= {n.name for o in system.outputs if o.adaptive is not None for n in names_in(o.adaptive)}
    used |= {n.name for g in system.guarantees for e in (g.claim, g.when) if e is not None for n in names_in(e)}
    for let in system.lets:
        if let.name not in used:
            yield Diagnostic("FZ216", f"let '{let.name}' is not used", let.span, "warning", help="remove it, or use it")


def circular_outputs(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find outputs whose values depend on themselves through antecedents and functions."""
    names = {o.name for o in system.outputs}
    needs: dict[str, dict[str, Span | None]] = {name: {} for name in names}
    for output, read in reads_of(system):
        needs[output].update(read)
    for declared in system.outputs:
        path = _circle(declared.name, needs)
        if path and declared.name == min(path):
            span = needs[path[0]][path[1]] or declared.span
            message = f"outputs depend on each other in a circle: {' → '.join(path)}"
            yield Diagnostic("FZ217", message, span, help="let one of these rules read inputs only")


def _circle(start: str, needs: dict[str, dict[str, Span | None]]) -> list[str]:
    """Return a way from an output back to itself, or nothing."""
    ways = [[start]]
    seen: set[str] = set()
    while ways:
        way = ways.pop()
        for name in needs[way[-1]]:
            if name == start:
                return [*way, name]
            if name not in seen:
                seen.add(name)
                ways.append([*way, name])
    return []


def misfitting_activation(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find activation methods that compare rules where some of them wait for an output."""
    yield from comparisons_that_wait(system)


def functions_read(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find antecedents that name a term of an output that is not a fuzzy set."""
    if system.method.semantics.chained == "degree":
        return  # how far a function has been activated is as good a degree as any
    if all(t.membership.kind in MEMBERSHIP for o in system.outputs for t in o.terms):
        return
    outputs = {o.name: o for o in system.outputs}
    seen: set[tuple[str, str]] = set()
    for rule in system.rules:
        for i in literals(rule.antecedent):
            output = outputs.get(i.variable)
            term = output.term(i.term) if output is not None else None
            if term is None or term.membership.kind in (*MEMBERSHIP, "formula") or (i.variable, i.term) in seen:
                continue
            seen.add((i.variable, i.term))
            message = f"term '{i.term}' of output '{i.variable}' is a function of the inputs, so nothing can be it"
            note = (Note(term.span, "declared here"),) if term.span is not None else ()
            yield Diagnostic("FZ214", message, i.span, help="give the output fuzzy sets as terms", notes=note)


def inputs_without_degree(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find linear consequents among the terms of inputs: sums over all inputs, which are not degrees."""
    for variable in system.inputs:
        for term in variable.terms:
            if term.membership.kind == "linear":
                message = f"term '{term.name}' of input '{variable.name}' is linear, a consequent, and no fuzzy set"
                help_text = "give the input fuzzy sets as terms, or a function of the input alone"
                yield Diagnostic("FZ214", message, term.membership.span or term.span, help=help_text)


def unused_hedges(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find hedges of the system's own that no rule uses."""
    used = {h for rule in system.rules for i in literals(rule.antecedent) for h in i.hedges}
    used |= {h for rule in system.rules for c in rule.consequents for h in c.hedges}
    for hedge in system.hedges:
        if hedge.name not in used:
            message = f"no rule uses hedge '{hedge.name}'"
            yield Diagnostic("FZ219", message, hedge.span, "warning", help="remove it, or use it in a rule")


def outputs_without_rules(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find outputs that no rule sets, and formulas that a rule sets."""
    set_by_rules = {c.output: c.span for rule in system.rules for c in rule.consequents}
    for output in system.outputs:
        if output.value is not None and output.name in set_by_rules:
            message = f"output '{output.name}' is a formula, and a rule sets it"
            note = (Note(output.span, "declared here"),) if output.span is not None else ()
            yield Diagnostic("FZ214", message, set_by_rules[output.name], help="leave one of them out", notes=note)
        elif output.value is None and output.name not in set_by_rules:
            yield Diagnostic("FZ210", f"no rule sets output '{output.name}'", output.span, help="add a table or rules")


def contradictory_rules(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find rules with the same antecedent for the same output."""
    first: dict[tuple[object, str], tuple[Rule, str | Membership]] = {}
    for rule in system.rules:
        key = _canonical(rule.antecedent)
        for c in rule.consequents:
            earlier = first.setdefault((key, c.output), (rule, c.term))
            if earlier[0] is rule:
                continue
            again = "the same" if earlier[1] == c.term else f"{_named(earlier[1])} there, {_named(c.term)} here"
            note = (Note(earlier[0].span, "first given here"),) if earlier[0].span is not None else ()
            yield Diagnostic(
                "FZ209",
                f"a second rule for '{c.output}' has the same antecedent ({again})",
                c.span or rule.span,
                "warning",
                help="both count; remove one unless that is meant",
                notes=note,
            )


def _named(term: str | Membership) -> str:
    return f"'{term}'" if isinstance(term, str) else f"a '{term.kind}' consequent"


def _canonical(antecedent: Antecedent) -> object:
    """Return a key that does not depend on the order of operands."""
    match antecedent:
        case Is(variable=variable, term=term, hedges=hedges):
            return (variable, hedges, term)
        case Not(operand=operand):
            return ("not", _canonical(operand))
        case And(operands=operands) | Or(operands=operands):
            return (type(antecedent).__name__, frozenset(_canonical(o) for o in operands))
    raise TypeError(type(antecedent).__name__)


def unused_inputs(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find inputs that neither an antecedent, a consequent nor an adaptive law reads."""
    used = {i.variable for rule in system.rules for i in literals(rule.antecedent)}
    used |= {n.name for o in system.outputs if o.adaptive is not None for n in names_in(o.adaptive)}
    used |= {n.name for value in values_of(system) for n in names_in(value)}
    used |= {name for membership in _functions_of_rules(system) for name in _inputs_in(system, membership)}
    for variable in system.inputs:
        if variable.name not in used:
            message = f"no rule reads input '{variable.name}'"
            yield Diagnostic("FZ211", message, variable.span, "warning", help="remove it, or use it in a rule")


def _functions_of_rules(system: FuzzySystem) -> Iterator[Membership]:
    """Yield the consequents of all rules that are functions of the inputs, each named term once."""
    named = {(o.name, t.name): t.membership for o in system.outputs for t in o.terms}
    consequents = {(c.output, c.term): c.term for rule in system.rules for c in rule.consequents}
    for (output, _), term in consequents.items():
        membership = term if isinstance(term, Membership) else named.get((output, term))
        if membership is not None and membership.kind in ("linear", "function"):
            yield membership


def _inputs_in(system: FuzzySystem, membership: Membership) -> Iterator[str]:
    """Yield the inputs that a consequent reads; a coefficient that is the number 0 reads none."""
    if membership.kind == "function":
        yield from (n.name for n in names_in(membership.arguments[0]))
        return
    for variable, coefficient in zip(system.inputs, membership.arguments, strict=False):
        if coefficient != Number(0.0):
            yield variable.name


def unused_terms(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find terms that no rule names, of variables that some rule names."""
    read = {(i.variable, i.term) for rule in system.rules for i in literals(rule.antecedent)}
    written = {(c.output, c.term) for rule in system.rules for c in rule.consequents if isinstance(c.term, str)}
    used = read | written
    in_antecedents, touched = {name for name, _ in read}, {name for name, _ in used}
    # Variables may share terms, and each need not use all of them.
    lines = {t.span for v in system.variables for t in v.terms if (v.name, t.name) in used}
    for variable in system.variables:
        if variable.name not in touched:
            continue
        only_peaks = variable.name not in in_antecedents and _takes_peaks(system, variable)
        terms = (t for t in variable.terms if (variable.name, t.name) in used)
        helps = helps_by_line(terms, only_peaks=only_peaks)
        for term in variable.terms:
            if (variable.name, term.name) not in used and (term.span is None or term.span not in lines):
                message = f"no rule uses term '{term.name}' of '{variable.name}'"
                facts, help_text = removal(term, helps, only_peaks=only_peaks)
                yield Diagnostic("FZ208", message, term.span, "warning", facts, help_text)


def _takes_peaks(system: FuzzySystem, variable: LinguisticVariable) -> bool:
    """Return whether a variable is an output whose defuzzifier takes nothing of its terms but their peaks."""
    method = variable.defuzzifier or system.method.defuzzifier if isinstance(variable, Output) else None
    return method is not None and method.kind in OVER_MIDDLES


def unused_params(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find unused params."""
    used: set[str] = set()
    for expr, _, _ in computed_numbers(system):
        used.update(n.name for n in names_in(expr))
    for function in _functions(system):
        used.update(n.name for n in names_in(function))
    for p in system.params:
        used.update(n.name for n in names_in(p.expression))
    for g in system.guarantees:
        for claim in (g.claim, g.when):
            if claim is not None:
                used.update(n.name for n in names_in(claim))
    for o in system.outputs:
        if o.adaptive is not None:
            used.update(n.name for n in names_in(o.adaptive))
    for p in system.params:
        if p.name not in used:
            yield Diagnostic("FZ216", f"param '{p.name}' is not used", p.span, "warning", help="remove it, or use it")


def _functions(system: FuzzySystem) -> Iterator[Expr]:
    """Yield the expressions over variables: of hedges, and of terms and consequents that are functions."""
    yield from (h.expression for h in system.hedges)
    yield from values_of(system)
    memberships = [t.membership for v in system.variables for t in v.terms]
    memberships += [c.term for r in system.rules for c in r.consequents if isinstance(c.term, Membership)]
    yield from (m.arguments[0] for m in memberships if m.kind in ("function", "formula"))


def slips_in_tables(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find cells that jump in a table, or break its symmetry."""
    if any(isinstance(part, RuleTable) for part in system.tables_and_rules):
        from fuzzyctl.model.checks.tables import jumping_tables, odd_cells

        yield from jumping_tables(system)
        yield from odd_cells(system)


#: Implications under which a scaled set that is cut is a cut set that is scaled.
SCALABLE = tuple(name for name, norm in IMPLICATIONS.items() if norm.straight)


def misfitting_semantics(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find knobs under which parts of a system have no meaning."""
    for output in system.outputs:
        yield from _sampled(system, output)
        yield from _adaptive(system, output)
        yield from _weighted_after(system, output)
        yield from _divided(system, output)
    yield from _hedged(system)


def _defuzzifier(system: FuzzySystem, output: Output) -> Defuzzifier:
    return output.defuzzifier or system.method.defuzzifier


def _sampled(system: FuzzySystem, output: Output) -> Iterator[Diagnostic]:
    """Find options of a defuzzifier that exclude each other."""
    defuzzifier = _defuzzifier(system, output)
    if defuzzifier.rule == "running" and defuzzifier.by == "magnitude":
        message = f"output '{output.name}': 'rule=running' goes from left to right, and not by magnitude"
        yield Diagnostic("FZ214", message, output.span, help="leave one of them out")
    if defuzzifier.kind == "bisector" and defuzzifier.tolerance is not None and defuzzifier.rule != "between":
        message = f"output '{output.name}': a bisector has a tolerance with 'rule=between' only"
        yield Diagnostic("FZ214", message, output.span, help="leave it out")


def _adaptive(system: FuzzySystem, output: Output) -> Iterator[Diagnostic]:
    """An adaptive output has a state for each rule, and its rates are shares of activations."""
    semantics = system.method.semantics
    usual = semantics.merge == "rules" and semantics.total == "activations"
    if output.adaptive is not None and not usual:
        message = f"output '{output.name}' is adaptive, which the semantics '{semantics.profile}' do not know"
        help_text = "write: semantics exact, or merge=rules and total=activations behind the profile"
        yield Diagnostic("FZ214", message, output.span, help=help_text)


def _weighted_after(system: FuzzySystem, output: Output) -> Iterator[Diagnostic]:
    """A weight after implication is computed as a scaled set, which some implications do not allow."""
    if system.method.semantics.weight != "after" or _defuzzifier(system, output).over_rules:
        return
    other = next((i for i in system.implications_of(output) if i not in SCALABLE), None)
    if other is not None:
        message = f"output '{output.name}': 'weight=after' goes with the implications {' and '.join(SCALABLE)}"
        yield Diagnostic("FZ214", message, output.span, facts=(f"its implication is '{other}'",))


def _divided(system: FuzzySystem, output: Output) -> Iterator[Diagnostic]:
    """An average that divides by something else than it sums over must not make its parts larger than that."""
    semantics = system.method.semantics
    if semantics.total == "activations" or not _defuzzifier(system, output).averages:
        return
    if semantics.merge != "rules":
        message = f"output '{output.name}': 'total={semantics.total}' goes with 'merge=rules' only"
        yield Diagnostic("FZ214", message, semantics.span or output.span, help="leave one of them out")
    hedged = [c for rule in system.rules for c in rule.consequents if c.output == output.name and c.hedges]
    if hedged:
        message = f"'total={semantics.total}' does not know what hedges make of the activation of '{output.name}'"
        yield Diagnostic("FZ214", message, hedged[0].span, help="leave the hedge out, or say 'total=activations'")


def _hedged(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find hedges in consequents that change nothing there is."""
    how = system.method.semantics.consequent_hedges
    outputs = {o.name: o for o in system.outputs}
    hedges = {h.name for h in system.hedges}
    for rule in system.rules:
        for c in rule.consequents:
            if not c.hedges or c.output not in outputs:
                continue
            kind = _defuzzifier(system, outputs[c.output]).kind
            over_rules = _defuzzifier(system, outputs[c.output]).over_rules
            if outputs[c.output].adaptive is not None:
                yield Diagnostic("FZ214", f"output '{c.output}' is adaptive, so nothing hedges it", c.span)
            elif over_rules and how == "set":
                message = f"a hedge changes the set of a consequent, and '{kind}' of '{c.output}' looks at no set"
                help_text = "leave the hedge out, or say what it changes: semantics exact(consequent_hedges=activation)"
                yield Diagnostic("FZ214", message, c.span, help=help_text)
            elif over_rules and how == "undone":
                for name in c.hedges:
                    if name in hedges or inverse_hedge(name) is None:
                        message = f"hedge '{name}' of a consequent has no inverse, and '{kind}' needs it"
                        yield Diagnostic("FZ214", message, c.span)


def profile_hints(system: FuzzySystem, name: str) -> list[Diagnostic]:
    """Return hints about parts of a system that a profile does not compute as its tool does.

    These are hints at another version of the system's tool and at rule blocks that keep other norms, and
    warnings of rules that the tool leaves out. A system sets norms and a profile sets numerics, so blocks keep their
    norms under a profile whose tool has one norm for all rules.
    """
    new, old = profile(name), profile(system.method.semantics.profile)
    result = [_other_version(system, old, new)] if old.name.startswith(f"{name}_") else []
    # The reader reports those of fuzzylite's own files.
    if new.name.startswith("fuzzylite") and "fuzzylite" not in old.name:
        result += [_always_acting(rule, new) for rule in system.rules if _has_no_condition(rule)]
    if new.has_blocks:
        return result
    for block in system.rule_blocks:
        norms = {n: getattr(block, n) for n in ("conjunction", "disjunction", "implication")}
        norms_of_block = [f"{n} {norm}" for n, norm in norms.items() if norm not in (None, getattr(system.method, n))]
        if norms_of_block:
            message = f"profile '{name}' leaves rule block '{block.name}' its own {', '.join(norms_of_block)}"
            facts = (f"{new.tool} has one norm of each kind for all rules",)
            result.append(Diagnostic("FZ609", message, block.span, "hint", facts))
    return result


def _other_version(system: FuzzySystem, old: Profile, new: Profile) -> Diagnostic:
    message = f"profile '{new.name}' computes as {new.tool}, and '{system.name}' is of {old.tool}"
    help_text = f"for the numbers of {old.tool} leave the profile out, or name '{old.name}'"
    return Diagnostic("FZ609", message, system.span, "hint", help=help_text, file=system.path)


def _has_no_condition(rule: Rule) -> bool:
    """Whether the antecedent is not a part of the text: the reader of a `.fis` file made it from the whole rule."""
    antecedent = rule.antecedent
    return (
        isinstance(antecedent, Is)
        and antecedent.hedges == ("any",)
        and antecedent.span is not None
        and antecedent.span == rule.span
    )


def _always_acting(rule: Rule, new: Profile) -> Diagnostic:
    message = f"the rule has no condition; under profile '{new.name}' it acts all the same"
    facts = (f"{new.tool} leaves such a rule out; what only such rules set is 'nan' there",)
    help_text = "remove the rule, or give it a condition"
    return Diagnostic("FZ609", message, rule.span, "warning", facts=facts, help=help_text)


#: Checks that need no numbers.
CHECKS: Final[tuple[Check, ...]] = (
    circular_outputs,
    circular_lets,
    misfitting_activation,
    misfitting_semantics,
    functions_read,
    inputs_without_degree,
    outputs_without_rules,
    unlike_units,
)

#: Those of them that give nothing but warnings.
HINTS: Final[tuple[Check, ...]] = (
    contradictory_rules,
    unused_inputs,
    unused_terms,
    unused_params,
    unused_lets,
    unused_hedges,
    slips_in_tables,
)
