"""What can be seen of a scenario's rigid bodies: the MuJoCo model with colours, lights, wheels and obstacles."""

from __future__ import annotations

from xml.etree import ElementTree as Xml

from matplotlib.colors import to_rgb

from dwmr.figures.style import COLOURS
from dwmr.scenario.model import RigidBody, Robot, Scenario
from dwmr.simulation.mujoco_model import mjcf

#: Width and height of a picture [pixels].
SIZE = (720, 480)
#: Height of obstacles, which the scenario does not have [m].
OBSTACLE_HEIGHT = 0.6
#: MuJoCo's groups from 3 on are not drawn.
_HIDDEN = "3"
_DARK = "0.15 0.15 0.15 1"


def scene(scenario: Scenario) -> str:
    """Return the MuJoCo model of a scenario with what makes it look like something.

    Its joints are those of `mujoco_model.mjcf`, so it takes the same `qpos`. Obstacles are the mocap bodies
    `obstacle0`, `obstacle1` and so on, which touch nothing.

    Args:
        scenario: All of its robots have a `rigid_body`.
    """
    root = Xml.fromstring(mjcf(scenario))
    visual, asset = Xml.SubElement(root, "visual"), Xml.SubElement(root, "asset")
    Xml.SubElement(visual, "global", offwidth=str(SIZE[0]), offheight=str(SIZE[1]), fovy="40")
    Xml.SubElement(visual, "headlight", ambient="0.5 0.5 0.5", diffuse="0.15 0.15 0.15", specular="0 0 0")
    Xml.SubElement(visual, "quality", offsamples="4")
    Xml.SubElement(visual, "map", znear="0.02", zfar="30")
    Xml.SubElement(root, "statistic", extent="10", center="0 0 0")
    Xml.SubElement(
        asset, "texture", type="skybox", builtin="gradient", rgb1="0.93 0.95 0.98", rgb2="0.93 0.95 0.98",
        width="8", height="48",
    )  # fmt: skip
    Xml.SubElement(
        asset, "texture", name="squares", type="2d", builtin="checker", rgb1="0.93 0.93 0.93", rgb2="0.88 0.88 0.88",
        width="64", height="64",
    )  # fmt: skip
    Xml.SubElement(asset, "material", name="floor", texture="squares", texuniform="true", texrepeat="0.5 0.5")
    world = root.find("worldbody")
    assert world is not None
    Xml.SubElement(world, "light", directional="true", dir="0.3 0.4 -1", diffuse="0.45 0.45 0.45", castshadow="false")
    ground = world.find("geom[@name='ground']")
    assert ground is not None
    ground.set("material", "floor")
    for i, robot in enumerate(scenario.robots.values()):
        body = world.find(f"body[@name='robot{i}']")
        assert body is not None
        assert robot.rigid_body is not None
        _dress(body, robot, robot.rigid_body, COLOURS[i % len(COLOURS)])
    for a, obstacle in enumerate(scenario.obstacles):
        body = Xml.SubElement(world, "body", name=f"obstacle{a}", mocap="true", pos=f"{obstacle.x} {obstacle.y} 0")
        _shape(
            body, "cylinder", f"{obstacle.radius} {0.5 * OBSTACLE_HEIGHT}", f"0 0 {0.5 * OBSTACLE_HEIGHT}",
            "0.27 0.27 0.27 1",
        )  # fmt: skip
    return Xml.tostring(root, encoding="unicode")


def _dress(body: Xml.Element, robot: Robot, own: RigidBody, colour: str) -> None:
    """Give a robot its colour, a nose, and wheels that look like such: those that touch the ground are spheres."""
    red, green, blue = to_rgb(colour)
    for geom in body.findall("geom"):
        geom.set("rgba", _DARK if geom.get("type") == "sphere" else f"{red} {green} {blue} 1")
    front = robot.body.front if robot.body else robot.radius
    width = robot.body.width if robot.body else robot.radius
    top = own.height - robot.wheel_radius
    _shape(body, "box", f"0.06 {0.3 * width} 0.01", f"{front - 0.1} 0 {top}", "1 1 1 1")
    r, half = robot.wheel_radius, 0.5 * own.wheel_width
    for wheel in body.findall("body"):
        sphere = wheel.find("geom")
        assert sphere is not None
        sphere.set("group", _HIDDEN)
        _shape(wheel, "cylinder", f"{r} {half}", "0 0 0", _DARK, turned="1.5707963 0 0")
        _shape(wheel, "box", f"{0.8 * r} {half + 0.004} {0.15 * r}", "0 0 0", "0.8 0.8 0.8 1")


def _shape(body: Xml.Element, kind: str, size: str, place: str, colour: str, turned: str = "0 0 0") -> None:
    """Add a shape that is only seen, with Euler angles in radian."""
    Xml.SubElement(
        body, "geom", type=kind, size=size, pos=place, rgba=colour, euler=turned, contype="0", conaffinity="0", mass="0"
    )
