// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/growing_neural_gas.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <vector>

#include "estancia/cloud/normals.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/take_interrupt.hpp"
#include "support/clouds.hpp"
#include "support/errors.hpp"
#include "tests/cloud/textbook_neural_gas.hpp"

namespace estancia {
namespace {

using test::cloudOf;
using test::FailsWith;

/// Made-up clouds of every kind a network may meet, by name.
PointCloud made(const std::string& kind, std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> u(-1, 1);
  std::normal_distribution<float> g;
  std::vector<cv::Point3f> points;
  for (std::size_t i = 0; i < count; ++i) {
    cv::Point3f p(u(random), u(random), u(random));
    if (kind == "plane") p.z = 0.25F;
    if (kind == "line") p = {p.x, 2 * p.x, -p.x};
    if (kind == "surface") p.z = 0.3F * std::sin(4 * p.x) + 0.01F * g(random);
    if (kind == "lattice")
      p = {std::round(p.x * 6), std::round(p.y * 6), std::round(p.z * 6)};  // duplicates and ties
    if (kind == "clusters")
      p = p * (i % 3 == 0 ? 1e-4F : 0.1F) + cv::Point3f(static_cast<float>(i % 7), 0, 0);
    if (kind == "uneven") p *= std::pow(std::abs(u(random)), 6.0F);
    if (kind == "drifting" && i % 50 != 0) p *= 0.01F;
    points.push_back(p);
  }
  return cloudOf(std::move(points));
}

/// A texture over the cloud: stripes, a slope, noise.
PointCloud painted(PointCloud cloud, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> noise(-4, 4);
  for (const cv::Point3f& p : cloud.points) {
    const bool stripe = std::sin(20 * p.x) > 0;
    const auto level = [&](double v) { return cv::saturate_cast<uchar>(v + noise(random)); };
    cloud.colors.emplace_back(level(stripe ? 200 : 60), level(90 + 40 * p.y), level(stripe ? 30 : 150));
  }
  return cloud;
}

struct Case {
  const char* kind;
  std::size_t points, neurons, delta;
  std::uint32_t maxAge;
  std::uint64_t seed;
  double colorWeight = 0;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.kind << ", " << c.neurons << " neurons, delta " << c.delta << ", seed " << c.seed << ", color "
       << c.colorWeight;
}

class NeuralGasIsTheTextbooks : public testing::TestWithParam<Case> {};

TEST_P(NeuralGasIsTheTextbooks, BitByBit) {
  const Case c = GetParam();
  const PointCloud cloud = painted(made(c.kind, c.points, static_cast<unsigned>(c.seed) + 5), 1);
  GngOptions options;
  options.colorWeight = c.colorWeight;
  options.neurons = c.neurons;
  options.signalsPerInsertion = c.delta;
  options.maxAge = c.maxAge;
  options.seed = c.seed;
  Progress progress;
  const NeuralGas gas = growNeuralGas(cloud, options, progress);

  const Signals signals(cloud, c.seed, c.colorWeight);
  TextbookNeuralGas textbook(signals, options);
  const bool complete = textbook.grow(progress);
  if (c.kind == std::string("drifting")) {
    EXPECT_GT(textbook.removed(), 0U) << "so that neurons that no longer win are compared, too";
  }
  EXPECT_EQ(gas.stop, complete ? GngStop::neurons : GngStop::stalled);
  ASSERT_EQ(gas.cloud.points.size(), textbook.size());
  EXPECT_EQ(gas.signals, textbook.signalsSeen());
  for (std::size_t i = 0; i < textbook.size(); ++i)
    ASSERT_EQ(gas.cloud.points[i], signals.inCloud(textbook.at(i))) << "neuron " << i;
  const auto edges = textbook.edges();
  ASSERT_EQ(gas.edges.size(), edges.size());
  ASSERT_EQ(gas.ages.size(), edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    ASSERT_EQ(gas.edges[i], edges[i].first) << "edge " << i;
    ASSERT_EQ(gas.ages[i], edges[i].second) << "edge " << i;
  }
  double sum = 0;
  std::vector<cv::Vec4d> colors(textbook.size());
  for (std::size_t k = 0; k < cloud.points.size(); ++k) {
    const auto [nearest, squared] = textbook.nearestTwo(k);
    sum += squared;
    colors[nearest[0]] += cv::Vec4d(cloud.colors[k][0], cloud.colors[k][1], cloud.colors[k][2], 1);
  }
  for (std::size_t i = 0; i < textbook.size(); ++i)
    for (int channel = 0; channel < 3 && colors[i][3] > 0; ++channel)
      ASSERT_NEAR(gas.cloud.colors[i][channel], colors[i][channel] / colors[i][3], 0.51) << "neuron " << i;
  EXPECT_NEAR(gas.quantizationError,
              std::sqrt(sum / static_cast<double>(signals.points().size())) / signals.scale(),
              1e-9 * gas.quantizationError);
}

INSTANTIATE_TEST_SUITE_P(
    Clouds, NeuralGasIsTheTextbooks,
    testing::Values(Case{"surface", 20000, 600, 200, 250, 1}, Case{"surface", 3000, 2500, 20, 250, 3},
                    Case{"volume", 5000, 500, 200, 20, 7}, Case{"line", 5000, 500, 100, 250, 9},
                    Case{"lattice", 5000, 900, 100, 30, 11}, Case{"uneven", 20000, 800, 100, 30, 15},
                    Case{"drifting", 5000, 500, 60, 10, 16}, Case{"volume", 2000, 2, 100, 250, 17},
                    Case{"surface", 5000, 900, 50, 250, 3, 10}, Case{"lattice", 5000, 300, 100, 30, 11, 1},
                    Case{"clusters", 5000, 1000, 50, 40, 13, 1000}));

NeuralGas grown(const PointCloud& cloud, const GngOptions& options) {
  return growNeuralGas(cloud, options);
}

GngOptions small(std::size_t neurons) {
  GngOptions options;
  options.neurons = neurons;
  options.signalsPerInsertion = 100;
  return options;
}

test::Caught refusalOf(const PointCloud& cloud, const GngOptions& options) {
  return test::caught([&] { grown(cloud, options); });
}

TEST(GrowingNeuralGas, StopsAtAQuantizationError) {
  const PointCloud cloud = made("surface", 20000, 3);
  GngOptions options = small(5000);
  options.signalsPerInsertion = 2000;
  options.quantizationError = 0.08;
  const NeuralGas gas = grown(cloud, options);
  EXPECT_EQ(gas.stop, GngStop::quantizationError);
  EXPECT_LT(gas.cloud.points.size(), 1000U);
  EXPECT_NEAR(gas.quantizationError, 0.08, 0.008);
}

TEST(GrowingNeuralGas, StopsAtADeadlineOrWhenAsked) {
  GngOptions options = small(1000);
  options.seconds = 1e-9;
  const NeuralGas gas = grown(made("surface", 20000, 3), options);
  EXPECT_EQ(gas.stop, GngStop::seconds);
  EXPECT_EQ(gas.cloud.points.size(), 2U);
  requestInterrupt();
  EXPECT_THAT([&] { grown(made("surface", 2000, 3), small(100)); }, FailsWith(ErrorCode::interrupted));
  EXPECT_TRUE(takeInterrupt());
}

TEST(GrowingNeuralGas, PointsThatAreNotFiniteDoNotCount) {
  PointCloud cloud = made("surface", 3000, 3);
  const NeuralGas clean = grown(cloud, small(100));
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(),
                  infinity = std::numeric_limits<float>::infinity();
  cloud.points.insert(cloud.points.begin(), {nan, 0, 0});
  cloud.points.insert(cloud.points.begin() + 100, {0, infinity, 0});
  cloud.points.insert(cloud.points.begin() + 200, {0, 0, -infinity});
  cloud.width = cloud.points.size();
  EXPECT_EQ(grown(cloud, small(100)).cloud.points, clean.cloud.points);
}

TEST(GrowingNeuralGas, FewerPointsThanNeuronsAreTheirOwnNetwork) {
  const NeuralGas gas = grown(cloudOf({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {10, 0, 0}, {1, 0, 0}}), small(10));
  EXPECT_EQ(gas.stop, GngStop::points);
  EXPECT_THAT(gas.cloud.points,
              testing::ElementsAre(cv::Point3f(0, 0, 0), cv::Point3f(1, 0, 0), cv::Point3f(10, 0, 0)));
  using Edge = std::array<std::uint32_t, 2>;
  EXPECT_THAT(gas.edges, testing::ElementsAre(Edge{0, 1}, Edge{1, 2}));
  EXPECT_EQ(gas.quantizationError, 0);
  EXPECT_EQ(gas.signals, 0U);

  const NeuralGas one = grown(cloudOf({{3, 4, 5}, {3, 4, 5}}), small(10));
  EXPECT_EQ(one.stop, GngStop::points);
  EXPECT_THAT(one.cloud.points, testing::ElementsAre(cv::Point3f(3, 4, 5)));
  EXPECT_TRUE(one.edges.empty());
}

TEST(GrowingNeuralGas, PointsTooNearToBeToldApartHaveNoEdgeToThemselves) {
  PointCloud cloud;
  for (const float x : {-1.F, 1.F, 1e-25F, 2e-25F, 3e-25F}) cloud.points.emplace_back(x, 0.F, 0.F);
  cloud.width = cloud.points.size();
  cloud.height = 1;
  const NeuralGas gas = growNeuralGas(cloud, {.neurons = 10});
  for (const auto& [from, to] : gas.edges) EXPECT_LT(from, to);
}

TEST(GrowingNeuralGas, RefusesWhatMakesNoSense) {
  const PointCloud cloud = made("surface", 100, 3);
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusalOf({}, small(10)), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(refusalOf(cloudOf({{nan, nan, nan}}), small(10)), FailsWith(ErrorCode::invalidInput));
  for (const std::size_t neurons : {std::size_t{0}, std::size_t{1}, std::size_t{1} << 60})
    EXPECT_THAT(refusalOf(cloud, small(neurons)), FailsWith(ErrorCode::invalidOption));
  using Change = void (*)(GngOptions&);
  const Change changes[] = {
      [](GngOptions& o) { o.signalsPerInsertion = 0; }, [](GngOptions& o) { o.winnerRate = 0; },
      [](GngOptions& o) { o.winnerRate = 1.5F; },       [](GngOptions& o) { o.neighborRate = nan; },
      [](GngOptions& o) { o.insertionDecay = -1; },     [](GngOptions& o) { o.errorDecay = 0; },
      [](GngOptions& o) { o.quantizationError = nan; }, [](GngOptions& o) { o.seconds = -1; },
      [](GngOptions& o) { o.colorWeight = nan; }};
  for (std::size_t i = 0; i < std::size(changes); ++i) {
    GngOptions options = small(10);
    changes[i](options);
    EXPECT_THAT(refusalOf(cloud, options), FailsWith(ErrorCode::invalidOption)) << i;
  }
  GngOptions colored = small(10);
  colored.colorWeight = 1;
  EXPECT_THAT(refusalOf(cloud, colored), FailsWith(ErrorCode::invalidInput)) << "without colors";
}

TEST(NormalsFromGraph, ArePerpendicularToTheSurfaceAndLookAtTheViewer) {
  PointCloud cloud = made("plane", 5000, 3);  // z = 0.25
  const NeuralGas flat = grown(cloud, small(200));
  for (const cv::Point3f& n : normalsFromGraph(flat)) EXPECT_LT(cv::norm(n - cv::Point3f(0, 0, -1)), 1e-3);
  for (const cv::Point3f& n : normalsFromGraph(flat, {0, 0, 5}))
    EXPECT_LT(cv::norm(n - cv::Point3f(0, 0, 1)), 1e-3);

  for (cv::Point3f& p : cloud.points) p = 0.5F / static_cast<float>(cv::norm(p)) * p;  // part of a sphere
  const NeuralGas sphere = grown(cloud, small(400));
  const std::vector<cv::Point3f> normals = normalsFromGraph(sphere);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const cv::Point3f& p = sphere.cloud.points[i];
    EXPECT_GT(normals[i].dot(-p / static_cast<float>(cv::norm(p))), 0.8F);
    EXPECT_NEAR(cv::norm(normals[i]), 1, 1e-5);
  }
}

TEST(NormalsFromGraph, ThereIsNoneWithoutAPlane) {
  for (const cv::Point3f& n : normalsFromGraph(grown(made("line", 3000, 3), small(50))))
    EXPECT_TRUE(std::isnan(n.x));
  EXPECT_TRUE(std::isnan(normalsFromGraph(grown(cloudOf({{1, 2, 3}}), small(5)))[0].x));
  EXPECT_TRUE(normalsFromGraph({}).empty());
  NeuralGas broken;
  broken.cloud = cloudOf({{1, 2, 3}, {2, 2, 2}});
  broken.edges = {{0, 2}};
  EXPECT_THROW(normalsFromGraph(broken), Error);
}

}  // namespace
}  // namespace estancia
