// Frame list: a CSV that names the rows of a matrix file, with time stamps, poses and rooms.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

#include "estancia/core/frame.hpp"

namespace estancia::io {

/// Reads a CSV with a header that has the column `image` and may have timestamp, x, y, z, qx, qy, qz, qw (all
/// seven, or none) and room; other columns are ignored, empty cells are unknown. Without such a header: one
/// name per line. Throws Error `FILE:LINE: …`, also on repeated names.
std::vector<Frame> readFrameList(const std::filesystem::path& file);

/// The text of such a CSV, every number with all digits.
std::string frameListText(const std::vector<Frame>& frames);

/// Refuses repeated names.
class UniqueNames {
 public:
  /// Throws Error `FILE:LINE: …` that names both lines.
  void add(const std::string& name, const std::filesystem::path& file, std::size_t line);

 private:
  std::unordered_map<std::string, std::size_t> lines_;
};

}  // namespace estancia::io
