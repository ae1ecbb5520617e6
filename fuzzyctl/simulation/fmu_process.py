"""Loops with FMUs in a separate process: a crash of native code ends that process, and is a diagnostic."""

from __future__ import annotations

import mmap
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import weakref
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from queue import SimpleQueue
from threading import Thread
from typing import Any, Final, final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import listed
from fuzzyctl.simulation.fmu_plant import CALLS, MESSAGES, FmuPlant
from fuzzyctl.simulation.runge_kutta import External, external_plant, interpreted
from fuzzyctl.support.cores import interrupts_blocked

#: Most samples of one request, and the time [s] after which a request ends with fewer.
_SAMPLES: Final = 500
_SHARE: Final = 0.05
#: How long a process may take to end by itself [s]; native code that hangs is killed then.
_PATIENCE: Final = 1.0
#: Longest message of an FMU that is passed on, in characters.
_LONGEST: Final = 2_000
#: A process whose loop is gone, for the next loop with the same FMUs.
_idle: list[_Process] = []


class _Process:
    """A process that answers requests, and a folder for its files.

    Args:
        files: The FMUs that it may load.
    """

    def __init__(self, files: tuple[str, ...]) -> None:
        self.files, self.owner, self.folder = files, os.getpid(), Path(tempfile.mkdtemp(prefix="fuzzyctl-fmus-"))
        self.connection, theirs = Pipe()
        code = f"import sys; sys.path[:] = {[*map(str, sys.path)]}; import {__name__} as own; own.serve(sys.argv[1])"
        try:
            with theirs, interrupts_blocked():
                self.own = subprocess.Popen([sys.executable, "-c", code, str(self.folder)], stdin=theirs.fileno())
        except OSError:
            shutil.rmtree(self.folder, ignore_errors=True)
            raise
        #: Ends the process, at the latest with this one.
        self.end = weakref.finalize(self, _end, self.own, self.connection, self.folder, self.owner)

    @property
    def usable(self) -> bool:
        """Whether it can take a request of this process, which may be a fork of the one that started it."""
        return self.end.alive and self.owner == os.getpid()


def _end(process: subprocess.Popen[bytes], connection: Connection, folder: Path, owner: int) -> None:
    if os.getpid() != owner:
        return
    connection.close()
    try:
        process.wait(_PATIENCE)
    except subprocess.TimeoutExpired:
        pass
    finally:
        process.kill()
        process.wait()
        shutil.rmtree(folder, ignore_errors=True)


def _put_back(process: _Process) -> None:
    """Keep one process; the one that was kept before ends."""
    if process.usable:
        _idle.append(process)
        for other in _idle[:-1]:
            _idle.remove(other)
            other.end()


@final
class IsolatedKernel:
    """The function of a run in another process, which is called as the one of this process is.

    It may return after fewer samples than it should record: `done` counts them.

    Args:
        text: Its text.
        tables: The tables that the text reads.
        externals: The plants that are called.
        width: Numbers in the record of a sample.

    Attributes:
        done: How many samples of the run are recorded.
    """

    def __init__(self, text: str, tables: Mapping[str, Any], externals: Sequence[External], width: int) -> None:
        self._loaded = text, tables, externals, width
        self._plants, self._width = [(e[0], e[1], e[2]) for e in externals], width
        self._files = tuple(sorted({e[0].fmu for e in externals if e[0].fmu}))
        self._process: _Process | None = None
        self._crash: DiagnosticError | None = None
        self.done = 0

    def start(self) -> None:
        """Begin a run: start the process unless it runs.

        Raises:
            DiagnosticError: For a process that cannot be started, and for plants that cannot be used.
        """
        self.done, self._crash = 0, None
        if self._process is not None and self._process.usable:
            return
        idle = next((p for p in _idle if p.usable and p.files == self._files and p.own.poll() is None), None)
        if idle is not None:
            _idle.remove(idle)
        try:
            process = idle or _Process(self._files)
            path = process.folder / "record"
            path.unlink(missing_ok=True)  # the one of the loop before is still mapped
            path.write_bytes(bytes(8 * (1 + 2 * len(self._plants) + _SAMPLES * self._width)))
        except OSError as error:
            raise self._mistake("the process for FMUs cannot be started", (str(error),)) from None
        self._process = process
        self._sent: Sequence[Any] = ()
        weakref.finalize(self, _put_back, process)
        #: How many samples of a request are done; `FmuPlant.state` of each plant; the record of the samples.
        self._shared = _mapped(path)
        self._record = self._shared[1 + 2 * len(self._plants) :]
        self._request("load", *self._loaded, str(path), os.getcwd())

    def __call__(
        self, first: int, count: int, total: int, substeps: int, h: float, x: Any, c: Any, free: Any, given: Any,
        record: Any, *lags: Any,
    ) -> int:  # fmt: skip
        """Record samples, see `RunSource.lines`; exceptions of the other process are raised here."""
        if first == 0:
            self.start()
        if self._process is None or not self._process.usable:
            raise self._crash or self._mistake("the process of a loop with FMUs is not there any more", ())
        buffers = (given, *lags)  # which the process keeps, as it writes into these
        new = len(self._sent) != len(buffers) or any(a is not b for a, b in zip(self._sent, buffers, strict=True))
        numbers = (first, min(count, _SAMPLES), total, substeps, h)
        self._sent = buffers
        self._shared[0] = 0.0
        try:
            code, x[:], c[:] = self._request("samples", *numbers, x, c, free, buffers if new else None)
        finally:
            samples = int(self._shared[0])
            record[: samples * self._width] = self._record[: samples * self._width]
            self.done = first + samples
        return int(code)

    def free(self) -> Diagnostic | None:
        """Free the instances of a run that is over; return why that ended the process."""
        if self._process is not None:
            try:
                self._request("free")
            except DiagnosticError as error:
                return error.diagnostics[0]
        return None

    def _request(self, *request: Any) -> Any:
        """Return the answer to a request: the name of a method of `_Server`, and its arguments."""
        assert self._process is not None
        messages: list[tuple[int, str]] = []
        kind = ""
        answer: Any = None
        try:
            self._process.connection.send(request)
            while kind not in ("done", "mistakes", "raised"):
                kind, answer = self._process.connection.recv()
                messages += [answer] if kind == "says" else []
        except (EOFError, OSError):
            self._crash = self._crashed(messages)
            raise self._crash from None
        except BaseException:  # its answer would be that to the next request
            self._process.end()
            self._process = None
            raise
        if kind == "mistakes":
            raise DiagnosticError(answer)
        if kind == "raised":
            raise answer
        return answer

    def _crashed(self, messages: Sequence[tuple[int, str]]) -> DiagnosticError:
        """Return the diagnostic of the process that has ended, and count samples that are recorded."""
        assert self._process is not None
        self._process.end()
        code, self._process = self._process.own.returncode, None
        how = f"it was ended by {signal.Signals(-code).name}: {signal.strsignal(-code)}" if code < 0 else ""
        how = how or f"it ended its process with exit code {code}"
        states = [self._shared[k : k + 2].tolist() for k in range(1, 1 + 2 * len(self._plants), 2)]
        position = next((k for k, state in enumerate(states) if state[0]), None)
        if position is None:
            return self._mistake("the process of a loop with FMUs ended", (how, f"it ran {listed(self._files)}"))
        call, t = CALLS[int(states[position][0])], states[position][1]
        if call == "make a step" or (call == "give its outputs" and t):
            self._shared[0] += 1.0
        plant, block, span = self._plants[position]
        texts = [text for k, text in messages if k == position][-MESSAGES:]
        message = f"FMU '{plant.name}' crashed when it had to {call} at t = {t:.6g} s"
        help_text = "its native code is wrong, or its inputs and params are not in their ranges: ask who made it"
        return self._mistake(message, (how, *texts, f"it is block '{block}', {plant.fmu}"), help_text, span)

    def _mistake(
        self, message: str, facts: tuple[str, ...], help_text: str = "", span: Span | None = None
    ) -> DiagnosticError:
        span = span or next((span for plant, _, span in self._plants if plant.fmu), None)
        return DiagnosticError([Diagnostic("FZ713", message, span, facts=facts, help=help_text)])


def _mapped(path: Path) -> Any:
    """Return the numbers of a file that both processes see, as a memoryview of floats."""
    with path.open("r+b") as file:
        return memoryview(mmap.mmap(file.fileno(), 0)).cast("d")


class _Server:
    """The loop that the other process has."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._plants: list[Any] = []
        self._kept: Sequence[Any] = ()

    def load(
        self, text: str, tables: Mapping[str, Any], externals: Sequence[External], width: int, path: str, place: str
    ) -> None:
        """Take a loop in the place of the one before."""
        self.free()
        os.chdir(place)
        self._plants = [external_plant(*e) for e in externals]
        self._shared, self._width, begin = _mapped(Path(path)), width, 1 + 2 * len(externals)
        self._record = self._shared[begin:]
        for k, plant in enumerate(self._plants):
            if isinstance(plant, FmuPlant):
                plant.state, plant.listener = self._shared[1 + 2 * k : 3 + 2 * k], self._listener(k)
        self._kernel = interpreted(text, tables, self._plants)

    def _listener(self, position: int) -> Callable[[str], None]:
        def listen(text: str) -> None:
            with suppress(OSError):
                self._connection.send(("says", (position, text[:_LONGEST])))

        return listen

    def samples(
        self, first: int, count: int, total: int, substeps: int, h: float, x: Any, c: Any, free: Any, kept: Any
    ) -> tuple[int, Any, Any]:
        """Record samples one by one, and return the code of the kernel and the states."""
        self._kept = kept or self._kept
        columns, *lags = self._kept
        end, code = time.perf_counter() + _SHARE, -1
        for k in range(count):
            record = self._record[self._width * k : self._width * (k + 1)]
            code = self._kernel(first + k, 1, total, substeps, h, x, c, free, columns, record, *lags)
            self._shared[0] = k + 1
            if code >= 0 or time.perf_counter() > end:
                break
        return code, x, c

    def free(self) -> None:
        """Free the instances of FMUs."""
        for plant in self._plants:
            if isinstance(plant, FmuPlant):
                plant.free()


def serve(folder: str) -> None:
    """Answer the requests that come by the standard input, until its other end is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    tempfile.tempdir = folder
    connection = Connection(os.dup(0))
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)  # native code may read it
    requests: SimpleQueue[Any] = SimpleQueue()
    Thread(target=_receive, args=(connection, requests, folder), daemon=True).start()
    server = _Server(connection)
    while (request := requests.get()) is not None:
        try:
            answer = "done", getattr(server, request[0])(*request[1:])
        except DiagnosticError as error:
            answer = "mistakes", error.diagnostics
        except Exception as error:  # noqa: BLE001 - it is raised where the request came from
            answer = "raised", error
        sys.stdout.flush()
        try:
            connection.send(answer)
        except OSError:  # the parent has ended
            break
    with suppress(DiagnosticError):
        server.free()
    shutil.rmtree(folder, ignore_errors=True)


def _receive(connection: Connection, requests: SimpleQueue[Any], folder: str) -> None:
    """Pass on requests; end the process with the one that sends them, also if native code hangs."""
    try:
        while True:
            requests.put(connection.recv())
    except (EOFError, OSError):
        requests.put(None)
    time.sleep(2.0 * _PATIENCE)
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)
