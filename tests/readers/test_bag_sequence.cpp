// Bags as sequences: drives written by others' programs, and recordings of robots.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/readers/bag_topics.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/readers/undistortion.hpp"
#include "estancia/sequences/sequence.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

constexpr std::size_t driveFrames = 6;

/// The first frames of a drive through a home, as a robot would have recorded them: poses of its body, which
/// the camera is mounted on, at other times than the images.
class BagDrive : public testing::Test {
 protected:
  void SetUp() override {
    const auto home = test::findData("home_a");
    ESTANCIA_NEEDS(home, "home_a is missing");
    modules_ = test::findFetched("test-tools/node_modules");
    ESTANCIA_NEEDS(modules_, "the tests' npm packages are missing; run script/bootstrap");
    folder_ = openSequence(*home / "day");
    describe(*home / "day");
  }

  void describe(const std::filesystem::path& drive) {
    const CameraIntrinsics& camera = *folder_->intrinsics();
    json_ = {{"width", camera.width},
             {"height", camera.height},
             {"matrix", {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1}},
             {"mount", numbersOf(mount_)}};
    for (std::size_t i = 0; i < driveFrames; ++i) {
      const std::string color = scratch_ / fmt::format("color{}", i),
                        depth = scratch_ / fmt::format("depth{}", i);
      const cv::Mat image = folder_->image(i), meters = folder_->depth(i);
      cv::Mat millimeters;
      meters.convertTo(millimeters, CV_16U, 1000);
      test::writeFile(color, {reinterpret_cast<const char*>(image.data), image.total() * image.elemSize()});
      test::writeFile(depth, {reinterpret_cast<const char*>(millimeters.data), millimeters.total() * 2});
      json_["frames"].push_back({{"stamp", stampOf(static_cast<double>(i))},
                                 {"color", color},
                                 {"depth", depth},
                                 {"jpeg", (drive / "rgb" / fmt::format("{:06}.jpg", i)).string()}});
      json_["body"].push_back({{"stamp", stampOf(static_cast<double>(i))}, {"pose", numbersOf(bodyAt(i))}});
    }
  }
  static std::int64_t stampOf(double frame) {
    return 1'700'000'000'000'000'000 + static_cast<std::int64_t>(frame * 1e8);
  }
  cv::Affine3d bodyAt(std::size_t i) const { return rigidOf(*folder_->frame(i).pose) * mount_.inv(); }
  static std::vector<double> numbersOf(const cv::Affine3d& transform) {
    const Pose p = poseOf(transform);
    return {p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw};
  }

  std::filesystem::path write(const std::vector<std::string>& topics) {
    json_["topics"] = topics;
    test::writeFile(scratch_ / "drive.json", json_.dump());
    const auto done =
        test::runProgram("node", {std::string(ESTANCIA_SOURCE_DIR) + "/tests/readers/write_drive.js",
                                  *modules_, scratch_ / "drive.json", scratch_ / "drive.mcap"});
    EXPECT_EQ(done.exitCode, 0) << done.err;
    return scratch_ / "drive.mcap";
  }

  test::ScratchFolder scratch_;
  std::optional<std::filesystem::path> modules_;
  std::unique_ptr<Sequence> folder_;
  nlohmann::json json_;
  const cv::Affine3d mount_ = rigidOf(Pose::planar(0.2, -0.1, 0.3));
};

double farthest(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() ? cv::norm(a, b, cv::NORM_INF) : 1e9;
}

/// What the topics of a bag are used for.
std::map<std::string, std::string> usesOf(const std::filesystem::path& bag) {
  std::map<std::string, std::string> uses;
  for (const TopicSummary& topic : summarizeBag(bag).topics) uses[topic.name] = topic.use;
  return uses;
}

TEST_F(BagDrive, HasTheImagesDepthCameraAndPosesOfTheFolder) {
  const auto bag = openSequence(write({"image", "depth", "odom", "tf_static"}));
  ASSERT_EQ(bag->size(), driveFrames);
  EXPECT_THAT(bag->warnings(), testing::IsEmpty());
  ASSERT_TRUE(bag->intrinsics());
  EXPECT_EQ(bag->intrinsics()->fx, folder_->intrinsics()->fx);
  EXPECT_TRUE(bag->hasDepth());
  for (std::size_t i = 0; i < driveFrames; ++i) {
    EXPECT_EQ(farthest(bag->image(i), folder_->image(i)), 0);
    EXPECT_LT(farthest(bag->depth(i), folder_->depth(i)), 1e-6);
    ASSERT_TRUE(bag->frame(i).pose);
    EXPECT_LT(distanceBetween(*bag->frame(i).pose, *folder_->frame(i).pose), 1e-9);
    EXPECT_LT(angleOf(rigidOf(*bag->frame(i).pose).inv() * rigidOf(*folder_->frame(i).pose)), 1e-7);
    EXPECT_NEAR(*bag->frame(i).timestamp, 1.7e9 + static_cast<double>(i) * 0.1, 1e-6);
  }
}

TEST_F(BagDrive, PosesAreInterpolatedBetweenTransforms) {
  // The body's poses of frames 0 and 2 only: that of frame 1 lies between.
  json_["body"] = {json_["body"][0], json_["body"][2]};
  const auto bag = openSequence(write({"compressed", "tf", "tf_static"}));
  ASSERT_TRUE(bag->frame(1).pose);
  const cv::Vec3d middle = (bodyAt(0).translation() + bodyAt(2).translation()) * 0.5;
  const cv::Affine3d body = rigidOf(*bag->frame(1).pose) * mount_.inv();
  EXPECT_LT(cv::norm(body.translation() - middle), 1e-9);
  EXPECT_FALSE(bag->frame(4).pose);  // 0.2 s after the last one
  EXPECT_FALSE(bag->warnings().empty());
}

TEST_F(BagDrive, OneCameraThatIsRecordedTwiceIsOne) {
  const auto path = write({"image", "compressed", "depth", "odom", "tf_static"});
  auto uses = usesOf(path);
  EXPECT_EQ(uses["/camera/color/image_raw"], "images");
  EXPECT_EQ(uses["/camera/color/image_raw/compressed"], "");
  EXPECT_EQ(uses["/camera/aligned_depth_to_color/image_raw"], "depth");
  EXPECT_EQ(uses["/camera/color/camera_info"], "camera");
  EXPECT_EQ(uses["/odom"], "poses");
  EXPECT_NEAR(summarizeBag(path).duration, 0.5, 1e-6);
}

TEST_F(BagDrive, TopicsAreChosenByName) {
  const auto path = write({"image", "compressed", "depth", "odom", "tf", "tf_static"});
  SequenceOptions options;
  options.imageTopic = "camera/color/image_raw/compressed";
  options.depthTopic = "none";
  options.odomTopic = "none";
  const auto bag = openSequence(path, options);
  EXPECT_EQ(farthest(bag->image(3), folder_->image(3)), 0);
  EXPECT_FALSE(bag->hasDepth());
  EXPECT_FALSE(bag->poseSource());
  options.depthTopic = "/camera/aligned_depth_to_color/image_raw";
  options.odomTopic = "/odom";
  EXPECT_TRUE(openSequence(path, options)->hasDepth());
  EXPECT_TRUE(openSequence(path, options)->poseSource());
  for (const char* topic : {"/front/image", "/odom"}) {
    options.imageTopic = topic;
    EXPECT_THAT([&] { openSequence(path, options); }, test::FailsWith(ErrorCode::unknownName)) << topic;
  }
}

TEST_F(BagDrive, DepthOfACameraOfItsOwnIsSeenFromThatOfTheImages) {
  const auto unplaced = openSequence(write({"image", "odom", "tf_static", "left"}));
  EXPECT_THAT(unplaced->warnings(), testing::SizeIs(1)) << "no transform says where it is";
  EXPECT_EQ(farthest(unplaced->depth(2), folder_->depth(2)), 0);
  const auto path = write({"image", "odom", "tf_static", "left", "beside"});
  const auto bag = openSequence(path);
  EXPECT_THAT(bag->warnings(), testing::IsEmpty());
  EXPECT_EQ(bag->depthTimestamp(2), bag->frame(2).timestamp);
  const CameraIntrinsics& camera = *folder_->intrinsics();
  const cv::Affine3d beside(cv::Matx33d::eye(), cv::Vec3d(-0.1, 0, 0));
  EXPECT_EQ(farthest(bag->depth(2), io::registerDepth(folder_->depth(2), camera, beside, camera)), 0);
  EXPECT_EQ(usesOf(path)["/left/camera_info"], "camera of depth");
}

TEST_F(BagDrive, OfSeveralDepthsOrPosesNoneIsUsedBeforeOneIsChosen) {
  const auto path = write({"image", "odom", "tf_static", "left", "right", "pose"});
  const auto bag = openSequence(path);
  EXPECT_FALSE(bag->hasDepth() || bag->poseSource());
  EXPECT_THAT(bag->warnings(), testing::SizeIs(2));
  SequenceOptions options;
  options.depthTopic = "/right/image_raw";
  options.odomTopic = "/pose";
  const auto chosen = openSequence(path, options);
  EXPECT_TRUE(chosen->hasDepth());
  ASSERT_TRUE(chosen->frame(3).pose);
  EXPECT_NEAR(chosen->frame(3).pose->x, 7 + mount_.translation()[0], 1e-9)
      << "of the robot, not of its camera";
}

TEST_F(BagDrive, ALensIsStraightenedOrItsCalibrationRefused) {
  const auto straight = openSequence(write({"image", "depth"}));
  json_["lens"] = {{"d", {-0.2, 0.05, 0, 0, 0}}};
  const auto bag = openSequence(write({"image", "depth"}));
  EXPECT_NE(bag->intrinsics()->fx, straight->intrinsics()->fx);
  EXPECT_GT(farthest(bag->image(0), straight->image(0)), 0);
  EXPECT_GT(farthest(bag->depth(0), straight->depth(0)), 0);
  EXPECT_NE(bag->fingerprint(0), straight->fingerprint(0));
  json_["lens"]["distortion_model"] = "magic";
  const auto unknown = openSequence(write({"image"}));
  EXPECT_FALSE(unknown->intrinsics());
  EXPECT_FALSE(unknown->warnings().empty());
}

TEST_F(BagDrive, DamagedMessagesAreCountedAndLeftOut) {
  json_["damaged"] = {{"/camera/color/image_raw", "sensor_msgs/msg/Image", "0001"},
                      {"/camera/aligned_depth_to_color/image_raw", "sensor_msgs/msg/Image", "0001"},
                      {"/odom", "nav_msgs/msg/Odometry", "00010000ff"},
                      {"/tf_static", "tf2_msgs/msg/TFMessage", "00010000ffffff0f"}};
  const auto bag = openSequence(write({"image", "depth", "odom", "tf_static"}));
  EXPECT_EQ(bag->size(), driveFrames);
  EXPECT_THAT(bag->warnings(), testing::SizeIs(4)) << "images, depth, transforms, poses";
  EXPECT_EQ(farthest(bag->depth(1), folder_->depth(1)), 0);
  EXPECT_TRUE(bag->frame(1).pose);
}

TEST_F(BagDrive, WithoutATransformTheCameraLooksAhead) {
  const auto bag = openSequence(write({"image", "odom"}));
  EXPECT_FALSE(bag->warnings().empty());
  ASSERT_TRUE(bag->frame(2).pose);
  const std::array<double, 3> forward = bag->frame(2).pose->forward();
  const cv::Vec3d bodyX = bodyAt(2).rotation() * cv::Vec3d(1, 0, 0);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(forward[static_cast<std::size_t>(i)], bodyX[i], 1e-9);
}

TEST_F(BagDrive, WhatIsNotThereOrDamagedIsSaid) {
  EXPECT_THAT(
      [&] {
        openSequence(write({"odom", "tf_static"}));
      },
      test::FailsWith(ErrorCode::insufficientData));
  const auto path = write({"image", "depth", "odom", "tf_static"});
  const std::string whole = test::readFile(path);
  test::writeFile(path, whole.substr(0, whole.size() * 3 / 4));
  const auto bag = openSequence(path);
  EXPECT_LT(bag->size(), driveFrames);
  ASSERT_GT(bag->size(), 0U);
  EXPECT_FALSE(bag->warnings().empty());
  EXPECT_EQ(farthest(bag->image(0), folder_->image(0)), 0);
}

TEST(BagRecordings, SeveralCamerasAskForAChoice) {
  const auto data = test::findData("robot_bags");
  ESTANCIA_NEEDS(data, "no robot_bags");
  const auto office = *data / "camera/office_fisheye_ros1.bag";
  EXPECT_THAT([&] { openSequence(office); }, test::FailsWith(ErrorCode::insufficientData));
  SequenceOptions options;
  options.imageTopic = "/camera/fisheye2/image_raw";
  const auto sequence = openSequence(office, options);
  ASSERT_EQ(sequence->size(), 3U);
  EXPECT_EQ(sequence->image(2).size(), cv::Size(848, 800));
  EXPECT_TRUE(sequence->frame(1).pose);
}

}  // namespace
}  // namespace estancia
