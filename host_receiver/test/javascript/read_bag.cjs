// Reads an .mcap file with @mcap/core, checks its CRCs, decodes each message, and prints one JSON object per message:
//   NODE_PATH=... node read_bag.cjs indexed|sequential FILE
const { createHash } = require("node:crypto");
const { open, readFile } = require("node:fs/promises");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const { decompress } = require("fzstd");

const decompressHandlers = { zstd: (data) => decompress(data) };
const schemas = new Map();
const channels = new Map();
const readers = new Map();

function show(message) {
  const channel = channels.get(message.channelId);
  const schema = schemas.get(channel.schemaId);
  if (!readers.has(schema.id)) {
    readers.set(schema.id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
  }
  const decoded = readers.get(schema.id).readMessage(message.data);
  const stamp = (decoded.header ?? decoded.transforms?.[0]?.header)?.stamp;
  console.log(
    JSON.stringify({
      topic: channel.topic,
      type: schema.name,
      stamp: stamp && [stamp.sec, stamp.nanosec ?? stamp.nsec],
      sha256: createHash("sha256").update(message.data).digest("hex"),
    }),
  );
}

async function readIndexed(file) {
  const handle = await open(file);
  const readable = {
    size: async () => BigInt((await handle.stat()).size),
    read: async (offset, length) => {
      const { buffer } = await handle.read(new Uint8Array(Number(length)), 0, Number(length), Number(offset));
      return buffer;
    },
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  reader.schemasById.forEach((schema, id) => schemas.set(id, schema));
  reader.channelsById.forEach((channel, id) => channels.set(id, channel));
  for await (const message of reader.readMessages({ validateCrcs: true })) show(message);
  await handle.close();
}

async function readSequentially(file) {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  reader.append(await readFile(file));
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Schema") schemas.set(record.id, record);
    if (record.type === "Channel") channels.set(record.id, record);
    if (record.type === "Message") show(record);
  }
}

const [mode, file] = process.argv.slice(2);
(mode === "indexed" ? readIndexed : readSequentially)(file);
