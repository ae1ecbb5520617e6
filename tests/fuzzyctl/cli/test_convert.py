"""Pictures of pages that `fuzzyctl convert` writes; transcripts/convert.txt holds what it prints."""

import resource

import pytest

import fuzzyctl
from tests.commands import runner

run = runner("convert")


@pytest.fixture
def source(tmp_path, base):
    path = tmp_path / "base.fz"
    path.write_text(base, encoding="utf-8")
    return path


def test_a_page_comes_with_its_pictures_which_are_not_replaced_without_force(source, tmp_path):
    folder, page = tmp_path / "base-pictures", tmp_path / "base.md"
    folder.mkdir()
    for name in ("x.svg", "other.svg"):
        (folder / name).write_text("mine", encoding="utf-8")
    result = run(source, page)
    assert (result.exit_code, page.exists()) == (1, False)
    assert "x.svg: error[FZ005]: a file of this name exists" in result.stderr
    assert "--force" in result.stderr
    assert [p.read_text() for p in folder.iterdir()] == ["mine", "mine"]
    assert run(source, page, "--force").exit_code == 0
    assert "![Terms of x](base-pictures/x.svg)" in page.read_text(encoding="utf-8")
    assert sorted(p.name for p in folder.iterdir()) == ["other.svg", "surface-u.svg", "u.svg", "x.svg", "y.svg"]
    assert (folder / "x.svg").read_text(encoding="utf-8").startswith("<?xml")
    assert (folder / "other.svg").read_text() == "mine"


def test_a_file_in_the_place_of_the_folder_of_pictures_is_named(source, tmp_path):
    (tmp_path / "q-pictures").write_text("mine", encoding="utf-8")
    for more in ([], ["--force"]):
        result = run(source, tmp_path / "q.md", *more)
        assert result.exit_code == 1
        assert f"{tmp_path / 'q-pictures'}: error[FZ005]: this is a file" in result.stderr
        assert "= help: move it" in result.stderr
    assert not (tmp_path / "q.md").exists()


@pytest.mark.parametrize("most", [300, 200_000])
def test_a_full_disk_leaves_neither_a_page_nor_pictures(source, tmp_path, most):
    """Of the pictures the surface alone is larger than 200 kB."""
    before = sorted(tmp_path.rglob("*"))
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, limits[1]))
    try:
        result = run(source, tmp_path / "base.md")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert result.exit_code == 1
    assert ".svg: error[FZ005]: the file cannot be written: File too large" in result.stderr
    assert sorted(tmp_path.rglob("*")) == before


def test_names_that_are_the_same_as_parts_of_files_have_pictures_each(tmp_path):
    text = "Engine: n\n" + "".join(
        f"InputVariable: {name}\n  range: 0 1\n  term: a Triangle 0 0.5 1\n" for name in ("a-b", "a+b")
    )
    text += "OutputVariable: y\n  range: 0 1\n  aggregation: Maximum\n  defuzzifier: Centroid 100\n"
    text += "  term: b Triangle 0 0.5 1\n  default: nan\n"
    text += "RuleBlock:\n  conjunction: Minimum\n  implication: Minimum\n  activation: General\n"
    (tmp_path / "n.fll").write_text(text + "  rule: if a-b is a and a+b is a then y is b\n", encoding="utf-8")
    result = run(tmp_path / "n.fll", tmp_path / "n.md")
    assert result.exit_code == 0, result.output
    assert len(list((tmp_path / "n-pictures").iterdir())) == 4


def test_a_file_of_other_numbers_is_not_written_even_if_the_writer_knows_of_no_reason(source, tmp_path, monkeypatch):
    other = fuzzyctl.dumps(fuzzyctl.load(source)).replace("triangle(-1, 0, 1)", "triangle(-1, 0.5, 1)")
    monkeypatch.setattr("fuzzyctl.convert.convert.written", lambda system, target: (other, []))
    result = run(source, tmp_path / "copy.fz", "--points", "200")
    assert result.exit_code == 1
    assert "output 'u': its numbers: they differ by" in result.stderr
    assert not (tmp_path / "copy.fz").exists()
