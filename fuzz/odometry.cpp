// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/bytes.hpp"
#include "estancia/odometry/frame_view.hpp"
#include "estancia/odometry/keyframe_graph.hpp"
#include "estancia/odometry/tracker.hpp"
#include "fuzz/fuzz_target.hpp"
#include "support/room.hpp"

namespace estancia::fuzz {

static ByteReader readerOf(std::string_view bytes) {
  return {bytes, "input", "map again"};
}

FUZZ_TARGET(odometry, features) {
  ByteReader in = readerOf(bytes);
  odometry::readFeatures(in);
}

FUZZ_TARGET(odometry, packed_image) {
  ByteReader in = readerOf(bytes);
  odometry::unpacked(odometry::readPackedImage(in));
}

FUZZ_TARGET(odometry, camera) {
  ByteReader in = readerOf(bytes);
  odometry::readCamera(in);
}

/// The head of a tracker's state, a keyframe and a frame.
FUZZ_TARGET(odometry, tracker) {
  const auto texts = parts(bytes, 3);
  RgbdTracker::State state{std::string(texts[0]), {}, {}};
  if (!texts[1].empty()) state.keyframes.push_back({0, std::string(texts[1])});
  if (!texts[2].empty()) state.frames.push_back({0, std::string(texts[2])});
  CameraIntrinsics camera;
  camera.fx = camera.fy = 50, camera.cx = 31.5, camera.cy = 23.5, camera.width = 64, camera.height = 48;
  RgbdTracker::restore(camera, {}, {}, state);
}

/// The rows of a tracker that went through a room, bytes of which are replaced: parts, each of them a row's
/// number and withBytesReplaced(). It goes on with the next frame.
FUZZ_TARGET(odometry, tracker_state) {
  static const RgbdOptions options{.maxWidth = 48, .keyframeOverlap = 0.9, .threads = 1};
  static const test::Drive drive(test::turnAround(40, -34));
  static const RgbdTracker::State whole = [] {
    RgbdTracker tracker(*drive.intrinsics(), options);
    for (std::size_t i = 0; i + 1 < drive.size(); ++i) tracker.add(drive.image(i), drive.depth(i));
    return tracker.save();
  }();
  static const cv::Mat image = drive.image(drive.size() - 1), depth = drive.depth(drive.size() - 1);
  RgbdTracker::State state = whole;
  std::vector<std::string*> rows{&state.head};
  for (RgbdTracker::Row& row : state.keyframes) rows.push_back(&row.bytes);
  for (RgbdTracker::Row& row : state.frames) rows.push_back(&row.bytes);
  for (const std::string_view how : parts(bytes, 4)) {
    if (how.empty()) continue;
    std::string& row = *rows[static_cast<unsigned char>(how.front()) % rows.size()];
    row = withBytesReplaced(row, how.substr(1));
  }
  RgbdTracker tracker = RgbdTracker::restore(*drive.intrinsics(), options, {}, state);
  tracker.add(image, depth);
  tracker.trajectory();
}

}  // namespace estancia::fuzz
