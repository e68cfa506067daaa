// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "estancia/ros/dds_names.hpp"
#include "support/errors.hpp"

namespace estancia::ros {
namespace {

using test::FailsWith;

TEST(DdsNames, AreThoseOfRos2) {
  EXPECT_EQ(ddsTopicName("/camera/image_raw"), "rt/camera/image_raw");
  EXPECT_EQ(rosTopicName("rt/camera/image_raw"), "/camera/image_raw");
  EXPECT_EQ(ddsTypeName("sensor_msgs/Image"), "sensor_msgs::msg::dds_::Image_");
  EXPECT_EQ(ddsTypeName("sensor_msgs/msg/Image"), "sensor_msgs::msg::dds_::Image_");
  EXPECT_EQ(ddsTypeName("tf2_msgs/action/Look_Feedback"), "tf2_msgs::action::dds_::Look_Feedback_");
  EXPECT_EQ(rosTypeName("sensor_msgs::msg::dds_::Image_"), "sensor_msgs/Image");
  EXPECT_EQ(rosTypeName("tf2_msgs::action::dds_::Look_Feedback_"), "tf2_msgs/action/Look_Feedback");
}

TEST(DdsNames, WhatIsNotOfRosHasNone) {
  for (const char* topic : {"", "rt", "rt/", "rq/service", "HelloTopic", "rt/a b", "rt//a", "rt/a/", "rt/1a",
                            "rt/a\x1b[31m", "rt\0/a"})
    EXPECT_EQ(rosTopicName(topic), "") << topic;
  for (const char* type :
       {"", "HelloWorld", "a::msg::B_", "a::msg::dds_::B", "a::msg::dds_::_", "::msg::dds_::B_",
        "a::idl::dds_::B_", "a::msg::dds_::B\n_", "a::msg::dds_::B_::C_"})
    EXPECT_EQ(rosTypeName(type), "") << type;
}

TEST(DdsNames, RefusesWhatRosWouldRefuse) {
  for (const char* topic : {"", "/", "camera", "/camera/", "//camera", "/cam era", "/1st", "/a-b"})
    EXPECT_THAT([&] { ddsTopicName(topic); }, FailsWith(ErrorCode::invalidInput)) << topic;
  EXPECT_THAT([] { ddsTopicName("/" + std::string(300, 'a')); }, FailsWith(ErrorCode::invalidInput));
  for (const char* type :
       {"", "Image", "sensor_msgs/", "/Image", "a/b/C", "a/msg/b/C", "a/B;C", "sensor_msgs::Image"})
    EXPECT_THAT([&] { ddsTypeName(type); }, FailsWith(ErrorCode::invalidInput)) << type;
}

}  // namespace
}  // namespace estancia::ros
