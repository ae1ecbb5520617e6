from fuzzyctl.diagnostics.fixes import Fix, Replacement, fixed, respelt, respelt_as_suggested
from fuzzyctl.diagnostics.source import SourceText, Span

KNOWN = ["service", "food", "tip"]


def replacement(source, start, end, text):
    return Replacement(Span(source, start, end), text)


def fix_of(text, word, meant, known=KNOWN):
    source = SourceText("a.fz", text)
    at = text.rindex(word)
    return source, respelt(Span(source, at, at + len(word)), word, meant, known)


class TestFixed:
    def test_replaces_inserts_and_removes(self):
        source = SourceText("a.fz", "abcdef")
        fixes = [
            Fix((replacement(source, 0, 1, "X"), replacement(source, 3, 3, "--")), "sure"),
            Fix((replacement(source, 4, 6, ""),), "likely"),
        ]
        assert fixed(source, fixes) == "Xbc--d"

    def test_of_two_that_overlap_the_first_counts(self):
        source = SourceText("a.fz", "abcdef")
        first, second = replacement(source, 1, 4, "1"), replacement(source, 3, 5, "2")
        assert fixed(source, [Fix((first,), "sure"), Fix((second,), "sure")]) == "a1ef"
        twice = Fix((replacement(source, 2, 2, "x"),), "sure")
        assert fixed(source, [twice, twice]) == "abxcdef"

    def test_a_fix_of_another_file_is_left_out_as_a_whole(self):
        source, other = SourceText("a.fz", "ab"), SourceText("b.fz", "ab")
        fix = Fix((replacement(source, 0, 1, "x"), replacement(other, 0, 1, "x")), "sure")
        assert fixed(source, [fix]) == "ab"


class TestRespelt:
    def test_one_letter_off_a_single_name_is_sure(self):
        for word in ("servce", "serice", "sevrice", "servvice", "Service", "serv_ice"):
            source, fix = fix_of(f"service service {word}", word, "service")
            assert fix.applicability == "sure"
            assert fixed(source, [fix]) == "service service service"

    def test_two_letters_off_and_short_or_ambiguous_names_are_likely(self):
        assert fix_of("service service srvce", "srvce", "service")[1].applicability == "likely"
        assert fix_of("NB NB NM NM NX", "NX", "NB", ["NB", "NM"])[1].applicability == "likely"
        assert fix_of("tap tap tip tip tup", "tup", "tip", ["tip", "tap"])[1].applicability == "likely"

    def test_the_slip_is_in_the_declaration_where_all_uses_agree(self):
        source, fix = fix_of("input servce\nservice service", "service", "servce", ["servce"])
        assert fix.applicability == "sure"
        assert fixed(source, [fix]) == "input service\nservice service"

    def test_either_may_be_the_slip_where_each_stands_once(self):
        # The comment is no use of the name.
        _, fix = fix_of("input servce # service\nif service", "service", "servce", ["servce"])
        assert fix.applicability == "likely"

    def test_of_a_call_only_the_name_is_replaced(self):
        source = SourceText("a.fz", "let y = sim(x) + sin(x) + sin(0)")
        fix = respelt(Span(source, 8, 14), "sim", "sin", ["sin", "cos"])
        assert fixed(source, [fix]) == "let y = sin(x) + sin(x) + sin(0)"

    def test_nothing_known_gives_none(self):
        source = SourceText("a.fz", "abc")
        assert respelt_as_suggested(Span(source, 0, 3), "abc", ["quite", "other"]) is None
        assert respelt(None, "abc", "abd", ["abd"]) is None
        assert respelt(Span(source, 0, 3), "other", "abd", ["abd"]) is None

    def test_data_counts_lines_and_columns_from_one(self):
        source = SourceText("a.fz", "one\ntwo")
        fix = Fix((replacement(source, 4, 7, "2"),), "sure")
        edit = {"line": 2, "column": 1, "end_line": 2, "end_column": 4, "text": "2"}
        assert fix.as_dict() == {"applicability": "sure", "edits": [edit]}
