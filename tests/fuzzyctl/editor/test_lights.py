"""Guarantee lights: how proofs go on, stop and are kept; tests/golden/editor/lenses.txt holds verdicts."""

import pytest

from fuzzyctl import Undecided
from fuzzyctl.editor.session import lights
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM
from tests.golden.answers import Case

FAMILY = """
plant cart
  state x = 1
  der x = -x
  output y = x
loop settle
block cart = cart()
for cart.x in [-1, 1]
measure final = final(cart.y)
run 1 s step 10 ms
"""
BASE = SYSTEM.replace("require tip >= 0\n", "")


def opened(text):
    return Case(text).now


def states(document):
    return [light.state for light in lights.lights(document)]


def test_a_light_has_its_line_its_block_and_its_counterexample():
    document = opened(f"{BASE}require tip <= 19  # why\n")
    assert [(x.state, x.text) for x in lights.lights(document)] == [("unknown", "not proved yet")]
    lights.prove(document)
    (light,) = lights.lights(document)
    assert (light.span.text, light.block, light.kind) == ("require tip <= 19", "tip", "system")
    assert set(light.point) == {"service", "food"}
    assert light.text.startswith("refuted at service = ")
    assert document.bounds["tip", "tip"] == (0.0, 20.0)


def test_a_newer_text_stops_a_proof():
    document = opened(BASE + "require tip <= 1\nrequire tip >= 0")
    asked = iter([False, True])
    with pytest.raises(lights.StoppedError):
        lights.prove(document, stopped=lambda: next(asked))
    assert states(document) == ["refuted", "unknown"]


def test_a_newer_text_stops_a_subdivision():
    text = BASE.replace("center_average", "centroid").replace("small=0 large=most", "small large")
    document, asked = opened(text + "require (tip - 10) * (service - 5) <= 40.1"), iter([False])
    with pytest.raises(lights.StoppedError):
        lights.prove(document, lights.LAST, lambda: next(asked, True))


def test_what_is_open_is_proved_with_more_time_and_what_is_settled_is_kept():
    document = opened(BASE + "require tip >= 0")
    (at,) = (x.span.start for x in lights.lights(document))
    document.verdicts[at, "tip"] = Undecided("tip >= 0", "no time")
    assert [x.text for x in lights.lights(document)] == ["undecided: no time"]
    assert lights.prove(document, lights.LAST) is False
    asked = []
    lights.prove(document, lights.LAST, lambda: bool(asked.append(1)))
    assert (states(document), len(asked)) == (["proved"], 1)


@pytest.mark.parametrize(("low", "state"), [(0, "proved"), (3, "refuted")])
def test_a_line_of_two_systems_has_the_worst_light(low, state):
    shared = "param most = 20\nrequire tip <= 20 - low\n"
    one, other = (BASE.replace("param most = 20\n", f"param low = {value}\n") for value in (0, low))
    document = opened(shared + one + other.replace("system tip", "system tap"))
    lights.prove(document)
    assert states(document) == [state], document.mistakes


def test_long_reasons_are_cut_and_a_claim_of_a_run_is_not_proved():
    document = opened(SYSTEM)
    document.verdicts[SYSTEM.index("require"), "tip"] = Undecided("tip >= 0", "x" * 500)
    assert len(lights.lenses(document)[-1].title) == 162
    assert lights.prove(opened(LOOP + "require iae <= 9")) is False
    assert lights.prove(opened(BASE + "require tap >= 0")) is False


def test_claims_about_families_of_loops_have_lights():
    document = opened(
        f"{FAMILY}require final <= 1\nrequire always cart.y <= 2\nrequire always cart.y <= 0.9 until 1 s\n"
    )
    lights.prove(document, lights.LAST)
    assert states(document) == ["unknown", "proved", "refuted"], document.mistakes
    assert [x.on_runs for x in lights.lights(document)] == [True, False, False]
    assert lights.lights(document)[2].point == {"cart.x": 1.0}
    commands = [lens.command.removeprefix("fuzzyctl.") for lens in lights.lenses(document)]
    assert commands == ["prove", "simulate", "simulate", "prove", "prove"]


@pytest.mark.parametrize(
    ("command", "block", "words"),
    [
        ("surface", "tip", ["plot-surface", "-", "--block", "tip", "-o", "a.svg"]),
        ("surface", "", ["plot-surface", "-", "-o", "a.svg"]),
        ("why", "tip", ["why", "-", "--block", "tip", "x=0.5", "y=-1"]),
        ("prove", "tip", ["prove", "-", "--block", "tip"]),
        ("simulate", "", ["simulate", "-"]),
    ],
)
def test_commands_as_arguments(command, block, words):
    assert lights.arguments(f"fuzzyctl.{command}", block, {"x": 0.5, "y": -1.0}, "a.svg") == words
