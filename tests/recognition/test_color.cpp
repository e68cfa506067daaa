// What the colors of a model and a scene say about a pose.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estancia/recognition/color_term.hpp"
#include "estancia/recognition/pose_score.hpp"
#include "estancia/recognition/prepared.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "recognition/made_up_surface.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

/// A square of 0.2 m in z = 1 that is smoothly painted, without any shape.
PointCloud poster(double shift = 0) {
  PointCloud cloud;
  for (int i = 0; i < 101 * 101; ++i) {
    const double x = 0.002 * (i % 101 - 50), y = 0.002 * (i / 101 - 50), at = x - shift;
    cloud.points.emplace_back(cv::Point3f(static_cast<float>(x), static_cast<float>(y), 1));
    cloud.normals.emplace_back(0.F, 0.F, -1.F);
    cloud.colors.emplace_back(cv::saturate_cast<uchar>(128 + 80 * std::sin(40 * at)),
                              cv::saturate_cast<uchar>(128 + 80 * std::sin(30 * y)),
                              cv::saturate_cast<uchar>(128 + 80 * std::sin(25 * (at + y))));
  }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

TEST(ColorTerm, GradientsAreThoseOfTheColors) {
  PointCloud cloud = poster();
  const Surface surface("poster", cloud);
  const auto gradients = colorGradients(surface, 0.006, 2);
  ASSERT_EQ(gradients.size(), surface.size());
  double off = 0, all = 0;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    const std::size_t column = i % 101;
    if (column < 4 || column > 96 || i / 101 < 4 || i / 101 > 96) continue;
    const cv::Vec3f along = (surface.lab()[i + 1] - surface.lab()[i - 1]) / 0.004F;
    const cv::Vec3f slope(gradients[i](0, 0), gradients[i](1, 0), gradients[i](2, 0));
    off += cv::norm(slope - along, cv::NORM_L2SQR);
    all += cv::norm(along, cv::NORM_L2SQR);
    EXPECT_NEAR(gradients[i](0, 2), 0, 1e-2);  // none across the surface
  }
  EXPECT_LT(off, 0.02 * all);
  cloud.colors.clear();
  EXPECT_TRUE(colorGradients(Surface("gray", cloud), 0.006, 1).empty());
}

/// Refines the identity, of a poster whose print is moved along it by 4 mm; returns what is left.
double left(double tolerance, uchar brighter) {
  const double shift = 0.004;
  const Surface scene("scene", poster(shift));
  PointCloud print = poster();
  for (cv::Vec3b& c : print.colors)
    for (int k = 0; k < 3; ++k) c[k] = cv::saturate_cast<uchar>(c[k] + brighter);
  const Surface model("model", print);
  const NearestField field(scene.points(), 0.002, 0.02, 1);
  const RangeImage view({}, 0);
  const auto gradients = colorGradients(scene, 0.006, 1);
  const DenseScene dense{scene, field, view, &gradients};
  const cv::Affine3d pose =
      refineInField(spreadPointsBy(model, 0.005), {0, 0, 1}, dense, cv::Affine3d::Identity(),
                    {.firstReach = 0.01, .lastReach = 0.005, .rounds = 20, .color = tolerance});
  return cv::norm(pose.translation() - cv::Vec3d(shift, 0, 0));
}

TEST(ColorTerm, APrintFindsItsPlaceOnAPlane) {
  EXPECT_NEAR(left(0, 0), 0.004, 1e-4);  // shape alone stays
  EXPECT_LT(left(20, 0), 0.0005);
  EXPECT_LT(left(20, 20), 0.0008);  // in other light
}

TEST(ColorTerm, SupportNeedsTheColor) {
  PointCloud red = test::wavySheet(70, 0.25), blue = red;
  red.colors.assign(red.points.size(), {30, 30, 200});
  blue.colors.assign(blue.points.size(), {200, 60, 30});
  const Surface scene("scene", red);
  const NearestField field(scene.points(), 0.002, 0.02, 1);
  const RangeImage view({}, 0);
  const auto support = [&](const PointCloud& model, double tolerance) {
    return scorePose(spreadPointsBy(Surface("model", model), 0.005), {scene, field, view},
                     cv::Affine3d::Identity(),
                     {.offset = 0.005, .freeSpace = 0.02, .minDot = 0.7, .color = tolerance})
        .supported;
  };
  EXPECT_GT(support(red, 0), 0.95);
  EXPECT_EQ(support(red, 20), support(red, 0));
  EXPECT_EQ(support(blue, 0), support(red, 0));
  EXPECT_EQ(support(blue, 20), 0);
  red.colors.clear();
  EXPECT_EQ(support(red, 20), support(blue, 0)) << "colors count if both have them";
}

TEST(ColorDifference, CountsLightnessHalf) {
  EXPECT_EQ(colorDifference({50, 3, 4}, {50, 0, 0}), 5);
  EXPECT_EQ(colorDifference({50, 0, 0}, {30, 0, 0}), 10);
}

TEST(Recognizer, MeanSurfacesKeepColors) {
  PointCloud cloud = test::painted(test::wavySheet(120, 0.25));
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
    cloud.colors[i] = cloud.points[i].x < 0 ? cv::Vec3b(30, 30, 200) : cv::Vec3b(200, 60, 30);
  cloud.normals.clear();
  const Recognizer recognizer;
  const auto scene = recognizer.prepareScene("scene", cloud);
  const Surface& surface = scene->surface();
  ASSERT_EQ(surface.lab().size(), surface.size());
  for (std::size_t i = 0; i < surface.size(); ++i)
    if (std::abs(surface.points()[i].x) > 0.01F) {
      EXPECT_EQ(surface.lab()[i][2] > 0, surface.points()[i].x < 0) << surface.points()[i];
    }
}

TEST(RecognitionOptions, RefuseAColorToleranceThatIsNone) {
  for (const double tolerance : {-1.0, 301.0, std::nan("")}) {
    RecognitionOptions options;
    options.colorTolerance = tolerance;
    EXPECT_THAT([&] { validate(options); },
                test::FailsWith(ErrorCode::invalidOption, "recognition.color-tolerance"));
  }
}

}  // namespace
}  // namespace estancia
