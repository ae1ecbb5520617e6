"""Links from guarantees to outputs of other systems: `SYSTEM.OUTPUT`, of the same file or of a used one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.suggestions import counted, did_you_mean, listed
from fuzzyctl.expr import Call, Expr, Name, span_of, walk
from fuzzyctl.loading.calls import Elsewhere
from fuzzyctl.model.checks.units import unlike_units
from fuzzyctl.model.guarantee import Guarantee
from fuzzyctl.model.system import FuzzySystem


def link(
    systems: Sequence[FuzzySystem], elsewhere: Elsewhere, *, broken: bool
) -> tuple[tuple[FuzzySystem, ...], list[Diagnostic]]:
    """Give each system the other ones that its guarantees name.

    Args:
        systems: Those of one file.
        elsewhere: Where to look for what is none of them.
        broken: Whether some system of the file has mistakes, so that it may be the one that is missing.

    Returns:
        The systems, without the guarantees that name what is not there, and what is wrong with these.
    """
    linked, mistakes = [], []
    for system in systems:
        others = {s.name: s for s in systems if s is not system}
        found = _Links(system, others, elsewhere, broken)
        kept = tuple(g for g in system.guarantees if found.take(g))
        if found.compared or len(kept) < len(system.guarantees):
            system = replace(system, guarantees=kept, compared=tuple(found.compared.values()))
        linked.append(system)
        mistakes.extend([*found.mistakes, *(unlike_units(system) if found.compared else ())])
    return tuple(linked), mistakes


class _Links:
    """The systems that the guarantees of one system name."""

    def __init__(self, system: FuzzySystem, others: dict[str, FuzzySystem], elsewhere: Elsewhere, broken: bool) -> None:
        self.system, self.others, self.elsewhere, self.broken = system, others, elsewhere, broken
        self.compared: dict[str, FuzzySystem] = {}
        self.mistakes: list[Diagnostic] = []

    def take(self, guarantee: Guarantee) -> bool:
        """Return whether all that a guarantee names of other systems is there."""
        if self.system.lets:
            from fuzzyctl.model.inlined_lets import MOST_LEVELS, MOST_PARTS, inlined, is_too_large

            if is_too_large(self.system, guarantee):
                message = f"the guarantee has more than {MOST_PARTS:,} operations or {MOST_LEVELS} levels of them"
                facts = ("each let that it names counts with the operations of its expression",)
                help_text = "name lets of fewer operations"
                self.mistakes.append(Diagnostic("FZ112", message, guarantee.span, facts=facts, help=help_text))
                return False
            guarantee = inlined(self.system, guarantee)
        parts = [e for e in (guarantee.claim, guarantee.when) if e is not None]
        found = [self._mistake(node) for part in parts for node in walk(part) if "." in _name(node)]
        self.mistakes.extend(d for d in found if isinstance(d, Diagnostic))
        return not any(found)

    def _mistake(self, node: Expr) -> Diagnostic | bool:
        """Return what is wrong with a name, True where something else is to blame, False for nothing."""
        system, _, output = _name(node).partition(".")
        other = self._find(system)
        if other is None:
            return self.broken or self._unknown(node, system)
        for mistake in _misfits(self.system, other, output, node):
            return mistake
        return False

    def _find(self, name: str) -> FuzzySystem | None:
        if name not in self.compared:
            # A file with mistakes may name files that must not be read.
            found = self.others.get(name) or (None if self.broken else self.elsewhere(name))
            if found is None:
                return None
            self.compared[name] = replace(found, guarantees=(), compared=())
        return self.compared[name]

    def _unknown(self, node: Expr, name: str) -> Diagnostic:
        known = list(self.others)
        facts = (f"other systems of the file: {listed(known)}",) if known else ("the file holds no other system",)
        help_text = did_you_mean(name, known) or "add the system, or 'use' the file that holds it"
        if name == self.system.name:
            own = listed([o.name for o in self.system.outputs])
            help_text = f"the system's own outputs have no prefix: {own}"
        return Diagnostic("FZ202", f"no other system '{name}'", span_of(node), facts=facts, help=help_text)


def _misfits(system: FuzzySystem, other: FuzzySystem, output: str, node: Expr) -> Iterator[Diagnostic]:
    """Find an output that the other system lacks, and arguments or inputs that do not fit."""
    place = span_of(node)
    outputs, inputs = [o.name for o in other.outputs], [v.name for v in other.inputs]
    if output not in outputs:
        facts = (f"outputs: {listed(outputs)}",)
        help_text = did_you_mean(output, outputs)
        yield Diagnostic("FZ202", f"system '{other.name}' has no output '{output}'", place, facts=facts, help=help_text)
    if isinstance(node, Call):
        if len(node.arguments) != len(inputs):
            message = f"'{node.function}' takes {counted(len(inputs), 'argument')}, not {len(node.arguments)}"
            yield Diagnostic("FZ303", message, place, help=f"the form is: {node.function}({', '.join(inputs)})")
        return
    lacking = [v for v in other.inputs if v.name not in {own.name for own in system.inputs}]
    if lacking:
        message = f"system '{other.name}' has the input '{lacking[0].name}', which '{system.name}' lacks"
        notes = (Note(lacking[0].span, "declared here"),) if lacking[0].span is not None else ()
        help_text = f"say what it is there: {other.name}.{output}({', '.join(inputs)})"
        yield Diagnostic("FZ214", message, place, help=help_text, notes=notes)


def _name(node: Expr) -> str:
    return node.name if isinstance(node, Name) else node.function if isinstance(node, Call) else ""
