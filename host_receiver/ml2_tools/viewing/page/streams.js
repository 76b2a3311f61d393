// The grid of images. A tile asks for images only while it can be seen.
import { element, setText } from "./elements.js";
import { ImageDecoder } from "./image_decoder.js";

const UNKNOWN = "–";

export class Streams {
  #offered;
  #ask;
  #enlarge;
  #asked = "";
  #grid = document.getElementById("streams");
  #tiles = new Map();
  #observer = new IntersectionObserver((entries) => {
    for (const it of entries) {
      const tile = this.#tiles.get(it.target.dataset.stream);
      if (tile) tile.isInView = it.isIntersecting;
    }
    this.#askForImages();
  });
  #visibilityChanged = () => this.#askForImages();

  constructor(offered, ask, enlarge) {
    this.#offered = new Set(offered);
    this.#ask = ask;
    this.#enlarge = enlarge;
    document.addEventListener("visibilitychange", this.#visibilityChanged);
  }

  close() {
    this.#observer.disconnect();
    document.removeEventListener("visibilitychange", this.#visibilityChanged);
    for (const tile of this.#tiles.values()) tile.figure.remove();
  }

  show(streams) {
    const offered = streams.filter((it) => this.#offered.has(it.id));
    document.getElementById("eyes").hidden = offered.length === streams.length;
    document.getElementById("nothing").hidden = streams.length > 0;
    const ids = new Set(offered.map((it) => it.id));
    for (const [id, tile] of this.#tiles) if (!ids.has(id)) this.#remove(id, tile);
    for (const stream of offered) {
      if (!this.#tiles.has(stream.id)) this.#add(stream);
      this.#tiles.get(stream.id).show(stream);
    }
    this.#askForImages();
  }

  // Returns the canvas with the image; nothing if it is not shown.
  draw(stream, jpeg, farMetres) {
    return this.#tiles.get(stream)?.draw(jpeg, farMetres);
  }

  fail(stream, reason) {
    this.#tiles.get(stream)?.fail(reason);
  }

  #add(stream) {
    const tile = new Tile(stream, () => this.#askForImages(), () => this.#enlarge(stream.id));
    this.#tiles.set(stream.id, tile);
    this.#grid.append(tile.figure);
    this.#observer.observe(tile.figure);
  }

  #remove(id, tile) {
    this.#observer.unobserve(tile.figure);
    tile.figure.remove();
    this.#tiles.delete(id);
  }

  #askForImages() {
    const isWanted = (tile) => tile.isOn && tile.isInView && !document.hidden;
    const shown = [...this.#tiles].filter(([, tile]) => isWanted(tile)).map(([id]) => id);
    if (shown.join() === this.#asked) return;
    this.#asked = shown.join();
    this.#ask(shown);
  }
}

class Tile {
  isInView = false;
  #canvas = element("canvas");
  #decoder = new ImageDecoder();
  #rate = element("p");
  #latency = element("p", "quiet");
  #stages = element("p", "quiet stages");
  #mode = element("p", "quiet");
  #state = element("p");
  #button = element("button");
  #veil = element("div", "veil", "Images of eyes are biometric data.");
  #scale;
  #far = element("span");
  #isEye;

  constructor(stream, changed, enlarge) {
    const name = stream.id.replaceAll("_", " ");
    this.#isEye = stream.is_eye;
    // Eye images are biometric data: they come only after a click.
    this.isOn = !stream.is_eye;
    this.#canvas.width = 4;
    this.#canvas.height = 3;
    this.#canvas.setAttribute("role", "button");
    this.#canvas.setAttribute("aria-label", `newest image of ${name}; Enter shows it in full size`);
    this.#canvas.onclick = () => this.isOn && enlarge();
    this.#canvas.onkeydown = (event) => {
      if (!this.isOn || !["Enter", " "].includes(event.key)) return;
      event.preventDefault();
      enlarge();
    };
    this.#button.type = "button";
    const consent = element("button", "", "Show this eye");
    consent.type = "button";
    this.#veil.append(consent);
    consent.onclick = this.#button.onclick = () => {
      this.isOn = !this.isOn;
      this.#label();
      changed();
    };
    this.#scale = element("div", "scale", "0 m", element("i"), this.#far);
    this.#scale.hidden = true;
    const title = element("div", "title", element("b", "", name), this.#button);
    const caption = element(
      "figcaption", "", title, this.#rate, this.#latency, this.#stages, this.#mode, this.#state,
    );
    const veil = this.#isEye ? [this.#veil] : [];
    this.figure = element("figure", "", this.#canvas, ...veil, this.#scale, caption);
    this.figure.dataset.stream = stream.id;
    this.figure.title = stream.topic;
    this.#label();
  }

  show(stream) {
    const expected = stream.expected_hz === null ? "" : ` of ${number(stream.expected_hz)}`;
    const lost = stream.lost ? element("span", "level-1", `, ${stream.lost} lost`) : ", nothing lost";
    this.#rate.title = stream.lost === null ? "" : "rate of the last second, losses of the last 10 s";
    this.#rate.replaceChildren(`${number(stream.rate_hz, 1)}${expected} Hz`, stream.lost === null ? "" : lost);
    // A recording says nothing of losses and latency.
    this.#latency.hidden = stream.lost === null;
    this.#showLatency(stream);
    const lowered = element("span", "level-1", `, lowered to ${stream.lowered}`);
    this.#mode.replaceChildren(stream.mode || "mode unknown", stream.lowered ? lowered : "");
    this.#state.className = `level-${stream.level}`;
    setText(this.#state, stream.state);
  }

  #showLatency({ stages_ms, latency_p50_ms, latency_p99_ms }) {
    // Tenths are added, so that the shown stages add up to the shown whole.
    const tenths = stages_ms?.map((it) => Math.round(it * 10));
    const whole = tenths ? tenths.reduce((sum, it) => sum + it) / 10 : latency_p50_ms;
    setText(this.#latency, `latency ${number(whole, 1)} ms, p99 ${number(latency_p99_ms, 1)} ms`);
    this.#stages.hidden = !tenths;
    const [toSent, toReceived, toPublished] = (tenths ?? []).map((it) => (it / 10 || 0).toFixed(1));
    setText(this.#stages, `= headset ${toSent} + link ${toReceived} + host ${toPublished}`);
    this.#stages.title = "means of the last second, in ms: capture to sent, sent to received, received to published";
  }

  async draw(jpeg, farMetres) {
    const image = await this.#decoder.decode(jpeg);
    if (image === undefined) return undefined;
    if (!image) return this.fail("the browser cannot read the image");
    // A click may have hidden the image while it was decoded.
    if (this.isOn) {
      this.#canvas.width = image.width;
      this.#canvas.height = image.height;
      this.#canvas.getContext("2d").drawImage(image, 0, 0);
      this.#scale.hidden = !farMetres;
      setText(this.#far, `${number(farMetres, 1)} m`);
    }
    image.close();
    return this.isOn ? this.#canvas : undefined;
  }

  // Without a reason there is just no image.
  fail(reason) {
    this.#state.className = "level-2";
    setText(this.#state, reason);
    if (reason) return;
    this.#decoder.skip();
    this.#clear();
  }

  #label() {
    this.#veil.hidden = this.isOn || !this.#isEye;
    this.#button.hidden = !this.#veil.hidden;
    setText(this.#button, this.isOn ? "Hide" : "Show");
    if (this.isOn) this.#canvas.tabIndex = 0;
    else this.#canvas.removeAttribute("tabindex");
    if (!this.isOn) this.#clear();
  }

  #clear() {
    this.#canvas.getContext("2d").reset();
  }
}

function number(value, digits = 0) {
  return value === null || value === undefined ? UNKNOWN : value.toFixed(digits);
}
