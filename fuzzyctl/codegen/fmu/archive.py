"""FMU as an archive: descriptions, sources, and the binary of this machine."""

from __future__ import annotations

import io
import math
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fuzzyctl.codegen.c_source import comment
from fuzzyctl.codegen.c_text import INDENT
from fuzzyctl.codegen.comments import printable
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.fmu.description import OPTIONS, build_description, model_description, page
from fuzzyctl.codegen.fmu.model import Model, Variable, c_text


def model_header(model: Model) -> str:
    """Return the text of `fmu_model.h`."""
    lines = [*comment([f"Model of the FMU '{printable(model.block)}', for fmu_core.h."])]
    lines += ["#ifndef FMU_MODEL_H", "#define FMU_MODEL_H", "", "#include <float.h>", "#include <stddef.h>", ""]
    lines += [*(f'#include "{name}"' for name in model.sources if name.endswith(".h")), "", *_constants(model), ""]
    lines += [*_variables(model), "", *_memory(model), "", *model.helpers, *([""] if model.helpers else [])]
    lines += ["static void fmu_begin(fmu_Model *model)", "{", *_in(model.begin), "}", ""]
    lines += ["// Make a step of dt seconds. Returns why there is none, NULL where all is well."]
    lines += ["static const char *fmu_make(fmu_Model *model, double dt)", "{", *_in(model.make), "}"]
    return "\n".join([*lines, "", "#endif // FMU_MODEL_H"]) + "\n"


def _constants(model: Model) -> Iterator[str]:
    yield f"#define FMU_TOKEN {c_text(model.token)}"
    yield "// References of variables; that of the time is 0."
    references = {
        "FIRST_INPUT": 1,
        "FIRST_OUTPUT": model.first_output,
        "FIRST_PARAM": model.first_param,
        "FIRST_CONSTANT": model.first_constant,
        "VALUES": 1 + len(model.variables),
    }
    yield from (f"#define FMU_{name} {reference}U" for name, reference in references.items())
    yield f"#define FMU_SAMPLED {int(model.period is not None)}"
    if model.period is not None:
        yield f"#define FMU_PERIOD {model.period!r} // [s]"
    yield f"#define FMU_PREVIEW {model.preview!r} // dt of the outputs before the first step [s]"


def _variables(model: Model) -> Iterator[str]:
    yield from ("typedef struct {", f"{INDENT}const char *name;", f"{INDENT}double start;")
    yield from (f"{INDENT}double lower;", f"{INDENT}double upper;", "} fmu_Variable;", "")
    yield "static const fmu_Variable fmu_variables[FMU_VALUES] = {"
    for v in (Variable(model.time), *model.variables):
        yield f"{INDENT}{{{c_text(v.name)}, {_number(v.start)}, {_number(v.lower)}, {_number(v.upper)}}},"
    yield "};"


def _number(value: float) -> str:
    """Return a number; one without end is the largest, since variables are finite."""
    return ("DBL_MAX" if value > 0 else "-DBL_MAX") if math.isinf(value) else repr(float(value))


def _memory(model: Model) -> Iterator[str]:
    yield from ("typedef struct {", f"{INDENT}double value[FMU_VALUES];")
    yield from ([f"{INDENT}{model.memory}"] if model.memory else [])
    yield "} fmu_Model;"


def _in(lines: Iterable[str]) -> list[str]:
    return [INDENT + line for line in lines]


#: Compilers that are looked for, after that of the environment variable CC.
COMPILERS: Final = ("cc", "gcc", "clang")
#: Most characters of sources that are optimised: of a function of 60,000 lines that takes many minutes and gigabytes.
_OPTIMISED: Final = 500_000
#: Suffix of shared libraries, and the name of the system in folders of FMI 2 and 3.
_SYSTEMS: Final = {"linux": (".so", "linux", "linux"), "darwin": (".dylib", "darwin", "darwin"),
                   "win32": (".dll", "win", "windows")}  # fmt: skip
_MACHINES: Final = {"x86_64": "x86_64", "amd64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64"}


def compiler() -> str | None:
    """Return the C compiler: that of CC, or the first of `COMPILERS`, or None."""
    wanted = os.environ.get("CC", "")
    return next((result for name in (wanted, *COMPILERS) if name and (result := shutil.which(name))), None)


def library_path(name: str, version: int) -> str | None:
    """Return where the library of this machine lies in an FMU; None for a machine that FMI has no name for.

    Args:
        name: The model identifier.
        version: 2 or 3, of FMI.
    """
    system, machine = _SYSTEMS.get(sys.platform), _MACHINES.get(platform.machine().lower())
    if system is None or machine is None or sys.maxsize <= 2**32:
        return None
    suffix, old, new = system
    # FMI 2 names no processor: its importers take '64' for that of the machine.
    return f"binaries/{f'{old}64' if version == 2 else f'{machine}-{new}'}/{name}{suffix}"


def shared_library(sources: Mapping[str, str], command: str) -> bytes:
    """Compile a shared library.

    Args:
        sources: Text of each file by its name; those that end in `.c` are compiled.
        command: The compiler.

    Raises:
        CodegenError: If the compiler fails, with its output.
    """
    with tempfile.TemporaryDirectory() as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text, encoding="utf-8", newline="\n")
        names = [name for name in sources if name.endswith(".c")]
        optimised = OPTIONS if sum(map(len, sources.values())) <= _OPTIMISED else (*OPTIONS, "-O0")
        options = [*optimised, "-fvisibility=hidden", "-shared", *([] if sys.platform == "win32" else ["-fPIC"])]
        call = [command, *options, *names, "-o", "library", *([] if sys.platform == "win32" else ["-lm"])]
        try:
            run = subprocess.run(call, cwd=folder, capture_output=True, text=True, errors="replace", check=False)
        except OSError as error:
            raise CodegenError(f"the C compiler '{command}' cannot be run: {error.strerror}") from None
        if run.returncode:
            message = "\n".join(run.stderr.splitlines()[:10]) or f"it said nothing; exit code {run.returncode}"
            raise CodegenError(f"the C compiler '{command}' refuses the source of the FMU:\n{message}")
        return (Path(folder) / "library").read_bytes()


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
        model: Its computation.
        version: 2 or 3, of FMI.
    """
    names = ("fmu_core.h", *model.shared, f"fmi{version}.c")
    shared = {name: (_SHARED / name).read_text(encoding="utf-8") for name in names}
    return {**model.sources, "fmu_model.h": model_header(model), **shared}


def fmu(model: Model, version: int) -> Fmu:
    """Return an FMU; without a compiler one of sources only.

    Args:
        model: Its computation.
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
