"""Type of a fuzzy system: one mapping from inputs to outputs; the order in which its outputs are computed."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, overload

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, Note, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.expr import Expr, Number, names_in, span_of
from fuzzyctl.model.block import Block, Guarantee, Hedge
from fuzzyctl.model.method import Activation, Method, RuleMethod
from fuzzyctl.model.rule import Rule, RuleBlock, RuleTable, literals, rule_count, rules_of
from fuzzyctl.model.variable import Hold, Input, Let, LinguisticVariable, Membership, Output
from fuzzyctl.operations import operation
from fuzzyctl.records import dataclass
from fuzzyctl.support.arguments import InputSignature, is_finite

if TYPE_CHECKING:
    from fuzzyctl.annotations import Axes, Column, NamedArrays, NamedColumns, NamedOutputs, Numbers, Scalar


@dataclass(frozen=True, kw_only=True, repr=False)
class FuzzySystem(Block):
    """A fuzzy system as data; evaluation never writes into it.

    Args:
        hedges: Hedges of the file, besides those of `formulas.HEDGES`.
        method: Norms, implication, aggregation, defuzzifier.
        inputs: In the order of declaration, which is the order of a kernel's arguments.
        outputs: In the order of declaration, which is the order of a kernel's results.
        blocks: Rule tables and single rules in the order written, then rule blocks.
        guarantees: The `require` statements.
        compared: The other systems that they name, as `SYSTEM.OUTPUT`, without their guarantees.
        lets: Named values of the inputs, in the order of declaration.
        called: The other systems that lets call, as `SYSTEM.OUTPUT(...)`, without their guarantees.
    """

    kind: ClassVar[str] = "system"
    is_function: ClassVar[bool] = True

    hedges: tuple[Hedge, ...] = ()
    method: Method = field(default_factory=Method)
    inputs: tuple[Input, ...]
    outputs: tuple[Output, ...]
    blocks: tuple[RuleTable | Rule | RuleBlock, ...]
    guarantees: tuple[Guarantee, ...] = ()
    compared: tuple[FuzzySystem, ...] = ()
    lets: tuple[Let, ...] = ()
    called: tuple[FuzzySystem, ...] = ()

    __signature__ = InputSignature(named=lambda system: [v.name for v in system.inputs])

    def __post_init__(self) -> None:
        super().__post_init__()
        kinds = [isinstance(b, RuleBlock) for b in self.blocks]
        if kinds != sorted(kinds):  # a rule file has no form for this
            names = [type(b).__name__ for b in self.blocks]
            order = "in order: tables and rules of no rule block come before all rule blocks"
            raise ValueOutOfBoundsError("FuzzySystem.blocks", names, order)

    def __repr__(self) -> str:
        inputs, outputs = (", ".join(v.name for v in some) for some in (self.inputs, self.outputs))
        rules = counted(sum(map(rule_count, self.tables_and_rules)), "rule")
        return printable(f"FuzzySystem({self.name}: {inputs} -> {outputs}; {rules})")

    @property
    def identity(self) -> dict[str, str]:
        """Kind and name, and by whose numerics it computes."""
        return {**super().identity, "semantics": self.method.semantics.profile}

    @property
    def systems(self) -> tuple[FuzzySystem, ...]:
        """The system itself, by the name that systems have in every block."""
        return (self,)

    @property
    def definitions(self) -> tuple[Let, ...]:
        """The lets, by the name that they have in every block."""
        return self.lets

    def with_systems(self, change: Callable[[FuzzySystem], FuzzySystem]) -> FuzzySystem:
        """Return the system after a change."""
        return change(self)

    @property
    def variables(self) -> tuple[LinguisticVariable, ...]:
        """The inputs, the outputs and the lets, which have terms."""
        return (*self.inputs, *self.outputs, *self.lets)

    @property
    def rule_blocks(self) -> tuple[RuleBlock, ...]:
        """The rule blocks in the order written."""
        return tuple(b for b in self.blocks if isinstance(b, RuleBlock))

    @property
    def tables_and_rules(self) -> tuple[RuleTable | Rule, ...]:
        """All tables and single rules in the order written, those of rule blocks included."""
        results: list[RuleTable | Rule] = []
        for block in self.blocks:
            results.extend(block.rules if isinstance(block, RuleBlock) else (block,))
        return tuple(results)

    @cached_property
    def rules(self) -> tuple[Rule, ...]:
        """All rules, those of the tables included, in the order written; adaptive states follow this order."""
        return tuple(rule for part in self.tables_and_rules for rule in rules_of(part))

    @cached_property
    def conclusions(self) -> dict[str, list[tuple[int, int]]]:
        """By output the positions of the rules that name it, and of the consequents that do."""
        results: dict[str, list[tuple[int, int]]] = {}
        for r, rule in enumerate(self.rules):
            for k, consequent in enumerate(rule.consequents):
                results.setdefault(consequent.output, []).append((r, k))
        return results

    @cached_property
    def rule_methods(self) -> tuple[RuleMethod, ...]:
        """The methods of each rule, in the order of `rules`."""
        usual = self.method
        results: list[RuleMethod] = []
        of_none = RuleMethod(-1, usual.conjunction, usual.disjunction, None, usual.activation)
        for part in self.blocks:
            if not isinstance(part, RuleBlock):
                results.extend([of_none] * rule_count(part))
        for position, block in enumerate(self.rule_blocks):
            method = RuleMethod(
                position,
                block.conjunction or usual.conjunction,
                block.disjunction or usual.disjunction,
                block.implication,
                block.activation or usual.activation,
            )
            results.extend([method] * sum(map(rule_count, block.rules)))
        return tuple(results)

    def implication_of(self, rule: int, output: Output) -> str:
        """Return the implication of a rule, given by its position, for an output.

        The one nearest to the rule counts: of its block, else of the output, else of the system.
        """
        return self.rule_methods[rule].implication or output.implication or self.method.implication

    def implications_of(self, output: Output) -> tuple[str, ...]:
        """Return the different implications of the rules that conclude an output; without a rule that of the output."""
        rules = dict.fromkeys(r for r, _ in self.conclusions.get(output.name, ()))
        result = tuple(dict.fromkeys(self.implication_of(r, output) for r in rules))
        return result or (output.implication or self.method.implication,)

    @property
    def keeps_state(self) -> bool:
        """Whether an output adapts or is held, so that a value depends on earlier ones."""
        return any(o.adaptive is not None or isinstance(o.otherwise, Hold) for o in self.outputs)

    def range_of(self, signal: Any) -> tuple[float, float]:
        """Return the ends of the range of an input or output."""
        return self.number(signal.lower), self.number(signal.upper)

    def with_rules(self, rules: Sequence[Rule]) -> FuzzySystem:
        """Return the system with other rules, as many and each in the block of the one whose place it takes.

        Tables become single rules.
        """
        loose = [r for r, m in zip(rules, self.rule_methods, strict=True) if m.block < 0]
        blocks = [
            replace(block, rules=tuple(r for r, m in zip(rules, self.rule_methods, strict=True) if m.block == k))
            for k, block in enumerate(self.rule_blocks)
        ]
        return replace(self, blocks=(*loose, *(b for b in blocks if b.rules)))

    def input(self, name: str) -> Input:
        """Return the input of that name, or raise `UnknownNameError`."""
        return _find("input", name, self.inputs)

    def output(self, name: str) -> Output:
        """Return the output of that name, or raise `UnknownNameError`."""
        return _find("output", name, self.outputs)

    def with_params(self, **values: float) -> FuzzySystem:
        """Return the system with some params set to numbers.

        Args:
            values: New values by name; params computed from them follow.

        Raises:
            UnknownNameError: For a name that is not a param.
            ValueOutOfBoundsError: For a value that is not finite.
            DiagnosticError: When the system is not well formed with these values, such as feet out of order.
        """
        names = [p.name for p in self.params]
        for name, value in values.items():
            if name not in names:
                raise UnknownNameError("param", name, names)
            if not is_finite(value):
                raise ValueOutOfBoundsError(f"param {name!r}", value, "a finite number")
        params = tuple(
            replace(p, expression=Number(float(values[p.name]))) if p.name in values else p for p in self.params
        )
        compared = tuple(self._followed(c, values) for c in self.compared)
        called = tuple(self._followed(c, values) for c in self.called)
        changed = replace(self, params=params, compared=compared, called=called)
        operation("require_well_formed")(changed)
        return changed

    def with_values(self, values: Mapping[str, Any]) -> FuzzySystem:
        """Return the system with other values of free numbers, see `model.free_numbers.with_numbers`."""
        system: FuzzySystem = operation("with_numbers")(self, values)
        return system

    def _followed(self, compared: FuzzySystem, values: Mapping[str, float]) -> FuzzySystem:
        """Set in another system the params that are declared in one place for both."""
        declared = {(p.name, p.span) for p in self.params if p.span is not None}
        shared = {p.name: values[p.name] for p in compared.params if p.name in values and (p.name, p.span) in declared}
        return compared.with_params(**shared) if shared else compared

    def plot(
        self,
        x: str | None = None,
        y: str | None = None,
        *,
        output: str | None = None,
        at: Mapping[str, float] | Column | None = None,
        resolution: int = 61,
        ax: Axes | None = None,
    ) -> Axes:
        """Draw an output over one or two inputs, see `fuzzyctl.plot.surface`."""
        axes: Axes = operation("plot_surface")(self, x, y, output=output, at=at, resolution=resolution, ax=ax)
        return axes

    @overload
    def __call__(self, **inputs: Scalar) -> NamedOutputs: ...  # type: ignore[overload-overlap]
    @overload
    def __call__(self, **inputs: Scalar | Column) -> NamedColumns: ...
    @overload
    def __call__(self, **inputs: Numbers) -> NamedArrays: ...
    def __call__(self, *unnamed: Any, **inputs: Numbers | Column) -> NamedOutputs | NamedArrays | NamedColumns:
        """Evaluate the system for numbers or arrays given by name.

        Args:
            unnamed: None; `fuzzyctl.compile(system)` takes inputs by position.
            inputs: A number or an array for every input; arrays broadcast against each other.

        Returns:
            The output, a float or an array of the broadcast shape, for Series of pandas a Series with their index; for
            several outputs a dict of them by name.

        Raises:
            UnknownNameError: For a name that is not an input.
            ArgumentError: When an input is missing, or given without its name.
            NoRuleFiresError: Where no rule fires for an output that says `else error`.
        """
        if unnamed:
            call = ", ".join(f"{v.name}=..." for v in self.inputs)
            raise ArgumentError(f"inputs are given by name: system({call}); a kernel takes them by position")
        return self._by_name(inputs)

    @cached_property
    def derived(self) -> dict[str, Any]:
        """What other packages have computed from the system, such as its plan; a changed copy begins with nothing."""
        return {}

    @cached_property
    def _by_name(self) -> Callable[[Mapping[str, Any]], NamedOutputs | NamedArrays | NamedColumns]:
        """Evaluation by name, compiled at the first call."""
        by_name: Callable[[Mapping[str, Any]], Any] = operation("by_name")(self)
        return by_name


_Variable = TypeVar("_Variable", Input, Output)


def _find(kind: str, name: str, among: tuple[_Variable, ...]) -> _Variable:
    for variable in among:
        if variable.name == name:
            return variable
    raise UnknownNameError(kind, name, [v.name for v in among])


def reads_of(system: FuzzySystem) -> Iterator[tuple[str, dict[str, Span | None]]]:
    """Yield for each consequent its output and the outputs that its rule waits for, each with its place.

    A rule waits for outputs in its antecedent, unless they count there with the degree that the rules before have
    reached; for outputs that its consequent is a function of; and where an activation method compares it with others,
    for what these wait for.
    """
    outputs = {o.name: o for o in system.outputs}
    for output in system.outputs:
        if output.value is not None:
            yield output.name, {n.name: span_of(n) for n in names_in(output.value) if n.name in outputs}
    waits = system.method.semantics.chained == "value"
    functions = {(o.name, t.name): t.membership for o in system.outputs for t in o.terms if _is_function(t.membership)}
    compares = any(b.activation is not None and b.activation.compares for b in system.rule_blocks)
    compared = _compared(system) if waits and (compares or system.method.activation.compares) else {}
    waits = waits and (bool(compared) or _reads_any(system, outputs))
    for rule, method in zip(system.rules, system.rule_methods, strict=True):
        read = _read(rule, outputs) if waits else {}
        if waits and method.activation.compares:
            read = compared[method.block] | read
        for consequent in rule.consequents:
            term = consequent.term
            membership = functions.get((consequent.output, term)) if isinstance(term, str) else term
            inside = _in_function(outputs, membership) if membership is not None and _is_function(membership) else {}
            yield consequent.output, read | inside


def ordered_lets(system: FuzzySystem) -> tuple[Let, ...]:
    """Return the lets each after those it reads; those of a circle, which is reported, come last."""
    order: dict[str, Let] = {}
    left = {v.name: v for v in system.lets}
    while left:
        ready = [v for v in left.values() if not any(n.name in left for n in names_in(v.value))]
        order |= {v.name: v for v in ready or left.values()}
        left = {name: v for name, v in left.items() if name not in order}
    return tuple(order.values())


def values_of(system: FuzzySystem) -> Iterator[Expr]:
    """Yield the expressions of lets, and of outputs that are formulas."""
    yield from (v.value for v in system.lets)
    yield from (o.value for o in system.outputs if o.value is not None)


def comparisons_that_wait(system: FuzzySystem) -> Iterator[Diagnostic]:
    """Find for each rule block whose activation method compares rules one that reads an output of another one."""
    blocks: dict[int, list[Rule]] = {}
    methods: dict[int, Activation] = {}
    for rule, method in zip(system.rules, system.rule_methods, strict=True):
        if method.activation.compares:
            blocks.setdefault(method.block, []).append(rule)
            methods[method.block] = method.activation
    for block, rules in blocks.items():
        yield from _comparison_that_waits(system, rules, methods[block])


def _comparison_that_waits(system: FuzzySystem, rules: Sequence[Rule], method: Activation) -> Iterator[Diagnostic]:
    """Find the same for the rules of one block, or of none."""
    concluded = {c.output for rule in rules for c in rule.consequents}
    reader = next((i for rule in rules for i in literals(rule.antecedent) if i.variable in concluded), None)
    if reader is not None:
        among = "all rules" if not system.rule_blocks else "the rules of a block"
        message = f"activation '{method.kind}' compares {among} at once, and some of them read an output"
        message += " that others set" if system.rule_blocks else ""
        note = (Note(reader.span, f"'{reader.variable}' is read here"),) if reader.span is not None else ()
        help_text = "use 'activation general', or put the rules that read it into a rule block of their own"
        yield Diagnostic("FZ214", message, method.span or reader.span, help=help_text, notes=note)


def _compared(system: FuzzySystem) -> dict[int, dict[str, Span | None]]:
    """Return for each rule block, and -1 for none, the outputs that its rules read and that it does not set itself."""
    outputs = {o.name: o for o in system.outputs}
    results: dict[int, dict[str, Span | None]] = {}
    for rule, method in zip(system.rules, system.rule_methods, strict=True):
        results[method.block] = results.get(method.block, {}) | _read(rule, outputs)
    for rule, method in zip(system.rules, system.rule_methods, strict=True):
        for consequent in rule.consequents:
            results[method.block].pop(consequent.output, None)
    return results


def _read(rule: Rule, outputs: Container[str]) -> dict[str, Span | None]:
    return {i.variable: i.span for i in literals(rule.antecedent) if i.variable in outputs}


def _reads_any(system: FuzzySystem, outputs: Container[str]) -> bool:
    """Whether any antecedent names an output; a table names its inputs in its head."""
    for part in system.tables_and_rules:
        heads = (part.condition,) if isinstance(part, RuleTable) else (part.antecedent,)
        if isinstance(part, RuleTable) and (part.rows in outputs or part.columns in outputs):
            return True
        if any(i.variable in outputs for head in heads if head is not None for i in literals(head)):
            return True
    return False


def _is_function(membership: Membership) -> bool:
    return membership.kind == "function"


def _in_function(outputs: dict[str, Output], membership: Membership) -> dict[str, Span | None]:
    return {n.name: span_of(n) for n in names_in(membership.arguments[0]) if n.name in outputs}
