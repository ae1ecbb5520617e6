"""Rule files: the shipped ones and their names, and the reading of texts and numbers."""

from __future__ import annotations

import math
import os
import re
import stat
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, Final, NamedTuple

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.diagnostics.suggestions import closest

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


#: Largest file that is read, in bytes, unless the caller says otherwise.
MAX_BYTES: Final = 1 << 20

#: Suffixes of files of other tools, which often are not UTF-8.
FOREIGN: Final = frozenset({".fll", ".fis", ".fcl", ".fml", ".xml"})


#: The files that are read while `recorded` is entered.
_RECORDED: ContextVar[dict[str, bytes] | None] = ContextVar("recorded", default=None)


@contextmanager
def recorded() -> Iterator[dict[str, bytes]]:
    """Collect the files that are read meanwhile: their content by path, in the order of reading."""
    results: dict[str, bytes] = {}
    token = _RECORDED.set(results)
    try:
        yield results
    finally:
        _RECORDED.reset(token)


#: Texts that stand for files while `overlaid` is entered, by absolute path.
_OVERLAID: ContextVar[Mapping[str, str] | None] = ContextVar("overlaid", default=None)


@contextmanager
def overlaid(texts: Mapping[str, str]) -> Iterator[None]:
    """Read texts in place of files meanwhile: those that an editor shows and has not saved, by absolute path."""
    token = _OVERLAID.set(texts)
    try:
        yield
    finally:
        _OVERLAID.reset(token)


def read_source(path: str | os.PathLike[str], *, max_bytes: int = MAX_BYTES, only_regular: bool = False) -> SourceText:
    """Read a file as text.

    A byte order mark is dropped; lines may end with LF or CRLF. Files of other tools may be UTF-16 with such a mark, or
    Windows-1252 in place of UTF-8, and lines may end with CR.

    Args:
        path: The file, or the name of a shipped one.
        max_bytes: Largest size that is read.
        only_regular: Whether names of shipped files are refused, and pipes and devices, which can block for ever: set
            for names that come from a file. A user may name a pipe, such as `<(command)` of a shell.

    Raises:
        DiagnosticError: When the file is missing, a directory, unreadable, too large or not UTF-8 text.
        ArgumentError: For an object that is not a path.
    """
    data, place = read_place(path, max_bytes=max_bytes, only_regular=only_regular)
    return decode(data, place.name)


def read_place(
    path: str | os.PathLike[str], *, max_bytes: int = MAX_BYTES, only_regular: bool = False
) -> tuple[bytes, Place]:
    """Read a file as `read_source` does, without decoding it; return its place, too."""
    given: object = path  # whatever the annotation says, callers pass None and bytes
    name = os.fspath(given) if isinstance(given, str | os.PathLike) else None
    if not isinstance(name, str) or "\0" in name:
        raise ArgumentError(f"expected the path of a rule file, got {path!r:.80}; 'loads' takes texts")
    if only_regular and is_special(name):
        raise DiagnosticError([Diagnostic("FZ001", "this is not a regular file", file=name)])
    place = Place(Path(name), name, False) if only_regular else place_of(name)
    texts = _OVERLAID.get()
    shown = texts.get(os.path.abspath(place.path)) if texts else None
    try:
        # A pipe may have taken the place of the file by now: it is opened without waiting for its writer.
        way = _at_once if only_regular else None
        with (
            open(name if only_regular else place.path, "rb", opener=way)
            if shown is None
            else BytesIO(shown.encode("utf-8", "replace")) as file
        ):
            if only_regular and shown is None and not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise DiagnosticError([Diagnostic("FZ001", "this is not a regular file", file=name)])
            content = read_bytes(file, place.name, max_bytes=max_bytes)
    except OSError as error:
        # A file that names a table of data means no rule file.
        is_rule_file = not only_regular or Path(name).suffix.lower() in {"", ".fz", *FOREIGN}
        raise DiagnosticError([_unreadable(name, error, suggests=is_rule_file)]) from None
    record = _RECORDED.get()
    if record is not None:
        record[os.fspath(place.path) if place.is_shipped else place.name] = content
    return content, place


def _at_once(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def record_file(path: str | os.PathLike[str]) -> None:
    """Keep the content of a file that is not read as text, such as an FMU, where reading is recorded."""
    record = _RECORDED.get()
    if record is not None:
        record[os.fspath(path)] = Path(path).read_bytes()


def read_bytes(stream: BinaryIO, name: str, *, max_bytes: int = MAX_BYTES) -> bytes:
    """Read a stream, without decoding it; `name` is shown in diagnostics.

    Raises:
        DiagnosticError: For more than `max_bytes`.
    """
    data = stream.read(max_bytes + 1)
    if len(data) > max_bytes:
        message = f"the file is larger than {max_bytes:,} bytes"
        help_text = (
            "in a .fz file, write rules as tables; those of a third input as slices, 'with INPUT is TERM' above each"
        )
        raise DiagnosticError([Diagnostic("FZ003", message, file=name, help=help_text)])
    return data


def is_below(path: str | os.PathLike[str], folder: str | os.PathLike[str]) -> bool:
    """Return whether a path leads into a folder, by its name and by its links.

    By its name first: on Windows a look at `//HOST/SHARE` already calls that host.
    """
    # Not Path.resolve, which raises for links in a circle.
    ways = (os.path.abspath, os.path.realpath)
    if "\0" in f"{path}{folder}":
        return False
    pairs = ([os.path.normcase(way(p)) for p in (path, folder)] for way in ways)
    return all(inner == outer or inner.startswith(os.path.join(outer, "")) for inner, outer in pairs)


def is_special(path: str | os.PathLike[str]) -> bool:
    """Return whether a path names a pipe, a device or a socket."""
    return os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path)


def decode(data: bytes, name: str) -> SourceText:
    """Return bytes as a source text; raises `DiagnosticError` when they are not UTF-8 text."""
    if Path(name).suffix.lower() in FOREIGN:
        return _decoded(data, name)
    return _utf8(data, name)


def _decoded(data: bytes, name: str) -> SourceText:
    """Return the text of a file of another tool, whatever its encoding."""
    source = None
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        try:
            text = data.decode("utf-16")
            if "\0" in text:  # the mark of UTF-32 begins with that of UTF-16
                message = "the file is not text: its byte order mark says UTF-16, but a character is NUL"
                raise DiagnosticError([Diagnostic("FZ002", message, file=name, help="save it as UTF-8")])
            source = SourceText(name, text, "UTF-16")
        except UnicodeDecodeError:
            message = "the file is not text: its byte order mark says UTF-16, but its bytes are not UTF-16"
            raise DiagnosticError([Diagnostic("FZ002", message, file=name, help="save it as UTF-8")]) from None
    try:
        source = source or _utf8(data, name)
    except DiagnosticError:
        if b"\x00" in data:
            raise
        source = SourceText(name, data.decode("cp1252", errors="replace"), "Windows-1252")
    if "\r" in source.text and "\n" not in source.text:
        return SourceText(name, source.text.replace("\r", "\n"), source.encoding)
    return source


def _utf8(data: bytes, name: str) -> SourceText:
    nul = data.find(b"\x00")
    try:
        if nul >= 0:
            message = f"the file is not text: byte {nul} is NUL"
            raise DiagnosticError([Diagnostic("FZ002", message, file=name, help="give a text file in UTF-8")])
        return SourceText(name, data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        message = f"the file is not UTF-8: byte 0x{data[error.start]:02x} in line {line}"
        raise DiagnosticError([Diagnostic("FZ002", message, file=name, help="save it as UTF-8")]) from None


def _unreadable(name: str, error: OSError, *, suggests: bool) -> Diagnostic:
    if isinstance(error, FileNotFoundError):
        return Diagnostic("FZ001", "there is no such file", file=name, help=_neighbours(name) if suggests else "")
    if isinstance(error, IsADirectoryError):
        return Diagnostic("FZ001", "this is a directory, not a rule file", file=name, help="name the files in it")
    return Diagnostic("FZ001", f"the file cannot be read: {error.strerror}", file=name)


def _neighbours(name: str) -> str:
    """Name the rule file that was most likely meant."""
    folder, stem = Path(name).parent, Path(name).stem
    suffixes = FOREIGN | {".fz"} if Path(name).suffix.lower() in FOREIGN else {".fz"}
    files = files_in(folder, suffixes)
    if is_name(name):
        near = closest(name, [*(Path(file).stem for file in files), *shipped_files()])
        if near is None:
            return LIST
        return f"did you mean '{near}.fz'?" if f"{near}.fz" in files else f"did you mean the shipped '{near}'? {LIST}"
    shipped = shipped_files() if Path(name).suffix.lower() in ("", ".fz") else {}
    near = None if stem in shipped else closest(Path(name).name, files)
    if near:
        return f"did you mean '{folder / near}'?"
    near = closest(stem, shipped)
    return f"did you mean the shipped '{near}'? {LIST}" if near else ""


def files_in(folder: Path, suffixes: Collection[str]) -> list[str]:
    """Return the names in a folder that end with one of some suffixes, sorted; none where it cannot be listed."""
    try:
        return sorted(name for name in os.listdir(folder) if Path(name).suffix.lower() in suffixes)
    except OSError:
        return []


#: Pattern of a number; Python's `float` also takes underscores and the digits of all scripts.
_NUMBER: Final = re.compile(
    r"[ \t\r\n]*[+-]?((?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?|inf|infinity|nan)[ \t\r\n]*", re.ASCII | re.IGNORECASE
)

#: The message on a number that no double can hold.
TOO_LARGE: Final = "a double cannot hold this number"


def to_number(text: str) -> float:
    """Read a number; `inf` and `nan` are numbers, a literal that overflows is not.

    Raises:
        OverflowError: For a number that a double cannot hold.
        ValueError: For a text that is not a number.
    """
    if _NUMBER.fullmatch(text) is None:
        raise ValueError(text)
    value = float(text)
    if math.isinf(value) and any(c in "0123456789" for c in text):
        raise OverflowError(TOO_LARGE)
    return value
