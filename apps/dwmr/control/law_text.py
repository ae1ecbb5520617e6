"""Control laws as text: a controller of a rule file, matched with the signals of the formation, and compiled."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from dwmr.control.rule_files import Used, read_whole
from fuzzyctl.analysis.check import check_examined
from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError, ValueOutOfBoundsError
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.expr import Call, Compare, Keyword, Name, Number, names_in, span_of, walk
from fuzzyctl.formats.fz_strings import guarantee_text
from fuzzyctl.kernels.free_values import require_bounds
from fuzzyctl.kernels.plan.equations import Equations, Evaluation, KeptState
from fuzzyctl.kernels.plan.expansion import equations_of, with_values
from fuzzyctl.loading.load import chosen, look_through
from fuzzyctl.model.block import Bounds, Guarantee
from fuzzyctl.model.controller import Controller, Result
from fuzzyctl.model.stateful_operators import OPERATORS
from fuzzyctl.support.files import read_source

if TYPE_CHECKING:
    from dwmr.core.arrays import FloatArray
    from fuzzyctl.analysis.verdicts import Verdict
    from fuzzyctl.kernels.kernel import Kernel
    from fuzzyctl.model.system import FuzzySystem

#: Inputs from the formation and their units: the fields of `TrackingError`, in their order.
OFFERED = {
    "x_e": "m",
    "y_e": "m",
    "theta_e_star": "rad",
    "drift_x": "m/s",
    "drift_y": "m/s",
    "drift_theta": "rad/s",
    "d": "m",
    "theta_e": "rad",
    "v_r": "m/s",
    "omega_r": "rad/s",
    "v": "m/s",
    "omega": "rad/s",
    "t": "s",
}
#: The outputs that a law must have; all others are recorded.
COMMANDS = {"v_c": "m/s", "omega_c": "rad/s"}
#: An output of laws of robots that move sideways: the commanded velocity to the left [m/s].
LATERAL = "v_y_c"
#: An output of laws with an immune reaction: the switching gain G_AIS, alone or of a channel.
GAIN = "g_ais"
#: Names of other columns of the data, which no output of a law may have: of every robot, of the row.
COLUMNS = (
    *("x", "y", "theta", "v", "omega", "x_r", "y_r", "theta_r", "v_r", "theta_r_star", "x_e", "y_e"),
    *("steering", "v_y", "torque_right", "torque_left", "d_v", "d_omega", "obstacle", "avoidance_radius"),
    *("t", "controller", "robot"),
)

#: Values of gains that are remembered: robots have mostly the same.
_MOST_VALUES = 100
#: Time of a proof for all values of the gains, as a part of that for the values of one robot, which may still succeed.
_FOR_ALL = 0.1


class LawText(NamedTuple):
    """A control law as its file has it.

    Attributes:
        path: The file.
        controller: The controller in it.
        used: Checksums of all that it reads.
        warnings: Those of its checks.
    """

    path: Path
    controller: Controller
    used: Used
    warnings: tuple[Diagnostic, ...]

    @property
    def recorded(self) -> tuple[Result, ...]:
        """The outputs that are recorded."""
        return tuple(r for r in self.controller.results if r.name not in COMMANDS)


class Assembled:
    """A control law with its systems; values that do not depend on gains are computed once."""

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        #: Params on which no system, start, range or period depends.
        self.varying = varying(controller)
        self._verdicts: dict[tuple[float, ...], tuple[Verdict, ...]] = {}
        self._called: dict[tuple[float, ...], tuple[FuzzySystem, ...]] = {}
        self._starts: dict[tuple[float, ...], FloatArray] = {}
        self._values: dict[tuple[tuple[str, float], ...], tuple[Mapping[str, float], Mapping[str, str]]] = {}
        self._adaptive: dict[tuple[float, ...], tuple[int, ...]] = {}
        self._step: Kernel | None = None

    def values(self, gains: Mapping[str, float]) -> tuple[Mapping[str, float], Mapping[str, str]]:
        """Return the values of all params with some gains, and the mistakes by name."""
        key = tuple(gains.items())
        if key not in self._values:
            if len(self._values) > _MOST_VALUES:
                self._values.clear()
            valued = with_values(self.controller, gains)
            self._values[key] = valued.param_values.values, dict(_out_of_bounds(valued))
        return self._values[key]

    def _fixed(self, values: Mapping[str, float]) -> tuple[float, ...]:
        """Return the values of the other params."""
        return tuple(values[p.name] for p in self.controller.params if p.name not in self.varying)

    def called(self, values: Mapping[str, float]) -> tuple[FuzzySystem, ...]:
        """Return the systems that the law calls, each with its params, with some values of all params of the law."""
        key = tuple(values.values())
        if key not in self._called:
            body = equations_of(with_values(self.controller, values)).body
            systems = {(s.path, *s.values.items()): s for s in (i.system for i in body if isinstance(i, Evaluation))}
            self._called[key] = tuple(systems.values())
        return self._called[key]

    def proved(self, values: Mapping[str, float]) -> tuple[Verdict, ...]:
        """Return a verdict on each claim with some values of all params.

        It is proved for all values of the varying ones at once, and where that fails, for these.
        """
        from fuzzyctl.analysis.induction.prover import verdicts  # not needed by the workers of a sweep
        from fuzzyctl.analysis.prove import TIMEOUT
        from fuzzyctl.analysis.verdicts import Proved

        fixed, whole = self._fixed(values), (*self._fixed(values), *values.values())
        if fixed not in self._verdicts:
            timeout = _FOR_ALL * TIMEOUT
            self._verdicts[fixed] = verdicts(with_values(self.controller, values), timeout, free=self.varying)
        if all(isinstance(v, Proved) for v in self._verdicts[fixed]):
            return self._verdicts[fixed]
        if whole not in self._verdicts:
            self._verdicts[whole] = verdicts(with_values(self.controller, values), TIMEOUT)
        return self._verdicts[whole]

    def step(self, backend: str) -> Kernel:
        """Return the compiled step: one for all values of the params; see `compiled`."""
        if self._step is None:
            self._step = compiled(self.controller, backend)
        return self._step

    def start(self, values: Mapping[str, float]) -> FloatArray:
        """Return the state before the first step with some values of all params, shape (states,)."""
        assert self._step is not None, "it is compiled before"
        fixed, names = self._fixed(values), self._step.free_names
        if fixed not in self._starts:
            self._starts[fixed] = self._step.start({name: values[name] for name in names})
        state = self._starts[fixed].copy()
        state[len(state) - len(names) :] = [values[name] for name in names]
        return state

    def adaptive(self, values: Mapping[str, float]) -> tuple[int, ...]:
        """Return the numbers of the states that are adaptive gains, with some values of all params.

        An adaptive gain starts at its floor: the positive lower end of a range without an upper end.
        """
        fixed = self._fixed(values)
        if fixed not in self._adaptive:
            states = equations_of(with_values(self.controller, values)).states
            self._adaptive[fixed] = tuple(k for k, state in enumerate(states) if _is_adaptive(state))
        return self._adaptive[fixed]


def _is_adaptive(state: KeptState) -> bool:
    match state.bounds:
        case Bounds(lower=Number(value=lower), upper=Number(value=upper)):
            return 0.0 < lower == state.start and upper == math.inf
    return False


def read(path: Path, opened: Mapping[Path, tuple[FuzzySystem, ...]]) -> LawText:
    """Read a control law: the controller that is called as its file, or the only one in it.

    Args:
        path: Its file.
        opened: Systems of files that have been read already.

    Raises:
        DiagnosticError: When the file has mistakes, or its controller does not fit the formation.
    """
    examined = look_through(read_source(path), folder=path.parent, opened=dict(opened))
    remarks = check_examined(examined, guarantees=False)[1]
    errors = [d for d in remarks if d.severity == "error"]
    if errors:
        raise DiagnosticError(errors)
    name = path.stem if path.stem in {c.name for c in examined.controllers} else None
    controller = chosen(examined, name, Controller)
    mistakes = list(_misfits(controller))
    if mistakes:
        raise DiagnosticError(mistakes)
    warnings = tuple(d for d in remarks if d.severity == "warning")
    return LawText(path, _with_positive_gains(controller), read_whole(path), warnings)


def _with_positive_gains(controller: Controller) -> Controller:
    """Add the claims that G_AIS, and β of the same channel, are positive, if the text of a law lacks them."""
    results, texts = {r.name: r for r in controller.results}, {guarantee_text(g) for g in controller.guarantees}
    channels = [name.removeprefix(GAIN) for name in results if f"{name}_".startswith(f"{GAIN}_")]
    names = [f"{part}{channel}" for channel in channels for part in (GAIN, "beta") if f"{part}{channel}" in results]
    claims = (Guarantee(claim=Compare(">", Name(n), Number(0.0)), span=results[n].span) for n in names)
    added = tuple(claim for claim in claims if guarantee_text(claim) not in texts)
    return replace(controller, guarantees=(*controller.guarantees, *added))


def _misfits(controller: Controller) -> Iterator[Diagnostic]:
    """Yield the reasons why a controller cannot be a control law of the formation."""
    offered = f"the formation offers {', '.join(f'{name} [{unit}]' for name, unit in OFFERED.items())}"
    for signal in controller.inputs:
        if signal.name not in OFFERED:
            message, hint = f"input '{signal.name}' is not a signal of the formation", tuple(OFFERED)
            yield Diagnostic("FZ905", message, signal.span, facts=(offered,), help=did_you_mean(signal.name, hint))
    for result in controller.results:
        if result.name in COLUMNS:
            yield taken_name(f"output '{result.name}'", result.name, span=result.span)
    for name in [name for name in COMMANDS if name not in {r.name for r in controller.results}]:
        message = f"controller '{controller.name}' has no output '{name}'"
        facts = (f"a control law has the outputs {', '.join(f'{n} [{u}]' for n, u in COMMANDS.items())}",)
        yield Diagnostic("FZ905", message, controller.span, facts=facts)
    for kind, verb, signals, units in (
        ("input", "gives", controller.inputs, OFFERED),
        ("output", "takes", controller.results, {**COMMANDS, LATERAL: "m/s"}),
    ):
        for one in signals:
            if one.unit not in ("", unit := units.get(one.name, one.unit)):
                message = f"{kind} '{one.name}' has the unit {one.unit}, and the formation {verb} {unit}"
                yield Diagnostic("FZ905", message, one.span, help=f'write: unit "{unit}"')


def taken_name(subject: str, name: str, **place: Any) -> Diagnostic:
    """Describe a signal that has the name of another column of the data."""
    facts = (f"names of these are {', '.join(COLUMNS)}",)
    message = f"{subject} has the name of another column of the data"
    return Diagnostic("FZ905", message, facts=facts, help=f"rename it, as to {name}_law", **place)


def require_period(controller: Controller, dt: float) -> None:
    """Refuse a law whose sample time is not the control period of the run.

    Args:
        controller: The law.
        dt: Control period [s].

    Raises:
        DiagnosticError: At its `every` line.
    """
    if controller.period is None or controller.number(controller.period) == dt:
        return
    sample_time = controller.number(controller.period)
    message = f"the law runs every {sample_time:g} s, and the control period run.dt is {dt:g} s"
    help_text = "leave out 'every', so that run.dt is the sample time"
    raise DiagnosticError([Diagnostic("FZ905", message, span_of(controller.period), help=help_text)])


def systems_of(controller: Controller) -> dict[str, FuzzySystem]:
    """Return the systems that a controller and those inside it call, by name."""
    systems = {s.name: s for s in controller.systems}
    for inner in controller.controllers:
        systems |= systems_of(inner)
    return systems


def with_systems(controller: Controller, systems: Mapping[str, FuzzySystem]) -> Controller:
    """Return a controller that calls other systems in place of those with the same names."""
    return replace(
        controller,
        systems=tuple(systems.get(s.name, s) for s in controller.systems),
        controllers=tuple(with_systems(c, systems) for c in controller.controllers),
    )


def used_as_called(law: LawText, roles: Mapping[str, Used]) -> Used:
    """Return the files that a law reads if files of roles replace those that it names.

    Args:
        law: The law.
        roles: Files of the replacing systems, by name.
    """
    paths = {name: Path(system.path) for name, system in systems_of(law.controller).items()}
    changed = {role: used for role, used in roles.items() if paths[role].resolve() != used.path.resolve()}
    others = {path for name, path in paths.items() if name not in changed}
    return read_whole(law.path, {paths[role] for role in changed} - others, changed) if changed else law.used


def _out_of_bounds(controller: Controller) -> Iterator[tuple[str, str]]:
    """Yield the names of params without a value or out of bounds, and the mistake of each."""
    params = controller.param_values
    yield from ((name, f"has no value: {params.errors[0]}") for name in sorted(params.failed))
    for param in controller.params:
        if param.bounds is not None and param.name in params.values:
            try:
                require_bounds(param.name, params.values[param.name], param.bounds, params.values, param.unit)
            except ValueOutOfBoundsError as error:
                unit = f" {param.unit}" if param.unit else ""
                yield param.name, f"must be {error.bound}{unit}, got {params.values[param.name]:g}"


def varying(controller: Controller) -> tuple[str, ...]:
    """Return the params on which no system, start, range or period depends."""
    names, params = _known(controller), {p.name: p for p in controller.params}
    waiting = [name for name in names if name in params]
    while waiting:
        for name in names_in(params[waiting.pop()].expression):
            if name.name in params and name.name not in names:
                names.add(name.name)
                waiting.append(name.name)
    return tuple(name for name in params if name not in names)


def _known(controller: Controller) -> set[str]:
    """Return the names in what must be known before a controller is expanded."""
    ranges = [s.bounds for s in (*controller.states, *controller.results) if s.bounds is not None]
    parts = [*(s.start for s in controller.states), *(e for b in ranges for e in (b.lower, b.upper))]
    parts += [e for e in (controller.period, *(g.within for g in controller.guarantees)) if e is not None]
    values = [d.value for d in (*controller.definitions, *controller.updates)] + [r.value for r in controller.results]
    calls = [
        e for v in (*values, *(f.expression for f in controller.functions)) for e in walk(v) if isinstance(e, Call)
    ]
    for call in calls:  # params of systems, settings of operators
        parts += [a.value for a in call.arguments if isinstance(a, Keyword)]
        parts += call.arguments[1:] if call.function in OPERATORS else ()
    inner = {c.name: {p for p in (x.name for x in c.params) if p not in varying(c)} for c in controller.controllers}
    for instance in controller.instances:
        named = [a for a in instance.arguments if isinstance(a, Keyword)]
        parts += [a.value for a in named if a.name in inner[instance.controller]]
    return {n.name for e in parts for n in names_in(e)}


def compiled(controller: Controller, backend: str) -> Kernel:
    """Compile a control law to a step that takes `OFFERED` and dt, and gives `COMMANDS` first.

    Its params are states, so that one machine code serves all gains.

    Args:
        controller: The law, called with the systems it shall have.
        backend: "numba" or "python".
    """
    from fuzzyctl.kernels.kernel import Kernel
    from fuzzyctl.kernels.step_form import StepForm, StepValues

    equations = _with_free_params(controller)
    outputs = sorted(equations.outputs, key=lambda one: list(COMMANDS).index(one[0]) if one[0] in COMMANDS else 2)
    changed = replace(equations, inputs=tuple(OFFERED), outputs=tuple(outputs), period=None)
    if not equations.states:
        changed = replace(changed, states=(KeptState("none", 0.0),), updates=(Name("none"),))
    values = StepValues(controller, equations) if equations.free else None
    return Kernel(StepForm(changed, values=values), backend)


def _with_free_params(controller: Controller) -> Equations:
    """Expand a law with all params free but for those that must be known beforehand, such as samples of a delay."""
    names = [p.name for p in controller.params]
    try:
        return equations_of(controller, names)
    except ArgumentError:
        return equations_of(controller, [name for name in names if _can_be_free(controller, name)])


def _can_be_free(controller: Controller, name: str) -> bool:
    try:
        equations_of(controller, [name])
    except ArgumentError:
        return False
    return True
