"""`fuzzyctl convert` as a user types it."""

import json
import resource
from pathlib import Path

import pytest

import fuzzyctl
from tests.commands import runner

run = runner("convert")


@pytest.fixture
def source(tmp_path, base):
    path = tmp_path / "base.fz"
    path.write_text(base + "require bounded(u, -2, 2)\n", encoding="utf-8")
    return path


def test_a_copy_in_the_same_format_has_no_difference(source, tmp_path):
    result = run(source, tmp_path / "copy.fz", "--points", "100")
    assert result.exit_code == 0, result.output
    assert "wrote" in result.stdout
    assert "u: no difference" in result.stdout
    assert fuzzyctl.load(tmp_path / "copy.fz") == fuzzyctl.load(source)


def test_a_file_that_exists_is_not_replaced_without_force(source, tmp_path):
    target = tmp_path / "copy.fz"
    target.write_text("mine", encoding="utf-8")
    result = run(source, target)
    assert result.exit_code == 1
    assert "add --force" in result.stderr
    assert target.read_text(encoding="utf-8") == "mine"
    assert run(source, target, "--force", "--points", "100").exit_code == 0


def test_a_conversion_is_repeated_without_force_until_its_file_is_edited(source, tmp_path):
    target = tmp_path / "copy.fll"
    for _ in range(2):
        result = run(source, target, "--points", "100")
        assert (result.exit_code, result.stdout.partition("\n")[0]) == (0, f"wrote {target}")
    target.write_text(target.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    result = run(source, target, "--points", "100")
    assert (result.exit_code, result.stdout) == (1, "")
    assert f"{target}: error[FZ005]: the file exists with another text" in result.stderr


DISABLED = """Engine: fan
InputVariable: heat
  range: 0 40
  term: hot Ramp 0 40
OutputVariable: speed
  range: 0 900
  aggregation: Maximum
  defuzzifier: Centroid 100
  term: high Triangle 300 600 900
RuleBlock: usual
  implication: Minimum
  rule: if heat is hot then speed is high
RuleBlock: night
  enabled: false
  rule: if heat is hot then speed is high
"""


def test_what_is_switched_off_is_listed_since_no_format_gets_it(tmp_path):
    source = tmp_path / "fan.fll"
    source.write_text(DISABLED, encoding="utf-8")
    reported = "line 13: left out: rule block 'night' is disabled; it is left out, and 1 rule with it"
    assert reported in run(source, tmp_path / "fan.fz", "--points", "10").stdout
    result = run(source, tmp_path / "other.fll", "--points", "10", "--format", "json")
    assert json.loads(result.stdout)["losses"][0]["where"] == "line 13"
    assert run(source, tmp_path / "again.fll", "--points", "10").exit_code == 0  # no number changes


def test_standard_output_holds_the_text_and_nothing_else(source):
    result = run(source, "-", "--to", "python")
    assert result.exit_code == 0
    assert result.stdout.startswith('"""base: Base"""')


def test_a_page_comes_with_its_pictures(source, tmp_path):
    result = run(source, tmp_path / "base.md")
    assert result.exit_code == 0, result.output
    assert "![Terms of x](base-pictures/x.svg)" in (tmp_path / "base.md").read_text(encoding="utf-8")
    assert sorted(p.name for p in (tmp_path / "base-pictures").iterdir()) == [
        "surface-u.svg",
        "u.svg",
        "x.svg",
        "y.svg",
    ]


def test_pictures_that_are_there_are_not_replaced_without_force(source, tmp_path):
    folder = tmp_path / "base-pictures"
    folder.mkdir()
    (folder / "x.svg").write_text("mine", encoding="utf-8")
    (folder / "other.svg").write_text("mine", encoding="utf-8")
    result = run(source, tmp_path / "base.md")
    assert result.exit_code == 1
    assert "x.svg: error[FZ005]: a file of this name exists" in result.stderr
    assert "--force" in result.stderr
    assert [p.read_text() for p in folder.iterdir()] == ["mine", "mine"]
    assert not (tmp_path / "base.md").exists()
    assert run(source, tmp_path / "base.md", "--force").exit_code == 0
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


@pytest.mark.parametrize(
    ("arguments", "message", "code"),
    [
        (["out.fiz"], "no format has the suffix '.fiz'", 1),
        (["out"], "no suffix that says the format", 1),
        (["-", "--to", "fiss"], "did you mean 'fis'?", 2),
    ],
)
def test_a_format_that_is_none_is_named(source, arguments, message, code):
    result = run(source, *arguments)
    assert result.exit_code == code
    assert message in result.stderr


def test_json_reports_the_same(source, tmp_path):
    data = json.loads(run(source, tmp_path / "copy.fz", "--format", "json", "--points", "100").stdout)
    assert data["written"]
    assert data["losses"] == []
    assert data["outputs"][0]["largest"] == 0.0


def test_a_file_of_other_numbers_is_not_written_even_if_the_writer_knows_of_no_reason(source, tmp_path, monkeypatch):
    other = fuzzyctl.dumps(fuzzyctl.load(source)).replace("triangle(-1, 0, 1)", "triangle(-1, 0.5, 1)")
    monkeypatch.setattr("fuzzyctl.convert.convert.written", lambda system, target: (other, []))
    result = run(source, tmp_path / "copy.fz", "--points", "200")
    assert result.exit_code == 1
    assert "output 'u': its numbers: they differ by" in result.stderr
    assert not (tmp_path / "copy.fz").exists()


def test_a_folder_is_no_file(source, tmp_path):
    result = run(source, tmp_path, "--to", "fz", "--force")
    assert result.exit_code == 1
    assert "this is a folder" in result.stderr


NO_RULE = """\
OutputVariable: light
  range: 0 1
  aggregation: Maximum
  defuzzifier: Centroid 100
  default: 0.5
  term: on Triangle 0 1 2
RuleBlock: usual
  conjunction: Minimum
"""
CIRCLE = """\
  rule: if heat is hot then speed is high
  rule: if speed is not high then speed is high
"""


MAXIMA = """\
  defuzzifier: MeanOfMaximum 100
  term: high Triangle 300 600 900
RuleBlock: usual
  implication: AlgebraicProduct
  rule: if heat is hot then speed is very high
"""


@pytest.mark.parametrize(
    ("old", "new", "target", "reason"),
    [
        ("RuleBlock: usual\n", NO_RULE, "fan.fz", "no rule sets output 'light'"),
        ("RuleBlock: usual\n", NO_RULE, "fan.py", "no rule sets output 'light'"),
        ("  rule: if heat is hot then speed is high\n", CIRCLE, "fan.fml", "in a circle: speed → speed"),
        (DISABLED[DISABLED.index("  defuzzifier") : DISABLED.index("RuleBlock: night")], MAXIMA, "fan.fml", "'mom' of"),
    ],
)
def test_what_would_be_a_mistake_in_the_other_format_is_reported_at_the_place_it_comes_from(
    tmp_path, old, new, target, reason
):
    source = tmp_path / "fan.fll"
    source.write_text(DISABLED.partition("RuleBlock: night")[0].replace(old, new), encoding="utf-8")
    result = run(source, tmp_path / target, "--points", "20")
    assert result.exit_code == 1
    assert f"{source}:1:1: error[FZ608]" in result.stderr
    assert reason in result.stderr
    assert "converted." not in result.stderr
    assert "<text>" not in result.stderr
    assert not (tmp_path / target).exists()


def test_a_point_where_no_rule_fires_is_reported_as_check_does(tmp_path):
    path = tmp_path / "gap.fz"
    path.write_text(
        "system a\nand product\nor probabilistic_sum\ndefuzzifier center_average\n"
        "semantics exact(consequent_hedges=activation)\n"
        "input x in [-1, 1]\n  terms N Z P\noutput u in [-1, 1]\n  terms N Z P\n"
        "table u = x\n    N  Z  P\n | N  .  [not P]\notherwise u is not Z\n",
        encoding="utf-8",
    )
    result = run(path, tmp_path / "gap.fll")
    assert result.exit_code == 1
    assert "gap.fz:8:8: error[FZ401]: no rule fires for output 'u'" in result.stderr
    assert not (tmp_path / "gap.fll").exists()


def test_a_slight_loss_is_reported_and_a_larger_one_refused(tmp_path):
    sampled = tmp_path / "tip.fis"
    result = run("rules/tipper.fz", str(sampled))
    assert (result.exit_code, sampled.exists()) == (0, True)
    assert "becomes centroid(resolution=101, grid=endpoints, rule=plain)" in result.output
    narrow = tmp_path / "narrow.fz"
    narrow.write_text(Path("rules/tipper.fz").read_text().replace("triangle(0, 5, 10)", "triangle(4.9, 5, 5.2)"))
    refused = run(str(narrow), str(tmp_path / "narrow.fis"))
    assert refused.exit_code == 1
    assert "nothing was written" in refused.output


def test_a_loss_of_an_output_that_holds_its_value_is_refused(tmp_path):
    held = tmp_path / "held.fz"
    held.write_text(Path("rules/tipper.fz").read_text().replace('unit "%"', 'unit "%" else hold'))
    refused = run(str(held), str(tmp_path / "held.fis"))
    assert (refused.exit_code, (tmp_path / "held.fis").exists()) == (1, False)
