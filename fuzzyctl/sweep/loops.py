"""Loops as the `Runnable` of sweeps."""

from __future__ import annotations

import hashlib
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, UnknownNameError
from fuzzyctl.experiments.runnable import Computed, Prepared, Runnable, UsedFile
from fuzzyctl.expr import Compare, Name, walk
from fuzzyctl.model.instance_params import with_instance_params
from fuzzyctl.model.loop import Loop
from fuzzyctl.simulation.columns import columns
from fuzzyctl.simulation.expansion import loop_equations
from fuzzyctl.simulation.experiment import Experiment
from fuzzyctl.simulation.loop_params import blocks_of, with_settings
from fuzzyctl.simulation.members import can_be_free, members
from fuzzyctl.simulation.run import Run
from fuzzyctl.simulation.signals import Noise, Table
from fuzzyctl.support.files import place_of
from fuzzyctl.sweep.loop_files import SEED, LoopFiles, LoopScenario, read_files, with_overrides


@dataclass
class Known:
    """Files and loops that a process has read and compiled."""

    files: dict[Path, LoopFiles] = field(default_factory=dict)
    free: dict[tuple[str, tuple[str, ...]], set[str]] = field(default_factory=dict)
    experiments: dict[str, tuple[Any, Experiment]] = field(default_factory=dict)
    checked: set[tuple[Any, ...]] = field(default_factory=set)


@dataclass(frozen=True)
class Loops(Runnable[LoopScenario]):
    """Loops of rule files; each counts as a controller.

    Args:
        against: Files whose loops are run besides those of the scenario.
        known: Cache of this process.
    """

    seed = SEED
    package = Path(__file__).parents[1]

    against: tuple[Path, ...] = ()
    known: Known = field(default_factory=Known, compare=False, repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        """Leave out the cache of this process."""
        return type(self), (self.against,)

    def find(self, name: str, folder: Path = Path()) -> Path:
        """Return a file by its path, or by its name: that of the folder of the SPEC, else the shipped one."""
        path = place_of(name, folder=folder).path
        return path if path.is_file() else super().find(name)

    def read(self, path: Path, overrides: Sequence[str]) -> LoopScenario:
        """Read the files, once in each process, and set params of their loops."""
        if path not in self.known.files:
            self.known.files[path] = read_files(path, self.against)
        return with_overrides(self.known.files[path], overrides)

    def controllers(self, scenario: LoopScenario, names: Sequence[str]) -> tuple[str, ...]:
        """Return the labels of loops; without names those of all."""
        for name in names:
            if name not in scenario.files.loops:
                raise UnknownNameError("loop", name, tuple(scenario.files.loops))
        return tuple(names) or tuple(scenario.files.loops)

    def measures(self, scenario: LoopScenario, controllers: Sequence[str]) -> tuple[str, ...]:
        """Return the measures of some loops."""
        return tuple(dict.fromkeys(m.name for label in controllers for m in scenario.files.loops[label].measures))

    def members(self, scenario: LoopScenario, controllers: Sequence[str], spec: Any) -> Sequence[Mapping[str, float]]:
        """Return members of the family of the loops, corners first; loops without a family take those of the others."""
        if not getattr(spec, "members", 0):
            return ({},)
        loops = [with_settings(scenario.files.loops[label], scenario.of(label)) for label in controllers]
        families = [loop for loop in loops if loop.family]
        if not families:
            help_text = "add a 'for' or a 'disturbance' line to a loop"
            raise DiagnosticError([Diagnostic("FZ904", "no loop has a family to draw from", help=help_text)])
        other = next((loop for loop in families if loop.family != families[0].family), None)
        if other is not None:
            message = f"loops '{families[0].name}' and '{other.name}' have different families"
            help_text = "give them the same 'for' and 'disturbance' lines, or name one loop with 'controllers'"
            raise DiagnosticError([Diagnostic("FZ904", message, other.span, help=help_text)])
        return members(families[0], spec.members, spec.seed)

    def check(self, scenario: LoopScenario, controllers: Sequence[str]) -> Mapping[str, UsedFile]:
        """Expand the loops, once for all values of free params, and read their tables."""
        for label in controllers:
            fixed = self._split(scenario, label)[1]
            if (label, *fixed.items()) in self.known.checked:
                continue
            loop = with_settings(scenario.files.loops[label], fixed)
            equations = loop_equations(loop)
            tables = [one for one in equations.given.values() if isinstance(one, Table)]
            columns(tables, np.arange(equations.samples, dtype=np.float64) * equations.step, Path(loop.path).parent)
            self.known.checked.add((label, *fixed.items()))
        return self._used(scenario)

    def unread(
        self, scenario: LoopScenario, controllers: Sequence[str], used: Mapping[str, str], key: Sequence[str]
    ) -> str:
        """Return the param that the loops lack, or the seed if the loops have no noise."""
        name = ".".join(key)
        full = scenario.files.names.get(name, name)
        is_param = any(full in scenario.files.params[label] for label in controllers)
        if full == SEED and not is_param:
            loops = [scenario.files.loops[label] for label in controllers]
            columns = [one for loop in loops for one in loop_equations(loop).given.values()]
            return "" if any(isinstance(one, Noise) for one in columns) else "a seed of noise"
        return "" if "*" in key or is_param else f"param {full}"

    def prepare(self, scenario: LoopScenario, controller: str, measures: Sequence[str]) -> Prepared:
        """Compile a loop, once for all values of the params that are set."""
        experiment, values = self._experiment(scenario, controller)

        def compute() -> Computed:
            began = time.perf_counter()
            run = experiment.run(values, seed=scenario.seed)
            return Computed(dict(_row(run, measures)), time.perf_counter() - began)

        return Prepared(self._used(scenario, again=True), compute)

    def is_better_large(self, scenario: LoopScenario, controller: str, measure: str) -> bool:
        """Return whether a requirement asks for a large value of a measure."""
        claims = (node for g in scenario.files.loops[controller].requirements for node in walk(g.claim))
        ordered = [c for c in claims if isinstance(c, Compare) and c.op not in ("==", "!=")]
        return any((c.left if c.op in (">", ">=") else c.right) == Name(measure) for c in ordered)

    def unit(self, scenario: LoopScenario, column: str) -> str:
        """Return the unit of a measure or of a param."""
        if column == "t_end":
            return "s"
        loops = scenario.files.loops.values()
        units = [m.unit for loop in loops for m in loop.measures if m.name == column]
        full = scenario.files.names.get(column, column)
        return next(iter([*units, *(unit for loop in loops for name, unit in _param_units(loop) if name == full)]), "")

    def _experiment(self, scenario: LoopScenario, label: str) -> tuple[Experiment, list[float]]:
        """Return a compiled loop, and the values of its free params."""
        free, fixed = self._split(scenario, label)
        key, experiment = self.known.experiments.get(label, (None, None))
        if experiment is None or key != (tuple(free), fixed):
            experiment = Experiment(with_settings(scenario.files.loops[label], fixed), free=tuple(free))
            self.known.experiments[label] = ((tuple(free), fixed), experiment)
        return experiment, list(free.values())

    def _split(self, scenario: LoopScenario, label: str) -> tuple[dict[str, float], dict[str, float]]:
        """Return the values that are arguments of a compiled loop, and those that it has as constants."""
        loop = scenario.files.loops[label]
        values = scenario.of(label)
        chosen = (label, tuple(values))
        if chosen not in self.known.free:
            self.known.free[chosen] = {name for name in values if can_be_free(loop, name)}
        free = {name: value for name, value in values.items() if name in self.known.free[chosen]}
        return free, {name: value for name, value in values.items() if name not in free}

    def _used(self, scenario: LoopScenario, again: bool = False) -> dict[str, UsedFile]:
        """Return the files that those with loops use: tables, plants in Python, FMUs; `again` reads them anew."""
        others = list(scenario.files.read.items())[scenario.files.own :]
        files = {}
        for name, content in others:
            path = Path(name)
            content = path.read_bytes() if again and path.exists() else content
            relative = path.relative_to(scenario.path.parent) if path.is_relative_to(scenario.path.parent) else path
            files[relative.as_posix()] = UsedFile(path, hashlib.sha256(content).hexdigest())
        return files


def _param_units(loop: Loop) -> Iterator[tuple[str, str]]:
    """Yield the full names of the params of a loop and of its blocks, with their units."""
    loop = with_instance_params(loop, loop.instance_params)
    yield from ((p.name, p.unit) for p in loop.params)
    for instance in loop.instances:
        yield from ((f"{instance.name}.{p.name}", p.unit) for p in blocks_of(loop)[instance.controller].params)


def _row(run: Run, wanted: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """Yield how a run ended, its measures, and which requirements it meets."""
    yield "t_end", float(run.t[-1]) if len(run) else 0.0
    yield "stopped", run.stopped is not None
    yield "stop_reason", None if run.stopped is None else run.stopped.message.partition(" at t = ")[0]
    for name, value in run.measures.items():
        if not wanted or name in wanted:
            yield name, None if run.stopped is not None or math.isnan(value) else value
    yield from ((f"require {one.text}", one.holds) for one in run.requirements)
