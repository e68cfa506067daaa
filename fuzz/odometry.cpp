// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/bytes.hpp"
#include "estancia/odometry/features.hpp"
#include "estancia/odometry/keyframe_graph.hpp"
#include "estancia/odometry/packed_image.hpp"
#include "estancia/odometry/tracker.hpp"
#include "fuzz/fuzz_target.hpp"

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

}  // namespace estancia::fuzz
