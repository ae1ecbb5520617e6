"""Where MuJoCo cannot render: the reason, and the film from above."""

from types import SimpleNamespace

import pytest
from PIL import Image

from dwmr.figures import scene
from dwmr.figures.scene import NoRendererError, _context
from tests.dwmr.process import here
from tests.physics import needs_mujoco


@pytest.mark.parametrize("word", ["disable", "Off", "0"])
def test_a_renderer_that_is_turned_off_is_none(monkeypatch, word):
    monkeypatch.setenv("MUJOCO_GL", word)
    with pytest.raises(NoRendererError, match=r"^MUJOCO_GL = "):
        _context(8, 8)


@pytest.mark.parametrize(("asked", "name"), [("osmesa", "osmesa"), ("GLFW", "glfw"), ("", "egl"), ("1", "egl")])
def test_the_context_is_the_one_that_is_asked_for(monkeypatch, asked, name):
    made = []

    def loaded(module):
        made.append(module)
        return SimpleNamespace(GLContext=lambda *size: SimpleNamespace(make_current=lambda: made.append(size)))

    monkeypatch.setenv("MUJOCO_GL", asked)
    monkeypatch.setattr(scene, "import_module", loaded)
    monkeypatch.setattr(scene.sys, "platform", "linux")
    _context(8, 6)
    assert made == [f"mujoco.{name}", (8, 6)]


@pytest.mark.parametrize("error", [ImportError, AttributeError, OSError, RuntimeError])
def test_a_library_that_is_missing_is_a_reason(monkeypatch, error):
    def broken(module):
        raise error("no library\nand more")

    monkeypatch.setenv("MUJOCO_GL", "egl")
    monkeypatch.setattr(scene, "import_module", broken)
    with pytest.raises(NoRendererError, match=r"^OpenGL by egl: no library$"):
        _context(8, 8)


@needs_mujoco
class TestAnimate:
    SHORT = ("animate", "experiment", "--set", "run.horizon=0.5")

    def test_draws_from_above_with_a_warning(self, tmp_path):
        done = here(*self.SHORT, "-o", tmp_path / "a.gif", MUJOCO_GL="off")
        first, repair = done.stderr.splitlines()
        assert first == "warning: MuJoCo cannot render here: MUJOCO_GL = off; the run is drawn from above"
        assert repair.startswith(" = help: leave MUJOCO_GL unset")
        with Image.open(tmp_path / "a.gif") as gif:
            assert gif.n_frames == 2

    def test_refuses_a_scene_that_is_asked_for(self, tmp_path):
        done = here(*self.SHORT, "--follow", "leader", "-o", tmp_path / "a.gif", MUJOCO_GL="off", status=1)
        assert "Error: MuJoCo cannot render here: MUJOCO_GL = off\n = help: " in done.stderr
        assert "--view above" in done.stderr
        assert list(tmp_path.iterdir()) == []

    def test_is_silent_where_a_drawing_is_asked_for(self, tmp_path):
        assert here(*self.SHORT, "--view", "above", "-o", tmp_path / "a.gif", MUJOCO_GL="off").stderr == ""
