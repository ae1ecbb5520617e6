"""Rule files of a scenario: their settings, search, checksums and params."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from pydantic import ConfigDict, Field

from dwmr.config.quantities import Section
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.loading.assembly import files_read
from fuzzyctl.support.files import is_special, rules_folder

if TYPE_CHECKING:
    from fuzzyctl.experiments.scenario_keys import Places


class RuleFile(Section):
    """A rule file and values for its params."""

    model_config = ConfigDict(frozen=True, extra="allow", allow_inf_nan=False, strict=True)
    __pydantic_extra__: dict[str, float] = Field(init=False)

    file: str = Field(description="name of the rule file", min_length=1)

    @property
    def params(self) -> dict[str, float]:
        """Values for params of the file, by name."""
        return {name: float(value) for name, value in (self.__pydantic_extra__ or {}).items()}


#: Files of the shipped control laws.
LAWS = {
    "ackermann": "ackermann.fz",
    "aifqsmc": "aifqsmc.fz",
    "backstepping": "backstepping.fz",
    "fcafsmc": "fcafsmc_law.fz",
    "kanayama": "kanayama.fz",
    "omnidirectional": "omnidirectional.fz",
    "smc": "smc.fz",
    "super_twisting": "super_twisting.fz",
}


#: Roles of rule files that the shipped control laws call.
ROLES = ("ais_reaction", "boundary_layer", "fcafsmc")


class Used(NamedTuple):
    """A rule file that serves in a role: its place and its contents.

    Attributes:
        path: The file.
        sha256: Of the file and, after one another, of all files that it brings in.
        files: Checksum of each of these files by name, as seen from the folder of the first.
    """

    path: Path
    sha256: str
    files: Mapping[str, str]


def read_whole(path: Path, without: Collection[Path] = (), roles: Mapping[str, Used] | None = None) -> Used:
    """Return a rule file with the checksums of all that it reads.

    Args:
        path: The file.
        without: Files that it names and that do not count, as others replace them.
        roles: These others, by role.
    """
    names = {path.name: path} | {str(p.relative_to(path.parent)): p for p in files_read(path, without)}
    for role, used in (roles or {}).items():
        names |= {f"{role}/{name}": used.path.parent / name for name in used.files}
    contents = {name: one.read_bytes() for name, one in names.items()}
    files = {name: hashlib.sha256(content).hexdigest() for name, content in contents.items()}
    return Used(path, hashlib.sha256(b"".join(contents.values())).hexdigest(), files)


class RuleFiles:
    """The rule files that a scenario names.

    Args:
        named: File and params by role, as the scenario gives them.
        folders: Where to look for a file, first match wins; the shipped rules come last.
        places: Locations of the scenario's keys, for diagnostics.
    """

    def __init__(self, named: Mapping[str, RuleFile], folders: tuple[Path, ...], places: Places) -> None:
        self.named, self.folders, self.places = named, folders, places

    def params(self, role: str) -> Mapping[str, float]:
        """Return the params that the scenario sets in the file of a role; none where it names no such file."""
        return self.named[role].params if role in self.named else {}

    def path(self, role: str) -> Path:
        """Return the file that serves in a role.

        Raises:
            DiagnosticError: When the scenario names none, or none is found.
        """
        if role not in self.named:
            raise DiagnosticError([self.places.diagnostic("FZ903", f"rules.{role}", f"rules.{role}.file is missing")])
        key, name = f"rules.{role}.file", self.named[role].file
        return self._found(name, key, f"{key} = {name!r} names a rule file that does not exist")

    def law(self, name: str) -> Path:
        """Return the file of a control law that is text.

        Raises:
            DiagnosticError: When none is found.
        """
        return self._found(name, "run.controller", f"the control law {name} does not exist")

    def _found(self, name: str, key: str, missing: str) -> Path:
        folders = (*self.folders, rules_folder())
        for folder in folders:
            if _exists(folder / name):
                if is_special(folder / name):  # reading could block for ever
                    message = f"{key}: {folder / name} is not a regular file"
                    raise DiagnosticError([self.places.diagnostic("FZ904", key, message)])
                return folder / name
        looked = f"looked in {', '.join(str(f) for f in folders)}"
        raise DiagnosticError([self.places.diagnostic("FZ904", key, missing, facts=(looked,))])

    def require_use_of(self, folder: Path) -> None:
        """Refuse a folder of rule files that holds none of the files the scenario names.

        Raises:
            DiagnosticError: Naming the files that were looked for.
        """
        wanted = self._wanted()
        if not self.named or any(_exists(folder / name) for name in wanted):
            return
        present = sorted(p.name for p in folder.glob("*.fz"))
        near = next((n for n in (closest(p, wanted) for p in present) if n is not None), None)
        facts = [f"looked for {', '.join(wanted)}"]
        facts.append(f"the folder holds {', '.join(present)}" if present else "the folder holds no rule files")
        help_text = f"did you mean '{near}'?" if near else "copy the files to change from the folder rules"
        message = f"--rules {folder} holds no rule file of this scenario"
        raise DiagnosticError([Diagnostic("FZ905", message, facts=tuple(facts), help=help_text, file=str(folder))])

    def _wanted(self) -> list[str]:
        """Return the names of the files that a folder may replace."""
        return [*(rule.file for rule in self.named.values()), *LAWS.values()]

    def near_misses(self, folder: Path) -> list[Diagnostic]:
        """Warn of rule files in a folder that are named almost like one that the scenario takes from elsewhere."""
        wanted = self._wanted()
        missing = [name for name in wanted if not _exists(folder / name)]
        warnings = []
        for path in sorted(folder.glob("*.fz")):
            near = closest(path.name, missing) if path.name not in wanted else None
            if near is not None:
                message = f"{path.name} is not used: the scenario names no such file"
                warnings.append(
                    Diagnostic("FZ905", message, severity="warning", help=f"did you mean '{near}'?", file=str(path))
                )
        return warnings

    def unknown_param(self, key: str, file: Path, known: tuple[str, ...]) -> Diagnostic:
        """Describe a param that a key of the scenario sets and a rule file does not declare."""
        facts = (f"its params are {', '.join(known)}",) if known else ("it has no params",)
        message = f"{key}: {file.name} has no param {key.rpartition('.')[2]!r}"
        return self.places.diagnostic("FZ902", key, message, facts=facts, help=self.places.did_you_mean(key, known))

    def wrong_gain(self, name: str, robot: str, gain: str, reason: str) -> Diagnostic:
        """Describe a gain of a robot that the text of its control law does not admit."""
        key = self.key_of_gain(robot, name, gain)
        return self.places.diagnostic("FZ904", key, f"{key} {reason}")

    def key_of_gain(self, robot: str, name: str, gain: str) -> str:
        """Return the key of a gain as the scenario has it: of the robot, or of all robots."""
        return self.places.resolve(("robots", robot, "controllers", name, gain))[0]

    def computed_param(self, role: str, name: str, sources: Sequence[str]) -> Diagnostic:
        """Describe a param that the scenario sets and the file of a role computes from others."""
        key = f"rules.{role}.{name}"
        message = f"{key} cannot be set: {self.path(role).name} computes {name} from {', '.join(sources)}"
        return self.places.diagnostic("FZ904", key, message, help=f"set {', '.join(sources)} instead")


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # such as a name longer than the file system allows
        return False
