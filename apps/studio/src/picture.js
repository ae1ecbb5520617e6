// The picture: a page in a frame without an origin, which gets each new text as a message and draws it in place.

/** Most milliseconds that the frame may take; pictures that are computed in slices end before. */
const LIMIT = 15_000;

export class Picture {
  /**
   * @param box The element that the frame is put in.
   * @param page Returns a promise of the frame's page, where scripts with a nonce are executed.
   */
  constructor(box, page) {
    Object.assign(this, { box, page, has: false, count: 0, waiting: new Map(), saving: new Map() });
    addEventListener("message", ({ source, data }) => {
      if (source !== this.frame?.contentWindow) return;
      this.saving.get(data.id)?.(data.files);
      this.waiting.get(data.id)?.(data.failed ? `The picture cannot be drawn, please report this: ${data.failed}` : "");
    });
  }

  /** Returns a promise, once a picture is drawn, of why it is none: "" for one that is, null for one that a newer overtook. */
  async show({ facts, script, fresh = false }) {
    const id = (this.count += 1);
    for (const end of this.waiting.values()) end(null);
    this.loaded ??= this.#load();
    if (!(await this.loaded)) {
      this.loaded = null;
      return "fuzzyctl was stopped before there was a page for it.";
    }
    if (id !== this.count) return null;
    let timer;
    const failed = await new Promise((resolve) => {
      this.waiting.set(id, resolve);
      this.frame.contentWindow.postMessage({ id, facts, script, fresh, nonce: this.nonce }, "*");
      timer = setTimeout(() => resolve(this.#ended()), LIMIT);
    });
    clearTimeout(timer);
    this.waiting.delete(id);
    if (failed === "") this.has = true;
    return failed;
  }

  /** Returns a promise of pictures that are shown as files { file, content }; of "names" without content. */
  async files(format, wanted = null) {
    if (!this.has) return [];
    const id = `files ${(this.count += 1)}`;
    const found = await new Promise((resolve) => {
      this.saving.set(id, resolve);
      this.frame.contentWindow.postMessage({ id, format, wanted }, "*");
      setTimeout(() => resolve([]), LIMIT);
    });
    this.saving.delete(id);
    return found;
  }

  /** Moves the sliders of a block to values by name. */
  go(block, point) {
    this.frame?.contentWindow.postMessage({ block, point }, "*");
  }

  async #load() {
    this.nonce = crypto.randomUUID();
    const found = await this.page(this.nonce);
    if (!found?.html) return false;
    const frame = document.createElement("iframe");
    frame.title = "Systems and controllers of the text";
    frame.sandbox = "allow-scripts";
    frame.srcdoc = found.html;
    const loaded = new Promise((resolve) => (frame.onload = resolve));
    this.box.append(frame);
    await loaded;
    this.frame = frame;
    return true;
  }

  /** Takes a frame away that does not answer; the next picture gets another one. */
  #ended() {
    this.frame.remove();
    Object.assign(this, { frame: null, loaded: null, has: false });
    return `The picture took more than ${LIMIT / 1000} s and was stopped.`;
  }
}
