"""Lines of controllers: how they are laid out."""

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang.formatter import format_source

TYPED = """controller c
input x in [0,1]
param long_name in (0,10]=2   # a
param k=-3
let a=f(x,k =2)+5ms
let bcd   = -a*2%
output   y in [ 0, inf ) = where(a>2 , -1,2)
next s=1
"""

LAID = """controller c
input x in [0, 1]
param long_name in (0, 10] = 2  # a
param k                    = -3
let a   = f(x, k=2) + 5 ms
let bcd = -a * 2 %
output y in [0, inf) = where(a > 2, -1, 2)
next s = 1
"""


def test_lines_are_laid_out_as_in_the_reference():
    assert format_source(SourceText("c.fz", TYPED)) == LAID


def test_the_layout_is_kept():
    assert format_source(SourceText("c.fz", LAID)) == LAID
