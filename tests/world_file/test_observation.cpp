// Observations: what of a view is a segment, a wall or loose, and what a map file keeps of it.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/observation.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <opencv2/core.hpp>

#include "estancia/objects/object_instance.hpp"

namespace estancia {
namespace {

enum RoomPart : std::uint8_t { floorPart, wallPart, cupboardPart, canePart };

struct SeenRoom {
  cv::Mat depth = cv::Mat(240, 320, CV_32F), part = cv::Mat(240, 320, CV_8U);
  CameraIntrinsics camera{320, 240, 262.5, 262.5, 159.5, 119.5};
};

/// What a level camera 0.8 m above the floor sees: a wall at 3 m, a cupboard before it, and a cane, too thin
/// for a segment.
SeenRoom roomWithACupboard() {
  SeenRoom room;
  for (int v = 0; v < room.depth.rows; ++v)
    for (int u = 0; u < room.depth.cols; ++u) {
      const double x = room.camera.slopeX(u), y = room.camera.slopeY(v);
      double z = 3;
      RoomPart part = wallPart;
      const auto meet = [&](double distance, RoomPart other, bool hit) {
        if (!hit || distance >= z) return;
        z = distance;
        part = other;
      };
      const auto between = [](double value, double low, double high) {
        return low <= value && value <= high;
      };
      meet(0.8 / y, floorPart, y > 0);
      meet(2.45, cupboardPart, between(2.45 * x, -1.2, -0.4) && between(2.45 * y, -0.3, 0.8));
      meet(1.5, canePart, between(1.5 * x, 0.5, 0.52) && between(1.5 * y, 0.1, 0.8));
      room.depth.at<float>(v, u) = static_cast<float>(z);
      room.part.at<std::uint8_t>(v, u) = part;
    }
  return room;
}

/// Share of a part's pixels for which the predicate holds.
template <class Predicate>
double shareOf(const Observation& seen, const SeenRoom& room, RoomPart part, const Predicate& predicate) {
  double all = 0, right = 0;
  for (int v = 0; v < room.part.rows; ++v)
    for (int u = 0; u < room.part.cols; ++u) {
      if (room.part.at<std::uint8_t>(v, u) != part) continue;
      ++all;
      right += predicate(seen.segments.at<std::uint8_t>(v, u)) ? 1 : 0;
    }
  return right / all;
}

TEST(Observation, TellsSegmentsWallsAndLoosePixelsApart) {
  const SeenRoom room = roomWithACupboard();
  Observation seen = observe(room.depth, room.camera);
  findSegments(seen, {}, {});
  // Far away the tolerance of a plane is wide: what is near two of them may be of either.
  EXPECT_GT(shareOf(seen, room, floorPart, [](std::uint8_t p) { return p == 0; }), 0.8);
  EXPECT_GT(shareOf(seen, room, wallPart, [](std::uint8_t p) { return p == wallPixel; }), 0.9);
  EXPECT_GT(shareOf(seen, room, cupboardPart, [](std::uint8_t p) { return inSegment(p); }), 0.9);
  EXPECT_GT(shareOf(seen, room, canePart, [](std::uint8_t p) { return p == loosePixel; }), 0.8);

  const Observation read = observationFromBytes(toBytes(seen));
  EXPECT_EQ(cv::norm(read.segments, seen.segments, cv::NORM_INF), 0);
  ASSERT_EQ(read.info.size(), seen.info.size());
}

}  // namespace
}  // namespace estancia
