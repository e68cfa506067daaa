// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/growing_neural_gas.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <vector>

#include "estancia/cloud/normals.hpp"
#include "estancia/core/error.hpp"
#include "support/errors.hpp"
#include "tests/cloud/textbook_neural_gas.hpp"

namespace estancia {
namespace {

PointCloud unorganized(std::vector<cv::Point3f> points) {
  PointCloud cloud;
  cloud.width = points.size();
  cloud.height = 1;
  cloud.points = std::move(points);
  return cloud;
}

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
  return unorganized(std::move(points));
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
    testing::Values(Case{"surface", 20000, 600, 200, 250, 1}, Case{"surface", 20000, 600, 200, 250, 2},
                    Case{"surface", 3000, 2500, 20, 250, 3}, Case{"surface", 20000, 100, 2000, 250, 4},
                    Case{"surface", 20000, 300, 300, 12, 5}, Case{"volume", 5000, 500, 200, 250, 6},
                    Case{"volume", 5000, 500, 200, 20, 7}, Case{"plane", 5000, 500, 100, 250, 8},
                    Case{"line", 5000, 500, 100, 250, 9}, Case{"lattice", 5000, 300, 100, 250, 10},
                    Case{"lattice", 5000, 900, 100, 30, 11}, Case{"clusters", 5000, 400, 100, 250, 12},
                    Case{"clusters", 5000, 1000, 50, 40, 13}, Case{"uneven", 20000, 800, 100, 250, 14},
                    Case{"uneven", 20000, 800, 100, 30, 15}, Case{"drifting", 5000, 500, 60, 10, 16},
                    Case{"volume", 2000, 2, 100, 250, 17}, Case{"surface", 60000, 4000, 100, 250, 18},
                    Case{"surface", 20000, 600, 200, 250, 1, 1}, Case{"surface", 20000, 600, 200, 12, 2, 0.1},
                    Case{"surface", 5000, 900, 50, 250, 3, 10}, Case{"lattice", 5000, 300, 100, 30, 11, 1},
                    Case{"uneven", 20000, 800, 100, 30, 15, 1},
                    Case{"clusters", 5000, 1000, 50, 40, 13, 1000},
                    Case{"drifting", 5000, 500, 60, 10, 16, 1}));

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

TEST(GrowingNeuralGas, NeuronsThatNoLongerWinGo) {
  // Half of the cloud is far away and hardly ever seen again; edges to it grow old.
  const PointCloud cloud = made("drifting", 5000, 21);
  GngOptions options = small(500);
  options.signalsPerInsertion = 60;
  options.maxAge = 10;
  options.seed = 16;
  const Signals signals(cloud, options.seed);
  TextbookNeuralGas textbook(signals, options);
  Progress progress;
  textbook.grow(progress);
  EXPECT_GT(textbook.removed(), 0U);  // so that the comparison above has seen removals
  EXPECT_EQ(grown(cloud, options).cloud.points.size(), 500U);
}

TEST(GrowingNeuralGas, SeedsDecide) {
  const PointCloud cloud = made("surface", 5000, 3);
  GngOptions options = small(200);
  const NeuralGas a = grown(cloud, options), b = grown(cloud, options);
  EXPECT_EQ(a.cloud.points, b.cloud.points);
  EXPECT_EQ(a.edges, b.edges);
  options.seed = 2;
  EXPECT_NE(grown(cloud, options).cloud.points, a.cloud.points);
}

TEST(GrowingNeuralGas, UnitsDoNotMatter) {
  PointCloud cloud = made("surface", 5000, 3);
  const NeuralGas meters = grown(cloud, small(300));
  for (const float unit : {1024.0F, 0x1p-80F, 0x1p80F}) {
    PointCloud other = cloud;
    for (cv::Point3f& p : other.points) p *= unit;
    const NeuralGas scaled = grown(other, small(300));
    EXPECT_EQ(scaled.edges, meters.edges) << unit;
    for (std::size_t i = 0; i < 300; ++i) ASSERT_EQ(scaled.cloud.points[i], meters.cloud.points[i] * unit);
    EXPECT_NEAR(scaled.quantizationError, meters.quantizationError * unit, 1e-9 * scaled.quantizationError);
  }
  PointCloud millimeters = cloud;
  for (cv::Point3f& p : millimeters.points) p *= 1000;
  EXPECT_NEAR(grown(millimeters, small(300)).quantizationError, 1000 * meters.quantizationError,
              50 * meters.quantizationError);
}

TEST(GrowingNeuralGas, FollowsTheSurface) {
  const PointCloud cloud = made("surface", 20000, 3);
  const NeuralGas gas = grown(cloud, small(600));
  for (const cv::Point3f& p : gas.cloud.points) EXPECT_NEAR(p.z, 0.3F * std::sin(4 * p.x), 0.05F);
  EXPECT_FALSE(gas.cloud.organized());
  EXPECT_EQ(gas.cloud.width, 600U);
  EXPECT_EQ(gas.stop, GngStop::neurons);
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

TEST(GrowingNeuralGas, StopsAtADeadline) {
  GngOptions options = small(1000);
  options.seconds = 1e-9;
  const NeuralGas gas = grown(made("surface", 20000, 3), options);
  EXPECT_EQ(gas.stop, GngStop::seconds);
  EXPECT_EQ(gas.cloud.points.size(), 2U);
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
  const NeuralGas gas =
      grown(unorganized({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {10, 0, 0}, {1, 0, 0}}), small(10));
  EXPECT_EQ(gas.stop, GngStop::points);
  EXPECT_THAT(gas.cloud.points,
              testing::ElementsAre(cv::Point3f(0, 0, 0), cv::Point3f(1, 0, 0), cv::Point3f(10, 0, 0)));
  using Edge = std::array<std::uint32_t, 2>;
  EXPECT_THAT(gas.edges, testing::ElementsAre(Edge{0, 1}, Edge{1, 2}));
  EXPECT_EQ(gas.quantizationError, 0);
  EXPECT_EQ(gas.signals, 0U);

  const PointCloud many = made("volume", 3000, 4);
  const NeuralGas all = grown(many, small(3000));
  EXPECT_EQ(all.stop, GngStop::points);
  ASSERT_EQ(all.cloud.points.size(), 3000U);
  for (std::size_t i = 0; i < 3000; ++i) EXPECT_LT(cv::norm(all.cloud.points[i] - many.points[i]), 1e-6);

  const NeuralGas one = grown(unorganized({{3, 4, 5}, {3, 4, 5}}), small(10));
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

TEST(GrowingNeuralGas, HardlyMorePointsThanNeurons) {
  const NeuralGas gas = grown(made("volume", 400, 4), small(399));
  EXPECT_TRUE(gas.stop == GngStop::neurons ? gas.cloud.points.size() == 399 : gas.stop == GngStop::stalled);
  // Two places, one of them seen nearly always.
  PointCloud cloud = made("lattice", 3000, 4);
  for (std::size_t i = 20; i < 3000; ++i) cloud.points[i] = {100, 100, 100};
  const NeuralGas few = grown(cloud, small(15));
  EXPECT_LE(few.cloud.points.size(), 15U);
  EXPECT_GE(few.cloud.points.size(), 2U);
}

TEST(GrowingNeuralGas, HugeAndTinyCoordinates) {
  PointCloud cloud = made("surface", 3000, 3);
  for (std::size_t i = 0; i < 3000; i += 100) cloud.points[i] *= 1e30F;
  for (const NeuralGas& gas : {grown(cloud, small(20)), grown(made("uneven", 3000, 3), small(500))})
    for (const cv::Point3f& p : gas.cloud.points) EXPECT_TRUE(std::isfinite(p.x + p.y + p.z));
  constexpr float most = std::numeric_limits<float>::max();
  const NeuralGas widest =
      grown(unorganized({{-most, 0, 0}, {most, 0, 0}, {0, most, 0}, {0, 0, -most}}), small(3));
  EXPECT_EQ(widest.cloud.points.size(), 3U);
  for (const cv::Point3f& p : widest.cloud.points) EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y));
}

/// Of the neurons within `near` of an edge between two colors, how many have a color of neither side.
double mixed(const NeuralGas& gas, float near) {
  double mixed = 0, all = 0;
  for (std::size_t i = 0; i < gas.cloud.points.size(); ++i) {
    if (std::abs(gas.cloud.points[i].x) > near) continue;
    ++all;
    const int blue = gas.cloud.colors[i][0];
    mixed += blue > 75 && blue < 185 ? 1 : 0;
  }
  return mixed / all;
}

TEST(GrowingNeuralGas, ColorsKeepNeuronsOnOneSideOfAnEdge) {
  PointCloud cloud = made("surface", 20000, 3);
  for (const cv::Point3f& p : cloud.points) cloud.colors.emplace_back(p.x < 0 ? 60 : 200, 100, 90);
  GngOptions options = small(600);
  EXPECT_GT(mixed(grown(cloud, options), 0.03F), 0.3);
  options.colorWeight = 1;
  const NeuralGas colored = grown(cloud, options);
  EXPECT_LT(mixed(colored, 0.03F), 0.1);
  for (cv::Point3f& p : cloud.points) p *= 1024;
  EXPECT_EQ(grown(cloud, options).edges, colored.edges);  // in any unit of length
}

TEST(GrowingNeuralGas, ColorsDoNotMatterWithoutWeight) {
  const PointCloud cloud = made("surface", 5000, 3);
  const NeuralGas plain = grown(cloud, small(300)), colored = grown(painted(cloud, 1), small(300));
  EXPECT_EQ(colored.cloud.points, plain.cloud.points);
  EXPECT_EQ(colored.edges, plain.edges);
  EXPECT_TRUE(plain.cloud.colors.empty());
}

TEST(GrowingNeuralGas, RefusesWhatMakesNoSense) {
  using test::FailsWith;
  const PointCloud cloud = made("surface", 100, 3);
  EXPECT_THAT(refusalOf({}, small(10)), FailsWith(ErrorCode::invalidInput, "0"));
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusalOf(unorganized({{nan, nan, nan}}), small(10)), FailsWith(ErrorCode::invalidInput, "1"));
  for (const std::size_t neurons : {std::size_t{0}, std::size_t{1}, std::size_t{1} << 60})
    EXPECT_THAT(refusalOf(cloud, small(neurons)), FailsWith(ErrorCode::invalidOption, "gng.neurons"));
  const auto refused = [&](auto change) {
    GngOptions options = small(10);
    change(options);
    return refusalOf(cloud, options);
  };
  const auto option = [](const char* name, const char* value) {
    return FailsWith(ErrorCode::invalidOption, name, value);
  };
  EXPECT_THAT(refused([](GngOptions& o) { o.signalsPerInsertion = 0; }),
              option("gng.signals-per-insertion", "0"));
  EXPECT_THAT(refused([](GngOptions& o) { o.winnerRate = 0; }), option("gng.winner-rate", "0"));
  EXPECT_THAT(refused([](GngOptions& o) { o.winnerRate = 1.5F; }), option("gng.winner-rate", "1.5"));
  EXPECT_THAT(refused([](GngOptions& o) { o.neighborRate = nan; }), option("gng.neighbor-rate", "nan"));
  EXPECT_THAT(refused([](GngOptions& o) { o.insertionDecay = -1; }), option("gng.insertion-decay", "-1"));
  EXPECT_THAT(refused([](GngOptions& o) { o.errorDecay = 0; }), option("gng.error-decay", "0"));
  EXPECT_THAT(refused([](GngOptions& o) { o.quantizationError = nan; }),
              option("gng.quantization-error", "nan"));
  EXPECT_THAT(refused([](GngOptions& o) { o.seconds = -1; }), option("gng.seconds", "-1"));
  EXPECT_THAT(refused([](GngOptions& o) { o.colorWeight = nan; }), option("gng.color-weight", "nan"));
  EXPECT_THAT(refused([](GngOptions& o) { o.colorWeight = 1; }),
              FailsWith(ErrorCode::invalidInput, "no colors", "gng.color-weight"));
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
  EXPECT_TRUE(std::isnan(normalsFromGraph(grown(unorganized({{1, 2, 3}}), small(5)))[0].x));
  EXPECT_TRUE(normalsFromGraph({}).empty());
  NeuralGas broken;
  broken.cloud = unorganized({{1, 2, 3}, {2, 2, 2}});
  broken.edges = {{0, 2}};
  EXPECT_THROW(normalsFromGraph(broken), Error);
}

}  // namespace
}  // namespace estancia
