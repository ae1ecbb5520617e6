"""Reader of FCL: from text to fuzzy systems, with all errors at once."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import PurePath

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.model.rule import Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input
from tests.oracles.fcl import syntax as sx
from tests.oracles.fcl.dialect import Dialect, dialect_of
from tests.oracles.fcl.method import BlockRules, method_of
from tests.oracles.fcl.parser import parse
from tests.oracles.fcl.rules import Vocabulary
from tests.oracles.fcl.scope import Scope
from tests.oracles.fcl.variables import OutputDraft, VariableResolver


def read_all(source: SourceText) -> tuple[tuple[FuzzySystem, ...], list[Diagnostic]]:
    """Return the systems of an FCL file that have no errors, and all diagnostics."""
    file = parse(source)
    dialect = dialect_of(file)
    diagnostics = list(file.diagnostics)
    broken = any(d.severity == "error" for d in diagnostics)
    lost = _words_of([d.span for d in diagnostics if d.severity == "error" and d.span is not None])
    systems = []
    for block in file.blocks:
        found, more = _system(block, dialect, source)
        diagnostics.extend(d for d in more if not (broken and _follows(d, lost)))
        if found is not None and not broken:
            systems.append(found)
    return tuple(systems), [*diagnostics, *_same_names(file.blocks)]


def _same_names(blocks: Sequence[sx.FunctionBlock]) -> Iterator[Diagnostic]:
    """Find function blocks that no name tells apart, so that none of them can be chosen."""
    first: dict[str, sx.FunctionBlock] = {}
    for block in blocks:
        earlier = first.setdefault(block.name, block)
        if earlier is not block:
            message = (
                f"function block '{block.name}' is declared twice" if block.name else "two function blocks have no name"
            )
            notes = (Note(earlier.span, "first declared here"),)
            yield Diagnostic("FZ201", message, block.span, help="rename one of them", notes=notes)


def _words_of(spans: list[Span]) -> set[str]:
    """Return the words on the lines of some places, in small letters."""
    lines = {(span.source.line_text(n)) for span in spans for n in range(span.line, span.end_line + 1)}
    return {word.lower() for line in lines for word in re.findall(r"\w+", line)}


def _follows(diagnostic: Diagnostic, broken: set[str]) -> bool:
    """Whether something is missing that stands in a statement which could not be read."""
    if diagnostic.code == "FZ212":
        return True
    if diagnostic.code not in ("FZ202", "FZ203") or diagnostic.span is None:
        return False
    return diagnostic.span.text.lower() in broken


def read(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Return the system of an FCL file; None where it has errors, or several systems."""
    systems, diagnostics = read_all(source)
    if len(systems) > 1:
        message = f"the file has {len(systems)} function blocks"
        diagnostics.append(Diagnostic("FZ502", message, file=source.name, help="choose one of them by its name"))
    return (systems[0] if len(systems) == 1 else None), diagnostics


def _system(
    block: sx.FunctionBlock, dialect: Dialect, source: SourceText
) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    scope = Scope(dialect)
    variables = VariableResolver(block, scope)
    variables.declare()
    inputs = variables.inputs()
    drafts = variables.outputs(inputs)
    rules = BlockRules(block, scope, _vocabulary(inputs, drafts, block))
    _require_parts(block, inputs, rules.found, scope)
    outputs, method, combined = method_of(drafts, rules, scope)
    if scope.failed:
        return None, scope.diagnostics
    name = block.name or PurePath(source.name).stem
    system = FuzzySystem(
        name=name,
        params=tuple(scope.params.values()),
        method=method,
        inputs=tuple(inputs),
        outputs=tuple(outputs),
        blocks=combined.blocks,
        path=source.name,
        span=block.span,
    )
    return system, scope.diagnostics


def _vocabulary(inputs: list[Input], drafts: list[OutputDraft], block: sx.FunctionBlock) -> Vocabulary:
    """Return the names that rules may use; a term with a mistake of its own counts."""
    written = {b.variable.text: tuple(t.name.text for t in b.terms) for b in block.fuzzy}
    return Vocabulary(
        {i.name: _names(written.get(i.name, ()), tuple(t.name for t in i.terms)) for i in inputs},
        {
            d.name.text: _names(tuple(t.name.text for t in d.block.terms), tuple(t.name for t in d.terms))
            for d in drafts
        },
    )


def _names(written: tuple[str, ...], made: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(dict.fromkeys((*written, *made)))


def _require_parts(block: sx.FunctionBlock, inputs: list[Input], rules: list[Rule], scope: Scope) -> None:
    if not inputs:
        scope.error("FZ212", "the function block has no VAR_INPUT", block.span, help="declare the inputs")
    if not scope.outputs:
        scope.error("FZ212", "the function block has no VAR_OUTPUT", block.span, help="declare the outputs")
    if not any(b.rules for b in block.rules):
        place = block.rules[0].span if block.rules else block.span
        message = "the rule block has no rule" if block.rules else "the function block has no RULEBLOCK"
        scope.error("FZ212", message, place, help="add, for example: RULE 1 : IF x IS low THEN y IS high;")
    elif not rules and not scope.failed:
        message = "every rule block with rules is switched off"
        scope.error("FZ212", message, block.rules[0].span, help="write in one of them: ENABLED : TRUE")
