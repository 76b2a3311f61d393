// The 3D view: a camera that follows the head, turns around it, or looks from above.
import { OrbitControls, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "./three.min.js";
import { element } from "./elements.js";
import { FrameTree } from "./frame_tree.js";
import { Measure } from "./measure.js";
import { SceneObjects } from "./scene_objects.js";

// Metres from the head: as close as shows both hands.
const BEHIND = 1.1;
const ABOVE = 0.45;
const TOP = 3;
const SMOOTHING = 0.3;

export class SceneView {
  #figure = document.getElementById("scene");
  #canvas = this.#figure.querySelector("canvas");
  #legend = this.#figure.querySelector(".legend");
  #images = this.#figure.querySelector("[data-images]");
  #tree = new FrameTree(this.#figure.querySelector("details"));
  #hide = this.#figure.querySelector("[data-hide]");
  #views = [...this.#figure.querySelectorAll("[data-view]")];
  #view = "follow";
  #isOn = true;
  #isInView = false;
  #isDrawing = false;
  #isPlaced = false;
  #changed;
  #renderer;
  #camera = new PerspectiveCamera(55, 1, 0.05, 60);
  #space = new Scene();
  #objects = new SceneObjects(this.#space);
  #controls;
  #head = null;

  constructor(changed) {
    this.#changed = changed;
    this.#renderer = rendererOf(this.#canvas);
    if (!this.#renderer) {
      this.#figure.style.gridArea = "auto";
      this.#figure.replaceChildren(element("figcaption", "", "The 3D view needs WebGL, which this browser does not offer."));
      return;
    }
    this.#camera.up.set(0, 0, 1);
    const theme = matchMedia("(prefers-color-scheme: dark)");
    theme.addEventListener("change", () => this.#setTheme());
    this.#setTheme();
    this.#controls = new OrbitControls(this.#camera, this.#canvas);
    this.#controls.listenToKeyEvents(this.#canvas);
    this.#controls.addEventListener("change", () => this.#draw());
    // Dragging or pressing an arrow key means looking around.
    this.#controls.addEventListener("start", () => this.#view === "follow" && this.#choose("orbit"));
    this.#canvas.addEventListener("keydown", (event) => {
      if (event.key.startsWith("Arrow") && this.#view === "follow") this.#choose("orbit");
    });
    for (const button of this.#views) {
      button.onclick = () => this.#choose(button.dataset.view, true);
    }
    new Measure(this.#figure, this.#space, this.#camera, this.#objects.points, () => this.#draw());
    this.#images.onclick = () => {
      const isOn = this.#images.getAttribute("aria-pressed") !== "true";
      this.#images.setAttribute("aria-pressed", String(isOn));
      this.#objects.setImagesVisible(isOn);
      this.#draw();
    };
    this.#hide.onclick = () => this.#switch();
    new ResizeObserver(() => this.#resize()).observe(this.#canvas);
    new IntersectionObserver(([entry]) => {
      this.#isInView = entry.isIntersecting;
      this.#changed();
    }).observe(this.#figure);
    document.addEventListener("visibilitychange", () => this.#changed());
  }

  // The data that this view asks the server for.
  get wanted() {
    return this.#renderer && this.#isOn && this.#isInView && !document.hidden ? ["scene", "cloud"] : [];
  }

  // A `trail` is that of an earlier time, as places.
  show(scene, trail) {
    this.#objects.show(scene, trail);
    this.#showLegend();
    this.#tree.show(scene.parents);
    this.#head = scene.head;
    if (this.#head && !this.#isPlaced) {
      this.#isPlaced = true;
      this.#place(1);
    } else if (this.#head && this.#view === "follow") this.#place(SMOOTHING);
    this.#draw();
  }

  // Called when the time jumps.
  forgetTrail() {
    this.#objects.forgetTrail();
  }

  // Shows what is on a canvas in the frustum of a camera.
  showImage(stream, canvas) {
    if (this.wanted.length) this.#objects.showImage(stream, canvas);
  }

  showCloud(places, colours) {
    this.#objects.showCloud(places, colours);
    this.#draw();
  }

  #choose(view, isPlacing = false) {
    this.#view = view;
    for (const it of this.#views) it.setAttribute("aria-pressed", String(it.dataset.view === view));
    this.#controls.enableRotate = view !== "top";
    if (isPlacing && this.#head) this.#place(1);
    this.#draw();
  }

  // Moves the camera by a share of the way to where the view wants it.
  #place(share) {
    const [forwardX, forwardY] = this.#head;
    const head = new Vector3(...this.#head.slice(12, 15));
    const forward = new Vector3(forwardX, forwardY, 0).normalize();
    const place = head.clone();
    if (this.#view === "top") place.addScaledVector(forward, -0.01).setZ(head.z + TOP);
    else place.addScaledVector(forward, -BEHIND).setZ(head.z + ABOVE);
    const target = this.#view === "top" ? head : head.addScaledVector(forward, 0.4);
    this.#camera.position.lerp(place, share);
    this.#controls.target.lerp(target, share);
    this.#controls.update();
  }

  #setTheme() {
    const style = getComputedStyle(this.#figure);
    this.#objects.setTheme(style.getPropertyValue("--space"), style.getPropertyValue("--grid"));
    this.#draw();
  }

  #switch() {
    this.#isOn = !this.#isOn;
    this.#hide.textContent = this.#isOn ? "Hide" : "Show";
    this.#canvas.hidden = this.#legend.hidden = !this.#isOn;
    this.#changed();
  }

  #showLegend() {
    const entries = this.#objects.legend();
    if (this.#legend.dataset.shown === JSON.stringify(entries)) return;
    this.#legend.dataset.shown = JSON.stringify(entries);
    this.#legend.replaceChildren(
      ...entries.map(([name, colour]) => {
        const mark = element("i");
        mark.style.background = colour;
        return element("li", "", mark, name);
      }),
    );
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    if (!width || !height) return;
    this.#renderer.setSize(width, height, false);
    this.#camera.aspect = width / height;
    this.#camera.updateProjectionMatrix();
    this.#draw();
  }

  #draw() {
    if (this.#isDrawing) return;
    this.#isDrawing = true;
    requestAnimationFrame(() => {
      this.#isDrawing = false;
      this.#renderer.render(this.#space, this.#camera);
    });
  }
}

function rendererOf(canvas) {
  try {
    return new WebGLRenderer({ canvas, antialias: true });
  } catch {
    return null;
  }
}
