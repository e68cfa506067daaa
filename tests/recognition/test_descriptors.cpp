// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/descriptors.hpp"

#include <gmock/gmock.h>

#include <string>

#include "estancia/core/error.hpp"
#include "estancia/recognition/surface.hpp"
#include "recognition/made_up_surface.hpp"
#include "recognition/pcl_reference.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::everyNth;
using test::FailsWith;
using test::moved;
using test::painted;
using test::wavySheet;

const Surface& sheet() {
  static const Surface surface("sheet", painted(wavySheet(90, 0.3)));
  return surface;
}

TEST(Descriptors, AreTheSameHoweverTheSurfaceIsTurned) {
  const cv::Affine3d turn(cv::Vec3d(0.3, -1.1, 2.0), cv::Vec3d(0.1, 0.2, -0.3));
  const Surface turned("turned", moved(painted(wavySheet(90, 0.3)), turn));
  const auto keypoints = everyNth(sheet(), 97);
  for (const auto& [method, explanation] : descriptorMethods()) {
    const SurfaceFeatures a = describe(sheet(), keypoints, method, 0.03),
                          b = describe(turned, keypoints, method, 0.03);
    ASSERT_EQ(a.keypoints, b.keypoints) << method;
    std::size_t near = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      double difference = 0, size = 0;
      for (std::size_t k = 0; k < a.descriptors.labels(); ++k) {
        difference += std::pow(a.descriptors.row(i)[k] - b.descriptors.row(i)[k], 2);
        size += std::pow(a.descriptors.row(i)[k], 2);
      }
      if (difference < 1e-3 * size) ++near;
    }
    // Where as many points lie on both sides, rounding decides which way a local frame looks.
    EXPECT_GE(near, a.size() * 95 / 100) << method;
  }
}

TEST(Descriptors, DoNotDependOnThreads) {
  const auto keypoints = everyNth(sheet(), 13);
  for (const auto& [method, explanation] : descriptorMethods()) {
    const SurfaceFeatures one = describe(sheet(), keypoints, method, 0.025, 1),
                          three = describe(sheet(), keypoints, method, 0.025, 3);
    EXPECT_EQ(one.descriptors.values(), three.descriptors.values()) << method;
    EXPECT_EQ(one.keypoints, three.keypoints) << method;
  }
}

TEST(Descriptors, LeaveOutKeypointsWithoutNeighbors) {
  PointCloud cloud = painted(wavySheet(60, 0.3));
  cloud.points.emplace_back(5.F, 5.F, 5.F);
  cloud.colors.emplace_back(0, 0, 0);
  cloud.normals.emplace_back(0.F, 0.F, -1.F);
  const Surface surface("lonely", cloud);
  const auto last = static_cast<std::uint32_t>(surface.size() - 1);
  const std::vector<std::uint32_t> keypoints{0, 100, last};
  for (const auto& [method, explanation] : descriptorMethods()) {
    const SurfaceFeatures features = describe(surface, keypoints, method, 0.04);
    EXPECT_EQ(features.keypoints, (std::vector<std::uint32_t>{0, 100})) << method;
    EXPECT_EQ(features.descriptors.size(), 2U);
    EXPECT_EQ(features.frames.size(), 2U);
  }
}

TEST(Descriptors, RefuseWhatCannotBe) {
  const auto keypoints = everyNth(sheet(), 100);
  EXPECT_THAT([&] { describe(sheet(), keypoints, "sift", 0.03); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { describe(sheet(), keypoints, "shot", 0); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([&] { describe(sheet(), keypoints, "shot", 35); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { describe(sheet(), keypoints, "fpfh", 0.0001); }, FailsWith(ErrorCode::mismatch));
  const Surface gray("gray", wavySheet(90, 0.3));
  EXPECT_THAT([&] { describe(gray, keypoints, "shot-color", 0.03); }, FailsWith(ErrorCode::invalidInput));
}

#ifdef ESTANCIA_HAS_PCL

struct Deviation {
  double most = 0, mean = 0;  ///< statistics of distances of rows, by the length of a row
};

Deviation deviation(const std::vector<float>& ours, const std::vector<float>& pcls, std::size_t length) {
  Deviation d;
  EXPECT_EQ(ours.size(), pcls.size());
  for (std::size_t i = 0; i < ours.size(); i += length) {
    double difference = 0, size = 0;
    for (std::size_t k = i; k < i + length; ++k) {
      difference += std::pow(static_cast<double>(ours[k]) - pcls[k], 2);
      size += std::pow(static_cast<double>(pcls[k]), 2);
    }
    const double off = std::sqrt(difference / size);
    d.most = std::max(d.most, off);
    d.mean += off * static_cast<double>(length) / static_cast<double>(ours.size());
  }
  return d;
}

TEST(Descriptors, ShotIsPclsWithinRounding) {
  const auto keypoints = everyNth(sheet(), 11);
  std::vector<float> ours;
  describeShot(sheet(), keypoints, localFrames(sheet(), keypoints, 0.03, 1), 0.03, false, 1, ours);
  const Deviation d = deviation(ours, test::pclShot(sheet(), keypoints, 0.03), 352);
  EXPECT_LT(d.mean, 1e-4);
  EXPECT_LT(d.most, 0.05);  // a point that rounding puts on the other side of a border
}

TEST(Descriptors, ColorShotIsPclsWithinItsTable) {
  const auto keypoints = everyNth(sheet(), 11);
  std::vector<float> ours;
  describeShot(sheet(), keypoints, localFrames(sheet(), keypoints, 0.03, 1), 0.03, true, 1, ours);
  const Deviation d = deviation(ours, test::pclColorShot(painted(wavySheet(90, 0.3)), keypoints, 0.03), 1344);
  EXPECT_LT(d.mean, 0.01);  // PCL looks CIELAB up in a table of 4,000 steps of light …
  EXPECT_LT(d.most, 0.15);  // … by which points that share a color may be on the other side of a border
}

TEST(Descriptors, FpfhIsPclsWithinRounding) {
  const auto keypoints = everyNth(sheet(), 11);
  std::vector<float> ours;
  describeFpfh(sheet(), keypoints, 0.03, 2, ours);
  const Deviation d = deviation(ours, test::pclFpfh(sheet(), keypoints, 0.03), 33);
  EXPECT_LT(d.mean, 1e-4);
  EXPECT_LT(d.most, 0.01);
}

TEST(Descriptors, SpinImageIsPclsWithinRounding) {
  const auto keypoints = everyNth(sheet(), 11);
  std::vector<float> ours;
  describeSpinImage(sheet(), keypoints, 0.03, 1, ours);
  const Deviation d = deviation(ours, test::pclSpinImage(sheet(), keypoints, 0.03), 153);
  EXPECT_LT(d.mean, 1e-4);
  EXPECT_LT(d.most, 0.01);
}

#endif

const Surface& wideSheet() {
  static const Surface surface("sheet", test::wavySheet(100, 0.3));
  return surface;
}

TEST(Keypoints, UniformGivesOnePointACell) {
  const auto keypoints = findKeypoints(wideSheet(), "uniform", 0.02);
  cv::Point3f low = wideSheet().points()[0];
  for (const cv::Point3f& p : wideSheet().points())
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
  const auto cellOf = [&](std::uint32_t i) {
    const cv::Point3f p = wideSheet().points()[i] - low;
    return std::array{static_cast<int>(p.x / 0.02), static_cast<int>(p.y / 0.02),
                      static_cast<int>(p.z / 0.02)};
  };
  std::map<std::array<int, 3>, int> cells, chosen;
  for (std::uint32_t i = 0; i < wideSheet().size(); ++i) ++cells[cellOf(i)];
  for (const std::uint32_t i : keypoints) ++chosen[cellOf(i)];
  EXPECT_EQ(chosen.size(), cells.size());
  EXPECT_EQ(keypoints.size(), cells.size());
  EXPECT_TRUE(std::is_sorted(keypoints.begin(), keypoints.end()));
}

TEST(Keypoints, DoNotDependOnThreadsOrUnits) {
  PointCloud millimeters = test::wavySheet(100, 0.3);
  for (cv::Point3f& p : millimeters.points) p *= 1024;  // a power of two: no rounding
  const Surface large("large", millimeters);
  for (const auto& [method, explanation] : keypointMethods()) {
    const auto one = findKeypoints(wideSheet(), method, 0.02, 1);
    EXPECT_GT(one.size(), 3U) << method;
    EXPECT_EQ(one, findKeypoints(wideSheet(), method, 0.02, 3)) << method;
    EXPECT_EQ(one, findKeypoints(large, method, 0.02 * 1024)) << method;
  }
}

TEST(Keypoints, RefuseWhatCannotBe) {
  EXPECT_THAT([] { findKeypoints(wideSheet(), "sift", 0.01); }, FailsWith(ErrorCode::unknownName));
  for (const double spacing : {0.0, -1.0, std::nan(""), 1e-12})
    EXPECT_THAT([&] { findKeypoints(wideSheet(), "uniform", spacing); }, FailsWith(ErrorCode::invalidOption))
        << spacing;
}

TEST(Surface, NeedsPointsWithNormals) {
  PointCloud cloud = test::wavySheet(10, 0.3);
  cloud.normals.clear();
  EXPECT_THAT([&] { Surface("bare", cloud); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { Surface("empty", PointCloud()); }, FailsWith(ErrorCode::invalidInput));
}

#ifdef ESTANCIA_HAS_PCL

TEST(Keypoints, IssAndHarrisArePcls) {
  for (const std::string method : {"iss", "harris3d"}) {
    const auto ours = findKeypoints(wideSheet(), method, 0.02);
    auto pcls = method == "iss" ? test::pclIss(wideSheet(), 0.02) : test::pclHarris(wideSheet(), 0.02);
    std::sort(pcls.begin(), pcls.end());
    std::vector<std::uint32_t> both;
    std::set_intersection(ours.begin(), ours.end(), pcls.begin(), pcls.end(), std::back_inserter(both));
    EXPECT_GT(pcls.size(), 10U) << method;
    EXPECT_GE(both.size(), std::max(ours.size(), pcls.size()) * 95 / 100)
        << method << ": " << ours.size() << " and PCL's " << pcls.size();
  }
}

#endif

}  // namespace
}  // namespace estancia
