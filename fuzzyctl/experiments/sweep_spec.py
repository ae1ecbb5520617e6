"""SPEC of a sweep: its settings and their checks, and the errors of pydantic in words."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, Strict, ValidationError, model_validator

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.experiments.scenario_keys import join_key, key_places, split_key
from fuzzyctl.experiments.scenario_layers import UnknownScenarioError, read_toml

Pair = Annotated[tuple[float, float], Strict(False)]

#: By the type of an error the name of its bound, and the relation that the value must have to it.
BOUNDS = {
    "greater_than": ("gt", ">"),
    "greater_than_equal": ("ge", ">="),
    "less_than": ("lt", "<"),
    "less_than_equal": ("le", "<="),
}
_KINDS = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text in quotes",
    "bool_type": "true or false",
    "finite_number": "a finite number",
    "tuple_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
}


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)


class Distribution(_Table):
    """How a value is drawn: one of the distributions, and its relation to the scenario's value."""

    uniform: Pair | None = Field(default=None, description="least and greatest value")
    normal: Pair | None = Field(default=None, description="mean and standard deviation")
    loguniform: Pair | None = Field(default=None, description="least and greatest value, uniform in its logarithm")
    choice: Annotated[tuple[Any, ...], Strict(False)] | None = Field(default=None, description="values, equally likely")
    relative: Literal["no", "factor", "offset"] = Field(
        default="no", description="whether the number multiplies the scenario's value, or is added to it"
    )

    @model_validator(mode="after")
    def _possible(self) -> Distribution:
        names = [name for name in DISTRIBUTIONS if getattr(self, name) is not None]
        if len(names) != 1:
            raise ValueError(f"must have exactly one of {', '.join(DISTRIBUTIONS)}, has {', '.join(names) or 'none'}")
        low, high = self.uniform or self.loguniform or (0.0, 0.0)
        if low > high:
            raise ValueError(f"{names[0]}: {low:g} is greater than {high:g}")
        if self.loguniform and not low > 0.0:
            raise ValueError(f"loguniform: both values must be > 0, got {low:g}")
        if self.normal and self.normal[1] < 0.0:
            raise ValueError(f"normal: the standard deviation must be >= 0, got {self.normal[1]:g}")
        if self.uniform and not math.isfinite(high - low):
            raise ValueError("uniform: the values are too far apart")
        if self.choice is not None and not self.choice:
            raise ValueError("choice: there is nothing to choose from")
        if self.relative != "no" and any(
            isinstance(v, bool) or not isinstance(v, int | float) for v in self.choice or ()
        ):
            raise ValueError("choice: a factor or an offset must be a number")
        return self


DISTRIBUTIONS = ("uniform", "normal", "loguniform", "choice")


class Spec(_Table):
    """Content of a SPEC file; the keys of `set`, `grid` and `random` are those of `--set`.

    An application whose measures are known in advance declares them in a subclass.
    """

    scenario: str = Field(min_length=1, description="shipped name, or a file beside the SPEC")
    controllers: Annotated[tuple[str, ...], Strict(False)] | None = Field(
        default=None, min_length=1, description="what the scenario is run under; its own when absent"
    )
    runs: int = Field(default=1, ge=1, le=1_000_000, description="repetitions at every point of the grid")
    seed: int = Field(default=0, ge=0, le=2**63 - 1, description="first number of all that is drawn")
    measures: Annotated[tuple[str, ...], Strict(False)] = Field(default=(), description="what to keep of each run")
    set: dict[str, Any] = Field(default={}, description="values that replace those of the scenario in every run")
    grid: dict[str, Annotated[tuple[Any, ...], Strict(False), Field(min_length=1)]] = Field(
        default={}, description="lists of values; every combination of them is run"
    )
    random: dict[str, Distribution] = Field(default={}, description="values drawn anew for every repetition")

    @property
    def draws(self) -> int:
        """The number of draws from the ranges that the scenario declares, see `Runnable.members`."""
        return 1


#: Tables whose keys are those of a scenario.
TABLES = ("set", "grid", "random")


@dataclass(frozen=True)
class SpecFile:
    """A SPEC together with the locations of its keys.

    Args:
        spec: Its content.
        source: Its text.
        path: Its file.
    """

    spec: Spec
    source: SourceText
    path: Path

    @cached_property
    def _places(self) -> Mapping[tuple[str, ...], tuple[int, int]]:
        return key_places(self.source.text)

    def span(self, *path: str) -> Span | None:
        """Return the place of a key, dotted in quotes or written as tables, else of its nearest parent."""
        flat = (*path[:1], *(part for one in path[1:] for part in split_key(one)))
        prefixes = [one[:k] for one in (path, flat) for k in range(len(one), 1, -1)]
        for candidate in (*prefixes, path[:1]):
            if place := self._places.get(candidate):
                return Span(self.source, *place)
        return None

    def diagnostic(self, code: str, path: tuple[str, ...], message: str, **more: Any) -> Diagnostic:
        """Return a diagnostic about a key of the file."""
        return Diagnostic(code, message, span=self.span(*path), file=self.source.name, **more)

    def scenario_path(self, find: Callable[[str, Path], Path]) -> Path:
        """Return the scenario's file: a path from the folder of the SPEC, or what else the name stands for.

        Args:
            find: As `Runnable.find`.

        Raises:
            DiagnosticError: When it does not exist.
        """
        beside = self.path.parent / self.spec.scenario
        try:
            return beside if beside.is_file() else find(self.spec.scenario, self.path.parent)
        except (OSError, ValueError):  # a name longer than the file system allows, or one with a null character
            message = f"scenario: {self.spec.scenario[:200]!r} is not the name of a file"
        except UnknownScenarioError as error:
            message = f"scenario: {error}"
        raise DiagnosticError([self.diagnostic("FZ904", ("scenario",), message)])


def read(path: Path, kind: type[Spec] = Spec) -> SpecFile:
    """Read a SPEC file.

    Args:
        path: The file.
        kind: Class of its content.

    Raises:
        DiagnosticError: With every mistake in it.
    """
    file = read_toml(path, "a SPEC file holds a few lines of TOML")
    return SpecFile(_validate(file.data, file.source, path, kind), file.source, path)


def _validate(data: Mapping[str, Any], source: SourceText, path: Path, kind: type[Spec]) -> Spec:
    # only the text matters for places; the content is not valid yet
    places = SpecFile(kind(scenario="any"), source, path)
    flat, mistakes = dict(data), list[Diagnostic]()
    for name in (name for name in TABLES if isinstance(data.get(name), dict)):
        pairs = list(_flat(data[name], name))
        flat[name] = dict(pairs)
        for key in (key for key, times in Counter(key for key, _ in pairs).items() if times > 1):
            mistakes.append(places.diagnostic("FZ904", (name, key), f"{name}.{key} is given twice"))
    try:
        spec = kind.model_validate(flat)
    except ValidationError as error:
        errors = dict.fromkeys(_diagnose(one, places) for one in error.errors(include_url=False))
        raise DiagnosticError(sorted([*mistakes, *errors], key=lambda d: d.span.start if d.span else -1)) from None
    mistakes += repeated(spec, places)
    if mistakes:
        raise DiagnosticError(mistakes)
    return spec


def repeated(spec: Spec, places: SpecFile) -> Iterator[Diagnostic]:
    """Yield names that occur twice in the lists of a SPEC, and would be run twice, or once in spite of that."""
    lists: dict[tuple[str, ...], tuple[Any, ...]] = {
        ("controllers",): spec.controllers or (),
        ("measures",): spec.measures,
    }
    lists |= {("grid", key): values for key, values in spec.grid.items()}
    for path, values in lists.items():
        # 1 and true are equal in Python, but not in TOML
        times = Counter((type(value).__name__, str(value)) for value in values)
        for (_, text), count in times.items():
            if count > 1:
                yield places.diagnostic(
                    "FZ904", path, f"{'.'.join(path)} has {text} {count} times", help="name it once"
                )


def _flat(table: Mapping[str, Any], name: str, before: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """Yield dotted keys and values of a table of a scenario's keys, which may be in quotes or written as tables.

    A key of a table within is a name, which may hold dots itself.
    """
    for key, value in table.items():
        parts = (*before, key) if before else tuple(split_key(key))
        # a distribution, or what was meant for one, is a table of the SPEC and not of the scenario
        leaf = name == "random" and isinstance(value, dict) and not any(isinstance(v, dict) for v in value.values())
        if isinstance(value, dict) and value and not leaf:
            yield from _flat(value, name, parts)
        else:
            yield join_key(parts), value


def _diagnose(error: Any, places: SpecFile) -> Diagnostic:
    """Turn one of pydantic's errors into a diagnostic with key and value."""
    path = tuple(str(part) for part in error["loc"])
    key = ".".join(path)
    match error["type"]:
        case "extra_forbidden":
            owner: type[BaseModel] = Distribution if path[0] == "random" else type(places.spec)
            keys = tuple(owner.model_fields)
            facts = (f"{key.rpartition('.')[0] or 'a SPEC'} has the keys {', '.join(keys)}",)
            hint = did_you_mean(path[-1], keys)
            return places.diagnostic("FZ902", path, f"unknown key {key}", facts=facts, help=hint)
        case "missing":
            return places.diagnostic("FZ903", path, f"{key} is missing")
        case "value_error":
            return places.diagnostic("FZ904", path, f"{key}: {error['ctx']['error']}")
        case "literal_error":
            expected = error["ctx"]["expected"]
            names = tuple(word.strip(" '") for word in expected.replace(" or ", ", ").split(","))
            hint = did_you_mean(str(error["input"]), names)
            message = f"{key} must be one of {expected}, got {show(error['input'])}"
            return places.diagnostic("FZ904", path, message, help=hint)
        case "too_short" | "too_long" | "string_too_short" if error["loc"]:
            return places.diagnostic("FZ904", path, f"{key} {length(error)}")
    must = "a table such as { uniform = [0.9, 1.1] }" if error["type"] == "model_type" else requirement(error)
    return places.diagnostic("FZ904", path, f"{key} must be {must}, got {show(error['input'])}")


def length(error: Any) -> str:
    """Describe an error in the number of elements of a list, or of characters of a text."""
    if error["type"] == "string_too_short":
        return "must not be empty"
    few = error["type"] == "too_short"
    number = error["ctx"]["min_length" if few else "max_length"]
    words = f"must have at {'least' if few else 'most'} {number} element{'s' if number != 1 else ''}"
    actual = error["ctx"]["actual_length"]  # None of a table that is too long
    return f"{words}, has {'more' if actual is None else actual or 'none'}"


def requirement(error: Any, number: Callable[[float], str] = "{:g}".format) -> str:
    """Describe a valid value.

    Args:
        error: Of pydantic.
        number: Writes a bound.
    """
    kind, about = error["type"], error.get("ctx", {})
    if kind in BOUNDS:
        name, symbol = BOUNDS[kind]
        return f"{symbol} {number(about[name])}"
    if kind in _KINDS:
        return _KINDS[kind]
    if kind == "literal_error":
        return str(about["expected"])
    return f"right ({error['msg']})"


def show(value: Any) -> str:
    """Return a value of a scenario as a short text."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return "a list"
    try:
        text = repr(value)
    except ValueError:
        return "a whole number of thousands of digits"
    return text if len(text) <= 60 else f"{text[:57]}..."
