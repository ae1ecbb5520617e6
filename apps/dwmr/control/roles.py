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
    """Refuse a system whose inputs and output are not those of its role, in that order; any has one output.

    Raises:
        DiagnosticError: With all that does not fit.
    """
    if role not in ROLES:
        _require_one_output(system, role, path)
        return
    _check(system, role, ROLES[role], path)


def check_alike(system: Any, written: Any, role: str, path: Path) -> None:
    """Refuse a system in a role of one's own whose inputs and output are not those that the law was written with.

    Raises:
        DiagnosticError: With all that does not fit.
    """
    _require_one_output(written, role, path)
    output = written.outputs[0]
    _check(system, role, Role(tuple(v.name for v in written.inputs), output.name, output.adaptive is not None), path)


def _require_one_output(system: Any, role: str, path: Path) -> None:
    if len(system.outputs) != 1:
        message = f"{path.name} does not fit the role {role}"
        facts = (f"its outputs are {', '.join(v.name for v in system.outputs)}; a role has one output",)
        raise DiagnosticError([Diagnostic("FZ905", message, facts=facts, file=str(path))])


def _check(system: Any, role: str, wanted: Role, path: Path) -> None:
    """Refuse a system that does not fit a role."""
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
