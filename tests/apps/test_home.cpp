// A furnished home (home_a): the robot knows where it is back, and zones of its map are rooms.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/topology/session.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

/// How far two frames were taken from each other, 1 at the given distance [m] or angle [degrees].
double apart(const Frame& a, const Frame& b, double meters, double degrees) {
  const auto f = a.pose->forward(), g = b.pose->forward();
  const double cosine = std::clamp(f[0] * g[0] + f[1] * g[1] + f[2] * g[2], -1.0, 1.0);
  return std::max(distanceBetween(*a.pose, *b.pose) / meters,
                  std::acos(cosine) * 180 / std::numbers::pi / degrees);
}

struct Returns {
  /// Frames that were taken near one from before the robot went elsewhere; those whose node holds such a one.
  std::size_t frames = 0, found = 0;
  /// Decisions to return, and those to a node without an image within a meter and 45 degrees.
  std::size_t decisions = 0, wrong = 0;
  /// The first of `frames`, and the first that was found; the number of frames where there is none.
  std::size_t first = 0, firstFound = 0;
};

/// `frames` have the true poses, `map` what was mapped of them.
Returns returnsIn(const std::vector<Frame>& frames, const TopologicalMap& map) {
  Returns result;
  result.first = result.firstFound = frames.size();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    bool wasAway = false, isBack = false, isFound = false, isRight = false;
    for (std::size_t j = i; j-- > 0;) {
      const bool same = map.frames[i].node == map.frames[j].node;
      wasAway = wasAway || apart(frames[i], frames[j], 1.4, 60) > 1;
      isRight = isRight || (same && apart(frames[i], frames[j], 1, 45) <= 1);
      if (!wasAway || apart(frames[i], frames[j], 0.7, 30) > 1) continue;
      isBack = true;
      isFound = isFound || same;
    }
    if (map.decisions[i].kind == DecisionKind::revisit) {
      ++result.decisions;
      if (!isRight) ++result.wrong;
    }
    if (!isBack) continue;
    ++result.frames;
    result.first = std::min(result.first, i);
    if (!isFound) continue;
    ++result.found;
    result.firstFound = std::min(result.firstFound, i);
  }
  return result;
}

/// Maps a drive into `file`.
Returns returnsOf(const DescriptorSequence& drive, bool withPoses, const std::string& file) {
  auto session = MappingSession::create(file, drive.vocabulary, drive.model, {}, ExistingMap::replace);
  for (std::size_t i = 0; i < drive.frames.size(); ++i) {
    Frame frame = drive.frames[i];
    if (!withPoses) frame.pose.reset();
    session.add(frame, drive.descriptors.row(i));
  }
  session.finish();
  return returnsIn(drive.frames, session.map());
}

double agreementOfZones(const std::string& map, const std::string& zones) {
  EXPECT_EQ(run({"zones", "find", map, "-o", zones, "--overwrite"}).exitCode, 0);
  return nlohmann::json::parse(run({"evaluate", zones, "--json"}).out)["v_measure"];
}

TEST(FurnishedHome, IsKnownAgain) {
  const auto data = findData("home_a");
  const auto model = findFetched("models/inception-v3/inception-v3.onnx");
  ESTANCIA_NEEDS(data && model, "the rendered home or the default network are not here");
  const ScratchFolder scratch;
  const std::string map = scratch / "home.estancia", zones = scratch / "home.zones";
  double frames = 0, byPoses = 0, byWords = 0;
  for (const std::string drive : {"day", "evening", "slow"}) {
    const std::string file = scratch / (drive + ".labels");
    ASSERT_EQ(run({"label", *data / drive, "-o", file}).exitCode, 0);
    const DescriptorSequence words = readDescriptors(file);
    const Returns alone = returnsOf(words, false, map);
    if (drive == "day") {
      EXPECT_GE(agreementOfZones(map, zones), 0.62);
    }
    const Returns posed = returnsOf(words, true, map);
    if (drive == "day") {
      EXPECT_GE(agreementOfZones(map, zones), 0.75);
    }
    EXPECT_EQ(alone.wrong, 0U) << drive;
    EXPECT_EQ(posed.wrong, 0U) << drive;
    EXPECT_GT(alone.decisions, 0U) << drive;
    EXPECT_GT(posed.decisions, 0U) << drive;
    frames += static_cast<double>(posed.frames);
    byPoses += static_cast<double>(posed.found);
    byWords += static_cast<double>(alone.found);
    if (drive == "slow") {  // a loop of 16 m
      EXPECT_EQ(posed.firstFound, posed.first);
      EXPECT_LE(alone.firstFound, alone.first + 2) << "12 cm later";
    }
  }
  EXPECT_GE(byPoses / frames, 0.9);
  EXPECT_GE(byWords / frames, 0.75);
}

}  // namespace
}  // namespace estancia::test
