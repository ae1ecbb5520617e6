"""Put files that `check` passes through the other commands; each raw exception of Python is a failure.

    python tests/fuzz/runs_what_check_passes.py --files 500
    python tests/fuzz/runs_what_check_passes.py --files 0 --size 0.05 steps lets

Files are the worst cases of worst_files/, made smaller by --size, or those whose name contains one of the words given,
and drawn loops of a controller and a plant: conditions with names, free numbers, delays, tables over time, noise,
dead times, Greek letters and names of 200 letters. Files that `check` refuses must be refused by name, too. All
commands run within this process. Prints the command, the exception and its place; exit code 1 if there is one.
"""

import argparse
import os
import random
import re
import sys
import tempfile
import traceback
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from click.testing import CliRunner
from worst_files import CASES

from fuzzyctl.cli.main import main as fuzzyctl

#: The commands that take the file as it is; INPUTS are values of its inputs, BLOCK is its last controller or system.
COMMANDS = (
    "fmt --check FILE",
    "show FILE",
    "prove --timeout 0.2 FILE",
    "bounds --timeout 0.2 FILE",
    "page FILE -o page.html",
    "simulate FILE -o run",
    "eval FILE INPUTS",
    "convert FILE other.py --force --lossy",
    "convert FILE other.md --force --lossy",
    "convert FILE other.fll --force --lossy",
    "codegen FILE --target c -o out --unproved",
    "codegen FILE --target st -o out --unproved",
    "codegen FILE --target python -o out --unproved",
    "codegen FILE --target javascript -o out --unproved",
    "codegen FILE --target fmu -o out --unproved",
    "codegen FILE --target c --free P -o out --unproved",
)
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
    steps = ", ".join(f"{k * 0.01:.2f} s: {k % 3}" for k in range(rng.choice([2, 20, 300])))
    numbers = ", ".join(str(k % 5 + 1) for k in range(rng.choice([1, 4, 120])))
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


def words_of(command, file, text):
    """Return the words of a command."""
    inputs = [f"{name}=0.3" for name in dict.fromkeys(re.findall(r"^\s*input (\w+)", text, re.MULTILINE))]
    return [w for word in command.split() for w in (inputs if word == "INPUTS" else [file if word == "FILE" else word])]


def failure(words):
    """Return the exit code of a command, and its raw exception with the place; an empty text without one."""
    result = CliRunner().invoke(fuzzyctl, words)
    error = result.exception
    if error is None or isinstance(error, SystemExit):
        return result.exit_code, ""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return result.exit_code, f"{type(error).__name__}: {str(error)[:100]} ({Path(place.filename).name}:{place.lineno})"


def failures_of(files, commands=COMMANDS):
    """Yield the commands that raise for some files, each with its exception; only `check` runs if it refuses them."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        (file, text), *_ = files.items()
        os.chdir(folder)
        try:
            code, error = failure(["check", file])
            if error:
                yield f"check {file}", error
            for command in commands if code in (0, 3) else ():
                _, error = failure(words_of(command, file, text))
                if error:
                    yield command, error
        finally:
            os.chdir(before)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--files", type=int, default=100, help="how many loops are drawn")
    parser.add_argument("--seed", type=int, default=0, help="the number of the first of them")
    parser.add_argument("--size", type=float, default=0.02, help="of the worst cases: 1 for the limits")
    parser.add_argument("words", nargs="*", help="parts of names of worst cases")
    arguments = parser.parse_args()
    chosen = [name for name in CASES if not arguments.words or any(w in name for w in arguments.words)]
    count = 0
    for name in [*chosen, *range(arguments.seed, arguments.seed + arguments.files)]:
        files = drawn(name) if isinstance(name, int) else CASES[name](arguments.size)
        for command, error in failures_of(files):
            count += 1
            print(f"{name}: {command}: {error}", flush=True)
    print(f"{len(chosen)} worst cases, {arguments.files} drawn files, {count} exceptions")
    sys.exit(bool(count))


if __name__ == "__main__":
    main()
