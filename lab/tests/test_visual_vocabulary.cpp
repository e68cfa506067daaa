// Visual words of made-up features beside slow references, and local features of made-up images.
// SPDX-License-Identifier: Apache-2.0
#include "features/visual_vocabulary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "features/local_features.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using testing::Each;
using testing::FloatEq;

cv::Mat noise(int rows, int columns, std::uint64_t seed) {
  cv::Mat values(rows, columns, CV_32F);
  cv::RNG(seed).fill(values, cv::RNG::UNIFORM, 0, 1);
  return values;
}

std::vector<cv::Mat> madeUpImages() {
  std::vector<cv::Mat> images;
  for (std::uint64_t i = 0; i < 12; ++i) images.push_back(noise(20 + static_cast<int>(i), 6, i + 1));
  images.emplace_back(0, 6, CV_32F);  // without features
  return images;
}

VisualVocabulary madeUpWords() {
  return learnVisualVocabulary(madeUpImages(), {7, 1000, 3});
}

/// A gray image full of corners.
cv::Mat corners(std::uint64_t seed) {
  cv::RNG random(seed);
  cv::Mat image(240, 320, CV_8UC3, cv::Scalar::all(90));
  for (int i = 0; i < 80; ++i) {
    // One after the other: compilers evaluate arguments in different orders.
    const int x = random.uniform(0, 300), y = random.uniform(0, 220);
    const int width = random.uniform(5, 40), height = random.uniform(5, 40);
    cv::rectangle(image, {x, y, width + 1, height + 1}, cv::Scalar::all(random.uniform(0, 255)), cv::FILLED);
  }
  return image;
}

double squaredDistance(const cv::Mat& a, const cv::Mat& b) {
  double sum = 0;
  for (int c = 0; c < a.cols; ++c) sum += std::pow(static_cast<double>(a.at<float>(c)) - b.at<float>(c), 2);
  return sum;
}

std::size_t nearestWord(const VisualVocabulary& vocabulary, const cv::Mat& feature) {
  int best = 0;
  for (int w = 1; w < vocabulary.words.rows; ++w)
    if (squaredDistance(feature, vocabulary.words.row(w)) <
        squaredDistance(feature, vocabulary.words.row(best)))
      best = w;
  return static_cast<std::size_t>(best);
}

TEST(VisualVocabulary, WordsAreTheMeansOfTheFeaturesNearestToThem) {
  const VisualVocabulary vocabulary = madeUpWords();
  ASSERT_EQ(vocabulary.words.rows, 7);
  std::map<std::size_t, std::pair<cv::Mat, int>> sums;
  for (const cv::Mat& features : madeUpImages())
    for (int i = 0; i < features.rows; ++i) {
      auto& [sum, count] = sums[nearestWord(vocabulary, features.row(i))];
      if (sum.empty()) sum = cv::Mat::zeros(1, 6, CV_32F);
      sum += features.row(i);
      ++count;
    }
  for (auto& [word, sum] : sums) {  // k-means has converged
    const cv::Mat mean = sum.first / sum.second;
    EXPECT_LT(std::sqrt(squaredDistance(mean, vocabulary.words.row(static_cast<int>(word)))), 0.03);
  }
}

TEST(VisualVocabulary, IsTheSameForAnyNumberOfThreadsAndAnotherForAnotherSeed) {
  const int before = cv::getNumThreads();
  cv::setNumThreads(1);
  const VisualVocabulary one = madeUpWords();
  cv::setNumThreads(4);
  const VisualVocabulary four = madeUpWords();
  cv::setNumThreads(before);
  EXPECT_EQ(cv::norm(one.words, four.words, cv::NORM_INF), 0);
  EXPECT_EQ(one.idf, four.idf);
  EXPECT_GT(cv::norm(one.words, learnVisualVocabulary(madeUpImages(), {7, 1000, 4}).words, cv::NORM_INF), 0);
}

TEST(VisualVocabulary, InverseDocumentFrequenciesCountImages) {
  const auto vocabulary = madeUpWords();
  std::vector<int> with(7);
  for (const cv::Mat& features : madeUpImages()) {
    std::set<std::size_t> words;
    for (int i = 0; i < features.rows; ++i) words.insert(nearestWord(vocabulary, features.row(i)));
    for (const std::size_t word : words) ++with[word];
  }
  for (std::size_t w = 0; w < 7; ++w) EXPECT_NEAR(vocabulary.idf[w], std::log(12.0 / with[w]), 1e-6);
}

TEST(VisualVocabulary, BagsAreAsASlowReferenceCountsThem) {
  VisualVocabulary vocabulary = madeUpWords();
  for (std::size_t w = 0; w < 7; ++w) vocabulary.idf[w] = static_cast<float>(w);
  const cv::Mat features = noise(50, 6, 77);
  std::vector<double> expected(7);
  double sum = 0;
  for (int i = 0; i < features.rows; ++i) {
    const std::size_t word = nearestWord(vocabulary, features.row(i));
    expected[word] += static_cast<double>(word);
    sum += static_cast<double>(word);
  }
  const auto bag = bagOfWords(vocabulary, features);
  ASSERT_EQ(bag.size(), 7U);
  for (std::size_t w = 0; w < 7; ++w) EXPECT_NEAR(bag[w], expected[w] / sum, 1e-6);
  EXPECT_THAT(bagOfWords(vocabulary, cv::Mat(0, 6, CV_32F)), Each(FloatEq(1.0F / 7)));
  vocabulary.idf.assign(7, 0);
  EXPECT_THAT(bagOfWords(vocabulary, features), Each(FloatEq(1.0F / 7)))
      << "words of all images tell nothing";
}

TEST(VisualVocabulary, VladIsAsASlowReferenceSumsItUp) {
  const VisualVocabulary vocabulary = madeUpWords();
  const cv::Mat features = noise(50, 6, 78);
  std::vector<double> expected(std::size_t{7} * 6);
  for (int i = 0; i < features.rows; ++i) {
    const std::size_t word = nearestWord(vocabulary, features.row(i));
    for (std::size_t c = 0; c < 6; ++c)
      expected[word * 6 + c] += static_cast<double>(features.at<float>(i, static_cast<int>(c))) -
                                vocabulary.words.at<float>(static_cast<int>(word), static_cast<int>(c));
  }
  double squares = 0;
  for (double& value : expected) {
    value = std::copysign(std::sqrt(std::abs(value)), value);
    squares += value * value;
  }
  const auto values = vlad(vocabulary, features);
  ASSERT_EQ(values.size(), expected.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(values[i], expected[i] / std::sqrt(squares), 2e-3);
  EXPECT_THAT(vlad(vocabulary, cv::Mat(0, 6, CV_32F)), Each(0));
}

TEST(VisualVocabulary, RefusesTooFewFeaturesAndThoseOfAnotherKind) {
  EXPECT_THAT(
      [] {
        learnVisualVocabulary({noise(6, 6, 1)}, {7, 1000, 1});
      },
      FailsWith(ErrorCode::insufficientData, "6 local features", "7 visual words"));
  EXPECT_THAT([] { learnVisualVocabulary({}, {}); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT(
      [] {
        learnVisualVocabulary({noise(6, 6, 1)}, {0, 1000, 1});
      },
      FailsWith(ErrorCode::insufficientData, "0 visual words"));
  EXPECT_THAT(
      [] {
        learnVisualVocabulary({noise(6, 6, 1), noise(6, 5, 1)}, {2, 1000, 1});
      },
      FailsWith(ErrorCode::mismatch, "6 and 5"));
  EXPECT_THAT([] { bagOfWords(madeUpWords(), noise(6, 5, 1)); }, FailsWith(ErrorCode::mismatch, "5", "6"));
}

class LocalFeatures : public testing::TestWithParam<LocalFeature> {};
INSTANTIATE_TEST_SUITE_P(Both, LocalFeatures, testing::Values(LocalFeature::orb, LocalFeature::sift));

TEST_P(LocalFeatures, AreTheSameForAnyNumberOfThreads) {
  const cv::Mat image = corners(5);
  const int before = cv::getNumThreads();
  cv::setNumThreads(1);
  const cv::Mat one = localFeatures(GetParam(), image);
  cv::setNumThreads(4);
  const cv::Mat four = localFeatures(GetParam(), image);
  cv::setNumThreads(before);
  ASSERT_GT(one.rows, 100);
  EXPECT_LE(one.rows, 500);
  EXPECT_EQ(one.cols, static_cast<int>(dimensionsOf(GetParam())));
  ASSERT_EQ(one.size(), four.size());
  EXPECT_EQ(cv::norm(one, four, cv::NORM_INF), 0);
}

TEST_P(LocalFeatures, OfAnImageWithoutCornersAreNone) {
  const cv::Mat none = localFeatures(GetParam(), cv::Mat(100, 100, CV_8UC3, cv::Scalar::all(7)));
  EXPECT_EQ(none.size(), cv::Size(static_cast<int>(dimensionsOf(GetParam())), 0));
}

TEST_P(LocalFeatures, RefuseOtherImages) {
  EXPECT_THAT([] { localFeatures(GetParam(), cv::Mat()); }, FailsWith(ErrorCode::invalidInput, "BGR"));
  EXPECT_THAT([] { localFeatures(GetParam(), cv::Mat(9, 9, CV_8U, cv::Scalar(0))); },
              FailsWith(ErrorCode::invalidInput, "BGR"));
}

TEST(OrbFeatures, HaveHammingsDistance) {
  const cv::Mat features = localFeatures(LocalFeature::orb, corners(6));
  for (int i = 0; i < features.rows; ++i)
    for (int c = 0; c < features.cols; ++c)
      ASSERT_TRUE(features.at<float>(i, c) == 0 || features.at<float>(i, c) == 1);
}

TEST(SiftFeatures, HaveHellingersDistance) {
  const cv::Mat features = localFeatures(LocalFeature::sift, corners(6));
  for (int i = 0; i < features.rows; ++i) EXPECT_NEAR(features.row(i).dot(features.row(i)), 1, 1e-5);
}

}  // namespace
}  // namespace estancia::experiments
