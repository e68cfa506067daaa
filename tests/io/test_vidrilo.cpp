// ViDRILO on made-up folders: the set itself is to be had no longer.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estancia/io/sequence.hpp"
#include "io/images.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::Mentions;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// A wall at `z` meters before a camera of 16 × 12 pixels, fx 20, fy 22, cx 7, cy 5.5, with a hole at (3, 2).
std::string cloudAt(float z) {
  std::string bytes = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 16\nHEIGHT 12\nDATA binary\n";
  for (int v = 0; v < 12; ++v)
    for (int u = 0; u < 16; ++u) {
      const bool hole = u == 3 && v == 2;
      const float depth = hole ? std::nanf("") : z + 0.01F * static_cast<float>(u);
      const float point[3] = {depth * static_cast<float>(u - 7) / 20,
                              depth * (static_cast<float>(v) - 5.5F) / 22, depth};
      const auto* begin = reinterpret_cast<const char*>(point);
      bytes.append(begin, begin + sizeof point);
    }
  return bytes;
}

class Vidrilo : public ::testing::Test {
 protected:
  void images(const std::string& pattern, const std::vector<int>& numbers) {
    for (const int n : numbers)
      test::writeFile(folder_ / fmt::format(fmt::runtime(pattern), n),
                      test::encoded(".png", test::plain(16, 12, {1, 2, n * 1.0})));
  }
  void clouds(const std::string& pattern, const std::vector<int>& numbers) {
    for (const int n : numbers)
      test::writeFile(folder_ / fmt::format(fmt::runtime(pattern), n), cloudAt(static_cast<float>(n)));
  }
  void asPublished() {
    images("Visual/sequence1visual{}.png", {1, 2, 10});
    clouds("Depth/sequence1depth{}.pcd", {1, 2, 10});
  }
  std::unique_ptr<Sequence> open(const std::string& type = "auto") {
    SequenceOptions options;
    options.type = type;
    return openSequence(folder_.path(), options);
  }
  std::vector<std::string> rooms() {
    const auto sequence = open();
    std::vector<std::string> all;
    for (std::size_t i = 0; i < sequence->size(); ++i) all.push_back(sequence->frame(i).room);
    return all;
  }
  void annotate(const std::string& text, const std::string& name = "annotations.txt") {
    test::writeFile(folder_ / name, text);
  }
  test::ScratchFolder folder_;
};

TEST_F(Vidrilo, PairsImagesAndCloudsByNumber) {
  asPublished();
  const auto sequence = open();
  ASSERT_EQ(sequence->size(), 3U);
  EXPECT_EQ(sequence->frame(2).name, "sequence1visual10.png");
  EXPECT_EQ(sequence->image(2).at<cv::Vec3b>(0, 0)[2], 10);
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  ASSERT_TRUE(sequence->hasDepth());
  const cv::Mat depth = sequence->depth(2);
  ASSERT_EQ(depth.size(), cv::Size(16, 12));
  EXPECT_FLOAT_EQ(depth.at<float>(5, 4), 10.04F);
  EXPECT_EQ(depth.at<float>(2, 3), 0);
}

TEST_F(Vidrilo, FindsTheCameraInTheClouds) {
  asPublished();
  const auto camera = open()->intrinsics();
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->width, 16);
  EXPECT_NEAR(camera->fx, 20, 1e-3);
  EXPECT_NEAR(camera->fy, 22, 1e-3);
  EXPECT_NEAR(camera->cx, 7, 1e-3);
  EXPECT_NEAR(camera->cy, 5.5, 1e-3);
}

TEST_F(Vidrilo, ReadsAnnotationsInSeveralForms) {
  asPublished();
  EXPECT_THAT(rooms(), ElementsAre("", "", ""));
  annotate("Corridor 0 1\nToilet 1 0\nElevatorArea 0 0\n");
  EXPECT_THAT(rooms(), ElementsAre("Corridor", "Toilet", "ElevatorArea")) << "in the order of the images";
  annotate("10;Elevator Area;0;1\n1;\"Corridor\";1;1\n2;Toilet;0;0\n");
  EXPECT_THAT(rooms(), ElementsAre("Corridor", "Toilet", "Elevator Area")) << "by number";
  annotate(
      "# of sequence 1\nsequence1visual2.png sequence1depth2.pcd 5 1\nsequence1visual1.png "
      "sequence1depth1.pcd 7 0\n");
  EXPECT_THAT(rooms(), ElementsAre("7", "5", "")) << "by file; categories may be numbers";
  annotate("x,y,Category,frame\n0.5,1,Corridor,1\n0.6,1,Toilet,2\n0.7,2,Hall,99\n");
  EXPECT_THAT(rooms(), ElementsAre("Corridor", "Toilet", "")) << "by a header";
  annotate("image,room\nsequence1visual1.png,Warehouse\n", "rooms.csv");
  EXPECT_THAT(rooms(), ElementsAre("Warehouse", "Toilet", "")) << "rooms.csv has the last word";
}

TEST_F(Vidrilo, SaysWhatIsMissingOrDouble) {
  images("Visual/{}.png", {1, 2});
  EXPECT_THAT([&] { open("vidrilo"); }, FailsWith(ErrorCode::unsupportedFile));
  clouds("Depth/{}.pcd", {3});
  EXPECT_THAT([&] { open("vidrilo"); }, FailsWith(ErrorCode::mismatch));
  clouds("Depth/other{}.pcd", {3});
  EXPECT_THAT([&] { open("vidrilo"); }, FailsWith(ErrorCode::malformedFile));
}

TEST_F(Vidrilo, ADamagedCloudSpoilsItsOwnFrameOnly) {
  asPublished();
  test::writeFile(folder_ / "Depth/sequence1depth1.pcd", cloudAt(1).substr(0, 500));
  const auto sequence = open();
  EXPECT_TRUE(sequence->intrinsics());
  EXPECT_THAT([&] { sequence->depth(0); }, FailsWith(ErrorCode::truncatedFile));
  EXPECT_FALSE(sequence->depth(1).empty());
}

}  // namespace
}  // namespace estancia
