"""FMU as an archive: descriptions, sources, and the binary of this machine."""

from __future__ import annotations

import io
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fuzzyctl.codegen.fmu.binary import compiler, library_path, shared_library
from fuzzyctl.codegen.fmu.description import build_description, model_description, page
from fuzzyctl.codegen.fmu.model import Model
from fuzzyctl.codegen.fmu.model_header import model_header

#: Versions of FMI that are written.
VERSIONS: Final = (2, 3)
_SHARED: Final = Path(__file__).parent / "c"
#: Time of all files in the archive, so that the same text gives the same FMU.
_TIME: Final = (1980, 1, 1, 0, 0, 0)


@dataclass(frozen=True)
class Fmu:
    """An FMU.

    Args:
        data: The bytes of the archive.
        binary: Where the binary lies in it, an empty string for none.
        missing: Why there is no binary, an empty string where there is one.
    """

    data: bytes
    binary: str
    missing: str


def sources(model: Model, version: int) -> dict[str, str]:
    """Return the C files of an FMU by name.

    Args:
        model: What it computes.
        version: 2 or 3, of FMI.
    """
    names = ("fmu_core.h", *model.shared, f"fmi{version}.c")
    shared = {name: (_SHARED / name).read_text(encoding="utf-8") for name in names}
    return {**model.sources, "fmu_model.h": model_header(model), **shared}


def fmu(model: Model, version: int) -> Fmu:
    """Return an FMU; without a compiler one of sources only.

    Args:
        model: What it computes.
        version: 2 or 3, of FMI.

    Raises:
        CodegenError: Where the compiler fails.
    """
    texts = sources(model, version)
    compiled = [name for name in texts if name.endswith(".c")]
    files: dict[str, bytes | str] = {"modelDescription.xml": model_description(model, version, compiled)}
    files |= {f"sources/{name}": text for name, text in texts.items()}
    if version == 3:
        files["sources/buildDescription.xml"] = build_description(model, compiled)
    files["documentation/index.html"] = page(model)
    binary, command = library_path(model.name, version), compiler()
    missing = ""
    if command is None:
        missing = "there is no C compiler, so the FMU holds its source only"
    elif binary is None:
        missing = "FMI has no name for this machine, so the FMU holds its source only"
    else:
        files[binary] = shared_library(texts, command)
    return Fmu(_zipped(files), "" if missing else binary or "", missing)


def _zipped(files: dict[str, bytes | str]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, _TIME)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, content)
    return buffer.getvalue()
