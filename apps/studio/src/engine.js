// Requests to the worker, one at a time, newest first; a worker that takes too long is ended, and another one started.

/** Most milliseconds that a request may take, unless the engine has another limit, and that the start may. */
const LIMIT = 15_000;
const START = 90_000;

export class Engine {
  /**
   * @param {(state: string, detail?: string) => void} tell Hears "starting", "ready", "stopped", "failed".
   * @param limit Most milliseconds that a request may take.
   */
  constructor(tell, limit = LIMIT) {
    this.tell = tell;
    this.files = {};
    this.waiting = [];
    this.count = 0;
    this.limit = limit;
    this.#start();
  }

  /** Makes these files, texts by name, what `use` and `from` read. */
  place(files) {
    this.files = files;
    this.placed = false;
  }

  /**
   * Returns a promise of the answer; of null where a newer request of the same method overtakes this one, or where the
   * worker has been stopped; of a refusal where it does not start, which the next request tries again.
   */
  ask(request) {
    return new Promise((resolve) => {
      const overtaken = this.waiting.findIndex((w) => w.request.method === request.method);
      if (overtaken >= 0) this.waiting.splice(overtaken, 1)[0].resolve(null);
      this.waiting.push({ request, resolve });
      if (this.failed) this.#start();
      this.#next();
    });
  }

  #start() {
    this.ready = this.failed = false;
    this.placed = false;
    this.running = null;
    this.worker = new Worker("worker.js", { type: "module", name: "fuzzyctl" });
    this.worker.onmessage = ({ data }) => this.#hear(data);
    this.worker.onerror = (event) => this.#hear({ failed: event.message || "the worker cannot be loaded" });
    this.#limit(START);
    this.tell("starting");
  }

  #limit(milliseconds) {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.#stop(milliseconds / 1000), milliseconds);
  }

  #hear(data) {
    clearTimeout(this.timer);
    if (data.id === undefined) {
      if (!data.ready) return this.#fail(data.failed);
      this.ready = true;
      this.tell("ready");
    } else if (this.running?.id === data.id) {
      const { resolve } = this.running;
      this.running = null;
      resolve(data.answer ?? { refused: `fuzzyctl failed, please report this: ${data.failed}` });
    }
    this.#next();
  }

  #next() {
    if (!this.ready || this.running || this.waiting.length === 0) return;
    this.running = { id: (this.count += 1), ...this.waiting.shift() };
    const { id, request } = this.running;
    this.worker.postMessage(this.placed ? { id, request } : { id, request, files: this.files });
    this.placed = true;
    this.#limit(this.limit);
  }

  /** Ends a worker that takes too long; what it was asked is not asked again. */
  #stop(seconds) {
    const stopped = this.running;
    if (!stopped) return this.#fail(`the start took more than ${seconds} s`);
    this.worker.terminate();
    for (const { resolve } of [stopped, ...this.waiting]) resolve(null);
    this.waiting = [];
    this.#start();
    this.tell("stopped", `${stopped.request.method} took more than ${seconds} s`);
  }
  /** Ends a worker that does not start. */
  #fail(why) {
    this.worker.terminate();
    this.ready = false;
    this.failed = true;
    const asked = [...(this.running ? [this.running] : []), ...this.waiting];
    Object.assign(this, { running: null, waiting: [] });
    this.tell("failed", why);
    for (const { resolve } of asked) resolve({ refused: `fuzzyctl does not start: ${why}` });
  }
}
