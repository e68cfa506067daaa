// The detector as a source of several labels at once, against answers of @tensorflow/tfjs 4.22 (its plain
// JavaScript engine, which runs the whole model.json).
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <opencv2/imgcodecs.hpp>

#include "estancia/labelers/model.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

struct Answer {
  const char* word;
  double score;
};

class CocoSsd : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const auto folder = test::findFetched("models/coco-ssd");
    ESTANCIA_NEEDS(folder, "the detector is missing; run script/bootstrap");
    detector_ = loadModel(folder->string(), {GetParam(), 0});
  }

  /// The best labels of `image` must be these, in this order.
  void expectBest(const cv::Mat& image, const std::vector<Answer>& expected, double tolerance) {
    const auto words = detector_->label(image);
    const auto best = test::best(words, expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(detector_->vocabulary()[best[i]], expected[i].word);
      EXPECT_NEAR(words[best[i]], expected[i].score, tolerance) << expected[i].word;
    }
  }

  std::unique_ptr<Labeler> detector_;
};

INSTANTIATE_TEST_SUITE_P(Engines, CocoSsd, testing::ValuesIn(engines()));

TEST_P(CocoSsd, GivesTheScoresOfAnotherEngine) {
  cv::Mat pattern(300, 300, CV_8UC3);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 300; ++x)
      for (int c = 0; c < 3; ++c)  // red, green, blue
        pattern.at<cv::Vec3b>(y, x)[2 - c] =
            static_cast<unsigned char>((x * (3 + c) + y * (7 - 2 * c) + x * y / 50) % 256);
  ASSERT_EQ(detector_->vocabulary().size(), 80U);
  expectBest(pattern,
             {{"scissors", 0.132692},
              {"book", 0.052545},
              {"bench", 0.050390},
              {"dining table", 0.046319},
              {"knife", 0.043932},
              {"person", 0.026756},
              {"surfboard", 0.022281}},
             1e-4);
}

TEST_P(CocoSsd, TellsWhatIsWhereInAnImage) {
  const auto home = test::findData("home_a");
  ESTANCIA_NEEDS(home, "the data set home_a is missing (ESTANCIA_DATA)");
  const cv::Mat image = cv::imread((*home / "day/rgb/000200.jpg").string());
  ASSERT_EQ(image.size(), cv::Size(320, 240));
  const auto part = [](double x, double y, double right, double bottom) {
    return cv::Rect2d(cv::Point2d(x / 320, y / 240), cv::Point2d(right / 320, bottom / 240));
  };
  // Boxes of the office chair and of the plant in the truth's mask, and of the wall above.
  const auto words =
      detector_->labelRegions(image, std::array{part(43, 77, 156, 240), part(271, 125, 320, 199),
                                                part(200, 10, 300, 70), cv::Rect2d(0, 0, 1, 1)});
  ASSERT_EQ(words.size(), 4U);
  const Vocabulary& labels = detector_->vocabulary();
  EXPECT_EQ(labels[test::best(words[0], 1)[0]], "chair");
  EXPECT_EQ(labels[test::best(words[1], 1)[0]], "potted plant");
  const auto chair = test::best(words[0], 1)[0];
  EXPECT_GT(words[0][chair], 0.5F);
  EXPECT_LT(words[2][chair], 0.1F);
  const auto all = detector_->label(image);
  for (const LexicalDescriptor& region : words)
    for (std::size_t l = 0; l < all.size(); ++l)
      EXPECT_LE(region[l], all[l] + 1e-6F) << "the image's score is the highest of all boxes";
  EXPECT_EQ(detector_->regionLabels().size(), 80U);
  EXPECT_TRUE(detector_->labelRegions(image, {}).empty());
}

}  // namespace
}  // namespace estancia
