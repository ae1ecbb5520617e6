// Makes what the package holds: the program in one file, and the grammar, whose one source is docs/editors.
import { copyFileSync, mkdirSync } from "node:fs";
import { build } from "esbuild";

mkdirSync("syntaxes", { recursive: true });
copyFileSync("../../docs/editors/fz.tmLanguage.json", "syntaxes/fz.tmLanguage.json");
copyFileSync("../../LICENSE", "LICENSE.txt");
await build({
  entryPoints: ["src/extension.ts"],
  outfile: "out/extension.js",
  bundle: true,
  minify: true,
  platform: "node",
  target: "node18",
  format: "cjs",
  external: ["vscode"],
});
