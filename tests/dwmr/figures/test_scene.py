"""What is seen of rigid bodies is added to the model that runs, and changes nothing of its joints and contacts."""

from xml.etree import ElementTree as Xml

import pytest

from dwmr import find, read
from dwmr.figures.scene import scene
from dwmr.simulation.mujoco_plant import mjcf
from tests.physics import needs_mujoco


@pytest.fixture(scope="module")
def scenario():
    return read(find("experiment")).scenario


def test_only_what_runs_can_touch(scenario):
    run, seen = (Xml.fromstring(write(scenario)) for write in (mjcf, scene))
    touching = [one for one in seen.iter("geom") if one.get("contype") != "0"]
    assert len(touching) == len(list(run.iter("geom")))
    added = [one for one in seen.iter("geom") if one.get("contype") == "0"]
    assert all(one.get("conaffinity") == one.get("mass") == "0" for one in added)
    assert len(added) == 3 * 5 + 3  # nose, two wheels with a spoke; obstacles


@needs_mujoco
def test_joints_are_where_they_are_in_the_model_that_runs(scenario):
    import mujoco

    run, seen = (mujoco.MjModel.from_xml_string(write(scenario)) for write in (mjcf, scene))
    for i in range(3):
        for name in ("free", "right", "left"):
            assert seen.joint(f"{name}{i}").qposadr == run.joint(f"{name}{i}").qposadr
    assert seen.nq == run.nq == 27
    assert seen.nmocap == 3
