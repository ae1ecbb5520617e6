"""FMUs of texts, and instances of them in FMPy."""

import shutil

import numpy as np
import pytest

from fuzzyctl import loads
from fuzzyctl.codegen.fmu.archive import compiler, fmu
from fuzzyctl.codegen.fmu.calls import block_model, tunable
from fuzzyctl.codegen.fmu.plants import plant_model
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import look_through
from tests.fuzzyctl.codegen.steps.targets import controller_of


def controller_fmu(text, free=None, **options):
    controller = controller_of(text)
    free = tunable(controller) if free is None else free
    return block_model(prepare(controller, text, small=True, free=free, **options))


def system_fmu(text, **options):
    return block_model(prepare(loads(text), text, small=True, **options))


def plant_fmu(text, name="p", **options):
    examined = look_through(SourceText("p.fz", text))
    assert [d.message for d in examined.diagnostics if d.severity == "error"] == []
    return plant_model(next(p for p in examined.plants if p.name == name), text, **options)


class Built:
    """An FMU on disk."""

    def __init__(self, model, version, folder):
        fmpy = pytest.importorskip("fmpy")
        if compiler() is None:
            pytest.skip("there is no C compiler")
        self.model, self.version = model, version
        self.path = folder / f"{model.name}{version}.fmu"
        made = fmu(model, version)
        assert made.missing == ""
        folder.mkdir()
        self.path.write_bytes(made.data)
        self.description = fmpy.read_model_description(str(self.path))
        self.folder = fmpy.extract(str(self.path))
        self.messages = []
        self._instances = []

    def instance(self, start=0.0, begin=True, **values):
        from fmpy.simulation import instantiate_fmu

        own = instantiate_fmu(self.folder, self.description, fmi_type="CoSimulation", logger=self._log)
        instance = Instance(self, own)
        self._instances.append(instance)
        if self.version == 2:
            own.setupExperiment(startTime=start)
        if begin:
            instance.initialize(start, **values)
        return instance

    def _log(self, *arguments):
        """Keep a message: of FMI 2 the name of the instance comes before the status."""
        self.messages.append((arguments[-2].decode(), arguments[-1].decode()))

    def free(self):
        """Free the instances, and forget what they said."""
        for instance in self._instances:
            instance.own.freeInstance()
        self._instances.clear()
        self.messages.clear()

    def forget(self, instance):
        """Free one instance."""
        instance.own.freeInstance()
        self._instances.remove(instance)

    def remove(self):
        shutil.rmtree(self.folder, ignore_errors=True)


class Instance:
    """An instance, with its variables by name."""

    def __init__(self, built, own):
        self.own, self._built = own, built
        self.references = {v.name: v.valueReference for v in built.description.modelVariables}
        self.time = None

    def initialize(self, start=0.0, **values):
        if self._built.version == 3:
            self.own.enterInitializationMode(startTime=start)
        else:
            self.own.enterInitializationMode()
        self.set(**values)
        self.own.exitInitializationMode()
        self.time = start

    def set(self, **values):
        if values:
            set_ = self.own.setReal if self._built.version == 2 else self.own.setFloat64
            set_([self.references[n] for n in values], [*values.values()])

    def get(self, *names):
        get = self.own.getReal if self._built.version == 2 else self.own.getFloat64
        return get([self.references[n] for n in names])

    def step(self, size, **values):
        """Return the outputs after a communication step."""
        self.set(**values)
        self.own.doStep(currentCommunicationPoint=self.time, communicationStepSize=size)
        self.time += size
        return self.get(*(v.name for v in self._built.model.outputs))

    def steps(self, rows, size):
        """Return the outputs after steps with rows of inputs, shape (steps, outputs); the last column may be dt."""
        names = [v.name for v in self._built.model.inputs]
        times = [size] * len(rows) if size is not None else rows[:, -1].tolist()
        return np.array(
            [self.step(dt, **dict(zip(names, row, strict=False))) for row, dt in zip(rows.tolist(), times, strict=True)]
        )
