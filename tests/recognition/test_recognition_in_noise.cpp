// The default preset: real scenes as they are and in noise, other units, objects seen from all sides, and
// clouds that nobody should be asked to look through.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "estancia/cloud/noise.hpp"
#include "estancia/core/error.hpp"
#include "estancia/io/cloud_file.hpp"
#include "estancia/recognition/prepared.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "recognition/pose_check.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::isCorrect;
using test::poseError;

const RecognitionOptions standard;

PointCloud scaled(PointCloud cloud, float by) {
  for (cv::Point3f& p : cloud.points) p *= by;
  return cloud;
}

/// Of the thesis' data.
struct Pair {
  PointCloud model, scene;
  cv::Affine3d truth;
};

Pair pairOf(const std::filesystem::path& data, const std::string& model, const std::string& scene,
            const std::string& pose) {
  Pair pair{readCloud(data / "models" / model), readCloud(data / "scenes" / scene), {}};
  std::ifstream in(data / "gt" / pose);
  cv::Matx44d matrix;
  for (double& v : matrix.val) in >> v;
  pair.truth = cv::Affine3d(matrix);
  EXPECT_TRUE(in) << pose;
  return pair;
}

std::vector<Detection> findIn(const PointCloud& model, const PointCloud& scene,
                              const RecognitionOptions& options = standard) {
  const Recognizer recognizer(options);
  return recognizer.find(*recognizer.prepareModel("model", model), *recognizer.prepareScene("scene", scene));
}

constexpr const char* missing = "shot_kinect is not unpacked";

TEST(RecognitionInNoise, FindsWhatIsThereAndNotWhatIsNot) {
  const auto data = test::findData("shot_kinect");
  ESTANCIA_NEEDS(data, missing);
  const Pair mario = pairOf(*data, "mario/mario000.pcd", "scene005.pcd", "scene005-rs1.xf");
  const Recognizer recognizer(standard);
  const auto here = recognizer.prepareModel("here", mario.model);
  const auto notHere =
      recognizer.prepareModel("not here", readCloud(*data / "models" / "frog" / "Frog004.pcd"));
  for (const double noise : {0.0, 0.005, 0.01}) {
    const auto scene = recognizer.prepareScene("scene", withGaussianNoise(mario.scene, noise, 5));
    EXPECT_NEAR(scene->noise(), std::hypot(noise, 0.0005),
                0.1 * noise + 0.0003);  // the sensor has some itself
    const auto found = recognizer.find(*here, *scene);
    ASSERT_EQ(found.size(), 1U) << noise;
    EXPECT_TRUE(isCorrect(poseError(found[0].pose, mario.truth, found[0].center))) << noise;
    EXPECT_GT(found[0].confidence, 0.5);
    EXPECT_LE(found[0].confidence, 1);
    EXPECT_GT(found[0].inliers, 100U);
    std::vector<StageReport> stages;
    EXPECT_TRUE(recognizer.find(*notHere, *scene, &stages).empty()) << noise;
    ASSERT_FALSE(stages.empty());
    EXPECT_THAT(test::numbersIn(stages.back().detail), testing::Contains(0.01))
        << "the rate of false alarms that is allowed";
  }
}

TEST(RecognitionInNoise, OfADepthCameraMattersLittle) {
  const auto data = test::findData("shot_kinect");
  ESTANCIA_NEEDS(data, missing);
  const Pair mario = pairOf(*data, "mario/mario000.pcd", "scene005.pcd", "scene005-rs1.xf");
  const PointCloud absent = readCloud(*data / "models" / "frog" / "Frog004.pcd");
  for (const double atOneMeter : {0.0019, 0.004}) {  // a Kinect's, and twice that
    const PointCloud scene = withDepthNoise(mario.scene, atOneMeter, 0.0014, 5);
    const auto found = findIn(mario.model, scene);
    ASSERT_EQ(found.size(), 1U) << atOneMeter;
    EXPECT_TRUE(isCorrect(poseError(found[0].pose, mario.truth, found[0].center))) << atOneMeter;
    EXPECT_TRUE(findIn(absent, scene).empty()) << atOneMeter;
  }
}

TEST(RecognitionInNoise, MillimetersAndThreadsDoNotMatter) {
  const auto data = test::findData("shot_kinect");
  ESTANCIA_NEEDS(data, missing);
  const Pair pair = pairOf(*data, "mario/mario000.pcd", "scene005.pcd", "scene005-rs1.xf");
  const PointCloud scene = withGaussianNoise(pair.scene, 0.005, 3);
  RecognitionOptions options = standard;
  options.threads = 1;
  const auto one = findIn(pair.model, scene, options);
  options.threads = 2;
  const auto two = findIn(pair.model, scene, options);
  const auto millimeters = findIn(scaled(pair.model, 1000), scaled(scene, 1000), options);
  ASSERT_EQ(one.size(), 1U);
  ASSERT_EQ(two.size(), 1U);
  EXPECT_EQ(one[0].pose.matrix, two[0].pose.matrix);
  EXPECT_EQ(one[0].confidence, two[0].confidence);
  ASSERT_EQ(millimeters.size(), 1U);
  EXPECT_NEAR(millimeters[0].confidence, one[0].confidence, 0.03);
  EXPECT_LT(cv::norm(millimeters[0].pose.rotation() - one[0].pose.rotation()), 0.03);
  EXPECT_LT(cv::norm(millimeters[0].pose.translation() * 0.001 - one[0].pose.translation()), 0.01);
}

TEST(RecognitionInNoise, TooSmallToBeSeenIsNotSeen) {
  const auto data = test::findData("shot_kinect");
  ESTANCIA_NEEDS(data, missing);
  const Pair pair = pairOf(*data, "mario/mario000.pcd", "scene005.pcd", "scene005-rs1.xf");
  EXPECT_TRUE(findIn(scaled(pair.model, 0.05F), pair.scene).empty());
}

TEST(RecognitionInNoise, NeuronsMaySeedTheSurface) {
  const auto data = test::findData("shot_kinect");
  ESTANCIA_NEEDS(data, missing);
  const Pair pair = pairOf(*data, "mario/mario000.pcd", "scene005.pcd", "scene005-rs1.xf");
  RecognitionOptions options = standard;
  options.sceneFilter.method = "gng";
  const auto found = findIn(pair.model, withGaussianNoise(pair.scene, 0.01, 2), options);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(isCorrect(poseError(found[0].pose, pair.truth, found[0].center)));
}

/// A lump without symmetry, 0.3 m across, in its own frame; `normals` as a CAD program gives them.
PointCloud lump(std::size_t points, bool normals) {
  PointCloud cloud;
  const auto radius = [](const cv::Vec3d& d) {
    return 0.11 + 0.05 * d[0] * d[1] + 0.035 * std::sin(5 * d[2] + 1) + 0.03 * std::cos(4 * d[0] - 2 * d[1]) +
           0.04 * d[0] * d[2] * d[2];
  };
  for (std::size_t i = 0; i < points; ++i) {
    const double turn = 2.399963 * static_cast<double>(i);
    const double z = 1 - 2 * (static_cast<double>(i) + 0.5) / static_cast<double>(points);
    const double r = std::sqrt(1 - z * z);
    const cv::Vec3d d(r * std::cos(turn), r * std::sin(turn), z);
    const cv::Vec3d p = d * radius(d);
    cloud.points.emplace_back(cv::Vec3f(p));
    if (!normals) continue;
    const cv::Vec3d side = std::abs(d[2]) < 0.8 ? cv::Vec3d(0, 0, 1) : cv::Vec3d(1, 0, 0);
    const cv::Vec3d u = cv::normalize(d.cross(side)), v = d.cross(u);
    const auto at = [&](const cv::Vec3d& e) { return cv::normalize(e) * radius(cv::normalize(e)); };
    const cv::Vec3d n =
        cv::normalize((at(d + 1e-4 * u) - at(d - 1e-4 * u)).cross(at(d + 1e-4 * v) - at(d - 1e-4 * v)));
    cloud.normals.emplace_back(cv::Vec3f(n.dot(d) < 0 ? -n : n));
  }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

/// What a sensor at the origin sees of an object before a wall.
PointCloud seen(const PointCloud& object, const cv::Affine3d& pose) {
  PointCloud scene;
  for (std::size_t i = 0; i < object.points.size(); ++i) {
    const cv::Point3f p = cv::Affine3f(pose) * object.points[i];
    const cv::Point3f n = cv::Affine3f(pose).rotation() * object.normals[i];
    if (n.dot(p) < -0.1F * static_cast<float>(cv::norm(p))) scene.points.push_back(p);
  }
  for (int y = -120; y <= 120; ++y)
    for (int x = -160; x <= 160; ++x)
      scene.points.emplace_back(0.005F * static_cast<float>(x), 0.005F * static_cast<float>(y),
                                1.3F + 0.02F * std::sin(0.1F * static_cast<float>(x)));
  return scene;
}

TEST(RecognitionInNoise, AFilterFromElsewhereSeedsTheSurface) {
  const PointCloud scene = seen(lump(20000, true), cv::Affine3d(cv::Vec3d(), cv::Vec3d(0, 0, 0.9)));
  PointCloud part;  // the left half of it
  for (const cv::Point3f& p : scene.points)
    if (p.x < 0) part.points.push_back(p);
  const Recognizer recognizer(standard);
  const auto whole = recognizer.prepareScene("scene", scene, scene);
  const auto half = recognizer.prepareScene("scene", scene, part);
  EXPECT_LT(half->surface().size(), whole->surface().size() * 6 / 10);
  for (const cv::Point3f& p : half->surface().points()) EXPECT_LT(p.x, 0.01F);
}

TEST(RecognitionInNoise, FindsObjectsThatAreKnownFromAllSides) {
  const cv::Affine3d truth(cv::Vec3d(0.7, -1.1, 0.4), cv::Vec3d(0.05, -0.02, 0.9));
  const PointCloud scene = withGaussianNoise(seen(lump(40000, true), truth), 0.002, 4);
  for (const bool normals : {true, false}) {
    const auto found = findIn(lump(30000, normals), scene);
    ASSERT_EQ(found.size(), 1U) << normals;
    EXPECT_TRUE(isCorrect(poseError(found[0].pose, truth, found[0].center))) << normals;
  }
}

TEST(RecognitionInNoise, AMapOfAllSidesHasNoViewpoint) {
  const cv::Affine3d truth(cv::Vec3d(0.7, -1.1, 0.4), cv::Vec3d(0.4, 0.3, 0.1));
  PointCloud map = lump(30000, false);
  for (cv::Point3f& p : map.points) p = cv::Affine3f(truth) * p;
  for (int y = -140; y <= 140; ++y)  // a floor
    for (int x = -140; x <= 140; ++x)
      map.points.emplace_back(0.005F * static_cast<float>(x), 0.005F * static_cast<float>(y),
                              -0.15F + 0.02F * std::sin(0.1F * static_cast<float>(x)));
  map = withGaussianNoise(map, 0.002, 4);
  // A map begins where the robot did: beside the object, inside of it, under the floor.
  for (const cv::Point3d& origin :
       {cv::Point3d(0, 0, 0), cv::Point3d(truth.translation()), cv::Point3d(0.3, 0.2, -0.6)}) {
    PointCloud scene = map;
    for (cv::Point3f& p : scene.points) p -= cv::Point3f(origin);
    const auto found = findIn(lump(30000, false), scene);
    ASSERT_EQ(found.size(), 1U) << origin;
    const cv::Affine3d there = truth.translate(-cv::Vec3d(origin));
    EXPECT_TRUE(isCorrect(poseError(found[0].pose, there, found[0].center))) << origin;
  }
}

TEST(RecognitionInNoise, HostileCloudsAreErrorsOrGiveNothing) {
  const PointCloud model = lump(20000, false);
  const PointCloud scene = seen(lump(20000, true), cv::Affine3d(cv::Vec3d(), cv::Vec3d(0, 0, 0.9)));
  PointCloud plane, twice = scene, far = scene, behind = scene, tiny;
  for (int i = 0; i < 10000; ++i)
    plane.points.emplace_back(0.005F * static_cast<float>(i % 100), 0.005F * static_cast<float>(i / 100),
                              1.F);
  twice.points.insert(twice.points.end(), scene.points.begin(), scene.points.end());
  for (const float sign : {-1.F, 1.F}) far.points.emplace_back(1e6F * sign, 3e5F, 1e6F);
  behind.points.emplace_back(0.F, 0.F, -1.F);
  for (int i = 0; i < 12; ++i) tiny.points.emplace_back(0.01F * static_cast<float>(i), 0.F, 1.F);
  EXPECT_TRUE(findIn(model, plane).empty());
  EXPECT_EQ(findIn(model, twice).size(), 1U);
  EXPECT_EQ(findIn(model, far).size(), 1U);
  EXPECT_EQ(findIn(model, behind).size(), 1U);
  EXPECT_THROW(findIn(model, tiny), Error);
  EXPECT_THROW(findIn(plane, tiny), Error);
}

}  // namespace
}  // namespace estancia
