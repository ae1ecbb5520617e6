"""Shared library of an FMU, from the compiler at hand."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.fmu.description import OPTIONS

#: Compilers that are looked for, after that of the environment variable CC.
COMPILERS: Final = ("cc", "gcc", "clang")
#: Most characters of sources that are optimised: of a function of 60,000 lines that takes many minutes and gigabytes.
_OPTIMISED: Final = 500_000
#: Suffix of shared libraries, and the name of the system in folders of FMI 2 and 3.
_SYSTEMS: Final = {"linux": (".so", "linux", "linux"), "darwin": (".dylib", "darwin", "darwin"),
                   "win32": (".dll", "win", "windows")}  # fmt: skip
_MACHINES: Final = {"x86_64": "x86_64", "amd64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64"}


def compiler() -> str | None:
    """Return the C compiler: that of CC, or the first of `COMPILERS`; None where there is none."""
    wanted = os.environ.get("CC", "")
    return next((found for name in (wanted, *COMPILERS) if name and (found := shutil.which(name))), None)


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
        CodegenError: With what the compiler says, where it fails.
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
            said = "\n".join(run.stderr.splitlines()[:10]) or f"it said nothing; exit code {run.returncode}"
            raise CodegenError(f"the C compiler '{command}' refuses the source of the FMU:\n{said}")
        return (Path(folder) / "library").read_bytes()
