import pytest

from fuzzyctl import ArgumentError, check, load, load_all, loads

GAP = """
system s
input x in [0, 10]
  a = triangle(-inf, 1, TOP)
  b = triangle(6, 8, inf)
output u in [0, 1]
  lo = triangle(0, 0.2, 0.4)
  hi = triangle(0.5, 0.7, 1)
if x is a then u is lo
if x is b then u is hi
"""


class TestLoad:
    @pytest.mark.parametrize("path", [None, 3, b"rules/tipper.fz", "a\0b", ["a"]])
    def test_what_is_no_path_is_named(self, path):
        for function in (load, load_all, check):
            with pytest.raises(ArgumentError, match="expected the path of a rule file"):
                function(path)

    @pytest.mark.parametrize("text", [None, b"system s", 3])
    def test_what_is_no_text_is_named(self, text):
        with pytest.raises(ArgumentError, match="expected the text of a rule file"):
            loads(text)


class TestCheckOfASystem:
    def test_finds_what_it_finds_in_a_file(self, tmp_path):
        (tmp_path / "gap.fz").write_text(GAP.replace("TOP", "4"), encoding="utf-8")
        system = load(tmp_path / "gap.fz")
        found, diagnostics = check(system)
        assert found is None
        assert sorted(d.code for d in diagnostics) == sorted(d.code for d in check(tmp_path / "gap.fz")[1])
        assert "FZ401" in {d.code for d in diagnostics}

    def test_returns_a_sound_one(self):
        system = loads(GAP.replace("TOP", "7"))
        assert check(system) == (system, [])


def test_a_claim_that_does_not_hold_is_an_error_and_the_system_is_returned(tmp_path):
    rules, claim = GAP.replace("TOP", "9"), "require u <= 0.4\n"
    (tmp_path / "a.fz").write_text(rules + claim, encoding="utf-8")
    system, found = check(tmp_path / "a.fz")
    assert [d.code for d in found if d.severity == "error"] == ["FZ402"]
    assert system == check(system)[0] == load(tmp_path / "a.fz")
    (tmp_path / "a.fz").write_text(GAP.replace("TOP", "5") + claim, encoding="utf-8")
    assert check(tmp_path / "a.fz")[0] is None
