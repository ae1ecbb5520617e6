"""The functions of a page's scripts that need no browser: ends of sliders and axes, where to begin, texts that fit."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

ASSETS = Path(__file__).parents[3] / "fuzzyctl" / "page" / "assets"
SCRIPTS = ",".join(
    str(ASSETS / name) for name in ("plots.js", "panels.js", "inputs.js", "system.js", "loop.js", "files.js")
)

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")


def computed(asked):
    """Return what node computes by expressions over the scripts."""
    command = ["node", str(Path(__file__).with_name("numbers.js")), SCRIPTS, f"[{', '.join(asked)}]"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout)


def ends(lower, upper, given):
    return f"sliderEnds({json.dumps({'lower': lower, 'upper': upper})}, {json.dumps(given)})"


def test_sliders_end_where_ranges_do_else_around_what_runs_give_else_at_one():
    cases = {
        (ends(0, 5, []), (0, 5)),
        (ends(0, 5, [7]), (0, 5)),
        (ends(None, None, []), (-1, 1)),
        (ends(0, None, []), (0, 1)),
        (ends(None, -3, []), (-4, -3)),
        (ends(50, None, []), (50, 51)),
        (ends(None, None, [0.6, 1.0]), (0.4, 1.2)),
        (ends(None, None, [0.0]), (-0.5, 0.5)),
        (ends(None, None, [290, 310]), (280, 320)),
        (ends(0, None, [0.2, 0.8]), (0, 1.1)),
    }
    asked, expected = zip(*sorted(cases), strict=True)
    assert computed(asked) == [list(pair) for pair in expected]


def test_a_run_that_diverges_sets_no_ends_by_its_last_values():
    values = [*(k / 100 for k in range(99)), 1e12]
    assert computed([f"roundEnds(usual({values}))"])[0][1] < 2


def test_a_point_with_a_value_is_looked_for_from_the_start_on():
    near = "nearestFirst([0.5, 5], [[0, 1], [0, 10]], [[0.5, 5.1]]).find"
    asked = [
        f"{near}(() => true)",
        f"{near}(([x, y]) => x < 0.1 && y > 6)",
        f"{near}(() => false) ?? null",
        "nearestFirst([0, 0, 0, 0, 0], [1, 2, 3, 4, 5].map((k) => [-k, k]), []).length",
    ]
    first, corner, none, many = computed(asked)
    assert (first, none, many) == ([0.5, 5.1], None, 0)
    assert corner == pytest.approx([0.1, 6], abs=0.25)
    assert corner[0] < 0.1
    assert corner[1] > 6


#: A system whose one rule fires at low x and high z, at no point near the middle.
RULE = """rulePoints(
    { inputs: ["x", "y", "z"].map((name, variable) => ({ name, variable, lower: 0, upper: 10, corners: [] })),
      rules: [{ parts: [{ variable: "x", set: 0 }, { variable: "z", set: 1 }] }] },
    { sets: Array(3).fill((v) => [Math.max(0, 1 - v), Math.max(0, v - 9)]) }, [5, 5, 5])"""


def test_rules_show_where_they_fire_nearest_to_a_start_and_most():
    ((nearest, most),) = computed([RULE])
    assert nearest == [0.9375, 5, 9.0625]
    assert most == [0, 5, 10]


def test_a_constant_has_one_number_on_its_axis():
    lines = ["[[2, 2, null], [2]]", "[[2, 3]]", "[[null]]", "[[0, 0]]"]
    assert computed([f"constantOf({own})" for own in lines]) == [2, None, None, 0]


def test_a_line_of_a_run_has_its_peaks_and_its_values_at_the_times_of_the_slider():
    found = computed(["withPeaks([0, 2, 4], { values: [1, 1, null], peaks: [[1, 3], [5, -5]] })"])
    assert found == [{"x": [0, 1, 2, 3, 4], "y": [1, 5, 1, -5, None]}]


#: A panel with lines of some series, as `nameLines` asks it, and the texts and places that this adds to its copy.
NAMED = """(() => {
    const entry = (textContent) => ({ textContent, querySelector: () => ({ getAttribute: () => "" }) });
    const names = ["signal", "reference"].map(entry);
    const lines = SERIES.map((series) => ({ dataset: { series } }));
    const svg = { closest: () => ({ previousElementSibling: { children: names } }), querySelectorAll: () => lines };
    const copy = document.createElementNS("", "svg");
    nameLines(copy, svg, 700);
    return copy.children.map(({ tag, own, textContent }) => [tag === "text" ? textContent : tag, own.x ?? own.x2]);
})()"""


def test_pictures_of_panels_name_their_lines_where_there_are_several():
    both, one = computed([NAMED.replace("SERIES", series) for series in ('["1", "0"]', '["0"]')])
    assert [name for name, _ in both] == ["reference", "line", "signal", "line"]
    places = [place for _, place in both]
    assert places == sorted(places, reverse=True)
    assert places[0] == 700 - 16
    assert one == []


def test_long_names_are_cut_and_far_pixels_have_no_exponent():
    found = computed(
        ["fitted('short', 60)", "fitted('a name that is far too long', 60)", "pixels(1e40)", "pixels(-2e21)"]
    )
    assert found == ["short", "a name th…", "100000.0", "-100000.0"]
