// Shapes of the 3D view: places that change, and names that always face the viewer.
import { BufferAttribute, BufferGeometry, CanvasTexture, Sprite, SpriteMaterial, SRGBColorSpace } from "./three.min.js";

const PIXELS = 32;
const HEIGHT_M = 0.035;

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

// Returns a name beside a place.
export function label(name, colour) {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d");
  context.font = `${PIXELS}px system-ui, sans-serif`;
  canvas.width = Math.ceil(context.measureText(name).width) + 8;
  canvas.height = PIXELS + 8;
  context.font = `${PIXELS}px system-ui, sans-serif`;
  context.textBaseline = "middle";
  context.fillStyle = colour;
  context.fillText(name, 4, canvas.height / 2);
  const map = new CanvasTexture(canvas);
  map.colorSpace = SRGBColorSpace;
  const sprite = new Sprite(new SpriteMaterial({ map, depthTest: false }));
  sprite.center.set(0, 0);
  sprite.scale.set((HEIGHT_M * canvas.width) / canvas.height, HEIGHT_M, 1);
  return sprite;
}
