"""Writer of `.fz` text that reads back as the same system, bit for bit."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import ValueOutOfBoundsError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import ONE, Expr, Number, number_text, to_text
from fuzzyctl.formats.fz_strings import guarantee_text, param_text, quoted, require_names
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.model.block import Block
from fuzzyctl.model.method import KNOBS, Activation, Defuzzifier, Method, Semantics
from fuzzyctl.model.profiles import PROFILES, UNSET, Profile
from fuzzyctl.model.rule import And, Antecedent, Cell, Is, Not, Or, Rule, RuleBlock, RuleTable
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import ANYWHERE, Fallback, Hold, Input, Let, LinguisticVariable, Membership, Output
from fuzzyctl.support import arguments

_VARIABLES: Final = {Input: "input", Output: "output", Let: "let"}

#: Keywords of the norms of a method by its fields.
NORM_KEYWORDS: Final = {
    "conjunction": "and",
    "disjunction": "or",
    "implication": "implication",
    "aggregation": "aggregation",
}


def dumps(system: Block) -> str:
    """Return a system, controller, plant or loop as the text of a rule file in its canonical layout.

    Args:
        system: A well-formed system or other block.

    Returns:
        A text with `loads(dumps(system)) == system`; comments of its file are not part of a system. Other systems that
        guarantees name follow it: `loads` then takes `block=system.name`. The blocks that a controller, plant or loop
        calls precede it; a plant of one line is written with its equations.

    Raises:
        ValueOutOfBoundsError: For a name, title, label, unit or citation that a `.fz` file cannot hold; names of other
            formats may be such, and `fuzzyctl convert` changes them. For two blocks of one name.
        ArgumentError: For an object of another kind.
    """
    parts: dict[str, Block] = {}
    for part in arguments.instance("the system", Block, "a FuzzySystem, Controller, Plant or Loop", system).parts:
        if parts.setdefault(part.name, part) != part:
            raise ValueOutOfBoundsError("a name of a rule file", part.name, "that of one block only")
    written = set(parts)
    raw = "\n\n".join("\n".join(_block_lines(part, written)) for part in parts.values()) + "\n"
    return format_source(SourceText(system.name, raw))


def _block_lines(block: Any, written: set[str]) -> Iterator[str]:
    if isinstance(block, FuzzySystem):
        return system_lines(block, written)
    from fuzzyctl.formats.fz_blocks import block_lines  # here, since few files have them

    return block_lines(block)


def system_lines(system: FuzzySystem, written: set[str] | None = None) -> Iterator[str]:
    """Yield the lines of a system, then those of the systems that it names.

    Args:
        system: The system.
        written: Names of systems that are written elsewhere; gets the names of those written here.

    Raises:
        ValueOutOfBoundsError: As `dumps`.
    """
    variables = system.variables
    names = [n.name for part in (system.params, system.hedges, variables, system.rule_blocks) for n in part]
    require_names((system.name, *names, *(t.name for v in variables for t in v.terms)))
    yield from _lines(system, set() if written is None else written)


def dump(system: Block, path: str | os.PathLike[str]) -> None:
    """Write a system, controller, plant or loop to a rule file, whole or not at all; see `dumps`.

    Args:
        system: A well-formed system or other block.
        path: The file; one that exists is replaced.

    Raises:
        DiagnosticError: If the file cannot be written.
        ValueOutOfBoundsError: As `dumps`.
    """
    text = dumps(system)
    path = arguments.path(path)
    from fuzzyctl.support.writing import written_whole

    with written_whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def _lines(system: FuzzySystem, written: set[str]) -> Iterator[str]:
    yield f"system {system.name}{quoted(' ', system.title, 'title')}"
    if system.citation:
        yield f"source{quoted(' ', system.citation, 'citation')}"
    yield from _section(list(method_lines(system.method)))
    yield from _section([f"hedge {h.name}({h.parameter}) = {to_text(h.expression)}" for h in system.hedges])
    yield from _section([param_text(p) for p in system.params])
    for variable in (*system.inputs, *system.lets, *system.outputs):
        yield from _section(list(_variable(variable, PROFILES[system.method.semantics.profile])))
    yield from _rules(b for b in system.blocks if not isinstance(b, RuleBlock))
    for block in system.rule_blocks:
        yield from _section([block_text(block)])
        yield from _rules(block.rules)
    yield from _section([f"require {guarantee_text(g)}" for g in system.guarantees])
    for other in _others(system):
        if other.name not in written:
            written.add(other.name)
            yield from _section(list(_lines(other, written)))


def _others(system: FuzzySystem) -> list[FuzzySystem]:
    """Return the systems that a system names or calls, each once, without those that they call themselves."""
    others: dict[str, FuzzySystem] = {}
    rest = [*system.compared, *system.called]
    while rest:
        other = rest.pop(0)
        others.setdefault(other.name, replace(other, called=()))
        rest.extend(other.called)
    return list(others.values())


def _rules(parts: Iterable[RuleTable | Rule]) -> Iterator[str]:
    """Yield tables and runs of single rules, a blank line before each."""
    loose = False
    for part in parts:
        if isinstance(part, RuleTable):
            yield from _section(list(_table(part)))
            loose = False
            continue
        if not loose:
            yield ""
        yield rule_text(part)
        loose = True


def block_text(block: RuleBlock) -> str:
    """Return the line that begins a rule block."""
    return " ".join(["rules", block.name, *(f"{keyword} {value}" for keyword, value in block_settings(block))])


def block_settings(block: RuleBlock) -> list[tuple[str, str]]:
    """Return the settings of a rule block: keywords with their values."""
    norms = [(NORM_KEYWORDS[n], getattr(block, n)) for n in ("conjunction", "disjunction", "implication")]
    activation = activation_text(block.activation) if block.activation is not None else None
    return [(keyword, value) for keyword, value in (*norms, ("activation", activation)) if value is not None]


def _section(lines: list[str]) -> list[str]:
    return ["", *lines] if lines else []


def method_lines(method: Method) -> Iterator[str]:
    """Yield the settings that differ from the profile in force."""
    profile = PROFILES[method.semantics.profile]
    usual = profile.method
    if method.semantics != Semantics():
        yield f"semantics {semantics_text(method.semantics)}"
    for field, keyword in NORM_KEYWORDS.items():
        if getattr(method, field) != getattr(usual, field):
            yield f"{keyword} {getattr(method, field)}"
    if method.activation != usual.activation:
        yield f"activation {activation_text(method.activation)}"
    if method.defuzzifier != profile.defuzzifier("centroid"):
        yield f"defuzzifier {_defuzzifier_in(profile, method.defuzzifier)}"


def semantics_text(semantics: Semantics) -> str:
    """Return a profile with the knobs that differ from it."""
    usual = PROFILES[semantics.profile].semantics
    other = [f"{knob}={semantics.text(knob)}" for knob in KNOBS if getattr(semantics, knob) != getattr(usual, knob)]
    return f"{semantics.profile}({', '.join(other)})" if other else semantics.profile


def _defuzzifier_in(profile: Profile, d: Defuzzifier) -> str:
    """Return a defuzzifier as it is written under a profile: with the options that differ from it."""
    base = profile.defuzzifier(d.kind)
    if base == Defuzzifier(kind=d.kind):
        return defuzzifier_text(d)
    options = []
    if d.resolution is None and (base.resolution is not None or d.grid != base.grid):
        base, options = Defuzzifier(kind=d.kind), [f"resolution={UNSET['resolution']}"]
    for name in ("resolution", "grid", "rule", "tolerance", "by"):
        value = getattr(d, name)
        if value != getattr(base, name):
            options.append(f"{name}={UNSET[name] if value is None else value}")
    return f"{d.kind}({', '.join(options)})" if options else d.kind


def defuzzifier_text(d: Defuzzifier) -> str:
    """Return a defuzzifier with its options."""
    usual = Defuzzifier(kind=d.kind)
    options = [] if d.resolution is None else [f"resolution={d.resolution}", f"grid={d.grid}"]
    for name in ("rule", "tolerance", "by"):
        value = getattr(d, name)
        if value != getattr(usual, name):
            options.append(f"{name}={value}")
    return f"{d.kind}({', '.join(options)})" if options else d.kind


def activation_text(a: Activation) -> str:
    """Return an activation method with its options."""
    options = []
    if a.count is not None:
        options.append(f"count={a.count}")
    if a.threshold is not None:
        options.append(f"{a.comparison} {_value(a.threshold)}" if a.comparison else f"threshold={_value(a.threshold)}")
    return f"{a.kind}({', '.join(options)})" if options else a.kind


def otherwise_text(otherwise: Expr | Fallback | Hold) -> str:
    """Return the value of an output if no rule fires, as `else` has it."""
    if isinstance(otherwise, Hold):
        return "hold" if otherwise.start is None else f"hold({_start(otherwise.start)})"
    return otherwise if isinstance(otherwise, str) else _value(otherwise)


def _start(start: Expr | str) -> str:
    return start if isinstance(start, str) else to_text(start)


def let_lines(let: Let) -> list[str]:
    """Return a let as lines: itself, then its terms."""
    return list(_variable(let, PROFILES["exact"]))


def _variable(variable: LinguisticVariable, profile: Profile) -> Iterator[str]:
    keyword = next(word for kind, word in _VARIABLES.items() if isinstance(variable, kind))
    head = f"{keyword} {variable.name}{quoted(' ', variable.label, 'label')}"
    if (variable.lower, variable.upper) != ANYWHERE:
        head += f" in [{to_text(variable.lower)}, {to_text(variable.upper)}]"
    head += quoted(" unit ", variable.unit, "unit")
    if isinstance(variable, Let):
        head += f" = {to_text(variable.value)}"
    elif isinstance(variable, Output):
        if variable.value is None and variable.otherwise is not None and variable.otherwise != profile.otherwise:
            head += f" else {otherwise_text(variable.otherwise)}"
        if variable.adaptive is not None:
            head += f" adaptive rate {to_text(variable.adaptive)}"
        for keyword in ("implication", "aggregation"):
            if getattr(variable, keyword) is not None:
                head += f" {keyword} {getattr(variable, keyword)}"
        if variable.defuzzifier is not None:
            head += f" defuzzifier {_defuzzifier_in(profile, variable.defuzzifier)}"
        if variable.clamped:
            head += " clamp"
        if variable.value is not None:
            head += f" = {to_text(variable.value)}"
    elif getattr(variable, "extrapolate", False):
        head += " extrapolate"
    yield head
    for term in variable.terms:
        yield f"{term.name} = {membership_text(term.membership)}"


def _value(expr: Expr) -> str:
    """Return an expression for a place that takes only a number or parentheses."""
    return number_text(expr.value) if isinstance(expr, Number) else f"({to_text(expr)})"


def _table(table: RuleTable) -> Iterator[str]:
    if table.condition is not None:
        yield f"with {antecedent_text(table.condition, top=True)}"
    across = f"{table.rows} x {table.columns}" if table.rows is not None else table.columns
    yield f"table {', '.join(table.outputs)} = {across}"
    yield " ".join(table.column_terms)
    for i, row in enumerate(table.cells):
        label = table.row_terms[i] if table.rows is not None else ""
        yield f"{label} | {' '.join(cell_text(c) for c in row)}"


def cell_text(cell: Cell) -> str:
    """Return a cell of a table."""
    if not cell.terms:
        return "."
    weight = f"*{_value(cell.weight)}" if cell.weight != ONE else ""
    hedges = cell.hedges or ((),) * len(cell.terms)
    return "/".join(_hedged(h, _cell_term(t)) for h, t in zip(hedges, cell.terms, strict=True)) + weight


def _hedged(hedges: tuple[str, ...], term: str) -> str:
    return f"[{' '.join([*hedges, term])}]" if hedges else term


def _cell_term(term: str | Membership) -> str:
    if isinstance(term, str):
        return term
    return _value(term.arguments[0]) if term.kind == "constant" else membership_text(term).replace(", ", ",")


def membership_text(membership: Membership) -> str:
    """Return a membership function or a consequent with its parameters."""
    arguments = [to_text(a) for a in membership.arguments]
    if membership.height != ONE and membership.kind in ("function", "formula"):  # formulas take no 'height='
        arguments = [to_text(membership.height * membership.arguments[0])]
    elif membership.height != ONE:
        arguments.append(f"height={to_text(membership.height)}")
    return f"{'function' if membership.kind == 'formula' else membership.kind}({', '.join(arguments)})"


def rule_text(rule: Rule) -> str:
    """Return a single rule as a line."""
    consequents = ", ".join(
        f"{c.output} is {' '.join([*c.hedges, c.term if isinstance(c.term, str) else membership_text(c.term)])}"
        for c in rule.consequents
    )
    weight = f" weight {_value(rule.weight)}" if rule.weight != ONE else ""
    return f"if {antecedent_text(rule.antecedent, top=True)} then {consequents}{weight}"


def antecedent_text(antecedent: Antecedent, *, top: bool = False) -> str:
    """Return an antecedent; only the outermost goes without parentheses."""
    match antecedent:
        case Is(variable=variable, term=term, hedges=hedges):
            return f"{variable} is {' '.join([*hedges, term])}"
        case Not(operand=operand):
            return f"not {antecedent_text(operand)}"
        case And(operands=operands) | Or(operands=operands):
            word = " and " if isinstance(antecedent, And) else " or "
            text = word.join(antecedent_text(o) for o in operands)
            return text if top else f"({text})"
    raise TypeError(type(antecedent).__name__)
