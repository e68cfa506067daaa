// JPEG files that are decoded at a fraction of their size: who sees them so, and what identity that has.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "estancia/files/image_file.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/ensemble.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "support/model_support.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using testing::StartsWith;

LabelerOptions reduced() {
  LabelerOptions options;
  options.reducedImages = true;
  return options;
}

/// A small network of 8×8 pixels, and JPEG files of 64×48: 10 pixels (8 / 0.875) or more are 16×12.
class ReducedImages : public testing::Test {
 protected:
  void SetUp() override {
    test::writeSmallModel(scratch_ / "small");
    std::filesystem::create_directory(photos());
    for (int i = 0; i < 3; ++i) {
      cv::Mat image(48, 64, CV_8UC3);
      cv::RNG(static_cast<std::uint64_t>(i) + 1).fill(image, cv::RNG::UNIFORM, 0, 255);
      cv::imwrite((photos() / (std::to_string(i) + ".jpg")).string(), image);
    }
    cv::imwrite((photos() / "9.png").string(), cv::Mat(48, 64, CV_8UC3, cv::Scalar(50, 100, 150)));
  }
  std::filesystem::path photos() const { return scratch_ / "photos"; }
  std::string model() const { return (scratch_ / "small").string(); }

  test::ScratchFolder scratch_;
};

std::vector<LabeledFrame> all(const Sequence& sequence, Labeler& labeler) {
  std::vector<LabeledFrame> frames;
  LabelStream stream(sequence, labeler);
  while (auto frame = stream.next()) frames.push_back(std::move(*frame));
  return frames;
}

TEST_F(ReducedImages, AreWhatTheNetworkSees) {
  const auto sequence = openSequence(photos());
  const auto labeler = loadModel(model(), reduced());
  EXPECT_EQ(labeler->imageSide(), 9);
  const auto frames = all(*sequence, *labeler);
  ASSERT_EQ(frames.size(), 4U);
  for (std::size_t i = 0; i < 3; ++i) {
    const cv::Mat small = readReducedImage(photos() / sequence->frame(i).name, 9);
    ASSERT_EQ(small.size(), cv::Size(16, 12));
    EXPECT_EQ(frames[i].descriptor, labeler->label(small));
    EXPECT_NE(frames[i].descriptor, labeler->label(sequence->image(i)));
    EXPECT_TRUE(frames[i].image.empty());
  }
  EXPECT_EQ(frames[3].descriptor, labeler->label(sequence->image(3)));  // PNG
}

TEST_F(ReducedImages, MakeAnotherIdentity) {
  const auto whole = loadModel(model()), small = loadModel(model(), reduced());
  EXPECT_EQ(whole->imageSide(), 0);
  EXPECT_THAT(small->identity(), StartsWith("small reduced-"));
  EXPECT_NE(small->identity(), whole->identity());
  EXPECT_NE(small->cacheKey(), whole->cacheKey());
  LabelerOptions later = reduced();
  later.onDemand = true;
  EXPECT_EQ(loadModel(model(), later)->identity(), small->identity());
}

}  // namespace
}  // namespace estancia
