"""Sets of loops whose controllers compute in fixed point hold runs with rounded inputs and outputs that are off."""

from dataclasses import replace

import numpy as np
import pytest

from fuzzyctl import compile, loads
from fuzzyctl.analysis.reach.prover import LoopProver
from fuzzyctl.codegen.files import chip_of
from fuzzyctl.testing import run_command

LOOP = """
controller law
input x in [-2, 2]
input v in [-2, 2]
state s in [-1, 1] = 0
next s = clamp(0.5 * s + 0.25 * x + 0.03 * previous(u), -1, 1)
output u in [-8, 7] = clamp(-2 * x - 1.5 * v - 0.5 * s, -7, 7)
every 50 ms
plant mass
input u
state x = 0
state v = 0
der x = v
der v = u
output px = x
output pv = v
loop l
block law = law(mass.px{}, mass.pv)
block mass = mass(law.u)
for mass.x in [-0.1, 0.1]
for mass.v in [-0.1, 0.1]
run 3 s
"""


def loop_of(*lines, noise=""):
    return loads(LOOP.format(noise) + "".join(f"{line}\n" for line in lines), block="l")


def samples(prover, count):
    """Return ends of the plant's states at some samples, shape (samples, states, 2)."""
    sets = prover.sets([], 3.0)
    low, high = (e[None] for e in prover._family())
    plant, memory, free = prover._begin(sets, low, high)
    results = []

    def look(_, rows):
        results.append([[r[0, 0] - np.abs(r[0, 1:]).sum(), r[0, 0] + np.abs(r[0, 1:]).sum()] for r in rows[:2]])
        return rows if len(results) < count else None

    for _ in sets.run(plant, memory, free, 2, look):
        pass
    return np.array(results)


def runs(loop, error, unit, noise, rng, count):
    """Yield states at samples; the plant between them is solved exactly."""
    step = compile(next(c for c in loop.controllers if c.name == "law"), "python")
    h = 0.05
    for member in range(count):
        state = step.start()
        x, v = rng.choice([-0.1, 0.1], 2) if member % 2 else rng.uniform(-0.1, 0.1, 2)
        sides = np.sign([x if member % 4 < 2 else -x, v]) if member % 3 else None
        for _ in range(40):
            drift = noise * (sides[0] if sides is not None else rng.uniform(-1, 1))
            # Half a unit to one side is the largest error of rounding; whole numbers are exact.
            inputs = [np.floor(a / unit + 0.5) * unit for a in (x + drift, v)]
            u, state = step(*map(float, inputs), state)
            u += error * (sides[1] if sides is not None else rng.choice([-1, 1]))
            x, v = x + h * v + 0.5 * h * h * u, v + h * u
            yield x, v


@pytest.mark.parametrize(("form", "noise"), [("Q3.4", 0.0), ("Q3.6", 0.02), ("Q3.12", 0.0)])
def test_sets_hold_runs_with_errors(form, noise):
    loop = loop_of(noise=" + noise(sigma=0.01)" if noise else "")
    chip = chip_of(loop, form)
    assert chip.reason == ""
    integers = chip.blocks["law"]
    low, high, rounding = integers.inputs["x"]
    assert (low, high, rounding) == (-2.0, 2.0, 2.0 ** -int(form[3:]) / 2)
    prover = LoopProver(loop, 60.0, chip=chip, noise=2.0 if noise else None)
    sets = samples(prover, 40)
    members = runs(loop, integers.outputs["u"], 2.0 * rounding, noise, np.random.default_rng(0), 200)
    states = np.array(list(members)).reshape(200, 40, 2)
    assert (sets[..., 0] - 1e-9 <= states.min(0)).all()
    assert (states.max(0) <= sets[..., 1] + 1e-9).all()


def test_sets_hold_runs_whose_outputs_are_far_off():
    loop = loop_of()
    chip = chip_of(loop, "Q3.12")
    exact = replace(chip.blocks["law"], inputs=dict.fromkeys(("x", "v"), (-2.0, 2.0, 0.0)), outputs={"u": 0.25})
    sets = samples(LoopProver(loop, 60.0, chip=replace(chip, blocks={"law": exact})), 40)
    members = runs(loop, 0.25, 2.0**-40, 0.0, np.random.default_rng(0), 200)
    states = np.array(list(members)).reshape(200, 40, 2)
    assert (sets[..., 0] - 1e-9 <= states.min(0)).all()
    assert (states.max(0) <= sets[..., 1] + 1e-9).all()


def test_sets_in_fixed_point_are_wider_and_tend_to_those_in_double_precision():
    loop = loop_of()
    widths = [
        np.ptp(samples(LoopProver(loop, 60.0, chip=chip), 30)[-1], axis=-1).sum()
        for chip in (*(chip_of(loop, f) for f in ("Q3.4", "Q3.8", "Q3.20")), None)
    ]
    assert widths[0] > 1.5 * widths[1] > 1.5 * widths[2] > widths[3]
    assert widths[2] < 1.001 * widths[3]


def test_verdicts_name_the_format(tmp_path):
    path = tmp_path / "a.fz"
    claims = ["require always abs(mass.px) <= 0.3", "require always abs(mass.px) <= 1 forever", "require stable"]
    path.write_text(LOOP.format("") + "\n".join([*claims, "require always law.s <= 1"]) + "\n", encoding="utf-8")
    lines = run_command("prove", path, "--fixed", "Q3.8").output.splitlines()
    assert lines[1].endswith("in 1 box; the controllers in Q3.8")
    assert lines[3].endswith("lies in an earlier one; the controllers in Q3.8")
    assert "rounding and noise keep a loop from a point" in lines[5]
    assert "'law.s', which integers round" in lines[7]
    assert lines[-1] == "2 proved, 2 undecided"


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("next s = clamp(0.5 * s + 0.25 * x + 0.03 * previous(u), -1, 1)", "next s = s + x", "no range of state 's'"),
        ("for mass.v in [-0.1, 0.1]", "for law.s in [-0.5, 0.5]", "'law.s' varies, and integers are those of one"),
        ("every 50 ms\n", "", "a sample time"),
    ],
)
def test_a_controller_without_integers_is_undecided(old, new, reason):
    text = (LOOP.format("") + "require always abs(mass.px) <= 0.3\n").replace(old, new)
    loop = loads(text.replace("run 3 s", "run 3 s step 10 ms"), block="l")
    verdict = LoopProver(loop, 5.0, chip=chip_of(loop, "Q3.8")).verdict(loop.guarantees[0])
    assert type(verdict).__name__ == "Undecided"
    assert reason in verdict.reason


def test_a_member_that_breaks_a_claim_in_double_precision_refutes_no_chip():
    loop = loop_of("require always mass.px <= 0.05")
    verdict = LoopProver(loop, 5.0, chip=chip_of(loop, "Q3.8")).verdict(loop.guarantees[0])
    assert type(verdict).__name__ == "Undecided"
    assert "in double precision" in verdict.reason


def test_any_noise_is_more_than_that_of_a_seed():
    loop = loop_of("require always abs(mass.px) <= 1 forever", noise=" + noise(sigma=0.01)")
    assert "depends on the time" in LoopProver(loop, 10.0).verdict(loop.guarantees[0]).reason
    verdict = LoopProver(loop, 10.0, noise=3.0).verdict(loop.guarantees[0])
    assert type(verdict).__name__ == "Proved"
    assert verdict.note.endswith("noise up to 3 standard deviations")
    seeded, any_noise, none = (
        np.ptp(samples(LoopProver(loop, 60.0, noise=n), 30)[-1], axis=-1).sum() for n in (None, 3.0, 0.0)
    )
    assert any_noise > 1.2 * seeded
    assert none <= 1.01 * seeded


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--fixed", "q15"], "is not of the form Qm.n"),
        (["--fixed", "Q3.8", "--bounds"], "--fixed is not for --bounds"),
        (["--noise", "3", "--certificate", "c.json"], "--noise is not for --certificate"),
        (["--noise", "-1"], "--noise"),
    ],
)
def test_wrong_usage(options, message, tmp_path):
    (tmp_path / "a.fz").write_text(LOOP.format("") + "require stable\n", encoding="utf-8")
    result = run_command("prove", tmp_path / "a.fz", *options)
    assert (result.exit_code, message in result.errors) == (2, True), result.errors
    assert "is for loops" in run_command("prove", "tipper", "--fixed", "Q3.8").errors
