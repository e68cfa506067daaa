// SPDX-License-Identifier: Apache-2.0
// Messages of ROS 2 Humble by a writer of others: node write_messages.js NODE_MODULES FOLDER
const fs = require("fs");
const path = require("path");
const [modules, folder] = process.argv.slice(2);
const { parse } = require(path.join(modules, "@foxglove/rosmsg"));
const { MessageWriter, MessageReader } = require(path.join(modules, "@foxglove/rosmsg2-serialization"));

// Field by field as in Humble's .msg files (visualization_msgs 4.2, sensor_msgs 4.2).
const header = `
===
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
`;
const definitions = {
  string: "string data",
  image: `std_msgs/Header header
uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data` + header,
  markers: `visualization_msgs/Marker[] markers
===
MSG: visualization_msgs/Marker
std_msgs/Header header
string ns
int32 id
int32 type
int32 action
geometry_msgs/Pose pose
geometry_msgs/Vector3 scale
std_msgs/ColorRGBA color
builtin_interfaces/Duration lifetime
bool frame_locked
geometry_msgs/Point[] points
std_msgs/ColorRGBA[] colors
string texture_resource
sensor_msgs/CompressedImage texture
visualization_msgs/UVCoordinate[] uv_coordinates
string text
string mesh_resource
visualization_msgs/MeshFile mesh_file
bool mesh_use_embedded_materials
===
MSG: visualization_msgs/UVCoordinate
float32 u
float32 v
===
MSG: visualization_msgs/MeshFile
string filename
uint8[] data
===
MSG: sensor_msgs/CompressedImage
std_msgs/Header header
string format
uint8[] data
===
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
===
MSG: geometry_msgs/Point
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
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
===
MSG: std_msgs/ColorRGBA
float32 r
float32 g
float32 b
float32 a` + header,
};

// tests/ros/test_published_messages.cpp writes the same.
const marker = (fields) => ({
  header: { stamp: { sec: 0, nsec: 0 }, frame_id: "map" },
  ns: "", id: 0, type: 1, action: 0,
  pose: { position: { x: 0, y: 0, z: 0 }, orientation: { x: 0, y: 0, z: 0, w: 1 } },
  scale: { x: 1, y: 1, z: 1 }, color: { r: 1, g: 1, b: 1, a: 1 }, lifetime: { sec: 0, nsec: 0 },
  frame_locked: false, points: [], colors: [], texture_resource: "",
  texture: { header: { stamp: { sec: 0, nsec: 0 }, frame_id: "" }, format: "", data: new Uint8Array() },
  uv_coordinates: [], text: "", mesh_resource: "", mesh_file: { filename: "", data: new Uint8Array() },
  mesh_use_embedded_materials: false, ...fields,
});
const messages = {
  string: { data: "kitchen" },
  image: {
    header: { stamp: { sec: 1700000000, nsec: 123456789 }, frame_id: "camera" },
    height: 2, width: 3, encoding: "rgb8", is_bigendian: 0, step: 9, data: Uint8Array.from({ length: 18 }, (_, i) => 10 * i),
  },
  markers: {
    markers: [
      marker({
        header: { stamp: { sec: 12, nsec: 500000000 }, frame_id: "odom" }, ns: "places", id: 7, type: 4,
        pose: { position: { x: 1.5, y: -2, z: 0.25 }, orientation: { x: 0, y: 0, z: 1, w: 0 } },
        scale: { x: 0.05, y: 0, z: 0 }, color: { r: 1, g: 0.5, b: 0.25, a: 0.75 }, lifetime: { sec: 2, nsec: 1 },
        frame_locked: true, points: [{ x: 1, y: 2, z: 3 }, { x: -1, y: 0.5, z: 1e-3 }],
        colors: [{ r: 1, g: 0, b: 0, a: 1 }, { r: 0, g: 1, b: 0, a: 0.5 }],
      }),
      marker({ ns: "names", id: -1, type: 9, text: "kitchen", scale: { x: 1, y: 1, z: 0.3 } }),
      marker({ action: 3 }),
    ],
  },
};

for (const [name, definition] of Object.entries(definitions)) {
  const parsed = parse(definition, { ros2: true });
  const bytes = new MessageWriter(parsed).writeMessage(messages[name]);
  new MessageReader(parsed, { timeType: "sec,nsec" }).readMessage(bytes);
  fs.writeFileSync(path.join(folder, name), bytes);
}
