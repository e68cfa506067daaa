// SPDX-License-Identifier: Apache-2.0
#include "estancia/sources/ros_frames.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <thread>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/ros/published_messages.hpp"
#include "estancia/ros/wire.hpp"
#include "estancia/sources/ros_source.hpp"
#include "ros/dds_world.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t rosSecond = 1'000'000'000, rosStart = 1'700'000'000 * rosSecond;
constexpr const char* rosCamera = "camera_optical";

std::vector<std::byte> rosImage(std::int64_t stamp, int gray, const char* frame = rosCamera) {
  return ros::imageMessage(stamp, frame, 64, 48, "mono8", std::vector(64 * 48, static_cast<std::byte>(gray)));
}

std::vector<std::byte> rosDepth(std::int64_t stamp, std::uint16_t millimeters,
                                const char* frame = rosCamera) {
  const std::vector<std::uint16_t> values(64 * 48, millimeters);
  return ros::imageMessage(stamp, frame, 64, 48, "16UC1", std::as_bytes(std::span(values)));
}

void putRosHeader(ros::CdrWriter& writer, std::int64_t stamp, const char* frame) {
  writer.putTime(stamp);
  writer.put(std::string_view(frame));
}

std::vector<std::byte> rosCameraInfo() {
  ros::CdrWriter writer;
  putRosHeader(writer, rosStart, rosCamera);
  writer.put(std::uint32_t{48});
  writer.put(std::uint32_t{64});
  writer.put(std::string_view("plumb_bob"));
  writer.putCount(0);
  for (const double n : {50.0, 0.0, 31.5, 0.0, 50.0, 23.5, 0.0, 0.0, 1.0}) writer.put(n);
  for (int i = 0; i < 9 + 12; ++i) writer.put(0.0);
  return writer.take();
}

void putRosPose(ros::CdrWriter& writer, const Pose& p) {
  for (const double n : {p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw}) writer.put(n);
}

std::vector<std::byte> rosTransform(std::int64_t stamp, const char* parent, const char* child,
                                    const Pose& pose) {
  ros::CdrWriter writer;
  writer.putCount(1);
  putRosHeader(writer, stamp, parent);
  writer.put(std::string_view(child));
  putRosPose(writer, pose);
  return writer.take();
}

std::vector<std::byte> rosOdometry(std::int64_t stamp, double x) {
  ros::CdrWriter writer;
  putRosHeader(writer, stamp, "odom");
  writer.put(std::string_view("base"));
  putRosPose(writer, {x});
  for (int i = 0; i < 36 + 6 + 36; ++i) writer.put(0.0);
  return writer.take();
}

TEST(RosFrames, TheNewestImageIsTakenAndTheOthersAreCounted) {
  RosFrames frames({});
  EXPECT_FALSE(frames.newest(1ms));
  for (int i = 0; i < 20; ++i) frames.addImage(rosImage(rosStart + i, 10 * i), "sensor_msgs/Image");
  const auto newest = frames.newest(1s);
  ASSERT_TRUE(newest);
  EXPECT_EQ(newest->image.at<cv::Vec3b>(0, 0)[0], 190);
  EXPECT_EQ(newest->dropped, 19U);
  EXPECT_EQ(newest->frame.name, "1700000000.000000019");
  EXPECT_FALSE(frames.newest(1ms)) << "no frame is given twice";
}

TEST(RosFrames, DepthAndPosesAreWaitedFor) {
  RosFrames frames({.depth = true, .poses = true, .patience = 1h});
  frames.addCamera(rosCameraInfo());
  frames.addImage(rosImage(rosStart, 1), "sensor_msgs/Image");
  EXPECT_FALSE(frames.newest(20ms));
  frames.addDepth(rosDepth(rosStart + rosSecond / 100, 1500), "sensor_msgs/Image");
  EXPECT_FALSE(frames.newest(20ms));
  frames.addTransforms(rosTransform(rosStart, "base", rosCamera, {0, 0, 1}), true);
  frames.addTransforms(rosTransform(rosStart - rosSecond / 10, "odom", "base", {1}), false);
  EXPECT_FALSE(frames.newest(20ms)) << "the transform is too old";
  frames.addTransforms(rosTransform(rosStart + rosSecond / 10, "odom", "base", {2}), false);
  const auto whole = frames.newest(10s);
  ASSERT_TRUE(whole);
  EXPECT_FLOAT_EQ(whole->depth.at<float>(5, 5), 1.5F);
  ASSERT_TRUE(whole->frame.pose);
  EXPECT_NEAR(whole->frame.pose->x, 1.5, 1e-12) << "interpolated";
  EXPECT_NEAR(whole->frame.pose->z, 1, 1e-12);
  EXPECT_EQ(frames.intrinsics()->fx, 50);
}

TEST(RosFrames, DepthOfAnotherCameraIsWhatTheCameraOfTheImagesWouldMeasure) {
  RosFrames frames({.depth = true});
  frames.addCamera(rosCameraInfo());
  frames.addDepthCamera(rosCameraInfo());
  frames.addTransforms(rosTransform(rosStart, rosCamera, "behind", {0, 0, -0.5}), true);
  frames.addDepth(rosDepth(rosStart, 1500, "behind"), "sensor_msgs/Image");
  frames.addImage(rosImage(rosStart, 1), "sensor_msgs/Image");
  const auto frame = frames.newest(10s);
  ASSERT_TRUE(frame);
  EXPECT_NEAR(frame->depth.at<float>(24, 32), 1, 1e-5);
}

TEST(RosFrames, AnImageWhoseDepthAndPoseNeverComeIsGivenWithoutThem) {
  RosFrames frames({.depth = true, .poses = true, .patience = 0s});
  frames.addImage(rosImage(rosStart, 1), "sensor_msgs/Image");
  const auto frame = frames.newest(10s);
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->depth.empty());
  EXPECT_FALSE(frame->frame.pose);
}

TEST(RosFrames, OdometryMovesACameraThatLooksAheadUnlessItIsMountedOtherwise) {
  RosFrames frames({.poses = true});
  frames.addPose(rosOdometry(rosStart, 3), "nav_msgs/Odometry");
  frames.addImage(rosImage(rosStart, 1), "sensor_msgs/Image");
  const auto frame = frames.newest(10s);
  ASSERT_TRUE(frame && frame->frame.pose);
  EXPECT_NEAR(frame->frame.pose->x, 3, 1e-12);
  EXPECT_NEAR(frame->frame.pose->forward()[0], 1, 1e-12);
  frames.addTransforms(rosTransform(rosStart, "base", rosCamera, {0, 0, 1}), true);
  frames.addImage(rosImage(rosStart, 1), "sensor_msgs/Image");
  const auto mounted = frames.newest(10s);
  ASSERT_TRUE(mounted && mounted->frame.pose);
  EXPECT_NEAR(mounted->frame.pose->z, 1, 1e-12);
  EXPECT_NE(mounted->frame.name, frame->frame.name);
}

TEST(RosFrames, MessagesThatCannotBeReadAreToldOf) {
  RosFrames frames({});
  const std::vector<std::byte> rubbish(7, std::byte{1});
  frames.addImage(rubbish, "sensor_msgs/Image");
  EXPECT_NE(frames.trouble(), "");
  frames.addImage(rosImage(rosStart, 1), "sensor_msgs/Image");
  EXPECT_EQ(frames.trouble(), "");
  frames.addCamera(rubbish);
  EXPECT_NE(frames.trouble(), "");
  auto cut = rosImage(rosStart + 1, 1);
  cut.resize(60);  // its header is whole
  frames.addImage(cut, "sensor_msgs/Image");
  frames.newest(0ms);
  EXPECT_NO_THROW(frames.newest(1ms));
}

TEST(RosSource, ATopicBecomesFrames) {
  ESTANCIA_NEEDS_DDS();
  auto robot = ros::makeDdsNode(test::domainOfTest());
  const auto images = robot->publish("/camera/image_raw", "sensor_msgs/Image");
  const auto odometry = robot->publish("/odom", "nav_msgs/Odometry");
  RosSource source("ros2:/camera/image_raw", {}, ros::makeDdsNode(test::domainOfTest()));
  EXPECT_TRUE(source.hasPoses());
  EXPECT_FALSE(source.hasDepth());
  std::optional<LiveFrame> frame;
  int sent = 0;
  ASSERT_TRUE(test::eventually([&] {
    const std::int64_t stamp = rosStart + ++sent * rosSecond / 20;
    odometry->publish(rosOdometry(stamp, 4));
    images->publish(rosImage(stamp, 77));
    frame = source.newest(20ms);
    return frame && frame->frame.pose;
  }));
  EXPECT_EQ(frame->image.at<cv::Vec3b>(3, 3)[1], 77);
  EXPECT_NEAR(frame->frame.pose->x, 4, 1e-12);
}

TEST(RosSource, DepthIsUsedOnceItsCameraIsKnown) {
  ESTANCIA_NEEDS_DDS();
  auto robot = ros::makeDdsNode(test::domainOfTest());
  const auto images = robot->publish("/camera/image_raw", "sensor_msgs/Image");
  const auto depths = robot->publish("/camera/depth", "sensor_msgs/Image");
  const auto camera = robot->publish("/camera/camera_info", "sensor_msgs/CameraInfo");
  const auto transforms = robot->publish("/tf", "tf2_msgs/TFMessage");
  RosSource source("ros2:camera/image_raw", {.depthTopic = "/camera/depth", .odomTopic = "/tf"},
                   ros::makeDdsNode(test::domainOfTest()));
  EXPECT_FALSE(source.hasDepth());
  EXPECT_NE(source.trouble(), "");
  std::optional<LiveFrame> frame;
  int sent = 0;
  ASSERT_TRUE(test::eventually([&] {
    const std::int64_t stamp = rosStart + ++sent * rosSecond / 20;
    camera->publish(rosCameraInfo());
    depths->publish(rosDepth(stamp, 2000));
    transforms->publish(rosTransform(stamp, "odom", rosCamera, {4}));
    images->publish(rosImage(stamp, 77));
    frame = source.newest(20ms);
    return source.hasDepth() && frame && frame->frame.pose && !frame->depth.empty();
  }));
  EXPECT_EQ(source.trouble(), "");
  EXPECT_FLOAT_EQ(frame->depth.at<float>(3, 3), 2);
  EXPECT_NEAR(frame->frame.pose->x, 4, 1e-12);
}

TEST(RosSource, NoSuchTopicNamesThoseThatAreThere) {
  ESTANCIA_NEEDS_DDS();
  auto robot = ros::makeDdsNode(test::domainOfTest());
  const auto images = robot->publish("/front/image_raw", "sensor_msgs/Image");
  const auto failure =
      test::caught([] { RosSource("ros2:/camera/image", {}, ros::makeDdsNode(test::domainOfTest())); });
  EXPECT_EQ(failure.code, ErrorCode::unknownName);
  EXPECT_NE(failure.message.find("/front/image_raw"), std::string::npos);
  EXPECT_EQ(test::caught([] { RosSource("ros2:", {}, ros::makeDdsNode(test::domainOfTest())); }).code,
            ErrorCode::invalidInput);
}

TEST(RosSource, TheDomainIsThatOfRos) {
  setenv("ROS_DOMAIN_ID", "42", 1);
  EXPECT_EQ(rosDomain(), 42);
  for (const char* none : {"kitchen", "4x", "-1", "233"}) {
    setenv("ROS_DOMAIN_ID", none, 1);
    EXPECT_EQ(test::caught([] { rosDomain(); }).code, ErrorCode::invalidOption) << none;
  }
  unsetenv("ROS_DOMAIN_ID");
  EXPECT_EQ(rosDomain(), 0);
}

}  // namespace
}  // namespace estancia
