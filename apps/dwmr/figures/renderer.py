"""MuJoCo's renderer, into memory and without a window: OpenGL by EGL, or by what MUJOCO_GL says."""

from __future__ import annotations

import math
import os
import sys
import warnings
from importlib import import_module
from typing import Any

import numpy as np

from dwmr.core.arrays import FloatArray

#: What makes a context of OpenGL: modules of MuJoCo, by the values of MUJOCO_GL.
CONTEXTS = ("egl", "osmesa", "glfw", "cgl")
#: The one of each system where MUJOCO_GL is not set.
_USUAL = {"linux": "egl", "darwin": "cgl"}


class NoRendererError(Exception):
    """Raised where no picture can be rendered, with the reason."""


class Renderer:
    """Renders a model; a context manager, as what it holds of OpenGL must go while its own context is the present one.

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
            warnings.simplefilter("ignore")  # of GLFW without a display: what follows from it is reported
            context = import_module(f"mujoco.{name}").GLContext(width, height)
            context.make_current()
    # what PyOpenGL raises depends on which of its libraries is missing
    except (ImportError, AttributeError, OSError, RuntimeError) as error:
        raise NoRendererError(f"OpenGL by {name}: {str(error).splitlines()[0]}") from error
    return context
