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
  let values = {};

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
    byId("surface").alt = `Surface of ${data.title}`;
    for (const input of data.inputs) {
      values[input.name] = values[input.name] ?? input.value;
    }
    showSliders(data.inputs);
  });

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
      const [range, number] = [`value-${input.name}`, `number-${input.name}`].map(byId);
      // A slider that is held is ahead of the answer.
      if (document.activeElement !== range) {
        range.value = input.value;
        number.value = Number(input.value.toPrecision(4));
      }
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
      send(false);
    });
    label.append(name, range, number);
    return label;
  }

  function send(select) {
    const point = chosen.checked ? shown.inputs.map(({ name }) => ({ name, value: values[name] })) : null;
    vscode.postMessage({ point, select });
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
    if (document.activeElement) {
      document.activeElement.blur();
    }
    send(true);
  });
})();
