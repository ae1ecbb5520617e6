"""Every shipped rule file is clean, laid out, documented, compiles everywhere, and keeps what its header promises."""

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl.testing import check_text, run_command
from tests.shipped import LAWS, SYSTEMS
from tests.tipper import POINTS, TIPS

#: A controller as papers print it.
PAPER = """\
system pd "Fuzzy PD"
defuzzifier center_average
input e in [-1, 1]
  terms NB NM NS ZO PS PM PB
input de in [-1, 1]
  terms NB NM NS ZO PS PM PB
output u in [-1, 1]
  terms NB NM NS ZO PS PM PB
table u = e x de
     NB NM NS ZO PS PM PB
NB | NB NB NB NB NM NS ZO
NM | NB NB NB NM NS ZO PS
NS | NB NB NM NS ZO PS PM
ZO | NB NM NS ZO PS PM PB
PS | NM NS ZO PS PM PB PB
PM | NS ZO PS PM PB PB PB
PB | ZO PS PM PB PB PB PB
"""


@pytest.mark.parametrize("path", SYSTEMS + LAWS, ids=lambda p: p.name)
class TestEveryFile:
    def test_it_is_clean_and_laid_out(self, path):
        blocks, diagnostics = check_text(path.read_text(encoding="utf-8"), str(path), folder=path.parent)
        assert blocks
        assert diagnostics == []
        assert run_command("fmt", "--check", path).exit_code == 0

    def test_its_header_names_purpose_units_source_and_guarantee(self, path):
        text = path.read_text(encoding="utf-8")
        for word in ("# Purpose:", "# Units:", "# Guarantee:", "source "):
            assert word in text


@pytest.mark.parametrize("path", LAWS, ids=lambda p: p.name)
class TestEveryLaw:
    def test_it_is_named_like_its_last_controller(self, path):
        blocks, _ = check_text(path.read_text(encoding="utf-8"), str(path), folder=path.parent)
        assert [b.name for b in blocks if b.kind == "controller"][-1] == path.stem

    def test_what_it_requires_is_proved(self, path):
        verdicts = fuzzyctl.prove(fuzzyctl.load(path, block=path.stem))
        assert [type(v) for v in verdicts] == [fuzzyctl.Proved] * len(verdicts)


@pytest.mark.parametrize("path", SYSTEMS, ids=lambda p: p.name)
class TestEverySystem:
    def test_it_is_named_like_its_system(self, path):
        assert fuzzyctl.load(path).name == path.stem

    def test_all_backends_agree(self, path):
        system = fuzzyctl.load(path)
        low = np.array([system.number(v.lower) for v in system.inputs])
        high = np.array([system.number(v.upper) for v in system.inputs])
        # A tenth beyond the range on each side, so that clamping is compared too.
        points = np.random.default_rng(1).uniform(low - 0.1 * (high - low), high + 0.1 * (high - low), (200, len(low)))
        results = []
        for backend in ("numpy", "numba"):
            kernel = fuzzyctl.compile(system, backend=backend)
            state = np.linspace(-1, 1, kernel.n_states) if kernel.n_states else None
            results.append(kernel.batch(points, state))
        np.testing.assert_allclose(results[1], results[0], rtol=1e-12, atol=1e-14)

    def test_its_output_lies_in_its_proved_bounds_and_range(self, path):
        system = fuzzyctl.load(path)
        for name, bound in fuzzyctl.output_bounds(system).items():
            output = system.output(name)
            slack = 1e-9 * (system.number(output.upper) - system.number(output.lower))
            assert system.number(output.lower) - slack <= bound.lo <= bound.hi <= system.number(output.upper) + slack


def test_the_immune_reaction_is_as_the_paper_prints_it():
    system = fuzzyctl.load("ais_reaction")
    sigma = {"NB": -0.03, "NS": -0.015, "ZO": 0.0, "PS": 0.015, "PB": 0.03}
    dsigma = {"NB": -0.5, "NS": -0.25, "ZO": 0.0, "PS": 0.25, "PB": 0.5}
    peak = {"NB": -1.0, "NM": -0.66, "NS": -0.33, "ZO": 0.0, "PS": 0.09, "PM": 0.18}
    # Table 2, row by row: σ* down, dσ*/dt across.
    table = {
        "NB": "NB NM NM NS NS",
        "NS": "NM NS ZO PS ZO",
        "ZO": "ZO PS PM PS ZO",
        "PS": "ZO PS ZO NS NM",
        "PB": "NS NS NM NM NB",
    }
    for row, cells in table.items():
        for column, cell in zip(dsigma, cells.split(), strict=True):
            assert system(sigma=sigma[row], dsigma=dsigma[column]) == pytest.approx(peak[cell], abs=1e-15)


def test_the_immune_reaction_is_the_same_in_both_semi_cycles():
    system = fuzzyctl.load("ais_reaction")
    points = np.random.default_rng(2).uniform([-0.06, -1], [0.06, 1], (500, 2))
    f = system(sigma=points[:, 0], dsigma=points[:, 1])
    np.testing.assert_allclose(system(sigma=-points[:, 0], dsigma=-points[:, 1]), f, atol=1e-12)


def test_many_antigens_contain_the_suppression():
    system = fuzzyctl.load("ais_reaction")
    f = system(sigma=np.array([-0.06, -0.03, 0.03, 0.06])[:, None], dsigma=np.linspace(-1, 1, 401))
    assert np.all(f <= 0)


def test_the_boundary_layer_gets_thinner_away_from_the_surface():
    system = fuzzyctl.load("boundary_layer")
    beta = system(abs_sigma=np.linspace(0, 0.06, 1001))
    assert (beta[0], beta[-1]) == (0.05, 0.005)
    assert np.all(np.diff(beta) <= 1e-17)


def test_the_boundary_layer_as_printed_has_a_hole_at_zero(tmp_path):
    text = (SYSTEMS[0].parent / "boundary_layer.fz").read_text(encoding="utf-8")
    printed = text.replace("VS = triangle(-inf, 0.0050, 0.0162)", "VS = triangle(1e-6, 0.0050, 0.0162)")
    assert printed != text
    path = tmp_path / "printed.fz"
    path.write_text(printed, encoding="utf-8")
    _, diagnostics = fuzzyctl.check(path)
    assert [d.code for d in diagnostics] == ["FZ401"]
    assert "1e-06" in diagnostics[0].message + "".join(diagnostics[0].facts)


def test_the_adaptive_partition_has_seven_equal_steps():
    system = fuzzyctl.load("fcafsmc")
    peaks = [system.number(t.membership.arguments[1]) for t in system.input("sigma").terms]
    np.testing.assert_allclose(np.diff(peaks), 0.8 / 6, rtol=1e-14)


@pytest.mark.parametrize(("point", "tip"), [*zip(POINTS, TIPS["exact"], strict=True)])
def test_the_tip_is_the_exact_centroid(point, tip):
    assert fuzzyctl.load("tipper")(service=point[0], food=point[1]) == pytest.approx(tip, abs=6e-11)


def test_a_controller_of_seven_by_seven_takes_at_most_600_bytes():
    assert len(PAPER.encode()) <= 600
    system = fuzzyctl.loads(PAPER)
    assert (len(system.rules), system(e=1.0, de=1.0)) == (49, 1.0)
