import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.editor.document import Document
from fuzzyctl.support.shipped import overlaid, read_source

USER = 'system t\ndefuzzifier center_average\nuse "shared.fz"\noutput tip in [0, 1] else 0\n  terms small=0 large=1\n'
USER += "if service is poor then tip is small\nif service is good then tip is large\n"
SHARED = "input service in [0, 10]\n  terms poor good\n"


def document(folder, buffers):
    return Document(SourceText(str(folder / "a.fz"), USER), folder, {str(folder / n): t for n, t in buffers.items()})


@pytest.mark.parametrize(
    ("saved", "shown", "codes"),
    [
        (SHARED, None, set()),
        (None, SHARED, set()),
        (SHARED.replace("good", "bad"), SHARED, set()),
        (SHARED, SHARED.replace("good", "bad"), {"FZ203"}),
        (None, None, {"FZ218"}),
    ],
)
def test_texts_that_are_not_saved_are_used(tmp_path, saved, shown, codes):
    if saved is not None:
        (tmp_path / "shared.fz").write_text(saved)
    found = document(tmp_path, {} if shown is None else {"shared.fz": shown})
    assert {d.code for d in found.mistakes if d.severity == "error"} == codes
    assert str(tmp_path / "shared.fz") in found.used
    if shown is not None:
        assert {"poor"} <= {s.name for s in found.symbols.all}


def test_files_are_read_again_afterwards(tmp_path):
    (tmp_path / "a.fz").write_text("system a\n")
    with overlaid({str(tmp_path / "a.fz"): "system b\n"}):
        assert read_source(tmp_path / "a.fz").text == "system b\n"
    assert read_source(tmp_path / "a.fz").text == "system a\n"


def test_nothing_outside_the_folder_is_used(tmp_path):
    inner = tmp_path / "inner"
    inner.mkdir()
    text = USER.replace("shared.fz", "../shared.fz")
    found = Document(SourceText(str(inner / "a.fz"), text), inner, {str(tmp_path / "shared.fz"): SHARED})
    assert "FZ218" in {d.code for d in found.mistakes}
