"""Files of a sweep of loops: its SPEC, and rule files, read once, with the values that a run gives their params."""

from __future__ import annotations

import dataclasses
import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import Field, Strict

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.diagnostics.suggestions import closest, did_you_mean
from fuzzyctl.experiments import sweep_spec
from fuzzyctl.experiments.scenario_keys import OverrideError, join_key, override, shorten, split_key
from fuzzyctl.experiments.sweep_spec import Spec, SpecFile, show
from fuzzyctl.loading.load import look_through
from fuzzyctl.model.block import Param
from fuzzyctl.model.loop import Loop, Measure
from fuzzyctl.simulation.loop_params import all_settable, short_names, within_ranges
from fuzzyctl.support.files import files_in, place_of, read_source, recorded

#: Key of the number by which a run draws its noise anew.
SEED: Final = "noise.seed"
#: Columns that the results of each sweep have.
COLUMNS: Final = ("run", "scenario", "controller", "repetition", "t_end", "stopped", "stop_reason")


@dataclass(frozen=True)
class LoopFiles:
    """The loops of some files, and everything that was read for them.

    Args:
        path: The first file.
        loops: By label: their names, with the file before it where two files have one of the same name.
        read: Content of each file that was read, by its path.
        own: How many of them are the files themselves, which come first.
        warnings: Warnings about the files.
    """

    path: Path
    loops: Mapping[str, Loop]
    read: Mapping[str, bytes] = field(repr=False)
    own: int = 1
    warnings: tuple[Diagnostic, ...] = ()

    @cached_property
    def params(self) -> dict[str, dict[str, float]]:
        """The values of all params of each loop, by its label and their full names."""
        return {label: all_settable(loop) for label, loop in self.loops.items()}

    @cached_property
    def names(self) -> dict[str, str]:
        """The full names of all params of all loops by the names that they may be given by."""
        measures = {m.name for loop in self.loops.values() for m in loop.measures}
        full_names = {name: full for loop in self.loops.values() for name, full in short_names(loop).items()}
        full_names |= {name: name for values in self.params.values() for name in values}
        return {name: full for name, full in full_names.items() if name == full or name not in measures}


@dataclass(frozen=True)
class LoopScenario:
    """Loops with values of their params.

    Args:
        files: Where they come from.
        values: Those that are set, by full name.
        seed: By which noise is drawn anew, None for the draws of the files.
    """

    files: LoopFiles
    values: Mapping[str, float]
    seed: int | None = None

    @property
    def name(self) -> str:
        """Name in the results."""
        return self.path.stem

    @property
    def path(self) -> Path:
        """The first file."""
        return self.files.path

    @property
    def warnings(self) -> Sequence[Diagnostic]:
        """Warnings about the files."""
        return self.files.warnings

    @property
    def sha256(self) -> str:
        """Checksum of all files that were read."""
        return hashlib.sha256(b"".join(self.files.read.values())).hexdigest()

    @property
    def texts(self) -> list[dict[str, str]]:
        """Name and text of each file with loops."""
        files = list(self.files.read.items())[: self.files.own]
        return [{"file": Path(name).name, "text": content.decode(errors="replace")} for name, content in files]

    @property
    def settings(self) -> dict[str, Any]:
        """Values of the params by key, as tables for those of blocks; without params that differ between loops."""
        numbers_of: dict[str, set[float]] = {}
        for values in self.files.params.values():
            for name, full in self.files.names.items():
                if full in values:
                    numbers_of.setdefault(name, set()).add(self.values.get(full, values[full]))
        tables: dict[str, Any] = {}
        for name, numbers in numbers_of.items():
            *blocks, short = name.split(".")
            table: Any = tables
            for block in blocks:
                table = table.setdefault(block, {}) if isinstance(table, dict) else None
            if len(numbers) == 1 and isinstance(table, dict):
                table.setdefault(short, *numbers)
        return tables

    def of(self, label: str) -> dict[str, float]:
        """Return the values that are params of a loop."""
        params = self.files.params[label]
        return {name: value for name, value in self.values.items() if name in params}


def read_files(path: Path, against: Sequence[Path]) -> LoopFiles:
    """Read the loops of some files.

    Raises:
        DiagnosticError: With all errors of the first file that has any; for a file without loops.
    """
    loops_read: list[tuple[Path, Loop]] = []
    warnings: list[Diagnostic] = []
    with recorded() as read:
        sources = [(one, read_source(one)) for one in (path, *against)]
        for one, source in sources:
            examined = look_through(source, folder=one.parent)
            reported = examined.reported(examined.diagnostics)
            if any(d.severity == "error" for d in reported):
                raise DiagnosticError(reported)
            if not examined.loops:
                help_text = "a sweep runs loops: 'loop' joins controllers and plants"
                raise DiagnosticError([Diagnostic("FZ502", "the file holds no loop", file=str(one), help=help_text)])
            warnings += reported
            loops_read += [(one, loop) for loop in examined.loops]
    _require_columns([loop for _, loop in loops_read])
    names = [loop.name for _, loop in loops_read]
    loops = {loop.name if names.count(loop.name) == 1 else f"{one.stem}.{loop.name}": loop for one, loop in loops_read}
    if len(loops) < len(loops_read):
        raise DiagnosticError(list(_same_labels(loops_read)))
    return LoopFiles(path, loops, read, len(dict.fromkeys(str(one) for one, _ in sources)), tuple(warnings))


def _same_labels(found: Sequence[tuple[Path, Loop]]) -> Iterator[Diagnostic]:
    """Report loops of one name in files of one name, which the results cannot tell apart."""
    files: dict[tuple[str, str], list[Path]] = {}
    for path, loop in found:
        files.setdefault((path.stem, loop.name), []).append(path)
    for (_, name), paths in files.items():
        if len(paths) > 1:
            facts = tuple(f"it is in {path}" for path in paths)
            same = len({path.resolve() for path in paths}) == 1
            help_text = "name the file once" if same else "rename a loop or a file: the results need a name for each"
            yield Diagnostic("FZ502", f"loop '{name}' is there {len(paths)} times", facts=facts, help=help_text)


def _require_columns(loops: Sequence[Loop]) -> None:
    """Refuse measures and params of loops that have the name of a column of the results."""
    named: list[Measure | Param] = []
    for loop in loops:
        named += [*loop.measures, *loop.params]
    clashes = [one for one in named if one.name in COLUMNS]
    if clashes:
        help_text = "rename it: the results have a column of this name for each run"
        raise DiagnosticError([Diagnostic("FZ904", f"'{m.name}' is taken", m.span, help=help_text) for m in clashes])


def with_overrides(files: LoopFiles, overrides: Sequence[str]) -> LoopScenario:
    """Set params of loops by arguments `key=value`; each is a param of one loop at least.

    Raises:
        DiagnosticError: With every mistake.
        OverrideError: When an override is malformed.
    """
    names, arguments = files.names, dict[str, str]()
    values: dict[str, float] = {}
    seed: int | None = None
    mistakes: list[Diagnostic] = []
    for argument in overrides:
        table: dict[str, Any] = {}
        key, written = override(table, argument)
        value = _value(table, key)
        full = names.get(key, key)
        if full in arguments:
            raise OverrideError(f"--set {shorten(argument)}: {full} is given twice")
        arguments[full] = written
        if full == SEED and SEED not in names:
            seed, wrong = _seed(value)
        else:
            wrong = list(_mistakes(files, key, full, value))
            values |= {} if wrong else {full: float(value)}
        mistakes += [dataclasses.replace(d, span=None, file=f"--set {written}") for d in wrong]
    if mistakes:
        raise DiagnosticError(mistakes)
    return LoopScenario(files, values, seed)


def _value(table: Any, key: str) -> Any:
    for part in split_key(key):
        table = table[part]
    return table


def _seed(value: Any) -> tuple[int | None, list[Diagnostic]]:
    if type(value) is int and value >= 0:
        return value, []
    return None, [Diagnostic("FZ904", f"{SEED} must be a whole number >= 0, got {show(value)}")]


def _mistakes(files: LoopFiles, key: str, full: str, value: Any) -> Iterator[Diagnostic]:
    """Yield the mistakes in the value of a param."""
    names = files.names
    if key not in names:
        facts = (f"params: {', '.join(dict.fromkeys(names.values())) or 'none'}",)
        yield Diagnostic("FZ902", f"unknown param {key}", facts=facts, help=did_you_mean(key, [*names, SEED]))
    elif isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        yield Diagnostic("FZ904", f"{join_key(split_key(key))} must be a finite number, got {show(value)}")
    else:
        loop = next(loop for label, loop in files.loops.items() if full in files.params[label])
        try:
            within_ranges(loop, {full: float(value)})
        except DiagnosticError as error:
            yield from (dataclasses.replace(d, facts=(*d.facts, f"declared at {d.place}")) for d in error.diagnostics)


class LoopSpec(Spec):
    """Content of a SPEC file: `scenario` is a file with loops or a shipped name, `controllers` names some of them."""

    against: Annotated[tuple[str, ...], Strict(False)] = Field(
        default=(), description="further files beside the SPEC, or shipped ones, whose loops are run too"
    )
    members: int = Field(
        default=0, ge=0, le=1_000_000, description="members of the family of the loops that are run, as --for has them"
    )

    @property
    def draws(self) -> int:
        """How many members of the family are run."""
        return max(self.members, 1)


def read(path: Path) -> SpecFile:
    """Read a SPEC file.

    Raises:
        DiagnosticError: With every mistake in it.
    """
    return sweep_spec.read(path, LoopSpec)


def with_members(file: SpecFile, count: int) -> SpecFile:
    """Return a SPEC that runs a number of members of the family of its loops."""
    return dataclasses.replace(file, spec=file.spec.model_copy(update={"members": count}))


def spec_of_family(path: Path, count: int) -> SpecFile:
    """Return a SPEC that runs a number of members of the family of the loops of a rule file."""
    return SpecFile(LoopSpec(scenario=path.name, members=count), SourceText(path.name, ""), path)


def against(file: SpecFile) -> tuple[Path, ...]:
    """Return the further files of a SPEC.

    Raises:
        DiagnosticError: With each that is not there.
    """
    names = file.spec.against if isinstance(file.spec, LoopSpec) else ()
    mistakes = []
    beside = [file.path.parent / name for name in names]
    paths = [place_of(name, folder=file.path.parent).path for name in names]
    for path, there in zip(beside, paths, strict=True):
        if not there.exists():
            near = closest(path.name, files_in(path.parent, {path.suffix}))
            help_text = f"did you mean '{near}'?" if near else ""
            message = f"against: no file '{path.name}': there is no such file"
            mistakes.append(file.diagnostic("FZ904", ("against",), message, help=help_text))
    if mistakes:
        raise DiagnosticError(mistakes)
    return tuple(paths)
