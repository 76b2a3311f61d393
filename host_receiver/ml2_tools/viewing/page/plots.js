// The plots of the last seconds: those that are always there, and fields that were picked from a
// list; with one time axis and one cursor for all.
import { element, setText } from "./elements.js";
import { LEFT, Plot } from "./plot.js";

const REDRAW_MS = 100;
const STEP_S = 0.5;
const MOST_PICKED = 8;

export class Plots {
  #section = document.getElementById("plots");
  #list = this.#section.querySelector(".list");
  #axis = this.#section.querySelector(".axis");
  #picker = this.#section.querySelector("form");
  #plots;
  #shownS;
  #fields;
  #topics = {};
  #changed;
  // What the server's clock showed at a time of this page's: the plots move with the server's.
  #clock = { nowS: 0, rate: 1, sinceMs: 0 };
  // How long before now; null without a cursor.
  #cursorS = null;
  // How long before now a paused page shows; null if it is live.
  #lookedS = null;
  #timer;
  // The names of the picked fields: a topic, a space, and a field of it.
  picked = [];

  // `changed` is called when `wanted` is another; `picked` are those of an earlier connection.
  constructor({ plots, shown_s, fields }, changed, picked) {
    this.#shownS = shown_s;
    this.#fields = fields;
    this.#changed = changed;
    this.#plots = new Map(plots.map((it) => [it.name, new Plot(it)]));
    for (const it of picked) this.#pick(it);
    const [topic] = this.#picker.elements;
    topic.onchange = () => this.#offerFields();
    this.#picker.onsubmit = (event) => {
      event.preventDefault();
      const [topic, field] = this.#picker.elements;
      if (field.value) this.#pick(`${topic.value} ${field.value}`);
    };
    this.#section.onpointermove = (event) => this.#point(event);
    this.#section.onpointerleave = () => (this.#cursorS = null);
    this.#list.onkeydown = (event) => this.#step(event);
    this.#show();
    this.#timer = setInterval(() => this.#draw(), REDRAW_MS);
  }

  // The data that these plots ask the server for.
  get wanted() {
    return this.picked.filter((it) => it.split(" ")[0] in this.#topics);
  }

  close() {
    clearInterval(this.#timer);
  }

  // Offers the fields of these topics, whose types are given.
  offer(topics) {
    if (JSON.stringify(topics) === JSON.stringify(this.#topics)) return;
    this.#topics = topics;
    const [select] = this.#picker.elements;
    const chosen = select.value;
    select.replaceChildren(...Object.keys(topics).sort().map((it) => new Option(it)));
    if (chosen in topics) select.value = chosen;
    this.#offerFields();
    this.#changed();
  }

  add({ now_s, plots }) {
    this.setClock(now_s, this.#clock.rate);
    for (const [name, values] of Object.entries(plots)) this.#plots.get(name)?.add(values);
  }

  // The server's clock shows so many seconds now, and runs at a rate; 0 is a pause.
  setClock(nowS, rate) {
    this.#clock = { nowS, rate, sinceMs: performance.now() };
  }

  // Stands still, with the cursor at what was so many seconds ago; null moves on.
  look(agoS) {
    if (this.#lookedS === null && agoS !== null) this.setClock(this.#nowS(), 0);
    if (agoS === null) this.setClock(this.#nowS(), 1);
    this.#lookedS = agoS;
  }

  #nowS() {
    const { nowS, rate, sinceMs } = this.#clock;
    return nowS + ((performance.now() - sinceMs) / 1000) * rate;
  }

  #offerFields() {
    const [topic, field, button] = this.#picker.elements;
    const names = this.#fields[this.#topics[topic.value]] ?? [];
    field.replaceChildren(...names.map((it) => new Option(it)));
    button.disabled = !names.length;
  }

  #pick(name) {
    if (this.#plots.has(name) || this.picked.length === MOST_PICKED) return;
    this.picked.push(name);
    const remove = () => {
      this.#plots.delete(name);
      this.picked = this.picked.filter((it) => it !== name);
      this.#show();
    };
    this.#plots.set(name, new Plot({ name, unit: "" }, remove));
    this.#show();
  }

  #show() {
    this.#list.replaceChildren(...[...this.#plots.values()].map((it) => it.element));
    const [, , button] = this.#picker.elements;
    button.title = this.picked.length === MOST_PICKED ? `at most ${MOST_PICKED} plots can be added` : "";
    this.#changed();
  }

  #point(event) {
    const canvas = event.target.closest("canvas");
    if (!canvas || event.offsetX < LEFT) return (this.#cursorS = null);
    this.#cursorS = this.#shownS * (1 - (event.offsetX - LEFT) / (canvas.clientWidth - LEFT));
  }

  #step(event) {
    const step = { ArrowLeft: STEP_S, ArrowRight: -STEP_S }[event.key];
    if (event.key === "Escape") this.#cursorS = null;
    if (!step || event.target !== this.#list) return;
    event.preventDefault();
    this.#cursorS = Math.min(this.#shownS, Math.max(0, (this.#cursorS ?? 0) + step));
  }

  #draw() {
    if (document.hidden) return;
    const nowS = this.#nowS();
    const agoS = this.#cursorS ?? this.#lookedS;
    const cursorS = agoS === null ? null : nowS - agoS;
    for (const plot of this.#plots.values()) plot.draw(nowS - this.#shownS, nowS, cursorS);
    const [begin, ...others] = this.#axis.children;
    setText(begin, agoS === null ? `${this.#shownS} s ago` : `cursor: ${agoS.toFixed(1)} s ago`);
    others.forEach((it, index) => setText(it, ["20", "10", this.#lookedS === null ? "now" : "pause"][index]));
  }
}
