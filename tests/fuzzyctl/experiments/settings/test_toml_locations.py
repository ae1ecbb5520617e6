from fuzzyctl.experiments.settings.toml_locations import key_places

TEXT = """\
name = "x"
[run]
dt = 0.1
"quoted key" = 1

[[obstacles]]
x = 1.0
[[obstacles]]
x = 2.0

[robots.leader]
friction.coulomb = 3
inline = { a = 1 }
"""


def line(path):
    start, _ = key_places(TEXT)[path]
    return TEXT[:start].count("\n") + 1


class TestKeyPlaces:
    def test_reads_keys_in_quotes_as_toml_does(self):
        text = '"esc\\u0061pe".x = 1\n[\'li\\teral\'."a\\"b=".c]\n"\'" = 2\n'
        assert list(key_places(text)) == [("escape", "x"), ("li\\teral", 'a"b=', "c"), ("li\\teral", 'a"b=', "c", "'")]

    def test_finds_keys_of_the_top_and_of_tables(self):
        assert line(("name",)) == 1
        assert line(("run", "dt")) == 3
        assert line(("run", "quoted key")) == 4

    def test_counts_arrays_of_tables(self):
        assert line(("obstacles", "0", "x")) == 7
        assert line(("obstacles", "1", "x")) == 9

    def test_finds_tables_themselves_and_dotted_keys(self):
        assert line(("robots", "leader")) == 11
        assert line(("robots", "leader", "friction", "coulomb")) == 12

    def test_knows_only_the_parent_of_a_key_in_an_inline_table(self):
        assert line(("robots", "leader", "inline")) == 13
        assert ("robots", "leader", "inline", "a") not in key_places(TEXT)
