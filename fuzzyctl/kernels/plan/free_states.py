"""Free numbers of a controller: its params, and numbers of the systems that it calls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from fuzzyctl.diagnostics.diagnostic import ArgumentError, UnknownNameError
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.free_numbers import parametrised
from fuzzyctl.model.system import FuzzySystem


class FreeNumber(NamedTuple):
    """A number of a system that a controller calls."""

    system: str
    name: str


def free_names(controller: Controller, names: Sequence[str]) -> tuple[tuple[str, ...], tuple[float, ...]]:
    """Return the names of free numbers, those of arrays one by one, and their present values.

    Params of instances are among the params of the controller here, see `with_instance_params`.
    """
    values = controller.param_values.values
    systems = {s.name: s for s in controller.systems}
    found: dict[str, float] = {}
    for name in names:
        if not isinstance(name, str):
            raise ArgumentError(f"free must be a list of names, got {type(name).__name__} in it")
        system, _, rest = name.partition(".")
        if name in values:
            own = {name: values[name]}
        elif system in systems and rest:
            changed, parts = _parametrised(systems[system], rest)
            own = {f"{system}.{part}": changed.values[part] for part in parts}
        else:
            own_params = controller.settable
            known = [*dict.fromkeys(own_params), *(f"{s}.NAME" for s in systems)]
            raise UnknownNameError("free number", name, known)
        repeated = next((n for n in own if n in found), None)
        if repeated is not None:
            raise ArgumentError(f"'{repeated}' cannot be free: it is given twice")
        found |= own
    return tuple(found), tuple(found.values())


def _parametrised(system: FuzzySystem, name: str) -> tuple[FuzzySystem, tuple[str, ...]]:
    try:
        return parametrised(system, [name])
    except UnknownNameError as error:
        known = [f"{system.name}.{k}" for k in error.known]
        raise UnknownNameError("free number", f"{system.name}.{name}", known) from None
