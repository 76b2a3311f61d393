// The dialog that pairs a headset: a QR code, and the time that it is still valid.
import { element, setText } from "./elements.js";

const REDRAW_MS = 500;

export class Pairing {
  #dialog = document.getElementById("pairing");
  #canvas = this.#dialog.querySelector("canvas");
  #output = this.#dialog.querySelector("output");
  #uri = this.#dialog.querySelector(".uri");
  #others = this.#dialog.querySelector("ul");
  // When the code ends, on this page's clock; null without one.
  #endsMs = null;

  constructor(ask) {
    document.getElementById("pair").onclick = () => {
      if (this.#endsMs === null) this.#clear("");
      this.#dialog.showModal();
      ask({ pair: true });
    };
    this.#dialog.querySelector("button").onclick = () => this.close();
    this.#dialog.addEventListener("close", () => {
      this.#clear("");
      ask({ pair: false });
    });
    setInterval(() => this.#tick(), REDRAW_MS);
  }

  close() {
    this.#dialog.close();
  }

  show({ uri, others, modules, left_s, text }) {
    if (!uri) return this.#clear(text);
    this.#endsMs = performance.now() + left_s * 1000;
    setText(this.#uri, uri);
    this.#others.replaceChildren(...others.map((it) => element("li", "quiet", `this machine is ${it}, too, for a headset on another network`)));
    this.#draw(modules);
    this.#tick();
  }

  answer({ to, is_done, text }) {
    if (to === "pair" && !is_done) this.#clear(text);
  }

  #clear(text) {
    this.#endsMs = null;
    setText(this.#output, text);
    setText(this.#uri, "");
    this.#others.replaceChildren();
    this.#canvas.hidden = true;
  }

  // Black on white in any colour scheme, as readers of codes expect.
  #draw(modules) {
    const context = this.#canvas.getContext("2d");
    this.#canvas.hidden = false;
    this.#canvas.width = this.#canvas.height = modules.length;
    context.fillStyle = "#fff";
    context.fillRect(0, 0, modules.length, modules.length);
    context.fillStyle = "#000";
    modules.forEach((row, y) => [...row].forEach((it, x) => it === "1" && context.fillRect(x, y, 1, 1)));
  }

  #tick() {
    if (this.#endsMs === null) return;
    const leftS = Math.max(0, Math.ceil((this.#endsMs - performance.now()) / 1000));
    const seconds = String(leftS % 60).padStart(2, "0");
    setText(this.#output, `waiting for the headset, ${Math.floor(leftS / 60)}:${seconds} left`);
  }
}
