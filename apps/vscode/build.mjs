// Makes what the package holds: the program in one file, the licences of what is in it, and the grammar, whose one source is
// docs/editors.
import { copyFileSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

mkdirSync("syntaxes", { recursive: true });
copyFileSync("../../docs/editors/fz.tmLanguage.json", "syntaxes/fz.tmLanguage.json");
copyFileSync("../../LICENSE", "LICENSE.txt");
const { metafile } = await build({
  entryPoints: ["src/extension.ts"],
  outfile: "out/extension.js",
  bundle: true,
  minify: true,
  platform: "node",
  target: "node18",
  format: "cjs",
  external: ["vscode"],
  metafile: true,
});
const packages = new Set(Object.keys(metafile.inputs).flatMap((path) => path.match(/^(?:.*\/)?node_modules\/(?:@[^/]+\/)?[^/]+/) ?? []));
const notices = [...packages].sort().map((folder) => {
  const { name, version, license } = JSON.parse(readFileSync(`${folder}/package.json`, "utf8"));
  const file = readdirSync(folder).find((entry) => /^licen[cs]e/i.test(entry));
  return `${name} ${version} (${license})\n\n${readFileSync(`${folder}/${file}`, "utf8").trim()}\n`;
});
writeFileSync("NOTICES.txt", notices.join(`\n${"-".repeat(80)}\n\n`));
