"""What is known of a system that was written so before is what a first look at it finds."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fuzzyctl.testing import check_text
from tests import sizes
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM

TWO = (
    "param wide = 2\ninput shared in [0, wide]\n  terms near far\n"
    + SYSTEM
    + SYSTEM.replace("system tip", "system other")
)
TABLE = 'system t\ninput x in [0, 1]\n  terms a b\noutput y in [0, 1]\n  terms p q\ntable y = x from "t.csv"\n'
USER = 'system t\nuse "used.fz"\noutput y in [0, 1]\n  terms p q\nif x is a then y is p\nif x is b then y is q\n'


def found(text, folder=None):
    return [(d.code, d.message, d.place) for d in check_text(text, folder=folder)[1]]


@pytest.fixture(autouse=True)
def known(monkeypatch):
    """The systems that are known to be clean: none at first."""
    systems = set()
    monkeypatch.setattr("fuzzyctl.loading.examination._CLEAN", systems)
    return systems


def test_clean_systems_are_known_and_others_are_not(known):
    clean = TWO.replace("hedge hardly(d) = d ^ 3\n", "")
    assert found(clean) == []
    assert len(known) == 2
    assert found(TWO) != []
    assert len(known) == 2


@pytest.mark.parametrize(
    ("name", "first", "then", "text"),
    [
        ("t.csv", "corner,a,b\n,p,q\n", "corner,a,b\n,p,p\n", TABLE),
        ("used.fz", "input x in [0, 1]\n  terms a b\n", "input x in [0, 0]\n  terms a b\n", USER),
    ],
)
def test_files_that_it_reads_may_change(name, first, then, text, tmp_path, known):
    (tmp_path / name).write_text(first)
    assert found(text, tmp_path) == []
    (tmp_path / name).write_text(then)
    changed = found(text, tmp_path)
    known.clear()
    assert changed == found(text, tmp_path) != []


def test_what_stands_before_the_systems_may_change():
    clean = TWO.replace("hedge hardly(d) = d ^ 3\n", "").replace("service in [0, 10]", "service in [0, wide]")
    assert found(clean) == []
    assert len(found(clean.replace("wide = 2", "wide = 0"))) == 2


def test_few_are_kept(known, monkeypatch):
    monkeypatch.setattr("fuzzyctl.loading.examination._MOST_CLEAN", 5)
    for k in range(12):
        found(f"system t{k}\n" + SYSTEM.partition("\n")[2].replace("hedge hardly(d) = d ^ 3\n", ""))
    assert 0 < len(known) <= 5


@st.composite
def edits(draw):
    """Return versions of a text, each with some characters of the one before replaced."""
    text = draw(st.sampled_from([TWO, LOOP, SYSTEM]))
    versions = [text]
    for _ in range(draw(st.integers(1, 5))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.integers(0, 8)))
        text = text[:start] + draw(st.sampled_from(["", "\n", "a", "0", "# ", "P", "x is P"])) + text[end:]
        versions += [text, versions[0]]
    return versions


@settings(
    max_examples=sizes.examples(100, 5), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(versions=edits())
def test_every_version_has_the_diagnostics_of_a_first_look(known, versions):
    known.clear()
    again = [found(text) for text in versions]
    for text, expected in zip(versions, again, strict=True):
        known.clear()
        assert found(text) == expected
