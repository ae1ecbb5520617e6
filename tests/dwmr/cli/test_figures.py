import csv
import hashlib
import json

import pytest

from dwmr.figures import paper
from dwmr.simulation import mujoco_plant, simulate
from tests.dwmr.paper import TABLE_12
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
            (["paper", "--set", "rules.ais_reaction.k_s=0.6"], 1, "'k_h_min - k_s * f >= G_min within 1e-12' does not"),
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


class TestPaper:
    @pytest.fixture(autouse=True)
    def few(self, monkeypatch):
        """Draw one figure of each law, and one of the experiment."""
        few = [figure for figure in paper.FIGURES if figure.number in (11, 20, 27, 36)]
        monkeypatch.setattr(paper, "FIGURES", tuple(few))

    @pytest.fixture
    def without_mujoco(self, monkeypatch):
        def missing(name):
            raise ImportError(f"No module named {name!r}")

        monkeypatch.setattr(mujoco_plant, "import_module", missing)

    @needs_mujoco
    def test_gives_the_same_checksums_twice(self, tmp_path):
        texts = []
        for name in ("one", "two"):
            done = here("paper", *SHORT, "-o", tmp_path / name)
            assert "4 figures in " in done.stdout
            texts.append((tmp_path / name / "manifest.json").read_text(encoding="utf-8"))
        manifest = json.loads(texts[0])
        assert texts[0] == texts[1]
        assert (manifest["complete"], manifest["left_out"]) == (True, {})
        assert [list(run["controllers"]) for run in manifest["runs"]] == [["smc", "aifqsmc", "fcafsmc"], ["aifqsmc"]]
        there = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in (tmp_path / "one").iterdir()}
        del there["manifest.json"]
        assert {name: one["sha256"] for name, one in manifest["files"].items()} == there
        page = (tmp_path / "one" / "index.html").read_text(encoding="utf-8")
        assert page.count("data:image/png;base64,") == 4
        assert "Fig. 36, AIFQSMC, experiment: σ* within its boundary layer" in page

    @pytest.mark.usefixtures("without_mujoco")
    def test_goes_on_without_mujoco_and_says_so_in_one_line(self, tmp_path):
        done = here("paper", *SHORT, "-o", tmp_path)
        (line,) = [one for one in done.stderr.splitlines() if "left out" in one]
        assert line.startswith("warning: Table 13 and Figs. 36 to 36 left out: run.plant = 'mujoco' needs the package")
        manifest = json.loads((tmp_path / "manifest.json").read_text(encoding="utf-8"))
        assert not manifest["complete"]
        assert "pip install 'fuzzyctl[physics]'" in manifest["left_out"]["Table 13 and Figs. 36 to 36"]
        assert sorted(path.name for path in tmp_path.glob("*.png")) == ["fig11.png", "fig20.png", "fig27.png"]

    def test_keeps_what_is_done_when_it_is_interrupted(self, tmp_path, monkeypatch):
        finish = simulate.run

        def run(simulation, report=None):
            if simulation.name == "aifqsmc":
                raise KeyboardInterrupt
            return finish(simulation, report)

        monkeypatch.setattr(simulate, "run", run)
        done = here("paper", *SHORT, "-o", tmp_path, status=130)
        assert "1 figures in " in done.stdout
        assert sorted(path.name for path in tmp_path.iterdir()) == ["fig11.png", "index.html", "manifest.json"]
        manifest = json.loads((tmp_path / "manifest.json").read_text(encoding="utf-8"))
        assert (manifest["interrupted"], list(manifest["files"])) == (True, ["fig11.png", "index.html"])
        assert "The command was interrupted" in (tmp_path / "index.html").read_text(encoding="utf-8")

    def test_refuses_mistakes_and_leaves_nothing(self, tmp_path):
        done = here("paper", "--set", "rules.ais_reaction.k_s=0.6", "-o", tmp_path / "out", status=1)
        assert "the guarantee 'k_h_min - k_s * f >= G_min within 1e-12' does not hold" in done.stderr
        assert list(tmp_path.iterdir()) == []

    @pytest.mark.usefixtures("without_mujoco")
    def test_has_the_papers_numbers_with_ours(self, tmp_path, run_paper, recorded):
        recorded(*(run_paper(law)[1] for law in TABLE_12))
        done = here("paper", "-o", tmp_path)
        assert "smc, aifqsmc, fcafsmc: 21 of 27 errors within 10 % of Table 12, 21 within 12 %" in done.stdout
        with (tmp_path / "table12.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == 27
        for row in rows:
            assert float(row["paper"]) == TABLE_12[row["law"]][row["robot"]][row["error"]]
            assert float(row["ours"]) / float(row["paper"]) == pytest.approx(float(row["ratio"]))
        page = (tmp_path / "index.html").read_text(encoding="utf-8")
        assert page.count("<td") == 9 * 10
        assert "4.0197" in page
