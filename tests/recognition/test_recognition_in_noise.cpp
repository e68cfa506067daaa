// The default preset: real scenes as they are and in noise, other units, objects seen from all sides, and
// clouds that need no inspection by hand.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "estancia/cloud/resolution.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/recognition/prepared.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "recognition/made_up_surface.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::isCorrect;
using test::poseError;

const RecognitionOptions standard;

/// A pair of the thesis' data.
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

std::vector<Detection> findIn(const PointCloud& model, const PointCloud& scene) {
  const Recognizer recognizer(standard);
  return recognizer.find(*recognizer.prepareModel("model", model), *recognizer.prepareScene("scene", scene));
}

TEST(RecognitionInNoise, FindsWhatIsThereAndNotWhatIsNot) {
  const auto data = test::findData("shot_kinect");
  ESTANCIA_NEEDS(data, "shot_kinect is not unpacked");
  const Pair mario = pairOf(*data, "mario/mario000.pcd", "scene005.pcd", "scene005-rs1.xf");
  const Recognizer recognizer(standard);
  const auto here = recognizer.prepareModel("here", mario.model);
  const auto notHere =
      recognizer.prepareModel("not here", readCloud(*data / "models" / "frog" / "Frog004.pcd"));
  for (const double noise : {0.0, 0.01}) {
    const auto scene = recognizer.prepareScene("scene", withGaussianNoise(mario.scene, noise, 5));
    EXPECT_NEAR(scene->noise(), std::hypot(noise, 0.0005),
                0.1 * noise + 0.0003);  // the sensor has some itself
    const auto found = recognizer.find(*here, *scene);
    ASSERT_EQ(found.size(), 1U) << noise;
    EXPECT_TRUE(isCorrect(poseError(found[0].pose, mario.truth, found[0].center))) << noise;
    EXPECT_GT(found[0].confidence, 0.5);
    EXPECT_LE(found[0].confidence, 1);
    EXPECT_GT(found[0].inliers, 100U);
    EXPECT_TRUE(recognizer.find(*notHere, *scene).empty()) << noise;
  }
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

TEST(RecognitionInNoise, FindsObjectsThatAreKnownFromAllSides) {
  const cv::Affine3d truth(cv::Vec3d(0.7, -1.1, 0.4), cv::Vec3d(0.05, -0.02, 0.9));
  const PointCloud scene = withGaussianNoise(seen(lump(40000, true), truth), 0.002, 4);
  const auto found = findIn(lump(30000, true), scene);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(isCorrect(poseError(found[0].pose, truth, found[0].center)));
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
  // A map begins where the robot did: here inside of the object.
  for (cv::Point3f& p : map.points) p -= cv::Point3f(cv::Point3d(truth.translation()));
  const auto found = findIn(lump(30000, false), map);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(isCorrect(poseError(found[0].pose, cv::Affine3d(truth.rotation()), found[0].center)));
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
