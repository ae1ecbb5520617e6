"""Systems to claim something of, and the verdicts on claims about them."""

import re

from fuzzyctl import loads, prove

LINE = """
system line
and product
defuzzifier center_average
param c = 1
input e in [-1, 1]
  terms N Z P
input de in [-2, 2]
  terms N Z P
output u in [-1, 1]
  terms NB=-1 NS=-0.5 ZO=0 PS=0.5 PB=1
table u = e x de
     N  Z  P
 N | NB NS ZO
 Z | NS ZO PS
 P | ZO PS PB
"""
CURVED = (
    re.sub(
        r"(input \w+ in \[-(\d), \d\])\n  terms N Z P",
        r"\1\n  N = gaussian(-\2, 0.4 * \2)\n  Z = gaussian(0, 0.4 * \2)\n  P = gaussian(\2, 0.4 * \2)",
        LINE,
    )
    .replace("0.4 * 1", "0.4")
    .replace("0.4 * 2", "0.8")
)
MAMDANI = (
    LINE.replace("and product", "and min")
    .replace("center_average", "centroid")
    .replace("terms NB=-1 NS=-0.5 ZO=0 PS=0.5 PB=1", "terms NB NS ZO PS PB")
)
SAMPLED = MAMDANI.replace("centroid", "centroid(resolution=50)")
WEIGHTED = LINE + "if e is P then u is PB weight 0.5\n"


#: Seconds. What is decided here takes one at the most, on a machine that does nothing else.
AMPLE = 60.0


def verdicts(text, *claims, timeout=AMPLE):
    return prove(loads(text + "".join(f"require {c}\n" for c in claims)), timeout=timeout)


def words(text, *claims, timeout=AMPLE):
    return [type(v).__name__ for v in verdicts(text, *claims, timeout=timeout)]


CHAIN = """
system chain
defuzzifier weighted_average
input e in [-1, 1]
  terms N Z P
output m in [0, 1]
  lo = triangle(-inf, 0, 0.371)
  hi = triangle(0.3723, 1, inf)
output u in [-5, 5] else 0
  a = constant(1)
  b = constant(2)
table m = e
     N   Z   P
  |  lo  hi  hi
if m is lo then u is a
if m is hi then u is b
"""
