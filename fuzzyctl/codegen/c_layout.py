"""The C interface of a unit: identifiers, parameters, members of structs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from fuzzyctl.codegen.names import C_FUNCTION_RESERVED, C_RESERVED, LIBRARY, Names, ascii_name
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.kernels.plan.equations import DT

#: Macros of generated files, and the constant of success, behind the name of the block in capitals.
MACROS: Final = ("H", "OK", "MAGNITUDE", "INFINITE", "NAN", "FRACTION", "PERIOD")
#: Names of functions and types of the files, after the name of the block.
_OWN: Final = ("init", "step", "state", "params", "params_init", "outputs", "status", "rates", "adapt")


def member_name(name: str) -> str:
    """Return the name of a state in one word: instances and operators are joined by underscores."""
    return re.sub(r"[^\w]+", "_", name).strip("_")


@dataclass(frozen=True)
class CLayout:
    """What C calls things.

    One output is returned; several are written to a struct. A status is the last parameter, where a system may refuse.
    The state is the first parameter of a step, and follows the inputs of a system.

    Args:
        unit: The unit to write.
        bits: Of integers in place of floating-point numbers, 0 for none.
    """

    unit: Unit
    bits: int = 0

    @cached_property
    def name(self) -> str:
        """Begin of the names of the functions, and name of the files."""
        names = Names(C_FUNCTION_RESERVED)
        name = names.claim(self.unit.block.name)
        # Its macros must not be those of the library, as FP_NAN is.
        while any(f"{name.upper()}_{macro}" in LIBRARY for macro in MACROS) or any(
            f"{name}_{suffix}" in C_FUNCTION_RESERVED for suffix in _OWN
        ):
            name = names.claim(f"{name}_fz")
        return name

    @property
    def real(self) -> str:
        """The type of numbers."""
        return f"int{self.bits}_t" if self.bits else self.unit.precision

    @property
    def _macros(self) -> str:
        # Names of the files begin with the name of the block; members of structs meet its macros only.
        return f"{self.name.upper()}_"

    @cached_property
    def arguments(self) -> tuple[str, ...]:
        """Identifiers of the inputs, then `dt` where there is no period."""
        names = Names([*C_RESERVED, self.name, "params"])
        inputs = [names.claim(i, apart_from=(f"{self.name}_", self._macros)) for i in self.unit.inputs]
        return (*inputs, *((DT,) if self.unit.takes_time else ()))

    @cached_property
    def outputs(self) -> tuple[str, ...]:
        """Identifiers of the outputs, members of the struct of outputs."""
        names = Names([*C_RESERVED, self.name])
        return tuple(names.claim(o, apart_from=(self._macros,)) for o in self.unit.outputs)

    @cached_property
    def members(self) -> tuple[tuple[str, str], ...]:
        """For each slot its member of the state, and the member with the position of the oldest number of a delay."""
        names, macros = Names([*C_RESERVED, self.name]), (self._macros,)
        results = []
        for slot in self.unit.slots:
            member = names.claim(member_name(slot.name), apart_from=macros)
            results.append((member, names.claim(f"{member}_oldest", apart_from=macros) if slot.length > 1 else ""))
        return tuple(results)

    @property
    def slots(self) -> tuple[str, ...]:
        """The value that is read of each slot."""
        return tuple(f"state->{member}[state->{k}]" if k else f"state->{member}" for member, k in self.members)

    @property
    def consequents(self) -> tuple[str, ...]:
        """Texts of the adaptive consequents."""
        return tuple(f"state->consequent[{k}]" for k in range(len(self.unit.consequents)))

    @cached_property
    def numbers(self) -> tuple[str, ...]:
        """Identifiers of the free numbers, members of the struct of params."""
        names = Names([*C_RESERVED, self.name])
        return tuple(names.claim(member_name(n.name), apart_from=(self._macros,)) for n in self.unit.numbers)

    @property
    def names(self) -> dict[str, str]:
        """Texts of the arguments of the program."""
        texts = (*self.arguments, *self.consequents, *self.slots, *(f"params->{n}" for n in self.numbers))
        return dict(zip(self.unit.program.arguments, texts, strict=True))

    @property
    def many(self) -> bool:
        """Whether there are several outputs."""
        return len(self.outputs) > 1

    @property
    def function(self) -> str:
        """The name of the function that evaluates a system, or makes a step."""
        return f"{self.name}_step" if self.unit.is_step else self.name

    @property
    def evaluation(self) -> str:
        """The head of the function that evaluates a system, or makes a step."""
        inputs = [f"{self.real} {a}" for a in self.arguments]
        state = [f"{'' if self.unit.slots else 'const '}{self.name}_state *state"] if self.unit.has_state else []
        params = [f"const {self.name}_params *params"] if self.numbers else []
        parameters = [*state, *params, *inputs] if self.unit.is_step else [*inputs, *state]
        if self.many:
            parameters.append(f"{self.name}_outputs *outputs")
        if self.unit.refusals:
            parameters.append(f"{self.name}_status *status")
        return f"{'void' if self.many else self.real} {self.function}({', '.join(parameters) or 'void'})"

    def call(self, state: str, params: str, inputs: Sequence[str]) -> list[str]:
        """Return the texts of arguments in the order of the parameters, without those for results."""
        pointers = [*([state] if self.unit.has_state else []), *([params] if self.numbers else [])]
        return [*pointers, *inputs] if self.unit.is_step else [*inputs, *pointers]

    @property
    def init(self) -> str:
        """The head of the function that begins a state."""
        return f"void {self.name}_init({self.name}_state *state)"

    @property
    def params_init(self) -> str:
        """The head of the function that sets the free numbers to those of the rule file."""
        return f"void {self.name}_params_init({self.name}_params *params)"

    @property
    def rates(self) -> str:
        """The head of the function that computes dC/dt."""
        inputs = ", ".join(f"{self.real} {a}" for a in self.arguments)
        rate = f"{self.real} rate[{len(self.consequents)}]"
        return f"void {self.name}_rates({inputs}, const {self.name}_state *state, {rate})"

    @property
    def adapt(self) -> str:
        """The head of the function that steps the adaptive consequents."""
        inputs = ", ".join(f"{self.real} {a}" for a in self.arguments)
        return f"void {self.name}_adapt({self.name}_state *state, {inputs}, {self.real} dt)"

    def status(self, output: str = "") -> str:
        """Return the status of a refusal, or of success."""
        return self._refusals[output] if output else f"{self.name.upper()}_OK"

    @cached_property
    def _refusals(self) -> dict[str, str]:
        names, prefix = Names(()), f"{self.name.upper()}_NO_RULE_FOR_"
        return {o: names.claim(prefix + ascii_name(o).upper()) for o in self.unit.refusals}
