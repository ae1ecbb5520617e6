"""Links between blocks: calls of other blocks, and outputs of other systems in guarantees, SYSTEM.OUTPUT."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.fixes import Fix, respelt_as_suggested
from fuzzyctl.diagnostics.suggestions import counted, did_you_mean, listed
from fuzzyctl.expr import Call, Expr, Name, span_of, walk
from fuzzyctl.model.block import Guarantee
from fuzzyctl.model.checks.units import unlike_units
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold

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
