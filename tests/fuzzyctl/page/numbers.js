// Evaluates an expression over the functions of a page's scripts: node numbers.js SCRIPTS EXPRESSION, without a browser.
"use strict";
const { readFileSync } = require("fs");
const [scripts, asked] = process.argv.slice(2);
const made = (_, tag) => ({ tag, own: {}, children: [], setAttribute(key, value) { this.own[key] = value; }, append(...more) { this.children.push(...more); } });
globalThis.addEventListener = () => {};
globalThis.matchMedia = () => ({ addEventListener() {} });
globalThis.getComputedStyle = () => ({ getPropertyValue: () => "", stroke: "none" });
globalThis.document = { createElementNS: made, getElementById: () => ({ textContent: "null" }), createElement: () => ({ getContext: () => ({ measureText: (text) => ({ width: 6 * text.length }) }) }) };
const text = scripts.split(",").map((path) => readFileSync(path, "utf8")).join("\n");
console.log(JSON.stringify(new Function(`${text}\nreturn ${asked};`)()));
