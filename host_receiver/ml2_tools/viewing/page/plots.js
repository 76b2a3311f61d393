// The plots of the last seconds, each a canvas.
import { element, setText } from "./elements.js";

const REDRAW_MS = 100;
const MARGIN = { left: 44, top: 5, bottom: 5 };
const AXES = ["x", "y", "z"];

export class Plots {
  #section = document.getElementById("plots");
  #plots;
  #shownS;
  // What the server's clock showed at a time of this page's: the plots move with the server's.
  #clock = { nowS: 0, rate: 1, sinceMs: 0 };
  #timer;

  constructor(plots, shownS) {
    this.#shownS = shownS;
    this.#plots = new Map(plots.map((it) => [it.name, new Plot(it)]));
    this.#section.replaceChildren(...[...this.#plots.values()].map((it) => it.element));
    this.#timer = setInterval(() => this.#draw(), REDRAW_MS);
  }

  close() {
    clearInterval(this.#timer);
  }

  add({ now_s, plots }) {
    this.setClock(now_s, this.#clock.rate);
    for (const [name, values] of Object.entries(plots)) this.#plots.get(name)?.add(values);
  }

  // The server's clock shows so many seconds now, and runs at a rate; 0 is a pause.
  setClock(nowS, rate) {
    this.#clock = { nowS, rate, sinceMs: performance.now() };
  }

  #draw() {
    if (document.hidden) return;
    const { nowS: thenS, rate, sinceMs } = this.#clock;
    const nowS = thenS + ((performance.now() - sinceMs) / 1000) * rate;
    for (const plot of this.#plots.values()) plot.draw(nowS - this.#shownS, nowS);
  }
}

class Plot {
  #values = [];
  #canvas = element("canvas");
  #output = element("output");

  constructor({ name, unit }) {
    const title = element("h2", "", name, element("span", "quiet", unit), this.#output);
    this.element = element("div", "plot", title, this.#canvas);
    this.#canvas.setAttribute("role", "img");
    this.#canvas.setAttribute("aria-label", `${name} in ${unit} over the last 30 s`);
  }

  // A time without values says that the earlier ones do not count any more.
  add(values) {
    const last = values.findLastIndex(([, it]) => !it.length);
    if (last >= 0) this.#values = [];
    this.#values.push(...values.slice(last + 1));
  }

  draw(beginS, endS) {
    const first = this.#values.findIndex(([timeS]) => timeS >= beginS);
    this.#values.splice(0, first < 0 ? this.#values.length : first);
    const context = this.#prepare();
    this.#showNewest();
    const range = rangeOf(this.#values);
    if (!range) return;
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    const style = getComputedStyle(this.#canvas);
    const x = (timeS) =>
      MARGIN.left + ((timeS - beginS) / (endS - beginS)) * (width - MARGIN.left);
    const y = (value) =>
      MARGIN.top + ((range.high - value) / (range.high - range.low)) * (height - MARGIN.top - MARGIN.bottom);
    context.font = "11px system-ui, sans-serif";
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const level of [range.low, range.high]) {
      context.fillStyle = style.getPropertyValue("--quiet");
      context.fillText(level.toFixed(range.digits), MARGIN.left - 5, y(level));
      context.fillStyle = style.getPropertyValue("--line");
      context.fillRect(MARGIN.left, Math.round(y(level)), width - MARGIN.left, 1);
    }
    const lines = this.#values.at(-1)[1].length;
    for (let i = 0; i < lines; i++) {
      context.strokeStyle = style.getPropertyValue(`--series-${lines === 1 ? 2 : i}`);
      this.#line(context, i, x, y);
    }
  }

  #line(context, index, x, y) {
    context.beginPath();
    let isDrawing = false;
    for (const [timeS, values] of this.#values) {
      const value = values[index] ?? null;
      if (value === null) isDrawing = false;
      else if (isDrawing) context.lineTo(x(timeS), y(value));
      else {
        context.moveTo(x(timeS), y(value));
        isDrawing = true;
      }
    }
    context.lineWidth = 1.4;
    context.stroke();
  }

  #prepare() {
    const scale = window.devicePixelRatio;
    const [width, height] = [this.#canvas.clientWidth * scale, this.#canvas.clientHeight * scale];
    if (this.#canvas.width !== Math.round(width)) this.#canvas.width = Math.round(width);
    if (this.#canvas.height !== Math.round(height)) this.#canvas.height = Math.round(height);
    const context = this.#canvas.getContext("2d");
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, width, height);
    return context;
  }

  #showNewest() {
    const newest = this.#values.at(-1)?.[1] ?? [];
    if (!newest.length) {
      setText(this.#output, "no data");
      return;
    }
    const digits = rangeOf(this.#values)?.digits ?? 2;
    const words = newest.map((it, i) => {
      const value = it === null ? "–" : it.toFixed(Math.max(digits, 1)).replace(/^-(0\.0*)$/, "$1");
      if (newest.length === 1) return value;
      return element("span", `series-${i}`, `${AXES[i]} ${value} `);
    });
    this.#output.replaceChildren(...words);
  }
}

// Returns the shown range: that of the values, widened to round numbers.
function rangeOf(values) {
  const known = values.flatMap(([, it]) => it).filter((it) => it !== null);
  if (!known.length) return null;
  let low = known[0];
  let high = known[0];
  for (const it of known) {
    low = Math.min(low, it);
    high = Math.max(high, it);
  }
  const size = Math.max(high - low, Math.abs(high) * 1e-3, 1e-3);
  const power = 10 ** Math.floor(Math.log10(size));
  const step = size / power > 5 ? power : size / power > 2 ? power / 2 : power / 5;
  low = Math.floor(low / step) * step;
  high = Math.ceil(high / step) * step;
  if (low === high) high += step;
  return { low, high, digits: Math.max(0, -Math.floor(Math.log10(step))) };
}
