// The connection to the server that served this page. All messages but hello and answers are
// acknowledged once they are shown, so that a slow page gets fewer of them.

const RETRY_MS = 2000;
const WRONG_TOKEN = 4401;
const TOO_MANY = 1013;
const PAGE_FAILED = 4500;
const EXPIRED =
  "The address of this page is not valid any more. Open the address that `ml2-receiver view` prints.";
const text = new TextDecoder();

export function connect(handlers) {
  let socket;

  const send = (message) => {
    if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
  };

  function open() {
    const own = (socket = new WebSocket(`ws://${location.host}/live`));
    own.binaryType = "arraybuffer";
    own.onopen = () => send({ token: location.hash.slice(1) });
    own.onclose = (event) => {
      handlers.ended(reason(event));
      if (event.code !== WRONG_TOKEN) setTimeout(open, RETRY_MS);
    };
    own.onmessage = async (event) => {
      try {
        const name = await take(event.data);
        if (name !== null && own === socket) send({ seen: name });
      } catch (error) {
        // The server sends nothing more by this name without an acknowledgement.
        console.error(error);
        own.close(PAGE_FAILED, "this page failed");
      }
    };
  }

  // Returns the name by which a message is acknowledged.
  async function take(data) {
    if (typeof data !== "string") return takeImage(data);
    const message = JSON.parse(data);
    switch (message.type) {
      case "hello":
        handlers.hello(message);
        return null;
      case "image":
        handlers.brokenImage(message.stream, message.reason);
        return message.stream;
      case "answer":
      case "pixel":
        handlers[message.type](message);
        return null;
      case "scene":
      case "state":
      case "settings":
      case "pairing":
      case "log":
      case "products":
      case "position":
        handlers[message.type](message);
        return message.type;
      default:
        handlers.samples(message);
        return "samples";
    }
  }

  async function takeImage(data) {
    const view = new DataView(data);
    const length = view.getUint8(0);
    const stream = text.decode(new Uint8Array(data, 1, length));
    if (stream === "cloud") {
      takeCloud(data.slice(length + 5), view.getFloat32(length + 1, true) > 0);
      return stream;
    }
    if (stream === "snapshot") {
      handlers.snapshot(data.slice(length + 5));
      return null;
    }
    const jpeg = new Blob([new Uint8Array(data, length + 5)], { type: "image/jpeg" });
    await handlers.image(stream, jpeg, view.getFloat32(length + 1, true));
    return stream;
  }

  function takeCloud(data, isColoured) {
    const count = Math.floor(data.byteLength / (isColoured ? 15 : 12));
    const colours = isColoured ? new Uint8Array(data, 12 * count) : null;
    handlers.cloud(new Float32Array(data, 0, 3 * count), colours);
  }

  open();
  return { send, isOpen: () => socket.readyState === WebSocket.OPEN };
}

function reason(event) {
  if (event.code === WRONG_TOKEN) return EXPIRED;
  if (event.code === TOO_MANY) return "Too many browsers show this receiver. Close another page.";
  const why = event.reason ? `: ${event.reason}` : "";
  return `Disconnected${why}. Is \`ml2-receiver view\` running? The page tries again.`;
}
