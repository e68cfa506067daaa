// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/accuracy.hpp"

#include <gtest/gtest.h>

namespace estancia {
namespace {

/// Frames 0 … 4 at 0, 1, 2, 3, 4 m, looking along x; frame 5 at 0 m looks back.
TopologicalMap corridorMap() {
  TopologicalMap map{.vocabulary = Vocabulary({"x"})};
  map.nodes.push_back({});
  for (int i = 0; i < 6; ++i) {
    MappedFrame frame;
    frame.pose = i < 5 ? Pose::planar(i, 0, 0) : Pose::planar(0, 0, 3.1);
    map.frames.push_back(frame);
  }
  return map;
}

Frame at(double x, double heading) {
  Frame frame;
  frame.pose = Pose::planar(x, 0, heading);
  return frame;
}

Localization nearest(std::size_t image, std::size_t believed) {
  Localization answer;
  answer.nearestImage = image;
  answer.beliefImage = believed;
  return answer;
}

LocalizationAccuracy measured(const std::vector<Frame>& frames, const std::vector<Localization>& answers,
                              const AdmissibleImages& admissible = {}) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < frames.size(); ++i) numbers.push_back(i);
  return measureLocalization(corridorMap(), frames, numbers, answers, admissible,
                             {.nearDistance = 0.7, .nearAngle = 30});
}

TEST(LocalizationAccuracy, RecallCountsTheFramesOfWhichTheMapHasTheView) {
  const auto accuracy = measured({at(1.2, 0.4), at(0.3, 3.1), at(2.6, 0), at(2, 1.5), at(9, 0)},
                                 {nearest(1, 2), nearest(0, 5), nearest(3, 2), nearest(2, 2), nearest(4, 4)});
  EXPECT_EQ(accuracy.frames, 5U);
  EXPECT_DOUBLE_EQ(accuracy.nearestImage.recall.value(), 2.0 / 3);  // the last two have no such view
  EXPECT_DOUBLE_EQ(accuracy.belief.recall.value(), 2.0 / 3);
}

TEST(LocalizationAccuracy, ATableOfAdmissibleImagesGoesBeforePoses) {
  const auto accuracy = measured({at(1, 0), at(2, 0)}, {nearest(1, 4), nearest(3, 4)}, {{4}, {3, 4}});
  EXPECT_DOUBLE_EQ(accuracy.nearestImage.recall.value(), 0.5);
  EXPECT_DOUBLE_EQ(accuracy.belief.recall.value(), 1);
  EXPECT_FALSE(measured({Frame(), Frame()}, {nearest(0, 0), nearest(1, 1)}).nearestImage.recall)
      << "neither poses nor a table";
}

TEST(LocalizationAccuracy, AZoneIsInTheRoomOfMostOfItsFrames) {
  TopologicalMap map = corridorMap();
  for (std::size_t i = 0; i < 6; ++i) map.frames[i].room = i < 4 ? "hall" : "bath";
  const std::vector<int> zoneOf{0, 0, 0, 1, 1, 1};
  std::vector<Frame> frames(4);
  std::vector<Localization> answers(4);
  const std::pair<const char*, int> asked[] = {{"hall", 0}, {"bath", 1}, {"bath", 0}, {"", 1}};
  for (std::size_t i = 0; i < 4; ++i) {
    frames[i].room = asked[i].first;
    answers[i].beliefZone = asked[i].second;
  }
  const auto accuracy = measureLocalization(map, frames, {0, 1, 2, 3}, answers, {}, {}, zoneOf);
  EXPECT_DOUBLE_EQ(accuracy.beliefZoneRoom.value(), 2.0 / 3);
  EXPECT_FALSE(
      measureLocalization(map, frames, {0, 1, 2, 3}, std::vector<Localization>(4), {}, {}).beliefZoneRoom);
}

TEST(LocalizationSummary, NeedsNoTruth) {
  std::vector<Localization> answers(5);
  const int nodes[] = {3, 1, 3, 3, 1};
  const double confidences[] = {0.9, 0.25, 0.5, 0.75, 0.125};
  for (std::size_t i = 0; i < 5; ++i) {
    answers[i].beliefNode = nodes[i];
    answers[i].confidence = confidences[i];
  }
  LocalizationSummary summary = summarizeLocalization(answers);
  EXPECT_EQ(summary.medianConfidence, 0.5);
  EXPECT_FALSE(summary.unmapped) << "the map has no poses";
  ASSERT_EQ(summary.places.size(), 2U);
  EXPECT_EQ(summary.places[0].node, 3);
  EXPECT_EQ(summary.places[0].frames, 3U);
  EXPECT_EQ(summary.places[0].medianConfidence, 0.75);
  for (std::size_t i = 0; i < 5; ++i) answers[i].unmapped = i < 2 ? 0.9 : 0.1;
  EXPECT_EQ(summarizeLocalization(answers).unmapped, 0.4);
  EXPECT_FALSE(summarizeLocalization({}).medianConfidence);
}

}  // namespace
}  // namespace estancia
