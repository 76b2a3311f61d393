// Objects of places that change.
import { BufferAttribute, BufferGeometry } from "./three.min.js";

// An object of at most so many places.
export class Places {
  count = 0;
  #attribute;

  constructor(Kind, material, most) {
    this.#attribute = new BufferAttribute(new Float32Array(3 * most), 3);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.#attribute);
    this.object = new Kind(geometry, material);
    // The bounds of what moves would have to be computed each time.
    this.object.frustumCulled = false;
    this.set([]);
  }

  set(places) {
    this.setFlat(places.slice(-this.#attribute.count).flat());
  }

  setFlat(numbers) {
    this.count = Math.min(numbers.length / 3, this.#attribute.count);
    this.#attribute.array.set(numbers.slice(0, 3 * this.count));
    this.#attribute.needsUpdate = true;
    this.object.geometry.setDrawRange(0, this.count);
    return this.count;
  }
}
