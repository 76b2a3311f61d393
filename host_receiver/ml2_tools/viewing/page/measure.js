// Measures between two points of the 3D view, which a click, or Enter for the middle, chooses.
import { BufferAttribute, BufferGeometry, Line, LineBasicMaterial, Mesh, MeshBasicMaterial, Raycaster, SphereGeometry, Vector2, Vector3 } from "./three.min.js";
import { setText } from "./elements.js";

const COLOUR = "#d81b60";
const NEAR_M = 0.04;
const MOST_DRAG_PX = 4;

export class Measure {
  #button;
  #output;
  #drawn;
  #line = new Line(new BufferGeometry(), new LineBasicMaterial({ color: COLOUR, depthTest: false }));
  #ends = [0, 1].map(() => new Mesh(new SphereGeometry(0.012, 10, 8), new MeshBasicMaterial({ color: COLOUR, depthTest: false })));
  #places = [];
  #raycaster = new Raycaster();
  #pressed = null;

  // `pickable` is what points are chosen of, seen by `camera`; `drawn` is called after a change.
  constructor(figure, space, camera, pickable, drawn) {
    this.#button = figure.querySelector("[data-measure]");
    this.#output = figure.querySelector("output");
    this.#drawn = drawn;
    this.#raycaster.params.Points.threshold = NEAR_M;
    space.add(this.#line, ...this.#ends);
    this.#button.onclick = () => this.#switch(!this.isOn);
    const canvas = figure.querySelector("canvas");
    const choose = (x, y) => this.#choose(new Vector2(x, y), camera, pickable);
    canvas.addEventListener("pointerdown", ({ offsetX, offsetY }) => (this.#pressed = [offsetX, offsetY]));
    canvas.addEventListener("pointerup", ({ offsetX, offsetY }) => {
      if (!this.isOn || !this.#pressed) return;
      // Dragging turns the view; only a click chooses a point.
      if (Math.hypot(offsetX - this.#pressed[0], offsetY - this.#pressed[1]) > MOST_DRAG_PX) return;
      choose((offsetX / canvas.clientWidth) * 2 - 1, 1 - (offsetY / canvas.clientHeight) * 2);
    });
    canvas.addEventListener("keydown", (event) => {
      if (!this.isOn) return;
      if (event.key === "Enter") choose(0, 0);
      if (event.key === "Escape") this.#switch(false);
    });
    this.#show();
  }

  get isOn() {
    return this.#button.getAttribute("aria-pressed") === "true";
  }

  // Takes an end of the distance; the third one begins another distance.
  take(place) {
    if (this.#places.length === 2) this.#places = [];
    this.#places.push(place);
    this.#show();
  }

  #switch(isOn) {
    this.#button.setAttribute("aria-pressed", String(isOn));
    this.#places = [];
    this.#show();
  }

  #choose(at, camera, pickable) {
    this.#raycaster.setFromCamera(at, camera);
    // The points change, and their bounds are not kept up to date.
    pickable.geometry.computeBoundingSphere();
    const found = this.#raycaster.intersectObject(pickable, false);
    // The nearest to the ray, and not the nearest to the viewer.
    const best = found.sort((a, b) => a.distanceToRay - b.distanceToRay)[0];
    if (best) this.take(best.point.toArray());
    else setText(this.#output, "no point there");
  }

  #show() {
    this.#ends.forEach((end, index) => {
      end.visible = index < this.#places.length;
      if (end.visible) end.position.fromArray(this.#places[index]);
    });
    const [first, second] = this.#places;
    this.#line.visible = Boolean(second);
    if (second) this.#line.geometry.setAttribute("position", new BufferAttribute(new Float32Array([...first, ...second]), 3));
    const metres = second && new Vector3(...first).distanceTo(new Vector3(...second));
    const next = ["choose a point", "choose another point"][this.#places.length] ?? `${metres?.toFixed(3)} m`;
    setText(this.#output, this.isOn ? next : "");
    this.#drawn();
  }
}
