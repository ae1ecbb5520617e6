"""The C interface of a step: identifiers, parameters, members of the state."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from fuzzyctl.codegen.c_layout import MACROS, status_names
from fuzzyctl.codegen.c_library import LIBRARY
from fuzzyctl.codegen.names import C_FUNCTION_RESERVED, C_RESERVED, Names, ascii_name
from fuzzyctl.codegen.steps.unit import StepUnit
from fuzzyctl.kernels.plan.equations import DT

#: What the files call functions and types of their own, behind the name of the controller.
_OWN: Final = ("init", "step", "state", "params", "params_init", "outputs", "status")


def member_name(name: str) -> str:
    """Return the name of a state in one word: instances and operators are joined by underscores."""
    return re.sub(r"[^\w]+", "_", name).strip("_")


@dataclass(frozen=True)
class StepLayout:
    """What C calls things.

    The state is the first parameter. One output is returned; several are written to a struct. A status is the last
    parameter, where a system may refuse.
    """

    unit: StepUnit

    @cached_property
    def name(self) -> str:
        """Begin of the names of the functions, and name of the files."""
        names = Names(C_FUNCTION_RESERVED)
        name = names.claim(self.unit.controller.name)
        while self._collides(name):
            name = names.claim(f"{name}_fz")
        return name

    @staticmethod
    def _collides(name: str) -> bool:
        macros = any(f"{name.upper()}_{macro}" in LIBRARY for macro in (*MACROS, "PERIOD"))
        return macros or any(f"{name}_{own}" in C_FUNCTION_RESERVED for own in _OWN)

    @property
    def real(self) -> str:
        """The type of numbers."""
        return self.unit.precision

    @cached_property
    def arguments(self) -> tuple[str, ...]:
        """Identifiers of the inputs, then `dt` where there is no period."""
        macros = f"{self.name.upper()}_"
        names = Names([*C_RESERVED, self.name, "params"])
        inputs = [names.claim(i, apart_from=(f"{self.name}_", macros)) for i in self.unit.equations.inputs]
        return (*inputs, *(() if self.unit.equations.period is not None else (DT,)))

    @cached_property
    def outputs(self) -> tuple[str, ...]:
        """Identifiers of the outputs, members of the struct of outputs."""
        names = Names([*C_RESERVED, self.name])
        return tuple(names.claim(o, apart_from=(f"{self.name.upper()}_",)) for o in self.unit.outputs)

    @cached_property
    def members(self) -> tuple[tuple[str, str], ...]:
        """For each slot its member of the state, and the member with the position of the oldest number of a delay."""
        names, macros = Names([*C_RESERVED, self.name]), (f"{self.name.upper()}_",)
        found = []
        for slot in self.unit.slots:
            own = names.claim(member_name(slot.name), apart_from=macros)
            found.append((own, names.claim(f"{own}_oldest", apart_from=macros) if slot.length > 1 else ""))
        return tuple(found)

    @property
    def slots(self) -> tuple[str, ...]:
        """What is read of each slot."""
        return tuple(f"state->{own}[state->{k}]" if k else f"state->{own}" for own, k in self.members)

    @cached_property
    def numbers(self) -> tuple[str, ...]:
        """Identifiers of the free numbers, members of the struct of params."""
        names = Names([*C_RESERVED, self.name])
        own = (f"{self.name.upper()}_",)
        return tuple(names.claim(member_name(n.name), apart_from=own) for n in self.unit.numbers)

    @property
    def names(self) -> dict[str, str]:
        """Texts of the arguments of the program."""
        numbers = [f"params->{n}" for n in self.numbers]
        return dict(zip(self.unit.program.arguments, (*self.arguments, *self.slots, *numbers), strict=True))

    @property
    def many(self) -> bool:
        """Whether there are several outputs."""
        return len(self.outputs) > 1

    @property
    def step(self) -> str:
        """The head of the function that makes a step."""
        parameters = [f"{self.name}_state *state"] if self.members else []
        parameters += [f"const {self.name}_params *params"] if self.numbers else []
        parameters += [f"{self.real} {a}" for a in self.arguments]
        if self.many:
            parameters.append(f"{self.name}_outputs *outputs")
        if self.unit.refusals:
            parameters.append(f"{self.name}_status *status")
        return f"{'void' if self.many else self.real} {self.name}_step({', '.join(parameters) or 'void'})"

    @property
    def init(self) -> str:
        """The head of the function that begins a state."""
        return f"void {self.name}_init({self.name}_state *state)"

    @property
    def params_init(self) -> str:
        """The head of the function that sets the free numbers to those of the rule file."""
        return f"void {self.name}_params_init({self.name}_params *params)"

    def status(self, output: str = "") -> str:
        """Return the status of a refusal, or of success."""
        return self._refusals[output] if output else f"{self.name.upper()}_OK"

    @cached_property
    def _refusals(self) -> dict[str, str]:
        return status_names(self.name, {o: ascii_name(o) for o in self.unit.refusals})
