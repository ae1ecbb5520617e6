// Makes the studio's folder: npm ci && node build.mjs [FOLDER], `dist` where none is named. PYTHON (default: python3) is
// a Python that has fuzzyctl's parser, lark, installed; everything else is of this repository and of npm.
//
// The folder holds the page, Pyodide, the bytecode of fuzzyctl and lark in one archive, examples, its version, and licences.
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, readdirSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { dirname, join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";
import { loadPyodide } from "pyodide";

const HERE = dirname(fileURLToPath(import.meta.url));
const ROOT = join(HERE, "..", "..");
const OUT = resolve(process.argv[2] ?? join(HERE, "dist"));
const { version } = JSON.parse(readFileSync(join(HERE, "node_modules", "pyodide", "package.json"), "utf8"));
const RUNTIME = `pyodide-${version}`;
const PYODIDE = ["pyodide.asm.mjs", "pyodide.asm.wasm", "python_stdlib.zip", "pyodide-lock.json"];
/** Modules whose text is read: generated Python holds functions of them. */
const READ = ["fuzzyctl/expr.py", "fuzzyctl/kernels/program/ieee.py"];
/** Rooms of fuzzyctl that the worker never imports. */
const LEFT_OUT = new Set(["cli", "experiments", "interop", "sweep", "__pycache__"]);

function files(folder, wanted) {
  return readdirSync(folder, { withFileTypes: true })
    .sort((a, b) => (a.name < b.name ? -1 : 1))
    .flatMap((entry) => {
      if (entry.isDirectory()) return LEFT_OUT.has(entry.name) ? [] : files(join(folder, entry.name), wanted);
      return wanted.test(entry.name) ? [join(folder, entry.name)] : [];
    });
}

/** Returns the bytecode of fuzzyctl and lark, which Pyodide itself compiles, as one zip. */
async function archive() {
  const python = process.env.PYTHON ?? "python3";
  const [lark] = JSON.parse(execFileSync(python, ["-c", "import json, lark; print(json.dumps(list(lark.__path__)))"], { encoding: "utf8" }));
  const pyodide = await loadPyodide();
  for (const folder of [join(ROOT, "fuzzyctl"), lark]) {
    for (const path of files(folder, /\.(py|lark|tables|js|css)$/)) {
      const target = `/pack/${relative(dirname(folder), path)}`;
      pyodide.FS.mkdirTree(dirname(target));
      pyodide.FS.writeFile(target, readFileSync(path));
    }
  }
  pyodide.runPython(`
import compileall, os, zipfile
from py_compile import PycInvalidationMode
read = {os.path.join("/pack", path) for path in ${JSON.stringify(READ)}}
how = {"quiet": 1, "stripdir": "/pack", "prependdir": "/fuzzyctl", "invalidation_mode": PycInvalidationMode.UNCHECKED_HASH}
for folder, _, names in os.walk("/pack"):
    for path in (os.path.join(folder, name) for name in names if name.endswith(".py")):
        assert compileall.compile_file(path, legacy=path not in read, **how), path
        if path not in read:
            os.remove(path)
with zipfile.ZipFile("/fuzzyctl.zip", "w", zipfile.ZIP_DEFLATED, compresslevel=9) as packed:
    for folder, folders, names in os.walk("/pack"):
        folders.sort()
        for name in sorted(names):
            path = os.path.join(folder, name)
            with open(path, "rb") as file:
                packed.writestr(zipfile.ZipInfo(os.path.relpath(path, "/pack")), file.read(), zipfile.ZIP_DEFLATED)
`);
  return { zip: pyodide.FS.readFile("/fuzzyctl.zip"), lark };
}

/** Returns the rule files that come with the repository, each with the files beside it that it uses. */
function examples() {
  const found = [];
  for (const [group, folder] of [["Rule files", "rules"], ["Gallery", "apps/gallery"]]) {
    for (const path of files(join(ROOT, folder), /\.fz$/)) {
      const used = {};
      const text = read(path, used);
      found.push({ group, name: relative(join(ROOT, folder), path).split("/").at(-1), text, files: used });
    }
  }
  return found;
}

/** Returns a text, and adds what its lines `use "..."` and `from "..."` name to the files. */
function read(path, used) {
  const text = readFileSync(path, "utf8");
  for (const [, name] of text.matchAll(/^[^#"\n]*\b(?:use|from)\s+"([^"\n]+)"/gm)) {
    if (!(name in used)) {
      used[name] = "";
      used[name] = read(join(dirname(path), name), used);
    }
  }
  return text;
}

/** Returns the licences of all that is in the folder. */
function notices(metafile, lark) {
  const packages = new Set(Object.keys(metafile.inputs).flatMap((path) => path.match(/^(?:.*\/)?node_modules\/(?:@[^/]+\/)?[^/]+/) ?? []));
  const listed = [...packages].sort().map((folder) => {
    const { name, version, license, repository } = JSON.parse(readFileSync(join(HERE, folder, "package.json"), "utf8"));
    const file = readdirSync(join(HERE, folder)).find((entry) => /^licen[cs]e/i.test(entry));
    const text = file ? readFileSync(join(HERE, folder, file), "utf8").trim() : `Its source: ${repository?.url ?? "npm"}, version ${version}.`;
    return `${name} ${version} (${license})\n\n${text}\n`;
  });
  const info = readdirSync(dirname(lark)).find((entry) => /^lark-.*\.dist-info$/.test(entry));
  const licence = files(join(dirname(lark), info), /^LICEN[CS]E/)[0];
  const metadata = readFileSync(join(dirname(lark), info, "METADATA"), "utf8");
  return [
    `fuzzyctl (BSD-3-Clause)\n\n${readFileSync(join(ROOT, "LICENSE"), "utf8").trim()}\n`,
    `${info.replace(".dist-info", "").replace("-", " ")} (${metadata.match(/^License(?:-Expression)?: (.*)$/m)[1]})\n\n${readFileSync(licence, "utf8").trim()}\n`,
    "CPython 3.14, its standard library and its interpreter inside of Pyodide (PSF-2.0)\n\nhttps://docs.python.org/3.14/license.html\n",
    ...listed,
  ].join(`\n${"-".repeat(80)}\n\n`);
}

rmSync(OUT, { recursive: true, force: true });
mkdirSync(join(OUT, RUNTIME), { recursive: true });
const { metafile } = await build({
  entryPoints: [join(HERE, "src", "main.js"), join(HERE, "src", "worker.js")],
  outdir: OUT,
  absWorkingDir: HERE,
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  external: ["node:*", "ws"],
  define: { RUNTIME: JSON.stringify(RUNTIME) },
  metafile: true,
});
for (const name of ["index.html", "style.css"]) copyFileSync(join(HERE, "src", name), join(OUT, name));
for (const name of PYODIDE) copyFileSync(join(HERE, "node_modules", "pyodide", name), join(OUT, RUNTIME, name));
const { zip, lark } = await archive();
writeFileSync(join(OUT, "fuzzyctl.zip"), zip);
writeFileSync(join(OUT, "examples.json"), JSON.stringify(examples()));
writeFileSync(join(OUT, "version.txt"), readFileSync(join(ROOT, "fuzzyctl", "__init__.py"), "utf8").match(/^__version__ = "(.+)"$/m)[1]);
writeFileSync(join(OUT, "NOTICES.txt"), notices(metafile, lark));
const size = readdirSync(OUT, { recursive: true }).reduce((sum, name) => sum + statSync(join(OUT, name)).size, 0);
console.log(`wrote ${relative(process.cwd(), OUT) || OUT}: ${(size / 1e6).toFixed(1)} MB`);
process.exit(0); // Pyodide keeps node awake
