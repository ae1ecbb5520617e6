"""New scenarios: a copy of a shipped one, or a file that extends it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from dwmr.config.shipped import SHIPPED, shipped_names
from dwmr.control.rule_files import LAWS
from dwmr.scenario.file import UnknownScenarioError, read
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.loading.assembly import files_read
from fuzzyctl.support.shipped import rules_folder


def files(name: str, base: str, path: Path, extends: bool) -> dict[Path, str]:
    """Return what is to be written, by path: the scenario first, then the CSV file that it reads.

    Args:
        name: The scenario's name.
        base: Name of the shipped scenario to start from.
        path: Where the scenario goes.
        extends: Whether it extends the shipped one instead of copying it.

    Raises:
        UnknownScenarioError: When there is no such shipped scenario.
    """
    _require_shipped(base)
    if extends:
        return {path: _EXTENDING.format(base=base, name=name)}
    text = (SHIPPED / f"{base}.toml").read_text(encoding="utf-8")
    renamed = re.sub(r'^name = ".*"$', f'name = "{name}"', text, count=1, flags=re.MULTILINE)
    beside = getattr(read(SHIPPED / f"{base}.toml").scenario.reference, "file", None)
    if beside is not None:
        renamed = renamed.replace(beside, f"{path.stem}.csv")
    head = f"# Made by `dwmr new` from {base}; `dwmr check {path.name}` finds mistakes.\n#\n"
    found = {path: head + renamed}
    if beside is not None:
        found[path.with_suffix(".csv")] = (SHIPPED / beside).read_text(encoding="utf-8")
    return found


def rule_files(base: str, folder: Path) -> dict[Path, str]:
    """Return copies of the rule files that a shipped scenario and the control laws use, by their path in a folder.

    Raises:
        UnknownScenarioError: When there is no such shipped scenario.
    """
    _require_shipped(base)
    named = read(SHIPPED / f"{base}.toml").scenario.rules.values()
    paths = {rules_folder() / name for name in (*(rule.file for rule in named), *LAWS.values())}
    paths |= {used for path in paths for used in files_read(path)}
    return {folder / path.name: path.read_text(encoding="utf-8") for path in sorted(paths)}


def _require_shipped(base: str) -> None:
    if base not in shipped_names():
        hint = did_you_mean(base, shipped_names())
        message = f"no shipped scenario {base[:200]!r}; there are {', '.join(shipped_names())}"
        raise UnknownScenarioError(message + (f"; {hint}" if hint else ""))


_EXTENDING = """\
# {name}: {base} with other values.
#
# What stands here replaces the value of {base}, key by key; lists such as obstacles are replaced whole. `dwmr show
# {base}` prints what it says.

extends = "{base}"
name = "{name}"

[run]
# horizon = 60.0                    # s
"""


def refuse_present(paths: Iterable[Path], force: bool, rules: Path | None = None) -> None:
    """Refuse to replace files, among them those of the folder of --rules.

    Raises:
        DiagnosticError: When one of them exists and `force` is not given.
    """
    present = [path for path in paths if path.exists() or path.is_symlink()]
    if present and not force:
        mistakes = []
        for path in present:
            other = "folder with --rules DIR" if path.parent == rules else "file with -o FILE"
            help_text = f"name another {other}, or replace it with --force"
            mistakes.append(Diagnostic("FZ005", f"{path} exists", help=help_text, file=str(path)))
        raise DiagnosticError(mistakes)
