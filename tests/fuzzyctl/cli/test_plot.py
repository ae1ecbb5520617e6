import pytest

from fuzzyctl.plot.choices import chosen_axes
from fuzzyctl.support.shipped import rules_folder
from tests import shipped
from tests.commands import runner

TIPPER = str(rules_folder() / "tipper.fz")

run = runner()


class TestPlotSurface:
    @pytest.mark.parametrize(("suffix", "magic"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
    def test_it_writes_the_format_that_the_name_asks_for(self, tmp_path, suffix, magic):
        path = tmp_path / f"a.{suffix}"
        result = run("plot-surface", TIPPER, "-o", path, "--resolution", 11)
        assert result.exit_code == 0, result.output
        assert path.read_bytes().startswith(magic)
        assert [p.name for p in tmp_path.iterdir()] == [path.name]

    def test_the_same_picture_has_the_same_bytes(self, tmp_path):
        for name in ("a.svg", "b.svg"):
            run("plot-surface", TIPPER, "-x", "food", "--at", "service=3", "-o", tmp_path / name)
        assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()

    def test_the_default_name_comes_from_system_and_output(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        assert run("plot-surface", TIPPER, "--resolution", 5).output == "wrote tipper-tip.png\n"
        assert (tmp_path / "tipper-tip.png").exists()

    @pytest.mark.parametrize("name", ["../escaped", "a/b", "/tmp/absolute", "n" * 300, "ж" * 250, ""])
    def test_a_default_name_stays_in_the_folder_whatever_the_system_is_called(self, tmp_path, monkeypatch, name):
        folder = tmp_path / "folder"
        folder.mkdir()
        monkeypatch.chdir(folder)
        fis = f"[System]\nName='{name}'\nType='mamdani'\nNumInputs=1\nNumOutputs=1\nNumRules=1\n"
        fis += "[Input1]\nName='x'\nRange=[0 1]\nNumMFs=1\nMF1='a':'trimf',[0 0.5 1]\n"
        fis += "[Output1]\nName='../y'\nRange=[0 1]\nNumMFs=1\nMF1='b':'trimf',[0 0.5 1]\n[Rules]\n1, 1 (1) : 1\n"
        (folder / "t.fis").write_text(fis)
        for command in (["plot", "--terms", "t.fis"], ["plot-surface", "t.fis", "--resolution", 3]):
            result = run(*command)
            assert result.exit_code == 0, result.output
        assert [p.name for p in tmp_path.iterdir()] == ["folder"]
        assert len(list(folder.glob("*.png"))) == 2

    @pytest.mark.parametrize(
        ("arguments", "part"),
        [
            (["-x", "fod"], "did you mean 'food'"),
            (["-z", "tp"], "did you mean 'tip'"),
            (["--at", "food"], "not of the form"),
            (["--at", "food=1", "-x", "food"], "is an axis and has a value too"),
            (["-o", "a.jpg"], "no picture format '.jpg'"),
            (["-o", "no/such/folder/a.png"], "there is no folder"),
            (["-o", "a" * 300 + "/x.png"], "there is no folder"),
            (["-x", "food", "--at", "service=nan"], "not a number to draw at"),
            (["-x", "food", "-y", "food"], "both axes"),
        ],
    )
    def test_mistakes_are_named(self, arguments, part):
        result = run("plot-surface", TIPPER, *arguments)
        assert result.exit_code == (1 if "-o" in arguments else 2)
        assert part in result.output
        assert "Traceback" not in result.output

    def test_a_value_outside_its_range_is_clamped_with_a_warning(self, tmp_path):
        result = run("plot-surface", TIPPER, "-x", "food", "--at", "service=99", "-o", tmp_path / "a.png")
        assert "service = 99 lies outside [0, 10]; taken as 10" in result.output

    def test_a_dollar_sign_in_a_label_is_a_dollar_sign(self, tmp_path, changed):
        path = tmp_path / "a.fz"
        path.write_text(changed(("input x", 'input x "$\\frac$"'), ("input y", 'input y "a_$^{"')))
        for command in (["plot-surface"], ["plot", "--terms"]):
            assert run(*command, path, "-o", tmp_path / "a.png").exit_code == 0


PICTURES = [
    ("plot-surface", "tipper", "--resolution", "5", "-o", "out.{}"),
    ("plot", "--terms", "tipper", "-o", "out.{}"),
    ("why", "tipper", "service=7", "food=8", "-o", "out.{}"),
    ("simulate", "water_tank", "--picture", "{}", "-o", "out"),
]


class TestPrintedPictures:
    @pytest.fixture
    def picture(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)

        def drawn(words, suffix, *more):
            result = run(*(word.format(suffix) for word in words), *more)
            assert result.exit_code == 0, result.output
            (path,) = tmp_path.rglob(f"*.{suffix}")
            return path.read_bytes()

        return drawn

    @pytest.mark.parametrize("words", PICTURES, ids=lambda words: words[0])
    def test_no_font_of_a_pdf_is_of_type_3(self, picture, words):
        assert b"/Type3" not in picture(words, "pdf")

    @pytest.mark.parametrize("words", PICTURES, ids=lambda words: words[0])
    def test_an_svg_holds_text_if_it_is_wanted(self, picture, words):
        assert b"<text" not in picture(words, "svg")
        assert b"<text" in picture(words, "svg", "--svg-text")


class TestAxes:
    @pytest.mark.parametrize(
        ("inputs", "x", "y", "fixed", "axes"),
        [
            (["a"], None, None, {}, ["a"]),
            (["a", "b", "c"], None, None, {}, ["a", "b"]),
            (["a", "b"], "b", None, {}, ["b", "a"]),
            (["a", "b"], "b", None, {"a": 1}, ["b"]),
            (["a", "b"], None, None, {"a": 1}, ["b"]),
            (["a", "b", "c"], "c", "a", {}, ["c", "a"]),
            (["a", "b", "c"], None, "a", {}, ["b", "a"]),
        ],
    )
    def test_those_named_come_first(self, inputs, x, y, fixed, axes):
        assert chosen_axes(inputs, x, y, fixed) == axes


class TestPlotTerms:
    @pytest.mark.parametrize("path", shipped.SYSTEMS, ids=lambda p: p.name)
    def test_every_shipped_file_can_be_drawn(self, tmp_path, path):
        assert run("plot", "--terms", path, "-o", tmp_path / "a.png").exit_code == 0
