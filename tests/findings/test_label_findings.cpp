// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/label_findings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/errors.hpp"

namespace estancia {
namespace {

template <class Section>
const Section& only(const Findings& findings) {
  for (const auto& section : findings.sections)
    if (const auto* found = std::get_if<Section>(&section)) return *found;
  throw Error(ErrorCode::insufficientData, "no such section");
}

DescriptorSequence recordingOf(const std::vector<std::vector<float>>& rows) {
  DescriptorSequence recording{
      Vocabulary({"desk", "mug, cup", "sofa", "bed"}), "model-1", {}, DescriptorMatrix(4)};
  for (const auto& row : rows) {
    recording.frames.push_back({"frame" + std::to_string(recording.frames.size()), {}, {}, ""});
    recording.descriptors.append(row);
  }
  return recording;
}

TEST(LabelFindings, CountTheImagesThatHaveALabel) {
  const DescriptorSequence recording =
      recordingOf({{0.6F, 0.4F, 0, 0}, {0.5F, 0.3F, 0.2F, 0}, {0.7F, 0.2F, 0.1F, 0}});
  const Findings findings = labelFindings(recording, {}, {.labelsPerImage = 2});
  EXPECT_THAT(findings.summary, testing::StartsWith("2 of 4 labels occur; the 1 most frequent"));
  const auto& table = only<ResultTable>(findings);
  ASSERT_EQ(table.rows.size(), 2U) << "sofa is the third of every image, and nobody has a bed";
  EXPECT_EQ(table.rows[0].name, "desk");
  EXPECT_EQ(table.rows[1].name, "mug");
  EXPECT_EQ(*table.rows[0].values[0], 3);
  EXPECT_NEAR(*table.rows[1].values[2], 0.3, 1e-6);
  const auto& curve = only<LineChart>(findings);
  EXPECT_THAT(curve.lines[0].y, testing::ElementsAre(testing::DoubleEq(0.5), testing::DoubleEq(1)));
  EXPECT_THAT(only<WordClouds>(findings).clouds[0].words, testing::SizeIs(2));
  EXPECT_FALSE(std::ranges::any_of(
      findings.sections, [](const auto& section) { return std::holds_alternative<Images>(section); }));
}

TEST(LabelFindings, ShowTheImagesThatShowALabelBest) {
  const DescriptorSequence recording =
      recordingOf({{0.1F, 0, 0, 0}, {0.9F, 0, 0, 0}, {0.5F, 0, 0, 0}, {0.2F, 0, 0, 0}});
  const ImageOfFrame image = [](std::size_t frame) {
    return frame == 2 ? std::vector<unsigned char>() : std::vector<unsigned char>{1};
  };
  const Findings findings = labelFindings(recording, image);
  const auto& shown = only<Images>(findings).images;
  ASSERT_EQ(shown.size(), 2U) << "frame2 has no image";
  EXPECT_EQ(shown[0].caption, "desk 0.90, frame1");
  EXPECT_EQ(shown[1].caption, "desk 0.20, frame3");
}

TEST(LabelFindings, OfNothingAreRefused) {
  EXPECT_THAT(
      [] {
        labelFindings(recordingOf({{0, 0, 0, 0}}));
      },
      test::FailsWith(ErrorCode::insufficientData));
}

}  // namespace
}  // namespace estancia
