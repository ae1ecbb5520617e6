"""What is proved of a loop is true of each member: claims at the edge of the true, and ones that are false."""

import numpy as np
import pytest

from fuzzyctl import Experiment, Proved, Refuted, loads
from fuzzyctl.analysis.reach import prover
from fuzzyctl.analysis.work import clock
from fuzzyctl.simulation.loop_params import with_settings
from fuzzyctl.simulation.members import Tube, hull, intersection, members
from tests.fuzzyctl.analysis.reach.loops import FUZZY, LOOPS, RATES, TANK, loop_of

#: A plant whose output is its state, and how it changes, its family and its run.
ALONE = "plant p\nstate x = 1\n{plant}output y = x\nloop l\nblock p = p()\n{lines}"


@pytest.fixture(autouse=True)
def few_boxes(monkeypatch):
    monkeypatch.setattr(prover, "MOST_BOXES", 4)


def proofs(loop, timeout=60.0):
    """Return whether each claim is proved by sets alone, without runs of members."""
    looking = prover.LoopProver(loop, timeout)
    looking.__dict__["_refuted"] = {}
    return [isinstance(looking.verdict(c), Proved) for c in loop.guarantees]


def alone(plant, *lines):
    return loads(ALONE.format(plant=plant + "\n", lines="".join(f"{line}\n" for line in lines)), block="l")


#: Signals of loops whose largest values simulated members reach.
SIGNALS = {
    "tank": ["tank.h", "law.v", "-tank.h * tank.h"],
    "rates": ["mass.x - mass.w", "inner.u", "outer.n"],
    "fuzzy": ["pendulum.th", "law.u", "pendulum.w ^ 2"],
}


@pytest.mark.parametrize("name", SIGNALS)
def test_no_claim_that_a_member_breaks_is_proved(name):
    """The limits lie just below, and some way above, of what members reach."""
    text = LOOPS[name]
    text = text[: text.rindex("run")] + "run 1.2 s\n"
    loop = loop_of(text)
    runs = [Experiment(with_settings(loop, m), "python").run(substeps=16) for m in members(loop, 24)]
    claims, expected = [], []
    for signal in SIGNALS[name]:
        code = compile(signal.replace("^", "**").replace(".", "_"), "s", "eval")
        names = {n: n.replace(".", "_") for n in ("tank.h", "law.v", "mass.x", "mass.w", "inner.u", "outer.n",
                                                  "pendulum.th", "pendulum.w", "law.u")}  # fmt: skip
        largest = -np.inf
        for run in runs:
            values = {short: run[n] for n, short in names.items() if n in loop_signals(run)}
            largest = max(largest, float(np.max(eval(code, {}, values))))
        for limit, proved in ((largest - 1e-6, False), (largest + 0.4 * (1 + abs(largest)), True)):
            claims.append(f"require always {signal} <= {limit!r}")
            expected.append(proved)
    assert proofs(loop_of(text, *claims)) == expected


def loop_signals(run):
    return run.signals if hasattr(run, "signals") else list(run)


def test_a_claim_at_an_instant_between_samples_is_about_it():
    """x = 1 + t, at times that are no multiples of the step."""
    claims = [
        "require always p.y <= 1.249 until 0.25 s",
        "require always p.y <= 1.4 until 0.25 s",
        "require always p.y >= 1.251 from 0.25 s",
        "require always p.y >= 1.19 from 0.25 s until 0.26 s",
        "require always p.y <= 1.299 from 0.3 s until 0.3 s",
        "require always p.y <= 1.41 until 0.3 s",
    ]
    lines = "der x = 1", "run 1 s step 100 ms"
    assert proofs(alone(*lines, *claims)) == [False, True, False, True, False, True]
    assert [proofs(alone(*lines, c))[0] for c in claims] == [False, True, False, True, False, True]


def test_a_claim_about_times_behind_the_last_sample_is_proved_for_these():
    """x = 1 + t; the last sample of the run is at 0.9 s."""
    claims = ["p.y <= 1.95 until 1 s", "p.y <= 1.95", "p.y <= 2.25", "p.y <= 5 until 5 s", "p.y <= 6.2 until 5 s"]
    lines = "der x = 1", "run 1 s step 0.3 s", *(f"require always {c}" for c in claims)
    assert proofs(alone(*lines)) == [False, False, True, False, True]
    # The loop has a sample at its end, its controller has not.
    text = "controller c\ninput y\noutput u = 1 + 0 * y\nevery 0.3 s\nplant p\ninput u\nstate x = 1\nder x = u\n"
    loop = "output y = x\nloop l\nblock c = c(p.y)\nblock p = p(c.u)\nrun 1 s step 0.1 s\n"
    assert proofs(loop_of(text + loop, "require always p.x <= 1.95", "require always p.x <= 2.25")) == [False, True]


def test_the_command_of_the_last_sample_is_in_the_claim():
    """A controller that jumps at the end of the time of a claim, or at its begin."""
    text = TANK.replace(
        "output v = clamp(k * e + s, -0.5, 1)",
        "state n = 0\nnext n = n + 1\noutput v = where(n >= 3, 0.5, 0.1) + 0 * e",
    )
    claims = ["require always law.v <= 0.2 until 0.3 s", "require always law.v <= 0.2 until 0.29 s",
              "require always law.v >= 0.4 from 0.3 s", "require always law.v >= 0.4 from 0.29 s"]  # fmt: skip
    text = text[: text.rindex("run")].replace("for law.k in [1, 2]\n", "") + "run 0.6 s\n"
    assert proofs(loads(text + "".join(c + "\n" for c in claims), block="l")) == [False, True, True, False]


#: Plants alone, and whether |x| stays below a limit for ever.
FOREVER = [
    ("der x = -x", "for p.x in [-1, 1]", 1.16, True),
    ("der x = 0.01 * x", "for p.x in [-1, 1]", 1.019, False),  # after 100 ms still within a slightly wider start
    ("der x = 0.001 * x", "for p.x in [-1, 1]", 1.5, False),
    ("der x = 1e-6", "for p.x in [-1, 1]", 1.5, False),
    ("der x = -x + 0.5", "for p.x in [0, 1]", 1.01, True),
    ("der x = -x + 0.5", "for p.x in [0, 1]", 0.49, False),
    ("param a = 1\nder x = a * x", "for p.a in [-1, 0.001]", 1.5, False),
    ("param a = 1\nder x = a * x", "for p.a in [-2, -1]", 1.11, True),
    ("der x = x * (x - 1.0000001)", "for p.x in [0, 1]", 1.01, None),  # nearly at rest at the upper end
    ("der x = x * (0.5 - x)", "for p.x in [0.01, 0.1]", 0.3, False),
]


@pytest.mark.parametrize(("plant", "family", "limit", "true"), FOREVER)
def test_what_is_proved_for_ever_is_true_for_ever(plant, family, limit, true):
    loop = alone(plant, family, "run 10 s step 100 ms", f"require always abs(p.y) <= {limit} forever")
    assert true is None or proofs(loop, 1.0 + true) == [true]


def test_a_set_that_turns_comes_back_into_itself_only_if_it_shrinks():
    plant = "state v = 0\nder x = v\nder v = {} - x"
    for friction, true in (("-0.5 * v", True), ("0.001 * v", False)):
        loop = alone(
            plant.format(friction), "for p.x in [-1, 1]", "run 10 s step 100 ms", "require always abs(p.y) <= 3 forever"
        )
        assert proofs(loop, 8.0 if true else 1.0) == [true]


@pytest.mark.parametrize(
    ("condition", "true"),
    [
        (">= -1.5 forever", True),
        (">= -0.2 forever", True),  # not kept in a ball around the rest that holds the start
        (">= -0.1 forever", False),  # a spring with a damper that starts in [0.9, 1] comes to -0.163, at 3.6 s
        (">= -0.1 from 3 s forever", False),
        (">= -0.1 from 5 s forever", True),
    ],
)
def test_a_ball_that_contracts_proves_a_claim_for_ever(condition, true):
    lines = ["for p.x in [0.9, 1]", "run 10 s step 100 ms", f"require always p.y {condition}", "require stable"]
    looking = prover.LoopProver(alone("state v = 0\nder x = v\nder v = -x - v", *lines), 8.0 if true else 1.0)
    looking.__dict__["_refuted"] = {}
    verdict = looking.verdict(looking.own[0])
    assert isinstance(verdict, Proved) == true
    assert not true or "in a ball that a period maps into itself" in verdict.note


def test_a_loop_of_several_rates_and_a_counter_is_not_invariant():
    """The counter of the slow controller grows, if slowly."""
    text = RATES[: RATES.rindex("run")] + "run 3 s\n"
    assert proofs(loop_of(text, "require always mass.x <= 1.5 forever")) == [False]


def test_a_fuzzy_loop_is_proved_for_ever():
    assert proofs(loop_of(FUZZY, "require always abs(pendulum.th) <= 1.2 forever")) == [True]


@pytest.mark.parametrize(
    ("range_", "proved"),
    [("[0, 2]", True), ("[0, 1.5]", False), ("[0, 1.9)", False), ("[0.5, 3]", True), ("[0.5, 1.85]", False)],
)
def test_a_state_that_leaves_its_range_breaks_all_claims(range_, proved):
    text = ALONE.replace("state x = 1", f"state x in {range_} = 1")
    text = text.format(plant="der x = 1\n", lines="run 0.9 s step 100 ms\nrequire always p.y <= 5\n")
    assert proofs(loads(text, block="l")) == [proved]


@pytest.mark.parametrize(
    ("plant", "true"),
    [("der x = -x", True), ("der x = 0.01 * x", False), ("der x = -x * x * x", False), ("der x = sin(x) - 2 * x", True),
     ("der x = where(x > 0, -1, 1)", False), ("state v = 0\nder x = v\nder v = -x", False),
     ("state v = 0\nder x = v\nder v = -x - v", True)],
)  # fmt: skip
def test_convergence_is_proved_only_of_what_converges_at_a_rate(plant, true):
    loop = alone(plant, "for p.x in [-0.5, 0.5]", "run 10 s step 100 ms", "require stable")
    assert proofs(loop, 1.0 + true) == [true]


DELAYED = """
controller law
input y
output u = -{} * y
every 100 ms
plant p
input u
state x = 1
der x = delay(u, 200 ms, start=0.25)
output y = x
loop l
block law = law(p.y)
block p = p(law.u)
for p.x in [-1, 1]
run 2 s
"""


def test_a_dead_time_is_kept_sample_by_sample():
    loop = loop_of(DELAYED.format(3))
    runs = [Experiment(with_settings(loop, m), "python").run(substeps=4) for m in members(loop, 8)]
    largest = max(float(np.max(run["p.x"])) for run in runs)
    claims = [f"require always p.x <= {largest + d!r}" for d in (-1e-6, 1e-2)]
    assert proofs(loop_of(DELAYED.format(3), *claims, "require stable")) == [False, True, True]
    assert proofs(loop_of(DELAYED.format(8), "require stable"), 0.5) == [False]  # it swings up
    continuous = DELAYED.format(3).replace("delay(u, 200 ms, start=0.25)", "u - delay(x, 200 ms)")
    assert proofs(loop_of(continuous, "require stable")) == [False]


#: Claims for which one box suffices, and a box must be cut, of loops with a fast and a slow rate, and with a curve.
TUBES = {
    "tank": ["require always tank.h <= 10"],
    "cut": ["require always tank.h <= 0.415"],
    "rates": ["require always mass.x <= 10", "require always mass.x >= -10 until 0.5 s"],
}


@pytest.mark.parametrize("name", TUBES)
def test_the_tube_holds_the_runs_of_all_members(name):
    text = LOOPS["rates" if name == "rates" else "tank"]
    loop = loop_of(text[: text.rindex("run")] + "run 1.2 s\n", *TUBES[name])
    looking = prover.LoopProver(loop, 60.0)
    looking.__dict__["_refuted"] = {}
    for claim in loop.guarantees:
        looking.verdict(claim)
    tube = looking.tube
    assert tube.begin[0] == 0.0
    assert tube.end[-1] == pytest.approx(1.2)
    assert np.array_equal(tube.begin[1:], tube.end[:-1])
    assert list(tube.bounds) == (["mass.y", "mass.speed"] if name == "rates" else ["tank.y"])
    runs = [Experiment(with_settings(loop, m), "python").run(substeps=16) for m in members(loop, 24)]
    for signal, (low, high) in tube.bounds.items():
        values = np.array([run[signal] for run in runs])
        at = np.minimum(np.searchsorted(tube.end, runs[0].t), len(tube.end) - 1)
        assert np.all(low[at] <= values)
        assert np.all(values <= high[at])
        # It is not much wider than the runs are apart.
        assert np.all((high - low)[at] <= np.ptp(values, axis=0) + 0.4)


def test_a_tube_ends_where_the_first_of_its_boxes_is_open():
    one = Tube(np.array([0.0, 1.0]), np.array([1.0, 2.0]), {"y": (np.array([0.0, 1.0]), np.array([1.0, 2.0]))})
    other = Tube(np.array([0.0]), np.array([1.5]), {"y": (np.array([0.5]), np.array([1.5]))})
    both = hull([one, other])
    assert (list(both.begin), list(both.end)) == ([0.0, 1.0], [1.0, 1.5])
    assert [list(side) for side in both.bounds["y"]] == [[0.0, 0.5], [1.5, 2.0]]
    meet = intersection([one, other])
    assert list(meet.end) == [1.0, 1.5, 2.0]
    assert [list(side) for side in meet.bounds["y"]] == [[0.5, 1.0, 1.0], [1.0, 1.5, 2.0]]


def test_a_state_of_a_controller_is_not_the_param():
    """The state is the disturbance of the period before; no plant has a state."""
    loop = loads(
        "controller law\ninput d\nparam a in [-1, 1] = 0\nstate s = 0\nnext s = d\noutput y = s - a\nevery 1 s\n"
        "loop l\nblock law = law(d=w)\ndisturbance w in [-1, 1] = 0\nfor law.a in [-1, 1]\n"
        "require always abs(law.y) <= 1.9 from 1 s until 1.5 s\nrequire always abs(law.y) <= 2.1\nrun 2 s\n",
        block="l",
    )
    assert proofs(loop) == [False, True]


def test_a_tolerance_counts_for_all_comparisons_as_in_runs():
    loop = alone(
        "der x = 0",
        "for p.x in [0, 0.5]",
        "require always not (p.y > 1) within 0.5001",
        "require always not (p.y > 1) within 0.4",
        "require always p.y != 0.6 within 0.2",
        "require always p.y != 0.6 within 0.09",
        "require always p.y == 0.25 within 0.2",
        "require always p.y == 0.25 within 0.26",
        "run 1 s step 0.5 s",
    )
    expected = [False, True] * 3
    assert proofs(loop) == expected
    kept = [
        all(r.holds for r in run)
        for run in zip(*(Experiment(with_settings(loop, m)).run().requirements for m in members(loop, 8)), strict=True)
    ]
    assert kept == expected


def test_the_error_of_a_run_refutes_nothing():
    """x slides along 0.5; steps of RK4 jump across it."""
    loop = alone(
        "der x = where(x > 0.5, -1, 1)",
        *(f"require always p.y <= {limit}" for limit in (0.5, 0.503, 0.45)),
        "for p.x in [0, 0.3]",
        "run 2 s step 30 ms",
    )
    looking = prover.LoopProver(loop, 2.0)
    assert [isinstance(looking.verdict(c), Refuted) for c in loop.guarantees] == [False, False, True]


def test_ranges_and_times_that_differ_between_members_prove_nothing():
    """They would be those of the nominal member."""
    head = "param a in [0, 9] = 1"
    for line, claims in (
        ("for p.x in [0, a]", ["p.y <= 1.5", "p.y >= -1"]),
        ("for p.x in [0, 1]", ["p.y <= 2.5 from a", "p.y <= 9", "p.y >= 0.9 until a", "p.y <= 1.9 within a"]),
    ):
        lines = [head, "for a in [0.5, 2]", line, *(f"require always {c}" for c in claims), "run 3 s step 0.5 s"]
        expected = [c == "p.y <= 9" for c in claims]
        assert proofs(alone("der x = 1", *lines)) == expected
        looking = prover.LoopProver(alone("der x = 1", *lines), 10.0)
        looking.__dict__["_refuted"] = {}
        reasons = [v.reason for v in map(looking.verdict, looking.own) if not isinstance(v, Proved)]
        assert all(r.startswith("'a' cannot vary in a proof: ") for r in reasons)


@pytest.mark.parametrize(("step", "limit", "proved"), [(0.05, 0.41, False), (0.05, 0.43, True), (0.2, 0.41, True)])
def test_a_state_of_a_slow_controller_changes_at_the_next_sample_of_the_record(step, limit, proved):
    """After its sample at 0.6 s it is 0.4287: seen at 0.65 s, or at 0.8 s."""
    text = """
controller law
input y
output u = -0.5 * y
every 200 ms
controller slow
input y
state z = 0
next z = 0.7 * z + 0.3 * y
output r = z
every 600 ms
plant p
input u
state x = 1
der x = u
output y = x
loop l
block slow = slow(p.y)
block law = law(p.y)
block p = p(law.u)
for p.x in [0.9, 1]
"""
    loop = loop_of(text, f"run 1 s step {step} s", f"require always slow.z <= {limit} until 0.75 s")
    assert proofs(loop) == [proved]
    run = Experiment(with_settings(loop, {"p.x": 1.0}), "python").run()
    assert (max(run["slow.z"][run.t <= 0.75]) <= limit) == proved


def test_a_side_without_length_is_not_cut_and_the_start_has_no_error(monkeypatch):
    """A claim that all members break at the start is refuted, also by less than the error of runs."""
    monkeypatch.setattr(prover, "MOST_BOXES", 600)
    claims = [f"require always p.y in (0.3, {limit})" for limit in ("1", "1.01")]
    lines = ["for p.x in [1, 1]", "run 1 s step 100 ms", *claims, "require always p.y < 1 forever", "require stable"]
    looking = prover.LoopProver(alone("der x = -x", *lines), 20.0)
    first, second, forever, stable = map(looking.verdict, looking.own)
    assert isinstance(first, Refuted)
    assert first.note.startswith("at t = 0 s, p.y = 1")
    assert isinstance(second, Proved)
    assert second.note.endswith("in 1 box")
    assert isinstance(forever, Refuted)
    assert isinstance(stable, Proved)
    looking = prover.LoopProver(alone("der x = -x", *lines), 20.0)
    looking.__dict__["_refuted"] = {}
    assert looking.verdict(looking.own[0]).remaining == 1


def test_a_claim_is_not_about_the_step_after_its_end():
    """x = 1 + t, whatever other claims speak of; the controller jumps at 0.3 s, and its new output counts."""
    lines = "der x = 1", "run 1 s step 100 ms", "require always p.y <= 3"
    claims = [f"require always p.y <= {limit} until 0.3 s" for limit in (1.3001, 1.2999)]
    assert proofs(alone(*lines, *claims, "require always p.y <= 1.3001 from 0.3 s until 0.3 s")) == [
        True, True, False, True]  # fmt: skip
    text = "controller c\nstate n = 0\nnext n = n + 1\noutput v = where(n >= 3, 1, 0)\nevery 100 ms\nloop l\n"
    text += "block c = c()\nrun 1 s\nrequire always c.v <= 1\n"
    assert proofs(loop_of(text, *(f"require always c.v <= 0 until {t} s" for t in (0.3, 0.299)))) == [True, False, True]
    # A state may leave its range afterwards.
    text = ALONE.replace("state x = 1", "state x in [0, 1.35] = 1")
    text = text.format(plant="der x = 1\n", lines="run 0.9 s step 100 ms\n")
    claims = ["require always p.y <= 1.301 until 0.3 s", "require always p.y <= 1.41 until 0.4 s"]
    assert proofs(loads(text + "".join(f"{c}\n" for c in claims), block="l")) == [True, False]


@pytest.mark.long
def test_the_time_of_stable_is_a_limit():
    """A ring of twelve states and five params: one attempt to find a ball takes seconds."""
    rates = "".join(f"der x{k} = a{k % 5} * (sin(x{(k + 1) % 12}) - 1.2 * x{k}) - x{k}^3\n" for k in range(12))
    text = (
        "plant p\n" + "".join(f"param a{k} = 1\n" for k in range(5)) + "".join(f"state x{k} = 0.5\n" for k in range(12))
    )
    family = "".join(f"for p.a{k} in [0.8, 1.2]\n" for k in range(5))
    family += "".join(f"for p.x{k} in [0.2, 0.8]\n" for k in range(7))
    text += rates + "output y = x0\nloop l\nblock p = p()\n" + family + "run 10 s step 50 ms\n"
    loop = loop_of(text, "require stable")
    begin = clock.used()
    prover.LoopProver(loop, 2.0).verdict(loop.guarantees[0])
    assert clock.used() - begin < 20.0


#: Noise at samples of the record that the controller of a longer period does not read.
NOISY = """
controller law
input y
output u = -2 * previous(y)
every 100 ms
plant p
input u
state x = 1
der x = u
output y = x
loop l
block law = law(p.y + noise(sigma=0.1, seed=3))
block p = p(law.u)
for p.x in [0.9, 1]
run 1 s step 20 ms
"""


def test_noise_has_the_values_of_the_samples_of_the_controller():
    loop = loop_of(NOISY)
    runs = [Experiment(with_settings(loop, m), "python").run(substeps=4) for m in members(loop, 16)]
    largest = [max(float(np.max(run[name])) for run in runs) for name in ("p.x", "law.u")]
    claims = [
        f"require always {n} <= {v + d!r}"
        for n, v in zip(("p.x", "law.u"), largest, strict=True)
        for d in (-1e-6, 0.01)
    ]
    assert proofs(loop_of(NOISY, *claims)) == [False, True] * 2
    assert prover.LoopProver(loop, 10.0).sets([], 1.0).equations.step == 0.1
    # A claim reads the noise between them.
    seen = loop_of(
        NOISY.replace("block p", "let seen = p.y + noise(sigma=0.1, seed=4)\nblock p"), "require always seen <= 2"
    )
    assert prover.LoopProver(seen, 10.0).sets(seen.guarantees, 1.0).equations.step == 0.02
