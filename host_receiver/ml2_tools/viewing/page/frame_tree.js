// The tree of the frames in /tf and /tf_static, by name.
import { element, setText } from "./elements.js";

export class FrameTree {
  #details;
  #shown = "";

  constructor(details) {
    this.#details = details;
  }

  // `parents` has the parent of each frame.
  show(parents) {
    const now = JSON.stringify(parents);
    if (now === this.#shown) return;
    this.#shown = now;
    const children = new Map();
    for (const [child, parent] of Object.entries(parents)) {
      children.set(parent, [...(children.get(parent) ?? []), child]);
    }
    const roots = [...children.keys()].filter((it) => !(it in parents));
    setText(this.#details.querySelector("summary"), `${Object.keys(parents).length + roots.length} frames`);
    const seen = new Set();
    const tree = list(roots, children, seen);
    tree.setAttribute("role", "tree");
    this.#details.querySelector("div").replaceChildren(tree);
  }
}

// A frame may not be below itself, but any node may say so.
function list(names, children, seen) {
  const items = names.filter((it) => !seen.has(it)).sort().map((name) => {
    seen.add(name);
    const below = children.get(name);
    const item = element("li", "", name, ...(below ? [list(below, children, seen)] : []));
    item.setAttribute("role", "treeitem");
    return item;
  });
  const made = element("ul", "", ...items);
  made.setAttribute("role", "group");
  return made;
}
