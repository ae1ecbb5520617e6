"""`fuzzyctl studio` serves a folder that was built, and says what to do where there is none."""

from http.server import ThreadingHTTPServer

import pytest

from tests.commands import runner

run = runner("studio")


@pytest.fixture
def built(tmp_path, monkeypatch):
    (tmp_path / "index.html").write_text("<!doctype html>")

    def interrupted(self):
        raise KeyboardInterrupt

    monkeypatch.setattr(ThreadingHTTPServer, "serve_forever", interrupted)
    return tmp_path


def test_it_prints_the_address_with_the_text(built, tmp_path):
    (tmp_path / "a.fz").write_text("system a\n")
    found = run(tmp_path / "a.fz", "--folder", built, "--no-browser")
    assert found.exit_code == 0
    assert found.output.startswith("the studio: http://127.0.0.1:")
    assert "#name=a.fz&text=" in found.output


def test_it_opens_the_browser(built, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    assert run("--folder", built).exit_code == 0
    assert opened[0].startswith("http://127.0.0.1:")


def test_standard_input_is_a_text(built):
    assert "name=stdin.fz" in run("-", "--folder", built, "--no-browser", stdin="system a\n").output


def test_without_a_studio_it_says_how_to_build_one(tmp_path):
    found = run("--folder", tmp_path)
    assert found.exit_code == 2
    assert "npm ci && node build.mjs" in " ".join(found.output.split())


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
