"""What is kept on disk is used for the function that it was written for; what cannot be used costs only time."""

import errno
import linecache
import shutil
from contextlib import contextmanager

import numba
import pytest
from numba.core import compiler

from fuzzyctl.kernels.backends.numba.disk_cache import kept, native

TEXT = "def twice(x):\n    return x + x\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Have numba keep its files where nothing else is kept."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def make(tmp_path):
    """Define a function in a file, as a new process would."""
    path = tmp_path / "module.py"
    path.write_text(TEXT)

    def again():
        linecache.checkcache()
        names = {"__name__": "module", "__file__": str(path)}
        exec(compile(TEXT, str(path), "exec"), names)
        return names["twice"]

    return again


def files(folder, suffix):
    return sorted(folder.rglob(f"*.{suffix}"))


def hits(function):
    return sum(function.stats.cache_hits.values())


def test_is_found_again(folder, make):
    first, second = (native("float64(float64)", error_model="numpy")(make()) for _ in range(2))
    assert (hits(first), hits(second)) == (0, 1)
    assert second(2.5) == 5.0


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("garbage", [b"", b"garbage", bytes(200), bytes(range(256))])
def test_is_compiled_anew_where_it_is_damaged(folder, make, suffix, garbage):
    native("float64(float64)")(make())
    (path,) = files(folder, suffix)
    path.write_bytes(garbage)
    found = native("float64(float64)")(make())
    assert (hits(found), found(2.5)) == (0, 5.0)
    assert hits(native("float64(float64)")(make())) == 1


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("length", [0, 10, 40])
def test_is_not_run_where_it_is_cut_short(folder, make, suffix, length):
    native("float64(float64)")(make())
    (path,) = files(folder, suffix)
    path.write_bytes(path.read_bytes()[:length])
    found = native("float64(float64)")(make())
    assert (hits(found), found(2.5)) == (0, 5.0)


def test_of_another_signature_is_not_run(folder, make):
    """Two processes that begin with the same index write two signatures to one file."""
    first = kept(numba.njit(make()))
    assert (first(2.5), first(3)) == (5.0, 6)
    of_floats, of_integers = files(folder, "nbc")
    shutil.copy(of_integers, of_floats)
    second = kept(numba.njit(make()))
    assert (second(2.5), second(3)) == (5.0, 6)
    assert hits(second) == 1


def test_that_cannot_be_kept_is_compiled_once(folder, make, monkeypatch):
    count = []
    compile_extra = compiler.compile_extra
    monkeypatch.setattr(compiler, "compile_extra", lambda *a, **k: count.append(1) or compile_extra(*a, **k))

    @contextmanager
    def full(*_):
        raise OSError(errno.ENOSPC, "no space left on device")
        yield

    monkeypatch.setattr(numba.core.caching.IndexDataCacheFile, "_open_for_write", full)
    assert native("float64(float64)")(make())(2.5) == 5.0
    assert (len(count), files(folder, "nb?")) == (1, [])


def test_that_cannot_be_read_is_compiled(folder, make, monkeypatch):
    native("float64(float64)")(make())

    def unreadable(*_):
        raise PermissionError(errno.EACCES, "permission denied")

    monkeypatch.setattr(numba.core.caching.IndexDataCacheFile, "_load_data", unreadable)
    found = native("float64(float64)")(make())
    assert (hits(found), found(2.5)) == (0, 5.0)


def test_of_a_function_without_a_file_is_not_kept(folder):
    names = {}
    exec(TEXT, names)
    assert native("float64(float64)")(names["twice"])(2.5) == 5.0
    assert not folder.exists()


@pytest.mark.parametrize(
    "error",
    [
        ModuleNotFoundError("No module named '<dynamic>'"),
        AttributeError("gone"),
        KeyError(),
        MemoryError(),
        RuntimeError("LLVM"),
    ],
)
def test_that_names_what_is_no_more_counts_as_none(folder, make, monkeypatch, error):
    native("float64(float64)")(make())

    def nowhere(*_):
        raise error

    with monkeypatch.context() as patch:
        patch.setattr(numba.core.caching.CompileResultCacheImpl, "rebuild", nowhere)
        found = native("float64(float64)")(make())
        assert (hits(found), found(2.5)) == (0, 5.0)
    assert hits(native("float64(float64)")(make())) == 1
