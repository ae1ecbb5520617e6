"""The nearest velocities that meet linear constraints, against scipy and against laws of projections."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog, minimize

from dwmr.control.safety_filter import active_set, half_spaces, project
from tests.sizes import examples

LIMIT = 2.0


def filled(rows, robots):
    """Constraints from rows (a, b, normal of a, normal of b, bound), after the limits ±2 m/s of all velocities."""
    spaces = half_spaces(4 * robots + len(rows))
    k = 0
    for i in range(robots):
        for axis in (0, 1):
            for sign in (1.0, -1.0):
                spaces.robots[k] = i
                spaces.normals[k, axis] = sign
                spaces.bounds[k] = -LIMIT
                k += 1
    for a, b, first, second, bound in rows:
        spaces.robots[k], spaces.normals[k], spaces.bounds[k] = (a, b), (*first, *second), bound
        k += 1
    return spaces, 4 * robots


def solved(wanted, rows):
    wanted = np.array(wanted, dtype=float)
    spaces, hard = filled(rows, len(wanted))
    y = np.zeros_like(wanted)
    feasible = project(wanted, spaces, len(spaces.bounds), hard, active_set(len(wanted)), y)
    return feasible, y, spaces


def matrix(spaces, robots):
    found = np.zeros((len(spaces.bounds), 2 * robots))
    for row, (a, b), normal in zip(found, spaces.robots, spaces.normals, strict=True):
        row[2 * a : 2 * a + 2] += normal[:2]
        row[2 * b : 2 * b + 2] += normal[2:]
    return found


def one(angle, bound, robot=0):
    return robot, robot, (np.cos(angle), np.sin(angle)), (0.0, 0.0), bound


def pair(a, b, first, second, bound):
    return a, b, (np.cos(first), np.sin(first)), (-np.cos(second), -np.sin(second)), bound


angles = st.floats(-3.2, 3.2)
bounds = st.floats(-1.5, 1.5)
velocities = st.tuples(st.floats(-1.9, 1.9), st.floats(-1.9, 1.9))
rows = st.lists(
    st.one_of(
        st.builds(one, angles, bounds, st.integers(0, 2)),
        st.builds(
            lambda ends, *rest: pair(*ends, *rest), st.sampled_from([(0, 1), (1, 2), (0, 2)]), angles, angles, bounds
        ),
    ),
    max_size=8,
)


def test_velocities_that_meet_all_constraints_stay():
    feasible, y, _ = solved([(0.3, 0.4)], [one(0.0, -1.0)])
    assert feasible
    assert y.tolist() == [[0.3, 0.4]]


def test_one_constraint_takes_away_the_normal_part_only():
    feasible, y, _ = solved([(1.0, 0.4)], [one(np.pi, -0.25)])
    assert feasible
    assert y == pytest.approx(np.array([[0.25, 0.4]]))


def test_two_constraints_meet_in_their_corner():
    feasible, y, _ = solved([(1.0, 1.0)], [one(np.pi, -0.25), one(-np.pi / 2, -0.5)])
    assert feasible
    assert y == pytest.approx(np.array([[0.25, 0.5]]))


def test_a_constraint_of_two_robots_is_shared_in_equal_parts():
    feasible, y, _ = solved([(1.0, 0.0), (-1.0, 0.0)], [pair(0, 1, np.pi, np.pi, -0.5)])
    assert feasible
    assert y == pytest.approx(np.array([[0.25, 0.0], [-0.25, 0.0]]))


def test_a_contradiction_is_shared_in_equal_parts_and_leaves_other_constraints_whole():
    rows = [one(0.0, 0.5), one(np.pi, 0.1), one(0.0, 1.0, robot=1)]
    feasible, y, spaces = solved([(0.0, 0.0), (0.0, 0.0)], rows)
    assert not feasible
    assert y == pytest.approx(np.array([[0.2, 0.0], [1.0, 0.0]]), abs=1e-6)
    assert spaces.shortfalls[8:] == pytest.approx([0.3, 0.3, 0.0], abs=1e-6)


def test_limits_are_never_exceeded():
    feasible, y, spaces = solved([(0.0, 0.7)], [one(0.0, 3.0)])
    assert not feasible
    assert y == pytest.approx(np.array([[2.0, 0.7]]), abs=1e-6)
    assert spaces.shortfalls[-1] == pytest.approx(1.0, abs=1e-6)


def test_what_is_not_a_number_is_passed_on():
    feasible, y, _ = solved([(np.nan, 0.7)], [one(0.0, 1.0)])
    assert feasible
    assert np.isnan(y[0, 0])


@settings(max_examples=examples(600))
@given(st.tuples(velocities, velocities, velocities), rows)
def test_it_is_feasible_where_a_linear_program_is(wanted, rows):
    feasible, y, spaces = solved(wanted, rows)
    a = matrix(spaces, 3)
    # the least largest violation of the constraints that are not limits
    slack = np.where(np.arange(len(a)) < 12, 0.0, -1.0)[:, None]
    least = linprog(
        [*[0.0] * 6, 1.0], A_ub=np.hstack([-a, slack]), b_ub=-spaces.bounds, bounds=[*[(None, None)] * 6, (0.0, None)]
    )
    assert least.status == 0
    if feasible:
        assert least.fun <= 1e-7
        assert (a @ y.ravel() >= spaces.bounds - 1e-7).all()
    else:
        assert least.fun >= -1e-9
        assert spaces.shortfalls.max() > 0.0
        assert (spaces.shortfalls[:12] == 0.0).all()
        assert (a @ y.ravel() >= spaces.bounds - spaces.shortfalls - 1e-7).all()
    if least.fun > 1e-6:
        assert not feasible


@settings(max_examples=examples(300))
@given(st.tuples(velocities, velocities, velocities), rows)
def test_the_solution_is_the_nearest_one(wanted, rows):
    feasible, y, spaces = solved(wanted, rows)
    if not feasible:
        return
    a, w = matrix(spaces, 3), np.array(wanted).ravel()
    # optimality: y - wanted is a sum of normals of constraints that hold with equality, with factors >= 0
    tight = a[a @ y.ravel() - spaces.bounds <= 1e-6]
    step = y.ravel() - w
    if not len(tight):
        assert np.abs(step).max() <= 1e-9
        return
    fit = minimize(
        lambda m: 0.5 * np.sum((tight.T @ m - step) ** 2), np.zeros(len(tight)),
        jac=lambda m: tight @ (tight.T @ m - step),
        bounds=[(0.0, None)] * len(tight), method="L-BFGS-B", options={"ftol": 1e-18, "gtol": 1e-12, "maxiter": 2000},
    )  # fmt: skip
    assert fit.fun <= 1e-8
