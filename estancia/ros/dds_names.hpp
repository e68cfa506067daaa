// DDS names: how ROS 2 writes its topics and types in DDS, with checks. The module has its own copy.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace estancia::ros {

/// "rt/camera/image_raw" of "/camera/image_raw". Throws Error (invalidInput) for what is no absolute name.
std::string ddsTopicName(const std::string& topic);

/// "sensor_msgs::msg::dds_::Image_" of "sensor_msgs/Image" or "sensor_msgs/msg/Image". Throws Error
/// (invalidInput) for what is no type of ROS.
std::string ddsTypeName(const std::string& type);

/// The other way; "" for what is no topic of ROS.
std::string rosTopicName(const std::string& ddsTopic);

/// "sensor_msgs/Image", "tf2_msgs/action/LookupTransform_Feedback"; "" for what is no type of ROS.
std::string rosTypeName(const std::string& ddsType);

}  // namespace estancia::ros
