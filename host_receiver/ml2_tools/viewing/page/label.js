// A name beside a place of the 3D view, which always faces the viewer.
import { CanvasTexture, Sprite, SpriteMaterial, SRGBColorSpace } from "./three.min.js";

const PIXELS = 32;
const HEIGHT_M = 0.035;

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
