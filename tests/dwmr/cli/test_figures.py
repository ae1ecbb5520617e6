import pytest

from tests.dwmr.process import dwmr, here
from tests.physics import needs_mujoco

SHORT = ("--set", "run.horizon=0.5")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """All figures of a short run."""
    folder = tmp_path_factory.mktemp("figures")
    return folder, dwmr("figures", "paper", *SHORT, "-o", folder)


class TestFigures:
    @pytest.mark.long
    def test_are_all_there_with_their_index(self, whole):
        folder, done = whole
        assert done.stdout.startswith("21 figures in ")
        assert done.stderr == ""
        assert sorted(p.name for p in folder.iterdir()) == [*(f"fig{k:02d}.png" for k in range(8, 29)), "index.md"]
        text = (folder / "index.md").read_text(encoding="utf-8")
        assert all(f"(fig{k:02d}.png)" in text for k in range(8, 29))
        assert "Left out" not in text

    def test_come_in_the_wanted_number_and_kind(self, tmp_path):
        here("figures", "paper", *SHORT, "--only", "12,24", "--format", "svg", "-o", tmp_path)
        assert sorted(p.name for p in tmp_path.iterdir()) == ["fig12.svg", "fig24.svg", "index.md"]

    def test_that_a_scenario_lacks_are_left_out_and_named(self, tmp_path):
        free = ("--set", "obstacles=[]")
        done = here("figures", "paper", *SHORT, *free, "--only", "15,20", "-o", tmp_path)
        assert done.stderr == "warning: figure 15 is left out: the scenario has no obstacles\n"
        assert "Left out: the scenario has no obstacles." in (tmp_path / "index.md").read_text(encoding="utf-8")
        assert not (tmp_path / "fig15.png").exists()

    @pytest.mark.parametrize(
        ("arguments", "status", "words"),
        [
            (["paper", "--only", "7"], 2, "figures 8 to 39 have counterparts"),
            (["paper", "--only", "eight"], 2, "'eight' is not the number of a figure"),
            (["paper", "--format", "bmp"], 2, "'bmp' is not one of"),
            (["paper", "--only", "29"], 1, "figure 29 is left out: it shows rigid bodies"),
            (["paper", "--set", "obstacles=[]", "--only", "14-17"], 1, "the scenario has none of these figures"),
            (["paper", "--set", "rules.ais_reaction.k_s=0.6"], 1, "G_AIS > 0 is not guaranteed"),
        ],
    )
    def test_refuse_mistakes_and_leave_nothing(self, tmp_path, arguments, status, words):
        done = here("figures", *arguments, "-o", tmp_path / "out", status=status)
        assert words in done.stderr
        assert list(tmp_path.iterdir()) == []

    @needs_mujoco
    def test_of_rigid_bodies_are_those_of_the_experiment(self, tmp_path):
        done = here("figures", "experiment", *SHORT, "-o", tmp_path, "--only", "29,39")
        assert (done.stderr, sorted(p.name for p in tmp_path.glob("*.png"))) == ("", ["fig29.png", "fig39.png"])
        text = (tmp_path / "index.md").read_text(encoding="utf-8")
        assert "# Fig. 39: Immune reaction and switching gain (AIFQSMC, experiment)" in text
