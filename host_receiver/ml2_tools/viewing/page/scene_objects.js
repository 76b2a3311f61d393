// The objects of the 3D view, in metres in the world frame: x forward, y left, z up.
import { Frustum } from "./frustum.js";
import { label, Places } from "./shapes.js";
import {
  AxesHelper, BufferAttribute, Color, GridHelper, InstancedMesh, Line, LineBasicMaterial, LineSegments, Matrix4, Mesh,
  MeshBasicMaterial, Points, PointsMaterial, SphereGeometry, SRGBColorSpace,
} from "./three.min.js";

// Each can be told from a light ground and from a dark one.
const HEAD = "#d99000";
const WIRES = { color: HEAD, wireframe: true, transparent: true, opacity: 0.35 };
const GAZE = "#e0348c";
const HANDS = { hand_left: "#e8622c", hand_right: "#1fa35f" };
const CAMERAS = ["#2f80ed", "#a45bd6", "#12a5ab", "#5a9e1b", "#d9607a", "#b08d1e", "#6a74e0"];
const TRAIL_MS = 30000;
const MOST_TRAIL = 1000;
const GAZE_M = 2;
const JOINT_M = 0.006;
const FRAME_M = 0.15;
const PLACE = new SphereGeometry(0.02, 8, 6);
// OpenXR's XrHandJointEXT: 0 is the palm, 1 the wrist, then come the fingers from the thumb on.
const JOINTS = 26;
const FINGERS = [[1, 2, 3, 4, 5], [1, 6, 7, 8, 9, 10], [1, 11, 12, 13, 14, 15], [1, 16, 17, 18, 19, 20], [1, 21, 22, 23, 24, 25]];
const BONES = FINGERS.flatMap((it) => it.slice(1).map((joint, index) => [it[index], joint]));

export class SceneObjects {
  #space;
  // White, so that its colour is that of its material.
  #grid = new GridHelper(10, 20, "#fff", "#fff");
  #head = new Mesh(new SphereGeometry(0.08, 10, 7), new MeshBasicMaterial(WIRES));
  #trail = new Places(Line, new LineBasicMaterial({ color: HEAD }), MOST_TRAIL);
  #passed = [];
  #hasImages = true;
  #gaze = new Places(Line, new LineBasicMaterial({ color: GAZE }), 2);
  #cloud = new Places(Points, new PointsMaterial({ size: 2, sizeAttenuation: false, vertexColors: true }), 5000);
  #colours = new BufferAttribute(new Float32Array(5000 * 3), 3);
  #cameras = new Map();
  #hands = new Map();
  // Of other programs: tags, robots, maps.
  #frames = new Map();

  constructor(space) {
    this.#space = space;
    this.#grid.rotation.x = Math.PI / 2;
    this.#head.matrixAutoUpdate = false;
    this.#head.add(new AxesHelper(0.2));
    this.#cloud.object.geometry.setAttribute("color", this.#colours);
    for (const [hand, colour] of Object.entries(HANDS)) this.#hands.set(hand, new Hand(colour));
    space.add(this.#grid, new AxesHelper(0.5), this.#head);
    space.add(this.#trail.object, this.#gaze.object, this.#cloud.object);
    for (const it of this.#hands.values()) space.add(it.joints, it.bones.object);
  }

  // The points of the depth image, as an object.
  get points() {
    return this.#cloud.object;
  }

  showImage(stream, canvas) {
    this.#cameras.get(stream)?.showImage(canvas);
  }

  setImagesVisible(isOn) {
    this.#hasImages = isOn;
    for (const it of this.#cameras.values()) it.image.visible = isOn;
  }

  // Sets the colours of the background and of the grid.
  setTheme(ground, grid) {
    this.#space.background = new Color(ground);
    this.#grid.material.color.set(grid);
  }

  show({ head, gaze, hands, cameras, frames, markers }, trail) {
    this.#showHead(head, trail);
    this.#gaze.set(gaze ? [gaze.slice(12, 15), ahead(gaze, GAZE_M)] : []);
    for (const [name, hand] of this.#hands) hand.show(hands[name] ?? []);
    for (const [stream, camera] of this.#cameras) camera.object.visible = stream in cameras;
    for (const [stream, { pose, corners }] of Object.entries(cameras)) {
      if (!this.#cameras.has(stream)) this.#addCamera(stream);
      this.#cameras.get(stream).show(pose, corners);
    }
    this.#showFrames(frames);
    this.#showMarkers(markers);
  }

  // `colours` has red, green and blue of each point; without them, they are by height.
  showCloud(places, colours) {
    const count = this.#cloud.setFlat(places);
    const colour = new Color();
    for (let i = 0; i < count; i++) {
      if (colours) colour.setRGB(colours[3 * i] / 255, colours[3 * i + 1] / 255, colours[3 * i + 2] / 255, SRGBColorSpace);
      // From the floor on, red to blue over 2.5 m.
      else colour.setHSL(Math.min(0.7, Math.max(0, 0.28 * (places[3 * i + 2] + 1.5))), 0.8, 0.5);
      this.#colours.setXYZ(i, colour.r, colour.g, colour.b);
    }
    this.#colours.needsUpdate = true;
  }

  forgetTrail() {
    this.#passed = [];
  }

  // Names and colours of what can be seen.
  legend() {
    const cameras = [...this.#cameras].filter(([, it]) => it.object.visible);
    const hands = [...this.#hands].filter(([, it]) => it.isTracked);
    const named = [...cameras.map(([name, it]) => [name, it.colour]), ...hands.map(([name]) => [name, HANDS[name]])];
    if (this.#gaze.count) named.push(["gaze", GAZE]);
    if (this.#head.visible) named.unshift(["head", HEAD]);
    const frames = [...this.#frames].map(([name, it]) => [name, it.colour]);
    return [...named.map(([name, colour]) => [name.replaceAll("_", " "), colour]), ...frames];
  }

  #showFrames(frames) {
    for (const [name, { object }] of this.#frames) {
      if (name in frames) continue;
      this.#space.remove(object);
      this.#frames.delete(name);
    }
    for (const [name, pose] of Object.entries(frames)) {
      if (!this.#frames.has(name)) {
        const colour = CAMERAS[this.#frames.size % CAMERAS.length];
        const object = new Mesh(PLACE, new MeshBasicMaterial({ color: colour }));
        object.matrixAutoUpdate = false;
        object.add(new AxesHelper(FRAME_M), label(name, colour));
        this.#frames.set(name, { object, colour });
        this.#space.add(object);
      }
      this.#frames.get(name).object.matrix.fromArray(pose);
    }
  }

  // `markers` has the sides of those that are seen, by their frames.
  #showMarkers(markers) {
    for (const [name, it] of this.#frames) {
      if (name in markers && !it.square) {
        it.square = new Places(Line, new LineBasicMaterial({ color: it.colour }), 5);
        it.object.add(it.square.object);
      }
      const half = (markers[name] ?? 0) / 2;
      it.square?.set([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0], [-half, half, 0]]);
    }
  }

  #showHead(head, trail) {
    this.#head.visible = Boolean(head);
    if (trail) {
      if (head) this.#head.matrix.fromArray(head);
      return this.#trail.set(trail);
    }
    const now = performance.now();
    if (head) {
      this.#head.matrix.fromArray(head);
      this.#passed.push([now, head.slice(12, 15)]);
    }
    const first = this.#passed.findIndex(([then]) => then >= now - TRAIL_MS);
    this.#passed.splice(0, first < 0 ? this.#passed.length : first);
    this.#trail.set(this.#passed.map(([, place]) => place));
  }

  #addCamera(stream) {
    const colour = CAMERAS[this.#cameras.size % CAMERAS.length];
    const camera = new Frustum(stream.replaceAll("_", " "), colour);
    camera.image.visible = this.#hasImages;
    this.#cameras.set(stream, camera);
    this.#space.add(camera.object);
  }
}

class Hand {
  isTracked = false;

  constructor(colour) {
    const material = new MeshBasicMaterial({ color: colour });
    this.joints = new InstancedMesh(new SphereGeometry(JOINT_M, 8, 6), material, JOINTS);
    this.joints.frustumCulled = false;
    this.bones = new Places(LineSegments, new LineBasicMaterial({ color: colour }), 2 * BONES.length);
    this.show([]);
  }

  show(joints) {
    const tracked = joints.slice(0, JOINTS).filter(Boolean);
    const matrix = new Matrix4();
    tracked.forEach((place, index) => this.joints.setMatrixAt(index, matrix.makeTranslation(...place)));
    this.joints.count = tracked.length;
    this.joints.instanceMatrix.needsUpdate = true;
    this.bones.set(BONES.filter((it) => it.every((joint) => joints[joint])).flatMap((it) => it.map((joint) => joints[joint])));
    this.isTracked = tracked.length > 0;
  }
}

// Returns the place at a distance along the x axis of a pose.
function ahead(pose, metres) {
  return [0, 1, 2].map((axis) => pose[12 + axis] + metres * pose[axis]);
}
