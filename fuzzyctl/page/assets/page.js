// The page: what the file is called, its warnings, and a section for each of its blocks.

const makers = { system: systemSection, controller: controllerSection, loop: loopSection };
const main = document.getElementById("page");
main.replaceChildren(element("h1", {}, facts.title));
if (facts.sections.length > 1) {
    const links = facts.sections.map((s, k) => element("a", { href: `#block${k}` }, `${s.kind} ${s.name}`));
    main.append(element("nav", { "aria-label": "Blocks of the file" }, ...links));
}
if (facts.diagnostics.length) {
    const items = facts.diagnostics.map((d) => element("li", {}, element("strong", {}, `${d.severity}[${d.code}]: `), d.message,
        ...d.facts.map((f) => element("span", { className: "note" }, `; ${f}`)), d.help ? `; ${d.help}` : ""));
    main.append(element("section", { className: "diagnostics" }, element("h2", {}, "Diagnostics"), element("ul", {}, ...items)));
}
const bars = [];
const begins = facts.sections.map((section, k) => {
    const { parts, begin, bar } = makers[section.kind](section, kernels[k]);
    const source = section.source ? [element("p", { className: "note" }, `Source: ${section.source}`)] : [];
    const title = section.title ? `: ${section.title}` : "";
    const heading = element("h2", {}, `${section.kind} ${section.name}${title}`);
    main.append(element("article", { id: `block${k}` }, heading, ...source, element("div", { className: "parts" }, ...parts)));
    bars.push(...(bar ? [bar] : []));
    return begin;
});
if (bars.length) {
    main.append(element("section", { className: "times", "aria-label": "Times of runs" }, ...bars));
}
main.append(element("footer", { className: "note" }, `Written by fuzzyctl ${facts.version}. All numbers are computed on this page.`));
const again = () => redraws.forEach((draw) => draw());
// After the first paint, which need not wait for numbers.
requestAnimationFrame(() => setTimeout(() => {
    begins.forEach((begin) => begin());
    again();
    document.body.dataset.ready = "yes";
}));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
