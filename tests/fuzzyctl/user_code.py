"""What a user writes under mypy --strict: the lines that are wrong say so, and mypy reports a line that is not."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

import fuzzyctl

Array = npt.NDArray[np.float64]

system = fuzzyctl.load("rules/tipper.fz")
kernel = fuzzyctl.compile(system, "python")


def one_output() -> float:
    tip: float = system(service=7, food=8.5)
    tip = system(service=np.float64(7), food=np.float32(1)) + 1
    tip = max(kernel(7, 8.5), 0.0)
    label: str = system(service=7, food=8)  # type: ignore[assignment]
    print(label, kernel(7, 8).dtype, tip)  # type: ignore[attr-defined]
    return kernel(food=7, service=8)


def several_outputs(names: list[str]) -> tuple[float, float]:
    left, right = kernel(1.0, 2.0)
    by_position: float = kernel(1.0, 2.0)[1]
    by_name: float = system(e=1.0)["left"]
    kernel(1.0)["left"]  # type: ignore[call-overload]
    system(e=1.0)[0]  # type: ignore[index]
    values: dict[str, float] = dict(system(e=1.0))
    total = sum(values[n] for n in names) + sum(kernel(1.0, 2.0)) + by_position + by_name
    return left + right, total


def arrays(points: Array) -> Array:
    first: Array = system(service=points, food=3)
    second: Array = system(service=[1.0, 2.0], food=np.array([3.0, 4.0]))["tip"]
    third: Array = kernel.batch(points)
    kernel.batch([[1.0, 2.0], [3.0, 4.0]], parallel=False)
    kernel.batch({"food": points, "service": points}, out=third)
    number: float = kernel.batch(points)  # type: ignore[assignment]
    kernel.batch("rules.csv")  # type: ignore[arg-type]
    system(service="7", food=8)  # type: ignore[arg-type]
    system(7, 8)  # type: ignore[call-overload]
    shown: dict[str, dict[str, Array]] = kernel.degrees(points)
    gradient: Array = kernel.gradient(points) * kernel.strengths(points)
    return first + second + third + gradient + shown["food"]["good"] + number


def states() -> Array:
    state = kernel.start()
    y = kernel(1.0, state)
    state = kernel.next_state(state, y)
    step = fuzzyctl.compile(fuzzyctl.load("rules/loops/water_tank.fz", block=fuzzyctl.Controller))
    u, after = step(1.0, 2.0, step.start())
    volts: float = u
    several, last = step.run(np.zeros((4, 2)))
    plain: tuple[Array, Array] = step.batch([[1.0, 2.0]], [[0.0]])
    print(volts, several.shape, last, plain)
    return after + state


def free_numbers() -> float:
    free = fuzzyctl.compile(system, free=["food.good.peak"])
    values: Array = free.start({"food.good.peak": 8})
    free.gradient([1.0, 2.0], values, by="state")
    free.gradient([1.0, 2.0], values, by="numbers")  # type: ignore[call-overload]
    several: Array = free.batch([[1.0, 2.0]], {"food.good.peak": 8})
    return free(7.0, 8.0, {"food.good.peak": 8.5}) + float(several[0]) + free(1, 2, values)


def choices() -> None:
    fuzzyctl.compile(system, "cuda")  # type: ignore[call-overload]
    fuzzyctl.compile(system, algorithm="fast")  # type: ignore[call-overload]
    fuzzyctl.as_profile(system, "matlab")
    fuzzyctl.as_profile(system, "excel")  # type: ignore[arg-type]
    loop = fuzzyctl.load("rules/loops/water_tank.fz", block=fuzzyctl.Loop)
    run: fuzzyctl.Run = fuzzyctl.simulate(loop, backend="numba", solver="Radau", GU=2.0)
    fuzzyctl.simulate(loop, solver="euler")  # type: ignore[arg-type]
    fuzzyctl.simulate(loop, backend="numpy")  # type: ignore[arg-type]
    fuzzyctl.Experiment(loop, "numpy")  # type: ignore[arg-type]
    level: Array = run["tank.y"]
    measures: dict[str, float] = run.measures
    function: Callable[..., float] = kernel.jit
    print(level, measures, function)


def built() -> fuzzyctl.FuzzySystem:
    x = fuzzyctl.build.input_variable("x", 0, 1, {"low": fuzzyctl.build.membership("gaussian", 0, 0.2)})
    y = fuzzyctl.build.output_variable("y", 0, 1, {"a": 0, "b": "(k + 1) / 2"}, otherwise="hold", aggregation="sum")
    fuzzyctl.build.membership("gausian", 0, 1)  # type: ignore[arg-type]
    fuzzyctl.build.system("s", [x, y], ["if x is low then y is a"], conjunction="mn")  # type: ignore[arg-type]
    return fuzzyctl.build.system("s", [x, y], ["if x is low then y is a"], params={"k": 1}, conjunction="product")


def answers() -> bool:
    verdicts = fuzzyctl.prove(system)
    for verdict in verdicts:
        match verdict:
            case fuzzyctl.Refuted(witness=witness):
                print(witness.point["food"])
            case fuzzyctl.Undecided(reason=reason):
                print(reason)
    checked, diagnostics = fuzzyctl.check("rules/tipper.fz")
    print([d.message for d in diagnostics], checked.name)  # type: ignore[union-attr]
    trace: fuzzyctl.Trace = fuzzyctl.why(system, service=7, food=8)
    return trace.outputs["tip"] > fuzzyctl.output_bounds(system)["tip"].lo


def pictures(ax: Axes) -> None:
    curve: Axes = system.plot("food", at={"service": 3}, ax=ax)
    surface: Axes = fuzzyctl.plot.surface(kernel)
    panel: Axes = fuzzyctl.plot.terms(system, "food")
    panels: tuple[Axes, ...] = fuzzyctl.plot.terms(system)
    panels = fuzzyctl.plot.rules(system, service=7, food=8) + fuzzyctl.why(system, service=7, food=8).plot()
    print(curve.get_title(), surface.get_xlabel(), panel, panels)
