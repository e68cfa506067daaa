// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <random>
#include <thread>

#ifdef ESTANCIA_HAS_PCL
#include <pcl/features/esf.h>
#include <pcl/point_types.h>
#endif

#include "describe/made_up_sequence.hpp"
#include "estancia/describe/esf.hpp"
#include "estancia/describe/features.hpp"
#include "support/errors.hpp"

#ifdef ESTANCIA_HAS_PCL
namespace {
unsigned pclSeed = 1;
}
/// PCL starts its random numbers with the second that it is run in; here they are different in every run, and
/// the same in every test: the program's own srand stands before the C library's.
extern "C" void srand(unsigned) noexcept {
  srandom(pclSeed);
}
#endif

namespace estancia {
namespace {

using test::FailsWith;

const CameraIntrinsics kCamera{320, 240, 290, 290, 159.5, 119.5};
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/// The surface of a bent sheet with a ball on it.
PointCloud sheetAndBall(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::normal_distribution<float> normal;
  PointCloud cloud;
  while (cloud.points.size() < count) {
    const float x = uniform(random), y = uniform(random);
    cloud.points.emplace_back(x, y, 0.3F * x * x);
    const cv::Point3f d(normal(random), normal(random), normal(random));
    cloud.points.push_back(d * (0.4F / std::sqrt(d.dot(d))) + cv::Point3f(0.2F, 0.1F, 0.8F));
  }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

PointCloud moved(PointCloud cloud, float scale, cv::Point3f by = {}) {
  for (cv::Point3f& p : cloud.points) p = p * scale + by;
  return cloud;
}

double overlap(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::min(a[i], b[i]);
  return sum;
}

TEST(Esf, TheSameSeedGivesTheSameBytesInAnyThread) {
  const PointCloud cloud = sheetAndBall(30000, 2);  // thinned, too
  const auto once = esf(cloud, {.seed = 7});
  std::vector<std::vector<float>> results(6);
  {
    std::vector<std::jthread> threads;
    for (auto& result : results) threads.emplace_back([&] { result = esf(cloud, {.seed = 7}); });
  }
  for (const auto& result : results) EXPECT_EQ(result, once);
  EXPECT_NE(esf(cloud, {.seed = 8}), once);
  EXPECT_GT(overlap(esf(cloud, {.seed = 8}), once), 0.93);
}

TEST(Esf, UnitAndPlaceDoNotCount) {
  const PointCloud meters = sheetAndBall(8000, 3);
  const auto v = esf(meters);
  ASSERT_EQ(v.size(), 640U);
  EXPECT_NEAR(std::accumulate(v.begin(), v.end(), 0.0), 1, 1e-4);
  // Powers of two change no bit of the points; thousands round some over a limit.
  EXPECT_EQ(esf(moved(meters, 1024)), v);
  EXPECT_GT(overlap(esf(moved(meters, 1000)), v), 0.999);
  EXPECT_GT(overlap(esf(moved(meters, 1e-3F)), v), 0.999);
  EXPECT_GT(overlap(esf(moved(meters, 1, {5, -3, 9})), v), 0.995);
}

TEST(Esf, RefusesWhatHasNoShape) {
  PointCloud line, slanted;
  for (int i = 0; i < 500; ++i) {
    line.points.emplace_back(static_cast<float>(i), 0.0F, 1.0F);
    slanted.points.push_back(cv::Point3f(3, -7, 11) * static_cast<float>(i));
  }
  PointCloud pair{std::vector<cv::Point3f>(5000, {0, 0, 0}), {}, {}, 5002, 1};
  pair.points.push_back({1, 0, 0});
  pair.points.push_back({0, 1, 0});
  const PointCloud clouds[] = {{},
                               {{{0, 0, 0}, {1, 0, 0}}, {}, {}, 2, 1},
                               {{{0, 0, 0}, {1, 0, 0}, {nan, 1, 1}}, {}, {}, 3, 1},
                               {std::vector<cv::Point3f>(500, {1, 2, 3}), {}, {}, 500, 1},
                               line,
                               slanted,
                               pair};
  for (const PointCloud& cloud : clouds)
    EXPECT_THAT([&] { esf(cloud); }, FailsWith(ErrorCode::insufficientData)) << cloud.points.size();
  const PointCloud cloud = sheetAndBall(100, 8);
  EXPECT_THAT([&] { esf(cloud, {.samples = 0}); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([&] { esf(cloud, {.points = 2}); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_EQ(esf({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, {}, 3, 1}).size(), 640U) << "three are enough";
}

cv::Mat roomDepth(std::uint64_t seed) {
  cv::Mat depth(240, 320, CV_32F);
  cv::RNG random(seed);
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) {
      const double floor = y > 120 ? 1.4 / kCamera.slopeY(y) : 1e9;
      const bool box = x > 100 && x < 180 && y > 90 && y < 190;
      depth.at<float>(y, x) =
          static_cast<float>(std::min({3.0, floor, box ? 1.8 : 1e9}) + random.gaussian(0.005));
    }
  return depth;
}

TEST(Esf, DescribesAView) {
  View view{{}, roomDepth(1), kCamera, "a"};
  const auto v = Esf().describe(view);
  EXPECT_EQ(v, esf(backProject(view.depth, kCamera)));
  view.depth.rowRange(0, 5).setTo(0);
  view.depth.rowRange(5, 9).setTo(nan);
  EXPECT_GT(overlap(Esf().describe(view), v), 0.9);

  view.depth = cv::Mat::zeros(240, 320, CV_32F);
  EXPECT_THAT([&] { Esf().describe(view); }, FailsWith(ErrorCode::insufficientData));
  view.depth = roomDepth(1);
  view.camera.reset();
  EXPECT_THAT([&] { Esf().describe(view); }, FailsWith(ErrorCode::invalidInput));
  view.depth.release();
  EXPECT_THAT([&] { Esf().describe(view); }, FailsWith(ErrorCode::invalidInput));
}

TEST(BackProjection, PutsPixelsWhereTheCameraSawThem) {
  cv::Mat depth = cv::Mat::zeros(2, 3, CV_32F);
  depth.at<float>(1, 2) = 2;
  depth.at<float>(0, 0) = -1;
  depth.at<float>(0, 1) = std::numeric_limits<float>::infinity();
  const PointCloud cloud = backProject(depth, {3, 2, 10, 20, 1, 0.5});
  EXPECT_TRUE(cloud.organized());
  ASSERT_EQ(cloud.points.size(), 6U);
  EXPECT_EQ(cloud.width, 3U);
  EXPECT_FLOAT_EQ(cloud.points[5].x, 0.2F);
  EXPECT_FLOAT_EQ(cloud.points[5].y, 0.05F);
  EXPECT_FLOAT_EQ(cloud.points[5].z, 2);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(std::isnan(cloud.points[static_cast<std::size_t>(i)].z));
  EXPECT_THAT([&] { backProject({}, kCamera); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { backProject(cv::Mat(2, 2, CV_16U), kCamera); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { backProject(depth, {}); }, FailsWith(ErrorCode::invalidInput));
}

#ifdef ESTANCIA_HAS_PCL
std::vector<float> pclEsf(const PointCloud& cloud, unsigned run) {
  pclSeed = run + 1;
  const auto input = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const cv::Point3f& p : cloud.points) input->emplace_back(p.x, p.y, p.z);
  pcl::ESFEstimation<pcl::PointXYZ> estimation;
  estimation.setInputCloud(input);
  pcl::PointCloud<pcl::ESFSignature640> output;
  estimation.compute(output);
  return {output[0].histogram, output[0].histogram + 640};
}

struct Moments {
  std::vector<double> mean = std::vector<double>(640), variance = std::vector<double>(640);

  explicit Moments(const std::vector<std::vector<float>>& runs) {
    const auto n = static_cast<double>(runs.size());
    for (std::size_t i = 0; i < 640; ++i) {
      for (const auto& run : runs) mean[i] += run[i] / n;
      for (const auto& run : runs) variance[i] += (run[i] - mean[i]) * (run[i] - mean[i]) / (n - 1);
    }
  }
};

/// Welch's test in every bin. A |t| of 8 with 80 degrees of freedom happens once in 10^11 by chance, so that
/// the 640 bins never fail without a reason; the mean of t² is 1 by chance, and above 2 when
/// bins differ by as little as half a standard deviation of one run.
void expectSameDistribution(const PointCloud& cloud) {
  constexpr unsigned runs = 48;
  std::vector<std::vector<float>> ours, theirs;
  for (unsigned run = 0; run < runs; ++run) {
    ours.push_back(esf(cloud, {.points = 0, .seed = run + 1}));
    theirs.push_back(pclEsf(cloud, run));
  }
  const Moments a(ours), b(theirs);
  double sum = 0;
  int tested = 0;
  for (std::size_t i = 0; i < 640; ++i) {
    // About 120,000 counts: a bin with less than a dozen is no normal distribution.
    if (std::max(a.mean[i], b.mean[i]) < 1e-4) {
      EXPECT_NEAR(a.mean[i], b.mean[i], 1e-4) << i;
      continue;
    }
    const double t = (a.mean[i] - b.mean[i]) / std::sqrt((a.variance[i] + b.variance[i]) / runs);
    EXPECT_LT(std::abs(t), 8) << "bin " << i << ": " << a.mean[i] << " and " << b.mean[i];
    sum += t * t;
    ++tested;
  }
  EXPECT_GT(tested, 150);
  EXPECT_LT(sum / tested, 2);
}

TEST(EsfAsPcl, OfAMadeUpCloud) {
  expectSameDistribution(sheetAndBall(6000, 9));
}

#endif

}  // namespace
}  // namespace estancia
