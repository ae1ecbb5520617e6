"""Steps of controllers on every target: compiled C, Structured Text and the Python module, run over rows of inputs."""

import json
import math
import re
import struct
import subprocess
from collections.abc import Sequence
from functools import cache

import numpy as np

import fuzzyctl
from fuzzyctl.codegen.files import sources
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.testing import check_text
from tests.fuzzyctl.codegen.conftest import STRICT
from tests.fuzzyctl.codegen.structured_text import Block


def controller_of(text, name=None):
    """Return the last controller of a text, or the one of that name."""
    blocks, diagnostics = check_text(text, "c.fz", guarantees=False)
    assert [d.message for d in diagnostics if d.severity == "error"] == []
    return next(b for b in reversed(blocks) if b.kind == "controller" and name in (None, b.name))


@cache
def _unit_of(text, target, options):
    small = target not in ("python", "javascript")
    return prepare(controller_of(text), text, guarded=target == "st", small=small, **dict(options))


def unit_of(text, target="c", free=(), **options):
    """Return the last controller of a text, prepared once for all tests."""
    return _unit_of(text, target, (("free", tuple(free)), *options.items()))


def rows_for(unit, count, seed=1):
    """Return inputs, and times where a step takes them, shape (count, arguments); some are NaN."""
    rng = np.random.default_rng(seed)
    rows = rng.uniform(-2, 2, (count, len(unit.arguments)))
    rows = np.where(rng.random(rows.shape) < 0.5, np.roll(rows, 1, axis=0), rows)
    if unit.equations.period is None:
        rows[:, -1] = rng.choice([0.05, 0.05, 0.02], count)
    if unit.arguments:
        rows[count // 3, 0] = math.nan
    return rows


def by_kernel(text, rows, backend="python"):
    """Return the outputs of the kernel, shape (rows, outputs)."""
    step = fuzzyctl.compile(controller_of(text), backend)
    width = len(step.input_names)
    time = {} if step.period is not None else {"dt": rows[:, -1]}
    return step.run(rows[:, :width], **time)[0].reshape(len(rows), -1)


def by_python(unit, rows, **numbers):
    names = {"__name__": "generated"}
    exec(compile(*sources(unit, "python").values(), "generated", "exec"), names)
    state, results, width = names["start"](**numbers), [], len(unit.equations.inputs)
    for row in rows.tolist():
        found, state = names["step"](*row[:width], state, *row[width:])
        results.append(found if isinstance(found, tuple) else (found,))
    return np.array(results)


def by_structured_text(unit, rows, **numbers):
    """Return the outputs, NaN where they are not valid."""
    block = Block(*sources(unit, "st").values())
    results = []
    for row in rows.tolist():
        found = block(**dict(zip(block.inputs, [*row, *(n.start for n in unit.numbers)], strict=True)) | numbers)
        results.append([v if valid else math.nan for v, valid in zip(found[::2], found[1::2], strict=True)])
    return np.array(results)


#: Makes the steps of each controller, in a folder of its own, and writes the outputs.
NODE = """import { readFileSync, writeFileSync } from "node:fs";
for (const [folder, name, numbers] of JSON.parse(readFileSync("controllers.json", "utf8"))) {
    const module = await import("./" + folder + "/" + name + ".mjs");
    const bytes = readFileSync(folder + "/rows.bin");
    const rows = new Float64Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
    const width = module[name + "_step"].length - (name + "_init" in module ? 1 : 0);
    const state = name + "_init" in module ? [module[name + "_init"](numbers)] : [];
    const found = [];
    for (let k = 0; k < rows.length; k += Math.max(width, 1)) {
        found.push(module[name + "_step"](...state, ...rows.slice(k, k + width)));
    }
    writeFileSync(folder + "/found.bin", Float64Array.from(found.flat()));
}
"""


def by_javascript(units: Sequence, rows: Sequence, folder, **numbers):
    """Return the outputs of each controller over its rows, made by node."""
    entries = []
    for k, (unit, own) in enumerate(zip(units, rows, strict=True)):
        (folder / f"{k}").mkdir()
        ((name, text),) = sources(unit, "javascript").items()
        (folder / f"{k}" / name).write_text(text, encoding="utf-8")
        (own if own.shape[1] else np.zeros((len(own), 1))).tofile(folder / f"{k}" / "rows.bin")
        entries.append([f"{k}", name.removesuffix(".mjs"), numbers])
    (folder / "controllers.json").write_text(json.dumps(entries), encoding="utf-8")
    (folder / "main.mjs").write_text(NODE, encoding="utf-8")
    subprocess.run(["node", "main.mjs"], cwd=folder, check=True)
    return [np.fromfile(folder / f"{k}" / "found.bin").reshape(len(own), -1) for k, own in enumerate(rows)]


#: Reads rows of numbers from standard input and writes the outputs of each step.
DRIVER = """static void run_{name}(void)
{{
{begin}
    {row} row[{width}];
    size_t count = 0U;
    uint64_t rows = 0U;
    count = fread(&rows, sizeof rows, 1U, stdin);
    for (uint64_t k = 0U; (k < rows) && (count > 0U); ++k) {{
        count = fread(row, sizeof row[0], {width}U, stdin);
{call}
        (void)fwrite(found, sizeof found[0], {outputs}U, stdout);
    }}
}}
"""


def _driver(name, header, row, numbers):
    """Return the text of a function that evaluates a block over rows of a type, read in its header; its outputs.

    Args:
        name: That of the block.
        header: The text of its header.
        row: The type of numbers of the rows.
        numbers: Free numbers.
    """
    function, inside = re.search(rf"^\w+ ({name}(?:_step)?)\((.*)\);$", header, re.M).groups()
    taken = [re.fullmatch(r"(?:const )?(\w+) (\*?)(\w+)", part).groups() for part in inside.split(", ") if " " in part]
    numeric = [kind for kind, star, _ in taken if not star]
    structs = [(kind, own) for kind, star, own in taken if star and own != "outputs"]
    begin = [f"{kind} {own};\n    {name}_{'' if own == 'state' else own + '_'}init(&{own});" for kind, own in structs]
    begin += [f"params.{own} = {value!r};" for own, value in numbers.items()]
    given = [*(f"&{own}" for _, own in structs), *(f"({kind})row[{k}]" for k, kind in enumerate(numeric))]
    many = re.search(rf"typedef struct \{{([^}}]*)\}} {name}_outputs;", header)
    call = f"{function}({', '.join([*given, *(['&outputs'] if many else [])])})"
    lines, results = [], [call]
    if many:
        lines = [f"{name}_outputs outputs;", f"{call};"]
        results = [f"outputs.{own}" for own in re.findall(r"(\w+);", many[1])]
    lines.append(f"const {row} found[{len(results)}] = {{{', '.join(results)}}};")
    call = "\n".join("        " + line for line in lines)
    sizes = {"width": max(1, len(numeric)), "outputs": len(results)}
    begin = "\n".join("    " + line for line in begin)
    return DRIVER.format(name=name, begin=begin, row=row, call=call, **sizes), len(results)


def _by_program(files, rows, folder, flags, kind, **numbers):
    """Compile files of several blocks into one program, and return the outputs of each over its rows."""
    names = [next(n for n in texts if n.endswith(".h"))[:-2] for texts in files]
    for texts, name in zip(files, names, strict=True):
        for file in (f"{name}.h", f"{name}.c"):
            (folder / file).write_text(texts[file], encoding="utf-8")
    row, dtype = kind
    drivers = [_driver(n, texts[f"{n}.h"], row, numbers) for n, texts in zip(names, files, strict=True)]
    heads = ["#include <stdint.h>", "#include <stdio.h>", *(f'#include "{n}.h"' for n in names)]
    calls = "".join(f"    run_{n}();\n" for n in names)
    main = "\n".join([*heads, *(text for text, _ in drivers), f"int main(void)\n{{\n{calls}    return 0;\n}}\n"])
    (folder / "main.c").write_text(main, encoding="utf-8")
    program = folder / "program"
    compiled = [str(folder / f"{n}.c") for n in ("main", *names)]
    subprocess.run(["gcc", *STRICT, *flags, *compiled, "-o", str(program), "-lm"], check=True)
    # A controller without arguments reads a number for each step, too.
    wide = [r if r.shape[1] else np.zeros((len(r), 1)) for r in rows]
    given = b"".join(struct.pack("<Q", len(r)) + np.ascontiguousarray(r, dtype=dtype).tobytes() for r in wide)
    found = np.frombuffer(subprocess.run([program], input=given, capture_output=True, check=True).stdout, dtype=dtype)
    ends = np.cumsum([len(own) * width for (_, width), own in zip(drivers, rows, strict=True)])
    return [part.reshape(len(own), -1) for part, own in zip(np.split(found, ends[:-1]), rows, strict=True)]


def by_c(units: Sequence, rows: Sequence, folder, flags=("-O1",), **numbers):
    """Compile several controllers into one program, and return the outputs of each over its rows."""
    return by_doubles([sources(u, "c") for u in units], rows, folder, flags, **numbers)


def by_doubles(files: Sequence, rows: Sequence, folder, flags=("-O1",), **numbers):
    """Compile files of floating point into one program, and return the outputs of each block over its rows."""
    return _by_program(files, rows, folder, flags, ("double", np.float64), **numbers)


def by_integers(files: Sequence, rows: Sequence, folder, flags=("-O1",)):
    """Compile files of fixed point into one program, and return the integers of the outputs over integer rows."""
    return _by_program(files, rows, folder, flags, ("int32_t", np.int32))
