"""Files that are run are taken only from folders no other user can write to; without them everything still works."""

import os

import pytest

import fuzzyctl
from fuzzyctl.support import private_folders

pytestmark = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="the platform has no owners of files")

TEXT = """
system s
input x in [0, 1]
  a = ramp(0, 0.31)
output y in [0, 1] else 0
  b = constant(1)
defuzzifier weighted_average
if x is a then y is b
"""


@pytest.fixture(autouse=True)
def nothing_warned_of(monkeypatch):
    monkeypatch.setattr(private_folders, "_WARNED", set())


def test_a_folder_that_is_made_is_for_the_user_alone(tmp_path):
    before = os.umask(0)
    try:
        assert private_folders.is_private(tmp_path / "cache", "kernels")
    finally:
        os.umask(before)
    assert (tmp_path / "cache").stat().st_mode & 0o777 == 0o700
    assert (tmp_path / "cache" / "kernels").stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize(("shared", "mode"), [("cache", 0o777), ("cache/kernels", 0o702), ("cache", 0o1777)])
def test_a_folder_that_others_may_write_to_is_warned_of_once(tmp_path, shared, mode):
    (tmp_path / "cache" / "kernels").mkdir(parents=True)
    (tmp_path / shared).chmod(mode)
    with pytest.warns(RuntimeWarning, match="can be written to by other users.*FUZZYCTL_CACHE_DIR"):
        assert not private_folders.is_private(tmp_path / "cache", "kernels")
    assert not private_folders.is_private(tmp_path / "cache", "kernels")


def test_a_group_is_another_user_unless_it_is_the_users_own(tmp_path, monkeypatch):
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache").chmod(0o770)
    monkeypatch.setattr(private_folders, "_is_own_group", lambda _: True)
    assert private_folders.is_private(tmp_path / "cache")
    monkeypatch.setattr(private_folders, "_is_own_group", lambda _: False)
    with pytest.warns(RuntimeWarning, match="written to by other users"):
        assert not private_folders.is_private(tmp_path / "cache")


def test_a_folder_of_another_user_is_not_used(tmp_path, monkeypatch):
    (tmp_path / "cache").mkdir(mode=0o700)
    owner = (tmp_path / "cache").stat().st_uid
    if owner == 0:  # root can give a folder away, and trusts no other user
        os.chown(tmp_path / "cache", 12345, -1)
    else:
        monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
    with pytest.warns(RuntimeWarning, match="belongs to another user"):
        assert not private_folders.is_private(tmp_path / "cache")


def test_a_link_to_a_private_folder_of_the_user_is_followed(tmp_path):
    (tmp_path / "disk").mkdir(mode=0o700)
    (tmp_path / "cache").symlink_to(tmp_path / "disk")
    assert private_folders.is_private(tmp_path / "cache")
    (tmp_path / "disk").chmod(0o777)
    with pytest.warns(RuntimeWarning, match="written to by other users"):
        assert not private_folders.is_private(tmp_path / "cache")


@pytest.mark.parametrize("variable", ["FUZZYCTL_CACHE_DIR", "CACHE_DIR of numba"])
def test_kernels_compile_without_a_folder_that_others_may_write_to(tmp_path, monkeypatch, variable):
    numba = pytest.importorskip("numba")
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared").chmod(0o777)
    if variable == "FUZZYCTL_CACHE_DIR":
        monkeypatch.setenv(variable, str(tmp_path / "shared"))
        peak = "0.3171"
    else:
        monkeypatch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path / "own"))
        monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "shared"))
        peak = "0.3172"
    with pytest.warns(RuntimeWarning, match="compiled code is not kept"):
        assert fuzzyctl.compile(fuzzyctl.loads(TEXT.replace("0.31", peak)), "numba")(float(peak) / 2) == pytest.approx(
            1.0
        )
    assert [p for p in (tmp_path / "shared").rglob("*") if p.is_file()] == []


def test_robots_compile_without_a_folder_that_others_may_write_to(tmp_path, monkeypatch):
    from dwmr.core import jit

    if not jit.COMPILED:
        pytest.skip("needs numba")
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared").chmod(0o777)
    monkeypatch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path / "shared"))
    jit._cache_folder.cache_clear()
    try:
        with pytest.warns(RuntimeWarning, match="compiled code is not kept"):
            assert jit.compiled(lambda x: 2.0 * x)(21.0) == 42.0
    finally:
        jit._cache_folder.cache_clear()
    assert [p for p in (tmp_path / "shared").rglob("*") if p.is_file()] == []


@pytest.mark.parametrize(
    ("platform", "variable", "expected"),
    [
        ("linux", {"XDG_CACHE_HOME": "/x"}, "/x/fuzzyctl"),
        ("linux", {"XDG_CACHE_HOME": ""}, "/home/me/.cache/fuzzyctl"),
        ("darwin", {}, "/home/me/Library/Caches/fuzzyctl"),
        ("win32", {"LOCALAPPDATA": "/local"}, "/local/fuzzyctl/Cache"),
    ],
)
def test_the_folder_follows_the_platform(monkeypatch, platform, variable, expected):
    monkeypatch.delenv("FUZZYCTL_CACHE_DIR", raising=False)
    monkeypatch.setattr(private_folders.sys, "platform", platform)
    monkeypatch.setattr(private_folders.Path, "home", lambda: private_folders.Path("/home/me"))
    for name, value in variable.items():
        monkeypatch.setenv(name, value)
    assert private_folders.cache_folder().as_posix() == expected
