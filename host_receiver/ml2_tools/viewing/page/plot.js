// One plot: the values of the last seconds, with gaps where samples are missing, and a cursor.
import { element, setText } from "./elements.js";

export const LEFT = 44;
const MARGIN = { top: 5, bottom: 5 };
const AXES = ["x", "y", "z"];
const TICK_S = 10;
// Samples that are so many times farther apart than most have others missing between them.
const GAP = 2.5;
// Less is how late a sample comes, and not a missing one.
const LEAST_GAP_S = 0.1;

export class Plot {
  #values = [];
  #canvas = element("canvas");
  #output = element("output");

  // `removed` is called by the button that takes the plot away; a plot without it stays.
  constructor({ name, unit }, removed) {
    const title = element("h2", "", element("span", "", name), element("span", "quiet", unit), this.#output);
    if (removed) {
      const button = element("button", "", "×");
      button.type = "button";
      button.setAttribute("aria-label", `remove the plot of ${name}`);
      button.onclick = removed;
      title.append(button);
    }
    this.element = element("div", "plot", title, this.#canvas);
    this.#canvas.setAttribute("role", "img");
    this.#canvas.setAttribute("aria-label", `${name}${unit ? ` in ${unit}` : ""} over the last 30 s`);
  }

  // A time without values says that the earlier ones do not count any more.
  add(values) {
    const last = values.findLastIndex(([, it]) => !it.length);
    if (last >= 0) this.#values = [];
    this.#values.push(...values.slice(last + 1));
  }

  // Draws what is between two times, and the values at the cursor's time; null is the newest.
  draw(beginS, endS, cursorS) {
    const first = this.#values.findIndex(([timeS]) => timeS >= beginS);
    this.#values.splice(0, first < 0 ? this.#values.length : first);
    const context = this.#prepare();
    const range = rangeOf(this.#values);
    const gapS = gapOf(this.#values);
    this.#tell(range, cursorS === null ? this.#values.at(-1) : valuesAt(this.#values, cursorS, gapS));
    if (!range) return;
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    const style = getComputedStyle(this.#canvas);
    const x = (timeS) => LEFT + ((timeS - beginS) / (endS - beginS)) * (width - LEFT);
    const y = (value) =>
      MARGIN.top + ((range.high - value) / (range.high - range.low)) * (height - MARGIN.top - MARGIN.bottom);
    context.font = "11px system-ui, sans-serif";
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const level of [range.low, range.high]) {
      context.fillStyle = style.getPropertyValue("--quiet");
      context.fillText(level.toFixed(range.digits), LEFT - 5, y(level));
      context.fillStyle = style.getPropertyValue("--line");
      context.fillRect(LEFT, Math.round(y(level)), width - LEFT, 1);
    }
    for (let timeS = endS - TICK_S; timeS > beginS; timeS -= TICK_S) {
      context.fillRect(Math.round(x(timeS)), MARGIN.top, 1, height - MARGIN.top - MARGIN.bottom);
    }
    const lines = this.#values.at(-1)[1].length;
    for (let i = 0; i < lines; i++) {
      context.strokeStyle = style.getPropertyValue(`--series-${lines === 1 ? 2 : i}`);
      strokeLines(context, linesOf(this.#values, i, gapS), x, y);
    }
    if (cursorS === null) return;
    context.fillStyle = style.getPropertyValue("--text");
    context.fillRect(Math.round(x(cursorS)), 0, 1, height);
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

  #tell(range, sample) {
    const values = sample?.[1] ?? [];
    if (!values.length) return setText(this.#output, range ? "–" : "no data");
    const words = values.map((it, i) => {
      const value = it === null ? "–" : it.toFixed(Math.max(range?.digits ?? 2, 1)).replace(/^-(0\.0*)$/, "$1");
      return values.length === 1 ? value : element("span", `series-${i}`, `${AXES[i]} ${value} `);
    });
    this.#output.replaceChildren(...words);
  }
}

// Returns the time between two samples from which on others are missing between them.
export function gapOf(values) {
  const steps = values.slice(1).map(([timeS], index) => timeS - values[index][0]).sort((a, b) => a - b);
  return Math.max(GAP * (steps[Math.floor(steps.length / 2)] ?? Infinity), LEAST_GAP_S);
}

// Returns the lines of one value, each as places [time, value]; they end where samples are missing.
export function linesOf(values, index, gapS) {
  const lines = [];
  let lastS = -Infinity;
  for (const [timeS, numbers] of values) {
    const value = numbers[index] ?? null;
    if (value === null) {
      lastS = -Infinity;
      continue;
    }
    if (timeS - lastS > gapS) lines.push([]);
    lines.at(-1).push([timeS, value]);
    lastS = timeS;
  }
  return lines;
}

function strokeLines(context, lines, x, y) {
  context.beginPath();
  for (const line of lines) {
    context.moveTo(x(line[0][0]), y(line[0][1]));
    for (const [timeS, value] of line) context.lineTo(x(timeS), y(value));
    // A sample between two gaps is a dot.
    if (line.length === 1) context.lineTo(x(line[0][0]) + 1, y(line[0][1]));
  }
  context.lineWidth = 1.4;
  context.stroke();
}

// Returns the last sample before a time; none in a gap.
function valuesAt(values, timeS, gapS) {
  const sample = values.findLast(([it]) => it <= timeS);
  return sample && timeS - sample[0] <= gapS ? sample : undefined;
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
  return { low, high, digits: Math.min(20, Math.max(0, -Math.floor(Math.log10(step)))) };
}
