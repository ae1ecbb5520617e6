import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import decode, examine, load, loads
from fuzzyctl.support.shipped import rules_folder

WORDS = "system input output param table if then is and or not in x u N P triangle terms unit else rate adaptive weight"
SIGNS = '[ ] ( ) , = | @ * / + - ^ . 1 0.5 -1 inf require within when # σ ½ ∞ \\ $ "'
TOKENS = [*WORDS.split(), *SIGNS.split(), "\n", "\n"]


def codes(error):
    return [d.code for d in error.value.diagnostics]


class TestLoad:
    def test_a_file_becomes_a_system_that_knows_its_path(self):
        path = rules_folder() / "ais_reaction.fz"
        system = load(path)
        assert (system.name, len(system.rules), system.path) == ("ais_reaction", 25, str(path))

    @pytest.mark.parametrize(
        ("content", "code"),
        [
            (b"\x00\x01\x02", "FZ002"),
            (b"system s \xff\xfe", "FZ002"),
            (b"", "FZ004"),
            (b"\n\n# nothing\n", "FZ004"),
            (b"x" * (1 << 20) + b"y", "FZ003"),
        ],
    )
    def test_what_is_no_rule_file_is_diagnosed(self, tmp_path, content, code):
        path = tmp_path / "bad.fz"
        path.write_bytes(content)
        with pytest.raises(DiagnosticError) as error:
            load(path)
        assert codes(error) == [code]

    def test_a_missing_file_and_a_directory_are_diagnosed(self, tmp_path):
        (tmp_path / "tipper.fz").write_text("")
        for path, part in ((tmp_path / "tiper.fz", "tipper.fz"), (tmp_path, "directory")):
            with pytest.raises(DiagnosticError, match=part) as error:
                load(path)
            assert codes(error) == ["FZ001"]

    def test_the_size_bound_can_be_set(self, tmp_path, base):
        path = tmp_path / "a.fz"
        path.write_text(base)
        with pytest.raises(DiagnosticError):
            load(path, max_bytes=10)

    def test_a_byte_order_mark_and_crlf_are_accepted(self, tmp_path, base):
        path = tmp_path / "a.fz"
        path.write_bytes(b"\xef\xbb\xbf" + base.replace("\n", "\r\n").encode())
        assert load(path) == loads(base)


class TestExamine:
    def test_errors_come_in_the_order_of_their_places(self, changed):
        text = changed(("P = triangle(0, 1, inf)", "P = triangle(0, 1)"), ("Z |  N  P", "Z |  N  Q"))
        system, diagnostics = examine(SourceText("t", text))
        assert system is None
        assert [(d.code, d.span.line) for d in diagnostics] == [("FZ303", 6), ("FZ203", 19)]

    def test_warnings_do_not_stop_loading(self, changed):
        system, diagnostics = examine(SourceText("t", changed(("\ninput x", "\nparam k = 1\ninput x"))))
        assert system is not None
        assert [d.code for d in diagnostics] == ["FZ216"]


class TestHostileInput:
    @given(st.binary(max_size=200))
    def test_bytes_give_a_system_or_diagnostics(self, data):
        with contextlib.suppress(DiagnosticError):
            examine(decode(data, "t"))

    @given(st.lists(st.sampled_from(TOKENS), max_size=60))
    def test_token_soup_gives_a_system_or_diagnostics(self, tokens):
        system, diagnostics = examine(SourceText("t", " ".join(tokens)))
        assert system is not None or diagnostics

    @given(st.data())
    def test_a_mutated_file_gives_a_system_or_diagnostics(self, data):
        text = (rules_folder() / "ais_reaction.fz").read_text(encoding="utf-8")
        lines = text.split("\n")
        for _ in range(data.draw(st.integers(1, 3))):
            i = data.draw(st.integers(0, len(lines) - 1))
            action = data.draw(st.sampled_from(["drop", "double", "cut", "swap"]))
            if action == "drop":
                del lines[i]
            elif action == "double":
                lines.insert(i, lines[i])
            elif action == "cut":
                words = lines[i].split()
                lines[i] = " ".join(words[: data.draw(st.integers(0, len(words)))])
            else:
                lines[i] = " ".join(reversed(lines[i].split()))
        system, diagnostics = examine(SourceText("t", "\n".join(lines)))
        assert system is not None or diagnostics
        assert all(d.span is not None for d in diagnostics)
