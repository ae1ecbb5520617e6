"""Variables of a sweep: wildcards expanded to keys, values drawn for each repetition, both as `--set` arguments."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import BaseModel

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.experiments.scenario_keys import join_key, split_key
from fuzzyctl.experiments.sweep_spec import Distribution, SpecFile

#: Part of a key that stands for every table in a table, or every element of a list.
_STAR = "*"


@dataclass(frozen=True)
class Variable:
    """One value of the scenario that is drawn.

    Args:
        key: Of the scenario, as `--set` takes it.
        written: As written in the SPEC, perhaps with a star.
        distribution: How it is drawn.
        base: The scenario's own value, for a factor or an offset.
    """

    key: str
    written: str
    distribution: Distribution
    base: float = 0.0

    def draw(self, seed: int, repetition: int) -> Any:
        """Return the value of a repetition.

        It follows from seed, repetition and key alone: neither other keys nor controllers nor who computes it change
        it, so all controllers and all points of a grid meet the same values.
        """
        drawn = _draw(self.distribution, generator(seed, repetition, self.key))
        match self.distribution.relative:
            case "factor":
                return self.base * drawn
            case "offset":
                return self.base + drawn
        return drawn


def generator(seed: int, repetition: int, key: str) -> np.random.Generator:
    """Return the random numbers of one key in one repetition."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(repetition, *key.encode())))


def _draw(distribution: Distribution, random: np.random.Generator) -> Any:
    d = distribution
    if d.uniform is not None:
        return float(random.uniform(*d.uniform))
    if d.normal is not None:
        return float(random.normal(*d.normal))
    if d.loguniform is not None:
        return float(np.exp(random.uniform(*np.log(d.loguniform))))
    return (d.choice or ())[int(random.integers(len(d.choice or ())))]


def expand(file: SpecFile, settings: Any, common: Mapping[str, str] | None = None) -> tuple[Variable, ...]:
    """Return all values that are drawn; a star in a key stands for every table in a table, or element of a list.

    Args:
        file: The SPEC.
        settings: Of the scenario.
        common: Tables that others take values over from, as in `Places`.

    Raises:
        DiagnosticError: For a star without a match, a key without a number to be relative to, or a key twice.
    """
    variables: dict[str, Variable] = {}
    mistakes: list[Diagnostic] = []
    for written, distribution in file.spec.random.items():
        matches = (
            dict(_matches(settings, split_key(written)))
            if _STAR in split_key(written)
            else {written: _at(settings, written)}
        )
        if not matches:
            message = f"random.{written}: nothing in the scenario has this key"
            hint = _in_place_of(written, common or {})
            hint = hint or did_you_mean(split_key(written)[-1], _beside(settings, written))
            mistakes.append(file.diagnostic("FZ902", ("random", written), message, help=hint))
        for key, value in matches.items():
            relative = distribution.relative != "no"
            if relative and (isinstance(value, bool) or not isinstance(value, int | float)):
                message = (
                    f"random.{written}: {key} has no number in the scenario that a {distribution.relative} could change"
                )
                help_text = _in_place_of(written, common or {})
                if value is None and not help_text:
                    help_text = did_you_mean(split_key(key)[-1], _beside(settings, key))
                mistakes.append(file.diagnostic("FZ904", ("random", written), message, help=help_text))
            elif key in variables:
                message = f"random.{written} gives {key} again, after random.{variables[key].written}"
                mistakes.append(file.diagnostic("FZ904", ("random", written), message))
            else:
                variables[key] = Variable(key, written, distribution, value if relative else 0.0)
    if mistakes:
        raise DiagnosticError(mistakes)
    return tuple(variables.values())


def _in_place_of(written: str, common: Mapping[str, str]) -> str:
    """Return what to write in place of a key of a common table, which holds no values itself."""
    tables = ((many, one) for many, one in common.items() if written.startswith(f"{one}."))
    return next((f"give {many}.*.KEY in place of {one}.KEY" for many, one in tables), "")


def require_no_stars(file: SpecFile, common: Mapping[str, str]) -> None:
    """Refuse stars in the tables whose keys are those of the scenario as they are.

    Args:
        file: The SPEC.
        common: Tables that others take values over from, as in `Places`.

    Raises:
        DiagnosticError: For each key with a star outside [random].
    """
    mistakes = []
    for table, written in [*(("set", key) for key in file.spec.set), *(("grid", key) for key in file.spec.grid)]:
        if _STAR in split_key(written):
            message = f"{table}.{written}: a star stands for several keys in [random] alone"
            tables = ((many, one) for many, one in common.items() if written.startswith(f"{one}."))
            drawn = next((f"{many}.*{written.removeprefix(one)}" for many, one in tables), written)
            help_text = f"name one key, or draw {drawn} in [random]"
            mistakes.append(file.diagnostic("FZ902", (table, written), message, help=help_text))
    if mistakes:
        raise DiagnosticError(mistakes)


def has(settings: Any, key: str) -> bool:
    """Return whether something in a scenario has a key, which may hold stars."""
    return next(_matches(settings, split_key(key)), None) is not None


def _at(settings: Any, key: str) -> Any:
    return next((value for _, value in _matches(settings, split_key(key))), None)


def _matches(node: Any, parts: Sequence[str], before: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """Yield the full keys that match a key with stars, and their values; a table that is absent has none."""
    if not parts:
        yield join_key(before), node
        return
    children = _children(node)
    for name in children if parts[0] == _STAR else [parts[0]]:
        if children.get(name) is not None:
            yield from _matches(children[name], parts[1:], (*before, name))


def _beside(settings: Any, key: str) -> tuple[str, ...]:
    """Return the keys of the first table that would have to have the last part of a key."""
    for _, parent in _matches(settings, split_key(key)[:-1]):
        return tuple(_children(parent))
    return ()


def _children(node: Any) -> Mapping[str, Any]:
    if isinstance(node, BaseModel):
        return dict(node)
    if isinstance(node, tuple):
        return {str(k): value for k, value in enumerate(node)}
    return node if isinstance(node, dict) else {}
