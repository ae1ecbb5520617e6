"""Answers of the language server: in editor/FEATURE.txt a text with cursor marks, and below it what is answered.

`==== TITLE | ARGUMENT` begins a case, and `----` its answers: one for each mark, or one about the whole text. A case
counts once for each of its marks, one without marks once. After an intended change:
FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest tests/golden/test_editor.py, then read the difference.
"""

import os
import re
from pathlib import Path

import pytest

from tests.golden import answers

FOLDER = Path(__file__).parent / "editor"
FEATURES = {f.__name__: f for f in (*answers.AT_PLACES, *answers.OF_TEXTS)}
#: Fewest cases of a feature.
FEWEST = 20
SHARED = "input shared in [0, 1]\n  terms near far\n"
CASE = re.compile(r"^==== (?P<title>[^|\n]*)(?:\| (?P<argument>[^\n]*))?\n(?P<text>.*?)^----\n", re.M | re.S)


def cases(feature):
    """Return title, argument and marked text of the cases of a feature."""
    found = CASE.finditer((FOLDER / f"{feature}.txt").read_text(encoding="utf-8"))
    return [(m["title"].rstrip(), m["argument"] or "", m["text"]) for m in found]


def written(feature, folder):
    """Return the file of a feature with the answers as they are now."""
    answer, parts = FEATURES[feature], []
    for title, argument, text in cases(feature):
        case = answers.Case(text, argument, folder)
        if answer in answers.AT_PLACES:
            lines = []
            for mark, place in zip(
                sorted(set(text) & set(answers.MARKS), key=answers.MARKS.index), case.places, strict=True
            ):
                first, *more = answer(case, place)
                lines += [f"{mark} {first}", *(f"  {line}" for line in more)]
        else:
            lines = answer(case)
        head = f"==== {title}{f' | {argument}' if argument else ''}\n"
        parts.append(f"{head}{text}----\n" + "".join(f"{line}".rstrip() + "\n" for line in lines or ["nothing"]))
    return "\n".join(parts)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "shared.fz").write_text(SHARED)
    return tmp_path


@pytest.mark.parametrize("feature", FEATURES)
def test_answers(feature, folder):
    path, found = FOLDER / f"{feature}.txt", written(feature, folder)
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        path.write_text(found, encoding="utf-8")
    assert path.read_text(encoding="utf-8") == found


@pytest.mark.parametrize("feature", FEATURES)
def test_a_feature_has_cases(feature):
    count = sum(max(1, sum(text.count(m) for m in answers.MARKS)) for _, _, text in cases(feature))
    if FEATURES[feature] in answers.OF_TEXTS:
        count = len(cases(feature))
    assert count >= FEWEST
