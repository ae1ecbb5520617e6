"""Rule files as gain kernels: load, check the role of a file, prove the properties that the law requires, compile.

With `law_text` the only modules that import fuzzyctl's engine. Everything but compiling works without the compiler, so
that a broken rule file is answered at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import fuzzyctl
from dwmr.control import law_text
from dwmr.control.rule_files import RuleFiles, Used, read_whole
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.expr import names_in
from fuzzyctl.kernels.plan.expansion import with_values

if TYPE_CHECKING:
    from dwmr.control.rule_files import RuleFile
    from fuzzyctl.analysis.verdicts import Verdict
    from fuzzyctl.experiments.scenario_keys import Places
    from fuzzyctl.model.system import FuzzySystem

#: Identity of a fuzzy system: its file and the values of its params.
Key = tuple[Path, tuple[tuple[str, float], ...]]


class Known:
    """Files, proofs and compiled code, which scenarios that differ in params share.

    Attributes:
        systems: By file: the system, the checksums of all that it reads, and the warnings of its checks.
        changed: Systems with other params.
        sound: Systems that give a number everywhere.
        bounds: Proved bounds of outputs.
        verdicts: On the guarantees of a file, by its checksum and the values of its params.
        kernels: Compiled kernels.
        laws: Control laws as their files have them.
        assembled: Control laws with the systems that they call.
        proved: Whether another process has proved everything for the same files and values.

    Args:
        proved: As the attribute.
    """

    def __init__(self, proved: bool = False) -> None:
        self.proved = proved
        self.systems: dict[Path, tuple[Any, Used, tuple[Diagnostic, ...]]] = {}
        self.changed: dict[Key, Any] = {}
        self.sound: set[Key] = set()
        self.bounds: dict[Key, Any] = {}
        self.verdicts: dict[Any, tuple[Verdict, ...]] = {}
        self.kernels: dict[Key, Any] = {}
        self.laws: dict[Path, law_text.LawText] = {}
        self.assembled: dict[Any, law_text.Assembled] = {}


class Rules:
    """The rule files of a run.

    Args:
        named: File and params by role, as the scenario gives them.
        folders: Where to look for a file, first match wins; the shipped rules come last.
        places: Locations of the scenario's keys, for diagnostics.
        known: Of other scenarios, to share.

    Attributes:
        files: Where they are.
        used: The files read so far, by role.
        laws: The control laws read so far that are text, by file name.
        warnings: Those of the checks of these files.
    """

    def __init__(
        self, named: Mapping[str, RuleFile], folders: tuple[Path, ...], places: Places, known: Known | None = None
    ) -> None:
        self.files = RuleFiles(named, folders, places)
        self.used: dict[str, Used] = {}
        self.laws: dict[str, Used] = {}
        self.warnings: list[Diagnostic] = []
        self.known = Known() if known is None else known

    def law(self, name: str) -> law_text.LawText:
        """Read a control law once, and remember its warnings.

        Args:
            name: Name of its file.

        Raises:
            DiagnosticError: When the file has mistakes, or is not a control law.
        """
        path = self.files.law(name)
        if path not in self.known.laws:
            systems = {one.resolve(): (system,) for one, (system, *_) in self.known.systems.items()}
            self.known.laws[path] = law_text.read(path, systems)
        text = self.known.laws[path]
        if name not in self.laws:
            self.laws[name] = text.used
            self.warnings += [d for d in text.warnings if d not in self.warnings]
        return text

    def assembled(self, law: law_text.LawText, part: str) -> law_text.Assembled:
        """Return a control law that calls the rule files of the scenario, each by the name of its role.

        A param of the law that is a plain number has the value of the rule files' param of the same name.

        Args:
            law: The law.
            part: A param that is 0; an empty string for none.
        """
        controller, written = law.controller, law_text.systems_of(law.controller)
        systems = {role: self.system(role, written[role]) for role in written if role in self.files.named}
        self.laws[law.path.name] = law_text.used_as_called(law, {role: self.used[role] for role in systems})
        key = law.path, part, tuple(self._key(role, system) for role, system in systems.items())
        if key not in self.known.assembled:
            values = {name: value for system in systems.values() for name, value in system.values.items()}
            numbers = {
                p.name: values[p.name] for p in controller.params if p.name in values and not [*names_in(p.expression)]
            }
            called = law_text.with_systems(controller, {role: _named(s, role) for role, s in systems.items()})
            changed = with_values(called, numbers | ({part: 0.0} if part else {}))
            self.known.assembled[key] = law_text.Assembled(changed)
        return self.known.assembled[key]

    def prove_law(self, law: law_text.Assembled, values: Mapping[str, float], where: str) -> None:
        """Refuse a control law unless its guarantees, and those of the systems that it calls, are proved.

        Args:
            law: The law.
            values: Of all its params.
            where: The robot whose gains these are.

        Raises:
            DiagnosticError: With each guarantee that is refuted, or that cannot be decided in time.
        """
        if self.known.proved:
            return
        for system in law.called(values):
            self._require_coverage(system, Path(system.path))
            self._prove(system, where)
        _require_proved(law.proved(values), law.controller.path, where)

    def wrong_params(self, name: str, reason: str) -> Iterator[Diagnostic]:
        """Describe the params of rule files whose value the text of a control law does not admit, where it is given."""
        for role, used in self.used.items():
            if name in self.files.params(role):
                key = f"rules.{role}.{name}"
                yield self.files.places.diagnostic("FZ904", key, f"{key} {reason}")
            else:
                declared = (p for p in self._load(role).params if p.name == name)
                yield from (
                    Diagnostic("FZ904", f"param {name} {reason}", p.span, file=str(used.path)) for p in declared
                )

    def gain(self, role: str) -> Any:
        """Return the proved and compiled system of a custom role, for a law in Python."""
        system = self.system(role)
        self._prove(system)
        key = self._key(role, system)
        if key not in self.known.kernels:
            self.known.kernels[key] = fuzzyctl.compile(system)
        return self.known.kernels[key].value

    def proved(self, role: str) -> tuple[str, int, dict[str, float], float, float]:
        """Return facts of a proved rule file: output, number of rules, params, and least and greatest value.

        Raises:
            DiagnosticError: When the file has mistakes or does not fit the role.
        """
        system = self.system(role)
        output = system.outputs[0].name
        key = self._key(role, system)
        if key not in self.known.bounds:
            self.known.bounds[key] = fuzzyctl.output_bounds(system)
        bound = self.known.bounds[key][output]
        return output, len(system.rules), dict(system.values), bound.lo, bound.hi

    def system(self, role: str, written: FuzzySystem | None = None) -> Any:
        """Return the fuzzy system of a role with the scenario's params.

        Args:
            role: The role.
            written: The system that the control law was written with, whose inputs and output it must have.

        Raises:
            DiagnosticError: When the file has mistakes, does not fit the role, or has no such param.
        """
        system, params = self._load(role), self.files.params(role)
        if written is not None:
            _check_alike(system, written, role, self.used[role].path)
        unknown, path = sorted(set(params) - set(system.values)), self.used[role].path
        if unknown:
            params_of_file = tuple(system.values)
            keys = [f"rules.{role}.{name}" for name in unknown]
            raise DiagnosticError([self.files.unknown_param(key, path, params_of_file) for key in keys])
        replaced = [p for p in system.params if p.name in params]
        sources = {p.name: dict.fromkeys(n.name for n in names_in(p.expression)) for p in replaced}
        derived = [self.files.computed_param(role, name, tuple(names)) for name, names in sources.items() if names]
        if derived:
            raise DiagnosticError(derived)
        key = (path, tuple(sorted(params.items())))
        if params and key not in self.known.changed:
            try:
                self.known.changed[key] = system.with_params(**params)
            except (UnknownNameError, ValueOutOfBoundsError) as error:
                raise DiagnosticError([Diagnostic("FZ905", str(error), file=str(path))]) from error
        system = self.known.changed[key] if params else system
        self._require_coverage(system, path)
        return system

    def _load(self, role: str) -> Any:
        """Read and check the file of a role once, and remember its warnings."""
        path = self.used[role].path if role in self.used else self.files.path(role)
        if path not in self.known.systems:
            # Guarantees are proved at the values of each robot, see `_prove_guarantees`.
            system, reported = fuzzyctl.check(path, guarantees=False)
            diagnostics = [d for d in reported if d.severity != "hint"]
            if system is None:
                raise DiagnosticError(diagnostics)
            self.known.systems[path] = (system, read_whole(path), tuple(diagnostics))
        system, used, remarks = self.known.systems[path]
        if role not in self.used:
            _require_one_output(system, role, path)
            self.used[role] = used
            self.warnings += [d for d in remarks if d not in self.warnings]
        return system

    def _key(self, role: str, system: Any) -> Key:
        return self.used[role].path, tuple(sorted(system.values.items()))

    def _prove(self, system: FuzzySystem, where: str = "") -> None:
        """Refuse a system unless each `require` line of its file is proved at its params; equal ones are proved once.

        Args:
            system: The system.
            where: The robot whose gains are its params.

        Raises:
            DiagnosticError: With each guarantee that is refuted, or that cannot be decided in time.
        """
        if self.known.proved:
            return
        key = system.path, tuple(sorted(system.values.items()))
        if key not in self.known.verdicts:
            self.known.verdicts[key] = fuzzyctl.prove(system)
        _require_proved(self.known.verdicts[key], system.path, where)

    def _require_coverage(self, system: Any, path: Path) -> None:
        """Refuse a system that is not proved to have a number as its output everywhere; params may have opened a hole.

        A hole whose `else` is a number does not count: the number is in the bounds.
        """
        key = path, tuple(sorted(system.values.items()))
        if self.known.proved or key in self.known.sound:
            return
        from fuzzyctl.analysis.coverage import coverage

        errors = [d for d in coverage.diagnostics(system) if d.severity == "error"]
        if errors:
            raise DiagnosticError(errors)
        (output,) = system.outputs
        verdict = coverage.uncovered(system)[output.name]
        if verdict is not None and output.otherwise in (None, "nan", "error"):
            raise DiagnosticError([_not_covered(output, verdict, str(path))])
        self.known.sound.add(key)


def _require_one_output(system: FuzzySystem, role: str, path: Path) -> None:
    if len(system.outputs) != 1:
        message = f"{path.name} does not fit the role {role}"
        facts = (f"its outputs are {', '.join(v.name for v in system.outputs)}; a role has one output",)
        raise DiagnosticError([Diagnostic("FZ905", message, facts=facts, file=str(path))])


def _check_alike(system: FuzzySystem, written: FuzzySystem, role: str, path: Path) -> None:
    """Refuse a system whose inputs and output are not those of the system that the law was written with.

    Raises:
        DiagnosticError: With all that does not fit.
    """
    _require_one_output(written, role, path)
    (output,), (expected,) = system.outputs, written.outputs
    inputs, needed = (", ".join(v.name for v in one.inputs) for one in (system, written))
    mistakes = []
    if inputs != needed:
        mistakes.append(f"its inputs are {inputs}; {role} needs {needed} in this order")
    if output.name != expected.name:
        mistakes.append(f"its output is {output.name}; {role} needs the output {expected.name}")
    elif (output.adaptive is None) != (expected.adaptive is None):
        mistakes.append(f"output {output.name} must {'not ' if expected.adaptive is None else ''}be adaptive")
    if mistakes:
        message = f"{path.name} does not fit the role {role}"
        raise DiagnosticError([Diagnostic("FZ905", message, facts=tuple(mistakes), file=str(path))])


def _named(system: FuzzySystem, role: str) -> FuzzySystem:
    """Return a system by the name of its role; the same one, with all that it has kept, where that is its name."""
    return system if system.name == role else replace(system, name=role)


def _not_covered(output: Any, verdict: Any, path: str) -> Diagnostic:
    """Describe an output that has no number where no rule fires, or for which it is not decided whether one does."""
    from fuzzyctl.analysis.coverage.box_search import Hole

    needed = "a control law needs a number everywhere"
    if isinstance(verdict, Hole):
        without = f"'else {output.otherwise}' is not a number"
        message = f"no rule fires for output '{output.name}' where {verdict}, and {without}"
        help_text = "let a term of the inputs reach there, or say 'else' with a number"
        return Diagnostic("FZ401", message, output.span, facts=(needed,), help=help_text, file=path)
    message, facts = (
        f"it is not proved that some rule always fires for output '{output.name}'",
        (verdict.reason, needed),
    )
    return Diagnostic("FZ407", message, output.span, facts=facts, help="say 'else' with a number", file=path)


def _require_proved(verdicts: Sequence[Verdict], path: str, where: str) -> None:
    broken = [v for v in verdicts if not isinstance(v, fuzzyctl.Proved)]
    if broken:
        raise DiagnosticError([_unproved(v, path, where) for v in broken])


def _unproved(verdict: Verdict, path: str, where: str) -> Diagnostic:
    """Describe a guarantee of a rule file that is refuted or open."""
    if isinstance(verdict, fuzzyctl.Refuted):
        message, reason = f"the guarantee '{verdict.claim}' does not hold", str(verdict.witness)
        help_text = "change the rules or the gains, or claim what holds"
    else:
        assert isinstance(verdict, fuzzyctl.Undecided)
        message, reason = f"the guarantee '{verdict.claim}' is not proved", verdict.reason
        help_text = "a run needs it proved; 'fuzzyctl prove --timeout' takes more time"
    facts = (where, reason) if where else (reason,)
    return Diagnostic("FZ402", message, verdict.span, facts=facts, help=help_text, file=path)
