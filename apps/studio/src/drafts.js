// Drafts: each text that was changed, with its undo, in the storage of the browser, which belongs to the
// address and the port of the page. A draft is { name, base, files, state, time }: its file, the text as it was opened or
// saved last, the texts that it uses, the state of the editor with its history, and when it was kept.

const PREFIX = "fuzzyctl draft ";
/** Drafts that the storage does not take, by key: they last as long as the page. */
const held = new Map();

/** Whether a draft says more than its file. */
export const isChanged = ({ base, state }) => state.doc !== base;

/** Whether text is lost when the page is closed. */
export const isLost = () => [...held.values()].some(isChanged);

/** Keeps a draft; if the storage is full, the undo of saved texts goes first, then that of the draft. Returns a line about the loss, "" without one. */
export function keep(key, draft) {
  held.delete(key);
  let refusal = stored(key, draft);
  if (refusal === null) return "";
  if (isFull(refusal)) {
    for (const [other, own] of drafts()) if (other !== key && !isChanged(own)) remove(other);
    refusal = stored(key, draft);
    if (refusal === null) return "";
  }
  const reason = isFull(refusal) ? "the storage of the browser is full" : `the browser refuses storage (${refusal.name})`;
  const { history, ...bare } = draft.state;
  if (stored(key, { ...draft, state: bare }) === null) return `${reason}: undo of ${draft.name} lasts as long as this page`;
  held.set(key, draft);
  return `${reason}: ${draft.name} lasts as long as this page; 'Save' keeps it`;
}

const isFull = (error) => error.name === "QuotaExceededError";

/** Returns null once a draft is in the storage, else the error. */
function stored(key, draft) {
  try {
    localStorage.setItem(PREFIX + key, JSON.stringify(draft));
    return null;
  } catch (error) {
    return error;
  }
}

/** Takes a draft away. */
export function remove(key) {
  held.delete(key);
  try {
    localStorage.removeItem(PREFIX + key);
  } catch {
    return; // a storage that is refused holds none
  }
}

/** Returns pairs of a key and a draft, newest first; a stored text that is no draft is left out. */
export function drafts() {
  const found = new Map();
  try {
    for (const name of Object.keys(localStorage)) if (name.startsWith(PREFIX)) found.set(name.slice(PREFIX.length), read(localStorage.getItem(name)));
  } catch {
    found.clear(); // a storage that is refused holds none
  }
  for (const [key, draft] of held) found.set(key, draft);
  return [...found].filter(([, draft]) => draft !== null).sort(([, a], [, b]) => b.time - a.time);
}

function read(text) {
  let draft;
  try {
    draft = JSON.parse(text);
  } catch {
    return null;
  }
  const sound = typeof draft?.name === "string" && typeof draft.base === "string" && typeof draft.state?.doc === "string" && draft.files instanceof Object;
  return sound ? draft : null;
}
