// The view of a camera: a pyramid of lines with the camera's image on its base.
import { BufferAttribute, BufferGeometry, CanvasTexture, DoubleSide, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, SRGBColorSpace } from "./three.min.js";
import { label, Places } from "./shapes.js";

const FAR_M = 0.3;
const IMAGE = { width: 160, height: 120 };
const PERIOD_MS = 200;
// Corners from the upper left one on, clockwise.
const TRIANGLES = [0, 1, 2, 0, 2, 3];
const CORNERS = [0, 1, 1, 1, 1, 0, 0, 0];

export class Frustum {
  #lines;
  #corners = new BufferAttribute(new Float32Array(12), 3);
  #context;
  #texture;
  #label;
  #nextMs = 0;

  constructor(name, colour) {
    this.colour = colour;
    this.#lines = new Places(LineSegments, new LineBasicMaterial({ color: colour }), 16);
    this.#lines.object.matrixAutoUpdate = false;
    const canvas = Object.assign(document.createElement("canvas"), IMAGE);
    this.#context = canvas.getContext("2d");
    this.#texture = new CanvasTexture(canvas);
    this.#texture.colorSpace = SRGBColorSpace;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.#corners);
    geometry.setAttribute("uv", new BufferAttribute(new Float32Array(CORNERS), 2));
    geometry.setIndex(TRIANGLES);
    const material = new MeshBasicMaterial({ map: this.#texture, side: DoubleSide, transparent: true, opacity: 0.6, depthWrite: false });
    this.image = new Mesh(geometry, material);
    this.image.frustumCulled = false;
    this.#label = label(name, colour);
    this.object.add(this.image, this.#label);
  }

  get object() {
    return this.#lines.object;
  }

  show(pose, corners) {
    const far = corners.map((it) => it.map((value) => value * FAR_M));
    this.#lines.set(far.flatMap((it, index) => [[0, 0, 0], it, it, far[(index + 1) % 4]]));
    this.#corners.array.set(far.flat());
    this.#corners.needsUpdate = true;
    this.#label.position.fromArray(far[0]);
    this.object.matrix.fromArray(pose);
  }

  showImage(canvas) {
    if (!this.image.visible || performance.now() < this.#nextMs) return;
    this.#nextMs = performance.now() + PERIOD_MS;
    this.#context.drawImage(canvas, 0, 0, IMAGE.width, IMAGE.height);
    this.#texture.needsUpdate = true;
  }
}
