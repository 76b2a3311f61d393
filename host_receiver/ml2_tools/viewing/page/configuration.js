// The values that the receiver has in force, with controls that ask for others.
import { element, setText } from "./elements.js";

export class Configuration {
  #list = document.getElementById("sections");
  #rows;

  // `changed` gets the names of the values that the receiver has taken, as SECTION.KEY.
  constructor(controls, ask, changed) {
    this.#rows = new Map(controls.map((it) => [it.section, new Row(it, ask, changed)]));
    this.#list.replaceChildren(...[...this.#rows.values()].map((it) => it.element));
  }

  show({ sections }) {
    for (const [section, values] of Object.entries(sections)) this.#rows.get(section)?.show(values);
  }

  showApplied(applied) {
    for (const [section, row] of this.#rows) row.showApplied(applied[section] ?? "");
  }

  answer(answer) {
    this.#rows.get(answer.to)?.answer(answer);
  }
}

class Row {
  #section;
  #ask;
  #changed;
  #values = null;
  // What is asked for, and what shall be asked for after its answer.
  #asked = null;
  #next = null;
  #enabled = element("input");
  #mode = element("select");
  #format = element("select");
  #quality = element("input");
  #link = element("input");
  #applied = element("span", "quiet");
  #said = element("span");

  constructor({ section, doc, modes, isSwitch, formats, quality, link }, ask, changed) {
    this.#section = section;
    this.#ask = ask;
    this.#changed = changed;
    const name = section.replaceAll("_", " ");
    this.#enabled.type = "checkbox";
    this.#enabled.onchange = () => this.#wish({ enabled: this.#enabled.checked });
    this.#mode.setAttribute("aria-label", `mode of ${name}`);
    this.#mode.replaceChildren(...modeOptions(modes));
    this.#mode.onchange = () => {
      const [stream, mode] = this.#mode.value.split(" ");
      this.#wish({ stream: Number(stream), mode });
    };
    this.#format.setAttribute("aria-label", `format of ${name}`);
    this.#format.replaceChildren(...formats.map((it) => new Option(it)));
    this.#format.onchange = () => this.#wish({ format: this.#format.value });
    const title = element("label", "", ...(isSwitch ? [this.#enabled] : []), name);
    title.title = doc;
    const fields = [];
    if (modes.length > 1) fields.push(this.#mode);
    if (formats.length > 1) fields.push(this.#format);
    if (quality) fields.push(this.#qualityField(name, quality));
    if (link) fields.push(...this.#linkFields(link));
    this.#said.setAttribute("role", "status");
    this.element = element("li", "", title, ...fields, this.#applied, this.#said);
    this.element.dataset.section = section;
    this.#render();
  }

  #qualityField(name, [least, most]) {
    Object.assign(this.#quality, { type: "number", min: least, max: most, required: true });
    this.#quality.setAttribute("aria-label", `JPEG quality of ${name}`);
    this.#quality.title = `JPEG quality, from ${least} to ${most}`;
    // The browser says what is wrong with a number out of these bounds.
    this.#quality.onchange = () => this.#quality.reportValidity() && this.#wish({ quality: this.#quality.valueAsNumber });
    return this.#quality;
  }

  #linkFields(words) {
    const offered = element("datalist", "", ...words.map((it) => new Option(it)));
    offered.id = `${this.#section}-link`;
    Object.assign(this.#link, { size: 6, title: `what images do on a slow link: ${words.join(", ")}, or the most Mbit/s` });
    this.#link.setAttribute("list", offered.id);
    this.#link.setAttribute("aria-label", "link");
    // Mbit/s above 0
    this.#link.pattern = [...words, "(?!0*\\.?0*$)\\d*\\.?\\d+"].join("|");
    this.#link.required = true;
    this.#link.onchange = () => this.#link.reportValidity() && this.#wish({ link: this.#link.value });
    return ["link", this.#link, offered];
  }

  show(values) {
    this.#values = values;
    this.#render();
  }

  showApplied(text) {
    setText(this.#applied, text);
  }

  answer({ is_done, text }) {
    if (is_done) for (const key of Object.keys(this.#asked ?? {})) this.#changed.add(`${this.#section}.${key}`);
    this.#asked = null;
    // A value may also be taken with words, such as that it waits for another one.
    this.#said.className = is_done ? "level-1" : "level-2";
    setText(this.#said, text);
    if (this.#next) {
      const next = this.#next;
      this.#next = null;
      this.#wish(next);
    }
    this.#render();
  }

  // The receiver gets one request of a row at a time, and then the newest wish.
  #wish(values) {
    if (this.#asked) {
      this.#next = values;
      return;
    }
    this.#asked = values;
    this.element.setAttribute("aria-busy", "true");
    this.#ask({ set: this.#section, to: values });
  }

  // Shows the values in force, except in a field that has the focus.
  #render() {
    for (const it of [this.#enabled, this.#mode, this.#format, this.#quality, this.#link]) it.disabled = !this.#values;
    if (this.#asked || !this.#values) return;
    this.element.removeAttribute("aria-busy");
    const { enabled, stream, mode, format, quality, link } = this.#values;
    this.#enabled.checked = enabled;
    this.#mode.value = `${stream} ${mode}`;
    this.#format.value = format;
    this.#quality.hidden = format !== "jpeg";
    if (document.activeElement !== this.#quality) this.#quality.value = quality;
    if (document.activeElement !== this.#link) this.#link.value = link;
  }
}

function modeOptions(modes) {
  const streams = [...new Set(modes.map(([stream]) => stream))];
  const options = (wanted) =>
    modes.filter(([stream]) => stream === wanted).map(([stream, mode]) => new Option(mode, `${stream} ${mode}`));
  if (streams.length === 1) return options(streams[0]);
  return streams.map((stream) => {
    const group = element("optgroup", "", ...options(stream));
    group.label = `stream ${stream}`;
    return group;
  });
}
