// The facts about the headset at the top of the page, and under them warnings, lost messages, what the app uses of ROS, and the log.
import { element, setText } from "./elements.js";
import { timeOfDay } from "./timeline.js";

const WARNING = "WARNING";

export class Facts {
  #facts = document.getElementById("facts");
  #warnings = document.getElementById("warnings");
  #losses = document.getElementById("losses");
  #subscriptions = document.getElementById("subscriptions");
  #calls = document.getElementById("calls");
  #shown = "";

  show({ facts, warnings, losses, subscriptions, calls }) {
    // Elements that stay keep the reader's selection and place.
    const now = JSON.stringify([facts, warnings, losses, subscriptions, calls]);
    if (now === this.#shown) return;
    this.#shown = now;
    this.#facts.replaceChildren(
      ...facts.map((it) =>
        element("div", "", element("dt", "", it.name), element("dd", `level-${it.level}`, it.text)),
      ),
    );
    this.#warnings.replaceChildren(
      ...warnings.map((it) => {
        const name = element("b", "", it.level > 1 ? "error: " : "warning: ");
        return element("li", `level-${it.level}`, name, `${it.row}: ${it.text}`);
      }),
    );
    this.#showLosses(losses);
    this.#showSubscriptions(subscriptions);
    this.#showCalls(calls);
  }

  #showLosses(losses) {
    this.#losses.hidden = !losses.length;
    const recent = losses.filter((it) => it.recent);
    const count = recent.reduce((sum, it) => sum + it.recent, 0);
    const words = count ? `${counted(count, "message")} of ${counted(recent.length, "topic")}` : "nothing";
    const summary = this.#losses.querySelector("summary");
    summary.className = count ? "level-1" : "quiet";
    setText(summary, `lost in the last 10 s: ${words}`);
    fill(this.#losses, losses.map((it) => [it.topic, it.recent, it.all]));
  }

  #showSubscriptions(subscriptions) {
    this.#subscriptions.hidden = !subscriptions.length;
    const words = `the app subscribes to ${counted(subscriptions.length, "topic")} of ROS`;
    setText(this.#subscriptions.querySelector("summary"), words);
    fill(this.#subscriptions, subscriptions.map((it) => [it.topic, it.type, it.sent, it.superseded, it.lost]));
  }

  #showCalls(calls) {
    this.#calls.hidden = !calls.length;
    const words = `the app calls or offers ${counted(calls.length, "service")}`;
    setText(this.#calls.querySelector("summary"), words);
    fill(this.#calls, calls.map((it) => [it.service, it.by, it.type, it.requests, it.responses, it.failures]));
  }
}

function fill(details, rows) {
  const cells = (row) => row.map((cell) => element("td", "", String(cell)));
  details.querySelector("tbody").replaceChildren(...rows.map((row) => element("tr", "", ...cells(row))));
}

function counted(count, noun) {
  return `${count} ${noun}${count === 1 ? "" : "s"}`;
}

// Shows what app, headset and receiver say in the topic `log`, the newest first.
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
