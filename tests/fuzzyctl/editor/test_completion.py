import pytest

from fuzzyctl.editor.completion import complete
from fuzzyctl.editor.words import functions, keywords, memberships, snippet
from tests.effort import at_most
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM, marked

BASE = SYSTEM.replace("require tip >= 0\n", "")
ROW = "  good | small  large  large\n"
HEADER = "         bad    fine   great\n"

#: A text with a mark, and the first labels proposed there; `...` where more may follow.
CASES = {
    "terms of the variable before is": (BASE + "if service is §", "poor good not any very ..."),
    "terms after a letter": (BASE + "if service is p§", "poor good ..."),
    "terms after a hedge": (BASE + "if service is very §", "poor good ..."),
    "terms of another variable": (BASE + "if service is poor and food is §", "bad fine great not any ..."),
    "terms of an output": (BASE + "if service is poor then tip is §", "small large not ..."),
    "variables after if": (BASE + "if §", "service food tip"),
    "variables after and": (BASE + "if service is poor and §", "service food tip"),
    "variables after a parenthesis": (BASE + "if (service is poor or §", "service food tip"),
    "outputs after then": (BASE + "if service is poor then §", "tip"),
    "outputs of otherwise": (BASE + "otherwise §", "tip"),
    "own hedges": (BASE + "if service is hard§", "poor good not any ... hardly"),
    "cells": (BASE.replace(ROW, "  good | §\n"), "small large"),
    "a cell in the middle": (BASE.replace(ROW, "  good | small  l§\n"), "small large"),
    "columns that are missing": (BASE.replace(HEADER, "         bad §\n"), "fine great"),
    "rows that are missing": (BASE.replace(ROW, "  §\n"), "good fz system ..."),
    "statements": ("§", "fz system source use ..."),
    "statements of a controller": (LOOP.split("plant")[0] + "§", "controller plant loop system source use param ..."),
    "values of settings": ("system t\nand §", "min product ..."),
    "defuzzifiers": ("system t\ndefuzzifier c§", "centroid bisector ..."),
    "activations": ("system t\nactivation §", "general first last ..."),
    "profiles": ("system t\nsemantics §", "exact ..."),
    "membership functions": ("system t\ninput x in [0, 1]\n  low = §", "triangle trapezoid rectangle ramp ..."),
    "outputs of a table": (BASE + "table §", "tip"),
    "inputs of a table": (BASE + "table tip = service x §", "service food tip"),
    "terms of": (BASE + "input mood in [0, 1] terms of §", "service food tip"),
    "expressions of a guarantee": (BASE + "require §", "most service food tip abs min max ..."),
    "states of next": (LOOP.replace("next level", "next §"), "level"),
    "states of der": (LOOP.replace("der x =", "der §"), "x"),
    "names and operators of a controller": (
        LOOP.replace("gain * surface", "§gain * surface"),
        "r y gain level error u abs ... clamp where previous ...",
    ),
    "members of a block": (LOOP.replace("law(r, lag.y)", "law(r, lag.§)"), "y"),
    "blocks that can be added": (LOOP.replace("law = law(r, lag.y)", "law = §"), "law lag"),
    "plants of one line": ("plant p = §", "tf zpk ss python fmu"),
    "measures": (LOOP.replace("iae(lag.y, r)", "§"), "overshoot rise_time settling ..."),
    "signals": (LOOP.replace("let r = steps(0: 1)", "let r = §"), "law lag abs ... steps pulse ramp ..."),
    "nothing in a comment": (BASE + "# if service is §", ""),
    "nothing in a text": ('system t "is §', ""),
}


@pytest.mark.parametrize("line", ["@ = clamp(@", "@ = @ + (@"])
@pytest.mark.parametrize("letter", ["v", "Ω", "a\u0301"])
def test_long_names_take_no_longer(line, letter):
    with at_most(1.0):
        complete(*marked(LOOP + line.replace("@", letter * 25) + "§"))


@pytest.mark.parametrize("case", CASES)
def test_proposals(case):
    text, wanted = CASES[case]
    labels = [item.label for item in complete(*marked(text)).items]
    at = 0
    for k, part in enumerate(wanted.split("...")):
        for label in part.split():
            assert label in labels[at:], (label, labels)
            if k == 0:
                assert labels[at] == label, labels
            at = labels.index(label, at) + 1
    if "..." not in wanted:
        assert at == len(labels), labels[at:]


def test_what_is_begun_is_replaced():
    document, offset = marked(BASE + "if service is po§")
    assert complete(document, offset).span.text == "po"


def test_an_item_says_what_it_is():
    items = {i.label: i for i in complete(*marked("system t\ninput x in [0, 1]\n  low = §")).items}
    assert items["triangle"].detail == "triangle(left, peak, right)"
    assert items["triangle"].what
    items = {i.label: i for i in complete(*marked(LOOP.replace("gain * s", "§gain * s"))).items}
    assert items["gain"].detail == "param gain in [0, 9] = 2"


@pytest.mark.parametrize("block", ["", "controller", "plant", "loop"])
def test_skeletons_begin_with_their_word_and_have_placeholders(block):
    for word in (*keywords(block), *functions(block), *memberships()):
        skeleton = snippet(word)
        if skeleton:
            assert skeleton.startswith(word.name)
            assert "${1:" in skeleton
            assert skeleton.count("{") == skeleton.count("}")


@pytest.mark.parametrize(
    ("text", "label", "skeleton"),
    [
        ("§", "input", "input ${1:name} in [${2:0}, ${3:1}]\n  terms ${4:low high}"),
        (LOOP.split("plant")[0] + "§", "input", "input ${1:name}"),
        (BASE.replace(ROW, "  §\n"), "good", "good |  ${1:.}  ${2:.}  ${3:.}"),
        ("system t\ninput x in [0, 1]\n  low = §", "triangle", "triangle(${1:left}, ${2:peak}, ${3:right})"),
        (BASE + "require §", "most", ""),
    ],
)
def test_skeletons_of_proposals(text, label, skeleton):
    items = {i.label: i for i in complete(*marked(text)).items}
    assert items[label].snippet == skeleton
