// The Python that has fuzzyctl.
import { execFile } from "node:child_process";
import { existsSync } from "node:fs";
import { join } from "node:path";
import * as vscode from "vscode";

/** Modules without which the server does not start. */
const MODULES = ["fuzzyctl", "pygls", "lsprotocol"];
const PROBE = `import importlib.util as u; print(*(m for m in ${JSON.stringify(MODULES)} if u.find_spec(m) is None))`;
const SECONDS = 30;

/** A Python that has all modules, or what is wrong with each of those that were tried. */
export interface Search {
  python?: string;
  tried: { python: string; lack: string }[];
}

/** The folder's own modules are not imported: a `json.py` in it would be taken for Python's. */
export function serverArguments(): string[] {
  return ["-P", "-m", "fuzzyctl", "lsp"];
}

/** Look for the Python: a setting is the only candidate where there is one. */
export async function findPython(): Promise<Search> {
  const tried: Search["tried"] = [];
  for (const python of await candidates()) {
    const lack = await lackOf(python);
    if (lack === "") {
      return { python, tried };
    }
    tried.push({ python, lack });
  }
  return { tried };
}

async function candidates(): Promise<string[]> {
  const folders = (vscode.workspace.workspaceFolders ?? []).map((f) => f.uri.fsPath);
  const set = vscode.workspace.getConfiguration("fuzzyctl").get<string>("python", "").trim();
  if (set !== "") {
    return [set.replace("${workspaceFolder}", folders[0] ?? "")];
  }
  const found: string[] = [];
  if (vscode.workspace.isTrusted) {
    const chosen = await interpreterOfPythonExtension();
    if (chosen !== undefined) {
      found.push(chosen);
    }
    const inside = process.platform === "win32" ? ["Scripts", "python.exe"] : ["bin", "python"];
    found.push(...folders.map((f) => join(f, ".venv", ...inside)).filter((p) => existsSync(p)));
  }
  return [...new Set([...found, "python3", "python"])];
}

/** The part of the Python extension's interface that is used. */
interface PythonExtension {
  environments?: { getActiveEnvironmentPath(resource?: vscode.Uri): { path: string } | undefined };
}

async function interpreterOfPythonExtension(): Promise<string | undefined> {
  const extension = vscode.extensions.getExtension<PythonExtension>("ms-python.python");
  if (extension === undefined) {
    return undefined;
  }
  const api = extension.isActive ? extension.exports : await extension.activate();
  return api?.environments?.getActiveEnvironmentPath(vscode.workspace.workspaceFolders?.[0]?.uri)?.path;
}

/** Return what a Python lacks, in words; nothing for one that has all. */
function lackOf(python: string): Promise<string> {
  return new Promise((resolve) => {
    execFile(python, ["-P", "-c", PROBE], { timeout: SECONDS * 1000 }, (error, stdout, stderr) => {
      if (error === null) {
        const missing = stdout.trim().split(/\s+/).join(", ");
        resolve(missing === "" ? "" : `has no ${missing}`);
      } else if (error.code === ("ENOENT" as unknown)) {
        resolve("is not there");
      } else if (error.killed) {
        resolve(`did not answer within ${SECONDS} s`);
      } else if (stderr.includes("-P")) {
        resolve("is older than Python 3.11");
      } else {
        resolve(`cannot be run: ${(stderr || error.message).trim().split("\n").pop()}`);
      }
    });
  });
}
