// Shows the pictures that arrive; sends the point that is chosen in them.
(function () {
  const vscode = acquireVsCodeApi();
  const byId = (id) => document.getElementById(id);
  const message = byId("message");
  const pictures = byId("pictures");
  const chosen = byId("with-point");
  const sliders = byId("inputs");
  const svgs = {};
  let shown;
  const values = {};
  let sent = 0;

  window.addEventListener("message", ({ data }) => {
    if (!data.terms) {
      // What was drawn last stays, marked.
      message.textContent = shown ? `Not up to date: ${data.message}` : data.message;
      pictures.classList.toggle("stale", shown !== undefined);
      return;
    }
    shown = data;
    message.textContent = data.message;
    pictures.classList.remove("stale");
    for (const name of ["surface", "rules", "terms"]) {
      draw(name, data[name]);
    }
    byId("surface").alt = `Surface of ${data.title}${data.region ? `, marked: ${data.region.text}` : ""}`;
    byId("rules").alt = `Rules that act at ${data.inputs.map(({ name, value }) => `${name} = ${value}`).join(", ")}`;
    for (const { name, value } of data.inputs) {
      // A slider that has moved since is ahead of the answer.
      values[name] = data.serial === sent ? value : (values[name] ?? value);
    }
    chosen.checked = data.serial === sent ? data.pointed : chosen.checked;
    showSliders(data.inputs);
    showMark();
  });

  /** The point in the map; over one input a line. */
  function showMark() {
    const mark = byId("mark");
    mark.hidden = !shown.frame || !chosen.checked;
    if (mark.hidden) {
      return;
    }
    const { left, top, width, height, axes } = shown.frame;
    const [x, y] = axes.map((axis) => {
      const { low, high } = shown.inputs.find((i) => i.name === axis);
      return (values[axis] - low) / (high - low);
    });
    const percent = (part) => `${100 * part}%`;
    mark.classList.toggle("line", y === undefined);
    mark.style.left = percent(left + x * width);
    mark.style.top = percent(y === undefined ? top : top + (1 - y) * height);
    mark.style.height = y === undefined ? percent(height) : "";
  }

  // Many variables make a wide picture, which scrolls rather than becoming too small.
  byId("rules").addEventListener("load", ({ target }) => (target.style.minWidth = `${0.6 * target.naturalWidth}px`));

  function draw(name, svg) {
    const image = byId(name);
    image.hidden = svg === "";
    if (svg !== svgs[name]) {
      svgs[name] = svg;
      const old = image.src;
      image.src = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
      URL.revokeObjectURL(old);
    }
  }

  function showSliders(inputs) {
    sliders.hidden = !chosen.checked;
    const names = inputs.map((i) => [i.name, i.label, i.low, i.high].join()).join();
    if (sliders.dataset.names !== names) {
      sliders.dataset.names = names;
      sliders.replaceChildren(...inputs.map(slider));
    }
    for (const input of inputs) {
      byId(`value-${input.name}`).value = values[input.name];
      byId(`number-${input.name}`).value = Number(values[input.name].toPrecision(4));
    }
  }

  function slider(input) {
    const label = document.createElement("label");
    const name = document.createElement("span");
    name.textContent = input.label;
    const range = document.createElement("input");
    Object.assign(range, { type: "range", id: `value-${input.name}`, min: input.low, max: input.high, step: "any" });
    const number = document.createElement("output");
    number.id = `number-${input.name}`;
    range.addEventListener("input", () => {
      values[input.name] = Number(range.value);
      number.value = Number(values[input.name].toPrecision(4));
      showMark();
      send(false);
    });
    label.append(name, range, number);
    return label;
  }

  function send(select) {
    const point = chosen.checked ? shown.inputs.map(({ name }) => ({ name, value: values[name] })) : null;
    sent += 1;
    vscode.postMessage({ point, select, serial: sent });
  }

  chosen.addEventListener("change", () => shown && send(false));

  byId("surface").addEventListener("click", (event) => {
    if (pictures.classList.contains("stale")) {
      return;
    }
    const box = event.target.getBoundingClientRect();
    const { left, top, width, height, axes } = shown.frame;
    const x = ((event.clientX - box.left) / box.width - left) / width;
    const y = 1 - ((event.clientY - box.top) / box.height - top) / height;
    if (x < 0 || x > 1 || y < 0 || y > 1) {
      return;
    }
    axes.forEach((axis, k) => {
      const { low, high } = shown.inputs.find((i) => i.name === axis);
      values[axis] = low + [x, y][k] * (high - low);
    });
    chosen.checked = true;
    send(true);
  });

  // The point is what it was before the page was loaded again.
  vscode.postMessage({ select: false, serial: sent });
})();
