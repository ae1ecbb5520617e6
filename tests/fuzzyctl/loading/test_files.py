"""Files: what is read from them, which others they use, and bytes that are no rule file."""

import contextlib

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import fuzzyctl
from fuzzyctl import DiagnosticError, load, load_all, loads
from fuzzyctl.testing import check_text
from tests.shipped import SYSTEMS

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


def write(folder, **files):
    for name, text in files.items():
        (folder / f"{name}.fz").write_text(text)
    return folder / "main.fz"


def errors(path):
    return [d.code for d in fuzzyctl.check(path)[1] if d.severity == "error"]


class TestRead:
    def test_a_file_becomes_a_system_that_knows_its_path(self):
        system = load(SYSTEMS[0])
        assert system.path == str(SYSTEMS[0])

    @pytest.mark.parametrize(
        ("content", "code"),
        [
            (b"\x00\x01\x02", "FZ002"),
            (b"system s \xff\xfe", "FZ002"),
            (b"", "FZ004"),
            (b"\n\n# a comment\n", "FZ004"),
            (b"x" * (1 << 20) + b"y", "FZ003"),
        ],
    )
    def test_bytes_that_are_no_rule_file_are_diagnosed(self, tmp_path, content, code):
        path = tmp_path / "bad.fz"
        path.write_bytes(content)
        with pytest.raises(DiagnosticError) as error:
            load(path)
        assert [d.code for d in error.value.diagnostics] == [code]

    def test_a_missing_file_and_a_directory_are_diagnosed(self, tmp_path):
        (tmp_path / "tipper.fz").write_text("")
        for path, part in ((tmp_path / "tiper.fz", "tipper.fz"), (tmp_path, "directory")):
            with pytest.raises(DiagnosticError, match=rf"FZ001(.|\n)*{part}"):
                load(path)

    def test_a_byte_order_mark_and_crlf_are_accepted_up_to_a_size_that_can_be_set(self, tmp_path, base):
        path = tmp_path / "a.fz"
        path.write_bytes(b"\xef\xbb\xbf" + base.replace("\n", "\r\n").encode())
        assert load(path) == loads(base)
        with pytest.raises(DiagnosticError):
            load(path, max_bytes=10)

    @settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
    @given(st.binary(max_size=200))
    def test_any_bytes_give_a_system_or_diagnostics(self, tmp_path, data):
        (tmp_path / "a.fz").write_bytes(data)
        with contextlib.suppress(DiagnosticError):
            load(tmp_path / "a.fz")

    @given(st.data())
    def test_a_mutated_file_gives_blocks_or_diagnostics_with_locations(self, data):
        lines = data.draw(st.sampled_from(SYSTEMS)).read_text(encoding="utf-8").split("\n")
        for _ in range(data.draw(st.integers(1, 3))):
            i = data.draw(st.integers(0, len(lines) - 1))
            words = lines[i].split()
            count = data.draw(st.integers(0, len(words)))
            change = data.draw(
                st.sampled_from([[], [lines[i]] * 2, [" ".join(words[:count])], [" ".join(words[::-1])]])
            )
            lines[i : i + 1] = change or ([] if len(lines) > 1 else [""])
        blocks, diagnostics = check_text("\n".join(lines))
        assert blocks or diagnostics
        assert all(d.span is not None for d in diagnostics)


class TestSeveralSystems:
    def test_lines_before_the_first_belong_to_all_that_name_them(self, tmp_path):
        one, two = loads(TWO, block="one"), loads(TWO, block="two")
        assert [[v.name for v in s.inputs] for s in (one, two)] == [["e"], ["e", "d"]]
        assert (one(e=1.0), two(e=-1.0, d=5.0)) == (2.0, 1.0)
        assert load_all(write(tmp_path, main=TWO)) == (one, two)

    def test_linear_consequents_count_all_shared_inputs(self):
        rule = "if e is N or not e is N then u is linear(1, 2, 0.5)\n"
        one = loads(TWO.replace("table u = e\n     N  Z  P\n  |  N  Z  P\n", rule), block="one")
        assert [v.name for v in one.inputs] == ["e", "d"]
        assert one(e=0.0, d=0.25) == 1.0

    def test_a_setting_of_a_system_replaces_the_shared_one(self):
        terms = "output u in [0, 1]\n  a = triangle(-inf, 0, 1)\n  b = triangle(0, 1, inf)\n"
        rules = "if e is N then u is a\nif e is P then u is b\n"
        shared = "and product\nimplication product\ndefuzzifier centroid\ninput e in [-1, 1]\n  terms N P\n"
        text = f"{shared}system one\n{terms}{rules}system two\ndefuzzifier center_average\nand min\n{terms}{rules}"
        methods = [loads(text, block=name).method for name in ("one", "two")]
        assert [(m.defuzzifier.kind, m.conjunction, m.implication) for m in methods] == [
            ("centroid", "product", "product"),
            ("center_average", "min", "product"),
        ]


class TestUse:
    def test_used_files_may_use_files(self, tmp_path):
        path = write(
            tmp_path,
            main=TWO.replace(SHARED, 'use "a.fz"\n'),
            a='use "b.fz"\nparam k = 2\n',
            b=SHARED.replace("param k = 2\n", ""),
        )
        assert load(path, block="one") == loads(TWO, block="one")
        assert load(path, block="two")(e=-1.0, d=5.0) == 1.0

    def test_systems_and_settings_of_a_used_file_stay_there(self, tmp_path):
        path = write(tmp_path, main='use "two.fz"\n' + TWO.replace(SHARED, ""), two="and product\n" + TWO)
        assert load(path, block="one").method.conjunction == "min"

    @pytest.mark.parametrize("name", ["/etc/hostname", "../outside.fz", "sub/../../outside.fz", "link.fz"])
    def test_files_elsewhere_cannot_be_read(self, tmp_path, name):
        folder = tmp_path / "inner"
        folder.mkdir()
        (tmp_path / "outside.fz").write_text(SHARED)
        (folder / "link.fz").symlink_to(tmp_path / "outside.fz")
        with pytest.raises(DiagnosticError, match="lies outside the folder"):
            load_all(write(folder, main=f'use "{name}"\n{TWO}'))

    @pytest.mark.parametrize("name", ["folder.fz", "binary.fz", "main.fz", "no.fz"])
    def test_blocks_whose_file_cannot_be_used_have_one_mistake(self, tmp_path, name):
        (tmp_path / "folder.fz").mkdir()
        (tmp_path / "binary.fz").write_bytes(b"\xff\0")
        text = "controller c\ninput e\noutput u = e\n"
        assert errors(write(tmp_path, main=f'use "{name}"\n{text}')) == ["FZ218"]

    def test_each_is_read_once_however_many_ways_lead_to_it(self, tmp_path):
        """Layers of two files that use both files of the next layer: 2^12 ways from the first to the last."""
        body = "input x in [0, 1]\n  terms a b\noutput y in [0, 1] else 0\n  terms c d\nif x is a then y is c\n"
        for layer in range(12):
            for side in "lr":
                uses = "".join(f'use "{layer + 1}{other}.fz"\n' for other in "lr") if layer < 11 else ""
                claim = f"require y == s{layer + 1}{side}.y\n" if layer < 11 else ""
                (tmp_path / f"{layer}{side}.fz").write_text(f"{uses}system s{layer}{side}\n{body}{claim}")
        assert load(tmp_path / "0l.fz").compared[0].name == "s1l"

    def test_more_than_64_are_refused(self, tmp_path):
        text = "system s\n" + "".join(f'use "gone{k}.fz"\n' for k in range(200))
        messages = [d.message for d in check_text(text, folder=tmp_path)[1] if d.code == "FZ218"]
        assert (len(messages), messages[-1]) == (65, "more than 64 files are used")


def test_a_table_is_read_from_a_csv_file(tmp_path):
    table = "table v = e x d\n       N  P\n  N |  A  B\n  Z |  B  A\n  P |  A  A\n"
    path = write(tmp_path, main=TWO.replace(table, 'table v = e x d from "t.csv"\n'))
    (tmp_path / "t.csv").write_bytes(b"\xef\xbb\xbf,N,P\r\nN, A,B\r\n\r\nZ,B ,0.25\r\nP,A*0.5,.\r\n")
    system = load(path, block="two")
    assert (system(e=-1.0, d=5.0), system(e=0.0, d=5.0), len(system.rules)) == (1.0, 0.25, 5)


def test_the_interface_of_a_plant_in_python_is_read_without_running_the_file(tmp_path):
    text = 'inputs = ("force",)\nstates = {"x": 0.5, "v": 0}\noutputs: tuple = ["place"]\nraise SystemExit("run")\n'
    (tmp_path / "cart.py").write_text(text, encoding="utf-8")
    plant = load(write(tmp_path, main='plant cart = python("cart.py")\n'), block=fuzzyctl.Plant)
    assert plant.python == str(tmp_path / "cart.py")
    assert [s.name for s in plant.inputs] == ["force"]
    assert [(s.name, plant.number(s.start)) for s in plant.states] == [("x", 0.5), ("v", 0.0)]
    assert [r.name for r in plant.results] == ["place"]


def test_columns_of_csv_files_are_found_by_name_in_folders_below(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "data.csv").write_text('t, y ,"b c"\n0,1,2\n1,2,3\n', encoding="utf-8")
    loop = "plant lag = tf(num=[1], den=[1, 1])\nloop l\n"
    loop += 'let r = csv(file="sub/data.csv", column="b c", time="y")\nblock a = lag(r)\nrun 1 s step 10 ms\n'
    assert check_text(loop, folder=tmp_path)[1] == []
