// Puts together the page: what the server sends goes to the part of the page that shows it.
import { Actions } from "./actions.js";
import { Configuration } from "./configuration.js";
import { connect } from "./connection.js";
import { Enlarged } from "./enlarged.js";
import { Facts, Log } from "./facts.js";
import { History } from "./history.js";
import { Pairing } from "./pairing.js";
import { Plots } from "./plots.js";
import { SceneView } from "./scene.js";
import { Snapshot } from "./snapshot.js";
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
const log = new Log();
const snapshot = new Snapshot((request) => connection.send(request));
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

const history = new History(
  {
    scene: (poses, trail) => scene.show(poses, trail),
    cloud: (places, colours) => scene.showCloud(places, colours),
    async image(stream, jpeg, farMetres) {
      const canvas = await streams.draw(stream, jpeg, farMetres);
      if (canvas) scene.showImage(stream, canvas);
    },
  },
  (agoS) => {
    plots.look(agoS);
    askForShown();
  },
);

function askForShown() {
  // An image in full size covers all others, and a paused page has what it shows.
  const images = history.isPaused ? [] : (enlarged.wanted ?? [...shown, ...scene.wanted]);
  const wanted = [...images, ...(plots?.wanted ?? [])];
  if (!connection.isOpen() || wanted.join() === asked) return;
  asked = wanted.join();
  connection.send({ show: wanted });
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
    streams = new Streams(hello.images, showImages, (stream) => enlarged.open(stream, history.shown(stream)));
    plots = new Plots(hello, askForShown, plots?.picked ?? []);
    const ask = (request) => connection.send(request);
    // Only a receiver is steered, and only a recording has a time line.
    for (const id of ["actions", "configuration"]) document.getElementById(id).hidden = Boolean(recording);
    if (recording) document.getElementById("nothing").textContent = "The recording has no images.";
    configuration = new Configuration(hello.controls ?? [], ask, changed);
    history.reset(!recording);
    timeLine = recording ? new TimeLine(recording, ask) : null;
    actions.reset();
    snapshot.reset();
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
  scene: (poses) => history.scene(poses),
  cloud: (places, colours) => history.cloud(places, colours),
  snapshot: (bytes) => snapshot.save(bytes),
  position(position) {
    if (timeLine.show(position)) scene.forgetTrail();
    plots.setClock(position.at_s, position.is_playing ? position.rate : 0);
  },
  pairing: (news) => pairing.show(news),
  log: (lines) => log.show(lines),
  products: (products) => actions.showProducts(products),
  settings: (settings) => configuration.show(settings),
  answer(answer) {
    timeLine?.answer();
    actions.answer(answer);
    pairing.answer(answer);
    configuration.answer(answer);
  },
  samples: (samples) => history.isPaused || plots.add(samples),
  image(name, jpeg, farMetres) {
    if (name.startsWith(FULL)) return enlarged.draw(name.slice(FULL.length), jpeg, farMetres);
    return history.image(name, jpeg, farMetres);
  },
  brokenImage(name, reason) {
    if (name.startsWith(FULL)) enlarged.fail(name.slice(FULL.length), reason);
    else if (!history.isPaused) streams.fail(name, reason);
  },
  pixel: (pixel) => enlarged.pixel(pixel),
});

setInterval(() => {
  const silence = performance.now() - reportedAt;
  if (reportedAt && silence > OVERDUE_MS && connection.isOpen()) {
    say(`The receiver has not reported for ${Math.round(silence / 1000)} s. Is \`ml2-receiver run\` running?`);
    actions.refuse("the receiver does not report");
  }
}, 1000);
