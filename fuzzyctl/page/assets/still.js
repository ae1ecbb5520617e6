// A page of one text: its numbers come after the first paint, which need not wait for them.

const begin = build(document.getElementById("page"));
requestAnimationFrame(() => setTimeout(begin));
