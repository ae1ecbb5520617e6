"""Arrivals: their measure, robots that change places behind the safety filter, and gains while they do."""

import numpy as np
import pytest

from dwmr import measure, read, simulate
from tests import explanation
from tests.dwmr.process import here
from tests.dwmr.results.test_metrics import SCENARIO, stopped
from tests.dwmr.scenarios import KNOWN, by_hand, measured, shared, warned

ARRIVALS = explanation.script("avoidance/arrivals.py")
#: A robot that begins on a straight reference, 12 m before an obstacle that lies on it.
HEAD_ON = (
    "disturbances=[]", "load.mass_factor=1", "load.inertia_factor=1", "run.horizon=60",
    "reference={kind='line',start_x=0,start_y=0,angle=0,speed=0.5}", "obstacles=[{x=12,y=0,radius=0.5}]",
    "robot.actuator.v_limit=1", "robot.actuator.omega_limit=1.5", "robots.leader.avoids_obstacles=false",
    "robots.leader.x_0=0", "robots.leader.y_0=0", "robots.leader.theta_0=0",
    "robots.follower1.formation.separation=4", "robots.follower2.formation.separation=4",
)  # fmt: skip
SAFETY = "safety={alpha=2,lookahead=0.3,margin=0.05,velocity_error=0.1,acceleration=2,angular_acceleration=4%s}"
#: Limits that the robots of the paper reach at the start.
LIMITS = ("run.horizon=20", "robot.actuator.omega_limit=0.3")


class TestMeasure:
    def test_is_the_time_from_which_on_a_robot_stays_near_its_place(self):
        found = measure(by_hand(samples=4, x_r=[[1.0] * 3, [0.3, 0, 0], [0.6, 0, 0], [0.4, 0, 9.0]]), SCENARIO)
        assert found["arrival"]["leader"] == {"reached": True, "t": 0.015, "distance": 0.4}
        assert found["arrival"]["follower1"] == {"reached": True, "t": 0.005, "distance": 0.0}
        assert found["arrival"]["follower2"] == {"reached": False, "t": None, "distance": 9.0}

    def test_takes_the_radius_of_the_scenario(self):
        wide = SCENARIO.model_copy(update={"run": SCENARIO.run.model_copy(update={"arrival": 2.0})})
        assert measure(by_hand(x_r=1.0), wide)["arrival"]["leader"]["reached"]

    def test_a_run_that_stopped_has_none(self):
        found = measure(by_hand(stop=stopped(0.01, "diverged")), SCENARIO)["arrival"]["leader"]
        assert found == {"reached": False, "t": None, "distance": 0.0}


class TestScenes:
    @pytest.mark.parametrize("seed", range(2))
    def test_robots_that_meet_head_on_arrive(self, seed):
        found = ARRIVALS.outcome(ARRIVALS.swap(2, seed))
        assert (found["arrived"], found["moments"]) == (2, 0)
        assert found["gap"] > 0.0

    @pytest.mark.parametrize("number", range(3))
    def test_robots_among_obstacles_arrive(self, number):
        found = ARRIVALS.outcome(ARRIVALS.crowd(number, robots=2))
        assert (found["arrived"], found["moments"]) == (2, 0)
        assert found["gap"] > 0.0

    @pytest.mark.long
    @pytest.mark.parametrize("robots", [2, 4, 6, 10])
    def test_all_seeds_of_all_swaps_arrive(self, robots):
        found = [ARRIVALS.outcome(ARRIVALS.swap(robots, seed)) for seed in range(8)]
        assert [one["arrived"] for one in found] == [robots] * 8
        assert min(one["gap"] for one in found) > 0.0

    @pytest.mark.long
    def test_all_robots_arrive_in_nine_of_ten_random_scenes(self):
        found = [ARRIVALS.outcome(ARRIVALS.crowd(number)) for number in range(100)]
        assert sum(one["arrived"] == one["robots"] for one in found) >= 90
        assert min(one["gap"] for one in found) > 0.0


class TestBesideOrca:
    """ORCA of the library RVO2, for discs of the size that the filter guards, which can take every velocity."""

    @pytest.fixture
    def beside(self):
        pytest.importorskip("pyrvo", reason="needs ORCA: pip install pyrvo")
        return explanation.script("avoidance/beside_orca.py")

    @pytest.mark.parametrize(
        "robots", [2, pytest.param(4, marks=pytest.mark.long), pytest.param(6, marks=pytest.mark.long)]
    )
    def test_the_filter_keeps_as_far_apart_and_takes_little_longer(self, beside, robots):
        found = beside.each(robots, 0)
        filtered, turned = found["filter"], found["ORCA, 0.1 rad to the right"]
        assert filtered["arrived"] == turned["arrived"] == robots
        assert filtered["gap"] > 0.04 > 1e-3 > turned["gap"] > -1e-3
        assert filtered["last"] < 1.1 * turned["last"]

    def test_orca_alone_waits_in_the_middle_where_four_meet(self, beside):
        assert beside.orca(ARRIVALS.swap(2, 0), 0.9, 0.5)["arrived"] == 2
        assert beside.orca(ARRIVALS.swap(4, 0), 0.9, 0.5)["arrived"] == 0
        assert beside.orca(ARRIVALS.swap(4, 0), 0.9, 0.5, 0.1)["arrived"] == 4


class TestGains:
    def test_stay_near_their_floors_while_a_robot_passes_an_obstacle_head_on(self):
        found = measured("paper-with-limits", "aifqsmc", *HEAD_ON, SAFETY % "")
        assert max(gains["k_h_omega"]["largest"] for gains in found["drift"].values()) <= 0.5
        assert all(one["reached"] for one in found["arrival"].values())
        assert found["obstacle_gap"]["leader"] > 0.05

    def test_rise_without_the_condition_and_a_run_warns_of_it(self, recorded, tmp_path):
        never = ("robot.conditional_adaptation=false", SAFETY % ",keep_right=0")
        file, run = shared("paper-with-limits", "aifqsmc", *HEAD_ON, *never)
        found = measure(run, file.scenario)
        assert not found["arrival"]["leader"]["reached"]
        assert found["drift"]["leader"]["k_h_v"]["largest"] > 10.0
        recorded(run)
        options = [word for one in (*HEAD_ON, *never) for word in ("--set", one)]
        lines = here("run", "paper-with-limits", "--controller", "aifqsmc", *options, "-o", tmp_path / "out").stdout
        text = " ".join(lines.split())
        assert "leader's k_h_v rises to 14.673, 147 times its floor: robot.conditional_adaptation = true" in text
        assert "2 of 3 arrive" in text
        (row,) = [row for row in lines.partition("Safety\n")[2].splitlines() if row.startswith("aifqsmc leader")][:1]
        assert row.endswith("no")

    def test_rest_at_limits_on_request_only(self):
        (_, free), (_, asked), (_, never) = (
            shared("paper", "aifqsmc", *LIMITS, *(f"robot.conditional_adaptation={c}" for c in choice))
            for choice in ((), ("true",), ("false",))
        )
        assert np.array_equal(free.values, never.values)
        at_limit = np.abs(asked["omega_c"][:, 0]) > 0.3
        change = np.diff(asked["k_h_omega"][:, 0])
        assert at_limit.any()
        assert (change[at_limit[:-1]] == 0.0).all()
        assert (np.diff(never["k_h_omega"][:, 0])[at_limit[:-1]] != 0.0).any()

    def test_of_the_paper_are_those_without_the_condition(self):
        runs = [
            shared("paper", "aifqsmc", "run.horizon=5", f"robot.conditional_adaptation={c}")[1]
            for c in ("true", "false")
        ]
        assert np.array_equal(*(one.values for one in runs))

    def test_of_a_law_in_python_are_the_states_that_it_names(self, tmp_path):
        law = PYTHON_LAW.replace("FROZEN", "(0,)")
        (tmp_path / "mine.py").write_text(law, encoding="utf-8")
        (tmp_path / "scene.toml").write_text(
            'extends = "paper"\nrun = { controller = "mine", horizon = 0.1 }\n'
            "[robot]\nconditional_adaptation = true\n[robot.actuator]\nv_limit = 0.5\n[robot.controllers.mine]\n",
            encoding="utf-8",
        )
        run = simulate(read(tmp_path / "scene.toml"), known=KNOWN)
        assert run["frozen"][:, 0].tolist() == [0.0] * len(run.t)
        assert run["counted"][:, 0].tolist() == list(range(len(run.t)))


#: A law that counts its periods in two states.
PYTHON_LAW = '''
import numpy as np
from dwmr.control.laws.settings import LawSettings
from dwmr.core.interfaces import Law, Signal, control_law

SIGNALS = (Signal("frozen", "-", ""), Signal("counted", "-", ""))
FAULTS = {}


class Settings(LawSettings):
    """None."""


def init(settings, rules, robot):
    return Law(np.zeros(0), np.zeros(2), (), FROZEN)


@control_law()
def step(error, dt, gains, state, kernels, next_state, signals):
    for k in range(2):
        signals[k], next_state[k] = state[k], state[k] + 1.0
    return 1.0, 0.0, 0
'''


def test_the_formation_of_the_paper_has_room_for_two_discs_only():
    for discs, is_narrow in ((1, True), (2, False)):
        lines = warned("paper-with-limits", SAFETY % f",discs={discs}", "robot.actuator.omega_limit=1.5")
        assert any("cannot reach its place" in line for line in lines) is is_narrow


def test_two_discs_let_the_formation_of_the_paper_drive_as_without_a_filter():
    wide = ("run.horizon=40", "obstacles=[]", "disturbances=[]", "robot.actuator.omega_limit=1.5")
    found = measured("paper-with-limits", "aifqsmc", *wide, SAFETY % ",discs=2")
    assert found["safety"]["infeasible"] == found["safety"]["missed"] == []
    assert max(found["safety"]["acts"].values()) < 0.1
    assert all(one["reached"] for one in found["arrival"].values())
