// BOP results: estimated poses in the CSV files that the BOP challenge takes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core/affine.hpp>
#include <span>
#include <vector>

namespace estancia::experiments {

struct BopEstimate {
  int scene = 0, image = 0, object = 0;
  /// The larger, the surer.
  double score = 0;
  /// T_camera_model [m]; a file has millimeters.
  cv::Affine3d pose;
  /// Time of all estimates of the image [s]; −1: unknown.
  double seconds = -1;
};

/// Columns scene_id, im_id, obj_id, score, R (9 numbers, row by row), t (3), time. Throws Error when it
/// cannot be written.
void writeBopResults(const std::filesystem::path& file, std::span<const BopEstimate> estimates);

/// With or without the head. Throws Error, with file and line, on what is no such file.
std::vector<BopEstimate> readBopResults(const std::filesystem::path& file);

}  // namespace estancia::experiments
