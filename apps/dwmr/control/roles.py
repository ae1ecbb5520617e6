"""Roles of rule files in control laws: the inputs and the output that each role requires."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError


class Role(NamedTuple):
    """Inputs and output of a rule file, in their order.

    Attributes:
        inputs: Names of the inputs.
        output: Name of the one output.
        adaptive: Whether its consequents are adaptive.
    """

    inputs: tuple[str, ...]
    output: str
    adaptive: bool


ROLES = {
    "ais_reaction": Role(("sigma", "dsigma"), "f", False),
    "boundary_layer": Role(("abs_sigma",), "beta", False),
    "fcafsmc": Role(("sigma",), "F", True),
}


def check_role(system: Any, role: str, path: Path) -> None:
    """Refuse a system whose inputs and output are not those of its role, in that order.

    Raises:
        DiagnosticError: With all that does not fit.
    """
    wanted = ROLES[role]
    inputs = tuple(v.name for v in system.inputs)
    outputs = tuple(v.name for v in system.outputs)
    mistakes = []
    if inputs != wanted.inputs:
        mistakes.append(f"its inputs are {', '.join(inputs)}; {role} needs {', '.join(wanted.inputs)} in this order")
    if outputs != (wanted.output,):
        mistakes.append(f"its outputs are {', '.join(outputs)}; {role} needs the one output {wanted.output}")
    if not mistakes and (system.outputs[0].adaptive is not None) != wanted.adaptive:
        mistakes.append(f"output {wanted.output} must {'' if wanted.adaptive else 'not '}be adaptive")
    if mistakes:
        message = f"{path.name} does not fit the role {role}"
        raise DiagnosticError([Diagnostic("FZ905", message, facts=tuple(mistakes), file=str(path))])
