// The time line of a recording, or of the last seconds: shows the position in it, and moves it.
import { setText } from "./elements.js";

const REDRAW_MS = 100;
// As many as the slider's step, which is a tenth of a second.
const STEPS_PER_S = 10;

export class TimeLine {
  #bar = document.getElementById("timeline");
  #button = this.#bar.querySelector("button");
  #slider = this.#bar.querySelector("input");
  #speed = this.#bar.querySelector("select");
  #output = this.#bar.querySelector("output");
  #recording;
  #ask;
  // The newest wish of each kind; the server gets one at a time.
  #wishes = {};
  #isAsked = false;
  #isMoved = false;
  #position = { at_s: 0, rate: 1, is_playing: false, jumps: 0 };
  #sinceMs = 0;
  #timer;

  // `words` of the recording, if it has them, says a position; else it is told from its `begin_s`.
  constructor(recording, ask) {
    this.#recording = recording;
    this.#ask = ask;
    this.#bar.hidden = false;
    // A slider stops at the last whole step, which shall not be before the end.
    this.#slider.max = Math.ceil(recording.length_s * STEPS_PER_S) / STEPS_PER_S;
    this.#speed.replaceChildren(...recording.speeds.map((it) => new Option(`${it}×`, it)));
    this.#button.onclick = () => this.#wish("play", !this.#position.is_playing);
    this.#speed.onchange = () => this.#wish("speed", Number(this.#speed.value));
    this.#slider.oninput = () => {
      const atS = Math.min(Number(this.#slider.value), recording.length_s);
      this.#isMoved = true;
      // This position is drawn until the server sends its own.
      this.#position = { ...this.#position, at_s: atS };
      this.#sinceMs = performance.now();
      this.#tell(atS);
      this.#wish("seek", atS);
    };
    this.#slider.onchange = () => (this.#isMoved = false);
    this.#timer = setInterval(() => this.#draw(), REDRAW_MS);
  }

  close() {
    clearInterval(this.#timer);
    this.#bar.hidden = true;
  }

  // Returns true if the position has jumped.
  show(position) {
    const hasJumped = position.jumps !== this.#position.jumps;
    // Until the answer, a position may be that before the wish.
    if (this.#isAsked) return hasJumped;
    this.#position = position;
    this.#sinceMs = performance.now();
    setText(this.#button, position.is_playing ? "Pause" : "Play");
    this.#speed.value = position.rate;
    this.#draw();
    return hasJumped;
  }

  answer() {
    this.#isAsked = false;
    this.#send();
  }

  #wish(kind, value) {
    this.#wishes[kind] = value;
    this.#send();
  }

  #send() {
    const [kind] = Object.keys(this.#wishes);
    if (this.#isAsked || !kind) return;
    this.#isAsked = true;
    this.#ask({ [kind]: this.#wishes[kind] });
    delete this.#wishes[kind];
  }

  #draw() {
    if (this.#isMoved || this.#isAsked) return;
    const { at_s, rate, is_playing } = this.#position;
    const passedS = is_playing ? ((performance.now() - this.#sinceMs) / 1000) * rate : 0;
    const atS = Math.min(at_s + passedS, this.#recording.length_s);
    this.#slider.value = atS;
    this.#tell(atS);
  }

  #tell(atS) {
    const { begin_s, length_s, words } = this.#recording;
    setText(this.#output, words?.(atS) ?? `${atS.toFixed(1)} of ${length_s.toFixed(1)} s · ${timeOfDay(begin_s + atS)}`);
    this.#slider.setAttribute("aria-valuetext", `${atS.toFixed(1)} s`);
  }
}

export function timeOfDay(unixS) {
  const parts = { hour12: false, fractionalSecondDigits: 1, hour: "2-digit", minute: "2-digit", second: "2-digit" };
  return new Date(unixS * 1000).toLocaleTimeString([], parts);
}
