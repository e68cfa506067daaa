// RGB-D images of scenes in which every object is marked.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/camera.hpp"

namespace estancia::experiments {

struct ObjectScene {
  std::string name, category;  ///< category "" where unknown
  std::filesystem::path image, depth, mask;
};

/// The list index.csv of a folder with a column `split` and one `n`:
/// SPLIT/SPLITN_{rgb.jpg,depth.png,label.png} (Multi-Object Scene Dataset; index.csv: `split,n,category,…`).
/// Scenes whose files are not there are left out, told in `problems`. Throws Error `file:line: …` on missing
/// columns, and when no scene is there.
std::vector<ObjectScene> readObjectScenes(const std::filesystem::path& folder,
                                          std::vector<std::string>* problems = nullptr);

/// CV_32S, 0 where there is no object, else the object's number: 8-bit marks of `10 · object + part`, in
/// which objects count from 2 (0: nothing, 1: the support). Throws Error when it cannot be read.
cv::Mat readObjectMask(const std::filesystem::path& file);

}  // namespace estancia::experiments
