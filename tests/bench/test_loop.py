"""The compiled loop against a hand-written C loop of the same model: the same trajectory, in at most 1.5 times the
time.

Both are timed in turns, round by round.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import pytest

from dwmr import Known, find, read
from dwmr.core.jit import COMPILED
from dwmr.plant.disturbances import DISTURBANCE
from dwmr.plant.robot import EDGE, ROBOT
from dwmr.simulation import simulate
from dwmr.simulation.periods import Periods

SOURCE = Path(__file__).with_name("formation.c")
FLAGS = ["-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math", "-shared", "-fPIC"]
#: The bar: time of the compiled loop over that of the C loop.
MOST = 1.5
ROUNDS = 7
#: Params of rules/aifqsmc.fz as they are declared, and those that the C loop takes.
PARAMS = (
    *("lambda_1", "lambda_2", "lambda_3", "p_v", "p_omega", "gamma_v", "gamma_omega", "epsilon_v", "epsilon_omega"),
    *("k_h_min", "k_h_min_v", "k_h_min_omega", "k_s", "k_s_v", "k_s_omega", "immunity", "layer", "adaptation"),
)
GAINS = (
    *("lambda_1", "lambda_2", "lambda_3", "p_v", "k_s_v", "k_h_min_v", "gamma_v", "epsilon_v"),
    *("p_omega", "k_s_omega", "k_h_min_omega", "gamma_omega", "epsilon_omega"),
)

pytestmark = [
    pytest.mark.skipif(not COMPILED, reason="needs numba: in plain Python there is nothing to compare"),
    pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc to compile the C loop"),
]


def struct(name: str, record: np.dtype[Any]) -> str:
    """Return the C type of a numpy record."""
    kinds = {"f": "double", "i": "int64_t"}
    fields = "".join(f" {kinds[record[field].kind]} {field};" for field in record.names or ())
    return f"typedef struct {{{fields} }} {name};\n"


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """The C loop, compiled for this machine."""
    folder = tmp_path_factory.mktemp("c")
    header = struct("robot", ROBOT) + struct("edge", EDGE) + struct("disturbance", DISTURBANCE)
    (folder / "records.h").write_text("#include <stdint.h>\n" + header, encoding="utf-8")
    built = folder / "formation.so"
    subprocess.run(["gcc", *FLAGS, f"-I{folder}", str(SOURCE), "-o", str(built), "-lm"], check=True)
    return ctypes.CDLL(str(built))


@pytest.fixture(scope="module")
def simulation() -> simulate.Simulation:
    """The paper's scenario under AIFQSMC."""
    prepared: list[simulate.Simulation] = []
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(simulate, "run", prepared.append)
        simulate.simulate(read(find("paper")), "aifqsmc", known=Known(proved=True))
    return prepared[0]


def c_loop(library: ctypes.CDLL, simulation: simulate.Simulation) -> tuple[np.ndarray, np.ndarray, float]:
    """Run the C loop; return its records as a trajectory has them, and the time it took [s]."""
    periods = Periods(simulation)
    world, memory, samples, n = periods.world, periods.memory, len(periods.record), len(simulation.laws)
    load, avoidance = np.array(world.load), np.array(world.avoidance)
    obstacles = np.array([(one.x, one.y, one.radius) for one in simulation.scenario.obstacles])
    record, law_record = np.zeros((samples, n, 20)), np.zeros((samples, n, 14))

    # The params of the law's text, in the order of the C loop, which has the law by hand.
    tail = dict(zip(PARAMS, np.array(memory.law)[:, -len(PARAMS) :].T, strict=True))
    gains = np.ascontiguousarray(np.column_stack([tail[name] for name in GAINS]))
    law = np.column_stack([np.zeros((n, 2)), tail["k_h_min_v"], tail["k_h_min_omega"], np.zeros(n)])

    def address(array: np.ndarray) -> ctypes.c_void_p:
        assert array.flags.c_contiguous
        return ctypes.c_void_p(array.ctypes.data)

    began = perf_counter()
    failed = library.run(
        samples, ctypes.c_double(world.dt), world.substeps, address(world.shapes[0]), n, address(world.robots),
        address(world.edges), world.acting.shape[1], address(world.acting), address(load), len(obstacles),
        address(obstacles),
        address(avoidance), address(gains), address(memory.plant), address(memory.theta_star),
        address(memory.filters), address(memory.sides), address(law), address(np.zeros_like(law)),
        address(memory.torques), address(record), address(law_record),
    )  # fmt: skip
    took = perf_counter() - began
    assert failed == 0
    return record, law_record, took


def test_both_loops_give_the_same_trajectory(library: ctypes.CDLL, simulation: simulate.Simulation) -> None:
    record, law_record, _ = c_loop(library, simulation)
    trajectory = simulate.run(simulation)
    early = trajectory.t <= 150.0
    for ours, by_hand in ((trajectory.values, record), (trajectory.law_values, law_record)):
        largest = np.abs(by_hand[early]).max(axis=(0, 1))  # torques are some tens of newton metres, errors centimetres
        assert (np.abs(ours - by_hand)[early].max(axis=(0, 1)) <= 1e-6 * np.maximum(largest, 1.0)).all()
    # the way around the third obstacle, at 172 s, makes millimetres of what were last bits
    apart = np.abs(trajectory.values - record)[:, :, :3]
    assert apart[trajectory.t <= 150.0].max() < 1e-6
    assert apart.max() < 0.05


def test_the_compiled_loop_takes_at_most_half_as_long_again(
    library: ctypes.CDLL, simulation: simulate.Simulation
) -> None:
    simulate.run(simulation)
    ratios = []
    for _ in range(ROUNDS):  # side by side, so that what slows the machine down slows both
        by_hand = c_loop(library, simulation)[2]
        ratios.append(simulate.run(simulation).wall_s / by_hand)
    assert sorted(ratios)[ROUNDS // 2] < MOST, [round(r, 2) for r in ratios]
