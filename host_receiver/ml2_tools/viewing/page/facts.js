// The facts about the headset at the top of the page, and the warnings under them.
import { element } from "./elements.js";

export class Facts {
  #facts = document.getElementById("facts");
  #warnings = document.getElementById("warnings");
  #shown = "";

  show({ facts, warnings }) {
    // Elements that stay keep the reader's selection and place.
    const now = JSON.stringify([facts, warnings]);
    if (now === this.#shown) return;
    this.#shown = now;
    this.#facts.replaceChildren(
      ...facts.map((it) =>
        element("div", "", element("dt", "", it.name), element("dd", `level-${it.level}`, it.text)),
      ),
    );
    this.#warnings.replaceChildren(
      ...warnings.map((it) => {
        const name = element("b", "", it.level > 1 ? "error: " : "warning: ");
        return element("li", `level-${it.level}`, name, `${it.row}: ${it.text}`);
      }),
    );
  }
}
