// Bag files: which files are one bag.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/ros/file_bytes.hpp"

namespace estancia::ros {

constexpr std::string_view ros1Magic = "#ROSBAG V2.0\n", mcapMagic{"\x89MCAP0\r\n", 8};
enum class BagFormat { ros1, sqlite, mcap, zstd };

/// By its first bytes.
std::optional<BagFormat> bagFormat(const FileBytes& file);

/// ".db3" of "x_0.db3" and of "x_0.db3.zstd"; "" for names that are no bag's.
std::string bagExtension(const std::filesystem::path& file);

struct BagFiles {
  std::vector<std::filesystem::path> files;
  /// Sentences about what is missing.
  std::vector<std::string> warnings;
};

/// Whether `folder` is a bag: rosbag2's metadata.yaml or files are in it, or nothing but bags of ROS 1.
bool isBagFolder(const std::filesystem::path& folder);

/// The parts of a bag in `folder`: those that its metadata.yaml lists, else all that are there. Throws Error:
/// unsupportedFile when there are none, or of several formats.
BagFiles bagFilesIn(const std::filesystem::path& folder);

}  // namespace estancia::ros
