"""Runs of rigid bodies as films of MuJoCo's renderer: robots with their paths, references, obstacles and radii."""

from __future__ import annotations

import math
import os
import sys
import warnings
from collections.abc import Iterator
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_rgb
from PIL import Image, ImageDraw, ImageFont

from dwmr.core.arrays import FloatArray
from dwmr.figures.animation import NOTE, PALETTE, acting, extent
from dwmr.figures.style import COLOURS, TITLES
from dwmr.results import derived
from dwmr.scenario.model import RigidBody, Robot, Scenario
from dwmr.scenario.outlines import centres
from dwmr.simulation.mujoco_plant import mjcf
from dwmr.simulation.simulate import Trajectory

#: Makers of a context of OpenGL: modules of MuJoCo, by the values of MUJOCO_GL.
CONTEXTS = ("egl", "osmesa", "glfw", "cgl")
#: The one of each system where MUJOCO_GL is not set.
_USUAL = {"linux": "egl", "darwin": "cgl"}


class NoRendererError(Exception):
    """Raised where no picture can be rendered, with the reason."""


class Renderer:
    """Renders a model; a context manager, as objects of OpenGL must go while their context is the present one.

    Args:
        model: A MuJoCo model whose offscreen buffer has the size of the pictures.
        most_added: Objects that a picture may hold besides those of the model.

    Raises:
        NoRendererError: Where there is no OpenGL without a window.
    """

    def __init__(self, model: Any, most_added: int) -> None:
        self.mujoco: Any = import_module("mujoco")
        size = model.vis.global_
        self.size = (int(size.offwidth), int(size.offheight))
        self._model = model
        self._context = _context(*self.size)
        try:
            self._buffers = self.mujoco.MjrContext(model, self.mujoco.mjtFontScale.mjFONTSCALE_100.value)
        except self.mujoco.FatalError as error:
            raise NoRendererError(str(error)) from error
        self.mujoco.mjr_setBuffer(self.mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._buffers)
        self._scene = self.mujoco.MjvScene(model, model.ngeom + most_added)
        self._options = self.mujoco.MjvOption()

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self._context.make_current()
        self._buffers.free()
        self._context.free()

    def begin(self, data: Any, camera: Any) -> None:
        """Begin a picture with the model's objects where `data` says they are."""
        everything = self.mujoco.mjtCatBit.mjCAT_ALL.value
        self.mujoco.mjv_updateScene(self._model, data, self._options, None, camera, everything, self._scene)

    def add(self, kind: str, size: FloatArray, place: FloatArray, colour: FloatArray, yaw: float = 0.0) -> None:
        """Add an object to the picture.

        Args:
            kind: Such as "cylinder", as in MuJoCo's `mjtGeom`.
            size: Shape (3,) [m].
            place: Of its centre, shape (3,) [m].
            colour: Red, green, blue and opacity, shape (4,), 0 to 1.
            yaw: How it is turned about the vertical [rad].
        """
        scene, what = self._scene, getattr(self.mujoco.mjtGeom, f"mjGEOM_{kind.upper()}").value
        c, s = math.cos(yaw), math.sin(yaw)
        turned = np.array([c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0])
        self.mujoco.mjv_initGeom(scene.geoms[scene.ngeom], what, size, place, turned, colour.astype(np.float32))
        scene.ngeom += 1

    def add_line(self, begin: FloatArray, end: FloatArray, width: float, colour: FloatArray) -> None:
        """Add a flat stripe between places of shape (3,) at one height [m]; colour as for `add`."""
        x, y, _ = end - begin
        size = np.array([0.5 * math.hypot(x, y), 0.5 * width, 0.002])
        self.add("box", size, 0.5 * (begin + end), colour, math.atan2(y, x))

    def picture(self) -> FloatArray:
        """Return the picture, shape (height, width, 3), whole numbers from 0 to 255."""
        self._context.make_current()
        width, height = self.size
        pixels = np.empty((height, width, 3), dtype=np.uint8)
        whole = self.mujoco.MjrRect(0, 0, width, height)
        self.mujoco.mjr_render(whole, self._scene, self._buffers)
        self.mujoco.mjr_readPixels(pixels, None, whole, self._buffers)
        return np.flipud(pixels)


def _context(width: int, height: int) -> Any:
    """Return an OpenGL context of MuJoCo's Python package, the present one of this thread."""
    asked = os.environ.get("MUJOCO_GL", "").strip().lower()
    name = asked if asked in CONTEXTS else _USUAL.get(sys.platform, "glfw")
    if asked in ("disable", "disabled", "off", "false", "0"):
        raise NoRendererError(f"MUJOCO_GL = {asked}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of GLFW without a display: the error that follows is reported
            context = import_module(f"mujoco.{name}").GLContext(width, height)
            context.make_current()
    # what PyOpenGL raises depends on which of its libraries is missing
    except (ImportError, AttributeError, OSError, RuntimeError) as error:
        raise NoRendererError(f"OpenGL by {name}: {str(error).splitlines()[0]}") from error
    return context


#: Width and height of a picture [pixels].
SIZE = (720, 480)
#: Height of obstacles, which the scenario does not have [m].
OBSTACLE_HEIGHT = 0.6
#: MuJoCo's groups from 3 on are not drawn.
_HIDDEN = "3"
_DARK = "0.15 0.15 0.15 1"


def scene(scenario: Scenario) -> str:
    """Return the MuJoCo model of a scenario with colours, lights and a floor.

    Its joints are those of `mujoco_plant.mjcf`, so it takes the same `qpos`. Obstacles are the mocap bodies
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


#: Pieces of a trail and of the reference at most.
PIECES = 400
#: Least mean length of the reference's dashes [m].
DASH = 0.3
#: Angle at which the camera looks down on everything, and on a robot that it follows [degrees].
DOWN, DOWN_BEHIND = 52.0, 28.0
#: Share of the picture that the scene takes, as texts are at its borders.
ROOM = 0.9
#: Distance of a camera that follows a robot from it, in radii of the robot [-].
BEHIND = 13.0
#: Width of trails and crosses where the camera follows [m], and where it does not, as a share of its distance [-].
STRIPE, STRIPE_FAR = 0.08, 0.0035
#: The disc around an obstacle that is avoided, on both colours of the floor.
ACTIVE = ("#e29c64", "#dd975f")
_BLACK = np.array([0.0, 0.0, 0.0, 1.0])


class Scene:
    """Renders pictures of runs of a scenario.

    Args:
        scenario: Scenario of rigid bodies in MuJoCo.
        follow: Name of the robot that the camera follows, or None to see everything from above at an angle.

    Attributes:
        size: Width and height of a picture [pixels].
        palette: Colours that a picture may hold and the first one need not.

    Raises:
        renderer.NoRendererError: Where there is no OpenGL without a window.
    """

    def __init__(self, scenario: Scenario, follow: str | None = None) -> None:
        self.scenario = scenario
        self._mujoco: Any = import_module("mujoco")
        self._model = self._mujoco.MjModel.from_xml_string(scene(scenario))
        self._data = self._mujoco.MjData(self._model)
        per_robot = 3 * PIECES + len(scenario.obstacles) + 2  # trail, reference, radii, cross
        self._renderer = Renderer(self._model, len(scenario.robots) * per_robot)
        self.size, self.palette = self._renderer.size, (*PALETTE, *ACTIVE)
        self._followed = None if follow is None else list(scenario.robots).index(follow)
        self._font = ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"), 13)
        self._colours = [np.array([*to_rgb(c), 1.0]) for c in COLOURS]

    def __enter__(self) -> Scene:
        return self

    def __exit__(self, *error: object) -> None:
        self._renderer.__exit__(*error)

    def pictures(self, trajectory: Trajectory, samples: list[int]) -> Iterator[FloatArray]:
        """Yield a picture for each sample, shape (height, width, 3), whole numbers from 0 to 255."""
        places = centres(self.scenario, trajectory.t)
        radii = {n: derived.avoidance_radii(trajectory, self.scenario, n) for n in derived.avoiders(self.scenario)}
        whole = self._whole(trajectory)
        self._width = STRIPE if self._followed is not None else STRIPE_FAR * whole.distance
        assert trajectory.positions is not None
        for k in samples:
            self._data.qpos[:] = trajectory.positions[k]
            for a in range(len(self.scenario.obstacles)):
                self._data.mocap_pos[a, :2] = places[k, a]
            self._mujoco.mj_kinematics(self._model, self._data)
            self._mujoco.mj_camlight(self._model, self._data)
            self._renderer.begin(self._data, whole if self._followed is None else self._behind(trajectory, k))
            self._draw_paths(trajectory, k)
            self._draw_radii(trajectory, places[k], radii, k)
            yield self._inscribed(self._renderer.picture(), trajectory, k)

    def _camera(self, place: FloatArray, azimuth: float, down: float, distance: float) -> Any:
        camera = self._mujoco.MjvCamera()
        camera.lookat[:] = place
        camera.azimuth, camera.elevation, camera.distance = azimuth, -down, distance
        return camera

    def _whole(self, trajectory: Trajectory) -> Any:
        """Return the camera that sees all that the run needs, x to the right and y away from it."""
        (low_x, low_y), (high_x, high_y) = extent(trajectory, self.scenario)
        half_x, half_y = 0.5 * (high_x - low_x), 0.5 * (high_y - low_y)
        c, s = math.cos(math.radians(DOWN)), math.sin(math.radians(DOWN))
        up = ROOM * math.tan(0.5 * math.radians(float(self._model.vis.global_.fovy)))
        across = up * self.size[0] / self.size[1]
        before, distance = 0.0, 0.0
        for _ in range(20):  # each step brings a third or less of the change of the one before
            near = half_y - before
            distance = c * near + max(s * near / up, half_x / across)
            # the near edge is seen larger than the far one: looking at a place before the middle evens that out
            before = (math.sqrt(distance**2 + (2.0 * c * half_y) ** 2) - distance) / (2.0 * c)
        place = np.array([low_x + half_x, low_y + half_y - before, 0.0])
        return self._camera(place, 90.0, DOWN, distance)

    def _behind(self, trajectory: Trajectory, k: int) -> Any:
        i = self._followed or 0
        place = np.array([trajectory["x"][k, i], trajectory["y"][k, i], 0.0])
        radius = list(self.scenario.robots.values())[i].radius
        return self._camera(place, math.degrees(trajectory["theta"][k, i]), DOWN_BEHIND, BEHIND * radius)

    def _draw_paths(self, trajectory: Trajectory, k: int) -> None:
        """Draw references, trails, and crosses where robots should be."""
        every = max(1, len(trajectory.t) // PIECES)
        for i, name in enumerate(trajectory.robots):
            colour = self._colours[i % len(self._colours)]
            if not self.scenario.robots[name].leaders:
                x_r, y_r = trajectory["x_r"][:, i], trajectory["y_r"][:, i]
                length = float(np.hypot(np.diff(x_r), np.diff(y_r)).sum())
                dash = max(every, round(DASH * len(x_r) / max(length, DASH)))
                ends = _on_ground(x_r[::dash], y_r[::dash], 0.01)
                for begin, end in zip(ends[:-1:2], ends[1::2], strict=False):
                    self._renderer.add_line(begin, end, 0.6 * self._width, _BLACK)
            trail = np.append(np.arange(0, k, every), k)
            ends = _on_ground(trajectory["x"][trail, i], trajectory["y"][trail, i], 0.015)
            for begin, end in pairwise(ends):
                self._renderer.add_line(begin, end, self._width, colour)
            target = np.array([trajectory["x_r"][k, i], trajectory["y_r"][k, i], 0.02])
            for along in ((0.25, 0.25, 0.0), (0.25, -0.25, 0.0)):
                self._renderer.add_line(target - along, target + along, self._width, colour)

    def _draw_radii(self, trajectory: Trajectory, places: FloatArray, radii: dict[str, FloatArray], k: int) -> None:
        """Draw R_d of every obstacle as a disc on the ground, stronger while the obstacle is avoided."""
        for name, radius in radii.items():
            avoided = int(trajectory["obstacle"][k, trajectory.robots.index(name)])
            for a, (x, y) in enumerate(places):
                colour = np.array([*to_rgb(COLOURS[1]), 0.35] if a == avoided else [0.3, 0.3, 0.3, 0.15])
                size, place = np.array([radius[k, a], 0.002, 0.0]), np.array([x, y, 0.004])
                self._renderer.add("cylinder", size, place, colour)

    def _inscribed(self, picture: FloatArray, trajectory: Trajectory, k: int) -> FloatArray:
        """Write the law, the names, the time and the disturbances into a picture."""
        image = Image.fromarray(picture)
        draw = ImageDraw.Draw(image)
        width, height = self.size
        law = trajectory.controller
        draw.text((12, 10), TITLES.get(law, law), "black", self._font)
        draw.text((width - 12, 10), f"t = {trajectory.t[k]:6.1f} s", "black", self._font, anchor="ra")
        if words := acting(trajectory, self.scenario, k):
            box = draw.textbbox((0.5 * width, 10), words, self._font, anchor="ma")
            draw.rectangle((box[0] - 4, box[1] - 3, box[2] + 4, box[3] + 3), NOTE)
            draw.text((0.5 * width, 10), words, "black", self._font, anchor="ma")
        x = 12.0
        for i, name in enumerate(trajectory.robots):
            draw.rectangle((x, height - 22, x + 12, height - 10), COLOURS[i % len(COLOURS)])
            draw.text((x + 18, height - 16), name, "black", self._font, anchor="lm")
            x += 38 + draw.textlength(name, self._font)
        return np.asarray(image)


def _on_ground(x: FloatArray, y: FloatArray, height: float) -> FloatArray:
    """Return places at a height above the ground, shape (n, 3) [m]."""
    return np.stack([x, y, np.full(len(x), height)], axis=1)
