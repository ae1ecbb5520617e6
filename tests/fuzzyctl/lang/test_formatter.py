import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyctl.testing import check_text
from tests.golden.answers import formatted

#: Lines of blocks as they are typed, and as they are laid out.
PAIRS = [
    (
        """controller c
input x in [0,1]
param long_name in (0,10]=2   # a
param k=-3
let a=f(x,k =2)+5ms
let bcd   = -a*2%
output   y in [ 0, inf ) = where(a>2 , -1,2)
next s=1
""",
        """controller c
input x in [0, 1]
param long_name in (0, 10] = 2  # a
param k                    = -3
let a   = f(x, k=2) + 5 ms
let bcd = -a * 2 %
output y in [0, inf) = where(a > 2, -1, 2)
next s = 1
""",
    ),
    (
        """plant p "A plant"
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
""",
        """plant p "A plant"
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
""",
    ),
]


class TestFormat:
    def test_tables_are_aligned_by_column(self):
        text = "table f=x x y\nA B\nNB|LONG .\nZERO | P*0.5 A/B\n"
        assert formatted(text) == "table f = x x y\n          A      B\n  NB   |  LONG   .\n  ZERO |  P*0.5  A/B\n"

    def test_a_one_way_table_has_no_label_column(self):
        assert formatted("table f = x\nA BBB\n|C D\n") == "table f = x\n     A  BBB\n  |  C  D\n"

    def test_settings_params_and_terms_are_aligned(self):
        text = (
            "and min\nimplication product\n\nparam a=1\nparam long=2\n\n"
            "input x in[0,1]\nA=triangle(0,1,2)\nBC=gaussian( 0,1 )\n"
        )
        assert formatted(text) == (
            "and         min\nimplication product\n\nparam a    = 1\nparam long = 2\n\n"
            "input x in [0, 1]\n  A  = triangle(0, 1, 2)\n  BC = gaussian(0, 1)\n"
        )

    def test_an_equals_sign_in_a_label_is_left_alone(self):
        text = 'loop l\nmeasure long_name = 1\nmeasure m "at e = 0" = 2\n'
        assert formatted(text) == 'loop l\nmeasure long_name    = 1\nmeasure m "at e = 0" = 2\n'

    @pytest.mark.parametrize(
        ("typed", "laid"),
        [
            ("param k=-a*( 3+-2 )^-2", "param k = -a * (3 + -2)^-2"),
            ("param k = 1.50e+03", "param k = 1.50e+03"),
            (
                "require f( -x,-y )==f within 1e-12 when abs(x)>=.03",
                "require f(-x, -y) == f within 1e-12 when abs(x) >= .03",
            ),
            ("if a is b and not(c is d)then u is v weight .5", "if a is b and not (c is d) then u is v weight .5"),
            ("output u in [0,1] else-1", "output u in [0, 1] else -1"),
            ("output u in [0,1] else(k)", "output u in [0, 1] else (k)"),
            ("defuzzifier centroid( resolution = 100 )", "defuzzifier centroid(resolution=100)"),
            ("activation highest( count = 2 )", "activation highest(count=2)"),
            (
                "output u in [0,1] else 0 defuzzifier centroid( resolution = 9)",
                "output u in [0, 1] else 0 defuzzifier centroid(resolution=9)",
            ),
            ("terms A @ -1 B@( k+1 ) C=2", "  terms A@-1 B@(k + 1) C=2"),
        ],
    )
    def test_spacing(self, typed, laid):
        assert formatted(typed) == laid + "\n"

    def test_comments_stay_and_stand_in_one_column(self):
        text = "# head\nparam a = 1 # one\nparam bcd = 2     # two\n\n\n\n# own line\nsystem s\n"
        assert formatted(text) == ("# head\nparam a   = 1  # one\nparam bcd = 2  # two\n\n# own line\nsystem s\n")

    def test_a_line_broken_inside_parentheses_stays_as_typed(self):
        text = "input x in [0, 1]\n    A = triangle(0,   # foot\n                1, 2)\n"
        assert formatted(text) == text

    def test_the_comment_behind_a_broken_line_is_not_aligned_with_its_neighbours(self):
        broken = "if (a is N and\n    b is N) then c is N  # last\n"
        long = f"if {' and '.join(['a is N'] * 9)} then c is N  # first\n"
        assert formatted(long + broken) == long + broken

    def test_an_empty_file_stays_empty(self):
        assert formatted("\n\n") == ""

    @pytest.mark.parametrize(("typed", "laid"), PAIRS)
    def test_lines_of_blocks_are_laid_out_and_mean_the_same(self, typed, laid):
        assert formatted(typed) == formatted(laid) == laid
        assert [d.message for d in check_text(typed)[1]] == [d.message for d in check_text(laid)[1]]


LINES = st.sampled_from(
    [
        "system s 'x'",
        'system  s  "t"  # c',
        "param a=1+2*-k",
        "param longer   =   (1)# c",
        "and min",
        "implication product  #  c",
        "input x in[ 0,1 ]",
        " A=triangle( 0,1,2 )  #c",
        "terms A@0   B@1",
        "table f = x x y",
        "A   B",
        "N|P .",
        "  | P*0.5   Q/R",
        "# comment",
        "",
        "if x is A and(y is B)then f is C",
        "input x in [0,",
        "1]",
        "garbage !",
    ]
)


class TestLaws:
    @given(st.lists(LINES, max_size=25))
    def test_formatting_twice_is_formatting_once(self, lines):
        once = formatted("\n".join(lines))
        assert formatted(once) == once

    @given(st.lists(LINES, max_size=25))
    def test_formatting_changes_white_space_only(self, lines):
        text = "\n".join(lines)
        assert "".join(formatted(text).split()) == "".join(text.split())

    @settings(deadline=None)  # the first example builds the parser
    @given(st.lists(LINES, max_size=25))
    def test_a_formatted_file_means_the_same(self, lines):
        text = "\n".join(lines)
        (before, mistakes), (after, more) = check_text(text), check_text(formatted(text))
        assert [d.code for d in mistakes] == [d.code for d in more]
        assert before == after


def test_claims_about_every_instant_keep_their_parentheses():
    head = "loop l\nblock p = p(1)\nrun 1 s\n"
    text = (
        f"{head}require   always (p.y<=1) and -1<=p.y   from (2 s) until 5 s\n"
        'disturbance  w in (-1,1]  unit "m" =0\nfor p.x in [ 0,1 ]\n'
    )
    laid = (
        f"{head}require always (p.y <= 1) and -1 <= p.y from (2 s) until 5 s\n"
        'disturbance w in (-1, 1] unit "m" = 0\nfor p.x in [0, 1]\n'
    )
    assert formatted(text) == laid
    assert formatted(laid) == laid


def test_names_like_words_keep_their_meaning():
    text = (
        "loop l\nblock p = p(1)\nlet until = p.until+1\nmeasure always = maximum(rate -1)\nrun 1 s\n"
        "require always - 1 <= 3\nrequire always -until <= 3 until -until\n"
    )
    laid = (
        "loop l\nblock p = p(1)\nlet until = p.until + 1\nmeasure always = maximum(rate - 1)\nrun 1 s\n"
        "require always - 1 <= 3\nrequire always -until <= 3 until -until\n"
    )
    assert formatted(text) == laid
    assert formatted(laid) == laid
