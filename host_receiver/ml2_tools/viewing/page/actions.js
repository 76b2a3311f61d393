// The buttons that call services of the receiver, and what it last answered. Of the configuration,
// only what was changed on this page is saved.
import { setText } from "./elements.js";

const LABELS = {
  start: "Start streams", stop: "Stop streams", start_recording: "Record", stop_recording: "Stop recording",
  start_products: "Make products", stop_products: "Stop products",
  test_link: "Test the link", save_config: "Save changes",
};

export class Actions {
  #bar = document.getElementById("actions");
  #answer = this.#bar.querySelector("output");
  #buttons = new Map([...this.#bar.querySelectorAll("[data-call]")].map((it) => [it.id, it]));
  #record = this.#buttons.get("record");
  #waiting = new Set();
  #changed;
  #saving = [];

  // `changed` has the names of the values that were changed on this page, as SECTION.KEY.
  constructor(ask, changed) {
    this.#changed = changed;
    for (const button of this.#buttons.values()) {
      button.onclick = () => {
        const service = button.dataset.call;
        const reason = button.dataset.reason;
        if (reason) this.#say(`${LABELS[service]}: ${reason}`);
        if (reason || this.#waiting.has(service)) return;
        this.#waiting.add(service);
        button.setAttribute("aria-busy", "true");
        ask(service === "save_config" ? this.#save() : { call: service });
      };
    }
    this.refuse("the receiver has not reported yet");
  }

  // Shows what the receiver does at present, and offers what can follow.
  show({ has_headset, is_stopped, recording_s }) {
    this.refuse("");
    const isRecording = recording_s !== null;
    this.#offer("streaming", is_stopped ? "start" : "stop", has_headset ? "" : "no headset is connected");
    this.#offer("link", "test_link", has_headset ? "" : "no headset is connected");
    this.#offer("record", isRecording ? "stop_recording" : "start_recording", "");
    this.#record.setAttribute("aria-pressed", String(isRecording));
    if (isRecording) setText(this.#record, `${LABELS.stop_recording} ${clock(recording_s)}`);
  }

  // Shows whether `products` runs beside the page.
  showProducts({ is_on }) {
    const button = this.#buttons.get("products");
    this.#offer("products", is_on ? "stop_products" : "start_products", button.dataset.reason);
    button.setAttribute("aria-pressed", String(is_on));
  }

  // Says why nothing can be done.
  refuse(reason) {
    for (const [id, button] of this.#buttons) this.#offer(id, button.dataset.call, reason);
  }

  #offer(id, service, reason) {
    const button = this.#buttons.get(id);
    button.dataset.call = service;
    // A disabled button could not say why it is.
    button.dataset.reason = button.title = reason;
    button.setAttribute("aria-disabled", String(Boolean(reason)));
    setText(button, LABELS[service]);
  }

  // Without names, the receiver saves nothing, and says what is not as in its file.
  #save() {
    this.#saving = [...this.#changed];
    return { call: "save_config", ...(this.#saving.length && { keys: this.#saving }) };
  }

  // Forgets requests that a lost connection leaves without an answer.
  reset() {
    this.#waiting.clear();
    for (const button of this.#buttons.values()) button.removeAttribute("aria-busy");
  }

  answer({ to, is_done, text }) {
    if (!this.#waiting.delete(to)) return;
    if (to === "save_config" && is_done) this.#saving.forEach((it) => this.#changed.delete(it));
    for (const button of this.#bar.querySelectorAll("[aria-busy]")) {
      if (!this.#waiting.has(button.dataset.call)) button.removeAttribute("aria-busy");
    }
    this.#say(`${LABELS[to]}: ${text || "done"}`, is_done);
  }

  #say(text, isGood = false) {
    this.#answer.className = isGood ? "" : "level-2";
    setText(this.#answer, text);
  }
}

function clock(seconds) {
  return `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;
}
