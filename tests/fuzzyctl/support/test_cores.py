"""How many cores a process may use."""

import os

import pytest

from fuzzyctl.support import cores

MANY = 1 << 20


@pytest.fixture
def write(tmp_path):
    def written(name, text):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="ascii")
        return path

    return written


@pytest.mark.parametrize(
    ("limit", "expected"),
    [("200000 100000", 2), ("150000 100000", 2), ("50000 100000", 1), ("max 100000", MANY), ("1 0", MANY), ("", MANY)],
)
def test_the_limit_of_a_container_counts(write, tmp_path, limit, expected):
    write("groups/cpu.max", limit + "\n")
    assert cores.granted(tmp_path / "groups", write("own", "0::/\n")) == expected


def test_the_least_limit_of_a_group_and_those_it_is_in_counts(write, tmp_path):
    write("groups/a/cpu.max", "300000 100000\n")
    write("groups/a/b/cpu.max", "max 100000\n")
    write("groups/c/cpu.max", "100000 100000\n")
    assert cores.granted(tmp_path / "groups", write("own", "0::/a/b\n")) == 3


@pytest.mark.parametrize("controllers", ["cpu", "cpu,cpuacct"])
def test_groups_of_the_first_version_have_a_file_for_each_number(write, tmp_path, controllers):
    write(f"groups/{controllers}/x/cpu.cfs_quota_us", "400000\n")
    write(f"groups/{controllers}/x/cpu.cfs_period_us", "100000\n")
    write(f"groups/{controllers}/cpu.cfs_quota_us", "-1\n")
    write(f"groups/{controllers}/cpu.cfs_period_us", "100000\n")
    write("groups/memory/x/cpu.cfs_quota_us", "100000\n")
    write("groups/memory/x/cpu.cfs_period_us", "100000\n")
    assert cores.granted(tmp_path / "groups", write("own", f"4:memory:/x\n1:{controllers}:/x\n")) == 4


@pytest.mark.parametrize("text", ["0::/nowhere\n", "nonsense\n", "0::/../..\n", ""])
def test_without_groups_there_is_no_limit(write, tmp_path, text):
    write("cpu.max", "100000 100000\n")
    assert cores.granted(tmp_path / "groups" / "deep", write("own", text)) == MANY
    assert cores.granted(tmp_path, tmp_path / "missing") == MANY


def test_no_more_than_the_process_is_bound_to(monkeypatch):
    monkeypatch.setattr(cores, "_granted", lambda: 3)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _process: set(range(8)), raising=False)
    assert cores.cores() == 3
    monkeypatch.setattr(os, "sched_getaffinity", lambda _process: {1}, raising=False)
    assert cores.cores() == 1
