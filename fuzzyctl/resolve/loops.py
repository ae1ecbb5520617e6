"""Resolution of a loop: blocks, signals, measures and the duration of a run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.expr import ONE
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.block import Guarantee
from fuzzyctl.model.checks.checks import in_order
from fuzzyctl.model.controller import EquationBlock, Instance
from fuzzyctl.model.loop import MEASURES, SIGNALS, TIME, Always, Disturbance, Loop, Measure, Stable, Varied
from fuzzyctl.model.plant import PLANTS
from fuzzyctl.model.stateful_operators import OPERATORS
from fuzzyctl.resolve.block_expressions import Inner
from fuzzyctl.resolve.block_names import Find
from fuzzyctl.resolve.block_statements import Statements
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.variables import resolve_bounds

if TYPE_CHECKING:
    from fuzzyctl.model.block import Node

#: The claim that every member converges, unless a measure or a param has the name.
STABLE = "stable"
#: How a block of a loop is written.
_BLOCK = "CONTROLLER_OR_PLANT(input=EXPRESSION, ..., param=value)"


def resolve_loop(
    statements: Sequence[sx.Statement], head: sx.Head, find: Find, context: Context, *, path: str
) -> tuple[Loop, bool, list[Diagnostic]]:
    """Give the statements of a loop their meaning; as `resolve_controller`."""
    work = _Loop(context, head, find)
    work.declare(statements)
    loop = work.build(statements, path)
    return loop, work.incomplete, in_order(work.context.diagnostics)


class _Loop(Statements):
    kind = "loop"
    given = (TIME,)
    own = tuple(dict.fromkeys((*SIGNALS, *MEASURES)))
    #: The part under check: a "let", "measure", "require" or "always" line, or the "argument" of a measure.
    line = "let"

    def build(self, statements: Sequence[sx.Statement], path: str) -> Loop:
        """Resolve the statements; those without a meaning are reported and left out."""
        parts = self.parts(statements)
        claims = [self._require(s) for s in statements if isinstance(s, sx.Require)]
        self.incomplete = self.incomplete or None in claims
        duration, step = self._run(statements)
        has_blocks = any(isinstance(s, sx.Equation) and s.keyword.text == "block" for s in statements)
        if not has_blocks and "block" not in self.context.unread:
            message = f"loop '{self.head.name.text}' has no blocks"
            help_text = f"add a controller and a plant: block NAME = {_BLOCK}"
            self.context.report("FZ212", message, self.head.name.span, help=help_text)
        return Loop(
            **self.shared_fields(statements, parts),
            instances=parts.get("block", ()),
            measures=parts.get("measure", ()),
            requirements=tuple(c for c in claims if c is not None and not isinstance(c, Always | Stable)),
            guarantees=tuple(c for c in claims if isinstance(c, Always | Stable)),
            varied=tuple(self._varied(statements)),
            disturbances=parts.get("disturbance", ()),
            duration=duration,
            step=step,
            path=path,
        )

    @cached_property
    def names(self) -> Set[str]:
        """All names that a signal may use."""
        signals = (n for n, s in self.named.items() if s.keyword.text != "measure")
        return {*self.context.params, *signals, *chain.from_iterable(self.members.values()), *self.given}

    @cached_property
    def _measures_and_params(self) -> Set[str]:
        return {*self.context.params, *(n for n, s in self.named.items() if s.keyword.text == "measure")}

    def equation(self, s: sx.Equation) -> Node | None:
        return self._instance(s) if s.keyword.text == "block" else super().equation(s)

    def _instance(self, s: sx.Equation) -> Instance | None:
        if not isinstance(s.value, ex.Call):
            message = "expected a call of a controller or plant"
            help_text = f"the form is: block {s.name.text} = {_BLOCK}"
            self.context.report("FZ214", message, ex.span_of(s.value), help=help_text)
            return None
        block = self.found(s.value.function)
        if block is not None and block.is_function:
            help_text = f"write: let {s.name.text} = {ex.to_text(s.value)}"
            message = f"'{block.name}' is a system, and 'block' takes a controller or plant"
            self.context.report("FZ214", message, s.value.span, help=help_text)
            return None
        if block is None:
            self._unknown_block(s.value)
            return None
        if not self.arguments(s.value, [i.name for i in block.inputs], [p.name for p in block.params], self.formula):
            return None
        return Instance(name=s.name.text, controller=block.name, arguments=s.value.arguments, span=s.name.span)

    def _unknown_block(self, call: ex.Call) -> None:
        if call.function in PLANTS:
            message = f"'{call.function}' makes a plant, which is a block of its own"
            help_text = f"write above the loop: plant NAME = {PLANTS[call.function].form}"
            self.context.report("FZ214", message, call.span, help=help_text)
        else:
            self.unknown_call(call, "controller or plant", ())

    def signal(self, s: sx.Signal) -> Node | None:
        """Resolve a `measure` or a `disturbance` line."""
        assert s.value is not None, "only inputs have none"
        if s.keyword.text == "disturbance":
            bounds, fine = resolve_bounds(self.context, s.bounds), self.constant(s.value)
            if bounds is None or not fine:
                return None
            return Disturbance(
                name=s.name.text, label=s.label, unit=s.unit, bounds=bounds, nominal=s.value, span=s.name.span
            )
        self.line = "measure"
        fine = self.formula(s.value, names=self._measures_and_params, kind="measure or param")
        self.line = "let"
        if not fine:
            return None
        return Measure(name=s.name.text, value=s.value, label=s.label, unit=s.unit, span=s.name.span)

    def own_call(self, call: ex.Call, inner: Inner, *, pure: bool) -> bool:
        function = call.function
        if not pure and self.line == "measure" and function in MEASURES:
            self.line = "argument"
            fine = self.form(call, MEASURES, self.formula)
            self.line = "measure"
            return fine
        if not pure and self.line == "let" and function in SIGNALS:
            return self._steps(call) if SIGNALS[function].pairs else self.form(call, SIGNALS, inner)
        if function in MEASURES:
            message = f"'{function}' is a measure, which only 'measure' lines may call"
            help_text = f"write: measure NAME = {MEASURES[function].form}"
        else:
            message = f"'{function}' is a signal of time, which only 'let' and 'block' lines may call"
            help_text = "give it a name with 'let'"
        self.context.report("FZ214", message, call.span, help=help_text)
        return False

    def _steps(self, call: ex.Call) -> bool:
        form = SIGNALS[call.function].form
        odd = [a for a in call.arguments if not isinstance(a, ex.Pair)]
        if odd or not call.arguments:
            span = ex.span_of(odd[0]) if odd else call.span
            message = f"'{call.function}' takes pairs of a time and a value"
            self.context.report("FZ303", message, span, help=f"the form is: {form}")
            return False
        return all([self.constant(part) for pair in call.arguments for part in ex.children(pair)])

    def elsewhere(self, call: ex.Call) -> str:
        if call.function == "delay":
            return "write a plant above the loop: plant lag = tf(num=[1], den=[1], delay=0.1 s), and add it as a block"
        if call.function in OPERATORS:
            return "put it into a controller, and add that as a block"
        return f"write above the loop: plant NAME = {PLANTS[call.function].form}" if call.function in PLANTS else ""

    def instead_of(self, name: str, kind: str) -> str:
        if kind != "measure or param":
            return ""
        example = f"a measure makes a number of a signal, such as: maximum({name})"
        if self.line == "measure":
            return example
        every = (
            f"; a claim about every instant of it begins with 'require always {name}'" if self.line == "require" else ""
        )
        return f"{example}, in a 'measure' line{every}"

    @cached_property
    def _starts_and_params(self) -> dict[str, None]:
        """The numbers in which members of a family may differ."""
        names = list(self.context.params)
        for instance, block in self._blocks():
            names += [f"{instance}.{s.name}" for s in block.states] + [f"{instance}.{p.name}" for p in block.params]
        return dict.fromkeys(names)

    def _blocks(self) -> Iterator[tuple[str, EquationBlock]]:
        """Yield the blocks of the loop by the names of their instances."""
        for name, s in self.named.items():
            block = self.found(s.value.function) if isinstance(s.value, ex.Call) else None
            if s.keyword.text == "block" and isinstance(block, EquationBlock):
                yield name, block

    def _varied(self, statements: Sequence[sx.Statement]) -> Iterator[Varied]:
        """Resolve the `for` lines."""
        earlier: dict[str, sx.Varied] = {}
        for s in statements:
            if not isinstance(s, sx.Varied):
                continue
            name, bounds = s.name.text, resolve_bounds(self.context, s.bounds)
            if name.partition(".")[0] in self.lost:
                self.incomplete = True
            elif name in self.named and self.named[name].keyword.text != "block":
                facts = (f"'{name}' is {self.what(name)}",)
                help_text = "'for' takes BLOCK.STATE, BLOCK.PARAM or a param of the loop"
                message = f"no state or param '{name}'"
                self.context.report("FZ202", message, s.name.span, facts=facts, help=help_text)
            elif name not in self._starts_and_params:
                self.context.unknown("state or param", s.name, self._starts_and_params)
            elif name in earlier:
                note = (earlier[name].span, "first given here")
                message = f"'for {name}' is given twice"
                self.context.report("FZ215", message, s.span, note=note, help="remove one of them")
            elif bounds is not None:
                yield Varied(name=name, bounds=bounds, span=s.name.span)
            earlier.setdefault(name, s)

    @cached_property
    def _instants(self) -> Set[str]:
        """The names that claims about every instant may use: signals of the loop, and all of its blocks."""
        inner = (f"{n}.{s.name}" for n, b in self._blocks() for s in (*b.inputs, *b.states, *b.outputs))
        return {*self.names, *inner}

    def _always(self, s: sx.Always) -> Always | None:
        """Resolve a claim about every instant."""
        measured = [n for n in ex.names_in(s.claim) if self.what(n.name) == "a measure"]
        if measured:
            help_text = f"'{measured[0].name}' is a measure, which judges a whole run: leave 'always' out"
            self.context.report("FZ202", f"no signal '{measured[0].name}'", measured[0].span, help=help_text)
            return None
        self.line = "always"
        fine = self.formula(s.claim, truth=True, names=self._instants, pure=True)
        self.line = "let"
        fine = all([self.constant(e) for e in (s.within, s.begin, s.end) if e is not None]) and fine
        if s.forever and s.end is not None:
            help_text = "remove 'forever', or 'until' and its time"
            self.context.report("FZ214", "a claim goes on 'forever' or 'until' a time", s.span, help=help_text)
            return None
        if not fine:
            return None
        return Always(claim=s.claim, within=s.within, begin=s.begin, end=s.end, forever=s.forever, span=s.span)

    def _require(self, s: sx.Require) -> Guarantee | None:
        """Resolve a claim about measures, or about every member of a family."""
        names = self._measures_and_params
        if isinstance(s, sx.Always):
            return self._always(s)
        is_stable = isinstance(s.claim, ex.Name) and s.claim.name == STABLE and STABLE not in names
        part = s.when if s.within is None else s.within
        if is_stable and part is not None:
            message = "'require stable' takes no tolerance and no condition"
            self.context.report("FZ214", message, ex.span_of(part), help="end the line after 'stable'")
            return None
        if is_stable:
            return Stable(claim=s.claim, span=s.span)
        if s.when is not None:
            help_text = "put the condition into the claim, such as: a <= 1 or b > 2"
            self.context.report(
                "FZ214", "'when' belongs to systems and controllers", ex.span_of(s.when), help=help_text
            )
            return None
        if isinstance(s.claim, ex.Name) and s.claim.name not in names and s.claim.name not in self._instants:
            if s.claim.name == "always":
                help_text = "the form is: require always CONDITION from 20 s until 50 s"
                self.context.report("FZ102", "'require always' lacks its condition", s.claim.span, help=help_text)
            else:
                self.context.unknown(f"a measure, a param nor '{STABLE}'", s.claim, sorted({*names, STABLE}))
            return None
        self.line = "require"
        fine = self.formula(s.claim, truth=True, names=names, kind="measure or param")
        self.line = "let"
        fine = (s.within is None or self.constant(s.within)) and fine
        return Guarantee(claim=s.claim, within=s.within, span=s.span) if fine else None

    def _run(self, statements: Sequence[sx.Statement]) -> tuple[ex.Expr, ex.Expr | None]:
        """Return the duration and the step of the record; the duration is 1 s after a mistake."""
        runs = [s for s in statements if isinstance(s, sx.Run)]
        for again in runs[1:]:
            note = (runs[0].span, "first given here")
            self.context.report("FZ215", "'run' is given twice", again.span, note=note, help="remove one of them")
        if not runs:
            if "run" not in self.context.unread:
                message = f"loop '{self.head.name.text}' has no 'run' line"
                self.context.report("FZ212", message, self.head.name.span, help="add: run 50 s step 10 ms")
            self.incomplete = True
            return ONE, None
        run = runs[0]
        fine = all([self.constant(e) for e in (run.duration, run.step) if e is not None])
        self.incomplete = self.incomplete or not fine
        return (run.duration, run.step) if fine else (ONE, None)
