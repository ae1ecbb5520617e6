"""Where obstacles are over time."""

import numpy as np
import pytest

from dwmr.scenario.file import find, read
from dwmr.scenario.outlines import centres, is_moving, largest_speed
from fuzzyctl.diagnostics.diagnostic import DiagnosticError

STILL = "{x=1,y=2,radius=0.5}"
STRAIGHT = "{x=-9,y=2,radius=0.5,velocity=[0.5,-1.0]}"
BENT = "{x=0,y=9,radius=0.5,path=[[2,4,9],[4,4,5]]}"


def scenario(*obstacles):
    return read(find("paper"), [f"obstacles=[{','.join(obstacles)}]"]).scenario


def test_they_rest_go_straight_on_or_along_a_path():
    given = scenario(STILL, STRAIGHT, BENT)
    found = centres(given, np.array([0.0, 1.0, 3.0, 9.0]))
    assert found[:, 0].tolist() == [[1.0, 2.0]] * 4
    assert found[:, 1].tolist() == [[-9.0, 2.0], [-8.5, 1.0], [-7.5, -1.0], [-4.5, -7.0]]
    assert found[:, 2].tolist() == [[0.0, 9.0], [2.0, 9.0], [4.0, 7.0], [4.0, 5.0]]
    assert [largest_speed(one) for one in given.obstacles] == pytest.approx([0.0, np.hypot(0.5, 1.0), 2.0])
    assert is_moving(given)
    assert not is_moving(scenario(STILL))


@pytest.mark.parametrize(
    ("obstacle", "message"),
    [
        ("{x=0,y=0,radius=1,velocity=[1,1],path=[[1,1,1]]}", "obstacles.0: give velocity or path, not both"),
        ("{x=0,y=9,radius=1,path=[[1,1,1],[1,2,2]]}", "obstacles.0: path.1 is at 1 s, not after 1 s"),
        ("{x=0,y=9,radius=1,path=[[1e-6,9,9]]}", "obstacles.0: path.0 is reached at 9e+06 m/s"),
        ("{x=0,y=9,radius=1,path=[[0,9,9]]}", "obstacles.0.path.0.0 must be > 0"),
        ("{x=0,y=9,radius=1,path=[]}", "obstacles.0.path"),
        ("{x=0,y=9,radius=1,velocity=[1]}", "obstacles.0.velocity"),
        ("{x=0,y=9,radius=1,velocity=[inf,0]}", "obstacles.0.velocity.0"),
    ],
)
def test_ways_that_make_no_sense_are_refused(obstacle, message):
    with pytest.raises(DiagnosticError) as caught:
        scenario(obstacle)
    assert caught.value.diagnostics[0].message.startswith(message)
