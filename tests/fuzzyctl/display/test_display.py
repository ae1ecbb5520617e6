"""What objects look like: one line, the text of commands, and HTML that no name breaks."""

import dataclasses
import re
from html import escape
from html.parser import HTMLParser

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl.testing import run_command

#: The types that a notebook shows; plots are matplotlib's axes, whose line is its own.
PLOTS = ("Panels", "Plot", "Plot3D")
TYPES = (
    *("BlockTrace", "Controller", "Experiment", "FuzzySystem", "Kernel", "Loop", "Plant", "Proved", "Refuted", "Run"),
    *("Trace", "Undecided", "Verdicts", *PLOTS),
)
HOSTILE = "</script>\"><img src=x onerror='alert(1)'>\x1b[31m\u202e&"
SILENT = """system silent
input x in [0, 1]
  low = triangle(0, 0, 0.2)
output u in [0, 1] else {otherwise}
  terms a=0 b=1
defuzzifier weighted_average
if x is low then u is b
"""


class Tags(HTMLParser):
    """Keeps tags with their attributes."""

    def __init__(self, page):
        super().__init__()
        self.found = []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))


@pytest.fixture(scope="module")
def tipper():
    return fuzzyctl.load("tipper")


@pytest.fixture(scope="module")
def loop():
    return fuzzyctl.load("pendulum", block=fuzzyctl.Loop)


@pytest.fixture(scope="module")
def run(loop):
    return fuzzyctl.simulate(loop, backend="python", GE=3)


@pytest.fixture(scope="module")
def shown(tipper, loop, run):
    """By type something that a notebook shows."""
    fragile = fuzzyctl.load("ais_reaction").with_params(k_s=0.6)
    verdicts = fuzzyctl.prove(fragile)
    things = [
        tipper,
        fuzzyctl.compile(tipper, "numpy"),
        *(loop, loop.controllers[0], loop.plants[0], run),
        fuzzyctl.Experiment(loop, "python", free=["law.GE"]),
        fuzzyctl.why(tipper, service=7, food=8),
        fuzzyctl.why(loop.controllers[0], {s.name: 0.1 for s in loop.controllers[0].inputs}),
        *(verdicts, verdicts[0], verdicts[1]),
        fuzzyctl.Undecided("f <= 1", "it takes more time", ({"x": (0.0, 1.0)},), 7),
        *(fuzzyctl.plot.terms(tipper), tipper.plot("food", at={"service": 3}), tipper.plot(resolution=5)),
    ]
    return {type(thing).__name__: thing for thing in things}


def test_every_type_is_here(shown):
    assert set(shown) == set(TYPES)


@pytest.mark.parametrize("name", TYPES)
class TestEachType:
    def test_it_is_one_line(self, shown, name):
        if name in PLOTS:
            return
        text = repr(next(iter(shown[name])) if name == "Verdicts" else shown[name])
        assert text.startswith(("Refuted" if name == "Verdicts" else name) + "(")
        assert "\n" not in text
        assert len(text) < 200

    def test_its_html_has_no_script_and_follows_the_colour_scheme(self, shown, name):
        html = shown[name]._repr_html_()
        tags = Tags(html).found
        assert {t for t, _ in tags} <= {
            "style",
            "div",
            "p",
            "br",
            "img",
            "table",
            "caption",
            *"thead tbody tr th td".split(),
        }
        assert not [a for _, attrs in tags for a in attrs if a.startswith("on")]
        assert all(attrs["src"].startswith("data:image/") and attrs["alt"] for t, attrs in tags if t == "img")
        assert "@media (prefers-color-scheme: dark)" in html
        assert "http" not in html.replace("base64,", "")[:3000]


def test_one_line_says_what_goes_in_and_out(shown):
    assert repr(shown["FuzzySystem"]) == "FuzzySystem(tipper: service, food -> tip; 3 rules)"
    assert repr(shown["Plant"]) == "Plant(cart: F -> position, speed, angle, rate; 4 states)"
    assert repr(shown["Run"]).endswith("5001 samples, 17 signals; 1 of 1 requirements hold)")
    assert repr(shown["Refuted"]).endswith("at sigma = 0, dsigma = 0: k_h_min - k_s * f = -0.008, G_min = 0.001)")


def test_plots_are_turned_in_the_dark_unless_their_colours_are_values(shown):
    turned = {name: 'class="lines"' in shown[name]._repr_html_() for name in ("Panels", "Plot", "Plot3D")}
    assert turned == {"Panels": True, "Plot": True, "Plot3D": False}
    assert 'alt="Tip for service and food' in shown["Plot3D"]._repr_html_()


def test_a_plan_is_one_line_too(shown):
    assert repr(shown["Kernel"].plan) == "Plan(service, food -> tip; 3 rules)"


def test_a_kernel_says_what_it_takes(tipper, loop):
    free = fuzzyctl.compile(tipper, "python", free=["tip.cheap.peak"])._repr_html_()
    assert ">tip.cheap.peak<" in free
    assert "<img" not in free
    step = fuzzyctl.compile(loop.controllers[0], "python")._repr_html_()
    assert ">period<" in step
    assert ">rules<" not in step


def test_an_experiment_says_what_is_compiled(shown):
    html = shown["Experiment"]._repr_html_()
    for fact in ("experiment balanced: ", "5,001, 0.01 s apart", "law.GE = 4", "cart.angle, cart.rate<"):
        assert fact in html


@pytest.mark.parametrize("name", ["FuzzySystem", "Loop"])
def test_print_prints_what_show_prints(shown, name, capsys):
    printed = run_command("show", "tipper" if name == "FuzzySystem" else "pendulum").output
    print(shown[name])
    assert capsys.readouterr().out in printed


def test_print_of_a_trace_prints_what_why_prints(shown):
    assert run_command("why", "tipper", "service=7", "food=8").output == f"{shown['Trace']}\n"


def hostile(system):
    named = dataclasses.replace(system.inputs[0], label=HOSTILE, unit="$m$ \\frac{")
    return dataclasses.replace(
        system, name=HOSTILE, title=HOSTILE, citation=HOSTILE, inputs=(named, *system.inputs[1:])
    )


def test_no_name_becomes_markup_or_acts(tipper):
    system = hostile(tipper)
    found = [system, fuzzyctl.compile(system, "numpy"), fuzzyctl.why(system, service=7, food=8)]
    for page in (thing._repr_html_() for thing in found):
        tags = Tags(page).found
        assert "script" not in [t for t, _ in tags]
        assert all("onerror" not in attrs and attrs.get("src", "data:").startswith("data:") for _, attrs in tags)
        assert not re.search("[\x00-\x09\x0b-\x1f\u202a-\u202e]", page)
    assert "&lt;/script&gt;" in found[0]._repr_html_()
    assert "\x1b" not in repr(system) + str(system)


def test_no_name_of_a_block_becomes_markup_or_acts(loop, shown):
    """Labels that no file can hold are shown, too."""
    controller = loop.controllers[0]
    inputs = tuple(dataclasses.replace(i, label=HOSTILE, unit=HOSTILE) for i in controller.inputs)
    texts = {"title": HOSTILE, "citation": HOSTILE, "path": HOSTILE}
    found = [
        dataclasses.replace(controller, inputs=inputs, **texts),
        *(dataclasses.replace(block, **texts) for block in (loop, loop.plants[0])),
        fuzzyctl.Refuted(HOSTILE, fuzzyctl.Witness({HOSTILE: 0.0}, ((HOSTILE, 1.0),)), note=HOSTILE),
    ]
    for thing in found:
        assert not {"script", "img"} & {tag for tag, _ in Tags(thing._repr_html_()).found}
        assert not re.search("[\x00-\x09\x0b-\x1f\u202a-\u202e]", thing._repr_html_() + str(thing))


@pytest.mark.parametrize("otherwise", ["nan", "error", "0"])
def test_a_kernel_without_values_says_so(otherwise):
    system = fuzzyctl.loads(SILENT.format(otherwise=otherwise))
    html = fuzzyctl.compile(system, "numpy")._repr_html_()
    assert ("no surface: no rule fires for output" in html) == (otherwise == "error")
    assert ("<img" in html) == (otherwise != "error")


def test_a_trace_without_a_rule_has_no_picture():
    system = fuzzyctl.loads(SILENT.format(otherwise="nan"))
    found = fuzzyctl.why(system, x=0.9)
    assert "u = nan" in repr(found)
    assert "<img" not in found._repr_html_()


def test_a_run_that_stops_says_why(loop):
    run = fuzzyctl.simulate(loop, backend="python", GE=0.01)
    if run.stopped is not None:
        assert escape(run.stopped.message) in run._repr_html_()
    assert "not met" in run._repr_html_()


def test_long_tables_are_cut_and_counted():
    rules = "".join(f"if x is a then u is b weight {1 / (k + 2)}\n" for k in range(64))
    page = fuzzyctl.loads(SILENT.format(otherwise=0).replace("low", "a").partition("if x")[0] + rules)._repr_html_()
    assert page.count("if x is a") == 60
    assert "and 4 more" in page


def test_the_theme_of_a_notebook_comes_before_that_of_the_machine(tipper):
    """And the texts of tables stand left: Jupyter's rule for cells has two classes and one element."""
    page = tipper._repr_html_()
    machine = page.index("@media (prefers-color-scheme: dark)")
    for selector in ("body[data-jp-theme-light=false]", "body.vscode-dark", "html[theme=light]", "[data-theme=dark]"):
        assert page.index(selector) > machine
    assert ".fuzzyctl.fuzzyctl table td {" in page


def test_verdicts_without_findings_have_no_column_for_them(shown):
    assert '<th scope="col">found</th>' in shown["Verdicts"]._repr_html_()
    assert "found" not in type(shown["Verdicts"])([shown["Proved"]])._repr_html_()


def test_silent_rules_are_counted(tipper):
    assert "silent" not in fuzzyctl.why(tipper, service=7, food=8)._repr_html_()
    assert (
        '<p class="note">1 rule silent</p>'
        in fuzzyctl.why(fuzzyctl.loads(SILENT.format(otherwise="nan")), x=0.9)._repr_html_()
    )


def test_nine_inputs_are_shown():
    inputs = "".join(f"input x{k} in [0, 1]\n  terms low high\n" for k in range(9))
    rules = "if x0 is low then u is a\nif x0 is high then u is b\n"
    system = fuzzyctl.loads(
        f"system nine\n{inputs}output u in [0, 1]\n  terms a=0 b=1\ndefuzzifier weighted_average\n{rules}"
    )
    assert "x8 = 0.5" in "".join(system.plot(resolution=3).get_title().split("\n"))
    assert "<img" in fuzzyctl.compile(system, "numpy")._repr_html_()


def test_completion_shows_nothing_inherited(tipper):
    assert "model_copy" not in dir(tipper)
    assert {"plot", "rules", "with_params"} <= set(dir(tipper))
    assert {"annotations", "import_module", "Any"} & set(dir(fuzzyctl)) == set()
    assert dir(fuzzyctl.build) == sorted(fuzzyctl.build.__all__)


class TestWhy:
    def test_values_come_in_a_mapping_or_by_name(self, tipper):
        assert fuzzyctl.why(tipper, {"service": 7}, food=8) == fuzzyctl.why(tipper, service=7, food=8)

    @pytest.mark.parametrize(
        ("values", "named", "part"),
        [
            ({}, {"service": 1}, "a value is missing for: food"),
            ({"service": 1}, {"service": 1}, "'service' is given twice"),
            ({}, {"servcie": 1}, "did you mean 'service'"),
            (3, {}, "'values' must be numbers by name"),
        ],
    )
    def test_mistakes_are_named(self, tipper, values, named, part):
        with pytest.raises(fuzzyctl.FuzzyctlError, match=re.escape(part)):
            fuzzyctl.why(tipper, values, **named)

    def test_nan_is_no_rule(self, tipper):
        assert fuzzyctl.why(tipper, service=np.nan, food=8)._repr_html_()
