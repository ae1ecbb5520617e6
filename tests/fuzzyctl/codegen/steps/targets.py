"""Steps of controllers on every target: compiled C, Structured Text and the Python module, run over rows of inputs."""

import json
import math
import struct
import subprocess
from collections.abc import Sequence

import numpy as np

import fuzzyctl
from fuzzyctl.codegen import c_source, javascript_source, python_source, st_source
from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.fixed import c_fixed_step
from fuzzyctl.codegen.javascript_source import JavaScriptLayout
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import look_through
from tests.fuzzyctl.codegen.structured_text import Block

STRICT = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wdouble-promotion"]

#: Reads rows of numbers from standard input and writes the outputs of each step.
DRIVER = """static void run_{name}(void)
{{
{begin}
    double row[{width}];
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


def controller_of(text, name=None):
    """Return the last controller of a text, or the one of that name."""
    examined = look_through(SourceText("c.fz", text))
    assert [d.message for d in examined.diagnostics if d.severity == "error"] == []
    return next(c for c in reversed(examined.controllers) if name in (None, c.name))


def unit_of(text, target="c", **options):
    return prepare(
        controller_of(text), text, guarded=target == "st", small=target not in ("python", "javascript"), **options
    )


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
    exec(compile(python_source.module(unit), "generated", "exec"), names)
    state, results, width = names["start"](**numbers), [], len(unit.equations.inputs)
    for row in rows.tolist():
        found, state = names["step"](*row[:width], state, *row[width:])
        results.append(found if isinstance(found, tuple) else (found,))
    return np.array(results)


def by_structured_text(unit, rows, **numbers):
    """Return the outputs, NaN where they are not valid."""
    block = Block(st_source.function_block(unit))
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
        name = JavaScriptLayout(unit).name
        (folder / f"{k}" / f"{name}.mjs").write_text(javascript_source.module(unit), encoding="utf-8")
        (own if own.shape[1] else np.zeros((len(own), 1))).tofile(folder / f"{k}" / "rows.bin")
        entries.append([f"{k}", name, numbers])
    (folder / "controllers.json").write_text(json.dumps(entries), encoding="utf-8")
    (folder / "main.mjs").write_text(NODE, encoding="utf-8")
    subprocess.run(["node", "main.mjs"], cwd=folder, check=True)
    return [np.fromfile(folder / f"{k}" / "found.bin").reshape(len(own), -1) for k, own in enumerate(rows)]


def driver(unit, **numbers):
    """Return the text of a function that makes the steps of one controller with some free numbers."""
    layout = CLayout(unit)
    arguments = [*(["&state"] if layout.members else []), *(["&params"] if layout.numbers else [])]
    arguments = [*arguments, *(f"row[{k}]" for k in range(len(layout.arguments)))]
    call = f"{layout.name}_step({', '.join([*arguments, *(['&outputs'] if layout.many else [])])})"
    found = ", ".join(f"outputs.{o}" for o in layout.outputs) if layout.many else call
    lines = [f"{layout.name}_outputs outputs;", f"{call};"] if layout.many else []
    lines.append(f"const double found[{len(layout.outputs)}] = {{{found}}};")
    begin = f"    {layout.name}_state state;\n    {layout.name}_init(&state);" if layout.members else ""
    begin += f"    {layout.name}_params params;\n    {layout.name}_params_init(&params);" if layout.numbers else ""
    begin += "".join(f"\n    params.{name} = {value!r};" for name, value in numbers.items())
    body = "\n".join("        " + line for line in lines)
    sizes = {"width": max(1, len(layout.arguments)), "outputs": len(layout.outputs)}
    return DRIVER.format(name=layout.name, begin=begin, call=body, **sizes)


FIXED_DRIVER = """static void run_{name}(void)
{{
{begin}
    int32_t row[{width}];
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


def by_fixed_c(steps: Sequence, rows: Sequence, folder, flags=("-O1",)):
    """Compile fixed-point steps into one program, and return the integers of the outputs of each over integer rows."""
    layouts = [CLayout(s.unit, s.form.bits) for s in steps]
    texts = []
    for step, layout in zip(steps, layouts, strict=True):
        files = c_fixed_step.files(step.unit, step)
        for end in ("h", "c"):
            (folder / f"{layout.name}.{end}").write_text(files[f"{layout.name}.{end}"], encoding="utf-8")
        given = [*(["&state"] if layout.members else [])]
        given += [f"({layout.real})row[{k}]" for k in range(len(layout.arguments))]
        call = f"{layout.name}_step({', '.join([*given, *(['&outputs'] if layout.many else [])])})"
        found = ", ".join(f"outputs.{o}" for o in layout.outputs) if layout.many else call
        lines = [f"{layout.name}_outputs outputs;", f"{call};"] if layout.many else []
        lines.append(f"const int32_t found[{len(layout.outputs)}] = {{{found}}};")
        begin = f"    {layout.name}_state state;\n    {layout.name}_init(&state);" if layout.members else ""
        sizes = {"width": max(1, len(layout.arguments)), "outputs": len(layout.outputs)}
        texts.append(FIXED_DRIVER.format(name=layout.name, begin=begin, call="\n".join(lines), **sizes))
    heads = ["#include <stdint.h>", "#include <stdio.h>", *(f'#include "{x.name}.h"' for x in layouts)]
    calls = "".join(f"    run_{x.name}();\n" for x in layouts)
    main = "\n".join([*heads, *texts, f"int main(void)\n{{\n{calls}    return 0;\n}}\n"])
    (folder / "main.c").write_text(main, encoding="utf-8")
    program = folder / "program"
    sources = [str(folder / "main.c"), *(str(folder / f"{x.name}.c") for x in layouts)]
    subprocess.run(["gcc", *STRICT, *flags, *sources, "-o", str(program)], check=True)
    given = b"".join(struct.pack("<Q", len(r)) + np.ascontiguousarray(r, dtype=np.int32).tobytes() for r in rows)
    printed = subprocess.run([program], input=given, capture_output=True, check=True).stdout
    found, results, place = np.frombuffer(printed, dtype=np.int32), [], 0
    for layout, own in zip(layouts, rows, strict=True):
        size = len(own) * len(layout.outputs)
        results.append(found[place : place + size].reshape(len(own), -1))
        place += size
    return results


def by_c(units: Sequence, rows: Sequence, folder, flags=("-O1",), **numbers):
    """Compile several controllers into one program, and return the outputs of each over its rows."""
    layouts = [CLayout(u) for u in units]
    for unit, layout in zip(units, layouts, strict=True):
        (folder / f"{layout.name}.h").write_text(c_source.header(unit), encoding="utf-8")
        (folder / f"{layout.name}.c").write_text(c_source.source(unit), encoding="utf-8")
    heads = ["#include <stdint.h>", "#include <stdio.h>", *(f'#include "{x.name}.h"' for x in layouts)]
    calls = "".join(f"    run_{x.name}();\n" for x in layouts)
    main = "\n".join(
        [*heads, *(driver(u, **numbers) for u in units), f"int main(void)\n{{\n{calls}    return 0;\n}}\n"]
    )
    (folder / "main.c").write_text(main, encoding="utf-8")
    program = folder / "program"
    sources = [str(folder / "main.c"), *(str(folder / f"{x.name}.c") for x in layouts)]
    subprocess.run(["gcc", *STRICT, *flags, *sources, "-o", str(program), "-lm"], check=True)
    # A controller without arguments reads a number for each step, too.
    wide = [r if r.shape[1] else np.zeros((len(r), 1)) for r in rows]
    given = b"".join(struct.pack("<Q", len(r)) + np.ascontiguousarray(r).tobytes() for r in wide)
    found = np.frombuffer(subprocess.run([program], input=given, capture_output=True, check=True).stdout)
    results, place = [], 0
    for layout, own in zip(layouts, rows, strict=True):
        size = len(own) * len(layout.outputs)
        results.append(found[place : place + size].reshape(len(own), -1))
        place += size
    return results
