"""Coverage check: whether some rule fires everywhere, and a point where no rule fires."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Final

from fuzzyctl.analysis.coverage.box_search import Hole, Search, Undecided, Verdict, largest_degree
from fuzzyctl.analysis.coverage.silence import Silence, at, silent_point, unclear_at
from fuzzyctl.analysis.degrees import CERTAIN, Truths, degree_in, narrowed
from fuzzyctl.analysis.work import COVERAGE, SEARCH, SPENT, SpentError, Work
from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.formulas import IMPLICATIONS
from fuzzyctl.kernels.plan.build import OutputPlan, Plan, degree_name, plan
from fuzzyctl.model.rule import RuleBlock, RuleTable
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Output
from fuzzyctl.support import arguments

#: What other tools make of an output that no rule moves, for a rule base whose paper does not say it.
ELSEWHERE: Final = (
    "there MATLAB computes with 'else midpoint', fuzzylite and Octave with 'else nan', "
    "jFuzzyLogic with 'else hold', simpful with 'else 0', scikit-fuzzy with 'else error'"
)


def uncovered(system: FuzzySystem) -> dict[str, Verdict]:
    """Find for each output a region where no rule fires.

    Returns:
        By name of the output None (proved: some rule always fires), a `Hole`, or `Undecided`. A proof holds for
        the floats that kernels compute.

    Raises:
        ArgumentError: For an object that is not a system.
    """
    arguments.instance("the system", FuzzySystem, "a FuzzySystem", system)
    return uncovered_of(plan(system))


def uncovered_of(flat: Plan, work: Work | None = None) -> dict[str, Verdict]:
    """Do the same for a plan; `work` is the work that is allowed for all outputs."""
    whole = Work(len(flat.outputs) * COVERAGE) if work is None else work
    flat = narrowed(flat) if flat.lets else flat
    verdicts: dict[int, Verdict] = {}
    for position in flat.order:
        verdicts[position] = _verdict(flat, flat.outputs[position], verdicts, whole.part(COVERAGE))
    return {output.name: verdicts[k] for k, output in enumerate(flat.outputs)}


def _verdict(flat: Plan, output: OutputPlan, earlier: Mapping[int, Verdict], work: Work) -> Verdict:
    if output.value is not None:
        return None  # no rule sets it
    follows = bool(output.reads or flat.lets)
    verdict = Search(flat, output, True, work.part(0.5 * work.left) if follows else work).verdict()
    if verdict is not None and follows:
        # No output or let need ever have the value at which no rule fires; a hole is one for all their values.
        verdict = Search(flat, output, False, work).verdict()
    if isinstance(verdict, Hole) and output.total != "activations":
        return Undecided("the average divides by more than the activations of its own rules")
    if verdict is not None:
        return verdict
    if not _some_rule_acts(flat, output):
        return Undecided(f"activation {_comparing(flat, output)} may leave out the rules that fire for it")
    for k in output.reads:
        read = flat.outputs[k]
        has_value = read.otherwise is not None and read.otherwise == read.otherwise
        if not has_value and earlier[k] is not None:
            return Undecided(f"it reads '{read.name}', which may have no value")
    return None


def _some_rule_acts(flat: Plan, output: OutputPlan) -> bool:
    """Return whether, where some rule has an activation, one that moves this output acts."""
    groups = {flat.rules[entry.rule].group for entry in output.implied}
    comparing = [g for g in groups if flat.activations[g].compares]
    if not comparing:
        return True
    if flat.least or any(entry.change is not None for entry in output.implied):
        return False
    return all(_some_of_group_acts(flat, output, g) for g in comparing)


def _some_of_group_acts(flat: Plan, output: OutputPlan, group: int) -> bool:
    """Return the same for the rules of one group, whose activation method compares them."""
    method = flat.activations[group]
    if method.kind == "proportional":
        return output.over_rules or _is_exact(output)
    moving = {e.rule for e in output.implied if largest_degree(output, output.terms[e.term]) is not None}
    members = [(r, rule.weight) for r, rule in enumerate(flat.rules) if rule.group == group]
    if not all(r in moving or weight == 0.0 for r, weight in members):
        return False
    # The rule chosen may be one of the smallest activations there are, whose area is 0.
    strict = _is_exact(output) and (method.kind == "highest" or method.threshold >= CERTAIN)
    return output.over_rules or strict


def _is_exact(output: OutputPlan) -> bool:
    return all(IMPLICATIONS[output.implication_of(output.terms[e.term])].straight for e in output.implied)


def _comparing(flat: Plan, output: OutputPlan) -> str:
    """Return the names of the activation methods that compare the rules of an output."""
    return " and ".join(f"'{m.kind}'" for m in flat.activations_of(output) if m.compares)


def diagnostics(system: FuzzySystem) -> list[Diagnostic]:
    """Report each output without `else` for which some rule is not proved to fire always."""
    return diagnostics_of(system, plan(system), kept_of(system))


def kept_of(system: FuzzySystem) -> dict[str, Verdict]:
    """Return what `uncovered_of` does; a system keeps it."""
    if "uncovered" not in system.derived:
        system.derived["uncovered"] = uncovered_of(plan(system))
    verdicts: dict[str, Verdict] = system.derived["uncovered"]
    return verdicts


def diagnostics_of(
    system: FuzzySystem, flat: Plan, verdicts: Mapping[str, Verdict], work: Work | None = None
) -> list[Diagnostic]:
    """Do the same for a system with known plan and verdicts; `work` is the work that is allowed for all outputs."""
    work = Work() if work is None else work
    results: list[Diagnostic] = []
    silence: Silence | None = None
    for position, output in enumerate(system.outputs):
        verdict = verdicts[output.name]
        named = any(c.output == output.name for rule in system.rules for c in rule.consequents)
        # An output without rules has another diagnostic.
        if verdict is None or output.otherwise is not None or not named:
            continue
        part = work.part(SEARCH)
        silence = Silence(flat, output.name, part) if silence is None else silence.of(output.name, part)
        try:
            if isinstance(verdict, Hole) and not silence.confirms(verdict):
                verdict = Undecided(unclear_at(verdict))
        except SpentError:
            verdict = Undecided(SPENT, spent=True)
        if isinstance(verdict, Hole):
            hole = _at_hole(flat, output, flat.outputs[position], verdict)
            # If rules fire and do not move the output, empty cells are not the cause.
            stopped = _stopped(flat, flat.outputs[position], verdict.witness)
            results.append(hole if stopped else _with_cells(hole, system, output, verdict.witness))
        else:
            results.append(_undecided(flat, output, flat.outputs[position], verdict, silence))
    return results


def _at_hole(flat: Plan, output: Output, planned: OutputPlan, hole: Hole) -> Diagnostic:
    witness = ", ".join(f"{n} = {v:.6g}" for n, v in hole.witness.items())
    is_point = all(side.lower == side.upper for side in hole.region.values())
    example = () if is_point else (f"for example at {witness}",)
    return _silent(output, f"where {hole}", _stopped(flat, planned, hole.witness), before=example)


def _with_cells(hole: Diagnostic, system: FuzzySystem, output: Output, witness: Mapping[str, float]) -> Diagnostic:
    """Name the empty cells of tables where no rule fires: the user fills these."""
    cells = _empty_cells(system, output.name, witness)
    if not cells:
        return hole
    which = "the empty cell" if len(cells) == 1 else "the empty cells"
    help_text = f"fill {which}, or say 'output {output.name} ... else VALUE'"
    return dataclasses.replace(hole, notes=cells, help=help_text)


def _undecided(flat: Plan, output: Output, planned: OutputPlan, verdict: Undecided, silence: Silence) -> Diagnostic:
    """Report an output whose coverage is undecided, with a point where no rule fires if one was found."""
    point = silent_point(flat, silence)
    if point is not None:
        stopped = _stopped(flat, planned, dict(zip([i.name for i in flat.inputs], point, strict=True)))
        region = f"it is not known how far around it none does: {verdict.reason}"
        return _silent(output, f"at {at(flat, point)}", stopped, after=(region,))
    message = f"it cannot be decided whether some rule always fires for output '{output.name}'"
    help_text = f"say what holds where none does: 'output {output.name} ... else VALUE'"
    facts = (verdict.reason, ELSEWHERE)
    if verdict.spent:
        return Diagnostic("FZ407", message, output.span, "warning", facts, help_text)
    return Diagnostic("FZ401", message, output.span, facts=facts, help=help_text)


def _silent(
    output: Output, region: str, stopped: str, before: tuple[str, ...] = (), after: tuple[str, ...] = ()
) -> Diagnostic:
    """Report a point or a region where no rule moves an output, with the reason if a rule fires there."""
    message = f"no rule {'moves' if stopped else 'fires for'} output '{output.name}' {region}"
    facts = (*before, stopped or "without 'else' some rule must fire everywhere", ELSEWHERE, *after)
    change = "let a rule move it there" if stopped else "let a term of the inputs reach there"
    help_text = f"{change}, or say 'output {output.name} ... else VALUE'"
    return Diagnostic("FZ401", message, output.span, facts=facts, help=help_text)


def _stopped(flat: Plan, output: OutputPlan, at: Mapping[str, float]) -> str:
    """Return why rules that fire at a point do not move an output, an empty text if no rule fires."""
    box = {}
    for i, d in enumerate(flat.degrees):
        if d.variable >= len(flat.inputs):
            return ""
        x = at[flat.inputs[d.variable].name]
        box[degree_name(i)] = degree_in(d.set, (x, x))
    truths = Truths(flat, box)
    fired = {e.rule: truths.strength(flat.strengths[flat.rules[e.rule].strength])[0] for e in output.implied}
    firing = [e for e in output.implied if fired[e.rule] > 0.0]
    weighty = [e for e in firing if flat.rules[e.rule].weight > 0.0]
    if not firing:
        return ""
    if not weighty:
        return "rules fire there, but their weight is 0"
    if all(largest_degree(output, output.terms[e.term]) is None for e in weighty):
        seen = f"at the {output.resolution} samples" if output.resolution is not None else "within the range"
        return f"a rule fires there, but its consequent has no area {seen}"
    leaving = [m.kind for m in flat.activations_of(output) if m.kind not in ("general", "proportional")]
    if leaving:
        return f"rules fire there, but 'activation {leaving[0]}' leaves them out"
    lost = [output.implication_of(output.terms[e.term]) for e in weighty if fired[e.rule] >= CERTAIN]
    if output.over_rules or not lost:
        return ""
    return f"rules fire there, but 'implication {lost[0]}' leaves nothing of them"


def _empty_cells(system: FuzzySystem, output: str, point: Mapping[str, float]) -> tuple[Note, ...]:
    """Return a note for each empty cell whose row and column both hold at a point.

    Args:
        system: The system.
        output: Name of the output without a rule there.
        point: Values of the inputs by name.
    """
    notes = []
    for table in _tables(system, output):
        for row, cells in zip(table.row_terms or ("",), table.cells, strict=True):
            if table.rows is not None and not _holds(system, table.rows, row, point):
                continue
            for column, cell in zip(table.column_terms, cells, strict=True):
                if not cell.terms and cell.span is not None and _holds(system, table.columns, column, point):
                    where = f"row '{row}', column '{column}'" if row else f"column '{column}'"
                    notes.append(Note(cell.span, f"the cell of {where} is empty"))
    return tuple(notes)


def _tables(system: FuzzySystem, output: str) -> Iterator[RuleTable]:
    for block in system.blocks:
        parts = block.rules if isinstance(block, RuleBlock) else (block,)
        yield from (p for p in parts if isinstance(p, RuleTable) and output in p.outputs)


def _holds(system: FuzzySystem, variable: str, term: str, point: Mapping[str, float]) -> bool:
    # Imported here: a check without holes saves 8 ms.
    from fuzzyctl.kernels.compile import degree_function

    declared = next((i for i in system.inputs if i.name == variable), None)
    fuzzy_set = declared.term(term) if declared is not None else None
    if declared is None or fuzzy_set is None or variable not in point:
        return False
    degree = degree_function(system, declared, fuzzy_set)
    return degree is not None and degree(point[variable]) > 0.0
