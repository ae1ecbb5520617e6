// The worker: Pyodide with fuzzyctl. A message is { id, files, request } or { id, request }; the answer { id, answer },
// or { id, failed } for what no diagnostic says. The first message is { ready } or { failed } by itself.
import { loadPyodide } from "pyodide";

const FOLDER = "/files";
const started = start();
started.then(
  () => postMessage({ ready: true }),
  (error) => postMessage({ failed: String(error) }),
);

async function start() {
  const packed = fetch("fuzzyctl.zip").then((response) => {
    if (!response.ok) throw new Error(`fuzzyctl.zip: ${response.status}`);
    return response.arrayBuffer();
  });
  const pyodide = await loadPyodide({ indexURL: new URL(`${RUNTIME}/`, location.href).href });
  pyodide.unpackArchive(await packed, "zip", { extractDir: "/fuzzyctl" });
  pyodide.FS.mkdirTree(FOLDER);
  pyodide.runPython(`
import gc, os, sys
sys.path.insert(0, "/fuzzyctl")
os.chdir("${FOLDER}")
from fuzzyctl.studio.arrays import install
install()
import fuzzyctl.lang.grammar
from fuzzyctl.studio.answers import answer
gc.freeze()
`);
  return { pyodide, answer: pyodide.globals.get("answer") };
}

/** Takes everything out of a folder. */
function empty(system, folder) {
  for (const name of system.readdir(folder).filter((n) => n !== "." && n !== "..")) {
    const path = `${folder}/${name}`;
    if (system.isDir(system.stat(path).mode)) {
      empty(system, path);
      system.rmdir(path);
    } else system.unlink(path);
  }
}

/** Makes the folder of the text hold these files, and no others. */
function place(pyodide, files) {
  empty(pyodide.FS, FOLDER);
  for (const [name, text] of Object.entries(files)) {
    const path = `${FOLDER}/${name}`;
    pyodide.FS.mkdirTree(path.slice(0, path.lastIndexOf("/")));
    pyodide.FS.writeFile(path, text);
  }
  pyodide.runPython("from fuzzyctl.studio.answers import document; document.cache_clear()");
}

onmessage = async ({ data }) => {
  try {
    const { pyodide, answer } = await started;
    if (data.files) place(pyodide, data.files);
    postMessage({ id: data.id, answer: JSON.parse(answer(JSON.stringify(data.request))) });
  } catch (error) {
    postMessage({ id: data.id, failed: String(error) });
  }
};
