"""Controllers as policies, and plants or loops as environments of gymnasium."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError, ValueOutOfBoundsError
from fuzzyctl.interop.numbers import count, number, numbers, positive, span
from fuzzyctl.interop.packages import required
from fuzzyctl.kernels.compile import Backend, compile
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.plant import Plant
from fuzzyctl.model.system import FuzzySystem

if TYPE_CHECKING:
    from fuzzyctl.annotations import FloatArray, Numbers
    from fuzzyctl.interop.environments import LoopEnvironment, OpenedLoop
    from fuzzyctl.simulation.experiment import LoopBackend

#: The signals of a loop by name to a reward.
Reward = Callable[[Mapping[str, float]], float]


class Policy:
    """A system or controller as a policy: `policy(observation)` is the action.

    Args:
        block: A system without adaptive or held outputs, or a controller.
        dt: Time between two steps [s], for a controller without period.
        backend: As for `compile`.

    Attributes:
        state: Of the controller, shape (states,).

    Raises:
        ArgumentError: For another object, a system with state, and a `dt` that is missing or one too many.
        ValueOutOfBoundsError: For a `dt` that is not positive.
    """

    def __init__(
        self, block: FuzzySystem | Controller, *, dt: float | None = None, backend: Backend = "python"
    ) -> None:
        self._kernel: Any = compile(block, backend)
        self._names, self._moves = self._kernel.input_names, self._kernel.form.moves
        if self._kernel.n_states and not self._moves:
            raise ArgumentError(f"system '{block.name}' adapts or holds outputs: call it in a controller")
        if self._moves:
            dt = None if dt is None else positive("dt", dt, "s")
            if (self._kernel.period is None) == (dt is None):
                what = "has no 'every' line: give 'dt'" if dt is None else "has a period: leave 'dt' out"
                raise ArgumentError(f"controller '{block.name}' {what}")
        self._dt = dt
        self.reset()

    def reset(self) -> None:
        """Return to the state before the first step."""
        self.state: FloatArray = self._kernel.start()

    def __call__(self, observation: Numbers) -> FloatArray:
        """Make a step.

        Args:
            observation: The inputs in order, shape (inputs,).

        Returns:
            The outputs, shape (outputs,).

        Raises:
            ArgumentError: For an observation of another shape.
            ValueOutOfBoundsError: For an observation with NaN.
        """
        observed = numbers(observation)
        if observed is None or observed.shape != (len(self._names),):
            raise ArgumentError(
                f"the observation must have the shape ({len(self._names)},) for {', '.join(self._names)}, "
                f"got {observation!r}"
            )
        if np.isnan(observed).any():
            undefined = [name for name, value in zip(self._names, observed, strict=True) if np.isnan(value)]
            raise ValueOutOfBoundsError(f"observation of {', '.join(undefined)}", math.nan, "a number")
        if self._moves:
            outputs, self.state = self._kernel(*observed.tolist(), self.state, dt=self._dt)
        else:
            outputs = self._kernel(*observed.tolist())
        return np.atleast_1d(np.array(outputs))


def environment(
    system: Loop | Plant,
    block: str | None = None,
    *,
    reward: str | Reward,
    dt: float | None = None,
    duration: float | None = None,
    start: Mapping[str, tuple[float, float]] | None = None,
    actions: Mapping[str, tuple[float, float]] | None = None,
    penalty: float = 0.0,
    substeps: int = 1,
    backend: LoopBackend = "auto",
) -> LoopEnvironment:
    """Return a loop without one of its controllers, or a plant, as a `gymnasium.Env`.

    Of a loop the observations are the inputs of the controller that is taken out, references and noise included, and
    the actions its outputs, one in each of its periods; of a plant they are its outputs and inputs. The spaces have
    their ranges. An episode is truncated at the end of the run, and terminated where an observation or a state of a
    plant leaves its range; the last observation is then clipped to the space. `reset(seed=)` draws noise and starts.

    Args:
        system: The loop or plant.
        block: The block of the loop whose place the agent takes.
        reward: A function of the signals by name, as a run has them, with `t` [s], at the end of each step; or a
            measure of the loop that is an integral (`iae`, `ise`, `integral`, `effort`), whose part each step costs.
        dt: Time between two steps of a plant [s].
        duration: Length of an episode of a plant [s].
        start: Range from which `reset` draws states of plants, by name: `BLOCK.STATE` in a loop, `STATE` of a plant.
        actions: Ranges of actions where the text gives no finite ones, by name: `BLOCK.OUTPUT` in a loop, `INPUT` of a
            plant.
        penalty: The cost of a terminated episode.
        substeps: Steps of integration between two samples.
        backend: As for `Experiment`.

    Raises:
        MissingPackageError: Where gymnasium is not installed.
        ArgumentError: For another object, a block that is not a controller, a measure that is not an integral, a reward
            that is neither, a missing `dt` or `duration`, and actions without finite ranges.
        ValueOutOfBoundsError: For times and numbers of steps that are not positive, a penalty that is not a finite
            number, and ranges that are not two numbers in order.
        UnknownNameError: For a name of no block, measure, state or action.
        DiagnosticError: For a loop that cannot be run without the controller.
    """
    required("gymnasium", "gymnasium")
    if not (callable(reward) or isinstance(reward, str)):
        raise ArgumentError(f"reward must be a function of the signals or the name of a measure, got {reward!r}")
    from fuzzyctl.interop.environments import LoopEnvironment, with_action_ranges

    ends = {name: span(f"range of '{name}'", limits) for name, limits in (actions or {}).items()}
    opened = with_action_ranges(_opened(system, block, dt, duration), ends)
    starts = {name: span(f"start of '{name}'", ends) for name, ends in (start or {}).items()}
    return LoopEnvironment(opened, reward, starts, number("penalty", penalty), count("substeps", substeps), backend)


def _opened(system: Loop | Plant, block: str | None, dt: float | None, duration: float | None) -> OpenedLoop:
    """Return a loop without a controller, or a plant, with the arguments that go with it."""
    from fuzzyctl.interop.environments import opened_loop, opened_plant

    if isinstance(system, Loop):
        if block is None or dt is not None or duration is not None:
            raise ArgumentError(
                "of a loop 'block' is the controller that is taken out; 'dt' and 'duration' are its own"
            )
        return opened_loop(system, block)
    if isinstance(system, Plant):
        if block is not None or dt is None or duration is None:
            raise ArgumentError("a plant needs 'dt' and 'duration', and has no 'block'")
        return opened_plant(system, positive("dt", dt, "s"), positive("duration", duration, "s"))
    raise ArgumentError(f"expected a Loop or a Plant, got {type(system).__name__}")
