// What app, headset and receiver say in the topic `log`, the newest first.
import { element, setText } from "./elements.js";
import { timeOfDay } from "./timeline.js";

const WARNING = "WARNING";

export class Log {
  #details = document.getElementById("log");

  show({ lines }) {
    const newest = [...lines].reverse();
    this.#details.hidden = !lines.length;
    if (!lines.length) return;
    const [[unixS, text]] = newest;
    const summary = this.#details.querySelector("summary");
    summary.className = levelOf(text);
    setText(summary, `log: ${timeOfDay(unixS)} ${text}`);
    this.#details.querySelector("ol").replaceChildren(
      ...newest.map(([thenS, words]) => element("li", levelOf(words), element("span", "quiet", `${timeOfDay(thenS)} `), words)),
    );
  }
}

function levelOf(text) {
  return text.startsWith(WARNING) ? "level-1" : "quiet";
}
