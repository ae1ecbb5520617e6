"""Journal of a sweep, and the versions and checksums that tell whether it can be resumed."""

from __future__ import annotations

import hashlib
import json
import os
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.experiments.sweep_plan import Plan
from fuzzyctl.experiments.sweep_spec import SpecFile
from fuzzyctl.experiments.sweep_workers import Outcome
from fuzzyctl.support.files import is_special


def describe(file: SpecFile, plan: Plan[Any], overrides: Sequence[str]) -> dict[str, Any]:
    """Return where the results of a sweep come from, as plain data."""
    controllers = tuple(dict.fromkeys(run.controller for run in plan.runs))
    return {
        "spec": file.spec.model_dump(mode="json", exclude_none=True),
        "overrides": list(overrides),
        "runs": len(plan.runs),
        "scenario": {
            "name": plan.scenario.name,
            "file": plan.scenario.path.name,
            "sha256": plan.scenario.sha256,
            "inputs": hashlib.sha256("".join(run.sha256 for run in plan.runs).encode()).hexdigest(),
            "text": list(plan.scenario.texts),
        },
        "rules": dict(sorted(plan.used.items())),
        "laws": dict(plan.runnable.own_files(plan.scenario, controllers)),
        "versions": plan.runnable.software(),
    }


def differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """Yield the differences between two descriptions, in words."""
    yield from dict.fromkeys(_in_words(*key) for key in _keys(before, now))


def _keys(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """Yield the keys in which two descriptions differ."""
    for key in dict.fromkeys([*before, *now]):
        old, new = before.get(key), now.get(key)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            yield from ((key, *inner) for inner in _keys(old, new))
        elif old != new:
            yield (key,)


def _in_words(part: str, *keys: str) -> str:
    """Return the subject of a key of a description."""
    match part, keys:
        case "spec", _:
            return f"{'.'.join(keys)} of the SPEC"
        case "overrides", _:
            return "values of --set"
        case "runs", _:
            return "number of runs"
        case "scenario", ("inputs",):
            return "settings of the runs"
        case "scenario", ("name" | "file",):
            return "name of the scenario"
        case "scenario", _:
            return "text of the scenario"
        case "rules", _:
            return f"file {Path(keys[-1]).name}" if keys else "files that are used"
        case "laws", _:
            return f"law {keys[-1]}" if keys else "laws"
        case _:
            return f"version of {keys[-1]}" if keys and keys[-1] != "sources" else "version of this program"


NAME = "journal.jsonl"
#: Provenance of the results of a finished sweep.
ABOUT = "sweep.json"


class Journal:
    """Runs that are done, on their way into the results.

    Args:
        file: Open for writing at its end.
        path: Its name.
        done: Outcomes by number.
    """

    def __init__(self, file: BinaryIO, path: Path, done: dict[int, Outcome]) -> None:
        self._file, self._path, self.done = file, path, done

    def add(self, outcome: Outcome) -> None:
        """Keep a run; it survives whatever becomes of this process."""
        self.write([outcome.number, outcome.wall_s, dict(outcome.row)])
        self.done[outcome.number] = outcome

    def write(self, data: Any) -> None:
        """Write a line.

        Raises:
            DiagnosticError: When it cannot be written.
        """
        try:
            self._file.write(_line(data))
            self._file.flush()
        except OSError as error:
            with suppress(OSError):  # closing writes the line once more
                self._file.close()
            help_text = "make room, and go on with --resume" if self.done else "name another folder with -o DIR"
            raise _refused(self._path, f"cannot be written: {error.strerror}", help=help_text) from error


@contextmanager
def journal(folder: Path, about: Mapping[str, Any], resume: bool) -> Iterator[Journal]:
    """Open the journal of a sweep, anew or where it was left.

    Args:
        folder: Of the results; it exists.
        about: Provenance of the results.
        resume: Whether a journal that is there goes on.

    Raises:
        DiagnosticError: When a journal is there and must not be lost, or rests on something else, or is in use.
    """
    path = folder / NAME
    if is_special(path):  # reading could block for ever
        raise _refused(path, "is not a regular file")
    try:
        file = os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT, 0o666), "r+b")
    except OSError as error:
        raise _refused(path, f"cannot be written: {error.strerror}") from error
    with file:
        _lock(file, path)
        lines = list(_whole(file))
        if len(lines) == 1 and not resume:  # it holds no run
            lines = []
        if lines:
            _require_same(path, lines[0], about, len(lines) - 1, resume)
        done = {number: Outcome(number, row, wall_s) for number, wall_s, row in lines[1:]}
        opened = Journal(file, path, done)
        try:
            if not lines:
                file.seek(0)
                file.truncate()
                opened.write(about)
            yield opened
        finally:
            if not done:
                remove(folder)


def require_something(folder: Path, about: Mapping[str, Any]) -> None:
    """Refuse to resume where there is nothing to go on with, or results of another sweep.

    Raises:
        DiagnosticError: When there is no journal, nor results of the same sweep.
    """
    if (folder / NAME).exists():
        return
    before = _finished(folder)
    if before is None:
        raise _refused(folder, "holds no sweep to go on with", help="leave --resume out to begin one")
    path = folder / ABOUT
    del before["columns"]
    refuse_changes(path, before, about)
    raise _refused(path, "belongs to a sweep that is finished", help="leave --resume out to begin it anew")


def require_own(folder: Path, names: Sequence[str]) -> None:
    """Refuse a folder with files that no sweep wrote under the names of a sweep's results; they would be lost.

    Args:
        folder: Of the results.
        names: Of the files that a sweep leaves.

    Raises:
        DiagnosticError: Naming the files.
    """
    there = [name for name in names if (folder / name).exists()]
    if there and _finished(folder) is None:
        help_text = "move them away, or name another folder with -o DIR"
        raise _refused(folder, f"holds {', '.join(there)}, and no sweep wrote that", help=help_text)


def _finished(folder: Path) -> dict[str, Any] | None:
    """Return the provenance of the results in a folder, None without results of a sweep."""
    if is_special(folder / ABOUT):
        return None
    try:
        before = json.loads((folder / ABOUT).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return before if isinstance(before, dict) and {"spec", "runs", "columns"} <= before.keys() else None


def remove(folder: Path) -> None:
    """Remove the journal of a sweep whose results are whole."""
    (folder / NAME).unlink(missing_ok=True)


def _line(data: Any) -> bytes:
    text = json.dumps(data, ensure_ascii=False).encode()
    return b"%08x %s\n" % (zlib.crc32(text), text)


def _whole(file: BinaryIO) -> Iterator[Any]:
    """Yield the content of all whole lines, and cut off the rest: a run that was being written."""
    end = 0
    for line in file:
        checksum, _, text = line.partition(b" ")
        if not line.endswith(b"\n") or checksum != b"%08x" % zlib.crc32(text[:-1]):
            break
        yield json.loads(text)
        end += len(line)
    file.seek(end)
    file.truncate()


def _require_same(path: Path, before: Any, about: Mapping[str, Any], count: int, resume: bool) -> None:
    if not resume:
        help_text = "go on with --resume, name another folder with -o DIR, or delete the journal to begin anew"
        raise _refused(path, f"holds {count} of {before['runs']} runs of a sweep that is not finished", help=help_text)
    refuse_changes(path, before, about)


def refuse_changes(path: Path, before: Mapping[str, Any], about: Mapping[str, Any]) -> None:
    """Refuse to go on with a sweep that rests on something else.

    Raises:
        DiagnosticError: Naming what changed.
    """
    # as it reads after a way through JSON
    changed = list(differences(before, json.loads(json.dumps(about))))
    if changed:
        help_text = "put back what changed, or begin anew in another folder with -o DIR"
        raise _refused(
            path,
            "belongs to another sweep than this one: results of both cannot be mixed",
            [f"changed: {', '.join(changed[:8])}{', ...' if len(changed) > 8 else ''}"],
            help_text,
        )


def _lock(file: BinaryIO, path: Path) -> None:
    """Keep a second sweep from writing into the same journal, where the platform can."""
    try:
        import fcntl
    except ImportError:  # Windows
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise _refused(path, "is in use by another sweep") from error
    except OSError:  # a file system without locks
        return


def _refused(path: Path, what: str, facts: Sequence[str] = (), help: str = "") -> DiagnosticError:
    return DiagnosticError([Diagnostic("FZ909", f"{path} {what}", facts=tuple(facts), help=help, file=str(path))])
