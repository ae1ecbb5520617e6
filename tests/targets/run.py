"""Run generated C where no Python does: on an emulated Cortex-M4 and AVR; and let cppcheck look for MISRA violations.

    python tests/targets/run.py [--keep DIR]

Debian: apt-get install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm gcc-avr avr-libc simavr cppcheck.
What is not installed is left out and named. Prints the size of each kernel and what its self-test said; exits with 1 if
one failed.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

HERE: Final = Path(__file__).parent
RULES: Final = HERE.parent.parent / "rules"
STRICT: Final = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Os"]
M4: Final = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]
#: A part whose memory holds the vectors of the self-tests; the kernels themselves fit far smaller ones.
AVR: Final = ["-mmcu=atmega2560"]
QEMU: Final = ["-machine", "mps2-an386", "-cpu", "cortex-m4", "-semihosting", "-nographic", "-kernel"]

#: Rules of MISRA C:2012 that cppcheck reports, with the reason why the code keeps what it finds.
DEVIATIONS: Final = {
    "2.5": "headers tell the scale of fixed point and the sample time of a controller in macros, for the caller",
    "8.7": "functions of the interface are not called in the unit itself",
    "10.6": "knots below a value are counted in unsigned int and kept as size_t",
    "10.8": "products of fixed point are rounded in the wide type and then narrowed",
    "12.1": "the order of operations is IEEE 754's from left to right, with parentheses where they differ",
    "21.15": "memcpy looks at the bits of a number, the only way that C defines to find NaN under -ffast-math",
}


@dataclass(frozen=True)
class Case:
    """A rule file, and how its C is made.

    Args:
        file: Name of the rule file.
        options: Of `fuzzyctl codegen`.
        tools: Which targets can take it: an AVR has 8 KB for the self-test's vectors, and no `double`.
        folder: Where the rule file stands.
    """

    file: str
    options: tuple[str, ...]
    tools: tuple[str, ...] = ("arm", "avr", "cppcheck")
    folder: Path = RULES

    @property
    def name(self) -> str:
        """File and options in one line."""
        return " ".join([self.file, *self.options])


CASES: Final = (
    Case("ais_reaction", ()),
    Case("ais_reaction", ("--float", "float")),
    Case("ais_reaction", ("--fixed", "Q3.12")),
    Case("ais_reaction", ("--table", "33"), ("arm", "cppcheck")),
    Case("boundary_layer", ("--float", "float")),
    Case("boundary_layer", ("--table", "33", "--fixed", "Q5.10")),
    Case("fcafsmc", ("--float", "float"), ("arm", "cppcheck")),
    Case("tipper", ()),
    Case("tipper", ("--float", "float")),
    Case("valve", (), ("arm", "cppcheck", "host steps", "arm steps", "other steps"), HERE),
    Case("valve", ("--float", "float"), folder=HERE),
    Case("heater", ("--fixed", "Q7.8"), folder=HERE),
)


class FailedError(Exception):
    """Carries what a tool said."""


def call(*command: str | Path) -> str:
    """Run a tool and return what it printed.

    Raises:
        FailedError: If it fails or takes longer than a minute.
    """
    words = [str(c) for c in command]
    try:
        done = subprocess.run(words, capture_output=True, text=True, errors="replace", timeout=60, check=False)
    except subprocess.TimeoutExpired:
        raise FailedError(f"{words[0]} took longer than a minute") from None
    if done.returncode:
        raise FailedError(f"{' '.join(words)}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def generate(case: Case, folder: Path) -> tuple[Path, Path]:
    """Write the C of a case and return its source and its self-test."""
    command = "from fuzzyctl.cli.main import main; main()"
    rule_file = case.folder / f"{case.file}.fz"
    call(sys.executable, "-c", command, "codegen", rule_file, "--target", "c", *case.options, "-o", folder)
    return folder / f"{case.file}.c", folder / f"{case.file}_selftest.c"


def on_arm(source: Path, selftest: Path) -> str:
    """Run a self-test on QEMU's Cortex-M4 and return the size of the kernel and the verdict."""
    program = source.with_suffix(".elf")
    _linked_for_arm(program, source, selftest)
    said = call("qemu-system-arm", *QEMU, program)
    return f"{_size('arm-none-eabi', [*M4], source)} bytes, {_verdict(said)}"


def _linked_for_arm(program: Path, *sources: str | Path) -> None:
    """Compile and link sources with the start-up code of a Cortex-M4."""
    start = call("arm-none-eabi-gcc", *M4, "-print-file-name=rdimon-crt0.o").strip()
    linked = ["--specs=rdimon.specs", "-nostartfiles", "-T", HERE / "cortex_m4.ld", "-lm", "-o", program]
    call("arm-none-eabi-gcc", *STRICT, *M4, HERE / "cortex_m4.c", start, *sources, *linked)


def on_avr(source: Path, selftest: Path) -> str:
    """Run a self-test on simavr's ATmega2560 and return the size of the kernel and the verdict."""
    program, tested = source.with_suffix(".avr"), selftest.with_suffix(".o")
    call("avr-gcc", *STRICT, *AVR, "-Dmain=selftest", "-c", selftest, "-o", tested)
    start = source.with_suffix(".start.o")
    call("avr-gcc", "-std=gnu99", "-Os", *AVR, "-c", HERE / "avr.c", "-o", start)
    printing = ["-Wl,-u,vfprintf", "-lprintf_flt", "-lm"]
    call("avr-gcc", *STRICT, *AVR, start, source, tested, *printing, "-o", program)
    said = call("simavr", "-m", "atmega2560", "-f", "16000000", program)
    if "exit 0" not in said:
        raise FailedError(said)
    return f"{_size('avr', AVR, source)} bytes, {_verdict(said)}"


def steps_on_host(source: Path, _selftest: Path) -> str:
    """Make 10,000 steps on this machine and compare them with those of the kernel."""
    program = source.with_suffix(".host")
    call("gcc", *STRICT, f"-I{source.parent}", HERE / "steps.c", source, "-o", program, "-lm")
    return _compared(call(program))


def steps_on_arm(source: Path, _selftest: Path) -> str:
    """Make the same steps on QEMU's Cortex-M4."""
    program = source.with_suffix(".steps.elf")
    _linked_for_arm(program, f"-I{source.parent}", HERE / "steps.c", source)
    return _compared(call("qemu-system-arm", *QEMU, program))


def _compared(said: str) -> str:
    """Compare what `steps.c` prints with the steps of the kernel.

    Raises:
        FailedError: Where a number is off by more than 1e-12 of the largest one.
    """
    import fuzzyctl

    step = fuzzyctl.compile(fuzzyctl.load(HERE / "valve.fz", block=fuzzyctl.Controller), "python")
    state, total, worst = step.start(), 0.0, 0.0
    rows = iter(said.splitlines())
    for k, inputs in enumerate(_inputs(), start=1):
        outputs, state = step(*inputs, state)
        total += sum(outputs)
        if k % 100 == 0:
            found = [float(word) for word in next(rows, "nan nan nan").split()]
            off = [abs(a - b) / max(1.0, abs(b)) for a, b in zip(found, (*outputs, total), strict=True)]
            worst = max([worst, *off]) if all(x == x for x in off) else float("inf")
    if worst > 1e-12:
        raise FailedError(f"steps are off by {worst:g}\n{said}")
    return f"10,000 steps agree to {worst:.1g}"


def _inputs() -> Iterator[list[float]]:
    """Yield the inputs of 10,000 steps, those of `steps.c`."""
    seed = 1
    for _ in range(10_000):
        inputs = []
        for _ in range(2):
            seed = (seed * 1664525 + 1013904223) % 2**32
            inputs.append((seed >> 8) / 8388608.0)
        yield inputs


def steps_elsewhere(_source: Path, _selftest: Path) -> str:
    """Make the same steps in generated Python, numpy, numba and the interpreter of Structured Text, all against Python.

    Raises:
        FailedError: Where a number is off by more than 1e-12 of the largest one.
    """
    import numpy as np

    from tests.fuzzyctl.codegen.steps.targets import by_kernel, by_python, by_structured_text, unit_of

    text, rows = (HERE / "valve.fz").read_text(encoding="utf-8"), np.array(list(_inputs()))
    exact = by_kernel(text, rows)
    found = {
        "generated Python": by_python(unit_of(text, "python"), rows),
        "numpy": by_kernel(text, rows, "numpy"),
        "numba": by_kernel(text, rows, "numba"),
        "Structured Text": by_structured_text(unit_of(text, "st"), rows),
    }
    off = {name: float(np.max(np.abs(own - exact)) / np.max(np.abs(exact))) for name, own in found.items()}
    if not max(off.values()) <= 1e-12:
        raise FailedError(f"steps are off: {off}")
    return "10,000 steps agree: " + ", ".join(f"{name} to {own:.1g}" for name, own in off.items())


def misra(source: Path, _selftest: Path) -> str:
    """Return which of the known deviations cppcheck finds.

    Raises:
        FailedError: For any other.
    """
    settings = ["--std=c99", "--addon=misra", "--enable=all", "--suppress=missingIncludeSystem"]
    said = call("cppcheck", *settings, "--suppress=unusedFunction", source)
    found = set(re.findall(r"^\S+:\d+:\d+: .*\[(?:misra-c2012-)?([\w.]+)\]$", said, re.MULTILINE))
    if found - DEVIATIONS.keys():
        raise FailedError(said)
    return f"no rule but {', '.join(sorted(found, key=lambda r: [int(n) for n in r.split('.')]))}" if found else "none"


def _size(tools: str, flags: Sequence[str], source: Path) -> int:
    compiled = source.with_suffix(".size.o")
    call(f"{tools}-gcc", *STRICT, *flags, "-c", source, "-o", compiled)
    text, data, *_ = call(f"{tools}-size", compiled).splitlines()[1].split()
    return int(text) + int(data)


def _verdict(said: str) -> str:
    found = re.search(r"(\d+ vectors), (\d+) failures", said)
    if found is None or found[2] != "0":
        raise FailedError(said)
    return f"{found[1]} agree"


#: Name, what must be installed, and what is done.
JOBS: Final[dict[str, tuple[tuple[str, ...], Callable[[Path, Path], str]]]] = {
    "arm": (("arm-none-eabi-gcc", "qemu-system-arm"), on_arm),
    "avr": (("avr-gcc", "simavr"), on_avr),
    "cppcheck": (("cppcheck",), misra),
    "host steps": (("gcc",), steps_on_host),
    "arm steps": (("arm-none-eabi-gcc", "qemu-system-arm"), steps_on_arm),
    "other steps": ((), steps_elsewhere),
}


def missing(job: str) -> list[str]:
    """Return the tools of a job that are not installed."""
    return [tool for tool in JOBS[job][0] if shutil.which(tool) is None]


def main() -> int:
    """Run all cases for all targets that can be emulated here."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--keep", type=Path, help="folder for what is generated; else a temporary one")
    folder = parser.parse_args().keep
    if folder is None:
        with tempfile.TemporaryDirectory() as name:
            return _run(Path(name))
    return _run(folder)


def _run(folder: Path) -> int:
    failed = 0
    for job in JOBS:
        if missing(job):
            print(f"{job}: left out, {' and '.join(missing(job))} not installed")
    for k, case in enumerate(CASES):
        source, selftest = generate(case, folder / str(k))
        for job in case.tools:
            if missing(job):
                continue
            try:
                print(f"{case.name}: {job}: {JOBS[job][1](source, selftest)}")
            except FailedError as error:
                failed += 1
                print(f"{case.name}: {job}: FAILED\n{error}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
