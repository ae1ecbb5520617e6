"""Drawn files of other tools with their meaning, kept in tests/frozen/foreign, a file for each format.

    python -m tests.frozen.foreign --draw        draw the files anew, after a change of tests/fuzz/drawn_*.py
    python -m tests.frozen.foreign --controls    break the readers once each, and look for a kept file that detects it

Kept files are lines of JSON under gzip; git -c diff.gzip.textconv="gzip -dc" diff tests/frozen/foreign shows the lines.
"""

import difflib
import gzip
import json
import math
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from importlib import import_module
from itertools import count
from pathlib import Path

import fuzzyctl
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.registry import FORMATS
from fuzzyctl.loading.load import examine_all
from tests.frozen.foreign_controls import CONTROLS
from tests.frozen.systems import SYSTEMS
from tests.fuzz.mutating import mutated
from tests.peers.drawing import Abilities, Draw

ROOT = Path(__file__).parent.parent.parent
KEPT = ROOT / "tests/frozen/foreign"
#: Seeds of drawn files, and the number of sound ones that are kept, and of broken ones.
SEEDS, SHARE = 1000, 150
#: Profiles of the drawn systems that are written in each format, and their number.
PROFILES, SYSTEMS_DRAWN = ("exact", "matlab", "octave", "fuzzylite", "jfuzzylogic"), 100
ABLE = Abilities(infinite=True, heights=True, negates=True, activations=("general", "first", "highest", "proportional"))
POINTS = 4

TOKEN = re.compile(r"[\d.]+|[^\W\d]\w*|\n *|.", re.DOTALL)
WORDS = [*"0 -1 1e999 nan -inf 7 ( ) [ ] , ; : = ' \" # % and or not is if then with any x a none".split(), "\n"]


def kept(name):
    """Return the kept files of a format, or of `.fz`: each with the lines of its text, of its meaning, and so on."""
    return json.loads(gzip.decompress((KEPT / f"{name}.json.gz").read_bytes()))


def keep(name, files):
    """Write kept files, unless they are there: other versions of zlib compress the same lines to other bytes."""
    path = KEPT / f"{name}.json.gz"
    data = json.dumps(files, indent=0, ensure_ascii=False).encode()
    if not path.exists() or gzip.decompress(path.read_bytes()) != data:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(gzip.compress(data, mtime=0))


def entry(name, text):
    """Return a file as it is kept: text, diagnostics, systems as rule files, numbers, systems in the format."""
    systems, meaning = examined(name, text)
    found = {"text": text.split("\n"), "meaning": meaning}
    if systems:
        names = [name] if name in FORMATS else [*FORMATS]
        found |= {"numbers": numbers(systems), "written": [line for s in systems for line in written(s, names)]}
    return found


def examined(name, text):
    systems, diagnostics = examine_all(SourceText(f"drawn.{name}", text))
    said = [f"{d.code} {d.severity} {d.place} {d.message}" for d in diagnostics]
    return systems, [*said, *(line for s in systems for line in fuzzyctl.dumps(s).split("\n"))]


def numbers(systems):
    """Return outputs of systems at points drawn within and beyond the ranges, errors by their code or class."""
    rng, rows = random.Random(1), []
    for system in systems:
        try:
            kernel = fuzzyctl.compile(system, backend="python")
        except fuzzyctl.DiagnosticError as error:  # such as maxima that have no closed form
            rows.append(error.diagnostics[0].code)
            continue
        ends = [system.range_of(i) for i in system.inputs]
        for _ in range(POINTS):
            point = [round(rng.uniform(low - (high - low) / 9, high + (high - low) / 9), 3) for low, high in ends]
            try:
                values = kernel.batch([point])[0].tolist()
                rows.append([point, [float(f"{v:.12g}") for v in (values if isinstance(values, list) else [values])]])
            except fuzzyctl.FuzzyctlError as error:
                rows.append([point, type(error).__name__])
    return rows


def written(system, names):
    """Yield the lines of a system in some formats: its losses and its text, or the reasons of the refusal."""
    for name in names:
        yield f"== {name}"
        try:
            text, losses = FORMATS[name].write(system)
        except fuzzyctl.DiagnosticError as error:
            yield from (f"{d.code} {fact}" for d in error.diagnostics for fact in d.facts)
            continue
        yield from (f"{'exact' if loss.exact else 'lossy'} {loss}" for loss in losses)
        # The hundred points of each curve in FML take the place of all others.
        yield from (line for line in text.split("\n") if "<point " not in line or len(names) == 1)


def same(one, other):
    """Whether two results of `numbers` differ in their last digits only."""
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(same(a, b) for a, b in zip(one, other, strict=True))
    if isinstance(one, float | int) and isinstance(other, float | int):
        return math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-12) or (math.isnan(one) and math.isnan(other))
    return one == other


def renewed(name, file):
    """Return a kept file as it is now; numbers stay that differ in their last digits only."""
    now = entry(name, "\n".join(file["text"]))
    return now | {"numbers": file["numbers"]} if same(now.get("numbers", 0), file.get("numbers")) else now


def differences(name, file):
    """Return the lines of a kept file that are others now."""
    now, lines = renewed(name, file), []
    for part in ("meaning", "written"):
        lines += difflib.unified_diff(file.get(part, []), now.get(part, []), lineterm="", n=0)
    if now.get("numbers") != file.get("numbers"):
        lines += [f"numbers {file.get('numbers')}", f"are {now.get('numbers')}"]
    return lines


def drawn(format, seed):
    """Return a drawn file, and a drawn or shipped one with one mistake."""
    draw = getattr(import_module(f"tests.fuzz.drawn_{format}"), format)
    samples = [p.read_text(encoding="utf-8") for p in sorted((ROOT / "tests/fuzzyctl/formats").rglob(f"*.{format}"))]
    rng = random.Random(seed)
    text = rng.choice([draw(rng), *samples])
    return draw(random.Random(seed)), "".join(mutated(rng, TOKEN.findall(text), WORDS, 1))


def steps(format, text):
    """Return whether a text is sound, and the pairs of lines of the readers that it runs one after the other."""
    seen = set()

    def tracer(frame, event, argument):
        file, last = frame.f_code.co_filename, 0

        def local(frame, event, argument):
            nonlocal last
            seen.add((file, last, frame.f_lineno))
            last = frame.f_lineno
            return local

        return local if "formats" in file else None

    sys.settrace(tracer)
    try:
        systems, _ = examined(format, text)
    finally:
        sys.settrace(None)
    return bool(systems), seen


def draw(format):
    """Return the drawn files that run the rarest steps of the reader, each step in as many files as there is place."""
    sound, files = {}, defaultdict(list)
    for text in dict.fromkeys(text for seed in range(SEEDS) for text in drawn(format, seed)):
        sound[text], seen = steps(format, text)
        for step in seen:
            files[step].append(text)
    chosen = {True: {}, False: {}}
    for share in count():
        for texts in sorted(files.values(), key=len):
            for text in texts[share : share + 1]:
                if len(chosen[sound[text]]) < SHARE:
                    chosen[sound[text]][text] = None
        if sum(map(len, chosen.values())) == 2 * SHARE or share > SEEDS:
            return [text for some in chosen.values() for text in some]


def drawn_systems():
    """Return rule files whose systems are written in each format: every method, and drawn ones of each profile."""
    for seed in range(SYSTEMS_DRAWN):
        yield fuzzyctl.dumps(Draw(random.Random(seed), PROFILES[seed % len(PROFILES)], ABLE).system())
    yield from SYSTEMS.values()


def control(format, module, old, new, folder):
    """Return the number of a kept file that detects a breakage of a reader in a copy of the project, as a text."""
    path = Path(folder) / "fuzzyctl/formats" / module
    text = path.read_text(encoding="utf-8")
    assert old in text, (module, old)
    path.write_text(text.replace(old, new), encoding="utf-8")
    program = f"from tests.frozen.foreign import detecting; print(detecting({format!r}))"
    call = [sys.executable, "-B", "-c", program]
    found = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=True).stdout.strip()
    path.write_text(text, encoding="utf-8")
    return found


def detecting(format):
    """Return the number of the first kept file with another meaning, as a text; empty for none."""
    for number, file in enumerate(kept(format)):
        try:
            if examined(format, "\n".join(file["text"]))[1] != file["meaning"]:
                return f"file {number}"
        except Exception as error:  # noqa: BLE001
            return f"file {number}: {error!r}"
    return ""


def main():
    if sys.argv[1:] == ["--draw"]:
        for name in ("fz", *FORMATS):
            keep(name, [entry(name, text) for text in (drawn_systems() if name == "fz" else draw(name))])
        return
    assert sys.argv[1:] == ["--controls"], __doc__
    missed = 0
    with tempfile.TemporaryDirectory() as folder:
        for part in ("fuzzyctl", "tests"):
            shutil.copytree(ROOT / part, Path(folder) / part, ignore=shutil.ignore_patterns("__pycache__", "vectors"))
        for row in CONTROLS:
            found = control(*row, folder)
            missed += not found
            print(f"{row[1]}: {row[3]}: {found or 'NOT FOUND'}", flush=True)
    sys.exit(bool(missed))


if __name__ == "__main__":
    main()
