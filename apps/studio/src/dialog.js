// The dialog: what can be chosen, as buttons, each reached by the keyboard. It closes with a choice, or with Escape.

const at = (id) => document.getElementById(id);

/** Returns a button. */
export function button(text, click) {
  const found = document.createElement("button");
  found.type = "button";
  found.textContent = text;
  found.onclick = click;
  return found;
}

/**
 * Offers what can be chosen.
 * @param title Of the dialog.
 * @param groups Pairs of a heading and a list of choices: a text and what happens, or a text and pairs of both.
 * @param lead An element above them, null for none.
 */
export function offer(title, groups, lead = null) {
  at("choice-title").textContent = title;
  const parts = groups.filter(([, choices]) => choices.length > 0).flatMap(([name, choices]) => {
    const heading = document.createElement("h3");
    heading.textContent = name;
    const list = document.createElement("ul");
    list.className = choices.length > 12 ? "wide" : "";
    list.append(...choices.map(entry));
    return name ? [heading, list] : [list];
  });
  at("offered").replaceChildren(...(lead ? [lead] : []), ...parts);
  at("choice").showModal();
}

function entry([text, act]) {
  const item = document.createElement("li");
  const chosen = (label, own) => button(label, () => {
    at("choice").close();
    own();
  });
  if (typeof act === "function") item.append(chosen(text, act));
  else {
    item.append(text, ...act.map(([label, own]) => {
      const made = chosen(label, own);
      made.setAttribute("aria-label", `${text}: ${label}`);
      return made;
    }));
  }
  return item;
}

at("close").onclick = () => at("choice").close();
