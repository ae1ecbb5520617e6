"""Unit of code generation: one system with its programs, proved bounds and source."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, Literal

from fuzzyctl import __version__
from fuzzyctl.analysis.bounds import OutputBound, output_bounds
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict
from fuzzyctl.codegen.rounding_text import at_most
from fuzzyctl.codegen.simplify import lean
from fuzzyctl.codegen.table import Tabulated, tabulated
from fuzzyctl.codegen.wrapping import folded
from fuzzyctl.formats.fz import semantics_text
from fuzzyctl.kernels.algorithms.select import Algorithm, algorithm_of
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import Plan, plan
from fuzzyctl.kernels.program.program import Program, Refuse
from fuzzyctl.model.system import FuzzySystem

Precision = Literal["float", "double"]

#: Largest error that self-tests allow, in parts of an output's largest magnitude. Of `float` it is an allowance, not a
#: proof: rounding may add up.
TOLERANCE: Final[Mapping[Precision, float]] = {"double": 1e-12, "float": 1e-4}


#: Most numbers of the tables of rules that can act where memory is small: 32 kB in double precision.
MOST_NUMBERS: Final = 4096
#: Most coefficients of all cells, 2^n for each of n inputs, where memory is small: 4 kB in double precision.
MOST_COEFFICIENTS: Final = 512


@dataclass(frozen=True)
class Unit:
    """One system to be written.

    Args:
        system: The system, its params set.
        digest: SHA-256 of the text of its rule file.
        settings: Params that were set by hand.
        algorithm: How it is evaluated; for a table, interpolation of the table.
        bounds: What is proved of its outputs, by name; those of a table hold for the table too.
        table: The lookup table that takes its place, None for the system itself.
        precision: Type of its numbers.
        verdicts: What is known of its guarantees.
    """

    system: FuzzySystem
    digest: str
    settings: tuple[tuple[str, float], ...]
    algorithm: Algorithm
    bounds: Mapping[str, OutputBound] = field(hash=False)
    table: Tabulated | None = None
    precision: Precision = "double"
    verdicts: Sequence[Verdict] = field(default=(), hash=False)

    @property
    def plan(self) -> Plan:
        """The plan of the system."""
        return self.algorithm.plan

    @cached_property
    def evaluation(self) -> Program:
        """The program for one point whose inputs are no NaN."""
        return lean(self.algorithm.printed)

    @cached_property
    def rates(self) -> Program | None:
        """The program for dC/dt of adaptive consequents, None where nothing adapts."""
        return lean(inference.rates(self.plan)) if self.plan.states else None

    @cached_property
    def refusals(self) -> tuple[str, ...]:
        """Outputs that refuse where no rule fires: those with `else error`."""
        return tuple(s.output for s in self.evaluation.body if isinstance(s, Refuse))

    def scale(self, position: int) -> float:
        """Return the largest magnitude of an output, what tolerances are relative to."""
        output = self.plan.outputs[position]
        bound = self.bounds[output.name]
        ends = [abs(e) for e in (output.lower, output.upper, bound.lo, bound.hi) if abs(e) < 1e300]
        return max([*ends, 1e-300])

    def tolerance(self, position: int, precision: Precision | None = None) -> float:
        """Return the largest error of an output that the self-test allows: what rounding may make of it.

        What is expected of a table are its own values, so that its error is no part of it.

        Args:
            position: Of the output.
            precision: Of the target's numbers, where it is not what their type promises.
        """
        return TOLERANCE[precision or self.precision] * self.scale(position)


def prepare(
    system: FuzzySystem,
    text: str,
    *,
    settings: Mapping[str, float] | None = None,
    algorithm: str = "auto",
    precision: Precision = "double",
    table: int | None = None,
    small: bool = False,
    verdicts: Sequence[Verdict] = (),
) -> Unit:
    """Plan a system for code generation.

    Args:
        system: A checked system with its params set.
        text: The text of its rule file.
        settings: Params that were set, for the record.
        algorithm: One of `kernels.algorithm.ALGORITHMS`.
        precision: Type of its numbers.
        table: Points along each input of a lookup table to write instead.
        small: Whether the target has little memory, so that large tables are left out where none were asked for, and
            values are stored instead of the coefficients of many cells.
        verdicts: What is known of its guarantees, for the record.

    Raises:
        ArgumentError: For interpolation of a system that does not interpolate.
        CodegenError: For a lookup table of a system that has none, or whose error has no bound.
    """
    chosen = algorithm_of(plan(system), algorithm)
    chosen = for_small(chosen, algorithm) if small else chosen
    found = tabulated(chosen, table) if table is not None else None
    if found is not None:
        most = chosen.most_coefficients
        chosen = Algorithm(chosen.plan, found.grid, f"a table of {table} points along each input")
        chosen = replace(chosen, most_coefficients=most)
    return Unit(
        system=system,
        digest=hashlib.sha256(text.encode("utf-8")).hexdigest(),
        settings=tuple((settings or {}).items()),
        algorithm=chosen,
        bounds=output_bounds(system),
        table=found,
        precision=precision,
        verdicts=tuple(verdicts),
    )


def for_small(chosen: Algorithm, wanted: str) -> Algorithm:
    """Return an algorithm as it is written where memory is small.

    Args:
        chosen: The algorithm.
        wanted: What was asked for; large tables are left out for "auto" only.
    """
    if wanted == "auto" and chosen.name == "active":
        numbers = sum(len(values) for _, values in chosen.printed.tables)
        if numbers > MOST_NUMBERS:
            reason = (
                f"those that can act would take {numbers:,} numbers; algorithm 'active' looks them up, and is faster"
            )
            chosen = Algorithm(chosen.plan, None, reason)
    return replace(chosen, most_coefficients=MOST_COEFFICIENTS)


def described(unit: Unit) -> list[str]:
    """Return what stands at the head of generated text, line by line, in one line's characters."""
    system, flat = unit.system, unit.plan
    lines = [f"{system.name}: {system.title}" if system.title else system.name]
    if system.citation:
        lines.append(f"Source: {system.citation}")
    lines += ["", f"Generated by fuzzyctl {__version__}; change the rule file, not this file."]
    lines.append(f"Rule file: SHA-256 {unit.digest}")
    lines += [f"Param set: {name} = {value!r}" for name, value in unit.settings]
    lines.append(f"Semantics profile: {semantics_text(system.method.semantics)}")
    lines.append(f"Algorithm: {unit.algorithm.name}; {unit.algorithm.reason}")
    lines += ["", "Inputs; values outside the range count as its nearer end:"]
    for variable, planned in zip(system.inputs, flat.inputs, strict=True):
        tail = ", extrapolated" if planned.extrapolate else ""
        lines.append(f"  {variable.name}{_titled(variable.label)}: {_range(planned.lower, planned.upper)}")
        lines[-1] += f"{_unit(variable.unit)}{tail}"
    lines.append("Outputs:")
    for k, declared in enumerate(system.outputs):
        bound, out = unit.bounds[declared.name], flat.outputs[k]
        lines.append(
            f"  {declared.name}{_titled(declared.label)}: {_range(out.lower, out.upper)}{_unit(declared.unit)}"
        )
        lines[-1] += f"; proved: {bound.lo!r} <= {declared.name} <= {bound.hi!r} for all inputs"
    lines += guarantees(unit.verdicts, "system itself, before tables and rounding")
    if unit.table is not None:
        lines.append("Proved error of the table, beside rounding of the arithmetic:")
        errors = zip(system.outputs, unit.table.errors, strict=True)
        lines += [
            f"  |{o.name} - exact {o.name}| <= {at_most(e)} for all inputs; {unit.table.proof}" for o, e in errors
        ]
    return list(folded([printable(line) for line in lines]))


def guarantees(verdicts: Sequence[Verdict], of: str) -> Iterator[str]:
    """Yield the lines of generated text about guarantees, which are decided for the block that `of` describes."""
    if verdicts:
        yield f"Guarantees of the rule file, decided for the {of}:"
    for verdict in verdicts:
        match verdict:
            case Proved(note=note):
                pass
            case Refuted(witness=witness, note=more):
                note = "; ".join(filter(None, (str(witness), more)))
            case Undecided(reason=reason):
                note = reason
        yield f"  {type(verdict).__name__.lower()}: {verdict.claim}{f' ({note})' if note else ''}"


def printable(text: str) -> str:
    """Return a text as a line of a comment may hold it: nothing that breaks the line or, in C, joins it to the next."""
    text = re.sub(r"[\x00-\x1f\x7f\x85\u2028\u2029]+", " ", text)
    text = re.sub(r"[\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]", "", text)  # what turns the direction of writing
    return re.sub(r"\?(?=\?)", "? ", text).replace("\\", "/").rstrip()


def _titled(title: str) -> str:
    return f" ({title})" if title else ""


def _range(lower: float, upper: float) -> str:
    return f"[{lower!r}, {upper!r}]"


def _unit(unit: str) -> str:
    return f" {unit}" if unit else ""
