// Puts together the page: what the server sends goes to the part of the page that shows it.
import { Actions } from "./actions.js";
import { Configuration } from "./configuration.js";
import { connect } from "./connection.js";
import { Enlarged } from "./enlarged.js";
import { Facts } from "./facts.js";
import { Pairing } from "./pairing.js";
import { Plots } from "./plots.js";
import { SceneView } from "./scene.js";
import { Streams } from "./streams.js";
import { TimeLine } from "./timeline.js";

const OVERDUE_MS = 3000;
// Messages of images in full size are named by this and the stream.
const FULL = "full ";
const notice = document.getElementById("notice");
const facts = new Facts();
const changed = new Set();
const actions = new Actions((request) => connection.send(request), changed);
const scene = new SceneView(askForShown);
const enlarged = new Enlarged(askForShown, (request) => connection.send(request));
const pairing = new Pairing((request) => connection.send(request));
let configuration = null;
let streams = null;
let plots = null;
let timeLine = null;
let reportedAt = 0;
let shown = [];
let asked = "";

function say(text) {
  notice.textContent = text;
  notice.hidden = !text;
}

function askForShown() {
  // An image in full size covers all others.
  const wanted = [...(enlarged.wanted ?? [...shown, ...scene.wanted]), ...(plots?.wanted ?? [])];
  if (!connection.isOpen() || wanted.join() === asked) return;
  asked = wanted.join();
  connection.send({ show: wanted });
}

function shownBy(name, show) {
  return name.startsWith(FULL) ? show(enlarged, name.slice(FULL.length)) : show(streams, name);
}

const connection = connect({
  ended: say,
  hello(hello) {
    const { recording } = hello;
    say(recording ? "Reading the recording…" : "Waiting for the receiver's report…");
    reportedAt = 0;
    // The server of this page may have restarted, with other streams.
    streams?.close();
    plots?.close();
    timeLine?.close();
    enlarged.close();
    pairing.close();
    [shown, asked] = [[], ""];
    const showImages = (streams) => {
      shown = streams;
      askForShown();
    };
    streams = new Streams(hello.images, showImages, (stream) => enlarged.open(stream));
    plots = new Plots(hello, askForShown, plots?.picked ?? []);
    const ask = (request) => connection.send(request);
    // Only a receiver is steered, and only a recording has a time line.
    for (const id of ["actions", "configuration"]) document.getElementById(id).hidden = Boolean(recording);
    if (recording) document.getElementById("nothing").textContent = "The recording has no images.";
    configuration = new Configuration(hello.controls ?? [], ask, changed);
    timeLine = recording ? new TimeLine(recording, ask) : null;
    actions.reset();
    askForShown();
  },
  state(state) {
    reportedAt = performance.now();
    say(state.problem ?? "");
    if (state.problem) return actions.refuse(state.problem);
    if (state.doing) actions.show(state.doing);
    facts.show(state);
    streams.show(state.streams);
    plots.offer(state.topics);
    configuration.showApplied(state.applied);
  },
  scene: (poses) => scene.show(poses),
  cloud: (places) => scene.showCloud(places),
  position(position) {
    if (timeLine.show(position)) scene.forgetTrail();
    plots.setClock(position.at_s, position.is_playing ? position.rate : 0);
  },
  pairing: (news) => pairing.show(news),
  settings: (settings) => configuration.show(settings),
  answer(answer) {
    timeLine?.answer();
    actions.answer(answer);
    pairing.answer(answer);
    configuration.answer(answer);
  },
  samples: (samples) => plots.add(samples),
  image: (name, jpeg, farMetres) => shownBy(name, (it, stream) => it.draw(stream, jpeg, farMetres)),
  brokenImage: (name, reason) => shownBy(name, (it, stream) => it.fail(stream, reason)),
  pixel: (pixel) => enlarged.pixel(pixel),
});

setInterval(() => {
  const silence = performance.now() - reportedAt;
  if (reportedAt && silence > OVERDUE_MS && connection.isOpen()) {
    say(`The receiver has not reported for ${Math.round(silence / 1000)} s. Is \`ml2-receiver run\` running?`);
    actions.refuse("the receiver does not report");
  }
}, 1000);
