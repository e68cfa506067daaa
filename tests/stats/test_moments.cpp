// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/label_prior.hpp"
#include "estancia/stats/moments.hpp"
#include "estancia/stats/trajectory_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/stats/label_scale.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using Values = std::vector<float>;
using test::caught;
using test::FailsWith;

std::vector<Values> randomVectors(std::size_t count, std::size_t labels, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform;
  std::vector<Values> all(count, Values(labels));
  for (auto& v : all)
    for (float& x : v) x = uniform(random);
  return all;
}

/// Two passes in double precision.
void expectMoments(const Moments& moments, const std::vector<Values>& all, const std::vector<double>& weights,
                   double tolerance) {
  for (std::size_t i = 0; i < all[0].size(); ++i) {
    double total = 0, mean = 0, variance = 0;
    for (std::size_t n = 0; n < all.size(); ++n) {
      total += weights[n];
      mean += weights[n] * all[n][i];
    }
    mean /= total;
    for (std::size_t n = 0; n < all.size(); ++n) variance += weights[n] * std::pow(all[n][i] - mean, 2);
    EXPECT_NEAR(moments.mean()[i], mean, tolerance);
    EXPECT_NEAR(moments.variance()[i], variance / total, tolerance);
  }
}

TEST(Moments, WeightsCount) {
  const auto all = randomVectors(20, 5);
  std::vector<double> weights;
  Moments moments(5, true);
  for (std::size_t i = 0; i < all.size(); ++i) {
    weights.push_back(0.1 + 0.05 * static_cast<double>(i));
    moments.add(all[i], weights.back());
  }
  expectMoments(moments, all, weights, 1e-6);
}

TEST(Moments, WeightCanBeTakenBack) {
  const auto all = randomVectors(12, 5);
  std::vector<double> weights(12, 1.0);
  Moments moments(5, true);
  for (const auto& v : all) moments.add(v);
  for (std::size_t i = 9; i < 12; ++i) {
    moments.add(all[i], -0.5);
    weights[i] = 0.5;
  }
  expectMoments(moments, all, weights, 1e-5);
  EXPECT_THAT([&] { moments.add(all[0], -100); }, FailsWith(ErrorCode::invalidState));
}

TEST(Moments, MergedAreThoseOfAllImages) {
  const auto all = randomVectors(30, 5);
  Moments left(5, true), right(5, true);
  for (std::size_t i = 0; i < all.size(); ++i) (i < 11 ? left : right).add(all[i]);
  left.merge(right);
  expectMoments(left, all, std::vector<double>(30, 1.0), 1e-6);
  left.merge(Moments(5, true));  // nothing
  EXPECT_DOUBLE_EQ(left.weight(), 30);
}

TEST(Moments, StayTrueOverAMillionImages) {
  // A place that slowly changes by a hundredth: plain float32 Welford stops moving long before the end.
  constexpr std::size_t images = 1'000'000;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-1e-3F, 1e-3F);
  Moments moments(1, true);
  double sum = 0, squares = 0;
  for (std::size_t n = 0; n < images; ++n) {
    const Values v{0.5F + 0.01F * static_cast<float>(n) / images + uniform(random)};
    moments.add(v);
    sum += v[0] - 0.5;
    squares += (v[0] - 0.5) * (v[0] - 0.5);
  }
  const double mean = sum / images;
  EXPECT_NEAR(moments.mean()[0], 0.5 + mean, 1e-7);
  EXPECT_NEAR(std::sqrt(moments.variance()[0]), std::sqrt(squares / images - mean * mean), 1e-5);
}

TEST(Moments, ComeBackFromBytes) {
  const auto all = randomVectors(7, 5);
  for (const bool spread : {true, false}) {
    Moments moments(5, spread);
    for (const auto& v : all) moments.add(v);
    Moments back = Moments::fromBytes(moments.toBytes(), 5, spread);
    back.add(all[0]);
    moments.add(all[0]);
    EXPECT_EQ(moments.toBytes(), back.toBytes());
    const std::string sound = moments.toBytes();
    for (std::size_t at = 0; at < sound.size(); at += 4) {
      std::string bad = sound;
      bad.replace(at, 4, "\xff\xff\xff\xff");  // in the weight's lower half no damage can be seen
      EXPECT_EQ(caught([&] { Moments::fromBytes(bad, 5, spread); }).code.has_value(), at > 0) << at;
    }
  }
}

NamedLabelPrior builtin(const std::string& name) {
  return parseLabelPrior(test::readFile(std::string(ESTANCIA_SOURCE_DIR) + "/models/priors/" + name), name);
}

/// A prior file of these labels.
std::string fileOf(const std::string& labels) {
  std::string text = "estancia-label-prior 1\n# of a test\nimages 10\ndistances";
  for (int i = 0; i <= 100; ++i) text += " " + std::to_string(0.5 + 0.01 * i);
  return text + "\ndimensions 20\n" + labels;
}

TEST(LabelPrior, IsFoundByTheFirstSynonymsOfLabels) {
  const NamedLabelPrior imagenet = builtin("imagenet.prior");
  ASSERT_EQ(imagenet.labels.size(), 1001U);
  std::vector<std::string> labels = imagenet.labels;
  labels.erase(labels.begin());  // Caffe's list has no background …
  for (std::string& label : labels) label[0] = static_cast<char>(std::toupper(label[0]));
  labels[0] += ", Tinca tinca";  // … and synonyms
  std::ranges::reverse(labels);
  const LabelPrior found = labelPriorOf(Vocabulary(labels));
  ASSERT_EQ(found.center.size(), 1000U);
  EXPECT_EQ(found.center[999], imagenet.prior.center[1]);
  EXPECT_EQ(found.variance[0], imagenet.prior.variance[1000]);
  EXPECT_EQ(found.distances, imagenet.prior.distances);
  EXPECT_NEAR(found.distanceAt(0.03), 0.71, 0.01) << "the third quantile";
  EXPECT_DOUBLE_EQ(found.distanceAt(0.035), (found.distances[3] + found.distances[4]) / 2);
  EXPECT_DOUBLE_EQ(found.distanceAt(1), found.distances[100]);
}

TEST(LabelPrior, OfSeveralModelsAddsUp) {
  const NamedLabelPrior coco = builtin("coco.prior");
  const std::size_t n = coco.labels.size();
  std::vector<std::string> twice = coco.labels;
  twice.insert(twice.end(), coco.labels.begin(), coco.labels.end());
  const LabelPrior both = labelPriorOf(Vocabulary(twice, {{n, 1}, {n, 1}}));
  ASSERT_EQ(both.center.size(), 2 * n);
  EXPECT_EQ(both.center[n + 1], coco.prior.center[1]);
  // The mean of two deviations with a correlation of 0.4 has a variance of (1 + 0.4)/2.
  EXPECT_NEAR(both.dimensions, coco.prior.dimensions / 0.7, 1e-9);
  EXPECT_NEAR(1 - both.distanceAt(0.1), (1 - coco.prior.distanceAt(0.1)) * std::sqrt(0.7), 1e-9);
}

TEST(LabelPrior, GivesWayToTheRun) {
  const NamedLabelPrior file = parseLabelPrior(fileOf("1.00\t0.50\tbed\n-1.00\t2.00\tsofa\n"), "x");
  const Distance distance = getDistance("standardized-clr");
  LabelScale scale(distance, 2, file.prior);
  const std::vector<float> before = scale.standardization().center;
  EXPECT_TRUE(before.empty()) << "no frame yet";
  const std::vector<std::vector<float>> images{{0.9F, 0.1F}, {0.2F, 0.8F}, {0.6F, 0.4F}};
  const auto add = [&](int times) {
    for (int i = 0; i < times; ++i) {
      const auto& p = images[static_cast<std::size_t>(i) % 3];
      std::vector<float> embedded(2);
      embed(distance.embedding, p, embedded);
      scale.add(p, embedded);
    }
  };
  add(1);
  EXPECT_GT(scale.standardization().center[0], 0.9F) << "nearly the prior's";
  add(600);
  EXPECT_NEAR(scale.standardization().center[0], scale.moments().mean()[0], 0.04);
}

TEST(LabelPrior, IsKeptAsBytes) {
  const LabelPrior prior = builtin("coco.prior").prior;
  const std::string bytes = prior.toBytes();
  const LabelPrior back = LabelPrior::fromBytes(bytes, prior.center.size());
  EXPECT_EQ(back.center, prior.center);
  EXPECT_EQ(back.variance, prior.variance);
  EXPECT_EQ(back.distances, prior.distances);
  EXPECT_EQ(back.dimensions, prior.dimensions);
  EXPECT_THAT(caught([&] { LabelPrior::fromBytes(bytes, 3); }), FailsWith(ErrorCode::corruptFile));
  EXPECT_THAT(caught([&] { LabelPrior::fromBytes(bytes + "x", prior.center.size()); }),
              FailsWith(ErrorCode::corruptFile));
  for (LabelPrior bad : {LabelPrior{{1}, {}, prior.distances, 9}, LabelPrior{{1}, {1}, {1}, 9},
                         LabelPrior{{1}, {1}, prior.distances, NAN}})
    EXPECT_THAT(caught([&] { LabelPrior::fromBytes(bad.toBytes(), 1); }), FailsWith(ErrorCode::corruptFile));
  for (std::size_t length = 0; length < bytes.size(); length += 5)
    EXPECT_ANY_THROW(LabelPrior::fromBytes(bytes.substr(0, length), prior.center.size())) << length;
}

TEST(LabelPrior, RefusesOtherFiles) {
  EXPECT_NO_THROW(parseLabelPrior(fileOf("1.00\t0.50\tbed\n"), "x"));
  const auto refused = [](const std::string& text) {
    return caught([&] { parseLabelPrior(text, "x.prior"); });
  };
  for (const std::string& text : {std::string(), fileOf(""), fileOf("1.00\tbed\n"), fileOf("1.00\t-1\tbed\n"),
                                  fileOf("1.00\t1.00\t\n")})
    EXPECT_THAT(refused(text), FailsWith(ErrorCode::malformedFile)) << text;
  EXPECT_THAT(refused("estancia-label-prior 2\n"), FailsWith(ErrorCode::unsupportedFile));
  for (const std::string line : {"images", "distances", "dimensions 20", "distances 0.5", "ons 20"}) {
    std::string text = fileOf("1.00\t0.50\tbed\n");
    EXPECT_THAT(refused(text.replace(text.find(line), line.size(), "# ")),
                FailsWith(ErrorCode::malformedFile));
  }
  std::string text = fileOf("1.00\t0.50\tbed\n");
  EXPECT_THAT(refused(text.replace(text.find("0.5"), 3, "9.5")), FailsWith(ErrorCode::malformedFile));
}

/// A path through space that lies in no plane.
std::vector<Pose> spiral(std::size_t count) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 0.1 * static_cast<double>(i);
    poses.push_back(
        poseOf({cv::Vec3d(0.3 * std::sin(t), t, 0.1), cv::Vec3d(std::cos(t), std::sin(2 * t), 0.2 * t)}));
  }
  return poses;
}

std::vector<Pose> moved(const cv::Affine3d& by, const std::vector<Pose>& poses) {
  std::vector<Pose> result;
  for (const Pose& pose : poses) result.push_back(poseOf(by * rigidOf(pose)));
  return result;
}

TEST(Rigid, PosesBecomeTransformsAndBack) {
  for (const double angle : {0.0, 1e-3, 0.5, 2.0, 3.1, std::numbers::pi}) {
    const cv::Affine3d transform(cv::Vec3d(0.6, -0.48, 0.64) * angle, cv::Vec3d(1, -2, 3));
    const Pose pose = poseOf(transform);
    EXPECT_NEAR(cv::norm(rigidOf(pose).matrix - transform.matrix), 0, 1e-9) << angle;
    EXPECT_NEAR(angleOf(transform), angle, 1e-6);
    EXPECT_NEAR(pose.qx * pose.qx + pose.qy * pose.qy + pose.qz * pose.qz + pose.qw * pose.qw, 1, 1e-12);
  }
  const Pose level = Pose::planar(1, 2, 0.7);
  const cv::Vec3d ahead = rigidOf(level).rotation() * cv::Vec3d(0, 0, 1);
  EXPECT_NEAR(ahead[0], std::cos(0.7), 1e-12);
  EXPECT_NEAR(ahead[1], std::sin(0.7), 1e-12);
}

TEST(AbsoluteTrajectoryError, AnotherMapFrameIsNoError) {
  const auto truth = spiral(50);
  const cv::Affine3d shift(cv::Vec3d(0.4, -1.2, 2.0), cv::Vec3d(10, -3, 0.5));
  const auto error = absoluteTrajectoryError(moved(shift, truth), truth);
  EXPECT_EQ(error.poses, 50U);
  EXPECT_NEAR(error.rmse, 0, 1e-9);
  EXPECT_NEAR(error.max, 0, 1e-9);
  EXPECT_NEAR(cv::norm((rigidOf(error.truthFromEstimate) * shift).matrix - cv::Matx44d::eye()), 0, 1e-6);
}

TEST(AbsoluteTrajectoryError, MeasuresWhatNoMotionExplainsAndTurnsNothingInsideOut) {
  // Four corners of a square; the estimate is the square 10 % larger: every corner is off by a tenth of √½.
  const std::vector<Pose> truth{
      {.x = 0.5, .y = 0.5}, {.x = -0.5, .y = 0.5}, {.x = -0.5, .y = -0.5}, {.x = 0.5, .y = -0.5}};
  std::vector<Pose> larger = truth;
  for (Pose& pose : larger) pose.x *= 1.1, pose.y *= 1.1;
  const auto error = absoluteTrajectoryError(larger, truth);
  const double off = 0.1 * std::sqrt(0.5);
  for (const double found : {error.rmse, error.mean, error.median, error.max}) EXPECT_NEAR(found, off, 1e-12);
  auto mirrored = spiral(50);
  for (Pose& pose : mirrored) pose.x = -pose.x;
  EXPECT_GT(absoluteTrajectoryError(mirrored, spiral(50)).rmse, 0.05);
}

TEST(RelativePoseError, IsTheDriftOfOneStep) {
  // Every step is 1 cm and 1° too much.
  const cv::Affine3d step(cv::Vec3d(0, 0, 0), cv::Vec3d(0.1, 0, 0));
  const cv::Affine3d wrong(cv::Vec3d(0, 0, std::numbers::pi / 180), cv::Vec3d(0.11, 0, 0));
  std::vector<Pose> truth{{}}, estimated{{}};
  for (int i = 0; i < 20; ++i) {
    truth.push_back(poseOf(rigidOf(truth.back()) * step));
    estimated.push_back(poseOf(rigidOf(estimated.back()) * wrong));
  }
  const auto error = relativePoseError(estimated, truth);
  EXPECT_EQ(error.pairs, 20U);
  EXPECT_NEAR(error.translationRmse, 0.01, 1e-6);
  EXPECT_NEAR(error.rotationRmse, 1, 1e-4);
  EXPECT_NEAR(relativePoseError(estimated, truth, 5).rotationRmse, 5, 1e-3);
  EXPECT_EQ(relativePoseError(estimated, truth, 100).pairs, 0U);
  EXPECT_NEAR(pathLength(truth), 2, 1e-9);
}

TEST(TrajectoryErrors, RefuseWhatIsNoPair) {
  const auto error = [](const std::vector<Pose>& estimated, const std::vector<Pose>& truth) {
    return [=] { absoluteTrajectoryError(estimated, truth); };
  };
  EXPECT_THAT(error(spiral(3), spiral(4)), FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(error({}, {}), FailsWith(ErrorCode::mismatch));
  auto broken = spiral(4);
  broken[2].y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(error(broken, spiral(4)), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(error(spiral(4), broken), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { relativePoseError(spiral(4), spiral(4), 0); }, FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia
