"""Open loops as environments of gymnasium."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import gymnasium
import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Call, Expr, Keyword, Name, Number, evaluate, replace_names
from fuzzyctl.interop.numbers import number, numbers
from fuzzyctl.model.block import Param
from fuzzyctl.model.controller import Controller, Definition, Instance
from fuzzyctl.model.forms import bound
from fuzzyctl.model.loop import MEASURES, Loop
from fuzzyctl.model.plant import Plant
from fuzzyctl.simulation.experiment import Experiment, LoopBackend, Stepper
from fuzzyctl.simulation.loop_params import block_params
from fuzzyctl.simulation.measures import measured
from fuzzyctl.simulation.sample_times import sample_times


@dataclass(frozen=True)
class OpenedLoop:
    """A loop that is open at a controller.

    Args:
        loop: It has a param for each output of the controller, and a signal for each of its inputs.
        actions: The params.
        action_ranges: Their ends.
        observations: Names of the signals.
        observation_ranges: Their ends.
        shown: Names that a run has for the actions and observations, `BLOCK.SIGNAL`.
        every: Samples in each period of the controller.
        prefix: The prefix of the names of states in the loop, but not for the user.
    """

    loop: Loop
    actions: tuple[str, ...]
    action_ranges: tuple[tuple[float, float], ...]
    observations: tuple[str, ...]
    observation_ranges: tuple[tuple[float, float], ...]
    shown: Mapping[str, str]
    every: int = 1
    prefix: str = ""


def opened_loop(loop: Loop, block: str) -> OpenedLoop:
    """Take a controller out of a loop.

    Args:
        loop: The loop.
        block: Name of its block.

    Raises:
        UnknownNameError: For a name of no block.
        ArgumentError: For a block that is a plant.
        DiagnosticError: For sample times that do not fit together.
    """
    instance = next((i for i in loop.instances if i.name == block), None)
    if instance is None:
        raise UnknownNameError("block", block, tuple(i.name for i in loop.instances))
    controller = next((c for c in loop.controllers if c.name == instance.controller), None)
    if controller is None:
        raise ArgumentError(f"block '{block}' is a plant: an agent takes the place of a controller")
    step, every = sample_times(loop)
    names = {p.name for p in loop.params} | {d.name for d in loop.signals} | {i.name for i in loop.instances}
    actions = _fresh(block, [r.name for r in controller.results], names)
    observations = _fresh(block, [s.name for s in controller.inputs], names | set(actions))
    values: dict[str, Expr] = {
        f"{block}.{r.name}": Name(action) for r, action in zip(controller.results, actions, strict=True)
    }
    inputs = _inputs(instance, controller)
    seen = tuple(Definition(name=n, value=e) for n, e in zip(observations, inputs, strict=True))
    set_params = dataclasses.replace(controller, params=tuple(
        dataclasses.replace(p, expression=Number(v))
        for p, v in zip(controller.params, block_params(loop, instance).values(), strict=True)
    ))  # fmt: skip
    others = tuple(i for i in loop.instances if i is not instance)
    changed = dataclasses.replace(
        loop,
        params=(*loop.params, *(Param(name=n, expression=Number(0.0)) for n in actions)),
        instances=tuple(
            dataclasses.replace(i, arguments=tuple(replace_names(a, values) for a in i.arguments)) for i in others
        ),
        definitions=tuple(
            dataclasses.replace(d, value=replace_names(d.value, values)) for d in (*loop.definitions, *seen)
        ),
        measures=tuple(dataclasses.replace(m, value=replace_names(m.value, values)) for m in loop.measures),
        controllers=tuple(c for c in loop.controllers if c.name in {i.controller for i in others}),
        step=Number(step),
        varied=(),
        guarantees=(),
    )
    return OpenedLoop(
        changed,
        actions,
        tuple(set_params.range_of(r) for r in controller.results),
        observations,
        tuple(set_params.range_of(s) for s in controller.inputs),
        dict(
            zip(
                (*actions, *observations),
                (f"{block}.{s.name}" for s in (*controller.results, *controller.inputs)),
                strict=True,
            )
        ),
        every[block],
    )


def opened_plant(plant: Plant, dt: float, duration: float) -> OpenedLoop:
    """Return a plant alone, its inputs open.

    Args:
        plant: The plant.
        dt: Sample time [s].
        duration: Length of a run [s].

    Raises:
        ValueOutOfBoundsError: For a duration of less than `dt`.
    """
    if duration < dt:
        raise ValueOutOfBoundsError("duration", duration, f">= dt = {dt:g}", "s")
    block = "plant"
    actions = _fresh(block, [s.name for s in plant.inputs], set())
    loop = Loop(
        name=plant.name, params=tuple(Param(name=n, expression=Number(0.0)) for n in actions),
        instances=(Instance(name=block, controller=plant.name, arguments=tuple(map(Name, actions)), span=plant.span),),
        duration=Number(float(duration)), step=Number(float(dt)), plants=(plant,), path=plant.path, span=plant.span,
    )  # fmt: skip
    return OpenedLoop(
        loop,
        actions,
        tuple(plant.range_of(s) for s in plant.inputs),
        tuple(f"{block}.{r.name}" for r in plant.results),
        tuple(plant.range_of(r) for r in plant.results),
        dict(zip(actions, (f"{block}.{s.name}" for s in plant.inputs), strict=True)),
        prefix=f"{block}.",
    )


def with_action_ranges(opened: OpenedLoop, limits: Mapping[str, tuple[float, float]]) -> OpenedLoop:
    """Return an open loop whose actions have finite ranges, as agents draw them from these.

    Args:
        opened: The loop.
        limits: Ranges by the names that the user has for the actions; the others are those of the text.

    Raises:
        UnknownNameError: For a name of no action.
        ArgumentError: For actions without a finite range.
    """
    names = [opened.shown[a].removeprefix(opened.prefix) for a in opened.actions]
    for name in limits:
        if name not in names:
            raise UnknownNameError("action", name, names)
    ranges = tuple(limits.get(n, ends) for n, ends in zip(names, opened.action_ranges, strict=True))
    without = [n for n, ends in zip(names, ranges, strict=True) if not all(map(math.isfinite, ends))]
    if without:
        what = "inputs of the plant" if opened.prefix else "outputs of the controller"
        raise ArgumentError(
            f"agents draw actions from finite ranges, which the {what} do not have: {', '.join(without)}; declare them "
            f'in the text, or give them, as actions={{"{without[0]}": (-10, 10)}}'
        )
    return dataclasses.replace(opened, action_ranges=ranges)


def _fresh(block: str, names: Sequence[str], others: set[str]) -> tuple[str, ...]:
    """Return names `BLOCK_NAME` that the loop does not have."""
    fresh = []
    for name in names:
        new = f"{block}_{name}"
        while new in others:
            new += "_"
        fresh.append(new)
        others = others | {new}
    return tuple(fresh)


def _inputs(instance: Instance, controller: Controller) -> list[Expr]:
    """Return the connections of the inputs of a block, in order."""
    positional = [a for a in instance.arguments if not isinstance(a, Keyword)]
    named = {a.name: a.value for a in instance.arguments if isinstance(a, Keyword)}
    names = [s.name for s in controller.inputs]
    by_name = dict(zip(names, positional, strict=False)) | named
    return [by_name[name] for name in names]


#: Measures that are sums over the steps.
INTEGRALS: Final = ("iae", "ise", "integral", "effort")


class LoopEnvironment(gymnasium.Env[Any, Any]):  # type: ignore[misc]  # gymnasium has no types here
    """An open loop; `environment` makes it.

    Args:
        opened: The loop.
        reward: A function of the signals, or the name of a measure.
        start: Ranges of states at the begin.
        penalty: The cost of a terminated episode.
        substeps: Steps of integration between two samples.
        backend: As for `Experiment`.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - gymnasium declares it so

    def __init__(
        self,
        opened: OpenedLoop,
        reward: str | Callable[[Mapping[str, float]], float],
        start: Mapping[str, tuple[float, float]],
        penalty: float,
        substeps: int,
        backend: LoopBackend,
    ) -> None:
        self.opened, self._penalty, self._substeps = opened, penalty, substeps
        self.experiment = Experiment(opened.loop, backend, free=opened.actions)
        self.action_space = _box(opened.action_ranges)
        self.observation_space = _box(opened.observation_ranges)
        states = {s.name for s in self.experiment.equations.plant_states}
        self._start = {f"{opened.prefix}{name}": ends for name, ends in start.items()}
        for name in start:
            if f"{opened.prefix}{name}" not in states:
                raise UnknownNameError("state", name, [s.removeprefix(opened.prefix) for s in states])
        self._cost = None if callable(reward) else self._integral(reward)
        self._reward = reward if callable(reward) else None
        self._columns = [self.experiment.positions[name] for name in opened.observations]
        self._stepper: Stepper | None = None
        self._ended = False

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; noise and starts are drawn anew.

        Args:
            seed: Of the draws; None goes on with those before.
            options: None, or `{"start": {STATE: VALUE}}`, states that are not drawn.

        Returns:
            The observation and the signals by name.

        Raises:
            UnknownNameError: For a name of no state, and another option than `start`.
            ArgumentError: For a `start` that is not a mapping, and where the run cannot begin at these states.
            ValueOutOfBoundsError: For a state that is not a finite number.
        """
        for name in options or {}:
            if name != "start":
                raise UnknownNameError("option", name, ("start",))
        super().reset(seed=seed)
        begin = {name: float(self.np_random.uniform(*ends)) for name, ends in self._start.items()}
        start = (options or {}).get("start", {})
        if not isinstance(start, Mapping):
            raise ArgumentError(f"the option 'start' must be values by the names of states, got {start!r}")
        begin |= {f"{self.opened.prefix}{name}": number(f"start of '{name}'", value) for name, value in start.items()}
        noise = int(self.np_random.integers(2**32))
        self._stepper = Stepper(self.experiment, self._substeps, noise, begin)
        row = self._stepper.look(np.zeros(len(self.opened.actions)))
        if isinstance(row, Diagnostic):
            raise ArgumentError(f"the episode cannot begin: {row.message}")
        self._last, self._ended = row, False
        return self._observed(row), self._signals(row, np.zeros(len(self.opened.actions)))

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Hold an action for a period.

        Args:
            action: Shape (outputs of the controller,).

        Returns:
            Observation, reward, whether a range was left, whether the run ended, and the signals by name; `stopped`
            says why it was terminated.

        Raises:
            ArgumentError: For an action of another shape or not finite, before the first `reset`, and after the end of
                an episode.
            ValueOutOfBoundsError: For a reward that is not a finite number.
        """
        if self._stepper is None or self._ended:
            raise ArgumentError("'reset' begins an episode" + (": this one has ended" if self._ended else ""))
        values = numbers(action)
        if values is None or values.shape != self.action_space.shape or not np.isfinite(values).all():
            names = ", ".join(self.opened.shown[a] for a in self.opened.actions)
            expected = counted(self.action_space.shape[0], "finite number")
            raise ArgumentError(f"the action must be {expected} ({names}), got {action!r}")
        stepper, last, total = self._stepper, self.experiment.samples - 1, 0.0
        row: Any = None
        for _ in range(self.opened.every):
            before = stepper.advance(values)
            row = before if isinstance(before, Diagnostic) else stepper.look(values)
            if isinstance(row, Diagnostic):
                previous = self._last if isinstance(before, Diagnostic) else before
                return self._stopped(previous, row, total, values)
            self._last = row
            total -= 0.0 if self._cost is None else self._cost(before, row)
            if stepper.sample >= last:
                break
        signals = self._signals(row, values)
        total = total if self._reward is None else number("the reward", self._reward(signals))
        observation = self._observed(row)
        outside = [n for n, value, low, high in self._ranged(row) if not low <= value <= high]
        if outside:
            signals["stopped"] = f"{', '.join(outside)} left the range at t = {signals['t']:.6g} s"
            total -= self._penalty
        truncated = stepper.sample >= last
        self._ended = bool(outside) or truncated
        return observation, total, bool(outside), truncated, signals

    def _stopped(
        self, row: Any, why: Diagnostic, total: float, values: Any
    ) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Return the result of a step at whose end a state leaves its range."""
        self._ended = True
        signals = self._signals(row, values)
        reward = total if self._reward is None else number("the reward", self._reward(signals))
        return self._observed(row), reward - self._penalty, True, False, signals | {"stopped": why.message}

    def _ranged(self, row: Any) -> list[tuple[str, float, float, float]]:
        values = [float(row[k]) for k in self._columns]
        ends = self.opened.observation_ranges
        return [(n, v, *e) for n, v, e in zip(self.opened.observations, values, ends, strict=True)]

    def _observed(self, row: Any) -> Any:
        return np.clip(row[self._columns], self.observation_space.low, self.observation_space.high)

    def _signals(self, row: Any, values: Any) -> dict[str, Any]:
        """Return the signals by the names that a run has for them."""
        assert self._stepper is not None
        positions, labels = self.experiment.positions, self.opened.shown
        signals = {labels.get(n, n): float(row[k]) for n, k in positions.items() if not n.startswith("#")}
        actions = {labels[a]: float(value) for a, value in zip(self.opened.actions, values, strict=True)}
        return {"t": self._stepper.sample * self.experiment.step, **signals, **actions}

    def _integral(self, name: str) -> Callable[[Any, Any], float]:
        """Return the part of a measure of a step between two samples."""
        loop = self.opened.loop
        measures = {m.name: m.value for m in loop.measures}
        if name not in measures:
            raise UnknownNameError("measure", name, tuple(measures))
        call = measures[name]
        if not (isinstance(call, Call) and call.function in INTEGRALS):
            raise ArgumentError(
                f"measure '{name}' is not a sum over the steps: a reward is a function of the signals, or one of the "
                f"measures {', '.join(INTEGRALS)} alone"
            )
        form = MEASURES[call.function]
        arguments = bound(form, call)
        params = loop.param_values.values
        settings = {n: evaluate(arguments[n], params) for n in form.settings}
        columns = [self._column(arguments[n]) for n in form.signals]
        whole = {**settings, "begin": 0.0, "end": np.inf}
        begin, end = settings.get("begin", 0.0), settings.get("end", np.inf)
        step = self.experiment.step

        def cost(before: Any, after: Any) -> float:
            assert self._stepper is not None
            t = (self._stepper.sample - 1) * step
            if not (begin <= t + 0.5 * step <= end):
                return 0.0
            signals = tuple(np.array([before[k], after[k]]) for k in columns)
            return measured(call.function, np.array([t, t + step]), signals, whole)

        return cost

    def _column(self, expr: Expr) -> int:
        """Return where the record has a signal that a measure takes."""
        extra = self.experiment.judgement.signals
        if expr in extra:
            return self.experiment.positions[f"#{extra.index(expr)}"]
        assert isinstance(expr, Name)
        return self.experiment.positions[expr.name]


def _box(ranges: tuple[tuple[float, float], ...]) -> Any:
    low, high = (np.array([ends[k] for ends in ranges]) for k in (0, 1))
    return gymnasium.spaces.Box(low, high, dtype=np.float64)
