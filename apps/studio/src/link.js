// Links that carry a text: #name=...&text=...&files=..., the text deflated, in base 64 of URLs, and so the files that it uses, as
// JSON. `fuzzyctl studio FILE` writes the same.

/** Most bytes that a text, or the files, of a link may have: fewer than would stop the tab. */
const MOST = 1_000_000;
/** Most characters of a link: browsers take more, what people send links with does not. */
const LONGEST = 100_000;

async function through(bytes, transform) {
  const reader = new Blob([bytes]).stream().pipeThrough(transform).getReader();
  const parts = [];
  let size = 0;
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    parts.push(part.value);
    size += part.value.length;
    if (size > MOST) throw new RangeError(`the text of the link has more than ${MOST} bytes`);
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}

async function packed(text) {
  const bytes = await through(new TextEncoder().encode(text), new CompressionStream("deflate-raw"));
  const binary = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
  return btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

async function unpacked(base64) {
  if (!/^[\w-]*$/.test(base64)) throw new TypeError("it has characters that a link does not have");
  const binary = atob(base64.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = Uint8Array.from(binary, (letter) => letter.charCodeAt(0));
  return new TextDecoder("utf-8", { fatal: true }).decode(await through(bytes, new DecompressionStream("deflate-raw")));
}

/** Returns the files that a text names in quotes, and those that they name, by name. */
function used(text, files) {
  const found = {};
  for (const waiting = [text]; waiting.length > 0; ) {
    for (const [, name] of waiting.pop().matchAll(/"([^"\n]+)"/g)) {
      if (!Object.hasOwn(files, name) || Object.hasOwn(found, name)) continue;
      found[name] = files[name];
      waiting.push(files[name]);
    }
  }
  return found;
}

/** Whether a name stands for a file in the folder of the text, or below it. */
const inside = (name) => name.length <= 200 && !name.includes("\0") && !/(^|[/\\])\.{0,2}([/\\]|$)/.test(name);

/** Returns the address that holds a text and the files that it uses; throws where that would be too long. */
export async function link(name, text, files) {
  const own = used(text, files);
  const more = Object.keys(own).length > 0 ? `&files=${await packed(JSON.stringify(own))}` : "";
  const url = `${location.origin}${location.pathname}#name=${encodeURIComponent(name)}&text=${await packed(text)}${more}`;
  if (url.length > LONGEST) throw new RangeError(`the link would have ${url.length} characters, more than ${LONGEST}; save the rule file`);
  return url;
}

/** Returns { name, text, files } of an address, null for one without a text; throws for one that is broken. */
export async function linked(hash) {
  const found = new URLSearchParams(hash.replace(/^#/, ""));
  const base64 = found.get("text");
  if (base64 === null) return null;
  const files = found.has("files") ? JSON.parse(await unpacked(found.get("files"))) : {};
  for (const [name, text] of Object.entries(files)) {
    if (!inside(name) || typeof text !== "string") throw new TypeError(`'${name}' is not the name of a file`);
  }
  return { name: found.get("name") || "linked.fz", text: await unpacked(base64), files };
}
