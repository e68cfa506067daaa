// SPDX-License-Identifier: Apache-2.0
// An RGB-D drive as rosbag2 records it, by a writer of others (npm's @mcap/core and @foxglove/rosmsg2-serialization):
//   node write_drive.js NODE_MODULES DRIVE.json DRIVE.mcap
// DRIVE.json: {"width", "height", "matrix": [9], "topics": ["image", "compressed", "depth", "odom", "tf", "tf_static"],
// "frames": [{"stamp", "color", "jpeg", "depth": files}], "body": [{"stamp", "pose": [7]}], "mount": [7],
// "lens": {"distortion_model", "d"}, "damaged": [[topic, type, bytes in hex]]}; the last two may be left out.
// Further topics: "left" and "right", depth cameras of their own in the frame "depth"; "beside", the transform of that
// frame, a tenth of a meter to the left of the camera's; "pose", poses without a name of what has them.
const fs = require("fs");
const path = require("path");
const [modules, description, output] = process.argv.slice(2);
const { parse } = require(path.join(modules, "@foxglove/rosmsg"));
const { MessageWriter } = require(path.join(modules, "@foxglove/rosmsg2-serialization"));
const { McapWriter } = require(path.join(modules, "@mcap/core"));
const drive = JSON.parse(fs.readFileSync(description));

const shared = `
===
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
===
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
===
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
===
MSG: geometry_msgs/Pose
geometry_msgs/Vector3 position
geometry_msgs/Quaternion orientation
===
MSG: geometry_msgs/Transform
geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
===
MSG: geometry_msgs/PoseWithCovariance
geometry_msgs/Pose pose
float64[36] covariance
===
MSG: geometry_msgs/TwistWithCovariance
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
float64[36] covariance
===
MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
===
MSG: sensor_msgs/RegionOfInterest
uint32 x_offset
uint32 y_offset
uint32 height
uint32 width
bool do_rectify
`;
const definitions = {
  "sensor_msgs/msg/Image":
    "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data",
  "sensor_msgs/msg/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data",
  "sensor_msgs/msg/CameraInfo":
    "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\n" +
    "float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi",
  "nav_msgs/msg/Odometry":
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n" +
    "geometry_msgs/TwistWithCovariance twist",
  "geometry_msgs/msg/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose",
  "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms",
};

const header = (stamp, frame_id) => ({
  stamp: { sec: Math.floor(stamp / 1e9), nsec: stamp % 1e9 },
  frame_id,
});
const camera = "camera_color_optical_frame";
const vector = (n) => ({ x: n[0], y: n[1], z: n[2] });
const quaternion = (n) => ({ x: n[3], y: n[4], z: n[5], w: n[6] });
const transform = (stamp, parent, child_frame_id, pose) => ({
  header: header(stamp, parent),
  child_frame_id,
  transform: { translation: vector(pose), rotation: quaternion(pose) },
});
const zero = vector([0, 0, 0]);

function* messages() {
  const wanted = new Set(drive.topics);
  const { width, height } = drive;
  const first = drive.frames[0].stamp;
  if (wanted.has("tf_static"))
    yield ["/tf_static", "tf2_msgs/msg/TFMessage", first, { transforms: [transform(first, "base_link", camera, drive.mount)] }];
  if (wanted.has("beside"))
    yield ["/tf_static", "tf2_msgs/msg/TFMessage", first,
      { transforms: [transform(first, camera, "depth", [-0.1, 0, 0, 0, 0, 0, 1])] }];
  for (const { stamp, pose } of drive.body) {
    if (wanted.has("odom"))
      yield ["/odom", "nav_msgs/msg/Odometry", stamp, {
        header: header(stamp, "odom"),
        child_frame_id: "base_link",
        pose: { pose: { position: vector(pose), orientation: quaternion(pose) }, covariance: Array(36).fill(0) },
        twist: { linear: zero, angular: zero, covariance: Array(36).fill(0) },
      }];
    if (wanted.has("tf"))
      yield ["/tf", "tf2_msgs/msg/TFMessage", stamp, { transforms: [transform(stamp, "odom", "base_link", pose)] }];
  }
  for (const frame of drive.frames) {
    const image = (encoding, step, file) => ({
      header: header(frame.stamp, camera), height, width, encoding, is_bigendian: 0, step, data: fs.readFileSync(file),
    });
    if (wanted.has("image"))
      yield ["/camera/color/image_raw", "sensor_msgs/msg/Image", frame.stamp, image("bgr8", 3 * width, frame.color)];
    if (wanted.has("compressed"))
      yield ["/camera/color/image_raw/compressed", "sensor_msgs/msg/CompressedImage", frame.stamp,
        { header: header(frame.stamp, camera), format: "jpeg", data: fs.readFileSync(frame.jpeg) }];
    if (wanted.has("depth"))
      yield ["/camera/aligned_depth_to_color/image_raw", "sensor_msgs/msg/Image", frame.stamp,
        image("16UC1", 2 * width, frame.depth)];
    const info = (frame_id, lens) => ({
      header: header(frame.stamp, frame_id), height, width, distortion_model: "plumb_bob", d: [0, 0, 0, 0, 0], ...lens,
      k: drive.matrix, r: [1, 0, 0, 0, 1, 0, 0, 0, 1], p: Array(12).fill(0), binning_x: 0, binning_y: 0,
      roi: { x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false },
    });
    yield ["/camera/color/camera_info", "sensor_msgs/msg/CameraInfo", frame.stamp, info(camera, drive.lens)];
    for (const own of ["left", "right"])
      if (wanted.has(own)) {
        const depth = { ...image("16UC1", 2 * width, frame.depth), header: header(frame.stamp, "depth") };
        yield [`/${own}/image_raw`, "sensor_msgs/msg/Image", frame.stamp, depth];
        yield [`/${own}/camera_info`, "sensor_msgs/msg/CameraInfo", frame.stamp, info("depth", {})];
      }
    if (wanted.has("pose"))
      yield ["/pose", "geometry_msgs/msg/PoseStamped", frame.stamp,
        { header: header(frame.stamp, "map"), pose: { position: vector([7, 0, 0]), orientation: quaternion([0, 0, 0, 0, 0, 0, 1]) } }];
  }
  for (const [topic, type, bytes] of drive.damaged ?? []) yield [topic, type, first, Buffer.from(bytes, "hex")];
}

async function write() {
  const file = fs.openSync(output, "w");
  let size = 0n;
  const writable = {
    position: () => size,
    write: async (bytes) => {
      fs.writeSync(file, bytes);
      size += BigInt(bytes.length);
    },
  };
  const writer = new McapWriter({ writable });
  await writer.start({ profile: "ros2", library: "estancia's tests" });
  const channels = new Map();
  for (const [topic, type, time, message] of messages()) {
    if (!channels.has(topic)) {
      const text = definitions[type] + shared;
      const schemaId = await writer.registerSchema({ name: type, encoding: "ros2msg", data: Buffer.from(text) });
      const id = await writer.registerChannel({ schemaId, topic, messageEncoding: "cdr", metadata: new Map() });
      channels.set(topic, { id, writer: new MessageWriter(parse(text, { ros2: true })) });
    }
    const channel = channels.get(topic);
    await writer.addMessage({
      channelId: channel.id, sequence: 0, logTime: BigInt(time), publishTime: BigInt(time),
      data: Buffer.isBuffer(message) ? message : channel.writer.writeMessage(message),
    });
  }
  await writer.end();
  fs.closeSync(file);
}

write().catch((error) => {
  console.error(error);
  process.exit(1);
});
