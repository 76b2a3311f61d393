// Keeps what was shown in the last 30 s, thinned, so that a paused page can look back. It moves by
// the time line of a recording, whose last position is the present.
import { TimeLine, timeOfDay } from "./timeline.js";

const KEPT_MS = 30000;
const MOST_BYTES = 64e6;
const PLAY_MS = 100;
// The least time between two kept messages of a name.
const PERIODS_MS = { scene: 100, cloud: 500 };
const IMAGE_MS = 200;
const SCENE_BYTES = 4000;

export class History {
  #entries = [];
  #bytes = 0;
  #last = new Map();
  // The entries that are shown, by name.
  #shown = new Map();
  #show;
  #moved;
  #timeLine = null;
  // When the page was paused, which time is shown, and how fast it moves; the first is null live.
  #pausedMs = null;
  #atMs = 0;
  #rate = 1;
  #isPlaying = true;
  #timer;

  // `show` has a function for each kind of message; `moved` is called with how many s ago was what
  // is shown, and with null once that is the present.
  constructor(show, moved) {
    this.#show = show;
    this.#moved = moved;
  }

  // Begins anew, with a time line; or, with a recording, without one.
  reset(isLive) {
    this.#timeLine?.close();
    clearInterval(this.#timer);
    [this.#entries, this.#bytes, this.#pausedMs, this.#isPlaying] = [[], 0, null, true];
    this.#timeLine = null;
    if (!isLive) return;
    const line = { length_s: KEPT_MS / 1000, speeds: [0.25, 0.5, 1, 2], words: (atS) => this.#words(atS) };
    this.#timeLine = new TimeLine(line, (request) => this.#ask(request));
    this.#timer = setInterval(() => this.#play(), PLAY_MS);
    this.#tell();
  }

  get bytes() {
    return this.#bytes;
  }

  get isPaused() {
    return this.#pausedMs !== null;
  }

  // Returns the message of this name that a paused page shows.
  shown(name) {
    return this.isPaused ? this.#shown.get(name)?.message : undefined;
  }

  scene(poses) {
    return this.#take("scene", "scene", [poses], SCENE_BYTES);
  }

  cloud(places, colours) {
    return this.#take("cloud", "cloud", [places, colours], places.byteLength);
  }

  image(name, jpeg, farMetres) {
    return this.#take("image", name, [name, jpeg, farMetres], jpeg.size);
  }

  // Shows a message, and keeps it if the one before is old enough; a paused page ignores it.
  #take(kind, name, message, bytes) {
    if (this.isPaused) return undefined;
    const nowMs = performance.now();
    if (this.#timeLine && nowMs - (this.#last.get(name) ?? -Infinity) >= (PERIODS_MS[name] ?? IMAGE_MS)) {
      this.#last.set(name, nowMs);
      this.#entries.push({ atMs: nowMs, kind, name, message, bytes });
      this.#bytes += bytes;
      const isOver = (it) => it && (it.atMs < nowMs - KEPT_MS || this.#bytes > MOST_BYTES);
      while (isOver(this.#entries[0])) this.#bytes -= this.#entries.shift().bytes;
    }
    return this.#show[kind](...message);
  }

  #ask(request) {
    if ("speed" in request) this.#rate = request.speed;
    if ("play" in request) this.#isPlaying = request.play;
    if (!this.isPaused && ("seek" in request || !this.#isPlaying)) this.#pausedMs = this.#atMs = performance.now();
    if ("seek" in request) {
      this.#isPlaying = false;
      this.#atMs = this.#pausedMs - KEPT_MS + request.seek * 1000;
    }
    // Playing at the end means following the present.
    if (this.isPaused && this.#isPlaying && this.#atMs >= this.#pausedMs) this.#resume();
    else this.#look();
    queueMicrotask(() => {
      this.#timeLine.answer();
      this.#tell();
    });
  }

  #play() {
    if (!this.isPaused || !this.#isPlaying) return;
    this.#atMs += PLAY_MS * this.#rate;
    if (this.#atMs >= this.#pausedMs) this.#resume();
    else this.#look();
    this.#tell();
  }

  #resume() {
    [this.#pausedMs, this.#isPlaying] = [null, true];
    this.#shown.clear();
    this.#moved(null);
  }

  // Shows the newest message of each name at the time.
  #look() {
    if (!this.isPaused) return;
    const past = this.#entries.filter((it) => it.atMs <= this.#atMs);
    const newest = new Map(past.map((it) => [it.name, it]));
    const heads = past.filter((it) => it.kind === "scene" && it.message[0].head);
    const trail = heads.map((it) => it.message[0].head.slice(12, 15));
    for (const [name, it] of newest) {
      if (this.#shown.get(name) !== it) this.#show[it.kind](...it.message, ...(it.kind === "scene" ? [trail] : []));
    }
    this.#shown = newest;
    this.#moved((this.#pausedMs - this.#atMs) / 1000);
  }

  #tell() {
    const at_s = (this.isPaused ? KEPT_MS + this.#atMs - this.#pausedMs : KEPT_MS) / 1000;
    this.#timeLine.show({ at_s, rate: this.#rate, is_playing: this.#isPlaying, jumps: 0 });
  }

  #words(atS) {
    if (!this.isPaused) return "live";
    const agoS = KEPT_MS / 1000 - atS;
    const then = Date.now() - (performance.now() - this.#pausedMs) - agoS * 1000;
    return `paused, ${agoS.toFixed(1)} s before · ${timeOfDay(then / 1000)}`;
  }
}
