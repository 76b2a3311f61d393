// The buttons that call services of the receiver, and what it last answered. Of the configuration,
// only what was changed on this page is saved.
import { setText } from "./elements.js";

export class Actions {
  #bar = document.getElementById("actions");
  #answer = this.#bar.querySelector("output");
  #waiting = new Set();
  #changed;
  #saving = [];

  // `changed` has the names of the values that were changed on this page, as SECTION.KEY.
  constructor(ask, changed) {
    this.#changed = changed;
    for (const button of this.#bar.querySelectorAll("[data-call]")) {
      const service = button.dataset.call;
      button.onclick = () => {
        if (this.#waiting.has(service)) return;
        this.#waiting.add(service);
        button.setAttribute("aria-busy", "true");
        ask(service === "save_config" ? this.#save() : { call: service });
      };
    }
  }

  // Without names, the receiver saves nothing, and says what is not as in its file.
  #save() {
    this.#saving = [...this.#changed];
    return { call: "save_config", ...(this.#saving.length && { keys: this.#saving }) };
  }

  // Forgets requests that a lost connection leaves without an answer.
  reset() {
    this.#waiting.clear();
    for (const button of this.#bar.querySelectorAll("[data-call]")) button.removeAttribute("aria-busy");
  }

  answer({ to, is_done, text }) {
    const button = this.#bar.querySelector(`[data-call="${to}"]`);
    if (!button) return;
    this.#waiting.delete(to);
    if (to === "save_config" && is_done) this.#saving.forEach((it) => this.#changed.delete(it));
    button.removeAttribute("aria-busy");
    this.#answer.className = is_done ? "" : "level-2";
    setText(this.#answer, `${button.textContent}: ${text || "done"}`);
  }
}
