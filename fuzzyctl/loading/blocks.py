"""Controllers, plants and loops of a file: resolved each after those that it names, and checked."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, Note
from fuzzyctl.kernels.plan.expansion import DEEPEST_INSTANCES
from fuzzyctl.lang import syntax as sx
from fuzzyctl.loading.assembly import Part
from fuzzyctl.loading.block_equations import parts_of
from fuzzyctl.model.block import ParamValues
from fuzzyctl.model.checks.blocks import numbers, unread_names
from fuzzyctl.model.checks.units import unlike_block_units
from fuzzyctl.model.controller import EquationBlock
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.plant import Plant
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.resolve.block_names import Callee as Callee
from fuzzyctl.resolve.context import Context

#: Most parts of expressions that the blocks of a file expand to together.
MOST_PARTS: Final = 100_000


class Blocks:
    """Resolves the controllers, plants and loops of a file, each after those that it names.

    Args:
        parts: The blocks of the file.
        systems: Its systems without errors.
        elsewhere: Finds the blocks of used files.
        found_elsewhere: Returns those of the files that have been read to find one.
        folder: The folder of the file; None for a text that may not use files.

    Attributes:
        diagnostics: Their mistakes.
    """

    def __init__(
        self,
        parts: Sequence[Part],
        systems: Sequence[FuzzySystem],
        elsewhere: Callable[[str], Callee | None],
        found_elsewhere: Callable[[], Mapping[str, Callee]],
        folder: Path | None,
    ) -> None:
        self.diagnostics: list[Diagnostic] = []
        self._systems = {s.name: s for s in systems}
        self._elsewhere, self._found_elsewhere, self._folder = elsewhere, found_elsewhere, folder
        self._parts: dict[str, Part] = {}
        self._found: dict[str, EquationBlock | None] = {}
        self._path: list[str] = []
        self._parts_left = MOST_PARTS
        heads = [p.head for p in parts if p.head is not None]
        self._report_repeated(heads)
        for part in parts:
            if isinstance(part.head, sx.Head):
                self._parts.setdefault(part.head.name.text, part)
        #: Names of blocks that may have mistakes.
        self._declared = {h.name.text: _kind(h) for h in heads if not _is_loop(h)}

    def _report_repeated(self, heads: Sequence[sx.System | sx.Head]) -> None:
        """Report names that two blocks have; those of two systems are reported elsewhere."""
        first: dict[str, sx.System | sx.Head] = {}
        for head in heads:
            earlier = first.setdefault(head.name.text, head)
            if earlier is not head and isinstance(earlier, sx.Head) | isinstance(head, sx.Head):
                note = (Note(earlier.name.span, "first declared here"),)
                message = f"there is a block '{head.name.text}' already"
                diagnostic = Diagnostic("FZ201", message, head.name.span, help="rename one of them", notes=note)
                self.diagnostics.append(diagnostic)

    def all(self) -> tuple[EquationBlock, ...]:
        """Return the blocks without mistakes in the order written."""
        results = [self._resolved(name) for name in self._parts]
        return tuple(b for b in results if b is not None)

    def find(self, name: str) -> Callee | None:
        """Return the system, controller or plant of that name, of this file or of a used one."""
        if name in self._systems:
            return self._systems[name]
        if name not in self._parts:
            return self._elsewhere(name)
        block = None if _is_loop(self._parts[name].head) else self._resolved(name)
        return None if isinstance(block, Loop) else block

    def _callees(self) -> dict[str, str]:
        """Return the blocks that can be called, each name with its kind; without the block that is being resolved."""
        kinds = {n: b.kind for n, b in self._found_elsewhere().items()}
        return {name: kind for name, kind in (kinds | self._declared).items() if name not in self._path}

    def _resolved(self, name: str) -> EquationBlock | None:
        part = self._parts[name]
        assert isinstance(part.head, sx.Head)
        if name in self._path:
            circle = " → ".join([*self._path[self._path.index(name) :], name])
            message = f"{part.head.keyword.text} '{name}' contains itself"
            self.diagnostics.append(
                Diagnostic("FZ217", message, part.head.name.span, facts=(circle,), help="remove one of these blocks")
            )
            return None
        if len(self._path) == DEEPEST_INSTANCES:
            message = f"controllers lie more than {DEEPEST_INSTANCES} levels inside each other"
            self.diagnostics.append(Diagnostic("FZ106", message, part.head.name.span))
            return None
        if name not in self._found:
            self._path.append(name)
            self._found[name] = self._examined(part, part.head)
            self._path.pop()
        return self._found[name]

    def _examined(self, part: Part, head: sx.Head) -> EquationBlock | None:
        """Resolve a block and check it; None after a mistake."""
        broken = frozenset(self._declared.keys() - self._systems.keys())
        context = Context(unread=part.tree.unread, nameless=part.tree.nameless, broken=broken, callees=self._callees)
        statements = (*part.shared, *part.tree.statements)
        resolve = _resolver(head.keyword.text)
        block, incomplete, results = resolve(statements, head, self.find, context, path=part.tree.source.name)
        if isinstance(block, Plant) and block.python:
            from fuzzyctl.loading.block_files import with_interface

            block, more = with_interface(block, head, self._folder)
            results = [*results, *more]
        if isinstance(block, Plant) and block.fmu:
            from fuzzyctl.loading.block_files import with_fmu

            block, more = with_fmu(block, head, self._folder)
            results = [*results, *more]
        failed = incomplete or _has_errors(results)
        results = [*results, *numbers(block, ParamValues(block.params, partial=failed))]
        if isinstance(block, Loop) and (block.family or block.guarantees):
            from fuzzyctl.simulation.families import mistakes  # which few loops need

            results.extend(mistakes(block, ParamValues(block.params, partial=failed)))
        if isinstance(block, Loop) and not failed:
            from fuzzyctl.loading.block_files import check_csv

            results.extend(check_csv(block, self._folder))
        if not (failed or _has_errors(results)):
            results.extend(self._expanded(block))
        if not (failed or _has_errors(results)):
            results.extend(unlike_block_units(block))
            results.extend(d for d in unread_names(block) if not part.is_shared(d.span))
        if isinstance(block, Loop) and not (failed or _has_errors(results)):
            from fuzzyctl.simulation.sample_times import measures_without_samples
            from fuzzyctl.simulation.signals import equal_seeds  # which other blocks need not

            results.extend((*equal_seeds(block), *measures_without_samples(block)))
        self.diagnostics.extend(results)
        return None if failed or _has_errors(results) else block

    def _expanded(self, block: EquationBlock) -> Iterator[Diagnostic]:
        """Yield mistakes in the order of the equations, or their number."""
        if self._parts_left <= 0:
            message = f"the blocks of this file expand to more than {MOST_PARTS:,} parts of expressions"
            yield Diagnostic("FZ112", message, block.span, help="spread them over several files")
            return
        try:
            self._parts_left -= parts_of(block)
        except DiagnosticError as error:
            self._parts_left -= MOST_PARTS // 20
            yield from error.diagnostics


def _resolver(kind: str) -> Callable[..., tuple[EquationBlock, bool, list[Diagnostic]]]:
    """Return the resolver of the statements of a block; a file of controllers needs no plants."""
    match kind:
        case "controller":
            from fuzzyctl.resolve.controllers import resolve_controller

            return resolve_controller
        case "plant":
            from fuzzyctl.resolve.plants import resolve_plant

            return resolve_plant
    from fuzzyctl.resolve.loops import resolve_loop

    return resolve_loop


def _kind(head: sx.System | sx.Head) -> str:
    return "system" if isinstance(head, sx.System) else head.keyword.text


def _is_loop(head: Any) -> bool:
    return isinstance(head, sx.Head) and head.keyword.text == "loop"


def _has_errors(diagnostics: Sequence[Diagnostic]) -> bool:
    return any(d.severity == "error" for d in diagnostics)
