"""Colours of pictures, pages, the studio and the robots' figures are told apart without a working green receptor."""

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import fuzzyctl

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "fuzzyctl/page/assets/page.css"
#: Deuteranopia on linear RGB (Machado, Oliveira and Fernandes 2009, Table 1, severity 1.0).
DEUTERANOPIA = np.array(
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
)
#: From linear sRGB to XYZ under D65 (IEC 61966-2-1).
XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
#: Least difference of two series, and of one from what it is drawn on. A difference of 1 is just seen side by side.
APART, FROM_BACK = 10.0, 15.0


@pytest.fixture(scope="module")
def series():
    """The colours of the runs of a picture, before they begin again."""
    run = fuzzyctl.simulate(fuzzyctl.load("water_tank", block=fuzzyctl.Loop), backend="python")
    labels = [f"{k}" for k in range(12)]
    lines = fuzzyctl.plot.runs(*[run] * 12, labels=labels)[0].lines
    return list(dict.fromkeys(line.get_color() for line in lines if line.get_linestyle() == "-"))


def lab(color, vision):
    """Return a colour such as '#0072B2' in CIELAB, as it is seen."""
    share = np.array([int(color[k : k + 2], 16) for k in (1, 3, 5)]) / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    x = XYZ @ np.clip(vision @ linear, 0, 1) / (XYZ @ np.ones(3))
    f = np.where(x > 216 / 24389, np.cbrt(x), (24389 / 27 * x + 16) / 116)
    return 116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])


def ciede2000(one, two):
    """Return the difference of two colours in CIELAB (Sharma, Wu and Dalal 2005)."""
    (l1, a1, b1), (l2, a2, b2) = one, two
    mean = (np.hypot(a1, b1) + np.hypot(a2, b2)) / 2
    wider = 1.5 - 0.5 * np.sqrt(mean**7 / (mean**7 + 25**7))
    c1, c2 = np.hypot(a1 * wider, b1), np.hypot(a2 * wider, b2)
    h1, h2 = (np.degrees(np.arctan2(b, a * wider)) % 360 for a, b in ((a1, b1), (a2, b2)))
    turn = (h2 - h1 + 180) % 360 - 180 if c1 * c2 else 0.0
    lightness, c, h = (l1 + l2) / 2, (c1 + c2) / 2, h1 + turn / 2 if c1 * c2 else h1 + h2
    cos = [np.cos(np.radians(k * h - shift)) for k, shift in ((1, 30), (2, 0), (3, -6), (4, 63))]
    t = 1 - 0.17 * cos[0] + 0.24 * cos[1] + 0.32 * cos[2] - 0.20 * cos[3]
    light = (l2 - l1) / (1 + 0.015 * (lightness - 50) ** 2 / np.sqrt(20 + (lightness - 50) ** 2))
    chroma = (c2 - c1) / (1 + 0.045 * c)
    hue = 2 * np.sqrt(c1 * c2) * np.sin(np.radians(turn / 2)) / (1 + 0.015 * c * t)
    turned = np.sin(np.radians(60 * np.exp(-(((h % 360 - 275) / 25) ** 2))))
    rotation = -2 * np.sqrt(c**7 / (c**7 + 25**7)) * turned
    return float(np.sqrt(light**2 + chroma**2 + hue**2 + rotation * chroma * hue))


@pytest.mark.parametrize(
    ("one", "two", "difference"),
    [
        ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
        ((50.0, 0.0, 0.0), (50.0, -1.0, 2.0), 2.3669),
        ((50.0, 2.5, 0.0), (73.0, 25.0, -18.0), 27.1492),
        ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
        ((22.7233, 20.0904, -46.6940), (23.0331, 14.9730, -42.5619), 2.0373),
        ((90.8027, -2.0831, 1.4410), (91.1528, -1.6435, 0.0447), 1.4441),
    ],
)
def test_the_difference_is_that_of_the_published_pairs(one, two, difference):
    assert ciede2000(one, two) == pytest.approx(difference, abs=5e-5)


def backgrounds():
    """Return what pages and pictures are drawn on, light and dark."""
    style = PAGE.read_text(encoding="utf-8")
    light, dark = (re.findall(rf"--{name}: (#[0-9a-f]{{6}})", style) for name in ("back", "card"))
    return set(light + dark)


@pytest.mark.parametrize("vision", [np.eye(3), DEUTERANOPIA], ids=["trichromat", "deuteranope"])
def test_series_are_told_apart(vision, series):
    assert len(series) > 5
    for one, two in combinations(series, 2):
        assert ciede2000(lab(one, vision), lab(two, vision)) >= APART, (one, two)
    for back in backgrounds():
        for color in series:
            # On a page, black takes the colour of the text.
            if color != "#000000":
                assert ciede2000(lab(color, vision), lab(back, vision)) >= FROM_BACK, (color, back)


def test_red_and_green_of_the_same_lightness_would_not_be():
    red, green = (lab(color, DEUTERANOPIA) for color in ("#b05040", "#6a7a30"))
    assert ciede2000(red, green) < APART < ciede2000(*(lab(c, np.eye(3)) for c in ("#b05040", "#6a7a30")))


@pytest.mark.parametrize("scheme", [0, 1], ids=["light", "dark"])
def test_errors_warnings_and_links_of_the_studio_are_told_apart(scheme):
    style = (ROOT / "apps/studio/src/style.css").read_text(encoding="utf-8")
    found = dict(re.findall(r"--(blue|red|brown): light-dark\(([^)]*)\)", style))
    colors = [both.split(", ")[scheme] for both in found.values()]
    assert len(colors) == 3
    for one, two in combinations(colors, 2):
        assert ciede2000(lab(one, DEUTERANOPIA), lab(two, DEUTERANOPIA)) >= APART, (one, two)


@pytest.mark.parametrize("scheme", [0, 1], ids=["light", "dark"])
def test_claims_that_hold_fail_and_are_undecided_are_told_apart(scheme):
    style = PAGE.read_text(encoding="utf-8")
    names = [re.search(rf"\.{kind} {{ color: var\(--(\w+)\)", style)[1] for kind in ("holds", "fails", "undecided")]
    own = [re.findall(rf"--{name}: (#[0-9a-fA-F]{{6}})", style)[scheme] for name in [*names, "text"]]
    for one, two in combinations(own, 2):
        assert ciede2000(lab(one, DEUTERANOPIA), lab(two, DEUTERANOPIA)) >= APART, (one, two)
