// The page: what the file is called, a section for each of its blocks, and remarks on the file.

const makers = { system: systemSection, controller: controllerSection, loop: loopSection };

/** Errors, warnings and hints of the file, folded; their numbers, which a link and the summary say. */
function remarkList() {
    const kinds = ["error", "warning", "hint"].map((kind) => [kind, facts.diagnostics.filter((d) => d.severity === kind).length]);
    const counts = kinds.filter(([, n]) => n).map(([kind, n]) => `${n} ${kind}${n > 1 ? "s" : ""}`).join(", ");
    const items = facts.diagnostics.map((d) => element("li", {}, element("strong", {}, `${d.severity}[${d.code}]: `), d.message, d.place ? element("span", { className: "note" }, ` (${d.place})`) : "",
        ...d.facts.map((f) => element("span", { className: "note" }, `; ${f}`)), d.help ? `; ${d.help}` : ""));
    const list = element("details", { open: settings.get("remarks") ?? false, ontoggle: () => settings.set("remarks", list.open) },
        element("summary", {}, element("h2", {}, "Remarks"), ` ${counts}`), element("ul", {}, ...items));
    return { counts, list, box: element("section", { id: "remarks", className: "remarks" }, list) };
}

/** Puts the blocks of the file into an element; returns what shows their numbers. */
function build(main) {
    redraws.length = pictures.length = 0;
    isDrawn = false;
    computing.clear();
    controlled.clear();
    const runs = [], sources = new Set(facts.sections.map((s) => s.source ?? ""));
    const sourceOf = (text) => (text ? [element("p", { className: "note" }, `Source: ${text}`)] : []);
    const parts = [element("h1", {}, facts.title), ...(sources.size === 1 ? sourceOf(...sources) : [])];
    const links = facts.sections.map((s, k) => element("a", { href: `#block${k}` }, `${s.kind} ${s.name}`)).filter((_, k, { length }) => length > 1);
    const remarks = facts.diagnostics.length ? remarkList() : null;
    if (remarks !== null) {
        links.push(element("a", { href: "#remarks", onclick: () => (remarks.list.open = true) }, remarks.counts));
    }
    if (links.length) {
        parts.push(element("nav", { "aria-label": "Parts of the page" }, ...links));
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
    parts.push(...(remarks === null ? [] : [remarks.box]));
    if (runs.length) {
        parts.push(timeBar(runs));
    }
    const origin = runs.length ? "Loops were run beforehand; all other numbers" : "All numbers";
    parts.push(element("footer", { className: "note" }, `Written by fuzzyctl ${facts.version}. ${origin} are computed on this page.`));
    main.replaceChildren(...parts);
    return () => {
        pictures.forEach((p) => p.measure());
        isDrawn = true;
        begins.forEach((begin) => begin());
        document.body.dataset.ready = "yes";
    };
}
