"""Policies and environments: gymnasium's own checks, and the run of simulate step by step."""

import math

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import fuzzyctl
from fuzzyctl import ArgumentError, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.interop.gymnasium import Policy, environment
from tests import sizes


def episode(env, policy, seed=0):
    """Return observations, actions, rewards and signals of an episode, and whether it was terminated."""
    observation, info = env.reset(seed=seed)
    policy.reset()
    found = [[observation], [], [], [info]]
    terminated = truncated = False
    while not (terminated or truncated):
        action = policy(observation)
        observation, reward, terminated, truncated, info = env.step(action)
        for values, one in zip(found, (observation, action, reward, info), strict=True):
            values.append(one)
    return (*found, terminated)


class TestLoop:
    @pytest.mark.parametrize("backend", ["numba", "python"])
    def test_a_controller_as_the_policy_gives_the_run_of_simulate(self, tank, backend):
        quiet = tank("500 s step 50 ms" if sizes.LONG else "10 s step 10 ms", sigma=0)
        run = fuzzyctl.Experiment(quiet, backend).run()
        every = 1 if sizes.LONG else 5
        env = environment(quiet, "law", reward="iae", backend=backend)
        _, actions, rewards, signals, terminated = episode(env, Policy(quiet.controllers[0]))
        np.testing.assert_allclose(np.ravel(actions), run["law.valve"][:-1:every], atol=1e-12)
        np.testing.assert_allclose([s["tank.y"] for s in signals], run["tank.y"][::every], atol=1e-12)
        assert -sum(rewards) == pytest.approx(run.measures["iae"], rel=1e-12)
        assert not terminated

    def test_a_measure_of_a_part_of_the_run_is_its_reward(self, tank):
        loop = tank("4 s step 10 ms", "measure part = ise(0.5 * tank.y, 1, begin=1 s, end=3 s)\n", sigma=0)
        _, _, rewards, _, _ = episode(environment(loop, "law", reward="part"), Policy(loop.controllers[0]))
        assert -sum(rewards) == pytest.approx(fuzzyctl.Experiment(loop).run().measures["part"], rel=1e-12)

    def test_passes_the_checks_of_gymnasium(self, tank):
        env = environment(tank("2 s"), "law", reward="iae", start={"tank.h": (0.3, 0.7)})
        with pytest.warns(UserWarning, match="Box"):  # ranges are the user's
            check_env(env, skip_render_check=True)
        assert env.action_space.high == [10.0]

    def test_a_seed_repeats_noise_and_starts(self, tank):
        env = environment(tank("2 s"), "law", reward="iae", start={"tank.h": (0.3, 0.7)})
        first, second = (env.reset(seed=3)[0] for _ in range(2))
        assert first.tolist() == second.tolist()
        assert env.reset(seed=4)[0].tolist() != first.tolist()
        assert env.reset(options={"start": {"tank.h": 0.9}})[1]["tank.y"] == 0.9

    def test_leaving_a_range_terminates_with_a_penalty(self):
        loop = fuzzyctl.load("pendulum", block=fuzzyctl.Loop)
        env = environment(loop, "law", reward=lambda signals: 1.0, actions={"law.force": (-9.0, 9.0)}, penalty=100.0)
        _, _, rewards, signals, terminated = episode(env, lambda_policy([0.0]))
        assert terminated
        assert rewards[-1] == -99.0
        assert "state 'cart.th' left its range" in signals[-1]["stopped"]
        assert 1.0 < signals[-1]["cart.angle"] <= 1.5

    @pytest.mark.parametrize(
        ("options", "error", "words"),
        [
            ({"block": "tank"}, ArgumentError, "block 'tank' is a plant"),
            ({"block": "lwa"}, UnknownNameError, "did you mean 'law'"),
            ({"block": None}, ArgumentError, "'block' is the controller"),
            ({"reward": "iea"}, UnknownNameError, "no measure 'iea'"),
            ({"reward": "settling"}, ArgumentError, "not a sum over the steps"),
            ({"reward": 3}, ArgumentError, "reward must be a function"),
            ({"start": {"tank.x": (0, 1)}}, UnknownNameError, r"no state 'tank\.x'"),
            ({"start": {"tank.h": (0.7, 0.3)}}, ValueOutOfBoundsError, "two numbers, the smaller one first"),
            ({"start": {"tank.h": (0, np.inf)}}, ValueOutOfBoundsError, "must be finite"),
            ({"start": {"tank.h": 3}}, ValueOutOfBoundsError, "two numbers"),
            ({"substeps": 0}, ValueOutOfBoundsError, "substeps must be a positive integer"),
            ({"penalty": float("nan")}, ValueOutOfBoundsError, "penalty must be finite"),
        ],
    )
    def test_mistakes_are_named(self, tank, options, error, words):
        with pytest.raises(error, match=words):
            environment(tank("1 s"), **{"block": "law", "reward": "iae"} | options)
        for reward in (lambda s: float("nan"), lambda s: None):
            env = environment(tank("1 s"), "law", reward=reward)
            env.reset()
            with pytest.raises(ValueOutOfBoundsError, match="the reward must be finite"):
                env.step([1.0])

    def test_actions_are_numbers_of_the_right_count(self, tank):
        env = environment(tank("1 s"), "law", reward="iae")
        with pytest.raises(ArgumentError, match="'reset' begins an episode"):
            env.step([1.0])
        env.reset()
        for action in ([1.0, 2.0], [float("nan")], [np.inf]):
            with pytest.raises(ArgumentError, match=r"the action must be 1 finite number \(law.valve\), got \["):
                env.step(action)
        with pytest.raises(ArgumentError, match=r"\(law\.valve\), got \['open'\]"):
            env.step(["open"])

    def test_actions_have_finite_ranges(self, small):
        loop = small()
        with pytest.raises(ArgumentError, match=r'do not have: law\.u; declare .*actions=\{"law\.u": \(-10, 10\)\}'):
            environment(loop, "law", reward="error")
        with pytest.raises(ArgumentError, match=r"inputs of the plant do not have: u;"):
            environment(loop.plants[0], reward=lambda s: 0.0, dt=0.1, duration=1.0)
        with pytest.raises(UnknownNameError, match=r"no action 'u'.*law\.u"):
            environment(loop, "law", reward="error", actions={"u": (-1, 1)})
        with pytest.raises(ValueOutOfBoundsError, match=r"range of 'law\.u'"):
            environment(loop, "law", reward="error", actions={"law.u": (1, -1)})
        env = environment(loop, "law", reward="error", actions={"law.u": (-1, 1)}, backend="python")
        assert (env.action_space.low, env.action_space.high) == ([-1.0], [1.0])

    def test_options_of_reset_are_checked(self, tank):
        env = environment(tank("1 s"), "law", reward="iae")
        with pytest.raises(UnknownNameError, match=r"no option 'strat'.*did you mean 'start'"):
            env.reset(options={"strat": {"tank.h": 1.0}})
        with pytest.raises(ValueOutOfBoundsError, match=r"start of 'tank\.h' must be finite"):
            env.reset(options={"start": {"tank.h": float("nan")}})
        with pytest.raises(ArgumentError, match="the option 'start' must be values by the names of states, got None"):
            env.reset(options={"start": None})

    @pytest.mark.parametrize(("action", "ended"), [(5.0, "truncated"), (-100.0, "terminated")])
    def test_an_episode_ends_once(self, tank, action, ended):
        env = environment(tank("1 s"), "law", reward="iae")
        *_, terminated = episode(env, lambda_policy([action]))
        assert ("terminated" if terminated else "truncated") == ended
        with pytest.raises(ArgumentError, match="'reset' begins an episode: this one has ended"):
            env.step([action])
        env.reset()
        env.step([5.0])

    def test_signals_have_the_names_of_a_run(self, tank):
        loop = tank("1 s")
        env = environment(loop, "law", reward=lambda s: -(s["law.valve"] ** 2))
        signals = env.reset()[1]
        states = {f"law.{s.name}" for s in loop.controllers[0].states}
        assert set(signals) == {"t", *fuzzyctl.simulate(loop).names} - states
        _, reward, _, _, signals = env.step([3.0])
        assert (reward, signals["law.valve"], signals["law.level"]) == (-9.0, 3.0, signals["level"])


class TestPlant:
    def test_its_outputs_are_observed_and_its_inputs_set(self, tank):
        (plant,) = tank().plants
        env = environment(
            plant, reward=lambda s: -abs(s["plant.y"] - 1.0), dt=0.1, duration=2.0, start={"h": (0.2, 0.4)}
        )
        with pytest.warns(UserWarning, match="Box"):
            check_env(env, skip_render_check=True)
        observation, info = env.reset(seed=1)
        assert observation.tolist() == [info["plant.y"]]
        assert 0.2 <= info["plant.h"] <= 0.4
        observation, reward, *_ = env.step(np.array([5.0]))
        assert reward == -abs(observation[0] - 1.0)

    def test_dead_time_is_kept_by_the_environment(self, small):
        (plant,) = small("tf(num=[1], den=[1, 1], delay=0.2 s)").plants
        env = environment(plant, reward=lambda s: 0.0, dt=0.1, duration=1.0, actions={"u": (-1, 1)})
        env.reset()
        found = [env.step([1.0])[0][0] for _ in range(4)]
        assert found[:2] == [0.0, 0.0]
        assert found[3] == pytest.approx(1 - np.exp(-0.2), abs=1e-6)

    def test_times_are_needed(self, tank):
        with pytest.raises(ArgumentError, match="needs 'dt' and 'duration'"):
            environment(tank().plants[0], reward=lambda s: 0.0)
        for dt, duration in ((float("inf"), 1), (0, 1), (True, 1), ("0.1", 1), (0.1, float("inf")), (0.1, 0.05)):
            with pytest.raises(ValueOutOfBoundsError, match=r"dt|duration"):
                environment(tank().plants[0], reward=lambda s: 0.0, dt=dt, duration=duration)


class TestPolicy:
    def test_a_system_is_a_policy_without_state(self):
        system = fuzzyctl.load("tipper")
        policy = Policy(system)
        assert policy([3.0, 8.0]).tolist() == [fuzzyctl.compile(system, "python")(3.0, 8.0)]
        with pytest.raises(ArgumentError, match=r"must have the shape \(2,\) for service, food"):
            policy([3.0])

    def test_an_observation_that_is_not_a_number_is_refused_and_changes_nothing(self, tank):
        policy = Policy(tank().controllers[0])
        before = policy.state.tolist()
        with pytest.raises(ValueOutOfBoundsError, match=r"observation of level must be a number, got nan") as caught:
            policy([1.0, math.nan])
        assert caught.value.name == "observation of level"
        assert policy.state.tolist() == before
        with pytest.raises(ValueOutOfBoundsError, match="observation of service, food"):
            Policy(fuzzyctl.load("tipper"))([math.nan, math.nan])

    def test_reset_forgets(self, tank):
        policy = Policy(tank().controllers[0])
        first = policy([1.0, 0.5])
        assert policy([1.0, 0.5]).tolist() != first.tolist()
        policy.reset()
        assert policy([1.0, 0.5]).tolist() == first.tolist()
        with pytest.raises(ArgumentError, match="leave 'dt' out"):
            Policy(tank().controllers[0], dt=0.1)


def lambda_policy(action):
    """Return a policy that always does the same."""

    class Same:
        def reset(self):
            pass

        def __call__(self, observation):
            return np.array(action)

    return Same()
