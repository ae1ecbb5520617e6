"""Requirements on rule files: inputs and outputs by role, and the lower bound of the switching gain."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from dwmr.control.rule_files import RuleFiles
    from fuzzyctl.diagnostics.source import Span


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
    """Refuse a system in a custom role whose inputs and output are not those that the law was written with.

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


#: The role of the rule file whose gains these are.
ROLE = "ais_reaction"
#: Rulings of the constraint G_AIS >= G_min: the claim is checked within this much [m/s or rad/s].
TOLERANCE = 1e-12


class Channel(NamedTuple):
    """One channel of a robot whose gains are checked.

    Attributes:
        robot: Name of the robot.
        channel: "v" or "omega".
        own: The gains the robot sets itself, by name.
    """

    robot: str
    channel: str
    own: Mapping[str, float]


def not_positive(
    asked: Channel, name: str, value: float, files: RuleFiles, place: tuple[Span | None, Path]
) -> Diagnostic:
    """Describe a gain without which k̄_h − k_s sup f is not a bound of G_AIS, at the place that gives it.

    Args:
        asked: Whose gain it is.
        name: Name of the gain.
        value: Its value [m/s or rad/s].
        files: The rule files, with the params that the scenario sets.
        place: Where the rule file declares the param.
    """
    unit = "m/s" if asked.channel == "v" else "rad/s"
    bad = f"must be > 0 {unit}, got {value:g}"
    facts = ("G_AIS = k_h - k_s f is least where f is greatest, and k_h >= k_h_min > 0, only for such gains",)
    if name in asked.own:
        key = f"robots.{asked.robot}.controllers.aifqsmc.{name}_{asked.channel}"
        return files.places.diagnostic("FZ904", key, f"{key} {bad}", facts=facts)
    if name in files.params(ROLE):
        key = f"rules.{ROLE}.{name}"
        return files.places.diagnostic("FZ904", key, f"{key} {bad}", facts=facts)
    span, path = place
    return Diagnostic("FZ906", f"param {name} {bad}", span, facts=facts, file=str(path))


def prove_floor(system: Any, bound: Any, asked: Channel) -> None:
    """Refuse a run unless k̄_h − k_s sup f >= G_min > 0 follows from the bounds of f.

    Args:
        system: The fuzzy system f(σ*, dσ*/dt) with the gains of the channel as its params.
        bound: Proved bounds of f.
        asked: Whose gains they are.

    Raises:
        DiagnosticError: At the term whose peak is too high.

    Source:
        Goto, Bertol, Martins, section 7, choice of f_max.
    """
    k_h_min, k_s, g_min = (system.values[name] for name in ("k_h_min", "k_s", "G_min"))
    smallest = k_h_min - k_s * bound.hi
    if g_min > TOLERANCE and smallest >= g_min - TOLERANCE:
        return
    facts = [
        f"robot {asked.robot}, channel {asked.channel}: "
        f"k_h_min - k_s * sup f = {k_h_min:.6g} - {k_s:.6g} * {bound.hi:.6g} = {smallest:.6g}, "
        f"which must be >= G_min = {g_min:.6g}"
    ]
    if g_min <= TOLERANCE:
        facts.append(f"G_min must be > {TOLERANCE:g}, or nothing keeps the switching gain positive")
    highest = (k_h_min - g_min) / k_s
    help_text = f"lower this peak to f_max = (k_h_min - G_min) / k_s = {highest:.6g} or less, or lower k_s"
    raise DiagnosticError(
        [
            Diagnostic(
                "FZ906",
                f"G_AIS > 0 is not guaranteed: f reaches {bound.hi:.6g}",
                span=bound.hi_span,
                facts=tuple(facts),
                help=help_text,
                file=str(system.path),
            )
        ]
    )
