"""Mistakes and warnings of [safety]."""

import pytest

from tests.dwmr.scenarios import messages, mistakes, warned

NAME = "paper-with-limits"
GIVEN = {
    "alpha": 1.0, "lookahead": 0.3, "margin": 0.05, "velocity_error": 0.4, "acceleration": 2.0,
    "angular_acceleration": 4.0,
}  # fmt: skip
WIDE = ["robots.follower1.formation.separation=3", "robots.follower2.formation.separation=3"]


def safety(**changes):
    return "safety={" + ",".join(f"{key}={value}" for key, value in (GIVEN | changes).items()) + "}"


#: Overrides, and how the only message begins.
REFUSED = [
    ([safety(alpha=201.0)],
     "safety.alpha = 201 1/s times run.dt = 0.005 s exceeds 1: a barrier could be jumped"),
    ([safety(alpha=150.0), "robot.noise.x=0.001"],
     "safety.alpha = 150 1/s times run.dt = 0.005 s exceeds 0.5: a barrier could be jumped"),
    ([safety(), "robots.follower2.x_0=-2", "robots.follower2.y_0=1"],
     "robots.follower2 starts too close to robots.leader for [safety]: its guarded point is 1.3 m"),
    ([safety(), "obstacles.0.x=-3.2", "obstacles.0.y=4.2"],
     "robots.follower1 starts too close to obstacles.0 for [safety]"),
    ([safety(), "obstacles.0.x=-3.4", "obstacles.0.y=3.1"], "robots.follower1 starts inside obstacles.0: "),
    ([safety(), "run.record_every=2"], "run.record_every = 2: the measures of [safety] need every control period"),
    ([safety(), "robots.leader.noise.y=0.2"],
     "robots.leader.noise moves its guarded point by up to 0.8 m: [safety] would keep "),
]  # fmt: skip


@pytest.mark.parametrize(("overrides", "message"), REFUSED)
def test_values_that_cannot_be_are_refused(overrides, message):
    (one,) = messages(NAME, *overrides)
    assert one.startswith(message)


def test_a_start_that_is_too_close_says_what_is_kept():
    found = mistakes(NAME, safety(), "run.dt=1.0", "run.substeps=80")
    one = next(d for d in found if d.message.startswith("robots.follower1 starts too close"))
    kept = "kept are the radii 0.9081 m and 0.9081 m, the margin 0.05 m, and "
    assert any(fact.startswith(kept) for fact in one.facts)
    assert "shorten run.dt" in one.help


def test_an_unknown_key_and_a_missing_one_are_refused():
    found = messages(NAME, "safety={alpha=1,lookahaed=0.3}")
    assert {"unknown key safety.lookahaed", "safety.lookahead is missing", "safety.margin is missing"} <= set(found)


@pytest.mark.parametrize(
    ("change", "override", "message"),
    [
        (
            {},
            "robots.leader.actuator.acceleration=1.5",
            "robots.leader.actuator.acceleration = 1.5 m/s² is below safety.acceleration = 2 m/s²: barriers may be",
        ),
        ({"acceleration": 9.0}, "run.seed=1", "safety.acceleration = 9 m/s² is beyond what the wheels give"),
        ({"angular_acceleration": 20.0}, "run.seed=1", "safety.angular_acceleration = 20 rad/s² is beyond what"),
        ({"alpha": 2.0}, "run.seed=1", "safety.alpha = 2 1/s brakes robots.leader from its 2 m/s with up to 4 m/s²"),
        ({"velocity_error": 0.2}, "run.seed=1", "disturbances.1 moves guarded points at 0.306 m/s, beyond"),
        ({}, "obstacles.0.velocity=[3,0]", "obstacles.0 moves at up to 3 m/s, robots.leader at 2 m/s at most"),
        (
            {},
            'robots.leader.sensors={pose="odometry"}',
            "robots.leader knows its place by odometry, whose error has no bound: [safety] keeps the distances",
        ),
        ({"margin": 1.2}, "run.seed=1", "robots.follower1.formation puts guarded points"),
    ],
)
def test_distances_that_robots_cannot_keep_are_warned_of(change, override, message):
    assert warned(NAME, safety(), *WIDE) == []
    assert any(one.startswith(message) for one in warned(NAME, safety(**change), override, *WIDE))
