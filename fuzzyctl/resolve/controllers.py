"""Resolution of a controller: names, calls and statements that belong together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted, did_you_mean, listed
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.checks.checks import in_order
from fuzzyctl.model.controller import (
    Controller,
    Definition,
    Function,
    Instance,
    Result,
    Signal,
    State,
)
from fuzzyctl.model.guarantee import Bounds, Param
from fuzzyctl.model.operators import OPERATORS
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold
from fuzzyctl.resolve.context import Context

#: Finds a system or controller by its name; None where there is none.
Find = Callable[[str], FuzzySystem | Controller | None]

#: Functions of controllers besides those of all expressions, with their numbers of arguments.
FUNCTIONS: Final = {"clamp": 3, "where": 3}

#: Names that a controller has without declaring them: the time since the step before [s].
GIVEN: Final = ("dt",)

#: Statements of controllers.
_STATEMENTS: Final = ("input", "output", "state", "let", "next", "block")


def resolve_controller(
    statements: Sequence[sx.Statement], head: sx.Head, find: Find, *, unread: frozenset[str], path: str
) -> tuple[Controller, bool, list[Diagnostic]]:
    """Give the statements of a controller their meaning.

    Args:
        statements: Its own, and those that it shares with other blocks of the file.
        head: The `controller` line.
        find: Finds the systems and controllers that it names.
        unread: Words of lines that could not be read; what they may have declared is no unknown name.
        path: The file.

    Returns:
        The controller, without the parts that have no meaning; whether it has such parts; and the diagnostics in order
        of their locations.
    """
    work = _Resolution(Context(unread=unread), head, find)
    work.declare(statements)
    controller = work.build(statements, path)
    return controller, work.incomplete, in_order(work.context.diagnostics)


@dataclass
class _Resolution:
    context: Context
    head: sx.Head
    find: Find
    functions: dict[str, sx.Function] = field(default_factory=dict)
    named: dict[str, sx.Statement] = field(default_factory=dict)
    #: Outputs of instances and of calls with several outputs, as `NAME.OUTPUT`.
    members: dict[str, sx.Statement] = field(default_factory=dict)
    #: Instances of what is not known, whose outputs are not known either.
    lost: set[str] = field(default_factory=set)
    #: What has been looked for, by name.
    blocks: dict[str, FuzzySystem | Controller | None] = field(default_factory=dict)
    #: Whether some part has no meaning, perhaps through a mistake elsewhere.
    incomplete: bool = False
    systems: dict[str, FuzzySystem] = field(default_factory=dict)
    controllers: dict[str, Controller] = field(default_factory=dict)

    def declare(self, statements: Sequence[sx.Statement]) -> None:
        """Enter all names first, so that statements may come in any order."""
        context = self.context
        context.is_free(self.head.name, "a controller")
        for s in statements:
            match s:
                case sx.Param(name=name) if self._declared(name, "a param"):
                    context.params[name.text] = s
                case sx.Function(name=name) if self._is_new_function(name):
                    self.functions[name.text] = s
                case sx.Signal(name=name, keyword=keyword) if self._declared(
                    name, f"an {keyword.text}".replace("an s", "a s")
                ):
                    self.named[name.text] = s
                case sx.Equation(name=name, keyword=keyword, value=value) if keyword.text in ("let", "block"):
                    if self._declared(name, f"a {keyword.text}"):
                        self.named[name.text] = s
                        self._declare_members(name.text, value, s)

    def _declared(self, word: sx.Word, what: str) -> bool:
        if word.text in GIVEN or word.text in OPERATORS or word.text in FUNCTIONS:
            message = f"'{word.text}' is a word of controllers and cannot name {what}"
            self.context.report("FZ201", message, word.span, help="rename it")
            return False
        return self.context.declare(word, what)

    def _is_new_function(self, word: sx.Word) -> bool:
        known = word.text in ex.FUNCTIONS or word.text in OPERATORS or word.text in FUNCTIONS
        earlier = self.functions.get(word.text)
        if not known and earlier is None:
            return True
        note = (earlier.name.span, "first declared here") if earlier is not None else None
        self.context.report(
            "FZ201", f"there is a function '{word.text}' already", word.span, note=note, help="rename it"
        )
        return False

    def _declare_members(self, name: str, value: ex.Expr, s: sx.Statement) -> None:
        block = self._found(value.function) if isinstance(value, ex.Call) else None
        if isinstance(block, FuzzySystem) and len(block.outputs) > 1:
            self.members |= {f"{name}.{o.name}": s for o in block.outputs}
        elif isinstance(block, Controller):
            self.members |= {f"{name}.{r.name}": s for r in block.results}
        elif block is None and isinstance(s, sx.Equation) and s.keyword.text == "block":
            self.lost.add(name)

    def _found(self, name: str) -> FuzzySystem | Controller | None:
        if name not in self.blocks:
            self.blocks[name] = None if name in self.functions else self.find(name)
        block = self.blocks[name]
        if isinstance(block, FuzzySystem):
            self.systems[name] = block
        elif isinstance(block, Controller):
            self.controllers[name] = block
        return block

    # -- statements

    def build(self, statements: Sequence[sx.Statement], path: str) -> Controller:
        """Resolve the statements; those without a meaning are reported and left out."""
        parts: dict[str, list[object]] = {k: [] for k in ("params", "functions", *_STATEMENTS, "source")}
        period: ex.Expr | None = None
        for s in statements:
            match s:
                case sx.Param(name=name) if self.context.params.get(name.text) is s:
                    parts["params"].append(self._param(s))
                case sx.Function(name=name) if self.functions.get(name.text) is s:
                    parts["functions"].append(self._function(s))
                case sx.Signal(name=name, keyword=keyword) if self.named.get(name.text) is s:
                    parts[keyword.text].append(self._signal(s))
                case sx.Equation(keyword=keyword, name=name) if (
                    keyword.text == "next" or self.named.get(name.text) is s
                ):
                    parts[keyword.text].append(self._equation(s))
                case sx.Every():
                    period = self._period(s, period)
                case sx.Citation(text=text):
                    parts["source"].append(text)
        self.incomplete = any(p is None for found in parts.values() for p in found)
        given = {key: tuple(p for p in found if p is not None) for key, found in parts.items()}
        self._require_updates(statements)
        if not given["output"] and not any(isinstance(s, sx.Signal) and s.keyword.text == "output" for s in statements):
            message = f"controller '{self.head.name.text}' has no outputs"
            self.context.report("FZ212", message, self.head.name.span, help="add an 'output NAME = EXPRESSION' line")
        fields = {
            "params": "params",
            "functions": "functions",
            "inputs": "input",
            "states": "state",
            "definitions": "let",
            "results": "output",
            "updates": "next",
            "instances": "block",
        }
        return Controller(
            name=self.head.name.text,
            title=self.head.title,
            citation="; ".join(str(text) for text in given["source"]),
            period=period,
            systems=tuple(self.systems.values()),
            controllers=tuple(self.controllers.values()),
            path=path,
            span=self.head.name.span,
            **{key: given[own] for key, own in fields.items()},  # type: ignore[arg-type]  # each of its own type
        )

    def _param(self, s: sx.Param) -> Param | None:
        fine = self.context.check_names(s.expression, self.context.params, "param")
        bounds = self._bounds(s.bounds)
        return (
            Param(name=s.name.text, expression=s.expression, unit=s.unit, bounds=bounds, span=s.name.span)
            if fine
            else None
        )

    def _bounds(self, bounds: sx.Bounds | None) -> Bounds | None:
        if bounds is None:
            return None
        fine = [self.context.check_names(e, self.context.params, "param") for e in (bounds.lower, bounds.upper)]
        if not all(fine):
            return None
        return Bounds(
            lower=bounds.lower,
            upper=bounds.upper,
            without_lower=bounds.without_lower,
            without_upper=bounds.without_upper,
            span=bounds.span,
        )

    def _function(self, s: sx.Function) -> Function | None:
        parameters = [p.text for p in s.parameters]
        for k, word in enumerate(s.parameters):
            self.context.is_free(word, "a parameter")
            if word.text in parameters[:k]:
                self.context.report("FZ201", f"parameter '{word.text}' is given twice", word.span, help="rename one")
        names = {*parameters, *self.context.params}
        if not self.formula(s.expression, names=names, kind="parameter or param", pure=True):
            return None
        return Function(name=s.name.text, parameters=tuple(parameters), expression=s.expression, span=s.name.span)

    def _signal(self, s: sx.Signal) -> Signal | State | Result | None:
        shared = {
            "name": s.name.text,
            "label": s.label,
            "unit": s.unit,
            "bounds": self._bounds(s.bounds),
            "span": s.name.span,
        }
        if s.value is None:
            return Signal(**shared)  # type: ignore[arg-type]  # the fields of a signal
        if s.keyword.text == "state":
            fine = self.context.check_names(s.value, self.context.params, "param")
            return State(**shared, start=s.value) if fine else None  # type: ignore[arg-type]
        return Result(**shared, value=s.value) if self.formula(s.value) else None  # type: ignore[arg-type]

    def _equation(self, s: sx.Equation) -> Definition | Instance | None:
        if s.keyword.text == "block":
            return self._instance(s)
        return Definition(name=s.name.text, value=s.value, span=s.name.span) if self.formula(s.value) else None

    def _instance(self, s: sx.Equation) -> Instance | None:
        form = f"block {s.name.text} = CONTROLLER(input, ..., param=value)"
        if not isinstance(s.value, ex.Call):
            self.context.report(
                "FZ214", "expected a call of a controller", ex.span_of(s.value), help=f"the form is: {form}"
            )
            return None
        block = self._found(s.value.function)
        if isinstance(block, FuzzySystem):
            help_text = f"write: let {s.name.text} = {ex.to_text(s.value)}"
            message = f"'{block.name}' is a system, and 'block' takes a controller"
            self.context.report("FZ214", message, s.value.span, help=help_text)
            return None
        if block is None:
            self._unknown_call(s.value, "controller")
            return None
        inputs = [i.name for i in block.inputs]
        if not self._arguments(s.value, inputs, [p.name for p in block.params], self.formula):
            return None
        return Instance(name=s.name.text, controller=block.name, arguments=s.value.arguments, span=s.name.span)

    def _period(self, s: sx.Every, period: ex.Expr | None) -> ex.Expr | None:
        if period is not None:
            self.context.report("FZ215", "'every' is given twice", s.span, help="remove one of them")
        return s.period if self.context.check_names(s.period, self.context.params, "param") else period

    def _require_updates(self, statements: Sequence[sx.Statement]) -> None:
        """Check that each state has its next value, once, and that nothing else has one."""
        states = {n: s for n, s in self.named.items() if isinstance(s, sx.Signal) and s.keyword.text == "state"}
        updates: dict[str, sx.Equation] = {}
        for s in statements:
            if not (isinstance(s, sx.Equation) and s.keyword.text == "next"):
                continue
            name = s.name.text
            if name not in states:
                what = self._what(name)
                facts = (
                    (f"'{name}' is {what}",)
                    if what
                    else (f"states: {listed(list(states))}" if states else "there is no state",)
                )
                help_text = did_you_mean(name, list(states)) or f"declare it: state {name} = START"
                self.context.report("FZ202", f"no state '{name}'", s.name.span, facts=facts, help=help_text)
            elif name in updates:
                note = (updates[name].span, "first given here")
                self.context.report("FZ215", f"the next value of '{name}' is given twice", s.span, note=note)
            updates.setdefault(name, s)
        for name, state in states.items():
            if name not in updates and name not in self.context.unread:
                help_text = f"add: next {name} = EXPRESSION"
                self.context.report("FZ212", f"state '{name}' has no 'next' line", state.name.span, help=help_text)

    def _what(self, name: str) -> str:
        if name in self.context.params:
            return "a param"
        s = self.named.get(name)
        keyword = s.keyword.text if isinstance(s, sx.Signal | sx.Equation) else ""
        return f"an {keyword}" if keyword in ("input", "output") else f"a {keyword}" if keyword else ""

    # -- expressions

    def formula(
        self,
        expr: ex.Expr,
        *,
        truth: bool | None = None,
        names: set[str] | None = None,
        kind: str = "name",
        pure: bool = False,
    ) -> bool:
        """Check an expression.

        Args:
            expr: The expression.
            truth: Whether a condition is expected, or a number; None for either.
            names: The names that it may use; None for all of the controller.
            kind: What these are.
            pure: Whether calls that have a state are refused.
        """

        def inner(part: ex.Expr, truth: bool | None = False) -> bool:
            return self.formula(part, truth=truth, names=names, kind=kind, pure=pure)

        match expr:
            case ex.Compare(left=left, right=right, span=span):
                return all([inner(left), inner(right), self._fits(truth, is_condition=True, span=span)])
            case ex.Logic(operands=operands, span=span):
                parts = [inner(o, True) for o in operands]
                return all([*parts, self._fits(truth, is_condition=True, span=span)])
            case ex.Name(name=name):
                known = self._names() if names is None else names
                fine = name in known or name in ex.CONSTANTS
                if name.partition(".")[0] in self.lost:
                    return False
                if not fine:
                    self.context.unknown(kind, expr, sorted(known))
                elif isinstance(self.named.get(name), sx.Equation) and self._is_several(name):
                    fine = False
                    outputs = [m for m in self.members if m.startswith(f"{name}.")]
                    message = f"'{name}' has several outputs"
                    self.context.report("FZ214", message, expr.span, help=f"write one of: {listed(outputs)}")
                return fine and self._fits(truth, is_condition=False, span=expr.span)
            case ex.Call():
                return self._call(expr, inner, pure=pure) and self._fits(truth, is_condition=False, span=expr.span)
            case ex.Keyword(name=name, span=span):
                self.context.report("FZ303", f"unexpected named argument '{name}'", span)
                return False
        return all([inner(part) for part in ex.children(expr)]) and self._fits(
            truth, is_condition=False, span=ex.span_of(expr)
        )

    def _fits(self, truth: bool | None, *, is_condition: bool, span: Span | None) -> bool:
        if truth is None or truth == is_condition:
            return True
        expected, found = ("a condition", "a number") if truth else ("a number", "a condition")
        help_text = "compare it, such as: x > 0" if truth else "write where(CONDITION, 1, 0)"
        self.context.report("FZ307", f"expected {expected}, found {found}", span, help=help_text)
        return False

    def _names(self) -> set[str]:
        return {*self.context.params, *self.named, *self.members, *GIVEN}

    def _is_several(self, name: str) -> bool:
        return any(m.startswith(f"{name}.") for m in self.members)

    def _call(self, call: ex.Call, inner: Callable[..., bool], *, pure: bool) -> bool:
        function, arguments = call.function, call.arguments
        if function == "where" and len(arguments) == 3:
            return all([inner(arguments[0], True), inner(arguments[1]), inner(arguments[2])])
        if function in FUNCTIONS:
            return self._counted(call, FUNCTIONS[function]) and all([inner(a) for a in arguments])
        if function in self.functions:
            return self._counted(call, len(self.functions[function].parameters)) and all([inner(a) for a in arguments])
        if function in OPERATORS:
            return self._operator(call, inner, pure=pure)
        if function in ex.FUNCTIONS:
            return self.context.check_call(call) and all([inner(a) for a in arguments])
        block = self._found(function)
        if isinstance(block, FuzzySystem):
            if pure and any(o.adaptive is not None or isinstance(o.otherwise, Hold) for o in block.outputs):
                return self._refuse_state(call)
            inputs, params = [i.name for i in block.inputs], [p.name for p in block.params]
            return self._arguments(call, inputs, params, inner)
        if isinstance(block, Controller):
            help_text = f"give it a name: block NAME = {ex.to_text(call)}"
            self.context.report(
                "FZ214", f"'{function}' is a controller, which has a state of its own", call.span, help=help_text
            )
            return False
        self._unknown_call(call, "function, system")
        return False

    def _unknown_call(self, call: ex.Call, kind: str) -> None:
        if call.function in self.context.unread:
            return
        known = [*ex.FUNCTIONS, *FUNCTIONS, *OPERATORS, *self.functions]
        own = [k for k in known if kind != "controller"]
        facts = (f"functions: {', '.join(own)}",) if own else ()
        help_text = did_you_mean(call.function, own) or "add the block, or 'use' the file that holds it"
        what = "controller" if kind == "controller" else "function or system"
        self.context.report("FZ202", f"no {what} '{call.function}'", call.span, facts=facts, help=help_text)

    def _counted(self, call: ex.Call, expected: int) -> bool:
        named = next((a for a in call.arguments if isinstance(a, ex.Keyword)), None)
        if named is not None:
            message = f"'{call.function}' takes its arguments by position"
            self.context.report("FZ303", message, named.span, help="write the value alone")
            return False
        if len(call.arguments) == expected:
            return True
        message = f"'{call.function}' takes {counted(expected, 'argument')}, not {len(call.arguments)}"
        self.context.report("FZ303", message, call.span)
        return False

    def _operator(self, call: ex.Call, inner: Callable[..., bool], *, pure: bool) -> bool:
        operator = OPERATORS[call.function]
        if pure:
            return self._refuse_state(call)
        given = [a for a in call.arguments if not isinstance(a, ex.Keyword)]
        settings = dict(zip(operator.settings, given[1:], strict=False))
        fine = bool(given) and len(given) <= 1 + len(operator.settings)
        for argument in call.arguments:
            if isinstance(argument, ex.Keyword):
                fine = fine and argument.name in operator.settings and argument.name not in settings
                settings[argument.name] = argument.value
        if not fine or len([s for s in operator.settings[: operator.needed] if s in settings]) < operator.needed:
            help_text = f"the form is: {operator.form}"
            self.context.report("FZ303", f"wrong arguments of '{call.function}'", call.span, help=help_text)
            return False
        checks = [inner(given[0])]
        for name, value in settings.items():
            if name in ("start", "samples"):
                checks.append(self.context.check_names(value, self.context.params, "param"))
            else:
                checks.append(inner(value, name == "hold"))
        return all(checks)

    def _refuse_state(self, call: ex.Call) -> bool:
        message = f"'{call.function}' keeps a state, which only 'let', 'next' and 'output' lines may have"
        self.context.report("FZ214", message, call.span, help="give it a name with 'let'")
        return False

    def _arguments(
        self, call: ex.Call, inputs: Sequence[str], params: Sequence[str], inner: Callable[..., bool]
    ) -> bool:
        """Check the arguments of a system or controller: its inputs in order or by name, its params by name."""
        given = [a for a in call.arguments if not isinstance(a, ex.Keyword)]
        fine = True
        bound = list(inputs[: len(given)])
        if len(given) > len(inputs):
            message = f"'{call.function}' takes {counted(len(inputs), 'input')}, not {len(given)}"
            self.context.report("FZ303", message, call.span, facts=(f"inputs: {', '.join(inputs)}",))
            fine = False
        for argument in call.arguments:
            if not isinstance(argument, ex.Keyword):
                fine = inner(argument, truth=False) and fine
            elif argument.name in bound:
                self.context.report("FZ303", f"argument '{argument.name}' is given twice", argument.span)
                fine = False
            elif argument.name in inputs:
                fine = inner(argument.value, truth=False) and fine
            elif argument.name in params:
                fine = self.context.check_names(argument.value, self.context.params, "param") and fine
            else:
                known = [*inputs, *params]
                facts = (f"inputs: {', '.join(inputs)}", *((f"params: {', '.join(params)}",) if params else ()))
                message = f"'{call.function}' has no input or param '{argument.name}'"
                self.context.report(
                    "FZ202", message, argument.span, facts=facts, help=did_you_mean(argument.name, known)
                )
                fine = False
            if isinstance(argument, ex.Keyword):
                bound.append(argument.name)
        missing = [name for name in inputs if name not in bound]
        if fine and missing:
            message = f"'{call.function}' lacks a value for: {', '.join(missing)}"
            self.context.report("FZ303", message, call.span, facts=(f"inputs: {', '.join(inputs)}",))
        return fine and not missing
