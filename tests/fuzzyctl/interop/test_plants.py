"""Systems of python-control and scipy, and functions, in the place of a plant: the numbers of the plant in text."""

import control
import numpy as np
import pytest
import scipy.signal

import fuzzyctl
from fuzzyctl import ArgumentError, DiagnosticError, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.interop.plants import plant_of, python_plant, with_plant
from fuzzyctl.interop.scipy import rhs

TRANSFER = control.tf([3, 1], [1, 2, 5])
MATRICES = ([[-1.0, 0.5], [0.2, -2.0]], [[1.0, 0.0], [0.3, 1.0]], [[1.0, 1.0], [0.0, 2.0]], [[0.0, 0.0], [0.0, 0.0]])
SISO = ([[-1.0, 0.5], [0.2, -2.0]], [[1.0], [0.3]], [[1.0, 1.0]], [[0.0]])


def output(loop):
    return fuzzyctl.simulate(loop, backend="python")["p.y"]


class TestLinear:
    @pytest.mark.parametrize(
        "system",
        [
            TRANSFER, control.ss(TRANSFER),
            scipy.signal.lti([3, 1], [1, 2, 5]), scipy.signal.lti([3, 1], [1, 2, 5]).to_ss(),
            scipy.signal.lti([-1 / 3], [-1 + 2j, -1 - 2j], 3.0),
        ],
        ids=["control.tf", "control.ss", "scipy.tf", "scipy.ss", "scipy.zpk"],
    )  # fmt: skip
    def test_agrees_with_the_text(self, small, system):
        text = output(small())
        assert np.abs(text).max() > 0.1
        np.testing.assert_allclose(output(with_plant(small("tf(num=[1], den=[1, 1])"), "p", system)), text, atol=1e-12)

    def test_matrices_of_several_signals_are_those_of_the_text(self):
        a, b, c, d = MATRICES
        plant = plant_of(control.ss(a, b, c, d), "two")
        assert [s.name for s in plant.inputs + plant.results] == ["u1", "u2", "y1", "y2"]
        assert fuzzyctl.dumps(plant).count("der") == 2
        assert plant == plant_of(scipy.signal.StateSpace(a, b, c, d), "two")

    def test_a_system_in_discrete_time_is_held_between_its_samples(self, small):
        a, b, c, d = (np.array(m) for m in SISO)
        held = scipy.signal.cont2discrete((a, b, c, d), 0.05)
        continuous = output(small(f"ss(A={a.tolist()}, B={b.tolist()}, C={c.tolist()}, D=[0])"))
        base = small("tf(num=[1], den=[1, 1])")
        for system in (scipy.signal.dlti(*held[:4], dt=0.05), control.ss(*held[:4], 0.05)):
            found = output(with_plant(base, "p", system))
            np.testing.assert_allclose(found[::5], continuous[::5], atol=1e-9)
            assert np.unique(found[:5]).size == 1

    def test_signals_keep_names_units_and_ranges_of_the_plant(self, tank):
        loop = with_plant(tank("1 s step 10 ms"), "tank", control.tf([1], [10, 1]))
        (plant,) = loop.plants
        old = tank().plants[0]
        assert (plant.inputs[0].name, plant.inputs[0].unit, plant.results[0].label) == ("v", "V", "level")
        assert plant.inputs[0].bounds == old.inputs[0].bounds
        assert "tank.y" in fuzzyctl.simulate(loop).names

    @pytest.mark.parametrize(
        ("system", "words"),
        [
            (3, "expected a system of python-control or an lti or dlti of scipy.signal, got int"),
            (control.tf([1], [1, 1], True), "discrete time without a sample time"),
            (control.ss([], [], [], [[1]]), "has no states"),
            (control.ss(*MATRICES), r"block 'p' has 1 input \(u\), the StateSpace 2"),
            (control.tf([[[1], [2]]], [[[1, 1], [1, 1]]]), "has 2 inputs and 1 outputs: convert it with control.ss"),
        ],
    )
    def test_what_cannot_be_a_plant_is_refused(self, small, system, words):
        with pytest.raises(ArgumentError, match=words):
            with_plant(small(), "p", system)

    @pytest.mark.parametrize(
        ("system", "words"),
        [
            (scipy.signal.lti([], [-1 + 1j], 1), "a complex one has no conjugate"),
            (scipy.signal.lti([], [-1 - 1j, -2], 1), "a complex one has no conjugate"),
            (scipy.signal.lti([], [-1 + 1j, -1.1 - 1j], 1), "a complex one has no conjugate"),
            (scipy.signal.lti([1j], [1, 1]), "numerator must be real"),
            (scipy.signal.lti([[1j]], [[1]], [[1]], [[0]]), "matrix A must be real"),
            (scipy.signal.lti([], [-1], 1j), "gain must be real"),
            (scipy.signal.lti([], [np.inf], 1), "roots must be finite"),
            (control.tf([np.nan], [1, 1]), "numerator must be finite"),
            (control.ss([[np.inf]], [[1]], [[1]], [[0]], 0.1), "matrix A must be finite"),
            (control.tf([0], [1, 1]), "the numerator of the TransferFunction is 0"),
            (control.tf([1, 0, 0], [1, 1], 0.1), "has no state space: .*proper"),
            (scipy.signal.dlti([1, 0, 0], [1, 1], dt=0.1), "has no state space: Improper"),
        ],
    )
    def test_coefficients_that_no_plant_has_are_refused(self, system, words):
        with pytest.raises((ArgumentError, ValueOutOfBoundsError), match=words):
            plant_of(system)

    def test_pairs_of_roots_keep_their_poles(self):
        poles = [-1 + 2j, -3, -1 - 2j, -1 + 1j, -1 - 1j]
        plant = plant_of(scipy.signal.lti([], poles, 5.0))
        matrix = np.column_stack([rhs(plant, 0.0)(0.0, column) for column in np.eye(5)])
        np.testing.assert_allclose(np.poly(np.linalg.eigvals(matrix)), np.poly(poles), rtol=1e-9)

    @pytest.mark.parametrize("dt", [0, 0.1])
    def test_a_name_is_one_word(self, dt):
        with pytest.raises(ArgumentError, match="is not a name"):
            plant_of(control.tf([1], [1, 1], dt), "a\ninput b")

    def test_what_is_not_proper_is_a_diagnostic(self, small):
        with pytest.raises(DiagnosticError, match="FZ221"):
            with_plant(small(), "p", control.tf([1, 0, 0], [1, 1]))

    def test_only_plants_are_replaced(self, small):
        with pytest.raises(ArgumentError, match="is not a plant"):
            with_plant(small(), "law", TRANSFER)
        with pytest.raises(UnknownNameError, match="no block 'q'"):
            with_plant(small(), "q", TRANSFER)


class TestFunctions:
    @staticmethod
    def system(derivative=None, output=None):
        return control.NonlinearIOSystem(
            derivative or (lambda t, x, u, p: [x[1], u[0] - 5 * x[0] - 2 * x[1]]),
            output or (lambda t, x, u, p: [x[0] + 3 * x[1]]),
            inputs=1, outputs=1, states=2,
        )  # fmt: skip

    def test_agree_with_the_text(self, small):
        text = output(small())
        np.testing.assert_allclose(output(with_plant(small(), "p", self.system())), text, atol=1e-12)
        plant = python_plant(
            "own", ["force"], {"a": 0.0, "b": 0.0}, ["place"],
            derivative=lambda t, x, u: (x[1], u[0] - 5 * x[0] - 2 * x[1]), output=lambda t, x: (x[0] + 3 * x[1],),
        )  # fmt: skip
        np.testing.assert_allclose(output(with_plant(small(), "p", plant)), text, atol=1e-12)
        with pytest.raises(ArgumentError, match="no rule file can hold"):
            fuzzyctl.dumps(plant)

    @pytest.mark.parametrize(
        ("value", "words"),
        [
            (lambda t: [1 / (t < 1), 0.0], "raised ZeroDivisionError at t = 1 s"),
            (lambda t: [float("nan") if t >= 1 else 0.0, 0.0], "returned array([nan,  0.]) at t = 1 s"),
            (lambda t: [0.0] * (2 if t < 1 else 3), "returned array([0., 0., 0.]) at t = 1 s"),
        ],
    )
    def test_a_mistake_ends_the_run_and_keeps_what_is_done(self, small, value, words):
        run = fuzzyctl.simulate(with_plant(small(), "p", self.system(lambda t, x, u, p: value(t))))
        assert run.stopped.code == "FZ704"
        assert words in run.stopped.message
        assert run.stopped.span.line == 13
        assert run.t[-1] == pytest.approx(1.0, abs=0.011)

    def test_a_function_with_other_arguments_is_no_line_of_the_engine(self, small):
        plant = python_plant("p", ("u",), {"x": 0.0}, ("y",), derivative=lambda x, u: (0.0,), output=lambda t, x: x)
        (fact, *_) = fuzzyctl.simulate(with_plant(small(), "p", plant)).stopped.facts
        assert "takes 2 positional arguments but 3 were given" in fact
        assert "python_plant.py" not in fact

    def test_outputs_that_depend_on_inputs_are_reported(self, small):
        run = fuzzyctl.simulate(with_plant(small(), "p", self.system(output=lambda t, x, u, p: [x[0] + u[0]])))
        assert "depend on the inputs of the same instant" in run.stopped.facts[0]

    @pytest.mark.parametrize(
        ("inputs", "states"),
        [(["a b"], ["x"]), (["x"], ["x"]), (["é"], ["x"]), (["u", "u"], ["x"]), (["u"], ["y"])],
    )
    def test_names_are_those_of_signals(self, inputs, states):
        with pytest.raises(ArgumentError, match=r"is not a name|'.' names two of the inputs, states and outputs"):
            python_plant("p", inputs, dict.fromkeys(states, 0.0), ["y"], derivative=max, output=max)

    @pytest.mark.parametrize("start", [float("nan"), "a", None, [1.0]])
    def test_starts_are_finite_numbers(self, start):
        with pytest.raises(ValueOutOfBoundsError, match="start of 'x' must be"):
            python_plant("p", ["u"], {"x": start}, ["y"], derivative=max, output=max)
