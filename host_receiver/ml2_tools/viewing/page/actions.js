// The buttons that call services of the receiver, and what it last answered.
import { setText } from "./elements.js";

export class Actions {
  #bar = document.getElementById("actions");
  #answer = this.#bar.querySelector("output");
  #waiting = new Set();

  constructor(ask) {
    for (const button of this.#bar.querySelectorAll("[data-call]")) {
      const service = button.dataset.call;
      button.onclick = () => {
        if (this.#waiting.has(service)) return;
        this.#waiting.add(service);
        button.setAttribute("aria-busy", "true");
        ask({ call: service });
      };
    }
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
    button.removeAttribute("aria-busy");
    this.#answer.className = is_done ? "" : "level-2";
    setText(this.#answer, `${button.textContent}: ${text || "done"}`);
  }
}
