"""Rule files as gain kernels: load, check that a file fits its role, prove what the law relies on, compile.

The only control module that imports fuzzyctl's engine. Everything but compiling works without the compiler, so that a
broken rule file is answered at once.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import fuzzyctl
from fuzzyctl.assembly import files_read
from fuzzyctl.errors import Diagnostic, DiagnosticError, UnknownNameError, ValueOutOfBoundsError, closest, did_you_mean
from fuzzyctl.expr import names_in
from fuzzyctl.shipped import rules_folder

if TYPE_CHECKING:
    from dwmr.contracts import FloatArray
    from dwmr.places import Places
    from dwmr.scenario import RuleFile
    from fuzzyctl.analysis.verdicts import Verdict
    from fuzzyctl.source import Span

#: Rulings of the constraint G_AIS >= G_min: the claim is checked within this much [m/s or rad/s].
TOLERANCE = 1e-12


class Role(NamedTuple):
    """What a rule file must offer to serve in a control law."""

    inputs: tuple[str, ...]
    output: str
    adaptive: bool


ROLES = {
    "ais_reaction": Role(("sigma", "dsigma"), "f", False),
    "boundary_layer": Role(("abs_sigma",), "beta", False),
    "fcafsmc": Role(("sigma",), "F", True),
}


class Used(NamedTuple):
    """A rule file that serves in a role: where it is and what it holds.

    Attributes:
        path: The file.
        sha256: Of the file and, after one another, of all files that it brings in.
        files: Checksum of each of these files by name, as seen from the folder of the first.
    """

    path: Path
    sha256: str
    files: Mapping[str, str]


def _used(path: Path) -> Used:
    """Return a rule file with the checksums of all that it reads."""
    names = {path.name: path} | {str(p.relative_to(path.parent)): p for p in files_read(path)}
    contents = {name: one.read_bytes() for name, one in names.items()}
    files = {name: hashlib.sha256(content).hexdigest() for name, content in contents.items()}
    return Used(path, hashlib.sha256(b"".join(contents.values())).hexdigest(), files)


#: Identity of a fuzzy system: its file and the values of its params.
Key = tuple[Path, tuple[tuple[str, float], ...]]


class Known:
    """What has been read, proved and compiled; scenarios that differ in params share it.

    Attributes:
        systems: By file: the system, the checksums of all that it reads, and the warnings of its checks.
        changed: Systems with other params.
        sound: Systems that give a number everywhere.
        bounds: Proved bounds of outputs.
        verdicts: On the guarantees of a file, by its checksum and the values of its params.
        kernels: Compiled kernels.
    """

    def __init__(self) -> None:
        self.systems: dict[Path, tuple[Any, Used, tuple[Diagnostic, ...]]] = {}
        self.changed: dict[Key, Any] = {}
        self.sound: set[Key] = set()
        self.bounds: dict[Key, Any] = {}
        self.verdicts: dict[tuple[str, tuple[tuple[str, float], ...]], tuple[Verdict, ...]] = {}
        self.kernels: dict[Key, Any] = {}


class Rules:
    """The rule files of a run.

    Args:
        files: File and params by role, as the scenario gives them.
        folders: Where to look for a file, first match wins; the shipped rules come last.
        places: Where the scenario's keys stand, for diagnostics.
        known: Of other scenarios, to share.

    Attributes:
        used: The files read so far, by role.
        warnings: What the checks of those files warn of.
    """

    def __init__(
        self, files: Mapping[str, RuleFile], folders: tuple[Path, ...], places: Places, known: Known | None = None
    ) -> None:
        self.files, self.folders, self.places = files, folders, places
        self.used: dict[str, Used] = {}
        self.warnings: list[Diagnostic] = []
        self.known = Known() if known is None else known

    def path(self, role: str) -> Path:
        """Return the file that serves in a role.

        Raises:
            DiagnosticError: When the scenario names none, or none is found.
        """
        if role not in self.files:
            raise DiagnosticError([self.places.diagnostic("FZ903", f"rules.{role}", f"rules.{role}.file is missing")])
        name = self.files[role].file
        folders = (*self.folders, rules_folder())
        for folder in folders:
            if _exists(folder / name):
                return folder / name
        places = ", ".join(str(f) for f in folders)
        key = f"rules.{role}.file"
        message = f"{key} = {name!r} names a rule file that does not exist"
        raise DiagnosticError([self.places.diagnostic("FZ904", key, message, facts=(f"looked in {places}",))])

    def require_use_of(self, folder: Path) -> None:
        """Refuse a folder of rule files that holds none of the files the scenario names.

        Raises:
            DiagnosticError: Naming the files that were looked for.
        """
        wanted = [rule.file for rule in self.files.values()]
        if not wanted or any(_exists(folder / name) for name in wanted):
            return
        present = sorted(p.name for p in folder.glob("*.fz"))
        near = next((n for n in (closest(p, wanted) for p in present) if n is not None), None)
        facts = [f"looked for {', '.join(wanted)}"]
        facts.append(f"the folder holds {', '.join(present)}" if present else "the folder holds no rule files")
        help_text = f"did you mean '{near}'?" if near else "copy the files to change from the folder rules"
        message = f"--rules {folder} holds no rule file of this scenario"
        raise DiagnosticError([Diagnostic("FZ905", message, facts=tuple(facts), help=help_text, file=str(folder))])

    def near_misses(self, folder: Path) -> list[Diagnostic]:
        """Warn of rule files in a folder that are named almost like one that the scenario takes from elsewhere."""
        wanted = [rule.file for rule in self.files.values()]
        missing = [name for name in wanted if not _exists(folder / name)]
        found = []
        for path in sorted(folder.glob("*.fz")):
            near = closest(path.name, missing) if path.name not in wanted else None
            if near is not None:
                message = f"{path.name} is not used: the scenario names no such file"
                found.append(
                    Diagnostic("FZ905", message, severity="warning", help=f"did you mean '{near}'?", file=str(path))
                )
        return found

    def prove_reaction(self, robot: str, channel: str, k_h_min: float | None, k_s: float | None) -> Any:
        """Prove k̄_h − k_s sup f >= G_min > 0, and what else the rule file requires, for one channel of a robot.

        Args:
            robot: Name of the robot.
            channel: "v" or "omega".
            k_h_min, k_s: The robot's own gains, or None for those of the rule file's params.

        Returns:
            The fuzzy system f(σ*, dσ*/dt) with these gains as its params.

        Raises:
            DiagnosticError: When the guarantee does not follow from the rule file.

        Source:
            Goto, Bertol, Martins, section 7, choice of f_max.
        """
        role = "ais_reaction"
        own = {name: value for name, value in (("k_h_min", k_h_min), ("k_s", k_s)) if value is not None}
        given = {**(self.files[role].params if role in self.files else {}), **own}
        for name in ("k_h_min", "k_s"):
            if not given.get(name, 1.0) > 0.0:
                raise DiagnosticError([self._not_positive(role, name, given[name], robot, channel, own)])
        missing = [name for name in ("k_h_min", "k_s", "G_min") if name not in self.system(role, {}).values]
        if missing:
            message = f"{self.path(role).name} declares no param {', '.join(missing)}"
            facts = (f"{role} needs the params k_h_min, k_s and G_min",)
            raise DiagnosticError([Diagnostic("FZ905", message, facts=facts, file=str(self.path(role)))])
        system = self.system(role, own)
        for name in ("k_h_min", "k_s"):
            if not system.values[name] > 0.0:
                raise DiagnosticError([self._not_positive(role, name, system.values[name], robot, channel, own)])
        _prove_gain(system, self._bounds(role, system)["f"], robot, channel)
        self._prove_guarantees(role, system, f"robot {robot}, channel {channel}")
        return system

    def prove_boundary_layer(self) -> Any:
        """Prove β > 0, and what else the rule file requires, and return the fuzzy system β(|σ*|).

        Raises:
            DiagnosticError: When β > 0 does not follow from the rule file, or a guarantee is not proved.
        """
        system = self.system("boundary_layer", {})
        bound = self._bounds("boundary_layer", system)["beta"]
        if bound.lo > 0.0:
            self._prove_guarantees("boundary_layer", system)
            return system
        message = f"the boundary layer is not guaranteed to be positive: β comes down to {bound.lo:.6g}"
        facts = ("Eq. (19) divides by β, so every value β can take must be > 0",)
        help_text = "raise the peak of this term above 0"
        path = str(self.path("boundary_layer"))
        raise DiagnosticError(
            [Diagnostic("FZ907", message, span=bound.lo_span, facts=facts, help=help_text, file=path)]
        )

    def reaction(self, robot: str, channel: str, k_h_min: float | None, k_s: float | None) -> tuple[Any, float, float]:
        """Return the proved and compiled f(σ*, dσ*/dt) of one channel of a robot, with k̄_h and k_s.

        Source:
            Goto, Bertol, Martins, Eq. (18), which the rule file's `center_average` is.
        """
        system = self.prove_reaction(robot, channel, k_h_min, k_s)
        return self.kernel("ais_reaction", system).value, system.values["k_h_min"], system.values["k_s"]

    def boundary_layer(self) -> Any:
        """Return the proved and compiled β(|σ*|)."""
        return self.kernel("boundary_layer", self.prove_boundary_layer()).value

    def prove_adaptive_gain(self) -> Any:
        """Prove what the rule file requires and return the fuzzy system F(σ*).

        Raises:
            DiagnosticError: When a guarantee is not proved.
        """
        system = self.system("fcafsmc", {})
        self._prove_guarantees("fcafsmc", system)
        return system

    def adaptive_gain(self) -> tuple[Any, Any, FloatArray, float, float]:
        """Return F = C·ξ(σ*), the rates of C, C(0), and the bounds every consequent is kept in."""
        system = self.prove_adaptive_gain()
        bound = self._bounds("fcafsmc", system)["F"]
        kernel = self.kernel("fcafsmc", system)
        return kernel.value, kernel.rates_value, kernel.initial_state(), bound.lo, bound.hi

    def proved(self, role: str) -> tuple[str, int, dict[str, float], float, float]:
        """Return what is proved of a rule file: output, number of rules, params, and least and greatest value.

        Raises:
            DiagnosticError: When the file has mistakes or does not fit the role.
        """
        system, output = self.system(role, {}), ROLES[role].output
        bound = self._bounds(role, system)[output]
        return output, len(system.rules), dict(system.values), bound.lo, bound.hi

    def system(self, role: str, own: Mapping[str, float]) -> Any:
        """Return the fuzzy system of a role with the scenario's params and a robot's own ones.

        Raises:
            DiagnosticError: When the file has mistakes, does not fit the role, or has no such param.
        """
        system, params = self._load(role), self.files[role].params
        unknown = sorted(set(params) - set(system.values))
        if unknown:
            raise DiagnosticError([self._unknown_param(role, name, tuple(system.values)) for name in unknown])
        derived = [d for p in system.params if p.name in params for d in self._derived(role, p)]
        if derived:
            raise DiagnosticError(derived)
        given = {**params, **own}
        if not given:
            self._require_coverage(role, system)
            return system
        key = (self.used[role].path, tuple(sorted(given.items())))
        if key not in self.known.changed:
            try:
                self.known.changed[key] = system.with_params(**given)
            except (UnknownNameError, ValueOutOfBoundsError) as error:
                raise DiagnosticError([Diagnostic("FZ905", str(error), file=str(self.used[role].path))]) from error
        changed = self.known.changed[key]
        self._require_coverage(role, changed)
        return changed

    def _load(self, role: str) -> Any:
        """Read and check the file of a role once, and remember its warnings."""
        path = self.used[role].path if role in self.used else self.path(role)
        if path not in self.known.systems:
            # Guarantees are proved at the values of each robot, see `_prove_guarantees`.
            system, told = fuzzyctl.check(path, guarantees=False)
            diagnostics = [d for d in told if d.severity != "hint"]
            if system is None:
                raise DiagnosticError(diagnostics)
            self.known.systems[path] = (system, _used(path), tuple(diagnostics))
        system, used, found = self.known.systems[path]
        if role not in self.used:
            _check_role(system, role, path)
            self.used[role] = used
            self.warnings += [d for d in found if d not in self.warnings]
        return system

    def _key(self, role: str, system: Any) -> Key:
        return self.used[role].path, tuple(sorted(system.values.items()))

    def _bounds(self, role: str, system: Any) -> Any:
        """Return the proved bounds of a system's outputs; equal params are proved once."""
        key = self._key(role, system)
        if key not in self.known.bounds:
            self.known.bounds[key] = fuzzyctl.output_bounds(system)
        return self.known.bounds[key]

    def _prove_guarantees(self, role: str, system: Any, where: str = "") -> None:
        """Refuse a system unless every `require` line of its file is proved at its params; equal ones are proved once.

        Args:
            role: Which file it came from.
            system: The system.
            where: The robot and the channel whose gains are its params.

        Raises:
            DiagnosticError: With each guarantee that is refuted, or that cannot be decided in time.
        """
        key = self.used[role].sha256, tuple(sorted(system.values.items()))
        if key not in self.known.verdicts:
            self.known.verdicts[key] = fuzzyctl.prove(system)
        broken = [v for v in self.known.verdicts[key] if not isinstance(v, fuzzyctl.Proved)]
        if broken:
            raise DiagnosticError([_unproved(v, str(self.used[role].path), where) for v in broken])

    def _require_coverage(self, role: str, system: Any) -> None:
        """Refuse a system that has no number as its output somewhere; params may have opened a hole.

        A hole whose `else` is a number is none: the number counts in the bounds.
        """
        from fuzzyctl.analysis import coverage
        from fuzzyctl.analysis.holes import Hole

        key = self._key(role, system)
        if key in self.known.sound:
            return
        found = [d for d in coverage.diagnostics(system) if d.severity == "error"]
        if found:
            raise DiagnosticError(found)
        (output,) = system.outputs
        hole = coverage.uncovered(system)[output.name]
        if hole is not None and output.otherwise in ("nan", "error"):
            message = (
                f"no rule fires for output '{output.name}' where {hole}, and 'else {output.otherwise}' is no number"
            )
            if not isinstance(hole, Hole):
                message = f"it is not proved that some rule always fires for output '{output.name}'"
            facts = ("a control law needs a number everywhere",)
            help_text = "let a term of the inputs reach there, or say 'else' with a number"
            path = str(self.used[role].path)
            raise DiagnosticError([Diagnostic("FZ401", message, output.span, facts=facts, help=help_text, file=path)])
        self.known.sound.add(key)

    def _derived(self, role: str, param: Any) -> list[Diagnostic]:
        """Refuse to set a param that the file computes from others, which would part it from them."""
        sources = dict.fromkeys(n.name for n in names_in(param.expression))
        if not sources:
            return []
        key = f"rules.{role}.{param.name}"
        message = f"{key} cannot be set: {self.used[role].path.name} computes {param.name} from {', '.join(sources)}"
        help_text = f"set {', '.join(sources)} instead"
        return [self.places.diagnostic("FZ904", key, message, help=help_text)]

    def _not_positive(
        self, role: str, name: str, value: float, robot: str, channel: str, own: Mapping[str, float]
    ) -> Diagnostic:
        """Describe a gain without which k̄_h − k_s sup f is no bound of G_AIS, at the place that gives it."""
        unit = "m/s" if channel == "v" else "rad/s"
        bad = f"must be > 0 {unit}, got {value:g}"
        facts = ("G_AIS = k_h - k_s f is least where f is greatest, and k_h >= k_h_min > 0, only for such gains",)
        if name in own:
            key = f"robots.{robot}.controllers.aifqsmc.{name}_{channel}"
            return self.places.diagnostic("FZ904", key, f"{key} {bad}", facts=facts)
        if name in self.files[role].params:
            key = f"rules.{role}.{name}"
            return self.places.diagnostic("FZ904", key, f"{key} {bad}", facts=facts)
        span: Span | None = next(p.span for p in self._load(role).params if p.name == name)
        return Diagnostic("FZ906", f"param {name} {bad}", span, facts=facts, file=str(self.used[role].path))

    def kernel(self, role: str, system: Any) -> Any:
        """Return the compiled kernel of a system; equal params are compiled once."""
        key = self._key(role, system)
        if key not in self.known.kernels:
            self.known.kernels[key] = fuzzyctl.compile(system)
        return self.known.kernels[key]

    def _unknown_param(self, role: str, name: str, known: tuple[str, ...]) -> Diagnostic:
        key = f"rules.{role}.{name}"
        message = f"{key}: {self.path(role).name} has no param {name!r}"
        facts = (f"its params are {', '.join(known)}",) if known else ("it has no params",)
        return self.places.diagnostic("FZ902", key, message, facts=facts, help=did_you_mean(name, known))


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


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # such as a name longer than the file system allows
        return False


def _check_role(system: Any, role: str, path: Path) -> None:
    """Refuse a system whose inputs and output are not those of its role, in that order."""
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


def _prove_gain(system: Any, bound: Any, robot: str, channel: str) -> None:
    """Refuse a run unless k̄_h − k_s sup f >= G_min > 0 follows from the bounds of f."""
    k_h_min, k_s, g_min = (system.values[name] for name in ("k_h_min", "k_s", "G_min"))
    smallest = k_h_min - k_s * bound.hi
    if g_min > TOLERANCE and smallest >= g_min - TOLERANCE:
        return
    facts = [
        f"robot {robot}, channel {channel}: k_h_min - k_s * sup f = {k_h_min:.6g} - {k_s:.6g} * {bound.hi:.6g} "
        f"= {smallest:.6g}, which must be >= G_min = {g_min:.6g}"
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
