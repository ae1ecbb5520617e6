import dataclasses
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from dwmr.output import data
from dwmr.output.data import Data, save, signals_of
from dwmr.results.metrics import lyapunov
from dwmr.simulation.simulate import Signal


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
    assert json.loads(json.dumps(first.metadata)) == second.metadata


@pytest.fixture(scope="module")
def real(run_paper):
    """Two laws with signals of their own, as `dwmr run` saves them."""
    runs = [run_paper(law, "run.horizon=3") for law in ("aifqsmc", "smc")]
    about = {"scenario": {"text": [{"file": "ö.toml", "text": "θ = 'σ*' # \"\n\\"}]}, "load": 1.25}
    return signals_of([one for _, one in runs], runs[0][0].scenario, 4, about)


@pytest.mark.parametrize(("every", "count"), [(1, 601), (4, 151), (7, 87), (600, 2), (10_000, 2)])
def test_the_first_and_the_last_sample_are_always_kept(run_paper, every, count):
    file, run = run_paper("aifqsmc", "run.horizon=3")
    kept = signals_of([run], file.scenario, every, {}).runs["aifqsmc"]
    assert kept["t"].shape == (count,)
    assert (kept["t"][0], kept["t"][-1]) == (0.0, 3.0)
    assert np.array_equal(kept["x"][-1], run["x"][-1])
    assert kept["V_10"].shape == (count, 3)


@pytest.mark.parametrize("name", data.FORMATS)
class TestEveryFormat:
    def test_gives_back_a_run_bit_for_bit(self, real, tmp_path, name):
        save(tmp_path / f"run.{name}", real)
        require_same(real, data.load(tmp_path / f"run.{name}"))

    def test_has_units_and_the_robots(self, real, tmp_path, name):
        save(tmp_path / f"run.{name}", real)
        found = data.load(tmp_path / f"run.{name}")
        assert found.robots == ("leader", "follower1", "follower2")
        assert found.metadata["signals"]["sigma_omega"]["unit"] == "rad"
        assert "k_h_v" not in found.runs["smc"]

    def test_holds_the_lyapunov_functions_of_the_whole_run(self, real, run_paper, tmp_path, name):
        save(tmp_path / f"run.{name}", real)
        found = data.load(tmp_path / f"run.{name}")
        for law in ("aifqsmc", "smc"):
            file, trajectory = run_paper(law, "run.horizon=3")
            for signal, array in lyapunov.signals(trajectory, file.scenario).items():
                assert equal(found.runs[law][signal], array[::4]), (law, signal)
        assert found.metadata["signals"]["V_dot_10"]["unit"] == "(m² + rad²)/s"
        assert "V_23" in found.runs["aifqsmc"]
        assert "V_23" not in found.runs["smc"]

    def test_is_the_same_bytes_each_time(self, real, tmp_path, name, monkeypatch):
        import time

        save(tmp_path / f"a.{name}", real)
        monkeypatch.setattr(time, "asctime", lambda *_: "another day")
        save(tmp_path / f"b.{name}", real)
        assert (tmp_path / f"a.{name}").read_bytes() == (tmp_path / f"b.{name}").read_bytes()

    @given(
        hnp.arrays(np.float64, st.tuples(st.integers(1, 4), st.integers(1, 3)), elements=st.floats(width=64)),
        st.floats(0.0, 1e6),
    )
    def test_keeps_any_number(self, tmp_path_factory, name, values, first):
        count, robots = values.shape
        t = first + np.arange(count)
        one = Data({"smc": {"t": t, "x": values}}, {"robots": [f"r{k}" for k in range(robots)]})
        path = tmp_path_factory.mktemp("any") / f"run.{name}"
        save(path, one)
        require_same(one, data.load(path))

    @pytest.mark.parametrize("content", [b"", b"x", b"a,b\n1,2\n", bytes(range(256)) * 4])
    def test_refuses_what_is_no_run(self, tmp_path, name, content):
        path = tmp_path / f"run.{name}"
        path.write_bytes(content)
        with pytest.raises(data.UnreadableDataError, match="does not hold"):
            data.load(path)


class TestSignals:
    def test_of_a_law_with_a_signal_of_the_same_name_keep_its_own(self, run_paper):
        file, run = run_paper("smc", "run.horizon=3")
        own = dataclasses.replace(run, law_signals=(*run.law_signals[:-1], Signal("V_10", "-", "its own")))
        found = signals_of([own], file.scenario, 1, {})
        assert equal(found.runs["smc"]["V_10"], own["V_10"])
        assert found.metadata["signals"]["V_10"]["doc"] == "its own"

    def test_of_an_unknown_law_have_no_lyapunov_functions(self, run_paper):
        file, run = run_paper("smc", "run.horizon=3")
        plain = dataclasses.replace(run, law_values=run.law_values[:, :, :0], law_signals=())
        assert not {s.name for s in lyapunov.SIGNALS} & set(signals_of([plain], file.scenario, 1, {}).signals())


class TestLoad:
    def test_names_the_formats_it_knows(self, tmp_path):
        with pytest.raises(data.UnreadableDataError, match="npz, csv, mat, parquet"):
            data.load(tmp_path / "run.xlsx")

    def test_leaves_a_missing_file_to_the_operating_system(self, tmp_path):
        for name in data.FORMATS:
            with pytest.raises(FileNotFoundError):
                data.load(tmp_path / f"run.{name}")
