"""Files of signals that `dwmr run` writes, read back by `dwmr.load`."""

import dataclasses
import time

import numpy as np
import pytest
from pyarrow import parquet

from dwmr import load, measure
from tests.dwmr.process import here
from tests.dwmr.scenarios import PAPER, by_hand, edited

FORMATS = ("npz", "csv", "mat", "parquet")
#: Text that needs escapes in some format.
TEXT = "θ = 'σ*' # \"\\"


def equal(first, second):
    """Whether two arrays are the same bit for bit; which NaN it is does not matter."""
    return first.shape == second.shape and np.array_equal(
        np.where(np.isnan(first), 0.0, first).view(np.int64), np.where(np.isnan(second), 0.0, second).view(np.int64)
    )


def require_same(first, second):
    assert list(first.runs) == list(second.runs)
    for law, run in first.runs.items():
        assert list(run) == list(second.runs[law])
        for name, array in run.items():
            other = second.runs[law][name]
            assert np.array_equal(np.isnan(array), np.isnan(other)), (law, name)
            assert equal(array, other), (law, name)
    assert first.metadata == second.metadata


def written(folder, laws, *overrides, scenario="paper", formats=FORMATS):
    """Write the signals of runs in some formats."""
    options = [word for one in overrides for word in ("--set", one)]
    here("run", scenario, "--controller", laws, *options, "--data", ",".join(formats), "-o", folder)
    return folder


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    """The folder of a run of two laws with signals of their own."""
    folder = tmp_path_factory.mktemp("data")
    scenario = edited(PAPER, folder / "ö.toml", ("# ", f"# {TEXT}\n# "))
    return written(folder, "aifqsmc,smc", "run.horizon=3", scenario=scenario)


@pytest.mark.parametrize(("every", "count"), [(1, 601), (7, 87), (10_000, 2)])
def test_the_first_and_the_last_sample_are_always_kept(run_paper, recorded, tmp_path, every, count):
    run = run_paper("smc", "run.horizon=3")[1]
    recorded(run)
    folder = written(tmp_path, "smc", "run.horizon=3", f"run.save_every={every}", formats=["npz"])
    kept = load(folder / "trajectory.npz").runs["smc"]
    assert kept["t"].shape == (count,)
    assert (kept["t"][0], kept["t"][-1]) == (0.0, 3.0)
    assert np.array_equal(kept["x"][-1], run["x"][-1])
    assert kept["V_10"].shape == (count, 3)


@pytest.mark.parametrize("name", FORMATS)
class TestEveryFormat:
    def test_gives_back_a_run_bit_for_bit(self, real, run_paper, name):
        found = load(real / f"trajectory.{name}")
        require_same(load(real / "trajectory.npz"), found)
        for law in ("aifqsmc", "smc"):
            run = run_paper(law, "run.horizon=3")[1]
            assert all(equal(found.runs[law][signal], run[signal][::4]) for signal in run.names)
        assert TEXT in found.metadata["scenario"]["text"][0]["text"]

    def test_has_units_and_the_robots(self, real, name):
        found = load(real / f"trajectory.{name}")
        assert found.robots == ("leader", "follower1", "follower2")
        assert found.metadata["signals"]["sigma_omega"]["unit"] == "rad"
        assert "k_h_v" not in found.runs["smc"]

    def test_holds_the_lyapunov_functions_of_the_whole_run(self, real, run_paper, name):
        found = load(real / f"trajectory.{name}")
        file, run = run_paper("aifqsmc", "run.horizon=3")
        assert found.metadata["signals"]["V_dot_10"]["unit"] == "(m² + rad²)/s"
        assert "V_23" in found.runs["aifqsmc"]
        assert "V_23" not in found.runs["smc"]
        kept = found.runs["aifqsmc"]
        assert kept["V_10"] == pytest.approx(0.5 * (kept["surface_v"] ** 2 + kept["surface_omega"] ** 2))
        shares = measure(run, file.scenario, ["lyapunov"])["lyapunov"]
        for i, robot in enumerate(found.robots):
            assert np.mean(kept["V_dot_10"][:, i] > 0.0) == pytest.approx(shares[robot]["V_dot_10_positive"], abs=0.02)

    def test_refuses_a_file_that_is_no_run(self, tmp_path, name):
        path = tmp_path / f"run.{name}"
        for content in (b"", b"x", b"a,b\n1,2\n", bytes(range(256)) * 4):
            path.write_bytes(content)
            with pytest.raises(ValueError, match="does not hold"):
                load(path)


def test_any_number_is_kept_in_the_same_bytes_each_time(recorded, tmp_path, monkeypatch):
    bits = np.random.default_rng(0).integers(0, 2**64, (400, 3), dtype=np.uint64)
    numbers = bits.view(np.float64)
    numbers[:8, 0] = [0.0, -0.0, np.inf, -np.inf, np.nan, 5e-324, np.finfo(float).max, 2.0**53 + 1.0]
    recorded(by_hand(samples=400, sigma_v=0.0, sigma_omega=0.0, odd=numbers))
    first = written(tmp_path / "a", "smc", "run.save_every=1")
    monkeypatch.setattr(time, "asctime", lambda *_: "another day")
    second = written(tmp_path / "b", "smc", "run.save_every=1")
    for name in FORMATS:
        assert equal(load(first / f"trajectory.{name}").runs["smc"]["odd"], numbers)
        assert (first / f"trajectory.{name}").read_bytes() == (second / f"trajectory.{name}").read_bytes()


class TestSignals:
    def found(self, run, recorded, folder):
        recorded(run)
        return load(written(folder, "smc", "run.horizon=3", formats=["npz"]) / "trajectory.npz")

    def test_of_a_law_with_a_signal_of_the_same_name_keep_its_own(self, run_paper, recorded, tmp_path):
        run = run_paper("smc", "run.horizon=3")[1]
        own = run.law_signals[-1]._replace(name="V_10", doc="its own")
        found = self.found(dataclasses.replace(run, law_signals=(*run.law_signals[:-1], own)), recorded, tmp_path)
        assert equal(found.runs["smc"]["V_10"], run.law_values[::4, :, -1])
        assert found.metadata["signals"]["V_10"]["doc"] == "its own"

    def test_of_an_unknown_law_have_no_lyapunov_functions(self, run_paper, recorded, tmp_path):
        run = run_paper("smc", "run.horizon=3")[1]
        plain = dataclasses.replace(run, law_values=run.law_values[:, :, :0], law_signals=())
        found = self.found(plain, recorded, tmp_path)
        assert set(found.signals()) == set(plain.names)


class TestLoad:
    def test_names_the_formats_it_knows(self, tmp_path):
        with pytest.raises(ValueError, match="npz, csv, mat, parquet"):
            load(tmp_path / "run.xlsx")

    def test_refuses_a_table_that_another_program_wrote(self, real, tmp_path):
        table = parquet.read_table(real / "trajectory.parquet").replace_schema_metadata({"other": "{}"})
        parquet.write_table(table, tmp_path / "run.parquet")
        with pytest.raises(ValueError, match="does not hold the signals of runs: it has no metadata of dwmr"):
            load(tmp_path / "run.parquet")

    def test_leaves_a_missing_file_to_the_operating_system(self, tmp_path):
        for name in FORMATS:
            with pytest.raises(FileNotFoundError):
                load(tmp_path / f"run.{name}")
