"""Drawn controllers with every operator: backends and targets make the same steps; none writes to what it is given."""

import shutil

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fuzzyctl
from tests.fuzzyctl.codegen.conftest import SANITIZED, written
from tests.fuzzyctl.codegen.steps.targets import (
    by_c,
    by_integers,
    by_javascript,
    by_kernel,
    by_python,
    by_structured_text,
    rows_for,
    unit_of,
)
from tests.properties.running import quick

RULE = """system rule
and product
defuzzifier center_average
input e in [-2, 2]
  terms N Z P
input d in [-2, 2]
  terms N Z P
output u in [-1, 1]
  terms N@-1 Z@0 P@1
table u = e x d
     N Z P
  N | N N Z
  Z | N Z P
  P | Z P P
"""

#: Forms of equations over values a and b that are computed before.
FORMS = (
    "{a} + 0.5 * {b}",
    "{a} * {b}",
    "{a} / (1 + abs({b}))",
    "where({a} > {b}, {b}, -{a})",
    "where({a} > 0 and not {b} < 0.5 or {b} == {a}, 1, {b})",
    "clamp({a}, -1, abs({b}))",
    "rule({a}, {b})",
    "rule(d={a}, e=0.5)",
    "twice({a}) - {b}",
    "previous({a}, start=0.25)",
    "difference({a})",
    "derivative({a}, filter=0.5 s)",
    "integral({a}, hold={b} > 1)",
    "lowpass({a}, 0.3)",
    "rate_limit({a}, 2)",
    "hysteresis({a}, -0.2, 0.2)",
    "delay({a}, 3)",
    "limit.y + {a}",
    "k + {a}",
    "where({c}, {a}, {b})",
    "where(not {c} or {a} == {b}, {b}, -{a})",
    "integral({a}, hold={c})",
    "{c} - {a}",
)
#: Forms of conditions, over another one as well.
CONDITIONS = (
    "{a} > {b}",
    "{a} in [-0.5, {b})",
    "not {c}",
    "{c} and {a} < 1",
    "{c} or inside({b})",
    "inside({a})",
    "limit.held",
    "hysteresis({a}, -0.2, 0.2)",
    "ge({a}, {b}) or {c}",
)


@st.composite
def controllers(draw):
    """Draw the text of a controller of two inputs; the order of its lines is drawn, too."""
    names, conditions = ["x", "y"], ["near", "inside(x)"]
    lines = ["input x", "input y", "param k in [0, 1] = 0.5", "block limit = inner(x, k=2)", "let near = x in [-1, y]"]
    for number in range(draw(st.integers(2, 10))):
        a, b = draw(st.sampled_from(names)), draw(st.sampled_from(names))
        if draw(st.booleans()):
            c = draw(st.sampled_from(conditions))
            lines.append(f"let c{number} = {draw(st.sampled_from(CONDITIONS)).format(a=a, b=b, c=c)}")
            conditions.append(f"c{number}")
        c = draw(st.sampled_from(conditions))
        lines.append(f"let v{number} = {draw(st.sampled_from(FORMS)).format(a=a, b=b, c=c)}")
        names.append(f"v{number}")
    lines += [f"state s = 1\nnext s = 0.9 * s + 0.1 * {draw(st.sampled_from(names))}", f"output z = {names[-1]} + s"]
    lines += [f"output w = {draw(st.sampled_from(names))}"]
    inner = "controller inner\ninput x\nparam k = 1\nlet y = clamp(k * previous(x), -1, 1)\noutput o = y\n"
    inner += "output held = y > 0.1\n"
    head = (
        "function twice(a) = a + a\nfunction inside(a) = a > -0.5 and a < 1\n"
        + RULE
        + inner.replace("let y", "let m").replace("output o = y", "output y = m")
    )
    return head + "controller drawn\n" + "\n".join(draw(st.permutations(lines))) + "\n"


def step_of(text, backend):
    return fuzzyctl.compile(fuzzyctl.loads(text, block="drawn"), backend)


def require_equal(text, backends):
    rows = np.random.default_rng(len(text)).uniform(-2, 2, (40, 2))
    rows[20, 1] = np.nan
    first, *others = (step_of(text, backend).run(rows, dt=0.05) for backend in backends)
    assert np.isnan(first[0][20]).all()
    assert np.isfinite(np.delete(first[0], 20, axis=0)).all()
    for other in others:
        for found, expected in zip(other, first, strict=True):
            np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


@given(controllers())
@quick(60)
def test_numpy_makes_the_steps_of_generated_python(text):
    steps = [step_of(text, backend) for backend in ("python", "numpy")]
    states = [np.tile(step.start(), (3, 1)) for step in steps]
    for row in np.random.default_rng(1).uniform(-2, 2, (15, 3, 2)):
        found = [step.batch(row, state, dt=0.05) for step, state in zip(steps, states, strict=True)]
        np.testing.assert_allclose(found[1][0], found[0][0], rtol=1e-12, atol=1e-12)
        states = [state for _, state in found]
    require_equal(text, ["python", "numpy"])


@given(controllers())
@quick(15)
def test_derivatives_are_those_of_differences_and_alike_on_backends(text):
    step, other = (step_of(text, backend) for backend in ("python", "numpy"))
    rows = np.random.default_rng(len(text)).uniform(-2, 2, (8, 2))
    _, state = step.run(rows, dt=0.05)
    point = np.concatenate([rows[3], state])
    outputs, after = step.gradient(point[:2], point[2:], dt=0.05, by="all")
    found = np.concatenate([outputs, after])
    for own, same in zip(other.gradient(point[:2], point[2:], dt=0.05, by="all"), (outputs, after), strict=True):
        np.testing.assert_allclose(own, same, rtol=1e-12, atol=1e-12)

    def results(at):
        made, following = step(*at[:2], at[2:], dt=0.05)
        return np.concatenate([made, following])

    for k in range(len(point)):
        sides = [s * (results(point + s * 1e-6 * np.eye(len(point))[k]) - results(point)) / 1e-6 for s in (1.0, -1.0)]
        # At a kink or a jump the sides differ.
        smooth = np.abs(sides[0] - sides[1]) <= 1e-3 * (1.0 + np.abs(sides[0]))
        np.testing.assert_allclose(found[smooth, k], sides[0][smooth], rtol=2e-3, atol=2e-3)


@pytest.mark.long
@given(controllers())
@quick(20)
def test_compiled_steps_are_those_of_generated_python(text):
    require_equal(text, ["python", "numba"])


@given(controllers())
@quick(60)
def test_the_module_and_the_function_block_make_the_steps_of_the_kernel(text):
    rows = rows_for(unit_of(text), 60, seed=len(text))
    expected = by_kernel(text, rows)
    for found in (by_python(unit_of(text, "python"), rows), by_structured_text(unit_of(text, "st"), rows)):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def require_equal_in_c(texts, count, folder):
    """Compile all controllers into one program, each under a name of its own."""
    texts = [t.replace("controller drawn", f"controller drawn{k}") for k, t in enumerate(texts)]
    units = [unit_of(t) for t in texts]
    rows = [rows_for(u, count, seed=k) for k, u in enumerate(units)]
    for text, own, found in zip(texts, rows, by_c(units, rows, folder, SANITIZED), strict=True):
        np.testing.assert_allclose(found, by_kernel(text, own), rtol=1e-12, atol=1e-12)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
@given(st.lists(controllers(), min_size=12, max_size=12))
@quick(1)
def test_c_makes_the_steps_of_the_kernel(tmp_path_factory, texts):
    require_equal_in_c(texts, 100, tmp_path_factory.mktemp("c"))


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
@given(st.lists(controllers(), min_size=20, max_size=20))
@quick(4, 1)
def test_javascript_makes_the_steps_of_the_kernel(tmp_path_factory, texts):
    units = [unit_of(text, "javascript") for text in texts]
    rows = [rows_for(unit, 100, seed=k) for k, unit in enumerate(units)]
    made = by_javascript(units, rows, tmp_path_factory.mktemp("javascript"))
    for text, own, found in zip(texts, rows, made, strict=True):
        np.testing.assert_allclose(found, by_kernel(text, own), rtol=1e-12, atol=1e-12)


#: Forms of equations that fixed point has.
FIXED_FORMS = (
    "{a} + 0.5 * {b}",
    "0.3 * {a} * {b}",
    "max({a}, -{b}) / 3",
    "abs({a})",
    "clamp({a}, -1, abs({b}))",
    "where({a} > {b}, {b}, -{a})",
    "where({a} > 0.1 and not {b} < 0.5 or {b} == {a}, 1, {b})",
    "where(near, {a}, -{b})",
    "where(not near or hysteresis(y, -0.2, 0.2), {a}, near)",
    "rule({a}, {b})",
    "rule(d={a}, e=0.5)",
    "previous({a}, start=0.25)",
    "difference({a})",
    "0.1 * derivative({a}, filter=0.5 s)",
    "lowpass({a}, 0.3)",
    "delay({a}, 5)",
    "hysteresis({a}, -0.2, 0.2)",
    "{a}^2 / 4",
)


@st.composite
def fixed_steps(draw):
    """Draw a controller and a format of its fixed-point step."""
    names, lines = ["x", "y"], ["input x in [-2, 2]", "input y in [-1, 1.5]", "let near = x > 0.25 and y <= 1"]
    for number in range(draw(st.integers(2, 7))):
        a, b = draw(st.sampled_from(names)), draw(st.sampled_from(names))
        lines.append(f"let v{number} = {draw(st.sampled_from(FIXED_FORMS)).format(a=a, b=b)}")
        names.append(f"v{number}")
    lines += [f"state s = 1\nnext s = 0.9 * s + 0.1 * {draw(st.sampled_from(names))}"]
    lines += [f"output z = {names[-1]} + s", f"output w = {draw(st.sampled_from(names))}", "every 50 ms"]
    return RULE + "controller drawn\n" + "\n".join(lines) + "\n", draw(st.sampled_from(["Q8.7", "Q10.21"]))


def require_bounds_in_c(drawn, count, folder):
    """Compare integers with the kernel in double precision, over sequences with every integer that inputs may have.

    Return how many controllers have a proved bound; only those are written.
    """
    texts = [t.replace("controller drawn", f"controller drawn{k}") for k, (t, _) in enumerate(drawn)]
    steps = [written(t, "c", "--block", f"drawn{k}", "--fixed", drawn[k][1]) for k, t in enumerate(texts)]
    kept = [k for k, step in enumerate(steps) if step.code == 0]
    ones = [1 << int(drawn[k][1].split(".")[1]) for k in kept]
    inputs = [[(-2 * one, 2 * one), (-one, one * 3 // 2)] for one in ones]
    rows = []
    for k, own in enumerate(inputs):
        rng = np.random.default_rng(k)
        drawn_rows = np.column_stack([rng.integers(low - 5, high + 5, count) for low, high in own])
        rows.append(np.where(rng.random(drawn_rows.shape) < 0.5, np.repeat(drawn_rows[::50], 50, axis=0), drawn_rows))
    results = by_integers([steps[k].files for k in kept], rows, folder, SANITIZED)
    for k, one, ends, own, found in zip(kept, ones, inputs, rows, results, strict=True):
        exact = by_kernel(texts[k], np.clip(own, *np.transpose(ends)) / one)
        errors = [steps[k].data["errors"][name] for name in ("z", "w")]
        assert np.all(np.abs(found / one - exact).max(axis=0) <= errors)
    return len(kept)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
@given(st.lists(fixed_steps(), min_size=6, max_size=6))
@quick(1)
def test_fixed_point_in_c_keeps_its_bounds(tmp_path_factory, drawn):
    require_bounds_in_c(drawn, 500, tmp_path_factory.mktemp("fixed"))


@pytest.mark.long
@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
@given(st.lists(fixed_steps(), min_size=40, max_size=40))
@quick(2)
def test_fixed_point_in_c_keeps_its_bounds_over_10_000_steps(tmp_path_factory, drawn):
    assert require_bounds_in_c(drawn, 10_000, tmp_path_factory.mktemp("fixed")) > 20


@pytest.mark.long
@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
@given(st.lists(controllers(), min_size=25, max_size=25))
@quick(4)
def test_c_makes_10_000_steps_of_the_kernel(tmp_path_factory, texts):
    require_equal_in_c(texts, 10_000, tmp_path_factory.mktemp("c"))
