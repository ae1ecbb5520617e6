// Which Python the extension takes, and what it says of the others, with folders and settings in place of VS Code's.
//
// PYTHON is a Python that has fuzzyctl and the extra lsp (default: python3).
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const HERE = dirname(fileURLToPath(import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "fuzzyctl-python-"));
const good = execFileSync(process.env.PYTHON ?? "python3", ["-c", "import sys; print(sys.executable)"], { encoding: "utf8" }).trim();

const vscode = { workspace: {}, extensions: {} };
globalThis.vscode = vscode;

function program(name, script) {
  const path = join(folder, name);
  mkdirSync(dirname(path), { recursive: true });
  writeFileSync(path, `#!/bin/sh\n${script}\n`, { mode: 0o755 });
  return path;
}

async function search({ setting = "", trusted = true, extension, path = "" }) {
  Object.assign(vscode.workspace, {
    workspaceFolders: [{ uri: { fsPath: join(folder, "work") } }],
    isTrusted: trusted,
    getConfiguration: () => ({ get: () => setting }),
  });
  vscode.extensions.getExtension = () => extension && { isActive: false, activate: async () => extension };
  const before = process.env.PATH;
  process.env.PATH = path;
  const found = await createRequire(import.meta.url)(join(folder, "python.cjs")).findPython();
  process.env.PATH = before;
  return found;
}

try {
  await build({
    entryPoints: [join(HERE, "..", "src", "python.ts")],
    outfile: join(folder, "python.cjs"),
    bundle: true,
    platform: "node",
    plugins: [{
      name: "vscode",
      setup(b) {
        b.onResolve({ filter: /^vscode$/ }, () => ({ path: "vscode", namespace: "stub" }));
        b.onLoad({ filter: /.*/, namespace: "stub" }, () => ({ contents: "module.exports = globalThis.vscode" }));
      },
    }],
  });

  assert.deepEqual(await search({ setting: good }), { python: good, tried: [] });
  for (const [setting, lack] of [
    [join(folder, "none"), /^is not there$/],
    [program("bare", "echo pygls lsprotocol"), /^has no pygls, lsprotocol$/],
    [program("old", "echo 'unknown option -P' >&2; exit 2"), /^is older than Python 3\.11$/],
    [program("broken", "echo Traceback: >&2; echo no encodings >&2; exit 1"), /^cannot be run: no encodings$/],
    [folder, /^cannot be run: .*EACCES/],
  ]) {
    const { python, tried } = await search({ setting });
    assert.equal(python, undefined);
    assert.equal(tried[0].python, setting);
    assert.match(tried[0].lack, lack);
  }

  const inFolder = program("work/.venv/bin/python", "echo fuzzyctl");
  const chosen = program("chosen", "echo pygls");
  const extension = { environments: { getActiveEnvironmentPath: () => ({ path: chosen }) } };
  const asked = async (given) => (await search(given)).tried.map(({ python }) => python);
  assert.deepEqual(await asked({ setting: "${workspaceFolder}/.venv/bin/python", extension }), [inFolder]);
  assert.deepEqual(await asked({ extension }), [chosen, inFolder, "python3", "python"]);
  assert.deepEqual(await asked({ extension: {} }), [inFolder, "python3", "python"]);
  assert.deepEqual(await asked({ extension, trusted: false }), ["python3", "python"]);
  program("path/python", "");
  assert.equal((await search({ trusted: false, path: join(folder, "path") })).python, "python");
  console.log("the Python that has fuzzyctl is found, and what others lack is said");
} finally {
  rmSync(folder, { recursive: true, force: true });
}
