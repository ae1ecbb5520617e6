"""Model of an FMU: its variables, and the C that evaluates them."""

from __future__ import annotations

import hashlib
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final

from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.expr import evaluate
from fuzzyctl.model.block import Bounds

#: Communication step that is proposed where there is no period [s].
USUAL_STEP: Final = 0.01


@dataclass(frozen=True)
class Variable:
    """A real variable of an FMU.

    Args:
        name: As the rule file has it.
        start: Its value before the first step; that of outputs is computed.
        lower: The lower end of its range, -inf for none.
        upper: The upper end.
        unit: Its unit.
        label: A label for people.
    """

    name: str
    start: float = 0.0
    lower: float = -math.inf
    upper: float = math.inf
    unit: str = ""
    label: str = ""


@dataclass(frozen=True)
class Model:
    """A system, controller or plant as an FMU has it. References of variables count from 1; 0 is the time.

    Args:
        name: C identifier: the name of its files and of the binary.
        block: The name in the rule file.
        title: A title for people.
        about: The head of its C, line by line.
        inputs: In the order of declaration.
        outputs: In the order of declaration.
        params: Those that an importer may set, at any time.
        constants: The other params.
        sources: Its C files by name, without those that all FMUs share.
        memory: The member of the model that holds its state, in C; an empty string for none.
        begin: Lines of C that begin this memory.
        make: Lines of C that make a step of `dt` seconds, and return NULL, or the reason of a failure.
        preview: The `dt` of the outputs before the first step.
        period: The sample time [s], None where each communication step is a step.
        helpers: C that `make` calls, line by line.
        shared: Files beside those of all FMUs that its C includes.
    """

    name: str
    block: str
    title: str
    about: Sequence[str]
    inputs: Sequence[Variable]
    outputs: Sequence[Variable]
    params: Sequence[Variable]
    constants: Sequence[Variable]
    sources: Mapping[str, str] = field(hash=False)
    memory: str
    begin: Sequence[str]
    make: Sequence[str]
    preview: float
    period: float | None = None
    helpers: Sequence[str] = ()
    shared: Sequence[str] = ()

    def __post_init__(self) -> None:
        if self.name.lower().startswith(("fmi", "fmu")):
            message = f"'{self.block}' begins as names of the standard, which its C would define again; rename it"
            raise CodegenError(message)

    @property
    def variables(self) -> tuple[Variable, ...]:
        """All variables but the time, in the order of their references."""
        return (*self.inputs, *self.outputs, *self.params, *self.constants)

    @property
    def first_output(self) -> int:
        """Reference of the first output."""
        return 1 + len(self.inputs)

    @property
    def first_param(self) -> int:
        """Reference of the first param."""
        return self.first_output + len(self.outputs)

    @property
    def first_constant(self) -> int:
        """Reference of the first constant."""
        return self.first_param + len(self.params)

    @property
    def step(self) -> float:
        """The communication step that is proposed [s]."""
        return USUAL_STEP if self.period is None else self.period

    @cached_property
    def time(self) -> str:
        """Name of the independent variable, which no other one has."""
        name = "time"
        while name in [v.name for v in self.variables]:
            name += "_"
        return name

    @cached_property
    def token(self) -> str:
        """Checksum of all that the FMU computes, in the form of a GUID."""
        parts = [*self.sources.items(), self.block, self.variables, self.memory, self.begin, self.make, self.helpers]
        digest = hashlib.sha256(repr(parts).encode("utf-8")).hexdigest()
        return f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"


def closed_range(bounds: Bounds | None, values: Mapping[str, float]) -> tuple[float, float]:
    """Return the ends of a range; an end outside of it is replaced by the next normal number inside."""
    if bounds is None:
        return -math.inf, math.inf
    lower, upper = evaluate(bounds.lower, values), evaluate(bounds.upper, values)
    lower = _beside(lower, 1.0) if bounds.without_lower and math.isfinite(lower) else lower
    return lower, _beside(upper, -1.0) if bounds.without_upper and math.isfinite(upper) else upper


def _beside(end: float, way: float) -> float:
    # Beside 0 some importers take numbers that are not normal for mistakes.
    return math.nextafter(end, way * math.inf) if end else way * sys.float_info.min


def near_zero(lower: float, upper: float) -> float:
    """Return the number of a range that is nearest to 0."""
    return min(max(0.0, lower), upper)


def c_text(text: str) -> str:
    """Return a text as a string literal of C, with nothing that `printf` would take as a format."""
    escaped = "".join(f"\\{c}" if c in '"\\' else c for c in text if c.isprintable() and c != "%")
    return f'"{escaped}"'
