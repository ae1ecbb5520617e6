"""Lines of plants and loops: how they are laid out, read and repaired, and what systems keep of their words."""

import pytest
from pygments.token import Error

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang import highlight
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.lang.highlight import FuzzyLexer
from fuzzyctl.model.loop import MEASURES, SIGNALS
from fuzzyctl.model.plant import PLANTS
from tests.fuzzyctl.resolve.mistakes import errors_in, repairs_in, require_one

TYPED = """plant p "A plant"
input u
state long in [0,inf) = 0
state x=-1
der long=u-long
der x =delay( u,0.5 s )
output y=long+x
plant m=tf( num=[1,-2],den=[1 ,2, 3] )
plant s = ss(A=[[0,1],[ -2,-3 ]],B=[0,1],C=[1,0])
loop l
block  b = p( u=r-b.y )
let r=steps( 0:1.0,25 s : -0.5 )
measure overshoot "O" unit "%"=100*overshoot(b.y,r)
measure m = final( b.y )
run 5s step 10ms
require m<=2 %
"""

LAID = """plant p "A plant"
input u
state long in [0, inf) = 0
state x = -1
der long = u - long
der x    = delay(u, 0.5 s)
output y = long + x
plant m = tf(num=[1, -2], den=[1, 2, 3])
plant s = ss(A=[[0, 1], [-2, -3]], B=[0, 1], C=[1, 0])
loop l
block b = p(u=r - b.y)
let r = steps(0: 1.0, 25 s: -0.5)
measure overshoot "O" unit "%" = 100 * overshoot(b.y, r)
measure m                      = final(b.y)
run 5 s step 10 ms
require m <= 2 %
"""

SYSTEM = """system rule
input plant in [-1, 1]
  terms loop plant
input other in [-1, 1]
  terms A B
output u in [-1, 1]
  terms N P
table u = plant
  loop plant
| N P
if (other is A or
    plant is loop) then u is N
if other is B and (
  plant is not loop) then u is P
"""


def test_lines_are_laid_out_as_in_the_reference():
    assert format_source(SourceText("c.fz", TYPED)) == LAID


def test_the_layout_is_kept_and_read():
    assert format_source(SourceText("c.fz", LAID)) == LAID
    assert errors_in(LAID) == errors_in(TYPED) == []


def test_every_character_has_a_colour():
    assert [value for kind, value in FuzzyLexer().get_tokens(LAID) if kind is Error] == []


def test_functions_of_plants_and_loops_have_a_colour():
    assert set(highlight.LOOP_FUNCTIONS) == {*SIGNALS, *MEASURES, *PLANTS, "pair"} - {"integral"}


class TestSystems:
    def test_variables_and_terms_may_be_called_plant_and_loop(self):
        assert errors_in(SYSTEM) == []

    def test_a_loop_ends_a_parenthesis_that_is_not_closed(self):
        text = SYSTEM.replace("loop) then", "loop then") + 'loop l "A loop"\nrun 1 s\n'
        assert [code for code, _, _ in errors_in(text)] == ["FZ103", "FZ103", "FZ212"]

    @pytest.mark.parametrize(
        ("argument", "code", "found"), [("[1]", "FZ102", "["), ('"a"', "FZ102", '"a"'), ("1: 2", "FZ105", ":")]
    )
    @pytest.mark.parametrize("line", ["param k = max({})", "param k = max(2, {})", "require max({}) > 1"])
    def test_lists_texts_and_pairs_are_refused(self, line, argument, code, found):
        (own_code, message, place), *_ = errors_in(SYSTEM + line.format(argument) + "\n")
        assert (own_code, place) == (code, found)
        assert message.startswith(f"unexpected '{found}'")


@pytest.mark.parametrize("head", ["controller c 5", "plant p 5", "loop l 5"])
def test_the_lines_below_a_broken_head_belong_to_no_other_block(head):
    text = f"{head}\ninput x\nlet a = 1\noutput y = x\nplant q = tf(num=[1], den=[1, 1])\n"
    found = errors_in(text)
    assert found[0] == ("FZ102", "unexpected '5'", "5")
    assert {code for code, _, _ in found[1:]} <= {"FZ101"}  # lines that such a block does not have


#: Lines of a plant as other tools write them, and the repair.
NOTATIONS = {
    "dx/dt = u": "write: der x = u",
    "der(x) = u": "write: der x = u",
    "der x = u // inflow": "write: der x = u # inflow",
}


@pytest.mark.parametrize("line", NOTATIONS)
def test_derivatives_of_other_tools_are_repaired(line):
    text = f"plant p\ninput u\nstate x = 0\n{line}\noutput y = x\n"
    assert repairs_in(text) == [NOTATIONS[line]]


def test_a_plant_without_its_keyword_is_repaired():
    assert repairs_in("G = tf(num=[1], den=[1, 2])\n") == ["write: plant G = tf(num=[1], den=[1, 2])"]


def test_what_only_loops_may_hold_is_read_in_repairs():
    loop = "loop l\nblock c = c(target)\nlet target := steps(0: 0, 10 s: 1)  % why\nrun 20 s\n"
    assert repairs_in(f"controller c\ninput x\noutput y = x\nevery 1 s\n{loop}") == [
        "write: let target = steps(0: 0, 10 s: 1)  # why"
    ]


def test_a_letter_behind_an_input_is_no_range():
    """A keyword that is half typed is not taken for the end of a range, with the name cut in two."""
    require_one("controller c\ninput phi u\noutput y = phi\n", ("FZ102", "unexpected 'u'", "u"))
