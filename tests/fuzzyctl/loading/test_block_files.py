"""Files that plants and loops name: plants in Python, whose code is not run, and CSV files."""

import pytest

import fuzzyctl
from fuzzyctl.expr import Name, Number
from tests.fuzzyctl.resolve.mistakes import errors_in

PYTHON = 'inputs = ("force",)\nstates = {"x": 0.5, "v": 0}\noutputs: tuple = ["place"]\nraise SystemExit("run")\n'

#: Texts of cart.py, and what is reported of each.
WRONG = {
    "inputs = (": "the file is not Python",
    "x = 1\0": '"cart.py" cannot be used: the file is no text: byte 5 is NUL',
    PYTHON.replace("inputs = ", "def inputs(): return "): "the file assigns no 'inputs'",
    PYTHON.replace('("force",)', "tuple('f')"): "'inputs' is not written out as a tuple of names",
    PYTHON.replace('("force",)', "(1,)"): "'inputs' is not written out as a tuple of names",
    PYTHON.replace("0.5", "None"): "'states' is not written out as a dictionary from names to numbers",
    PYTHON.replace("0.5", "1e999"): "'states' is not written out as a dictionary from names to numbers",
    PYTHON.replace('"force"', '"a b"'): "'a b' of 'inputs' is no name",
    PYTHON.replace('"force"', '"not"'): "'not' of 'inputs' is no name",
    PYTHON.replace('"force",', '"force", "force"'): "'force' of 'inputs' is declared twice",
    PYTHON.replace('"force"', '"v"'): "'v' of 'states' is declared twice",
    PYTHON.replace('"place"', '"x"'): "'x' of 'outputs' is declared twice",
}

LOOP = """plant lag = tf(num=[1], den=[1, 1])
loop l
let r = csv({})
block a = lag(r)
run 1 s step 10 ms
"""

#: Arguments of `csv`, and what is reported of each.
COLUMNS = {
    '"data.csv", column="y"': (),
    'file="sub/data.csv", column="b c", time="y"': (),
    '"data.csv", "y", "t"': (),
    '"data.csv", column="z"': ("FZ202", "'data.csv' has no column 'z'", '"z"'),
    '"data.csv", column="y", time="T"': ("FZ202", "'data.csv' has no column 'T'", '"T"'),
    '"dta.csv", column="y"': ("FZ218", '"dta.csv" cannot be used: there is no such file', '"dta.csv"'),
    '"../data.csv", column="y"': ("FZ218", "'../data.csv' lies outside the folder of this file", '"../data.csv"'),
    '"empty.csv", column="y"': ("FZ202", "'empty.csv' has no column 'y'", '"y"'),
    '"data.csv"': ("FZ303", "wrong arguments of 'csv'", 'csv("data.csv"'),
}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "data.csv").write_text("t,y\n0,1\n", encoding="utf-8")
    (tmp_path / "sub" / "data.csv").write_text('t, y ,"b c"\n0,1,2\n', encoding="utf-8")
    (tmp_path / "empty.csv").write_text("", encoding="utf-8")
    return tmp_path


class TestPython:
    def test_the_interface_is_read_without_running_the_file(self, tmp_path):
        (tmp_path / "cart.py").write_text(PYTHON, encoding="utf-8")
        (tmp_path / "cart.fz").write_text('plant cart = python("cart.py")\n', encoding="utf-8")
        plant = fuzzyctl.load(tmp_path / "cart.fz", block=fuzzyctl.Plant)
        assert plant.python == str(tmp_path / "cart.py")
        assert [s.name for s in plant.inputs] == ["force"]
        assert [(s.name, s.start) for s in plant.states] == [("x", Number(0.5)), ("v", Number(0.0))]
        assert [(r.name, r.value) for r in plant.results] == [("place", Name("place"))]

    @pytest.mark.parametrize("text", WRONG)
    def test_what_cannot_be_read_is_reported(self, text, tmp_path):
        (tmp_path / "cart.py").write_text(text, encoding="utf-8")
        ((code, message, place),) = errors_in('plant cart = python("cart.py")\n', tmp_path)
        assert (code, message, place) == ("FZ218", WRONG[text], '"cart.py"')

    def test_all_mistakes_are_reported_at_once(self, tmp_path):
        text = PYTHON.replace('"force"', '"u", "u"').replace("0.5", "'a'").replace('["place"]', '["y", "a b", "u"]')
        (tmp_path / "cart.py").write_text(text, encoding="utf-8")
        assert [message for _, message, _ in errors_in('plant cart = python("cart.py")\n', tmp_path)] == [
            "'u' of 'inputs' is declared twice",
            "'states' is not written out as a dictionary from names to numbers",
            "'a b' of 'outputs' is no name",
            "'u' of 'outputs' is declared twice",
        ]

    def test_a_missing_file_is_reported_with_a_near_one(self, tmp_path):
        (tmp_path / "cart.py").write_text(PYTHON, encoding="utf-8")
        (tmp_path / "cart.fz").write_text('plant cart = python("crat.py")\n', encoding="utf-8")
        with pytest.raises(fuzzyctl.DiagnosticError, match=r"did you mean 'cart\.py'"):
            fuzzyctl.load(tmp_path / "cart.fz", block=fuzzyctl.Plant)

    def test_a_loop_connects_it_by_its_names(self, tmp_path):
        (tmp_path / "cart.py").write_text(PYTHON, encoding="utf-8")
        text = 'plant cart = python("cart.py")\nloop l\nblock c = cart(force={})\nrun 1 s step 10 ms\n'
        assert errors_in(text.format("-c.place"), tmp_path) == []
        assert [m for _, m, _ in errors_in(text.format("-c.x"), tmp_path)] == ["no name 'c.x'"]


@pytest.mark.parametrize("arguments", COLUMNS)
def test_columns_are_looked_up(arguments, folder):
    expected = COLUMNS[arguments]
    found = errors_in(LOOP.format(arguments), folder)
    assert [(code, message) for code, message, _ in found] == ([expected[:2]] if expected else [])
    assert all(place.startswith(expected[2]) for _, _, place in found)
