// A page whose text changes, in a frame: a message { id, facts, script, nonce, fresh } brings a new one. The one before stays until all
// surfaces of the new one are drawn; then the answer is { id }, or { id, failed }. What was set on the page stays set, unless the
// text is `fresh`, that of another file. A message
// { id, format, wanted } asks for pictures as files, see `filesOf`; the answer is { id, files }. A message { block, point } moves a
// block to values by name.

let shownPage = document.getElementById("page"), nextPage = null, pressed = false;
for (const type of ["pointerdown", "pointermove", "pointerup", "pointercancel", "blur"]) {
    addEventListener(type, ({ buttons }) => {
        if (pressed !== (pressed = Boolean(buttons))) {
            setTimeout(() => settled()); // what waits for the end of a drag
        }
    });
}

/** What the keyboard is at, as a function that finds it on another page. */
function focused() {
    const reached = "input, select, button, summary, a, [tabindex]", at = document.activeElement;
    const block = at?.closest("article, .remarks, section.times"), own = block?.id ? `#${block.id}` : "section.times";
    const place = block ? [...block.querySelectorAll(reached)].indexOf(at) : -1;
    return (page) => page.querySelector(own)?.querySelectorAll(reached)[place];
}

addEventListener("message", ({ source, data }) => {
    if (source !== parent) {
        return;
    }
    const answer = (more = {}) => parent.postMessage({ id: data.id, ...more }, "*");
    if (data.format !== undefined) {
        filesOf(shownPage, data.format, data.wanted).then((files) => answer({ files }));
        return;
    }
    if (data.point !== undefined) {
        controlled.get(data.block)?.go(data.point);
        return;
    }
    nextPage?.remove();
    const own = (nextPage = element("main", { className: "next" }));
    settled = () => {};
    if (data.fresh) {
        settings.clear();
    }
    try {
        facts = data.facts;
        globalThis.kernels = null;
        const script = element("script", { nonce: data.nonce, textContent: data.script });
        document.head.append(script);
        script.remove();
        document.body.append(own);
        build(own)();
    } catch (error) {
        own.remove();
        answer({ failed: String(error) });
        return;
    }
    settled = () => {
        if (computing.size > 0 || (pressed && !data.fresh)) {
            return;
        }
        const again = focused();
        const top = data.fresh ? 0 : document.documentElement.scrollTop;
        settled = () => {};
        nextPage = null;
        shownPage.replaceWith(own);
        own.className = "";
        own.id = "page";
        shownPage = own;
        again(own)?.focus({ preventScroll: true });
        document.documentElement.scrollTop = top;
        answer();
    };
    settled();
});
