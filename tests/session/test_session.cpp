// Live mapping: images become a map file while they come, which can be asked and localized in meanwhile.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/session/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "estancia/labelers/labeler.hpp"
#include "estancia/localization/localizer.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/query/ask.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

/// Labels an image by the shares of its colors.
class ColorLabeler : public Labeler {
 public:
  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return identity_; }
  bool discovers() const override { return discovers_; }
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override { return {bgr, frame, {}}; }
  LexicalDescriptor infer(const Prepared& prepared) override {
    const cv::Scalar mean = cv::mean(prepared.input);
    const double sum = mean[0] + mean[1] + mean[2];
    return {static_cast<float>(mean[0] / sum), static_cast<float>(mean[1] / sum),
            static_cast<float>(mean[2] / sum)};
  }

  Vocabulary vocabulary_{{"sea", "lawn", "brick"}};
  std::string identity_ = "colors";
  bool discovers_ = false;
};

cv::Mat imageOf(double blue, double green, double red) {
  return cv::Mat(48, 64, CV_8UC3, cv::Scalar(blue, green, red));
}
const cv::Mat sea = imageOf(220, 20, 15), lawn = imageOf(25, 210, 20), brick = imageOf(20, 30, 200);

MapperOptions byHand() {
  MapperOptions options;
  options.distance = "hellinger";
  options.tauJoin = options.tauRevisit = 0.3;
  return options;
}

class LiveMapping : public testing::Test {
 protected:
  test::ScratchFolder folder_;
  const std::filesystem::path path_ = folder_ / "home.estancia";
  ColorLabeler labeler_;
};

TEST_F(LiveMapping, TellsThePlaceOfEachImage) {
  MappingSession map(path_, labeler_, byHand());
  EXPECT_EQ(map.add(sea, 1.5, Pose::planar(1, 2, 0)), 0);
  EXPECT_EQ(map.add(sea), 0);
  EXPECT_EQ(map.add(lawn), 1);
  EXPECT_EQ(map.add(sea), 0);
  EXPECT_EQ(map.frames(), 4U);
}

TEST_F(LiveMapping, IsOnDiskWhenItEnds) {
  {
    MappingSession map(path_, labeler_, byHand());
    map.add(sea, 1.5, Pose::planar(1, 2, 0));
    map.add(lawn);
  }
  const TopologicalMap map = readMap(path_);
  ASSERT_EQ(map.frames.size(), 2U);
  EXPECT_EQ(map.frames[1].name, "frame 000001");
  EXPECT_EQ(map.frames[0].timestamp, 1.5);
  EXPECT_EQ(map.frames[0].pose.value().y, 2);
  EXPECT_EQ(map.nodes.size(), 2U);
  const MapStore store = MapStore::open(path_, MapStore::Access::read);
  EXPECT_THAT(store.imageFrames(), ElementsAre(0U, 1U));
  EXPECT_FALSE(store.image(1).empty()) << "a thumbnail for reports";
  EXPECT_EQ(readMapDescriptors(path_).descriptors.row(1)[1], labeler_.label(lawn)[1]);
}

TEST_F(LiveMapping, TakesPosesThatAreKnownBetterLater) {
  {
    MappingSession map(path_, labeler_, byHand());
    map.add(sea, 0, Pose::planar(1, 2, 0));
    map.add(lawn, 1);
    map.add(brick, 2, Pose::planar(9, 9, 0));
    map.finish();
    map.correct({{0, Pose::planar(3, 4, 0)}, {1, Pose::planar(5, 6, 0)}, {2, std::nullopt}});
    EXPECT_THAT([&] { map.correct({{3, std::nullopt}}); }, FailsWith(ErrorCode::unknownName));
  }
  const TopologicalMap map = readMap(path_);
  EXPECT_EQ(map.frames[0].pose.value().y, 4);
  EXPECT_EQ(map.frames[1].pose.value().x, 5);
  EXPECT_FALSE(map.frames[2].pose);
}

TEST_F(LiveMapping, KnowsPlacesByPosesThatWereMoved) {
  for (const bool moved : {false, true}) {
    test::ScratchFolder folder;
    MapperOptions options = byHand();
    options.tauRevisit = 0.1;
    options.views = 40;
    MappingSession map(folder / "home.estancia", labeler_, options);
    map.add(sea, 0, Pose::planar(50, 0, 0));  // drift
    map.add(lawn, 1, Pose::planar(20, 0, 0));
    if (moved) map.correct({{0, Pose::planar(0, 0, 0)}});
    map.add(sea, 2, Pose::planar(0, 0, 0));
    EXPECT_EQ(map.mapper().nodes(), moved ? 2U : 3U);
  }
}

TEST_F(LiveMapping, CanBeAskedAndLocalizedInMeanwhile) {
  MappingSession map(path_, labeler_, byHand());
  EXPECT_TRUE(map.map().nodes.empty());
  for (const cv::Mat& image : {sea, sea, lawn, lawn, brick, brick}) map.add(image);
  EXPECT_EQ(ask(map.map(), "lawn").places.front().node, 1);
  Localizer localizer(map);
  EXPECT_EQ(localizer.add(labeler_.label(brick)).front().node, 2);
  EXPECT_EQ(map.add(sea), 0) << "and it goes on";
  EXPECT_EQ(localizer.map().frames.size(), 6U) << "as of then";
  map.finish();
  Localizer ofFile(path_);
  EXPECT_EQ(ofFile.map().frames.size(), 7U);
  EXPECT_EQ(ofFile.add(labeler_.label(lawn)).front().node, 1);
}

TEST_F(LiveMapping, GoesOnWithAMapOfThatName) {
  const std::filesystem::path unbroken = folder_ / "unbroken.estancia";
  MappingSession whole(unbroken, labeler_);
  for (int run = 0; run < 2; ++run) {
    MappingSession part(path_, labeler_);
    EXPECT_EQ(part.frames(), whole.frames());
    if (run > 0) whole.beginDrive();
    for (int i = 0; i < 30; ++i) {
      const cv::Mat image = imageOf(i % 7 < 3 ? 200 : 20 + i, 40, i % 7 < 3 ? 20 : 150 + run);
      whole.add(image);
      part.add(image);
    }
  }
  whole.finish();
  const TopologicalMap expected = whole.map(), map = readMap(path_);
  ASSERT_EQ(map.frames.size(), 60U);
  for (std::size_t i = 0; i < map.frames.size(); ++i) EXPECT_EQ(map.frames[i].node, expected.frames[i].node);
  EXPECT_EQ(map.transitions.size(), expected.transitions.size());
}

TEST_F(LiveMapping, LeavesNothingWithoutImagesNorWhenAnErrorEndsIt) {
  { const MappingSession map(path_, labeler_); }
  EXPECT_FALSE(std::filesystem::exists(path_));
  EXPECT_ANY_THROW({
    MappingSession map(path_, labeler_);
    map.add(sea);
    throw std::runtime_error("the camera is gone");
  });
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(LiveMapping, RefusesAnotherModelOtherSettingsAndUnknownWords) {
  MappingSession(path_, labeler_, byHand()).add(sea);
  EXPECT_THAT([&] { MappingSession(path_, labeler_, MapperOptions{}); }, FailsWith(ErrorCode::mismatch));
  ColorLabeler other;
  other.identity_ = "other colors";
  EXPECT_THAT([&] { MappingSession(path_, other); }, FailsWith(ErrorCode::mismatch));
  other = ColorLabeler();
  other.vocabulary_ = Vocabulary({"a", "b", "c"});
  EXPECT_THAT([&] { MappingSession(path_, other); }, FailsWith(ErrorCode::mismatch));
  other.discovers_ = true;
  EXPECT_THAT([&] { MappingSession(path_, other); }, FailsWith(ErrorCode::invalidInput));
  auto ofDescriptors = MappingSession::resume(path_, labeler_.vocabulary(), "colors");
  EXPECT_THAT([&] { ofDescriptors.add(sea); }, FailsWith(ErrorCode::invalidState));
}

TEST_F(LiveMapping, ReplacesAMapOnlyWhenAsked) {
  MappingSession(path_, labeler_, byHand()).add(sea);
  EXPECT_THAT([&] { MappingSession::create(path_, labeler_.vocabulary(), "colors", {}); },
              FailsWith(ErrorCode::fileExists));
  auto map = MappingSession::create(path_, labeler_.vocabulary(), "colors", byHand(), ExistingMap::replace);
  Frame frame;
  frame.name = "first";
  map.add(frame, labeler_.label(lawn));
  map.finish();
  EXPECT_EQ(readMap(path_).frames.front().name, "first");
}

}  // namespace
}  // namespace estancia
