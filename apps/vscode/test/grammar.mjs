// Colours every shipped rule file with VS Code's own engine, and compares that with the Pygments lexer.
//
// PYTHON is a Python that has fuzzyctl (default: python3).
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const HERE = dirname(fileURLToPath(import.meta.url));
const MODULES = join(HERE, "node_modules", "code-server", "lib", "vscode", "node_modules");
const require = createRequire(join(MODULES, "index.js"));
const { INITIAL, Registry } = require("vscode-textmate");
const { loadWASM, OnigScanner, OnigString } = require("vscode-oniguruma");

/** Prints, for each line of each file, its pieces that are not blank with their scopes. */
const LEXER = `
import json, pathlib, sys
from fuzzyctl.lang.highlight import TOKENS, FuzzyLexer
scopes = {token: scope for scope, token in TOKENS.items()}
lexer = FuzzyLexer(stripnl=False, ensurenl=False)
files = [p for folder in sys.argv[1:] for p in sorted(pathlib.Path(folder).rglob("*.fz"))]
print(json.dumps({
    str(p): [
        [line, [[scopes.get(token, "error"), text.strip()] for token, text in lexer.get_tokens(line) if text.strip()]]
        for line in p.read_text(encoding="utf-8").split("\\n")
    ]
    for p in files
}))
`;

async function grammarOfEditor() {
  await loadWASM(readFileSync(join(MODULES, "vscode-oniguruma", "release", "onig.wasm")).buffer);
  const registry = new Registry({
    onigLib: Promise.resolve({
      createOnigScanner: (patterns) => new OnigScanner(patterns),
      createOnigString: (text) => new OnigString(text),
    }),
    loadGrammar: async () => JSON.parse(readFileSync(join(HERE, "..", "syntaxes", "fz.tmLanguage.json"), "utf8")),
  });
  return registry.loadGrammar("source.fz");
}

/** The pieces of a line, as the editor has them; blanks have no scope, as what has no place in a line. */
function pieces(grammar, line) {
  return grammar.tokenizeLine(line, INITIAL).tokens
    .map(({ startIndex, endIndex, scopes }) => [scopes[1] ?? "error", line.slice(startIndex, endIndex).trim()])
    .filter(([, text]) => text !== "");
}

const root = join(HERE, "..", "..", "..");
const python = process.env.PYTHON ?? "python3";
const folders = ["rules", "docs", join("apps", "gallery"), "tests"].map((name) => join(root, name));
const files = JSON.parse(execFileSync(python, ["-c", LEXER, ...folders], { encoding: "utf8", maxBuffer: 1 << 28 }));
const grammar = await grammarOfEditor();
let lines = 0;
for (const [path, entries] of Object.entries(files)) {
  for (const [line, expected] of entries) {
    assert.deepEqual(pieces(grammar, line), expected, `${path}: ${line}`);
    lines += 1;
  }
}
assert(lines > 0);
console.log(`${lines} lines of ${Object.keys(files).length} files have the colours of the lexer`);
