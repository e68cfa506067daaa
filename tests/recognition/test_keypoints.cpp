// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/keypoints.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "estancia/core/error.hpp"
#include "recognition/made_up_surface.hpp"
#include "recognition/pcl_reference.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;

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

TEST(Keypoints, OfAPlaneAreNotSalient) {
  PointCloud plane;
  for (int i = 0; i < 900; ++i) {
    plane.points.emplace_back(0.01F * static_cast<float>(i % 30), 0.01F * static_cast<float>(i / 30), 1.F);
    plane.normals.emplace_back(0.F, 0.F, -1.F);
  }
  const Surface surface("plane", plane);
  EXPECT_TRUE(findKeypoints(surface, "harris3d", 0.05).empty());
  EXPECT_TRUE(findKeypoints(surface, "iss", 0.05).empty());
  EXPECT_FALSE(findKeypoints(surface, "uniform", 0.05).empty());
}

TEST(Keypoints, HarrisFindsTheCornersOfABox) {
  PointCloud box;  // three faces that meet in one corner
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j) {
      const float a = 0.01F * static_cast<float>(i) + 0.005F, b = 0.01F * static_cast<float>(j) + 0.005F;
      for (int face = 0; face < 3; ++face) {
        cv::Vec3f p(a, b, 0), n(0, 0, -1);
        box.points.emplace_back(cv::Point3f(p[(3 - face) % 3], p[(4 - face) % 3], p[(5 - face) % 3]));
        box.normals.emplace_back(cv::Point3f(n[(3 - face) % 3], n[(4 - face) % 3], n[(5 - face) % 3]));
      }
    }
  const Surface surface("box", box);
  const auto corners = findKeypoints(surface, "harris3d", 0.05);
  ASSERT_FALSE(corners.empty());
  double nearest = 1;
  for (const std::uint32_t i : corners) nearest = std::min(nearest, cv::norm(surface.points()[i]));
  EXPECT_LT(nearest, 0.05);
}

TEST(Keypoints, RefuseWhatCannotBe) {
  EXPECT_THAT([] { findKeypoints(wideSheet(), "sift", 0.01); },
              FailsWith(ErrorCode::unknownName, "sift", "uniform, harris3d, iss"));
  for (const double spacing : {0.0, -1.0, std::nan(""), 1e-12})
    EXPECT_THAT([&] { findKeypoints(wideSheet(), "uniform", spacing); },
                FailsWith(ErrorCode::invalidOption, "sheet"))
        << spacing;
}

TEST(Surface, NeedsPointsWithNormals) {
  PointCloud cloud = test::wavySheet(10, 0.3);
  cloud.normals.clear();
  EXPECT_THAT([&] { Surface("bare", cloud); }, FailsWith(ErrorCode::invalidInput, "bare", "100"));
  EXPECT_THAT([] { Surface("empty", PointCloud()); }, FailsWith(ErrorCode::invalidInput, "empty"));
}

TEST(Surface, LeavesOutHoles) {
  PointCloud cloud = test::wavySheet(20, 0.3);
  cloud.points[3].x = std::nanf("");
  cloud.normals[7].z = std::nanf("");
  EXPECT_EQ(Surface("holes", cloud).size(), 398U);
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
