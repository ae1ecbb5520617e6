// Links that carry a text: #name=...&text=..., the text deflated, in base 64 of URLs. `fuzzyctl studio FILE` writes the same.

/** Most bytes that a text from a link may have: fewer than would stop the tab. */
const MOST = 1_000_000;

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

export async function link(name, text) {
  const packed = await through(new TextEncoder().encode(text), new CompressionStream("deflate-raw"));
  const binary = Array.from(packed, (byte) => String.fromCharCode(byte)).join("");
  const base64 = btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
  return `${location.origin}${location.pathname}#name=${encodeURIComponent(name)}&text=${base64}`;
}

/** Returns { name, text } of an address, null for one without a text; throws for one that is broken. */
export async function linked(hash) {
  const found = new URLSearchParams(hash.replace(/^#/, ""));
  const base64 = found.get("text");
  if (base64 === null) return null;
  const binary = atob(base64.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = Uint8Array.from(binary, (letter) => letter.charCodeAt(0));
  const text = await through(bytes, new DecompressionStream("deflate-raw"));
  return { name: found.get("name") || "linked.fz", text: new TextDecoder("utf-8", { fatal: true }).decode(text) };
}
