import json

import pytest

import fuzzyctl
from fuzzyctl.display.layout import laid_out
from fuzzyctl.display.summary import summary
from fuzzyctl.model.method import Method
from fuzzyctl.support.shipped import rules_folder
from tests.commands import runner
from tests.shipped import SYSTEMS

EVERYTHING = """\
system one "A title that is so long that it must be broken somewhere on a narrow terminal"
source "a book"
or probabilistic_sum
activation highest(count=3)
hedge rather(x) = x^1.5
param k = 2 unit "m"
param wide = k * 3

input mode in [0, 1]
  terms slow fast
input a "A" in [-wide, wide] unit "m" extrapolate
  N = ramp(0, -3)
  Z = gaussian(0, k / 2, height=0.9)
  P = s_shape(0, 2)
input b in [0, 1]
  terms first_of_b second_of_b third_of_b

output u in [-10, 10] else 0 defuzzifier weighted_average
  lin = linear(1, 2, 3, k)
  fun = function(a * k + b)
  c = constant(2)
output v in [0, 1] else midpoint implication product
  terms lo hi

with mode is rather fast
table u = a x b
    first_of_b second_of_b third_of_b
  N | lin fun c*0.5
  Z | lin . linear(1,1,1,k)
  P | lin c*(k/4) 3
if mode is slow or mode is not fast then u is c, v is lo weight 0.5
if a is very P then v is hi

system two
input x in [0, 1]
  terms lo hi
output y in [0, 1]
  terms lo hi
output z in [0, 1]
  terms lo hi
table y, z = x
    lo hi
  | lo/hi hi/lo
"""


def run(*arguments, columns="120"):
    return runner("show", COLUMNS=columns)(*arguments)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "a.fz"
    path.write_text(EVERYTHING)
    return path


@pytest.fixture
def lines(file):
    result = run(file)
    assert result.exit_code == 0, result.output
    return result.output.splitlines()


class TestText:
    def test_title_source_and_file_come_first(self, lines, file):
        assert lines[0].startswith("one: A title")
        assert lines[1:3] == ["source: a book", f"file: {file}"]

    def test_every_setting_in_effect_is_printed_with_its_default(self, lines):
        for line in (
            "  and          min",
            "  or           probabilistic_sum",
            "  activation   highest(count=3)",
            "  defuzzifier  centroid, exact",
        ):
            assert line in lines

    def test_settings_of_each_output_are_those_in_effect(self, lines):
        u, v = lines.index("  u in [-10, 10]"), lines.index("  v in [0, 1]")
        of_u, of_v = lines[u:v], lines[v:]
        assert "    implication  no effect: the defuzzifier sums over rules" in of_u
        assert "    defuzzifier  weighted_average" in of_u
        assert "    else         0" in of_u
        assert "    implication  product" in of_v
        assert "    aggregation  max" in of_v
        assert "    else         midpoint" in of_v

    def test_params_have_values_and_formulas(self, lines):
        assert "  k    = 2 m" in lines
        assert "  wide = 6   = k * 3" in lines

    def test_numbers_are_computed(self, lines):
        assert '  a "A" in [-6, 6] m; values outside are extrapolated' in lines
        assert "  b in [0, 1]; values outside are clamped" in lines
        for line in (
            "    Z  gaussian(0, 1, height=0.9)",
            "    lin  linear(1, 2, 3, 2)",
            "    fun  function(a * k + b)",
            "    second_of_b  triangle(0, 0.5, 1)",
        ):
            assert line in lines

    def test_tables_are_drawn_as_tables(self, lines):
        at = lines.index("  u = a x b with mode is rather fast")
        assert lines[at + 1 : at + 6] == [
            "    a \\ b │ first_of_b  second_of_b  third_of_b",
            "    ──────┼─────────────────────────────────────────",
            "    N     │ lin         fun          c*0.5",
            "    Z     │ lin         .            linear(1,1,1,k)",
            "    P     │ lin         c*(k / 4)    3",
        ]

    def test_a_table_of_two_outputs_and_one_input(self, lines):
        at = lines.index("  y, z = x")
        assert lines[at + 1 : at + 4] == ["    x    │ lo     hi", "    ─────┼─────────────", "    y, z │ lo/hi  hi/lo"]

    def test_other_rules_are_text(self, lines):
        assert "  if mode is slow or mode is not fast then u is c, v is lo weight 0.5" in lines
        assert "  rather(x) = x^1.5" in lines

    def test_bounds_and_coverage_are_what_is_proved(self, lines):
        text = run(rules_folder() / "ais_reaction.fz").output
        assert "    values       from -1 to 0.18; both are attained" in text
        assert "    coverage     some rule fires everywhere; proved" in text
        assert "  f(-sigma, -dsigma) == f within 1e-12" in text
        assert any(line.startswith("    coverage     no rule fires where mode = 1") for line in lines)

    @pytest.mark.parametrize("columns", [30, 40, 50])
    def test_nothing_is_wider_than_the_terminal(self, file, columns, monkeypatch):
        monkeypatch.chdir(file.parent)
        output = run(file.name, columns=str(columns)).output
        assert max(map(len, output.splitlines())) <= columns
        assert output.count("a \\ b │") > 1
        assert "".join(output.split()).count("linear(1,1,1,k)") == 1

    def test_a_pipe_gets_no_colour(self, file):
        assert "\x1b" not in run(file).output


class TestChoice:
    def test_all_systems_are_printed_unless_one_is_named(self, file):
        assert "\n\ntwo\n" in run(file).output
        assert run(file, "--block", "two").output.startswith("two\n")
        assert "title" not in run(file, "--block", "two").output

    def test_an_unknown_system_is_a_diagnostic(self, file):
        result = run(file, "--block", "tow")
        assert result.exit_code == 2
        assert "FZ502" in result.output
        assert "did you mean 'two'?" in result.output

    def test_params_can_be_set(self):
        output = run(rules_folder() / "ais_reaction.fz", "--set", "k_s=0.5").output
        assert "  f_max   = 0.198   = (k_h_min - G_min) / k_s" in output
        assert "  f in [-1, 0.198]" in output

    def test_errors_are_diagnostics_and_warnings_are_not_its_business(self, tmp_path, changed):
        broken, warned = tmp_path / "a.fz", tmp_path / "b.fz"
        broken.write_text(changed(("Z |  N  P", "Z |  N  Q")))
        result = run(broken)
        assert result.exit_code == 1
        assert "error[FZ203]" in result.output
        assert "Rules" not in result.output
        warned.write_text(changed(("\ninput x", "\nparam k = 1\ninput x")))
        assert "warning" not in run(warned).output

    def test_a_hole_is_shown_rather_than_refused(self, tmp_path, changed):
        path = tmp_path / "a.fz"
        path.write_text(changed(("N |  N  Z", "N |  .  Z")))
        result = run(path)
        assert result.exit_code == 0
        assert "    coverage     no rule fires where x = -1, y = 0" in result.output.splitlines()


class TestJson:
    def test_it_has_every_digit(self, tmp_path):
        data = json.loads(run(rules_folder() / "fcafsmc.fz", "--format", "json").output)
        (foot,) = {t["parameters"][2] for t in data["inputs"][0]["terms"] if t["name"] == "NB"}
        assert data["inputs"][0]["terms"][0]["parameters"] == ["-inf", -0.4, foot]
        assert repr(foot).startswith("-0.26666666666666")
        assert data["outputs"][0]["bounds"] == {"low": -2.0, "high": 2.0, "attained": True}
        assert data["outputs"][0]["adaptive"] == "gamma * sigma"

    def test_several_systems_are_a_list(self, file):
        data = json.loads(run(file, "--format", "json").output)
        assert [s["system"] for s in data["systems"]] == ["one", "two"]
        table, *rules = data["systems"][0]["rules"]
        assert table["with"] == "mode is rather fast"
        assert table["cells"][0] == ["lin", "fun", "c*0.5"]
        assert len(rules) == 2

    def test_no_setting_of_a_method_is_forgotten(self):
        system = fuzzyctl.loads(EVERYTHING, block="two")
        assert len(summary(system)["method"]) == len(Method.__dataclass_fields__) - len({"span", "spans"})


@pytest.mark.parametrize("path", SYSTEMS, ids=lambda p: p.stem)
def test_every_shipped_file_is_shown_on_any_width(path):
    data = summary(fuzzyctl.load(path))
    json.dumps(data, allow_nan=False)
    for width in (30, 80, 200):
        text = laid_out(data, width, lambda t: f"<{t}>")
        assert text.startswith("<")
        assert "<Rules: " in text
