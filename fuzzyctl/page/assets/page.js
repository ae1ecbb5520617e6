// The page: what the file is called, its warnings, and a section for each of its blocks.

const makers = { system: systemSection, controller: controllerSection, loop: loopSection };

/** Puts the blocks of the file into an element; returns what shows their numbers. */
function build(main) {
    redraws.length = pictures.length = 0;
    isDrawn = false;
    computing.clear();
    controlled.clear();
    const runs = [], sources = new Set(facts.sections.map((s) => s.source ?? ""));
    const sourceOf = (text) => (text ? [element("p", { className: "note" }, `Source: ${text}`)] : []);
    const parts = [element("h1", {}, facts.title), ...(sources.size === 1 ? sourceOf(...sources) : [])];
    if (facts.sections.length > 1) {
        const links = facts.sections.map((s, k) => element("a", { href: `#block${k}` }, `${s.kind} ${s.name}`));
        parts.push(element("nav", { "aria-label": "Blocks of the file" }, ...links));
    }
    if (facts.diagnostics.length) {
        const items = facts.diagnostics.map((d) => element("li", {}, element("strong", {}, `${d.severity}[${d.code}]: `), d.message, d.place ? element("span", { className: "note" }, ` (${d.place})`) : "",
            ...d.facts.map((f) => element("span", { className: "note" }, `; ${f}`)), d.help ? `; ${d.help}` : ""));
        parts.push(element("section", { className: "diagnostics" }, element("h2", {}, "Diagnostics"), element("ul", {}, ...items)));
    }
    const begins = facts.sections.map((section, k) => {
        const { side, main: wide, begin, run } = makers[section.kind](section, kernels[k]);
        const source = sources.size > 1 ? sourceOf(section.source) : [];
        const columns = [element("div", { className: "side" }, ...side), element("div", { className: "main" }, ...wide)];
        const title = section.title ? `: ${section.title}` : "";
        const heading = element("h2", {}, `${section.kind} ${section.name}${title}`);
        parts.push(element("article", { id: `block${k}` }, heading, ...source, element("div", { className: side.length ? "parts" : "" }, ...columns)));
        runs.push(...(run ? [run] : []));
        return begin;
    });
    if (runs.length) {
        parts.push(timeBar(runs));
    }
    parts.push(element("footer", { className: "note" }, `Written by fuzzyctl ${facts.version}. All numbers are computed on this page.`));
    main.replaceChildren(...parts);
    return () => {
        pictures.forEach((p) => p.measure());
        isDrawn = true;
        begins.forEach((begin) => begin());
        document.body.dataset.ready = "yes";
    };
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    known.clear();
    redraws.forEach((draw) => draw());
});
