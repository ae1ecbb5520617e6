"""Description and files of an FMU, read without loading its code."""

from __future__ import annotations

import os
import platform
import re
import stat
import sys
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Final
from xml.parsers import expat

from fuzzyctl.diagnostics.diagnostic import FuzzyctlError
from fuzzyctl.lang import syntax as sx
from fuzzyctl.records import dataclass

#: Deepest nesting of elements.
DEEPEST: Final = 100


@dataclass(frozen=True)
class Element:
    """An element: its name, its attributes, and how many others it lies in."""

    name: str
    attributes: dict[str, str]
    depth: int


def elements(text: bytes) -> Iterator[Element]:
    """Yield the elements in the order of their begins.

    Raises:
        ValueError: For broken XML, a document type, and deep nesting.
    """
    tags: list[Element] = []
    depth = 0
    parser = expat.ParserCreate()

    def begin(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        if depth == DEEPEST:
            raise ValueError(f"elements lie more than {DEEPEST} levels inside each other")
        tags.append(Element(name, attributes, depth))
        depth += 1

    def end(_: str) -> None:
        nonlocal depth
        depth -= 1

    def document_type(*_: object) -> None:
        raise ValueError("it declares a document type, which FMI has none of")

    parser.StartElementHandler, parser.EndElementHandler = begin, end
    parser.StartDoctypeDeclHandler = document_type
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise ValueError(f"{expat.ErrorString(error.code)} in line {error.lineno}") from None
    except LookupError as error:  # an encoding that Python does not know
        raise ValueError(str(error)) from None
    yield from tags


#: Most files of an FMU, and most bytes of them together and of its description.
MOST_FILES: Final = 20_000
MOST_BYTES: Final = 1 << 30
MOST_TEXT: Final = 64 << 20
#: Value references have 32 bits.
_LARGEST_REFERENCE: Final = (1 << 32) - 1
#: Folders of the binaries of this machine, of FMI 2 and 3.
_SYSTEMS: Final = {"linux": "linux", "darwin": "darwin", "win32": "win"}
_MACHINES: Final = {"x86_64": "x86_64", "amd64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64"}


class FmuError(FuzzyctlError):
    """Raised for a file that is not an FMU for co-simulation.

    Args:
        message: The mistake.
        facts: Facts about the file.
        help_text: What to do.
    """

    def __init__(self, message: str, facts: tuple[str, ...] = (), help_text: str = "") -> None:
        super().__init__(message)
        self.message, self.facts, self.help_text = message, facts, help_text


@dataclass(frozen=True)
class FmuVariable:
    """A real variable of an FMU.

    Args:
        name: In the FMU.
        identifier: In rule files, which have letters, digits and underscores only.
        reference: Its number.
        label: Description for people.
        unit: Its unit.
    """

    name: str
    identifier: str
    reference: int
    label: str = ""
    unit: str = ""


@dataclass(frozen=True)
class FmuDescription:
    """Description of an FMU.

    Args:
        path: The file.
        version: 2 or 3, of FMI.
        model: Name of the binary.
        inputs: Its real inputs.
        outputs: Its real outputs.
        params: Its real parameters that can be set.
        platforms: Folders of its binaries.
        has_sources: Whether it holds C.
    """

    path: str
    version: int
    model: str
    inputs: tuple[FmuVariable, ...]
    outputs: tuple[FmuVariable, ...]
    params: tuple[FmuVariable, ...]
    platforms: tuple[str, ...]
    has_sources: bool

    @property
    def platform(self) -> str:
        """The folder of this machine's binary."""
        system, machine = _SYSTEMS.get(sys.platform, sys.platform), platform.machine().lower()
        if self.version == 2:
            return f"{system}{64 if sys.maxsize > 2**32 else 32}"
        return f"{_MACHINES.get(machine, machine)}-{'windows' if system == 'win' else system}"

    def missing_binary(self) -> FmuError | None:
        """Return the error of an FMU without a binary for this machine, or None."""
        if self.platform in self.platforms:
            return None
        facts = (f"it has binaries for: {', '.join(self.platforms) or 'no machine'}; this is {self.platform}",)
        compiled = f"it holds its source; compile that: fmpy compile {Path(self.path).name}"
        help_text = compiled if self.has_sources else "export it on this machine"
        return FmuError("the FMU has no binary for this machine", facts, help_text)


def read_description(path: str) -> FmuDescription:
    """Read the description of an FMU.

    Raises:
        FmuError: If the file is not an FMU for co-simulation.
    """
    with _opened(path) as archive:
        names = archive.namelist()
        if "modelDescription.xml" not in names:
            raise FmuError("the archive has no modelDescription.xml, so it is not an FMU", help_text="export it again")
        if archive.getinfo("modelDescription.xml").file_size > MOST_TEXT:
            raise FmuError(f"modelDescription.xml has more than {MOST_TEXT:,} bytes")
        try:
            text = archive.read("modelDescription.xml")
        except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError) as error:
            raise FmuError(f"modelDescription.xml cannot be unpacked: {error}", help_text="export it again") from None
    try:
        tags = list(elements(text))
    except ValueError as error:
        raise FmuError(f"modelDescription.xml cannot be read: {error}", help_text="export it again") from None
    return _described(path, tags, names)


def unpack(path: str, folder: Path) -> None:
    """Unpack an FMU whose names and sizes are in order.

    Raises:
        FmuError: For an archive that is broken.
    """
    with _opened(path) as archive:
        try:
            archive.extractall(folder)
        except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError) as error:
            raise FmuError(f"the archive cannot be unpacked: {error}", help_text="export it again") from None


def _opened(path: str) -> zipfile.ZipFile:
    """Open an archive none of whose files would be written elsewhere, or fill the disk."""
    if os.path.exists(path) and not os.path.isfile(path):
        raise FmuError("this is not a regular file")
    try:
        archive = zipfile.ZipFile(path)
    except zipfile.BadZipFile:
        raise FmuError("the file is not a zip archive, so it is not an FMU", help_text="export it again") from None
    except FileNotFoundError:
        raise FmuError("there is no such file") from None
    except OSError as error:
        raise FmuError(f"the file cannot be read: {error.strerror or error}") from None
    try:
        _require_harmless(archive.infolist())
    except FmuError:
        archive.close()
        raise
    return archive


def _require_harmless(files: list[zipfile.ZipInfo]) -> None:
    help_text = "no FMU needs that: ask who made it"
    size = sum(f.file_size for f in files)
    if len(files) > MOST_FILES or size > MOST_BYTES:
        facts = (f"it would unpack to {len(files):,} files of {size:,} bytes",)
        message = f"the archive is larger than {MOST_FILES:,} files or {MOST_BYTES:,} bytes"
        raise FmuError(message, facts, help_text)
    for file in files:
        name = file.orig_filename
        parts = PurePosixPath(name.replace("\\", "/")).parts
        if not parts or ".." in parts or parts[0].startswith("/") or ":" in name or "\0" in name or "\\" in name:
            raise FmuError(f"the archive has a file {name!r:.80}, which leads out of its folder", (), help_text)
        if stat.S_ISLNK(file.external_attr >> 16):
            raise FmuError(f"the archive has a link {name!r:.80}", (), help_text)
        if file.flag_bits & 1:
            raise FmuError("the archive is encrypted", (), "unpack it with its password, and zip it anew")


def _described(path: str, found: list[Element], names: list[str]) -> FmuDescription:
    if not found or found[0].name != "fmiModelDescription":
        raise FmuError("modelDescription.xml describes no FMU", help_text="export it again")
    version = found[0].attributes.get("fmiVersion", "")
    if not re.match(r"[23]\.\d", version):
        message = f"the FMU is one of FMI {version or '(no version)'}, not 2.0 or 3.0"
        raise FmuError(message, help_text="export it anew")
    interface = next((e for e in found if e.name == "CoSimulation"), None)
    if interface is None:
        kinds = [kind for kind in ("ModelExchange", "ScheduledExecution") if any(e.name == kind for e in found)]
        facts = (f"it is for: {', '.join(kinds)}",) if kinds else ()
        raise FmuError("the FMU is not for co-simulation", facts, "export it for co-simulation")
    model = interface.attributes.get("modelIdentifier", "")
    if not re.fullmatch(r"[A-Za-z_]\w*", model, re.ASCII):
        raise FmuError(f"the FMU has the model identifier {model!r:.60}, which is not a name in C")
    variables = list(_variables(found, int(version[0])))
    kinds_of = {kind: [e for e in variables if e.attributes.get("causality") == kind] for kind in _KINDS}
    interfaces = {kind: tuple(_variable(e) for e in of) for kind, of in kinds_of.items()}
    _require_names([v for of in interfaces.values() for v in of])
    if not interfaces["output"]:
        raise FmuError("the FMU has no real output", help_text="choose outputs when it is exported")
    parts = [PurePosixPath(name).parts for name in names]
    binaries = [p for p in parts if len(p) == 3 and p[0] == "binaries" and PurePosixPath(p[2]).stem == model]
    sources = any(p[0] == "sources" and p[-1].endswith(".c") for p in parts)
    ordered = (interfaces["input"], interfaces["output"], interfaces["parameter"])
    return FmuDescription(path, int(version[0]), model, *ordered, tuple(dict.fromkeys(p[1] for p in binaries)), sources)


_KINDS: Final = ("input", "output", "parameter")


def _variables(found: list[Element], version: int) -> Iterator[Element]:
    """Yield the real scalars; of FMI 2 with the attributes of their type."""
    for k, element in enumerate(found):
        if element.name not in ("ScalarVariable", "Float64"):
            continue
        inner = {}
        j = k + 1
        while j < len(found) and found[j].depth > element.depth:
            inner[found[j].name] = found[j]
            j += 1
        if version == 2 and "Real" in inner:
            yield Element("Real", {**inner["Real"].attributes, **element.attributes}, element.depth)
        elif version == 3 and element.name == "Float64" and "Dimension" not in inner:
            yield element


def _variable(element: Element) -> FmuVariable:
    attributes = element.attributes
    name, reference = attributes.get("name", ""), attributes.get("valueReference", "")
    if not (re.fullmatch(r"\d{1,10}", reference, re.ASCII) and int(reference) <= _LARGEST_REFERENCE):
        raise FmuError(f"variable {name!r:.60} of the FMU has no value reference from 0 to {_LARGEST_REFERENCE:,}")
    return FmuVariable(
        name, identifier(name), int(reference), attributes.get("description", ""), attributes.get("unit", "")
    )


def identifier(name: str) -> str:
    """Return the name of a variable in rule files: `body.x[1]` is `body_x_1`."""
    text = re.sub(r"\W+", "_", name).strip("_")
    text = text if text and not text[0].isdigit() else f"v{text}"
    return f"{text}_" if text in sx.RESERVED or not text.isidentifier() else text


def _require_names(variables: list[FmuVariable]) -> None:
    names: dict[str, str] = {}
    for v in variables:
        if v.identifier in names:
            message = f"variables '{names[v.identifier]}' and '{v.name}' of the FMU would both be '{v.identifier}'"
            raise FmuError(message, (), "rename one of them where the FMU is made")
        names[v.identifier] = v.name
