// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/descriptors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "estancia/core/error.hpp"
#include "estancia/recognition/keypoints.hpp"
#include "recognition/made_up_surface.hpp"
#include "recognition/pcl_reference.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
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
  EXPECT_THAT([&] { describe(sheet(), keypoints, "sift", 0.03); },
              FailsWith(ErrorCode::unknownName, "sift", "shot, shot-color, fpfh, spin-image"));
  EXPECT_THAT([&] { describe(sheet(), keypoints, "shot", 0); },
              FailsWith(ErrorCode::invalidOption, "sheet", "descriptor radius"));
  EXPECT_THAT([&] { describe(sheet(), keypoints, "shot", 35); },
              FailsWith(ErrorCode::mismatch, "sheet", "35"));
  EXPECT_THAT([&] { describe(sheet(), keypoints, "fpfh", 0.0001); },
              FailsWith(ErrorCode::mismatch, "sheet", "0.0001"));
  const Surface gray("gray", wavySheet(90, 0.3));
  EXPECT_THAT([&] { describe(gray, keypoints, "shot-color", 0.03); },
              FailsWith(ErrorCode::invalidInput, "gray", "no colors"));
}

TEST(Descriptors, ColorShotTellsTexturesApartThatHaveOneShape) {
  PointCloud plain = wavySheet(90, 0.3), stripes = painted(plain);
  plain.colors.assign(plain.points.size(), {40, 40, 200});
  const Surface a("plain", plain), b("stripes", stripes);
  const auto keypoints = everyNth(a, 97);
  const auto difference = [&](const std::string& method) {
    const SurfaceFeatures x = describe(a, keypoints, method, 0.03), y = describe(b, keypoints, method, 0.03);
    double sum = 0;
    for (std::size_t i = 0; i < x.descriptors.values().size(); ++i)
      sum += std::pow(static_cast<double>(x.descriptors.values()[i] - y.descriptors.values()[i]), 2);
    return sum / static_cast<double>(x.size());
  };
  EXPECT_EQ(difference("shot"), 0);
  EXPECT_GT(difference("shot-color"), 0.1);
}

TEST(Surface, AdvisesARadiusThatItAcceptsHoweverFewItsPoints) {
  for (const int across : {2, 3, 4, 5, 10, 40}) {
    std::vector<cv::Point3f> points;
    for (int i = 0; i < across * across; ++i)
      points.emplace_back(static_cast<float>(i % across), static_cast<float>(i / across), 1.F);
    const Neighbors neighbors(points);
    const auto refusal = [&](double radius) {
      return test::caught([&] { requireRadius("grid", points, neighbors, radius, "radius"); });
    };
    for (const double radius : {0.01, 1000.}) {
      const test::Caught error = refusal(radius);
      if (across < 5) {
        EXPECT_THAT(error, FailsWith(ErrorCode::insufficientData, std::to_string(across * across))) << across;
        continue;
      }
      EXPECT_THAT(error, FailsWith(ErrorCode::mismatch));
      const double advised = test::numbersIn(error.message).back();
      EXPECT_FALSE(refusal(advised).code) << across << ": " << error.message;
    }
  }
}

TEST(Descriptors, ExtremeSurfacesGiveNoNonsense) {
  PointCloud plane, twins;
  for (int i = 0; i < 400; ++i) {
    plane.points.emplace_back(0.01F * static_cast<float>(i % 20), 0.01F * static_cast<float>(i / 20), 1.F);
    plane.normals.emplace_back(0.F, 0.F, -1.F);
    twins.points.push_back(plane.points[static_cast<std::size_t>(i) / 2]);
    twins.normals.push_back(plane.normals.back());
  }
  for (const PointCloud& cloud : {plane, twins}) {
    const Surface surface("extreme", painted(cloud));
    for (const auto& [method, explanation] : descriptorMethods()) {
      const SurfaceFeatures features = describe(surface, everyNth(surface, 7), method, 0.05);
      EXPECT_GT(features.size(), 0U) << method;
      for (const float v : features.descriptors.values()) ASSERT_TRUE(std::isfinite(v)) << method;
    }
  }
}

#ifdef ESTANCIA_HAS_PCL

struct Deviation {
  double most = 0, mean = 0;  ///< of distances of rows, by the length of a row
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

}  // namespace
}  // namespace estancia
