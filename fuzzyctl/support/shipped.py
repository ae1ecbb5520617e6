"""Files shipped with the package, found in a wheel and in an editable install alike, and their names."""

from __future__ import annotations

import os
import re
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Final, NamedTuple

_PACKAGE: Final = Path(__file__).resolve().parents[1]
#: By group of shipped rule files and SPECs their folder, in a wheel and in a checkout, and the pattern of its files.
_GROUPS: Final = {
    "Rule files": (("rules", "../rules"), "*.fz"),
    "Loops": (("rules/loops", "../rules/loops"), "*.fz"),
    "Published loops": (("gallery", "../apps/gallery"), "*/*.fz"),
    "Sweeps": (("rules/loops", "../rules/loops"), "*.toml"),
}
#: A name: a word without separator and suffix.
_NAME: Final = re.compile(r"\w[\w-]*")

#: Command that lists the shipped files.
LIST: Final = "'fuzzyctl show' lists the shipped files"


class Place(NamedTuple):
    """The file that an argument means.

    Attributes:
        path: The file.
        name: Its name in messages.
        is_shipped: Whether it is a shipped file.
    """

    path: Path
    name: str
    is_shipped: bool


def rules_folder() -> Path:
    """Return the folder of the shipped rule files.

    Raises:
        FileNotFoundError: When the installation is not whole.
    """
    folder = _folder(_GROUPS["Rule files"][0])
    if folder is None:
        raise FileNotFoundError(f"the rule files are missing from the installation at {_PACKAGE}")
    return folder


def explanations_folder() -> Path | None:
    """Return the folder of the pages that explain diagnostic codes, or None when the installation has none."""
    return _folder(("explanations", "../docs/reference/diagnostics"))


def studio_folder() -> Path | None:
    """Return the folder of the studio that a checkout or the package `fuzzyctl-studio` has, or None."""
    spec = find_spec("fuzzyctl_studio")
    return _folder(("../apps/studio/dist", *((spec and spec.submodule_search_locations) or ())))


def _folder(places: tuple[str, ...]) -> Path | None:
    folders = (Path(os.path.normpath(_PACKAGE / place)) for place in places)
    return next((folder for folder in folders if folder.is_dir()), None)


@lru_cache(maxsize=1)
def shipped_groups() -> dict[str, dict[str, Path]]:
    """Return the shipped files by group and name."""
    folders = {group: (_folder(places), pattern) for group, (places, pattern) in _GROUPS.items()}
    return {
        group: {path.stem: path for path in sorted(folder.glob(pattern))} if folder is not None else {}
        for group, (folder, pattern) in folders.items()
    }


def shipped_files(suffix: str = ".fz") -> dict[str, Path]:
    """Return the shipped files with a suffix by name."""
    groups = shipped_groups().values()
    return {name: path for files in groups for name, path in files.items() if path.suffix == suffix}


def is_name(text: str) -> bool:
    """Return whether a text may name a shipped file: a word without separator and suffix."""
    return _NAME.fullmatch(text) is not None


def place_of(file: str | os.PathLike[str], suffix: str = ".fz", folder: Path | None = None) -> Place:
    """Return the file that an argument means.

    A name such as `tipper` is the file `tipper` or `tipper.fz` if there is one, else the shipped file of this name and
    suffix; anything else is a path. Both are from a folder; without one from the current one.
    """
    name = os.fspath(file)
    local = name if folder is None else os.fspath(folder / name)
    if not is_name(name) or (os.path.exists(local) and not os.path.isdir(local)):
        return Place(Path(local), local, False)
    beside, path = f"{local}{suffix}", shipped_files(suffix).get(name)
    if os.path.exists(beside) and not os.path.isdir(beside) and (path is None or not os.path.samefile(beside, path)):
        return Place(Path(beside), beside, False)
    return Place(path or Path(local), name, path is not None)


def first_sentence(path: Path) -> str:
    """Return the first sentence of the comment at the head of a file."""
    lines = path.read_text(encoding="utf-8").splitlines()
    comment = next((k for k, line in enumerate(lines) if not line.startswith("# ")), len(lines))
    text = " ".join(line.removeprefix("# ") for line in lines[:comment])
    end = text.find(". ")
    return text[: end + 1] if end >= 0 else text
