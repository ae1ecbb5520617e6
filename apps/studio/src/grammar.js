// Colours of rule files, from the one grammar in docs/editors, which VS Code and others read, too.
import { StreamLanguage } from "@codemirror/language";
import { tags } from "@lezer/highlight";
import grammar from "../../../docs/editors/fz.tmLanguage.json";

const STYLES = [
  ["comment", "comment"],
  ["string", "string"],
  ["keyword.operator", "operator"],
  ["keyword", "keyword"],
  ["constant.numeric", "number"],
  ["constant", "atom"],
  ["support.function", "function"],
  ["variable.other.declaration", "definition"],
  ["variable", "variableName"],
];
const style = (scope) => STYLES.find(([start]) => scope?.startsWith(start))?.[1] ?? null;

/** Returns a pattern for JavaScript, whose `\\w` knows letters of English only. */
function unicode(match) {
  return match
    .replace(/^\^/, "")
    .replaceAll('\\"', '"')
    .replaceAll("[^\\W\\d]", "[\\p{L}_]")
    .replaceAll("(?!\\w)", "(?![\\p{L}\\p{N}_])")
    .replaceAll("\\w", "\\p{L}\\p{N}_");
}

const patterns = grammar.patterns.map(({ match, name, captures }) => ({
  atStart: match.startsWith("^"),
  regex: new RegExp(unicode(match), "uy"),
  name: style(name),
  captures,
}));

function next(stream, state) {
  const [end, own] = state.waiting.shift();
  stream.pos = end;
  return own;
}

/** Reads one token; what captures of a pattern name waits in the state as pairs of an end and a style. */
function token(stream, state) {
  if (stream.sol()) state.waiting = [];
  if (state.waiting.length > 0) return next(stream, state);
  for (const { atStart, regex, name, captures } of patterns) {
    if (atStart && stream.pos > 0) continue;
    regex.lastIndex = stream.pos;
    const found = regex.exec(stream.string);
    if (!found || found[0] === "") continue;
    if (captures) {
      let end = stream.pos;
      state.waiting = found.slice(1).flatMap((text, k) => (text ? [[(end += text.length), style(captures[k + 1]?.name)]] : []));
      return next(stream, state);
    }
    stream.pos += found[0].length;
    return name;
  }
  stream.next();
  return null;
}

export const fz = StreamLanguage.define({
  name: "fz",
  startState: () => ({ waiting: [] }),
  copyState: (state) => ({ waiting: [...state.waiting] }),
  token,
  languageData: { commentTokens: { line: "#" }, closeBrackets: { brackets: ["(", "[", '"'] } },
  tokenTable: { function: tags.function(tags.variableName), definition: tags.definition(tags.variableName) },
});
