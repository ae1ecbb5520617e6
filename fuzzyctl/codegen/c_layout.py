"""The C interface of a unit: identifiers, parameters, struct members."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from fuzzyctl.codegen.c_library import LIBRARY
from fuzzyctl.codegen.names import C_FUNCTION_RESERVED, C_RESERVED, Names
from fuzzyctl.codegen.unit import Unit

#: Macros of generated files, and the constant of success, behind the name of the system in capitals.
MACROS: Final = ("H", "OK", "MAGNITUDE", "INFINITE", "NAN", "FRACTION")


@dataclass(frozen=True)
class CLayout:
    """What C calls things.

    One output is returned; several are written to a struct. A status is the last parameter, where a system may refuse.
    """

    unit: Unit

    @cached_property
    def name(self) -> str:
        """Name of the function, and of the files."""
        names = Names(C_FUNCTION_RESERVED)
        name = names.claim(self.unit.system.name)
        # Its macros must not be those of the library, as FP_NAN is.
        while any(f"{name.upper()}_{macro}" in LIBRARY for macro in MACROS):
            name = names.claim(f"{name}_fz")
        return name

    @cached_property
    def _members(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        # What the files call their own begins with the name of the system; members of structs meet its macros only.
        names, macros = Names([*C_RESERVED, self.name]), f"{self.name.upper()}_"
        own = (f"{self.name}_", macros)
        inputs = tuple(names.claim(i.name, apart_from=own) for i in self.unit.plan.inputs)
        return inputs, tuple(names.claim(o.name, apart_from=(macros,)) for o in self.unit.plan.outputs)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Identifiers of the inputs."""
        return self._members[0]

    @property
    def outputs(self) -> tuple[str, ...]:
        """Identifiers of the outputs, members of the struct of outputs."""
        return self._members[1]

    @property
    def arguments(self) -> dict[str, str]:
        """Identifiers of the arguments of programs."""
        return dict(zip(self.unit.evaluation.arguments, self.inputs, strict=True))

    @property
    def real(self) -> str:
        """The type of numbers."""
        return self.unit.precision

    @property
    def many(self) -> bool:
        """Whether there are several outputs."""
        return len(self.outputs) > 1

    @cached_property
    def states(self) -> tuple[str, ...]:
        """The entries of the state."""
        adaptive = [f"state->consequent[{k}]" for k in range(len(self.unit.plan.states))]
        return (*adaptive, *(f"state->held_{self.outputs[o]}" for o in self.unit.plan.held))

    @property
    def input_parameters(self) -> list[str]:
        """The declared inputs."""
        return [f"{self.real} {i}" for i in self.inputs]

    @property
    def evaluation(self) -> str:
        """The head of the function that evaluates."""
        parameters = self.input_parameters
        if self.states:
            parameters.append(f"{'' if self.unit.plan.held else 'const '}{self.name}_state *state")
        if self.many:
            parameters.append(f"{self.name}_outputs *outputs")
        if self.unit.refusals:
            parameters.append(f"{self.name}_status *status")
        return f"{'void' if self.many else self.real} {self.name}({', '.join(parameters)})"

    @property
    def init(self) -> str:
        """The head of the function that begins a state."""
        return f"void {self.name}_init({self.name}_state *state)"

    @property
    def rates(self) -> str:
        """The head of the function that computes dC/dt."""
        count = len(self.unit.plan.states)
        parameters = [*self.input_parameters, f"const {self.name}_state *state", f"{self.real} rate[{count}]"]
        return f"void {self.name}_rates({', '.join(parameters)})"

    @property
    def adapt(self) -> str:
        """The head of the function that steps the adaptive consequents."""
        parameters = [f"{self.name}_state *state", *self.input_parameters, f"{self.real} dt"]
        return f"void {self.name}_adapt({', '.join(parameters)})"

    def status(self, output: str = "") -> str:
        """Return the status of a refusal, or of success."""
        if not output:
            return f"{self.name.upper()}_OK"
        return self._refusals[output]

    @cached_property
    def _refusals(self) -> dict[str, str]:
        return status_names(
            self.name, {o.name: own for o, own in zip(self.unit.plan.outputs, self.outputs, strict=True)}
        )


def status_names(name: str, outputs: Mapping[str, str]) -> dict[str, str]:
    """Return the status of each refusal, by the name of the output.

    Args:
        name: That of the system, or of the controller.
        outputs: Identifiers of the outputs by name; they may differ by case only.
    """
    names, prefix = Names(()), f"{name.upper()}_NO_RULE_FOR_"
    return {output: names.claim(prefix + own.upper()) for output, own in outputs.items()}
