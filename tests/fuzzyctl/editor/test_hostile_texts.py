"""Every answer for texts that are cut off, mixed up or no rule files: a right one or an empty one, never an error."""

from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.editor.document import Document
from tests import sizes
from tests.bench.editor import ANSWERS
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM

PIECES = ["\r\n", "\r", "🙂", "|", "(", '"', "#", "terms", "table", "input x in [0, 1]\n", "\0", " = ", "x x y"]


@st.composite
def texts(draw):
    """Return a text that was a rule file, and an offset in it."""
    text = draw(st.sampled_from([SYSTEM, LOOP]))
    for _ in range(draw(st.integers(0, 3))):
        start = draw(st.integers(0, len(text)))
        end = draw(st.integers(start, min(len(text), start + 60)))
        text = text[:start] + draw(st.sampled_from(["", *PIECES])) + text[end:]
    return text, draw(st.integers(0, len(text)))


@settings(max_examples=sizes.examples(200, 30), deadline=None)
@given(texts())
def test_every_answer_is_one(place):
    text, offset = place
    document = Document(SourceText("a.fz", text))
    for answer in ANSWERS.values():
        answer(document, offset)
