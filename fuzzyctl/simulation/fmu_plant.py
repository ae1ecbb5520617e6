"""Plants that are FMUs: their native code is loaded by FMPy when a loop is run, and stepped from sample to sample."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Callable, Mapping, Sequence
from contextlib import chdir
from importlib import import_module
from pathlib import Path
from typing import Any, Final, final

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.plant import Plant
from fuzzyctl.simulation.fmu_archive import FmuDescription, FmuError, read_description, unpack

#: Most messages of an FMU that are kept to explain an error.
MESSAGES: Final = 3
#: Calls of native code, as messages name them.
CALLS: Final = ("", "begin", "make a step", "give its outputs", "be freed")


@final
class FmuPlant:
    """An FMU for co-simulation as a plant: its inputs are held between two samples.

    Args:
        plant: The plant.
        block: Name of its block in the loop.
        span: Place of the block.
        params: Values of its params, set before the run begins.

    Raises:
        DiagnosticError: For an FMU that cannot be loaded on this machine, and without FMPy.
    """

    def __init__(self, plant: Plant, block: str, span: Span | None, params: Mapping[str, float]) -> None:
        self._plant, self._block, self._span = plant, block, span
        try:
            _fmpy()
            self._fmu = read_description(plant.fmu)
            if missing := self._fmu.missing_binary():
                raise missing
            self._folder = tempfile.mkdtemp(prefix="fuzzyctl-fmu-")
            weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)
            unpack(plant.fmu, Path(self._folder))
        except FmuError as error:
            raise self._mistake(error.message, error.facts, error.help_text) from None
        self._params = {v.reference: params[v.identifier] for v in self._fmu.params if v.identifier in params}
        self._instance: _Instance | None = None
        self._messages: list[str] = []
        #: The call that its native code is in, as its position in `CALLS`, and the time of the last one [s].
        self.state: Any = [0.0, 0.0]
        #: Takes each message besides.
        self.listener: Callable[[str], None] | None = None
        self._broken: DiagnosticError | None = None
        self._sample = -1
        self._values: tuple[float, ...] = ()

    def output(self, t: float, x: tuple[float, ...]) -> Sequence[float]:
        """Return the outputs as they are since the last step; at the time 0 the FMU begins anew."""
        if t == 0.0 and self._sample != 0:
            self.free()
            self._guarded(self._begin, "begin", t)
        if self._broken is not None:
            raise self._broken
        return self._values

    def advance(self, k: int, step: float, inputs: tuple[float, ...]) -> None:
        """Make the communication step from sample `k` to the next one, where a mistake of it is raised."""
        assert self._instance is not None, "outputs are read before a step"
        instance = self._instance
        self._sample = k + 1
        try:
            self._guarded(lambda: instance.step(k * step, step, inputs), "make a step", k * step)
            self._read((k + 1) * step)
        except DiagnosticError as error:
            self._broken = error

    def _begin(self) -> None:
        self._messages.clear()
        self._broken = None
        self._instance = _Instance(self._fmu, self._folder, self._log)
        weakref.finalize(self, self._instance.close)
        self._instance.begin(self._params)
        self._sample = 0
        self._read(0.0)

    def _read(self, t: float) -> None:
        assert self._instance is not None
        instance = self._instance
        values = self._guarded(instance.outputs, "give its outputs", t)
        for variable, value in zip(self._fmu.outputs, values, strict=True):
            if not abs(value) < float("inf"):
                message = f"output '{variable.name}' of FMU '{self._plant.name}' is {value:g} at t = {t:.6g} s"
                raise self._mistake(
                    message, tuple(self._messages), "see that its inputs and params are in their ranges"
                )
        self._values = tuple(values)

    def _guarded(self, call: Any, what: str, t: float) -> Any:
        """Return the result of a call of the FMU; exceptions of FMPy are diagnostics."""
        self.state[1], self.state[0] = t, CALLS.index(what)
        try:
            return call()
        except (DiagnosticError, KeyboardInterrupt):
            raise
        except Exception as error:  # noqa: BLE001 - FMPy raises plain exceptions, which are reported
            message = f"FMU '{self._plant.name}' cannot {what} at t = {t:.6g} s"
            raise self._mistake(message, (str(error), *self._messages), "see what the tool that made it says") from None
        finally:
            self.state[0] = 0

    def _log(self, *arguments: Any) -> None:
        """Keep a message; of FMI 2 the name of the instance comes before the status."""
        text = f"it says: {(arguments[-1] or b'').decode('utf-8', 'replace')}"
        self._messages.append(text)
        del self._messages[:-MESSAGES]
        if self.listener is not None:
            self.listener(text)

    def free(self) -> None:
        """Free the instance; the next run begins with another one."""
        if self._instance is not None:
            instance, self._instance, self._sample = self._instance, None, -1
            self._guarded(instance.close, "be freed", self.state[1])

    def _mistake(self, message: str, facts: tuple[str, ...], help_text: str = "") -> DiagnosticError:
        facts = (*facts, f"it is block '{self._block}', {self._plant.fmu}")
        return DiagnosticError([Diagnostic("FZ711", message, self._span, facts=facts, help=help_text)])


class _Instance:
    """An instance of an FMU in FMPy.

    Args:
        fmu: Its description.
        folder: Where it is unpacked.
        log: Takes its messages.
    """

    def __init__(self, fmu: FmuDescription, folder: str, log: Callable[..., None]) -> None:
        fmpy = _fmpy()
        description = fmpy.read_model_description(folder, validate=False)
        self._fmu, self._open = fmu, False
        with chdir(folder):  # FMPy goes elsewhere to load the library, and stays there where that fails
            make = import_module("fmpy.simulation").instantiate_fmu
            self._own: Any = make(folder, description, fmi_type="CoSimulation", logger=log)
        self._open = True
        self._inputs = [v.reference for v in fmu.inputs]
        self._outputs = [v.reference for v in fmu.outputs]

    def begin(self, params: Mapping[int, float]) -> None:
        """Initialize at the time 0, with some params set."""
        if self._fmu.version == 2:
            self._own.setupExperiment(startTime=0.0)
        self._set(list(params), list(params.values()))
        self._own.enterInitializationMode()
        self._own.exitInitializationMode()

    def step(self, begin: float, size: float, inputs: Sequence[float]) -> None:
        """Set the inputs and make a step."""
        self._set(self._inputs, inputs)
        found = self._own.doStep(currentCommunicationPoint=begin, communicationStepSize=size)
        if self._fmu.version == 3 and found[1]:
            raise RuntimeError("it asks to end the simulation")

    def outputs(self) -> list[float]:
        """Return the outputs."""
        read = self._own.getReal if self._fmu.version == 2 else self._own.getFloat64
        return list(read(self._outputs))

    def _set(self, references: list[int], values: Sequence[float]) -> None:
        if references:
            (self._own.setReal if self._fmu.version == 2 else self._own.setFloat64)(references, values)

    def close(self) -> None:
        """Free the instance and its library."""
        if self._open:
            self._open = False
            self._own.freeInstance()


def _fmpy() -> Any:
    try:
        return import_module("fmpy")
    except ImportError as error:
        message = "FMUs are run by FMPy, which is not installed"
        raise FmuError(message, (str(error),), "pip install 'fuzzyctl[interop]'") from None


def require_fixed(loop: Loop, free: Sequence[str]) -> None:
    """Refuse params of FMUs as free params: they are set before a run.

    Raises:
        ArgumentError: For the first of them.
    """
    fmus = {p.name for p in loop.plants if p.fmu}
    blocks = {i.name for i in loop.instances if i.controller in fmus}
    for name in free:
        if name.partition(".")[0] in blocks:
            raise ArgumentError(f"'{name}' is a param of an FMU, which is set before a run, so it cannot be free")
