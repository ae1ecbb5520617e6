"""FMUs that `fuzzyctl codegen` writes, and instances of them in FMPy."""

import shutil
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest

from fuzzyctl.testing import run_command

#: What compiles the sources of an FMU into the library of its name.
COMPILE = "cc -std=c99 -O1 -ffp-contract=off -fvisibility=hidden -shared -fPIC -o".split()


def write_fmu(text, path, *options, version=3):
    """Write the last controller, system or plant of a text as an FMU, and return its path."""
    if shutil.which("cc") is None:
        pytest.skip("there is no C compiler")
    path.parent.mkdir(parents=True, exist_ok=True)
    source = path.with_suffix(".fz")
    source.write_text(text, encoding="utf-8")
    run = run_command("codegen", source, "--target", "fmu", "--fmi", version, "-o", path, "-q", *options)
    source.unlink()
    assert run.exit_code == 0, f"{run.output}{run.errors}"
    return path


def changed(path, change, *, compile_again=False):
    """Replace an FMU by one whose files a function changed; None drops a file.

    Args:
        path: The FMU.
        change: A function of the name and the bytes of a file.
        compile_again: Whether the library is compiled from the changed sources.
    """
    with zipfile.ZipFile(path) as archive:
        files = {name: change(name, archive.read(name)) for name in archive.namelist()}
    if compile_again:
        folder = path.parent / "sources"
        folder.mkdir(exist_ok=True)
        sources = {Path(n).name: c for n, c in files.items() if n.startswith("sources/") and not n.endswith(".xml")}
        for name, content in sources.items():
            (folder / name).write_bytes(content)
        subprocess.run([*COMPILE, "l.so", *(n for n in sources if n.endswith(".c")), "-lm"], cwd=folder, check=True)
        files[next(n for n in files if n.startswith("binaries/"))] = (folder / "l.so").read_bytes()
        shutil.rmtree(folder)
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in files.items():
            if content is not None:
                archive.writestr(name, content)
    return path


class Built:
    """An FMU on disk."""

    def __init__(self, text, version, folder, *options):
        fmpy = pytest.importorskip("fmpy")
        self.version = version
        self.path = write_fmu(text, folder / "own.fmu", *options, version=version)
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
        return self.get(*self.named("output"))

    def named(self, causality):
        """Return the names of the inputs or outputs."""
        return [v.name for v in self._built.description.modelVariables if v.causality == causality]

    def steps(self, rows, size):
        """Return the outputs after steps with rows of inputs, shape (steps, outputs); the last column may be dt."""
        names = self.named("input")
        times = [size] * len(rows) if size is not None else rows[:, -1].tolist()
        return np.array(
            [self.step(dt, **dict(zip(names, row, strict=False))) for row, dt in zip(rows.tolist(), times, strict=True)]
        )
