// One image in full size, and the value of a pixel of it.
import { setText } from "./elements.js";
import { ImageDecoder } from "./image_decoder.js";

const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export class Enlarged {
  #dialog = document.getElementById("enlarged");
  #canvas = this.#dialog.querySelector("canvas");
  #decoder = new ImageDecoder();
  #name = this.#dialog.querySelector("b");
  #value = this.#dialog.querySelector("output");
  #far = this.#dialog.querySelector(".scale span");
  #scale = this.#dialog.querySelector(".scale");
  #stream = null;
  // The pixel whose value is shown.
  #at = null;
  #isAsked = false;
  #changed;
  #ask;

  constructor(changed, ask) {
    this.#changed = changed;
    this.#ask = ask;
    this.#dialog.querySelector("button").onclick = () => this.close();
    this.#dialog.addEventListener("close", () => {
      this.#stream = this.#at = null;
      this.#changed();
    });
    this.#canvas.addEventListener("pointermove", (event) => this.#point(this.#pixelAt(event)));
    this.#canvas.addEventListener("keydown", (event) => this.#step(event));
  }

  // An image of an earlier time has no values.
  #isStill = false;

  // The data that this view asks the server for; null while it is closed.
  get wanted() {
    if (!this.#stream) return null;
    return document.hidden ? [] : [`full ${this.#stream}`];
  }

  // A `still` is the message that shall be shown instead of what comes.
  open(stream, still) {
    this.#stream = stream;
    this.#isStill = Boolean(still);
    this.#isAsked = false;
    setText(this.#name, stream.replaceAll("_", " "));
    setText(this.#value, still ? "paused, as small as it came: values are those of live images only" : "");
    this.#canvas.getContext("2d").reset();
    this.#scale.hidden = true;
    this.#dialog.showModal();
    this.#canvas.focus();
    this.#changed();
    if (still) this.draw(...still);
  }

  close() {
    this.#dialog.close();
  }

  async draw(stream, jpeg, farMetres) {
    const image = await this.#decoder.decode(jpeg);
    if (image === undefined) return;
    if (!image) {
      this.fail(stream, "the browser cannot read the image");
      return;
    }
    if (stream === this.#stream) {
      this.#canvas.width = image.width;
      this.#canvas.height = image.height;
      this.#canvas.getContext("2d").drawImage(image, 0, 0);
      this.#scale.hidden = !farMetres;
      setText(this.#far, `${farMetres.toFixed(1)} m`);
      this.#askForValue();
    }
    image.close();
  }

  fail(stream, reason) {
    if (stream === this.#stream) setText(this.#value, reason);
  }

  pixel({ at, value }) {
    this.#isAsked = false;
    if (!this.#at) return;
    setText(this.#value, `${at[0]}, ${at[1]}: ${inWords(value, this.#stream)}`);
    // The pointer has moved since.
    if (at.join() !== this.#at.join()) this.#askForValue();
  }

  #point(at) {
    this.#at = at;
    if (this.#isStill) return;
    if (at) this.#askForValue();
    else setText(this.#value, "");
  }

  #askForValue() {
    if (this.#isAsked || !this.#at || this.#isStill) return;
    this.#isAsked = true;
    this.#ask({ pixel: this.#stream, at: this.#at });
  }

  #step(event) {
    const step = STEPS[event.key];
    if (!step) return;
    event.preventDefault();
    const { width, height } = this.#canvas;
    const from = this.#at ?? [Math.floor(width / 2), Math.floor(height / 2)];
    const far = event.shiftKey ? 10 : 1;
    const limits = [width - 1, height - 1];
    this.#point(from.map((it, axis) => Math.min(Math.max(it + far * step[axis], 0), limits[axis])));
  }

  // Returns column and row under the pointer; null beside the image, which is in the middle.
  #pixelAt(event) {
    const { width, height, clientWidth, clientHeight } = this.#canvas;
    const scale = Math.min(clientWidth / width, clientHeight / height);
    const column = Math.floor((event.offsetX - (clientWidth - width * scale) / 2) / scale);
    const row = Math.floor((event.offsetY - (clientHeight - height * scale) / 2) / scale);
    return column >= 0 && row >= 0 && column < width && row < height ? [column, row] : null;
  }
}

function inWords(value, stream) {
  if (!value.length) return "no pixel";
  if (value.length === 3) return `red ${value[0]}, green ${value[1]}, blue ${value[2]}`;
  if (value[0] === null) return "invalid";
  return stream === "depth" ? `${value[0].toFixed(3)} m` : `${Number(value[0].toFixed(3))}`;
}
