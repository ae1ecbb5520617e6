import pytest

from fuzzyctl import check, load, load_all, loads
from fuzzyctl.diagnostics.diagnostic import ArgumentError, DiagnosticError
from fuzzyctl.support.shipped import rules_folder

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

    def test_all_systems_of_a_file_are_read(self, tmp_path):
        both = "".join((rules_folder() / f"{n}.fz").read_text(encoding="utf-8") for n in ("tipper", "boundary_layer"))
        (tmp_path / "both.fz").write_text(both, encoding="utf-8")
        assert [s.name for s in load_all(tmp_path / "both.fz")] == ["tipper", "boundary_layer"]


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


CHAIN = """
system s
defuzzifier weighted_average
ACTIVATION
param unused = 3
input e in [-1, 1]
  terms N Z P
output m in [0, 1]
  terms lo hi
output u in [-5, 5] else 0
  a = constant(1)
  b = function(e)
table m = e
     N   Z   P
  |  lo  hi  hi
if m is lo then u is a
if m is hi then u is b
"""


class TestWhatOnlyPlansFound:
    """It has a place, and costs no other diagnostic."""

    def codes(self, text, tmp_path):
        (tmp_path / "s.fz").write_text(text, encoding="utf-8")
        found = check(tmp_path / "s.fz")[1]
        assert all(d.span is not None for d in found)
        return [(d.code, d.span.line) for d in found]

    @pytest.mark.parametrize("activation", ["highest(count=1)", "proportional"])
    def test_activation_that_compares_rules_that_wait(self, tmp_path, activation):
        text = CHAIN.replace("ACTIVATION", f"activation {activation}")
        assert self.codes(text, tmp_path) == [("FZ214", 4), ("FZ216", 5)]
        with pytest.raises(DiagnosticError, match="compares all rules at once"):
            loads(text)

    def test_a_function_that_is_read(self, tmp_path):
        text = CHAIN.replace("ACTIVATION", "").replace("if m is hi then u is b", "if u is b then m is hi")
        text = text.replace("if m is lo then u is a", "if e is P then u is b")
        assert self.codes(text, tmp_path)[-1] == ("FZ214", 17)


def test_a_claim_that_does_not_hold_is_an_error_and_the_system_is_returned(tmp_path):
    rules, claim = GAP.replace("TOP", "9"), "require u <= 0.4\n"
    (tmp_path / "a.fz").write_text(rules + claim, encoding="utf-8")
    system, found = check(tmp_path / "a.fz")
    assert [d.code for d in found if d.severity == "error"] == ["FZ402"]
    assert system == check(system)[0] == load(tmp_path / "a.fz")
    (tmp_path / "a.fz").write_text(GAP.replace("TOP", "5") + claim, encoding="utf-8")
    assert check(tmp_path / "a.fz")[0] is None
