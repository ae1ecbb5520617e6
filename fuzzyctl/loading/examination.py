"""Everything that a source holds, with all its diagnostics: parse → assemble → resolve → check → link calls."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, Note
from fuzzyctl.diagnostics.fixes import Fix, respelt_as_suggested
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import counted, did_you_mean, listed
from fuzzyctl.expr import Call, Expr, Name, span_of, walk
from fuzzyctl.formats.registry import format_of
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.parser import parse
from fuzzyctl.lang.repaired_text import in_original
from fuzzyctl.loading.assembly import Part, bring_in, path_below, split, without_other_loops
from fuzzyctl.model.block import Block, Guarantee
from fuzzyctl.model.checks.checks import check_model
from fuzzyctl.model.checks.units import unlike_units
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold
from fuzzyctl.resolve import resolve
from fuzzyctl.support.files import read_source

if TYPE_CHECKING:
    from fuzzyctl.loading.blocks import Callee
    from fuzzyctl.model.controller import Controller, EquationBlock
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.model.plant import Plant


#: Most systems of a file, and most statements that they share, counted once for each system.
MAX_SYSTEMS: Final = 200
MAX_SHARED: Final = 20_000

_Block = TypeVar("_Block", bound=Block)

#: By file its systems, controllers and plants.
Opened = dict[Path, tuple["Callee", ...]]


@dataclasses.dataclass(frozen=True)
class Examined:
    """The contents of a source.

    Args:
        source: The text.
        blocks: Those without errors: systems, then controllers, plants and loops, each in the order written.
        diagnostics: All of them, whatever the file allows or denies.
        policy: The lines that allow and deny diagnostics.
    """

    source: SourceText
    blocks: tuple[Block, ...]
    diagnostics: list[Diagnostic]
    policy: tuple[sx.Allow, ...] = ()

    def of(self, kind: type[_Block]) -> tuple[_Block, ...]:
        """Return the blocks of a kind."""
        return tuple(b for b in self.blocks if isinstance(b, kind))

    @property
    def systems(self) -> tuple[FuzzySystem, ...]:
        """The systems."""
        return self.of(FuzzySystem)

    @property
    def equations(self) -> tuple[EquationBlock, ...]:
        """The controllers, plants and loops."""
        from fuzzyctl.model.controller import EquationBlock

        return self.of(EquationBlock)

    @property
    def controllers(self) -> tuple[Controller, ...]:
        """The controllers."""
        from fuzzyctl.model.controller import Controller

        return self.of(Controller)

    @property
    def plants(self) -> tuple[Plant, ...]:
        """The plants."""
        from fuzzyctl.model.plant import Plant

        return self.of(Plant)

    @property
    def loops(self) -> tuple[Loop, ...]:
        """The loops."""
        from fuzzyctl.model.loop import Loop

        return self.of(Loop)

    def reported(self, diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
        """Return diagnostics in order, as the lines of the file want them."""
        results = list(diagnostics)
        if not results and not self.policy:
            return []
        from fuzzyctl.loading.policy import apply_policy, in_order

        if format_of(self.source.name) is not None:
            from fuzzyctl.formats.foreign import with_option

            results = [with_option(d) for d in results]
        return [in_original(d) for d in apply_policy(in_order(self.source, results), self.policy)]


def look_through(
    source: SourceText,
    *,
    folder: Path | None = None,
    hints: bool = True,
    opened: Opened | None = None,
    loop: str | None = None,
    parsed: tuple[sx.SyntaxTree, list[Diagnostic]] | None = None,
) -> Examined:
    """Examine all systems of a source; the caller, who knows all diagnostics, applies its `allow` and `deny` lines.

    Args:
        source: The text.
        folder: The folder of the files that it uses.
        hints: Whether to look for warnings.
        opened: The systems of files that have been read for this check already.
        loop: Name of the loop that is wanted; mistakes in other loops of the file are left out.
        parsed: The statements of the source with its mistakes, where they are known.
    """
    foreign = format_of(source.name)
    if foreign is not None:
        from fuzzyctl.formats.foreign import examine_foreign

        return Examined(source, *examine_foreign(foreign, source))
    tree, mistakes = parse(source) if parsed is None else parsed
    if loop is not None:
        tree, mistakes = without_other_loops(tree, mistakes, loop)
    tree, more = bring_in(tree, folder)
    diagnostics = [*mistakes, *more]
    broken = bool(more) or (bool(mistakes) and not tree.repaired)
    policy = [s for s in tree.statements if isinstance(s, sx.Allow)]
    hints = hints or any(line.keyword.text == "deny" for line in policy)
    parts = split(tree)
    crowd = _crowded(source, parts)
    if crowd is not None:
        return Examined(source, (), [in_original(d) for d in (*diagnostics, crowd)], tuple(policy))
    systems, results = _examined_systems(tree, parts, broken, hints)
    diagnostics.extend(results)
    used = _Used(tree, folder, {} if opened is None else opened)
    failed = any(d.severity == "error" for d in diagnostics)
    called, wrong = tuple(systems), list[Diagnostic]()
    if any(s.lets for s in systems):
        called, wrong = with_called(systems, used.system, broken=failed)
    linked, more = link(called, used.system, broken=failed or bool(wrong))
    diagnostics.extend(wrong)
    equations: tuple[EquationBlock, ...] = ()
    if any(isinstance(part.head, sx.Head) for part in parts):
        from fuzzyctl.loading.blocks import Blocks

        blocks = Blocks(parts, linked, used.block, lambda: used.blocks, folder)
        equations = blocks.all()
        diagnostics.extend(_without_follow_ups(source, mistakes, blocks.diagnostics))
    # A system that was read after repairs is not one of the file, but its mistakes are those of the file.
    results = [in_original(d) for d in (*diagnostics, *more, *used.mistakes)]
    return Examined(source, () if mistakes else (*linked, *equations), results, tuple(policy))


def _examined_systems(
    tree: sx.SyntaxTree, parts: Sequence[Part], broken: bool, hints: bool
) -> tuple[list[FuzzySystem], list[Diagnostic]]:
    """Resolve and check the systems among the parts of a file, whose calls are not linked yet."""
    systems: list[FuzzySystem] = []
    diagnostics: list[Diagnostic] = []
    for part, key in zip(parts, _as_written(tree, parts, broken, hints), strict=True):
        if isinstance(part.head, sx.Head):
            continue
        system, findings = _examine_part(part, broken, hints, key)
        # Warnings are about the file as it is, not as repaired.
        diagnostics.extend(d for d in findings if d.severity == "error" or not tree.repaired)
        systems.extend([system] if system is not None else [])
    return systems, [*diagnostics, *_same_names(systems)]


def _without_follow_ups(source: SourceText, mistakes: list[Diagnostic], found: list[Diagnostic]) -> list[Diagnostic]:
    """Leave out mistakes in the meaning of lines without a keyword, or with an open parenthesis."""
    lines = {d.span.line for d in mistakes if d.code in ("FZ101", "FZ103") and d.span is not None}
    return [d for d in found if d.span is None or d.span.source.name != source.name or d.span.line not in lines]


def _crowded(source: SourceText, parts: Sequence[Part]) -> Diagnostic | None:
    """Report a file with more systems than are read, or with too much that is read for each of them."""
    place = next((s.name.span for s in parts[-1].tree.statements if isinstance(s, sx.System | sx.Head)), None)
    if len(parts) > MAX_SYSTEMS:
        message = f"the file holds {len(parts)} systems, controllers, plants and loops, more than {MAX_SYSTEMS}"
        return Diagnostic("FZ112", message, place, help="spread them over several files")
    shared = len(parts) * len(parts[0].shared)
    if len(parts) > 1 and shared > MAX_SHARED:
        message = (
            f"{len(parts)} systems share {len(parts[0].shared)} statements, {shared} in all, more than {MAX_SHARED}"
        )
        return Diagnostic("FZ112", message, place, help="spread the systems over several files")
    return None


class _Used:
    """The systems of the files that a file uses, read when one of them is named.

    Attributes:
        mistakes: Those of the files read.
    """

    def __init__(self, tree: sx.SyntaxTree, folder: Path | None, opened: Opened) -> None:
        self.opened = opened
        self.uses: dict[Path, sx.Use] = {}
        for use in tree.statements:
            # Files that lie elsewhere or cannot be read are reported where they are brought in.
            if isinstance(use, sx.Use) and folder is not None and (path := path_below(folder, use.path)) is not None:
                self.uses.setdefault(path, use)
        self.paths = [*self.uses]
        self.compared: set[str] = set()
        self.blocks: dict[str, Callee] = {}
        self.mistakes: list[Diagnostic] = []

    def block(self, name: str) -> Callee | None:
        """Return the system, controller or plant of that name in the first file that holds one."""
        while name not in self.blocks and self.paths:
            path = self.paths.pop(0)
            self.blocks = {s.name: s for s in self._opened(path)} | self.blocks
        result = self.blocks.get(name)
        if result is not None and result.span is not None and name not in self.compared and len(self.uses) > 1:
            self.compared.add(name)
            self.mistakes.extend(self._others(result.kind, name, result.span))
        return result

    def _others(self, kind: str, name: str, first: Span) -> Iterator[Diagnostic]:
        """Yield warnings of further used files that declare a block of a name that is called."""
        for path, use in self.uses.items():
            try:
                source = read_source(path, only_regular=True)
            except DiagnosticError:
                continue
            tree = parse(source)[0] if name in source.text and source.name != first.source.name else None
            for head in () if tree is None else tree.statements:
                if isinstance(head, sx.System | sx.Head) and head.name.text == name:
                    message = f"{use.path_span.text} declares a block '{name}', too"
                    notes = (Note(first, f"this {kind} is called"), Note(head.name.span, "this block is not"))
                    help_text = "rename one of them, or use only the file that is meant"
                    yield Diagnostic("FZ201", message, use.path_span, "warning", help=help_text, notes=notes)

    def system(self, name: str) -> FuzzySystem | None:
        """Return the system of that name in the first file that holds one."""
        result = self.block(name)
        return result if isinstance(result, FuzzySystem) else None

    def _opened(self, path: Path) -> tuple[Callee, ...]:
        """Return the systems of a file, read once however many ways lead to it."""
        key = path.resolve()
        if key not in self.opened:
            self.opened[key] = ()
            try:
                source = read_source(path, only_regular=True)
            except DiagnosticError:
                return ()
            content = look_through(source, folder=path.parent, hints=False, opened=self.opened)
            self.mistakes.extend(d for d in content.reported(content.diagnostics) if d.severity == "error")
            self.opened[key] = (*content.systems, *content.controllers, *content.plants)
        return self.opened[key]


def _as_written(tree: sx.SyntaxTree, parts: Sequence[Part], broken: bool, hints: bool) -> list[int | None]:
    """Return a hash of all texts that each part is made of, those that it shares included; None where there are others.

    Hashes of texts have 64 bits and a key of the process: no two texts that somebody writes have the same.
    """
    text, used = tree.source.text, {s.span.source for s in tree.used}
    starts = [p.head.span.start if p.head is not None and len(parts) > 1 else 0 for p in parts]
    if broken or tree.repaired or any(isinstance(s, sx.Table) and s.csv for s in tree.statements):
        return [None] * len(parts)
    common = (hints, text[: starts[0]], *(s.text for s in sorted(used, key=lambda s: s.name)))
    return [hash((text[a:b], *common)) for a, b in zip(starts, [*starts[1:], len(text)], strict=True)]


#: Systems as they were written that had no mistake and no warning: an editor asks about most of them with every key.
_CLEAN: Final[set[int]] = set()
_MOST_CLEAN: Final = 1000


def _examine_part(
    part: Part, broken: bool, hints: bool, written: int | None
) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    system, diagnostics = resolve(part.tree, part.shared, broken)
    if system is not None:
        diagnostics = [*diagnostics, *(check_model(system, hints=hints) if written not in _CLEAN else ())]
        # A line for several systems need not be used by each.
        once = ("FZ208", "FZ216", "FZ219")
        diagnostics = [d for d in diagnostics if not (d.code in once and part.is_shared(d.span))]
        if written is not None and not diagnostics:
            if len(_CLEAN) >= _MOST_CLEAN:
                _CLEAN.clear()
            _CLEAN.add(written)
    return (None if any(d.severity == "error" for d in diagnostics) else system), diagnostics


def _same_names(systems: list[FuzzySystem]) -> list[Diagnostic]:
    first: dict[str, FuzzySystem] = {}
    same_names = []
    for s in systems:
        earlier = first.setdefault(s.name, s)
        if earlier is not s:
            note = (Note(earlier.span, "first declared here"),) if earlier.span is not None else ()
            message = f"system '{s.name}' is declared twice"
            same_names.append(Diagnostic("FZ201", message, s.span, help="rename one of them", notes=note))
    return same_names


#: Most systems that all systems of a file call together, each as often as it is called, and most rules of these.
MAX_CALLED: Final = 200
MAX_CALLED_RULES: Final = 20_000

#: Finds a system of a used file by its name, or None.
Elsewhere = Callable[[str], FuzzySystem | None]


def calls_of(system: FuzzySystem) -> Iterator[Call]:
    """Yield the calls of other systems in the lets of a system."""
    for let in system.lets:
        yield from (e for e in walk(let.value) if isinstance(e, Call) and "." in e.function)


def with_called(
    systems: Sequence[FuzzySystem], elsewhere: Elsewhere, *, broken: bool
) -> tuple[tuple[FuzzySystem, ...], list[Diagnostic]]:
    """Give each system those that its lets call.

    Args:
        systems: Those of one file.
        elsewhere: Where to look for other names.
        broken: Whether some system of the file has mistakes, so that it may be the one that is missing.

    Returns:
        The systems whose calls are sound, and the mistakes of the others.
    """
    if not any(True for s in systems for _ in calls_of(s)):
        return tuple(systems), []
    work = _Calls({s.name: s for s in systems}, elsewhere, broken)
    results = [work.linked(s) for s in systems]
    return tuple(s for s in results if s is not None), work.mistakes


class _Calls:
    """Links systems, each after those that it calls."""

    def __init__(self, systems: Mapping[str, FuzzySystem], elsewhere: Elsewhere, broken: bool) -> None:
        self.systems, self.elsewhere, self.broken = systems, elsewhere, broken
        self.mistakes: list[Diagnostic] = []
        self.done: dict[str, FuzzySystem | None] = {}
        self.path: list[str] = []
        #: Of each system how many others it calls, directly and through others, and how many rules these have.
        self.weights: dict[str, tuple[int, int]] = {}
        self.called = self.rules = 0

    def linked(self, system: FuzzySystem) -> FuzzySystem | None:
        """Return a system with those that it calls; None for one with a mistake in its calls."""
        if system.name not in self.done:
            self.path.append(system.name)
            called: dict[str, FuzzySystem] = {}
            fine = [self._take(call, called) for call in calls_of(system)]
            self.path.pop()
            fine.append(not all(fine) or self._count(system, called))
            self.done[system.name] = replace(system, called=tuple(called.values())) if all(fine) else None
        return self.done[system.name]

    def _take(self, call: Call, called: dict[str, FuzzySystem]) -> bool:
        name, _, output = call.function.partition(".")
        if name in self.path:
            circle = " → ".join([*self.path[self.path.index(name) :], name])
            return self._refuse(
                "FZ217", "systems call each other in a circle", call, facts=(circle,), help="remove one of these calls"
            )
        named = self.systems.get(name)
        other = self.linked(named) if named is not None else None if self.broken else self.elsewhere(name)
        if other is None:
            names = [n for n in self.systems if n not in self.path]
            help_text = did_you_mean(name, names) or "add the system, or 'use' the file that holds it"
            is_blameless = self.broken or named is not None
            fix = respelt_as_suggested(call.span, name, names)
            return not is_blameless and self._refuse(
                "FZ202", f"no other system '{name}'", call, help=help_text, fix=fix
            )
        called[name] = replace(other, guarantees=(), compared=())
        return self._fits(call, other, output)

    def _count(self, system: FuzzySystem, called: Mapping[str, FuzzySystem]) -> bool:
        """Count the calls of a system, which are written out one by one."""
        calls, rules = self._calls_and_rules(system, called)
        self.called += calls
        self.rules += rules
        message = ""
        if self.called > MAX_CALLED:
            message = f"the systems of the file call more than {MAX_CALLED} others"
        elif self.rules > MAX_CALLED_RULES:
            message = f"the systems that others call have more than {MAX_CALLED_RULES:,} rules"
        facts = ("those that are called call others in turn, and each counts as often as it is called",)
        help_text = "call a system once, or spread the systems over several files"
        return not message or self._refuse("FZ112", message, next(calls_of(system)), facts=facts, help=help_text)

    def _calls_and_rules(self, system: FuzzySystem, called: Mapping[str, FuzzySystem]) -> tuple[int, int]:
        """Return how many systems a system calls, directly and through others, and how many rules they have."""
        if system.name not in self.weights:
            calls = rules = 0
            for call in calls_of(system):
                other = called[call.function.partition(".")[0]]
                inner = self._calls_and_rules(other, {s.name: s for s in other.called})
                calls += 1 + inner[0]
                rules += len(other.rules) + inner[1]
            self.weights[system.name] = calls, rules
        return self.weights[system.name]

    def _fits(self, call: Call, other: FuzzySystem, output: str) -> bool:
        outputs, inputs = [o.name for o in other.outputs], [v.name for v in other.inputs]
        if output not in outputs:
            message, help_text = f"system '{other.name}' has no output '{output}'", did_you_mean(output, outputs)
            return self._refuse("FZ202", message, call, facts=(f"outputs: {listed(outputs)}",), help=help_text)
        if len(call.arguments) != len(inputs):
            message = f"'{call.function}' takes {counted(len(inputs), 'argument')}, not {len(call.arguments)}"
            return self._refuse("FZ303", message, call, help=f"the form is: {call.function}({', '.join(inputs)})")
        name = next((o.name for o in other.outputs if o.adaptive is not None or isinstance(o.otherwise, Hold)), None)
        if name is not None:
            message = f"output '{name}' of '{other.name}' keeps a state, which a system cannot hold"
            return self._refuse("FZ214", message, call, help="call both systems from a controller")
        return True

    def _refuse(
        self,
        code: str,
        message: str,
        call: Call,
        *,
        facts: tuple[str, ...] = (),
        help: str = "",
        fix: Fix | None = None,
    ) -> bool:
        self.mistakes.append(Diagnostic(code, message, call.span, facts=facts, help=help, fix=fix))
        return False


def link(
    systems: Sequence[FuzzySystem], elsewhere: Elsewhere, *, broken: bool
) -> tuple[tuple[FuzzySystem, ...], list[Diagnostic]]:
    """Give each system the other ones that its guarantees name.

    Args:
        systems: Those of one file.
        elsewhere: Where to look for other names.
        broken: Whether some system of the file has mistakes, so that it may be the one that is missing.

    Returns:
        The systems, without the guarantees that name missing parts, and diagnostics on these.
    """
    linked, mistakes = [], []
    for system in systems:
        others = {s.name: s for s in systems if s is not system}
        links = _Links(system, others, elsewhere, broken)
        guarantees = tuple(g for g in system.guarantees if links.take(g))
        if links.compared or len(guarantees) < len(system.guarantees):
            system = replace(system, guarantees=guarantees, compared=tuple(links.compared.values()))
        linked.append(system)
        mistakes.extend([*links.mistakes, *(unlike_units(system) if links.compared else ())])
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
        results = [self._mistake(node) for part in parts for node in walk(part) if "." in _name(node)]
        self.mistakes.extend(d for d in results if isinstance(d, Diagnostic))
        return not any(results)

    def _mistake(self, node: Expr) -> Diagnostic | bool:
        """Return the mistake in a name, True if the cause is elsewhere, False for none."""
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
            other = self.others.get(name) or (None if self.broken else self.elsewhere(name))
            if other is None:
                return None
            self.compared[name] = replace(other, guarantees=(), compared=())
        return self.compared[name]

    def _unknown(self, node: Expr, name: str) -> Diagnostic:
        names = list(self.others)
        facts = (f"other systems of the file: {listed(names)}",) if names else ("the file holds no other system",)
        help_text = did_you_mean(name, names) or "add the system, or 'use' the file that holds it"
        if name == self.system.name:
            outputs = listed([o.name for o in self.system.outputs])
            help_text = f"the system's own outputs have no prefix: {outputs}"
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
    lacking = [v for v in other.inputs if v.name not in {signal.name for signal in system.inputs}]
    if lacking:
        message = f"system '{other.name}' has the input '{lacking[0].name}', which '{system.name}' lacks"
        notes = (Note(lacking[0].span, "declared here"),) if lacking[0].span is not None else ()
        help_text = f"say what it is there: {other.name}.{output}({', '.join(inputs)})"
        yield Diagnostic("FZ214", message, place, help=help_text, notes=notes)


def _name(node: Expr) -> str:
    return node.name if isinstance(node, Name) else node.function if isinstance(node, Call) else ""
