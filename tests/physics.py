"""What tests need to know of the extra `physics`, which not everybody has."""

from functools import cache
from importlib.util import find_spec

import pytest

from dwmr import find, read

needs_mujoco = pytest.mark.skipif(
    find_spec("mujoco") is None, reason="MuJoCo is not installed: pip install 'fuzzyctl[physics]'"
)


@cache
def renders():
    """Whether MuJoCo renders pictures here."""
    if find_spec("mujoco") is None:
        return False
    from dwmr.figures import scene
    from dwmr.figures.scene import NoRendererError

    try:
        with scene.Scene(read(find("experiment")).scenario):
            return True
    except NoRendererError:
        return False


def require_renderer():
    """Skip a test where MuJoCo renders no pictures."""
    if not renders():
        pytest.skip("MuJoCo renders no pictures here: pip install 'fuzzyctl[physics]'; apt install libegl1")


def shipped_names():
    """The names of all shipped scenarios."""
    return sorted(path.stem for path in find("paper").parent.glob("*.toml"))


def is_of_equations(name):
    """Whether a shipped scenario runs without MuJoCo; from its text, as this is asked when tests are collected."""
    return 'plant = "mujoco"' not in find(name).read_text(encoding="utf-8")


def shipped():
    """The names of all shipped scenarios as parameters, those that need MuJoCo with their mark."""
    return [name if is_of_equations(name) else pytest.param(name, marks=needs_mujoco) for name in shipped_names()]


def shipped_of_equations():
    """The names of those that run without MuJoCo."""
    return [name for name in shipped_names() if is_of_equations(name)]
