import pytest

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang.parser import parse
from fuzzyctl.loading.assembly import files_read, split
from fuzzyctl.loading.load import examine_all, load, load_all, loads
from fuzzyctl.support.shipped import read_source
from tests.fuzzyctl.editor.marked import LOOP

SHARED = "param k = 2\n\ninput e in [-1, 1]\n  terms N Z P\n\ninput d in [-5, 5]\n  terms N P\n"
TWO = (
    SHARED
    + """
system one
defuzzifier weighted_average
output u in [-2, 2]
  terms N=-1 Z=0 P=(k)
table u = e
     N  Z  P
  |  N  Z  P

system two
defuzzifier weighted_average
output v in [0, 1]
  terms A=0 B=1
table v = e x d
       N  P
  N |  A  B
  Z |  B  A
  P |  A  A
"""
)


def codes(path):
    _, diagnostics = examine_all(read_source(path), folder=path.parent)
    return [d.code for d in diagnostics]


class TestSeveralSystems:
    def test_what_they_share_is_held_once_in_memory(self):
        tree, _ = parse(SourceText("t", TWO))
        first, second = split(tree)
        assert first.shared is second.shared

    def test_what_stands_before_the_first_belongs_to_all_that_name_it(self):
        one, two = loads(TWO, block="one"), loads(TWO, block="two")
        assert [v.name for v in one.inputs] == ["e"]
        assert [v.name for v in two.inputs] == ["e", "d"]
        assert one(e=1.0) == 2.0
        assert two(e=-1.0, d=5.0) == 1.0

    def test_linear_consequents_count_all_shared_inputs(self):
        text = TWO.replace(
            "table u = e\n     N  Z  P\n  |  N  Z  P\n", "if e is N or not e is N then u is linear(1, 2, 0.5)\n"
        )
        one = loads(text, block="one")
        assert [v.name for v in one.inputs] == ["e", "d"]
        assert one(e=0.0, d=0.25) == 1.0

    def test_all_are_loaded_in_order_without_warnings(self, tmp_path):
        path = tmp_path / "two.fz"
        path.write_text(TWO)
        assert [s.name for s in load_all(path)] == ["one", "two"]
        assert codes(path) == []

    def test_a_mistake_in_a_shared_line_is_reported_once(self, tmp_path):
        path = tmp_path / "two.fz"
        path.write_text(TWO.replace("terms N Z P", "terms N Z N", 1))
        assert codes(path).count("FZ201") == 1

    def test_a_setting_of_its_own_replaces_the_shared_one(self, tmp_path):
        terms = "output u in [0, 1]\n  a = triangle(-inf, 0, 1)\n  b = triangle(0, 1, inf)\n"
        rules = "if e is N then u is a\nif e is P then u is b\n"
        shared = "and product\nimplication product\ndefuzzifier centroid\ninput e in [-1, 1]\n  terms N P\n"
        own = "defuzzifier center_average\nand min\n"
        text = f"{shared}system one\n{terms}{rules}system two\n{own}{terms}{rules}"
        systems, diagnostics = examine_all(SourceText("t.fz", text))
        assert diagnostics == []
        assert [s.method.defuzzifier.kind for s in systems] == ["centroid", "center_average"]
        assert [s.method.conjunction for s in systems] == ["product", "min"]
        assert [s.method.implication for s in systems] == ["product", "product"]

    def test_two_systems_of_one_name_are_refused(self, tmp_path):
        path = tmp_path / "two.fz"
        path.write_text(TWO.replace("system two", "system one"))
        assert codes(path) == ["FZ201"]


class TestUse:
    def write(self, folder, **files):
        for name, text in files.items():
            (folder / f"{name}.fz").write_text(text)
        return folder / "main.fz"

    def test_a_partition_written_once_serves_several_files(self, tmp_path):
        main = TWO.replace(SHARED, 'use "shared.fz"\n')
        path = self.write(tmp_path, main=main, shared=SHARED)
        assert load(path, block="one")(e=1.0) == 2.0
        assert codes(path) == []

    def test_used_files_may_use_files(self, tmp_path):
        path = self.write(
            tmp_path,
            main=TWO.replace(SHARED, 'use "a.fz"\n'),
            a='use "b.fz"\nparam k = 2\n',
            b=SHARED.replace("param k = 2\n", ""),
        )
        assert load(path, block="two")(e=-1.0, d=5.0) == 1.0

    def test_systems_and_settings_of_a_used_file_stay_there(self, tmp_path):
        path = self.write(tmp_path, main='use "two.fz"\n' + TWO.replace(SHARED, ""), two="and product\n" + TWO)
        assert load(path, block="one").method.conjunction == "min"

    def test_a_circle_is_diagnosed(self, tmp_path):
        path = self.write(tmp_path, main='use "a.fz"\n' + TWO, a='use "main.fz"\n')
        _, diagnostics = examine_all(read_source(path), folder=tmp_path)
        (circle,) = [d for d in diagnostics if d.code == "FZ218"]
        assert circle.facts == ("main.fz → a.fz → main.fz",)

    @pytest.mark.parametrize("name", ["/etc/hostname", "../outside.fz", "sub/../../outside.fz"])
    def test_files_elsewhere_cannot_be_read(self, tmp_path, name):
        folder = tmp_path / "inner"
        folder.mkdir()
        (tmp_path / "outside.fz").write_text(SHARED)
        path = self.write(folder, main=f'use "{name}"\n{TWO}')
        with pytest.raises(DiagnosticError, match="lies outside the folder"):
            load_all(path)

    def test_a_link_to_elsewhere_cannot_be_read(self, tmp_path):
        folder = tmp_path / "inner"
        folder.mkdir()
        (tmp_path / "outside.fz").write_text(SHARED)
        (folder / "link.fz").symlink_to(tmp_path / "outside.fz")
        with pytest.raises(DiagnosticError, match="lies outside the folder"):
            load_all(self.write(folder, main=f'use "link.fz"\n{TWO}'))

    def test_a_missing_file_and_a_text_without_a_folder_are_diagnosed(self, tmp_path):
        with pytest.raises(DiagnosticError, match="there is no such file"):
            load_all(self.write(tmp_path, main=f'use "no.fz"\n{TWO}'))
        with pytest.raises(DiagnosticError, match="no file can use no files"):
            loads('use "shared.fz"\n' + TWO, block="one")

    @pytest.mark.parametrize("name", ["no.fz", "../outside.fz", "folder.fz", "binary.fz", "main.fz"])
    def test_blocks_whose_file_cannot_be_used_have_one_mistake(self, tmp_path, name):
        folder = tmp_path / "inner"
        (folder / "folder.fz").mkdir(parents=True)
        (folder / "binary.fz").write_bytes(b"\xff\0")
        (tmp_path / "outside.fz").write_text("no rule file")
        path = self.write(folder, main=f'use "{name}"\n{LOOP}')
        assert codes(path) == ["FZ218"]

    def test_a_mistake_in_a_used_file_is_shown_there(self, tmp_path):
        path = self.write(
            tmp_path, main=TWO.replace(SHARED, 'use "a.fz"\n'), a=SHARED.replace("terms N P", "terms N@1 P@0")
        )
        with pytest.raises(DiagnosticError) as error:
            load_all(path)
        assert [str(d.span).rsplit("/", 1)[1] for d in error.value.diagnostics if d.code == "FZ301"] == ["a.fz:7:9"]


class TestCsvTables:
    MAIN = TWO.replace(
        "table v = e x d\n       N  P\n  N |  A  B\n  Z |  B  A\n  P |  A  A\n", 'table v = e x d from "t.csv"\n'
    )

    def test_a_table_is_read_from_a_file_beside(self, tmp_path):
        (tmp_path / "main.fz").write_text(self.MAIN)
        (tmp_path / "t.csv").write_bytes(b"\xef\xbb\xbf,N,P\r\nN, A,B\r\n\r\nZ,B ,0.25\r\nP,A*0.5,.\r\n")
        system = load(tmp_path / "main.fz", block="two")
        assert system(e=-1.0, d=5.0) == 1.0
        assert system(e=0.0, d=5.0) == 0.25
        assert len(system.rules) == 5

    @pytest.mark.parametrize(
        ("csv", "place"),
        [
            (",N,P\nN,A,B\nZ,B,Q\nP,A,A\n", "t.csv:3:5"),
            (",N,P\nN,A,B\nZ,B\nP,A,A\n", "t.csv:3:1"),
            (",N,P\nN,A,B\nZ,B,;\nP,A,A\n", "t.csv:3:5"),
            (",N,P\nN,A,B\nN,B,A\nP,A,A\n", "t.csv:3:1"),
        ],
    )
    def test_mistakes_are_shown_in_the_csv(self, tmp_path, csv, place):
        (tmp_path / "main.fz").write_text(self.MAIN)
        (tmp_path / "t.csv").write_text(csv)
        with pytest.raises(DiagnosticError) as error:
            load(tmp_path / "main.fz", block="two")
        assert place in [str(d.span).rsplit("/", 1)[1] for d in error.value.diagnostics]

    def test_rows_below_a_csv_table_are_refused(self, tmp_path):
        (tmp_path / "main.fz").write_text(TWO.replace("table v = e x d", 'table v = e x d from "t.csv"'))
        (tmp_path / "t.csv").write_text(",N,P\nN,A,B\n")
        with pytest.raises(DiagnosticError, match="rows here and in a file"):
            load(tmp_path / "main.fz", block="two")


class TestAllowAndDeny:
    def test_a_file_may_allow_a_warning_and_deny_another(self, changed):
        unused = ("\ninput x", "\nparam k = 1\ninput x")
        assert loads(changed(unused, after='allow FZ216 "kept for later"\n')) is not None
        with pytest.raises(DiagnosticError, match="FZ216"):
            loads(changed(unused, after="deny FZ216\n"))

    def test_errors_cannot_be_allowed_away(self, changed):
        with pytest.raises(DiagnosticError, match="FZ203"):
            loads(changed(("Z |  N  P", "Z |  N  Q"), after="allow FZ203\n"))

    def test_unknown_codes_are_diagnosed(self, changed):
        with pytest.raises(DiagnosticError, match="no diagnostic code 'FZ2166'"):
            loads(changed(after="allow FZ2166\n"))


class TestFilesRead:
    def test_are_those_used_through_others_and_the_tables(self, tmp_path):
        (tmp_path / "deep.fz").write_text("param k = 2\n")
        (tmp_path / "used.fz").write_text('use "deep.fz"\ninput e in [-1, 1]\n  terms N Z P\n')
        (tmp_path / "rows.csv").write_text("N,Z,P\n,N,Z,P\n")
        rules = (
            'use "used.fz"\nuse "gone.fz"\noutput u in [-2, 2]\n  terms N=-1 Z=0 P=(k)\ntable u = e from "rows.csv"\n'
        )
        (tmp_path / "main.fz").write_text(rules)
        found = [path.name for path in files_read(tmp_path / "main.fz")]
        assert sorted(found) == ["deep.fz", "rows.csv", "used.fz"]
