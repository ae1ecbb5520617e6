// Runs the script of a report on stand-ins for a browser's elements; prints how many lines each plot has drawn.
"use strict";
const text = require("fs").readFileSync(process.argv[2], "utf8");

class Element {
  constructor(name, namespaceURI) {
    Object.assign(this, { name, namespaceURI, attributes: {}, children: [], listeners: {}, clientWidth: 500, dataset: {} });
    this.style = { setProperty: () => {} };
  }
  setAttribute(key, value) {
    this.attributes[key] = String(value);
  }
  append(...children) {
    this.children.push(...children.filter((child) => child instanceof Element));
  }
  replaceChildren() {
    this.children = [];
  }
  addEventListener(kind, action) {
    this.listeners[kind] = action;
  }
  all(name) {
    return this.children.flatMap((child) => [...(child.name === name ? [child] : []), ...child.all(name)]);
  }
}

const byId = {};
const between = (open) => text.split(open)[1].split("</script>")[0];
globalThis.addEventListener = () => {};
globalThis.matchMedia = () => ({ addEventListener() {} });
globalThis.document = {
  body: new Element("body", "html"),
  createElement: (name) => new Element(name, "html"),
  createElementNS: (space, name) => new Element(name, space),
  getElementById: (id) => (byId[id] ??= new Element("div", "html")),
};
globalThis.getComputedStyle = () => ({ getPropertyValue: () => "" });
globalThis.requestAnimationFrame = (action) => action();
globalThis.ResizeObserver = class {
  constructor(action) {
    this.action = action;
  }
  observe() {
    this.action();
  }
};
document.getElementById("facts").textContent = between('id="facts">');
new Function(between("<script>"))();
const drawn = Object.keys(byId).filter((id) => id !== "facts").map((id) => byId[id]);
for (const path of drawn.flatMap((plot) => plot.all("path")))
  if (!/^M[\d.-]+ [\d.-]+(L[\d.-]+ [\d.-]+)*/.test(path.attributes.d) || /NaN|Infinity/.test(path.attributes.d))
    throw new Error(`not a line: ${path.attributes.d.slice(0, 60)}`);
for (const button of drawn.flatMap((plot) => plot.all("button"))) {
  button.listeners.click();
  button.listeners.click();
}
console.log(JSON.stringify(drawn.map((plot) => plot.all("path").length)));
