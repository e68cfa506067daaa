// Boxes on a table: what a face that lies in a larger plane proves, and what the outline does.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/outline.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "estancia/cloud/resolution.hpp"
#include "estancia/cloud/voxel_grid.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/recognition/pose_candidates.hpp"
#include "estancia/recognition/prepared.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "recognition/made_up_surface.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

/// A box that stands on the table, turned about its normal, as seen by a camera above it.
struct Box {
  cv::Vec3d size;
  cv::Vec2d at;
  double turn = 0.5;

  /// T_table_box; the box's origin is in the middle of its foot.
  cv::Affine3d pose() const { return {cv::Vec3d(0, 0, turn), cv::Vec3d(at[0], at[1], 0)}; }
};

/// T_camera_table: a meter away, 40° above the table, whose normal is its z.
cv::Affine3d cameraOf() {
  const double down = 40 * CV_PI / 180;
  const cv::Matx33d turn(1, 0, 0, 0, -std::sin(down), -std::cos(down), 0, std::cos(down), -std::sin(down));
  return {turn, cv::Vec3d(0, 0, 1)};
}

/// Distance at which a ray enters the box, in its frame; infinite where it passes.
double enters(const cv::Vec3d& size, const cv::Vec3d& from, const cv::Vec3d& ray) {
  const cv::Vec3d low(-size[0] / 2, -size[1] / 2, 0), high(size[0] / 2, size[1] / 2, size[2]);
  double first = 0, last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double a = (low[k] - from[k]) / ray[k], b = (high[k] - from[k]) / ray[k];
    first = std::max(first, std::min(a, b)), last = std::min(last, std::max(a, b));
  }
  return first <= last ? first : std::numeric_limits<double>::infinity();
}

/// What a depth camera sees of boxes on a table of 0.9 × 0.7 m, with noise.
PointCloud viewOf(const std::vector<Box>& boxes, bool table, std::uint64_t seed = 1) {
  const cv::Affine3d toTable = cameraOf().inv();
  PointCloud cloud;
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 320; ++u) {
      const cv::Vec3d ray((u - 159.5) / 300 + 1e-9, (v - 119.5) / 300 + 1e-9, 1);
      const auto cast = [&](const cv::Affine3d& from) {
        return std::pair(cv::Vec3d(from.translation()), cv::Vec3d(from.rotation() * ray));
      };
      double depth = std::numeric_limits<double>::infinity();
      for (const Box& box : boxes) {
        const auto [from, along] = cast(box.pose().inv() * toTable);
        depth = std::min(depth, enters(box.size, from, along));
      }
      if (const auto [from, along] = cast(toTable); table && along[2] < 0) {
        const double onTable = -from[2] / along[2];
        const cv::Vec3d at = from + along * onTable;
        if (std::abs(at[0]) < 0.45 && std::abs(at[1]) < 0.35) depth = std::min(depth, onTable);
      }
      if (std::isfinite(depth)) cloud.points.emplace_back(cv::Point3d(ray * depth));
    }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return withDepthNoise(cloud, 0.001, 0, seed);
}

const Box carton{{0.08, 0.12, 0.2}, {0.05, 0.02}};

std::vector<Detection> searched(const PointCloud& model, const PointCloud& scene) {
  const Recognizer recognizer;
  return recognizer.find(*recognizer.prepareModel("model", model), *recognizer.prepareScene("scene", scene));
}

TEST(Outline, ATableGoesOnAndABoxEnds) {
  const Recognizer recognizer;
  const auto scene = recognizer.prepareScene("scene", viewOf({{{0.25, 0.25, 0.15}, {0.1, 0}, 0}}, true));
  const auto described = scene->describedFor(scene->scales());
  const Outline& outline = described->outline;
  const Surface& surface = *described->surface;
  const auto nearest = [&](const cv::Vec3d& onTable) {
    const cv::Point3d at = cameraOf() * cv::Point3d(onTable);
    std::vector<Neighbor> buffer;
    return surface.neighbors().nearest(cv::Point3f(at), 1, buffer)[0].index;
  };
  const auto endsAt = [&](std::uint32_t point) {
    return std::ranges::count(outline.around(point), Outline::ends);
  };
  const std::uint32_t middle = nearest({-0.25, -0.1, 0}), top = nearest({0.1, 0, 0.15}),
                      rim = nearest({-0.02, -0.05, 0.15});
  EXPECT_EQ(endsAt(middle), 0);
  EXPECT_GT(endsAt(rim), 1);
  EXPECT_GE(outline.planeOf(middle), 0);
  EXPECT_GE(outline.planeOf(top), 0);
  EXPECT_NE(outline.planeOf(top), outline.planeOf(middle));
  const Outline::Plane& table = outline.planes()[static_cast<std::size_t>(outline.planeOf(middle))];
  const cv::Vec3d up = cameraOf().rotation() * cv::Vec3d(0, 0, 1);
  EXPECT_GT(cv::Vec3d(cv::Point3d(table.normal)).dot(up), 0.999);
}

/// The carton on the table, tried in poses that are moved from its own, in the table's frame [m].
struct Tried {
  Recognizer recognizer;
  std::shared_ptr<const PreparedScene> scene = recognizer.prepareScene("scene", viewOf({carton}, true));
  std::shared_ptr<const PreparedModel> model = recognizer.prepareModel("model", viewOf({carton}, false));
  std::shared_ptr<const PreparedScene::Described> at = scene->describedFor(scene->scalesFor(*model));
  std::shared_ptr<const PreparedModel::Described> shape = model->describedFor(at->scales);
  PoseTolerances limits = toleranceOf(at->scales);

  static cv::Affine3d moved(const cv::Vec3d& by) {
    return cameraOf() * cv::Affine3d(cv::Vec3d(), by) * cameraOf().inv();
  }
  PoseScore plain(const cv::Vec3d& by) const {
    return scorePose(shape->dense.fine, at->dense(), moved(by), limits);
  }
  PoseScore outlined(const cv::Vec3d& by) const {
    return scoreOutlined(shape->dense.fine, shape->dense.extent, at->dense(), moved(by), limits);
  }
};

TEST(Outline, AFaceInALargerPlaneProvesNothing) {
  const Tried tried;
  const PoseScore there = tried.outlined({0, 0, 0});
  EXPECT_GT(there.supported, 0.9);
  EXPECT_GT(there.outlined, 0.95);
  // The top in the table, the rest below: the table supports it, and hides the sides.
  const PoseScore in = tried.outlined({-0.25, -0.1, -0.2});
  EXPECT_GT(in.supported, 0.2);
  EXPECT_LT(in.outlined, 0.1);
  EXPECT_LT(in.support, 0.1 * in.supported);
}

TEST(Outline, WhatOverhangsByPixelsIsInFreeSpace) {
  const Tried tried;
  EXPECT_LT(tried.outlined({0, 0, 0}).seenThrough, 0.01);
  // 2 cm on either side of a narrower box: 6 pixels, less than two points of the mean surface.
  const Box narrower{{0.08, 0.08, 0.2}, carton.at};
  const auto scene = tried.recognizer.prepareScene("narrower", viewOf({narrower}, true));
  const auto at = scene->describedFor(scene->scalesFor(*tried.model));
  const auto seenThrough = [&](const DenseScene& dense) {
    return scoreOutlined(tried.shape->dense.fine, tried.shape->dense.extent, dense, Tried::moved({0, 0, 0}),
                         tried.limits)
        .seenThrough;
  };
  DenseScene smooth = at->dense();
  smooth.measured = nullptr;
  EXPECT_GT(seenThrough(at->dense()), 0.06);
  EXPECT_LT(seenThrough(smooth), 0.03);
}

TEST(Outline, ThingsDoNotPierceATable) {
  const Tried tried;
  // 6 cm deeper: its sides fit the carton above the table, and a part is below.
  const cv::Vec3d sunk(0, 0, -0.06);
  const PoseScore plain = tried.plain(sunk), outlined = tried.outlined(sunk);
  EXPECT_GT(plain.occluded, 0.05);
  EXPECT_GT(outlined.seenThrough, plain.seenThrough + 0.3 * plain.occluded);
}

TEST(Outline, WhatAnInstanceExplainsIsNoOthersMaybe) {
  const Recognizer recognizer;
  const auto scene = recognizer.prepareScene("scene", viewOf({carton}, true));
  const auto one = recognizer.prepareModel("one", viewOf({carton}, false)),
             twin = recognizer.prepareModel("twin", viewOf({carton}, false, 3));
  std::vector<PoseCandidates> candidates;
  candidates.push_back(recognizer.search(*one, *scene));
  candidates.push_back(recognizer.search(*twin, *scene));
  ASSERT_FALSE(candidates[0].instances.empty());
  ASSERT_FALSE(candidates[1].instances.empty());
  std::vector<Detection> maybe;
  EXPECT_EQ(recognizer.verify(candidates, &maybe).size(), 1U);
  EXPECT_TRUE(maybe.empty());
}

TEST(Outline, ABoxOnATableIsFoundOnce) {
  const PointCloud scene = viewOf({carton, {{0.15, 0.2, 0.06}, {-0.25, 0.05}, -0.3}}, true, 2);
  const auto found = searched(viewOf({carton}, false), scene);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(test::isCorrect(test::poseError(found[0].pose, cv::Affine3d::Identity(), found[0].center)));
}

TEST(Outline, ABoxIsNotFoundInABareTableNorInAnother) {
  EXPECT_TRUE(searched(viewOf({carton}, false), viewOf({}, true)).empty());
  EXPECT_TRUE(
      searched(viewOf({carton}, false), viewOf({{{0.3, 0.25, 0.1}, {-0.1, 0.05}, 0.2}}, true)).empty());
}

/// The example of PCL's tutorials: the carton stands there once (mean of its points), before floor and wall.
TEST(Outline, PclsCartonIsFoundOnceInEachFrame) {
  const auto data = test::findData("pcl_correspondence");
  ESTANCIA_NEEDS(data, "pcl_correspondence is not unpacked");
  const PointCloud model = readCloud(*data / "milk.pcd");
  const PointCloud scene = readCloud(*data / "milk_cartoon_all_small_clorox.pcd");
  const cv::Affine3d asIs = cv::Affine3d::Identity(), alongZ(cv::Vec3d(CV_PI, 0, 0)),
                     moved(cv::Vec3d(0.4, -0.7, 0.2), cv::Vec3d(1.5, -2, 0.8));
  for (const cv::Affine3d& frame : {asIs, alongZ, moved}) {
    const PointCloud there = test::moved(scene, frame);
    EXPECT_TRUE(Recognizer().prepareScene("scene", there)->hasView());  // the file looks along -z
    const auto found = searched(model, there);
    ASSERT_EQ(found.size(), 1U);
    const cv::Point3d at = frame.inv() * (found[0].pose * found[0].center);
    EXPECT_LT(cv::norm(at - cv::Point3d(-0.06, 0.13, -0.78)), 0.02);
  }
}

/// The example of PCL's template alignment: six views of a face, and where they all lie on the head.
TEST(Outline, PclsFacesAreFoundOnTheHeadSurelyOrMaybe) {
  const auto data = test::findData("pcl_tutorials");
  ESTANCIA_NEEDS(data, "pcl_tutorials is not unpacked");
  const Recognizer recognizer;
  const auto scene = recognizer.prepareScene("person", readCloud(*data / "person.pcd"));
  const auto onHead = [](const Detection& face) {
    return cv::norm(face.pose * face.center - cv::Point3d(-0.08, 0.04, 0.765)) < 0.08;
  };
  std::size_t sure = 0;
  for (const char view : std::string("012345")) {
    const auto model =
        recognizer.prepareModel("face", readCloud(*data / (std::string("object_template_") + view + ".pcd")));
    std::vector<PoseCandidates> candidates;
    candidates.push_back(recognizer.search(*model, *scene));
    std::vector<Detection> maybe;
    const std::vector<Detection> found = recognizer.verify(candidates, &maybe);
    EXPECT_TRUE(std::ranges::all_of(found, onHead)) << view;
    for (const Detection& face : maybe) EXPECT_GT(face.falseAlarmRate, 0.01);
    sure += found.empty() ? 0 : 1;
    EXPECT_TRUE(!found.empty() || std::ranges::any_of(maybe, onHead)) << view;
  }
  EXPECT_GE(sure, 4U);
}

class PclsScene : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto data = test::findData("pcl_correspondence");
    ESTANCIA_NEEDS(data, "pcl_correspondence is not unpacked");
    scene = finitePoints(readCloud(*data / "milk_cartoon_all_small_clorox.pcd"));
    scene.viewpoint.reset();
  }
  std::shared_ptr<const PreparedScene> in(const cv::Affine3d& frame) const {
    return recognizer.prepareScene("scene", test::moved(scene, frame));
  }
  Recognizer recognizer;
  PointCloud scene;
};

TEST_F(PclsScene, ACameraAtTheOriginMayLookAnywhere) {
  for (const cv::Vec3d& turn :
       {cv::Vec3d(), cv::Vec3d(0.3, 1, -2), cv::Vec3d(0, 1.4, 0), cv::Vec3d(0, 3, 0)}) {
    const auto prepared = in(cv::Affine3d(turn));
    EXPECT_TRUE(prepared->hasView()) << turn;
    EXPECT_FALSE(prepared->estimatedViewpoint()) << turn;
    EXPECT_EQ(prepared->viewKnown(), PreparedScene::ViewKnown::yes);
  }
}

/// Frames whose origin is not the sensor: beside it, before it, amid the points, above, a robot's base.
TEST_F(PclsScene, AnotherOriginIsNotTakenForTheSensor) {
  const double half = CV_PI / 2;
  for (const cv::Affine3d& frame :
       {cv::Affine3d(cv::Vec3d(), cv::Vec3d(0.4, 0, 0)), cv::Affine3d(cv::Vec3d(), cv::Vec3d(0, 0, -0.6)),
        cv::Affine3d(cv::Vec3d(), cv::Vec3d(0, 0, -1.5)),
        cv::Affine3d(cv::Vec3d(half, 0, 0), cv::Vec3d(0, 1, -1)),
        cv::Affine3d(cv::Vec3d(-1.2, 1.2, -1.2), cv::Vec3d(0.2, 0.1, 0.9))}) {
    const auto prepared = in(frame);
    if (prepared->hasView()) {
      ASSERT_TRUE(prepared->estimatedViewpoint()) << frame.translation();
      EXPECT_LT(cv::norm(*prepared->estimatedViewpoint() - cv::Point3d(frame.translation())), 0.5)
          << frame.translation();
    } else {
      EXPECT_EQ(prepared->viewKnown(), PreparedScene::ViewKnown::no) << frame.translation();
    }
  }
}

TEST_F(PclsScene, WhereAThinnedCloudWasSeenFromIsAssumed) {
  scene = voxelGrid(scene, 0.01);
  const auto prepared = in(cv::Affine3d::Identity());
  EXPECT_FALSE(prepared->estimatedViewpoint());
  EXPECT_EQ(prepared->viewKnown(), PreparedScene::ViewKnown::assumed);
}

}  // namespace
}  // namespace estancia
