"""Control laws: the shipped ones, and the user's in a file beside the scenario.

A control law is a controller of a rule file, see `text_law`, or a Python module, see `python_law`. Either has

- `Settings`, a frozen pydantic model of its gains;
- `SIGNALS`, a tuple of `Signal`: what `step` records;
- `FAULTS`, messages by the fault numbers that `step` may return;
- `init(settings, rules, robot) -> Law`, the flat gains, the initial state and the gain kernels of one robot;
- `step`, decorated with `control_law`.

A law named BASE_without_PART is an ablation: BASE with one part switched off, with the gains of BASE where the scenario
gives it none. Of a law as text it is the same text with its param PART set to 0.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dwmr.control.rule_files import LAWS
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.support.files import first_sentence, rules_folder

if TYPE_CHECKING:
    from dwmr.control.fuzzy_gains import Rules

#: The complete laws of the paper.
PAPER = ("aifqsmc", "fcafsmc", "smc")
#: The shipped laws in Python, modules of this package.
IN_PYTHON = ("mpc",)
_WITHOUT = "_without_"
#: The shipped ablations.
_ABLATIONS = tuple(f"aifqsmc{_WITHOUT}{part}" for part in ("adaptation", "immunity", "layer"))

#: Words that stand for several laws on the command line.
GROUPS = ("all", "ablations")


def names() -> tuple[str, ...]:
    """Return the names of all shipped control laws."""
    return tuple(sorted((*LAWS, *_ABLATIONS, *IN_PYTHON)))


def base(name: str) -> str:
    """Return the law whose gains a law falls back on: of an ablation the law it is taken from, else itself."""
    return name.partition(_WITHOUT)[0]


def zeroed(name: str) -> str:
    """Return the param that an ablation sets to 0, an empty string for any other law."""
    return name.partition(_WITHOUT)[2]


def shipped_file(name: str) -> str:
    """Return the name of the file of a shipped control law."""
    return f"{name}.py" if name in IN_PYTHON else LAWS[base(name)]


def first_sentence_of(name: str) -> str:
    """Return the first sentence of the file of a shipped control law."""
    if name not in IN_PYTHON:
        return first_sentence(rules_folder() / shipped_file(name))
    text = Path(__file__).with_name(f"{name}.py").read_text(encoding="utf-8")
    return text.removeprefix('"""').partition("\n")[0]


def table(tables: Mapping[str, Any], law: str) -> tuple[str, Any]:
    """Return name and content of the table a law has its gains from, of a robot's `controllers`; None without one.

    An ablation without a table has that of the law it is taken from.
    """
    return (law, tables[law]) if law in tables else (base(law), tables.get(base(law)))


def group(name: str) -> tuple[str, ...]:
    """Return the laws a word of the command line stands for.

    Args:
        name: "all" for every complete law of the paper, "ablations" for those with a part switched off,
            each beside the law it is taken from; or the name of one law.
    """
    if name == "all":
        return PAPER
    if name == "ablations":
        return tuple(dict.fromkeys(one for n in names() if base(n) != n for one in (base(n), n)))
    return (name,)


def exists(name: str, folder: Path) -> bool:
    """Return whether there is a law of this name: shipped, or as NAME.fz or NAME.py in the folder of a scenario."""
    return name in names() or python_file(name, folder) is not None or _is_file(base(name), ".fz", folder)


def python_file(name: str, folder: Path) -> Path | None:
    """Return the file of a user's law in Python; None for any other law."""
    return None if name in names() or not _is_file(name, ".py", folder) else (folder / f"{name}.py").resolve()


def find(name: str, folder: Path, rules: Rules) -> Any:
    """Return a control law by its name: a `TextLaw`, or the module of a law in Python, which is imported.

    Args:
        name: Name of the law.
        folder: Folder of the scenario.
        rules: Rule files of the scenario.

    Raises:
        DiagnosticError: When a file in Python cannot be imported or lacks a part of a control law; when there are two.
    """
    if name in IN_PYTHON:
        return import_module(f"{__name__}.{name}")
    path = python_file(name, folder)
    if path is None:
        from dwmr.control.laws import text_law

        law = base(name)
        return text_law.TextLaw(name, zeroed(name), LAWS.get(law, f"{law}.fz"), rules)
    if _is_file(base(name), ".fz", folder):
        message = f"the control law {name} is in two files, {path.name} and {base(name)}.fz"
        raise DiagnosticError([Diagnostic("FZ905", message, help="rename one of them", file=str(path))])
    from dwmr.control.laws import python_law

    return python_law.load(name, path)


def _is_file(name: str, suffix: str, folder: Path) -> bool:
    """Return whether a folder holds a file of a law; only a name that Python could import is looked for."""
    # Not Path.is_file, which raises for names that are too long.
    return name.isidentifier() and os.path.isfile(folder / f"{name}{suffix}")
