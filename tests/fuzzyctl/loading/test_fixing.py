import pytest

from fuzzyctl.testing import check_text, run_command

FOREIGN = """system t;
and product
defuzzifer center_average
input x in [0, 1]
  a = trimf [0 0 1]
  b = gaussmf(0.1, 1)  % other
output y in [0, 1] else 0
  terms lo=0 hi=1
IF x is a THEN y is lo;
if x is b && x is not a then y is hii
"""
RIGHT = """system t
and product
defuzzifier center_average
input x in [0, 1]
  a = triangle(0, 0, 1)
  b = gaussian(1, 0.1)  # other
output y in [0, 1] else 0
  terms lo=0 hi=1
if x is a then y is lo
if x is b and x is not a then y is hi
"""


@pytest.fixture
def text_of(tmp_path):
    """The text of a file after its repairs."""
    path = tmp_path / "t.fz"

    def fixed(text, *, likely=False):
        path.write_text(text, encoding="utf-8", newline="")
        run_command("check", path, "--fix", *(["likely"] if likely else []))
        return path.read_bytes().decode()

    return fixed


def test_all_repairs_of_all_lines_are_made_at_once(text_of):
    assert text_of(FOREIGN) == RIGHT.replace("is hi\n", "is hii\n")
    assert text_of(FOREIGN, likely=True) == RIGHT


def test_a_mistake_that_another_one_hid_is_fixed_too(text_of):
    # The misspelt setting is reported once its line is read.
    text = RIGHT.replace("and product", "adn produkt")
    assert text_of(text) == RIGHT


@pytest.mark.parametrize("text", [RIGHT, "", "system t\n", "{}[]\n", "input " * 1000])
def test_a_text_without_a_repair_stays(text, text_of):
    assert text_of(text, likely=True) == text


def test_line_ends_stay(text_of):
    text = FOREIGN.replace("\n", "\r\n")
    assert text_of(text, likely=True) == RIGHT.replace("\n", "\r\n")


def test_fixes_that_leave_as_many_errors_are_not_made(text_of):
    # With its name the output has a rule, whose term it lacks: no fewer errors.
    text = "system t\ninput x in [0, 1]\n  terms a b\noutput speed in [0, 1] else 0\n  terms lo hi\n"
    text += "if x is a then speeed is fast\nif x is a then speed is lo\n"
    assert text_of(text) == text


@pytest.mark.parametrize(
    ("line", "right"),
    [
        # As many numbers as the function takes say whether commas are decimal ones.
        ("b = trimf [0,0 0,5 1]", "b = triangle(0.0, 0.5, 1)"),
        ("b = trimf [0,1 2]", "b = triangle(0, 1, 2)"),
        ("b = gaussmf [0,1 1,5]", "b = gaussian(1.5, 0.1)"),
        ("b = trapmf(0, 1, 2, Inf)", "b = trapezoid(0, 1, 2, inf)"),
        # The names of constants have small letters, also where those of the wrong spelling are more.
        ("b = trapezoid(-Inf, -Inf, 0, inf)", "b = trapezoid(-inf, -inf, 0, inf)"),
        ("b = triangle(0, 1, PI)", "b = triangle(0, 1, pi)"),
    ],
)
def test_numbers_of_other_tools(line, right, text_of):
    text = RIGHT.replace("b = gaussian(1, 0.1)  # other", line)
    assert text_of(text) == RIGHT.replace("b = gaussian(1, 0.1)  # other", right)


@pytest.mark.parametrize(
    ("line", "right"),
    [
        ("require bounded(y, 0,0, 1,0)", "require bounded(y, 0.0, 1.0)"),
        ("require bounded(y,0,0,1,0);", "require bounded(y,0.0,1.0)"),
        ("param k = atan2(1,5, 2)", "param k = atan2(1.5, 2)"),
        ("if x is a then y is linear(1,5, 2)", "if x is a then y is linear(1.5, 2)"),
        ("if x is a then y is lo end", "if x is a then y is lo"),
        ("IF x IS a THEN y IS lo END_IF;", "if x is a then y is lo"),
        # What the repaired line says is repaired next.
        ("if x iz a then y is loo;", "if x is a then y is lo"),
    ],
)
def test_lines_of_other_tools(line, right, text_of):
    assert text_of(f"{RIGHT}{line}\n", likely=True) == f"{RIGHT}{right}\n"


@pytest.mark.parametrize(
    "line", ["require bounded(y, 0, 1, 2)", "require bounded(y, 0.5,0, 1)", "param k = atan2(1, 5, 2)"]
)
def test_commas_that_separate_numbers_stay(line, text_of):
    assert text_of(f"{RIGHT}{line}\n", likely=True) == f"{RIGHT}{line}\n"


@pytest.mark.parametrize(
    ("line", "right"),
    [
        ("terms b = gaussmf(0.1, 1)", "b = gaussian(1, 0.1)"),
        ("b = triangle(0,0,0,5,1,0)", "b = triangle(0.0, 0.5, 1.0)"),
    ],
)
def test_terms_of_other_tools(line, right, text_of):
    text = RIGHT.replace("b = gaussian(1, 0.1)  # other", line)
    assert text_of(text) == RIGHT.replace("b = gaussian(1, 0.1)  # other", right)


def test_a_value_is_no_param_under_the_name_of_a_variable(text_of):
    assert text_of(f"{RIGHT}k = 5\n", likely=True) == f"{RIGHT}param k = 5\n"
    assert text_of(f"{RIGHT}y = 5\n", likely=True) == f"{RIGHT}y = 5\n"


BLOCKS = """controller law
input e
every 10 ms
state s = 0
next s = s + e
let bend = 2 * e
let more = bend + 1
output u = s + more
require u <= 1e9

plant tank
input u
state h = 0
der h = u - h
output y = h

loop l
block c = law(1 - p.y)
block p = tank(c.u)
run 1 s
measure f0 = final(p.y)
"""


@pytest.mark.parametrize(
    ("line", "guess"),
    [
        ("next s = s + e", "next s = s + sin(t)"),
        ("measure f0 = final(p.y)", "measure f0 = f_at_0"),
        ("let bend = 2 * e", "let bend = bent"),
        ("let bend = 2 * e", "let bend = mora"),
        ("require u <= 1e9", "require u2 <= 1e9"),
        ("require u <= 1e9", "require u => 1e9 )"),
    ],
)
def test_a_guess_that_changes_the_meaning_is_not_made(line, guess, text_of):
    text = BLOCKS.replace(line, guess)
    fixed = text_of(text, likely=True)
    assert fixed.replace("require u >= 1e9 )", "require u => 1e9 )") == text


def test_the_time_of_a_controller_is_no_slip_of_its_sample_time():
    _, (mistake,) = check_text(BLOCKS.replace("next s = s + e", "next s = s + sin(t)"))
    assert mistake.help == "count the time in a state, such as: next time = time + dt"
