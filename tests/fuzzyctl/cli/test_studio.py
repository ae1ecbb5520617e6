"""`fuzzyctl studio` serves a folder that was built, and says what to do where there is none."""

import shutil
import subprocess
import sys
import threading
import urllib.request
import zipfile
from http.server import ThreadingHTTPServer
from pathlib import Path

import pytest

import fuzzyctl
from tests.commands import runner

run = runner("studio")
SOURCES = Path(__file__).parents[3] / "apps" / "studio"
REPAIR = "pip install 'fuzzyctl[studio]', or in a clone: pip install ./apps/studio\n"


def folder(path, version=fuzzyctl.__version__):
    path.mkdir(parents=True, exist_ok=True)
    (path / "index.html").write_text("<!doctype html>")
    (path / "version.txt").write_text(version)
    return path


@pytest.fixture
def built(tmp_path, monkeypatch):
    def interrupted(self):
        for thread in threading.enumerate():
            if "_open" in thread.name:
                thread.join(10)
        raise KeyboardInterrupt

    monkeypatch.setattr(ThreadingHTTPServer, "serve_forever", interrupted)
    return folder(tmp_path)


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Make fuzzyctl an installed one, beside which other packages can be put."""
    monkeypatch.setattr("fuzzyctl.support.files._PACKAGE", tmp_path / "site" / "fuzzyctl")
    monkeypatch.syspath_prepend(tmp_path / "site")
    return tmp_path / "site"


def test_it_prints_the_address_with_the_text(built, tmp_path):
    (tmp_path / "a.fz").write_text("system a\n")
    found = run(tmp_path / "a.fz", "--folder", built, "--no-browser")
    assert found.exit_code == 0
    assert found.output.startswith("the studio: http://127.0.0.1:")
    assert "#name=a.fz&text=" in found.output


def test_the_browser_is_answered_before_it_returns(built, monkeypatch):
    """A browser in the foreground returns when it is closed."""
    opened, closed = [], threading.Event()

    def browser(place):
        with urllib.request.urlopen(place, timeout=10) as answer:
            opened.append(answer.read())
        closed.set()
        return True

    def interrupted(self):
        self.timeout = 10
        self.handle_request()
        closed.wait(10)
        raise KeyboardInterrupt

    monkeypatch.setattr("webbrowser.open", browser)
    monkeypatch.setattr(ThreadingHTTPServer, "serve_forever", interrupted)
    assert (run("--folder", built, "--port", 0).stderr, opened) == ("\n", [b"<!doctype html>"])


def test_a_browser_that_does_not_start_is_a_line(built, monkeypatch):
    def too_long(place):
        raise OSError(7, "Argument list too long", "chromium")

    for browser in (too_long, lambda place: False):
        monkeypatch.setattr("webbrowser.open", browser)
        found = run("--folder", built, "--port", 0)
        assert (found.exit_code, found.stderr) == (0, "no browser opens the address above: open it there yourself\n\n")


def test_standard_input_is_a_text(built):
    assert "name=stdin.fz" in run("-", "--folder", built, "--no-browser", stdin="system a\n").output


def test_without_a_studio_it_says_how_to_get_one(tmp_path, installed):
    found = run()
    assert (found.exit_code, found.stderr) == (1, f"Error: the studio is not installed: {REPAIR}")
    found = run("--folder", tmp_path)
    assert found.exit_code == 2
    assert found.stderr.endswith(f"Error: there is no studio in '{tmp_path}': {REPAIR}")


def test_the_folder_is_the_named_one_else_that_of_the_checkout_else_the_installed_one(built, installed):
    """One with another version is named, and served."""
    folder(installed / "fuzzyctl_studio")
    assert "fuzzyctl" not in run("--no-browser", "--port", 0).stderr
    checkout = installed / "apps" / "studio" / "dist"
    for options, place in ([(), installed / "fuzzyctl_studio"], [(), checkout], [("--folder", built), built]):
        folder(place, "0.0.9")
        found = run("--no-browser", "--port", 0, *options)
        line = f"the studio in '{place}' has fuzzyctl 0.0.9, this is {fuzzyctl.__version__}: {REPAIR}"
        assert (found.exit_code, found.stderr) == (0, f"{line}\n")
    (built / "version.txt").unlink()
    assert "has fuzzyctl of an unknown version, this is" in run("--no-browser", "--folder", built).stderr


def test_the_package_has_the_folder_that_was_built(tmp_path):
    for name in ("pyproject.toml", "hatch_build.py", "README.md"):
        shutil.copy(SOURCES / name, tmp_path)
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", "wheels"]
    build = {"cwd": tmp_path, "env": {"PATH": ""}, "capture_output": True, "text": True}
    found = subprocess.run(command, **build, check=False)
    line = "the studio cannot be built: there is no npm; install Node 20 or newer, and try again\n"
    assert (found.returncode, found.stdout + found.stderr) == (1, line)
    folder(tmp_path / "dist")
    subprocess.run(command, **build, check=True)
    (wheel,) = (tmp_path / "wheels").iterdir()
    names = zipfile.ZipFile(wheel).namelist()
    assert {"fuzzyctl_studio/index.html", "fuzzyctl_studio/version.txt"} < set(names)


def test_a_file_that_is_not_there_is_a_mistake(built):
    found = run("nowhere.fz", "--folder", built)
    assert found.exit_code == 1
    assert "nowhere.fz" in found.output


def test_a_port_that_is_taken_is_named(built):
    taken = ThreadingHTTPServer(("127.0.0.1", 0), None)
    found = run("--folder", built, "--port", str(taken.server_port))
    taken.server_close()
    assert found.exit_code == 2
    assert f"port {taken.server_port} cannot be served" in " ".join(found.output.split())


def test_the_port_is_the_same_at_each_start(built, monkeypatch):
    taken = ThreadingHTTPServer(("127.0.0.1", 0), None)
    free = taken.server_port
    monkeypatch.setattr("fuzzyctl.studio.server.PORT", free)
    first = run("--folder", built, "--no-browser")
    taken.server_close()
    second = run("--folder", built, "--no-browser")
    assert first.exit_code == second.exit_code == 0
    assert f"port {free} cannot be served" in first.stderr
    assert f":{free}/" not in first.stdout
    assert "cannot be served" not in second.stderr
    assert second.stdout == f"the studio: http://127.0.0.1:{free}/\n"
