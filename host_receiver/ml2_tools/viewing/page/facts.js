// The facts about the headset at the top of the page, and under them the warnings and the lost messages.
import { element, setText } from "./elements.js";

export class Facts {
  #facts = document.getElementById("facts");
  #warnings = document.getElementById("warnings");
  #losses = document.getElementById("losses");
  #shown = "";

  show({ facts, warnings, losses }) {
    // Elements that stay keep the reader's selection and place.
    const now = JSON.stringify([facts, warnings, losses]);
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
    this.#showLosses(losses);
  }

  #showLosses(losses) {
    this.#losses.hidden = !losses.length;
    const recent = losses.filter((it) => it.recent);
    const count = recent.reduce((sum, it) => sum + it.recent, 0);
    const words = count ? `${counted(count, "message")} of ${counted(recent.length, "topic")}` : "nothing";
    const summary = this.#losses.querySelector("summary");
    summary.className = count ? "level-1" : "quiet";
    setText(summary, `lost in the last 10 s: ${words}`);
    const cells = (it) => [it.topic, it.recent, it.all].map((cell) => element("td", "", String(cell)));
    this.#losses.querySelector("tbody").replaceChildren(...losses.map((it) => element("tr", "", ...cells(it))));
  }
}

function counted(count, noun) {
  return `${count} ${noun}${count === 1 ? "" : "s"}`;
}
