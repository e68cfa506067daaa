// Networks that are opened when first asked.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>

#include "estancia/label/model.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;

class OnDemand : public testing::TestWithParam<std::string> {
 protected:
  OnDemand() { test::writeSmallModel(scratch_.path()); }
  std::unique_ptr<Labeler> open(bool onDemand) {
    return loadModel(scratch_.path().string(), {GetParam(), 1, onDemand});
  }
  test::ScratchFolder scratch_;
  const cv::Mat image_ = cv::Mat(20, 20, CV_8UC3, cv::Scalar(10, 90, 200));
};

TEST_P(OnDemand, AnswersAsTheNetworkItself) {
  const auto now = open(false), later = open(true);
  EXPECT_EQ(later->identity(), now->identity());
  EXPECT_EQ(later->cacheKey(), now->cacheKey()) << "they share a cache";
  EXPECT_EQ(later->vocabulary(), now->vocabulary());
  EXPECT_EQ(later->label(image_), now->label(image_));
  const std::vector<Prepared> two{later->prepare(image_), later->prepare(cv::Mat(image_ / 2))};
  const auto answers = later->inferBatch(two);
  ASSERT_EQ(answers.size(), 2U);
  EXPECT_EQ(answers[1].descriptor, now->label(cv::Mat(image_ / 2)));
  EXPECT_EQ(later->batchSize(), now->batchSize());
}

TEST_P(OnDemand, TellsAtTheFirstFrameWhatIsWrongWithTheNetwork) {
  test::writeFile(scratch_ / "small.onnx", "no network");
  EXPECT_THAT([&] { open(false); }, FailsWith(ErrorCode::malformedFile));
  const auto later = open(true);
  EXPECT_THAT([&] { later->label(image_); }, FailsWith(ErrorCode::malformedFile));
}

TEST_P(OnDemand, NoticesThatItsFilesHaveChanged) {
  const auto later = open(true);
  test::writeSmallModel(scratch_.path(), "crop = 0.5");
  test::writeFile(scratch_ / "labels.txt", "a\nb\nc\nd\n");
  EXPECT_THAT([&] { later->label(image_); }, FailsWith(ErrorCode::corruptFile));
}

INSTANTIATE_TEST_SUITE_P(Engines, OnDemand, testing::ValuesIn(engines()));

}  // namespace
}  // namespace estancia
