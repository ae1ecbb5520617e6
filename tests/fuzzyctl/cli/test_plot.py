"""Files that `fuzzyctl plot` and other commands draw; transcripts/plot.txt holds what they print."""

import pytest

from tests import shipped
from tests.commands import runner

run = runner()


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    (tmp_path / "folder").mkdir()
    monkeypatch.chdir(tmp_path / "folder")
    return tmp_path / "folder"


@pytest.mark.parametrize(("suffix", "magic"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_the_suffix_gives_the_format_and_a_picture_has_the_same_bytes_again(folder, suffix, magic):
    for name in ("a", "b"):
        result = run("plot-surface", "tipper", "-x", "food", "--at", "service=3", "-o", f"{name}.{suffix}")
        assert result.exit_code == 0, result.output
    first, second = (path.read_bytes() for path in sorted(folder.iterdir()))
    assert first == second
    assert first.startswith(magic)


@pytest.mark.parametrize("name", ["../escaped", "a/b", "/tmp/absolute", "ж" * 250, ""])
def test_a_default_name_stays_in_the_folder_for_any_name_of_the_system(folder, name):
    fis = f"[System]\nName='{name}'\nType='mamdani'\nNumInputs=1\nNumOutputs=1\nNumRules=1\n"
    fis += "[Input1]\nName='x'\nRange=[0 1]\nNumMFs=1\nMF1='a':'trimf',[0 0.5 1]\n"
    fis += "[Output1]\nName='../y'\nRange=[0 1]\nNumMFs=1\nMF1='b':'trimf',[0 0.5 1]\n[Rules]\n1, 1 (1) : 1\n"
    (folder / "t.fis").write_text(fis)
    for command in (["plot", "--terms", "t.fis"], ["plot-surface", "t.fis", "--resolution", 3]):
        result = run(*command)
        assert result.exit_code == 0, result.output
    assert [p.name for p in folder.parent.iterdir()] == ["folder"]
    assert len(list(folder.glob("*.png"))) == 2


PICTURES = [
    ("plot-surface", "tipper", "--resolution", "5", "-o", "out.{}"),
    ("plot", "--terms", "tipper", "-o", "out.{}"),
    ("why", "tipper", "service=7", "food=8", "-o", "out.{}"),
    ("simulate", "water_tank", "--picture", "{}", "-o", "out"),
]


@pytest.mark.parametrize("words", PICTURES, ids=lambda words: words[0])
def test_a_picture_can_be_printed_and_searched(folder, words):
    """No font of a PDF is of type 3, and an SVG holds text if it is wanted."""

    def drawn(suffix, *more):
        result = run(*(word.format(suffix) for word in words), *more)
        assert result.exit_code == 0, result.output
        (path,) = folder.rglob(f"*.{suffix}")
        return path.read_bytes()

    assert b"/Type3" not in drawn("pdf")
    assert b"<text" not in drawn("svg")
    assert b"<text" in drawn("svg", "--svg-text")


@pytest.mark.parametrize("path", shipped.SYSTEMS, ids=lambda p: p.name)
def test_the_terms_of_every_shipped_file_can_be_drawn(path):
    assert run("plot", "--terms", path, "-o", "a.png").exit_code == 0
