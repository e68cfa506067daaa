// SPDX-License-Identifier: Apache-2.0
// Another reader and writer of MCAP (npm's @mcap/core), which Estancia's is compared with.
//   node mcap_core.js MODULES digest FILE      SHA-256 of all times and bytes in order of time (no compression)
//   node mcap_core.js MODULES write FOLDER     one recording in several ways
const [, , modules, verb, path] = process.argv;
const fs = require("fs");
const crypto = require("crypto");
const { McapStreamReader, McapWriter } = require(`${modules}/@mcap/core`);

function messagesOf(bytes) {
  const reader = new McapStreamReader();
  reader.append(new Uint8Array(bytes));
  const messages = [];
  for (let record; (record = reader.nextRecord()); ) if (record.type === "Message") messages.push(record);
  return messages;
}

function digest() {
  const messages = messagesOf(fs.readFileSync(path));
  messages.sort((a, b) => (a.logTime < b.logTime ? -1 : a.logTime > b.logTime ? 1 : 0));
  const hash = crypto.createHash("sha256");
  for (const message of messages) {
    const time = Buffer.alloc(8);
    time.writeBigUInt64LE(message.logTime);
    hash.update(time);
    hash.update(message.data);
  }
  console.log(hash.digest("hex"));
}

async function writeOne(name, options) {
  const parts = [];
  let size = 0n;
  const writable = {
    position: () => size,
    write: async (bytes) => {
      parts.push(Buffer.from(bytes));
      size += BigInt(bytes.length);
    },
  };
  const writer = new McapWriter({ writable, ...options });
  await writer.start({ profile: "ros2", library: "estancia's tests" });
  const channels = [];
  for (const [topic, type] of [["/odom", "nav_msgs/msg/Odometry"], ["/tf", "tf2_msgs/msg/TFMessage"]]) {
    const schemaId = await writer.registerSchema({ name: type, encoding: "ros2msg", data: Buffer.from("int32 n") });
    channels.push(
      await writer.registerChannel({ schemaId, topic, messageEncoding: "cdr", metadata: new Map() }),
    );
  }
  for (let i = 0; i < 300; ++i) {
    // Not in order of time.
    const time = 1700000000000000000n + BigInt(i ^ 5) * 1000000n;
    const data = Buffer.alloc(4 + (i % 50), i);
    data.writeUInt32LE(256, 0);
    await writer.addMessage({ channelId: channels[i % 3 === 0 ? 1 : 0], sequence: i, logTime: time, publishTime: time, data });
  }
  await writer.addMetadata({ name: "rosbag2", metadata: new Map([["serialized_metadata", "x: 1"]]) });
  await writer.end();
  fs.writeFileSync(`${path}/${name}.mcap`, Buffer.concat(parts));
}

async function write() {
  await writeOne("usual", { chunkSize: 2000 });
  await writeOne("no_chunks", { useChunks: false });
  await writeOne("no_message_index", { chunkSize: 2000, useMessageIndex: false });
  await writeOne("no_chunk_index", { chunkSize: 2000, useChunkIndex: false });
  await writeOne("no_statistics", { chunkSize: 2000, useStatistics: false });
  await writeOne("no_channels_repeated", { chunkSize: 2000, repeatChannels: false, repeatSchemas: false });
  await writeOne("no_summary", {
    chunkSize: 2000, useStatistics: false, useSummaryOffsets: false, useChunkIndex: false,
    repeatChannels: false, repeatSchemas: false, useMetadataIndex: false, useMessageIndex: false,
  });
}

Promise.resolve({ digest, write }[verb]()).catch((error) => {
  console.error(error);
  process.exit(1);
});
