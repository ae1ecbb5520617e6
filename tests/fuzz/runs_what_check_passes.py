"""Put files that `check` passes through the other commands; each raw exception of Python is a failure.

    python tests/fuzz/runs_what_check_passes.py --files 500
    python tests/fuzz/runs_what_check_passes.py --files 400 --first 100 --jobs 1
    python tests/fuzz/runs_what_check_passes.py --files 0 --size 0.05 steps lets

Of four files one is made for a limit of docs/reference (limit_files.py), in turn above it, at it, and at a tenth and
less of it; one is a drawn loop with a system, a controller and a plant: conditions with names, free numbers, delays,
tables over time, noise, dead times, Greek letters and names of 190 letters; one is a drawn system (tests/peers), called
by a controller; one is a small worst case of worst_files/. With words: the worst cases whose names contain one of them.

A file above a limit must be refused by `check` with the number of the limit. Commands run within the processes of a
pool, which end after some files. Prints the file, the command, the exception and its place, and what takes more than
5 s of processor time; exit code 1 if there is an exception.
"""

import argparse
import multiprocessing
import os
import random
import re
import signal
import sys
import tempfile
import time
import traceback
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
sys.path.insert(0, str(Path(__file__).resolve().parent))

from limit_files import LIMITS
from lsprotocol import types as lsp
from worst_files import CASES

from fuzzyctl import dumps
from fuzzyctl.testing import run_command
from tests.frozen.test_verdicts import ABLE
from tests.fuzzyctl.editor.requests import requests
from tests.golden.answers import server
from tests.peers.drawing import Draw

#: The commands that take the file as it is; INPUTS are values of its inputs, LSP are all requests of an editor. Of the
#: last two of each line one is drawn for a file.
COMMANDS = (
    "fmt --check FILE",
    "show FILE",
    "eval FILE INPUTS",
    "simulate FILE -o run",
    "prove --timeout 0.2 FILE",
    "prove --bounds --timeout 0.2 FILE",
    "page FILE -o page.html",
    "LSP FILE",
)
CONVERTED = tuple(f"convert FILE other.{suffix} --force --lossy" for suffix in ("py", "md", "fll", "fis", "fcl", "xml"))
GENERATED = (
    *(f"codegen FILE --target {t} -o out --unproved" for t in ("c", "st", "python", "javascript", "fmu")),
    "codegen FILE --target c --free P -o out --unproved",
)
#: Seconds of a processor after which a command is listed, and after which it is stopped.
SLOW, STOP = 5.0, 10
#: Files after which each process ends and a fresh one begins.
FRESH_AFTER = 25
#: Expressions of controllers over values a and b and a condition c.
EXPRESSIONS = (
    "P * {a} - {b}",
    "where({c}, {a}, {b})",
    "where(high and not {c}, {a} / (1 + abs({b})), P)",
    "delay({a}, {n})",
    "lowpass({a}, 0.2 s)",
    "integral({a}, hold={c})",
    "rate_limit({a}, 3)",
    "rule({a}, {b})",
    "previous({a}, start=P)",
    "{c} - {a}",
    "clamp({a}, -1, P)",
)
CONDITIONS = (
    "{a} > {b}",
    "{a} in [-0.5, P)",
    "high and {a} < 1",
    "not {c}",
    "hysteresis({a}, -0.2, 0.2)",
    "inside({a})",
)
SIGNALS = (
    "steps(0.1 s: 2)",
    "steps({steps})",
    "noise(0.1)",
    "noise(0.1) + noise(0.2, seed=4)",
    'csv("data.csv", "x")',
    "sine(2) + ramp(0, 0.5)",
    "pulse(0.1 s, 0.2 s) + 1",
)
PLANTS = (
    "tf(num=[{numbers}], den=[1, {numbers}])",
    "tf(num=[1], den=[1, T], delay={delay} s)",
    "zpk(zeros=[], poles=[-1, pair(-1, 2)], gain=3)",
)
MEASURES = ("maximum(abs(plant.y))", "iae(plant.y, r)", "overshoot(plant.y, r)", "final(law.u)", "settling(plant.y, r)")
SYSTEM = """function inside(a) = a > -0.5 and a < 1

system rule
input e in [-2, 2]
  terms N P
input d in [-2, 2]
  terms N P
output u in [-1, 1]
  terms N@-1 P@1
defuzzifier center_average
table u = e x d
    N P
  N | N N
  P | N P
"""


def drawn(seed):
    """Return the files of a drawn loop."""
    rng = random.Random(seed)
    letter = rng.choice(["v", "Ω", "ε", "v" * 190])
    names, conditions = ["e", "d"], ["high"]
    lines = []
    for number in range(rng.randint(1, 12)):
        values = {"a": rng.choice(names), "b": rng.choice(names), "c": rng.choice(conditions), "n": rng.randint(1, 50)}
        lines.append(f"let c{number} = {rng.choice(CONDITIONS).format(**values)}")
        lines.append(f"let {letter}{number} = {rng.choice(EXPRESSIONS).format(**values)}")
        conditions.append(f"c{number}")
        names.append(f"{letter}{number}")
    controller = ["input e in [-2, 2]", "input d in [-2, 2]", "param P in [0, 5] = 2", "let high = P > 1", *lines]
    controller += [f"output u in [-9, 9] = clamp({names[-1]}, -9, 9)", f"output on = {conditions[-1]}", "every 10 ms"]
    controller += rng.sample(["require u <= 9", "require on in [0, 1] when high"], rng.randint(0, 2))
    steps = ", ".join(f"{k * 0.01:.2f} s: {k % 3}" for k in range(rng.choice([2, 20, 300, 5000])))
    numbers = ", ".join(str(k % 5 + 1) for k in range(rng.choice([1, 4, 40, 200])))
    plant = rng.choice(PLANTS).format(numbers=numbers, delay=rng.choice(["0", "0.013", "P"]).replace("P", "0.4"))
    loop = [f"let r = {rng.choice(SIGNALS).format(steps=steps)}", f"let q = {rng.choice(SIGNALS).format(steps=steps)}"]
    loop += ["let early = t < 0.1 s", "block law = law(r - plant.y, where(early, q, 0), P=K)", "param K in [0, 5] = 2"]
    loop += ["block plant = lag(law.u + q)", f"run {rng.choice(['0.2', '0.5'])} s step 10 ms"]
    loop += [f"measure m{k} = {m}" for k, m in enumerate(rng.sample(MEASURES, rng.randint(1, 4)))]
    loop += rng.sample(["require m0 < 1e9", "measure fine = m0 > 1", "require m0 > 1e9"], rng.randint(0, 3))
    head = "param T = 3\n" if "T" in plant else ""
    text = f"{head}{SYSTEM}\ncontroller law\n" + "\n".join(controller)
    text += f"\n\nplant lag = {plant}\n\nloop drawn\n" + "\n".join(loop) + "\n"
    return {"drawn.fz": text, "data.csv": "t,x\n0,0\n0.1,1\n10,2\n"}


def system(seed):
    """Return the files of a drawn system, and a controller that calls it."""
    found = Draw(random.Random(seed), "exact", ABLE).system()
    name, given = found.name, ", ".join(f"e * {k + 1}" for k in range(len(found.inputs)))
    text = re.sub(r"(?m)^(output [^\]]*\])(?!.* else )", r"\1 else 0", dumps(found))
    text += f"require {found.outputs[0].name} <= 1e300\n"
    member = f".{found.outputs[0].name}" if len(found.outputs) > 1 else ""
    law = f"controller law\ninput e in [-1, 1]\nevery 10 ms\nlet k = {name}({given})\noutput u = k{member} + e\n"
    return {"drawn.fz": text + law * (seed % 3 > 0)}


def files_of(number):
    """Return a name and the files of a number, and whether `check` must refuse them with a limit."""
    kind, count = number % 4, number // 4
    if kind == 0:
        name = list(LIMITS)[count % len(LIMITS)]
        part = (2, 1, 0.1, 0.003)[count // len(LIMITS) % 4]
        return f"{part} of {name}", LIMITS[name].made(part), LIMITS[name].most if part > 1 else 0
    if kind == 3:
        name = random.Random(number).choice(list(CASES))
        return name, CASES[name](random.Random(number).choice((0.001, 0.003, 0.01))), 0
    return ("a loop", drawn(number), 0) if kind == 1 else ("a system", system(number), 0)


def words_of(command, file, text):
    """Return the words of a command."""
    inputs = [f"{name}=0.3" for name in dict.fromkeys(re.findall(r"^\s*input (\w+)", text, re.MULTILINE))]
    return [w for word in command.split() for w in (inputs if word == "INPUTS" else [file if word == "FILE" else word])]


def answered(file):
    """Answer all requests of an editor about a file at some places."""
    uri, text = Path(file).resolve().as_uri(), Path(file).read_text(encoding="utf-8")
    list(server.protocol.lsp_initialize(lsp.InitializeParams(lsp.ClientCapabilities())))
    server.workspace.put_text_document(lsp.TextDocumentItem(uri, "fz", time.monotonic_ns() % (1 << 31), text))
    document = server.document(uri)
    places = [server.position(document.source, at * len(text) // 5) for at in range(1, 5)]
    for proved in (False, True):
        server.diagnostics(document, proved=proved)
    for method, params in requests(uri, places):
        server.protocol.fm.features[method](params)
    server.workspace.remove_text_document(uri)


class StoppedError(BaseException):
    """A command takes too long."""


@contextmanager
def stopped(seconds):
    """Stop what takes more seconds of a processor."""

    def stop(*_):
        raise StoppedError

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def failure(words):
    """Return exit code and output of a command, and its raw exception with the place; an empty text without one."""
    try:
        with stopped(STOP):
            if words[0] == "LSP":
                answered(words[1])
                return 0, "", ""
            result = run_command(*words)
    except StoppedError:
        return 1, "", ""
    except Exception as error:  # noqa: BLE001 - any one is a failure
        place = traceback.extract_tb(error.__traceback__)[-1]
        return 1, "", f"{type(error).__name__}: {str(error)[:100]} ({Path(place.filename).name}:{place.lineno})"
    return result.exit_code, result.output + result.errors, ""


def failures_of(files, commands=COMMANDS, limit=0):
    """Yield commands with what is wrong with them, and seconds of a processor; only `check` if it refuses the files."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        (file, text), *_ = files.items()
        os.chdir(folder)
        try:
            for command in ("check FILE", *commands):
                began = time.process_time()
                code, output, error = failure(words_of(command, file, text))
                took = time.process_time() - began
                if limit and (code != 1 or str(limit) not in output.replace(",", "")):
                    error = error or f"the limit of {limit} is not refused"
                if error or took > SLOW:
                    yield command, error, took
                if command == "check FILE" and code not in (0, 3):
                    return
        finally:
            os.chdir(before)


def tried(name, size=0.0):
    """Return name, failures and seconds of a worst case by its name, or of a drawn file by its number."""
    began = time.process_time()
    title, files, limit = files_of(name) if isinstance(name, int) else (name, CASES[name](size), 0)
    commands = (*COMMANDS, *CONVERTED, *GENERATED)
    if isinstance(name, int):
        commands = (*COMMANDS, CONVERTED[name // 4 % len(CONVERTED)], GENERATED[name // 5 % len(GENERATED)])
    found = list(failures_of(files, commands, limit))
    return f"{name} {title}" if isinstance(name, int) else title, found, time.process_time() - began


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--files", type=int, default=100, help="how many files are drawn")
    parser.add_argument("--first", type=int, default=0, help="the number of the first of them")
    parser.add_argument("--size", type=float, default=0.02, help="of the worst cases: 1 for the limits")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("words", nargs="*", help="parts of names of worst cases")
    arguments = parser.parse_args()
    chosen = [name for name in CASES if any(w in name for w in arguments.words)]
    numbers = range(arguments.first, arguments.first + arguments.files)
    fresh = multiprocessing.get_context("spawn")
    count = slow = seconds = 0
    names, share = [*chosen, *numbers], FRESH_AFTER * arguments.jobs
    # A pool for each share: one with `max_tasks_per_child` may wait for ever for the next worker.
    for first in range(0, len(names), share):
        with ProcessPoolExecutor(arguments.jobs, fresh) as pool:
            runs = [pool.submit(tried, name, arguments.size) for name in names[first : first + share]]
            for run in runs:
                name, found, took = run.result()
                print(f"{took:6.1f} s  {name}", flush=True)
                seconds += took
                for command, error, own in found:
                    count, slow = count + bool(error), slow + (own > SLOW)
                    print(f"          {own:.1f} s  {command}: {error or 'slow'}", flush=True)
    print(f"{len(names)} files, {count} exceptions, {slow} commands above {SLOW:g} s, {seconds:.0f} s in all")
    sys.exit(bool(count))


if __name__ == "__main__":
    main()
