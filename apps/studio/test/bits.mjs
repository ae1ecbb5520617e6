// Compares the studio's numbers with CPython's, to the last bit: node test/bits.mjs, with PYTHON as for run.mjs.
//
// Pyodide and fuzzyctl are those of the built folder. Systems without transcendental functions have the same bits in CPython, in
// Pyodide and in the JavaScript that the picture computes with; of the others the largest difference is printed.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readdirSync, readFileSync } from "node:fs";
import { basename, dirname, join, relative } from "node:path";
import { fileURLToPath } from "node:url";
import { loadPyodide } from "pyodide";

const HERE = dirname(fileURLToPath(import.meta.url));
const ROOT = join(HERE, "..", "..", "..");
const DIST = join(HERE, "..", "dist");
const FOLDERS = ["rules", "apps/gallery"];
const PROGRAM = readFileSync(join(HERE, "bits.py"), "utf8");
// Without the line of Pyodide that an error comes from: it has a million characters.
process.on("uncaughtException", (error) => {
  console.error(error.message);
  process.exit(1);
});
const wide = { encoding: "utf8", maxBuffer: 1e9 };

const expected = JSON.parse(execFileSync(process.env.PYTHON ?? "python3", ["-c", PROGRAM, ...FOLDERS], { cwd: ROOT, ...wide }));
const pyodide = await loadPyodide({ indexURL: join(DIST, readdirSync(DIST).find((name) => name.startsWith("pyodide-"))) });
pyodide.unpackArchive(new Uint8Array(readFileSync(join(DIST, "fuzzyctl.zip"))), "zip", { extractDir: "/fuzzyctl" });
const texts = FOLDERS.flatMap((folder) => readdirSync(join(ROOT, folder), { recursive: true })
  .map((name) => join(ROOT, folder, name)).filter((path) => /\.(fz|csv)$/.test(path)));
for (const path of texts) {
  const target = join("/files", relative(ROOT, path));
  pyodide.FS.mkdirTree(dirname(target));
  pyodide.FS.writeFile(target, new Uint8Array(readFileSync(path)));
}
pyodide.runPython("import os, sys; sys.path.insert(0, '/fuzzyctl'); os.chdir('/files')");
pyodide.runPython(PROGRAM.replace(/\nif __name__[^]*$/, ""));
const found = JSON.parse(pyodide.globals.get("numbers")(pyodide.toPy(FOLDERS)));
const answer = pyodide.runPython("from fuzzyctl.studio.answers import answer; answer");

/** Returns the bits of a number as Python prints them. */
function bits(value) {
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, value);
  return view.getBigUint64(0);
}

const number = (hex) => {
  const [, sign, whole, part, power] = /^(-?)0x([01])\.([0-9a-f]+)p([+-]\d+)$/.exec(hex) ?? [];
  if (whole === undefined) return { nan: NaN, inf: Infinity, "-inf": -Infinity }[hex];
  const size = (parseInt(whole, 16) + parseInt(part, 16) / 16 ** part.length) * 2 ** Number(power);
  return sign ? -size : size;
};

let systems = 0;
let compared = 0;
let largest = 0;
for (const path of texts.filter((p) => p.endsWith(".fz"))) {
  const file = join("/files", relative(ROOT, path));
  const { facts, script, refused } = JSON.parse(answer(JSON.stringify({ method: "picture", file, text: readFileSync(path, "utf8") })));
  const kernels = refused ? [] : new Function(`${script}; return kernels;`)();
  for (const [key, { exact, points, values }] of Object.entries(expected)) {
    const [name, system] = key.split(" ");
    if (name !== basename(path)) continue;
    const own = facts?.sections.findIndex((s) => s.kind === "system" && s.name === system) ?? -1;
    systems += exact ? 1 : 0;
    if (own < 0) console.log(`note: no picture of ${key}: ${refused}`);
    for (const [k, point] of points.entries()) {
      if (exact) assert.deepEqual(found[key].values[k], values[k], `${key} at ${point}, Pyodide`);
      compared += values[k].length;
      if (own < 0) continue;
      let result;
      try {
        result = kernels[own].evaluate(...point);
      } catch (error) {
        assert.deepEqual([error.output], values[k], `${key} at ${point}: ${error}`);
        continue;
      }
      for (const [n, value] of [result].flat().entries()) {
        const wanted = number(values[k][n]);
        if (exact) assert.equal(bits(value), bits(wanted), `${key} at ${point}, JavaScript: ${value} is not ${wanted}`);
        else if (Number.isFinite(wanted)) largest = Math.max(largest, Math.abs(value - wanted) / Math.max(1, Math.abs(wanted)));
      }
    }
  }
}
assert.ok(systems > 10);
console.log(`ok   ${compared} numbers; the same bits in CPython, Pyodide and JavaScript for ${systems} systems of ${Object.keys(expected).length}`);
console.log(`     largest difference of JavaScript for the others, with transcendental functions: ${largest.toExponential(1)}`);
process.exit(0); // Pyodide keeps node awake
