"""A controller as papers print it is short."""

import fuzzyctl

PAPER = """\
system pd "Fuzzy PD"
defuzzifier center_average
input e in [-1, 1]
  terms NB NM NS ZO PS PM PB
input de in [-1, 1]
  terms NB NM NS ZO PS PM PB
output u in [-1, 1]
  terms NB NM NS ZO PS PM PB
table u = e x de
     NB NM NS ZO PS PM PB
NB | NB NB NB NB NM NS ZO
NM | NB NB NB NM NS ZO PS
NS | NB NB NM NS ZO PS PM
ZO | NB NM NS ZO PS PM PB
PS | NM NS ZO PS PM PB PB
PM | NS ZO PS PM PB PB PB
PB | ZO PS PM PB PB PB PB
"""


def test_a_controller_of_seven_by_seven_takes_at_most_600_bytes():
    assert len(PAPER.encode()) <= 600
    system = fuzzyctl.loads(PAPER)
    assert len(system.rules) == 49
    assert system(e=1.0, de=1.0) == 1.0
