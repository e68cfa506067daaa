// Object scenes: RGB-D images with a mask of every object (Multi-Object Scene Dataset).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/camera.hpp"

namespace estancia::experiments {

struct ObjectScene {
  /// `category` is "" where unknown.
  std::string name, category;
  std::filesystem::path image, depth, mask;
};

/// Reads index.csv of a folder with the columns `split` and `n`: SPLIT/SPLITN_{rgb.jpg,depth.png,label.png}.
/// Scenes with missing files are left out and reported in `problems`. Throws Error `FILE:LINE: …` on missing
/// columns, and when no scene is left.
std::vector<ObjectScene> readObjectScenes(const std::filesystem::path& folder,
                                          std::vector<std::string>* problems = nullptr);

/// CV_32S, 0 where there is no object, else the object's number, from 8-bit pixels `10 · object + part` with
/// objects from 2 (0: nothing, 1: the support). Throws Error when it cannot be read.
cv::Mat readObjectMask(const std::filesystem::path& file);

}  // namespace estancia::experiments
