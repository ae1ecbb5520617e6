import pytest

from fuzzyctl.analysis.verdicts import Undecided
from fuzzyctl.editor.lights import FIRST, LAST, StoppedError, lights, prove
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM, marked

BASE = SYSTEM.replace("require tip >= 0\n", "")
GAINS = LOOP.replace("every 10 ms\n", "every 10 ms\nrequire {}\n").replace(
    "output u = gain * surface(e = error) + level", "output u = clamp(level, -1, 1)"
)

#: A guarantee of the system, and its light.
CASES = {
    "tip >= 0": "proved",
    "tip <= most": "proved",
    "tip <= 20 within 1e-9": "proved",
    "tip <= 19": "refuted",
    "tip >= 1": "refuted",
    "tip > 0": "refuted",
    "decreasing(tip, service)": "refuted",
    "increasing(tip, service) within 1e-9": "undecided",
    "decreasing(tip, food)": "refuted",
    "total(tip)": "proved",
    "tip <= 2 * service + 21": "proved",
    "lipschitz(tip, service) <= 0.01": "refuted",
    "tip <= 19 when service <= 5": "refuted",
    "tip >= 19 when service >= 10 and food >= 10": "proved",
    "tip >= 0 and tip <= 20": "proved",
    "tip >= 0 and tip <= 10": "refuted",
    "tip >= 100 or tip <= 20": "proved",
    "abs(tip) <= 20": "proved",
    "tip == 20": "refuted",
    "tip(10, 10) == 20 within 1e-9": "proved",
}


@pytest.mark.parametrize("claim", CASES)
def test_the_light_of(claim):
    document, _ = marked(f"{BASE}require {claim}  # why\n§")
    (before,) = lights(document)
    assert (before.state, before.text) == ("unknown", "not proved yet"), document.mistakes
    prove(document)
    (light,) = lights(document)
    assert light.state == CASES[claim], light.text
    assert light.span.text == f"require {claim}"
    assert (light.block, light.kind) == ("tip", "system")
    if light.state == "refuted":
        assert set(light.point) == {"service", "food"}
        assert light.text.startswith("refuted at service = ")
    assert document.bounds["tip", "tip"] == (0.0, 20.0)


@pytest.mark.parametrize(("claim", "state"), [("u <= 1", "proved"), ("u <= 0.5", "refuted")])
def test_lights_of_controllers(claim, state):
    document, _ = marked(GAINS.format(claim) + "§")
    prove(document)
    (light,) = lights(document)
    assert (light.state, light.kind, light.block) == (state, "controller", "law")


def test_claims_about_runs_are_not_proved():
    document, _ = marked(LOOP + "require iae <= 9§")
    assert prove(document) is False
    assert [(x.state, x.text) for x in lights(document)] == [("unknown", "judged by a run")]


def test_a_text_with_mistakes_is_not_proved():
    document, _ = marked(BASE + "require tip >= 0\nrequire tap >= 0§")
    assert prove(document) is False
    assert [x.text for x in lights(document)] == ["not proved: there are mistakes"] * 2


def test_a_newer_text_stops_a_proof():
    document, _ = marked(BASE + "require tip <= 1\nrequire tip >= 0§")
    asked = iter([False, True])
    with pytest.raises(StoppedError):
        prove(document, stopped=lambda: next(asked))
    assert [x.state for x in lights(document)] == ["refuted", "unknown"]


def test_a_newer_text_stops_a_subdivision():
    text = BASE.replace("center_average", "centroid").replace("small=0 large=most", "small large")
    document, _ = marked(text + "require (tip - 10) * (service - 5) <= 40.1§")
    count = 0

    def stopped():
        nonlocal count
        count += 1
        return count > 1

    with pytest.raises(StoppedError):
        prove(document, LAST, stopped)


def test_what_is_open_is_proved_with_more_time():
    document, _ = marked(BASE + "require tip >= 0§")
    (at,) = (x.span.start for x in lights(document))
    document.verdicts[at, "tip"] = Undecided("tip >= 0", "no time")
    assert [x.text for x in lights(document)] == ["undecided: no time"]
    assert prove(document, LAST) is False
    assert [x.state for x in lights(document)] == ["proved"]


def test_what_is_settled_is_not_proved_again():
    document, _ = marked(BASE + "require tip >= 0§")
    prove(document, FIRST)
    asked = []
    prove(document, LAST, lambda: bool(asked.append(1)))
    assert [x.state for x in lights(document)] == ["proved"]
    assert len(asked) == 1


@pytest.mark.parametrize(("ends", "state"), [((0, 20), "proved"), ((0, 1), "refuted")])
def test_a_line_of_two_systems_has_the_worst_light(ends, state):
    shared = "param most = 20\nrequire tip <= 20 - low\n"
    one = BASE.replace("param most = 20\n", "param low = 0\n")
    other = BASE.replace("param most = 20\n", f"param low = {ends[0] if state == 'proved' else 3}\n")
    document, _ = marked(shared + one + other.replace("system tip", "system tap") + "§")
    prove(document)
    assert [x.state for x in lights(document)] == [state], document.mistakes
