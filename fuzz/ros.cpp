// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "estancia/core/error.hpp"
#include "estancia/ros/bag.hpp"
#include "estancia/ros/messages.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

using namespace ros;

/// All messages, as a reader of the bag would.
static void readAll(const std::string& name, std::string_view bytes) {
  const std::unique_ptr<Bag> bag = openBag(inputFile(name, bytes));
  unsigned sum = 0;
  for (std::size_t i = 0; i < bag->messages().size(); ++i) {
    try {
      for (const std::byte byte : bag->read(i).bytes) sum += std::to_integer<unsigned>(byte);
    } catch (const Error&) {  // others may still be readable
    }
  }
  if (sum == 1) inputFile("sum", "1");  // the sum is not left out
}

FUZZ_TARGET(ros, bag_ros1) {
  readAll("input.bag", bytes);
}

FUZZ_TARGET(ros, bag_mcap) {
  readAll("input.mcap", bytes);
}

FUZZ_TARGET(ros, bag_sqlite) {
  readAll("input.db3", bytes);
}

/// A folder of rosbag2: its metadata, and two bags.
FUZZ_TARGET(ros, bag_folder) {
  const auto files = parts(bytes, 3);
  const std::filesystem::path bag = folder() / "bag";
  std::filesystem::create_directories(bag);
  inputFile("bag/metadata.yaml", files[0]);
  inputFile("bag/bag_0.mcap", files[1]);
  inputFile("bag/bag_1.db3", files[2]);
  openBag(bag);
}

/// The first byte chooses encoding and type.
FUZZ_TARGET(ros, messages) {
  if (bytes.empty()) return;
  const auto choice = static_cast<unsigned char>(bytes.front());
  const SerializedMessage message{std::as_bytes(std::span(bytes.substr(1))),
                                  (choice & 1) != 0 ? Encoding::cdr : Encoding::ros1};
  static constexpr std::array poses{"nav_msgs/Odometry", "geometry_msgs/PoseStamped",
                                    "geometry_msgs/PoseWithCovarianceStamped",
                                    "geometry_msgs/TransformStamped", "tf2_msgs/TFMessage"};
  switch (const unsigned type = (choice >> 1) % 11; type) {
    case 0:
      readHeader(message);
      break;
    case 1:
      readImageMessage(message);
      break;
    case 2:
      readCompressedImage(message);
      break;
    case 3:
      readCameraInfo(message);
      break;
    case 4:
      readPointCloud(message);
      break;
    case 5:
      readString(message);
      break;
    default:
      readPoses(message, poses.at(type - 6));
  }
}

}  // namespace estancia::fuzz
