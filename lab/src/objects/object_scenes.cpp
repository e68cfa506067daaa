// SPDX-License-Identifier: Apache-2.0
#include "objects/object_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "estancia/core/ascii.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/files.hpp"
#include "estancia/readers/object_view_formats.hpp"
#include "findings/csv_table.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

/// Names of folders and files.
bool isPlain(const std::string& name) {
  return !name.empty() &&
         std::ranges::all_of(name, [](char c) { return isLetterOrDigit(c) || c == '-' || c == '_'; });
}

}  // namespace

std::vector<ObjectScene> readObjectScenes(const fs::path& folder, std::vector<std::string>* problems) {
  const CsvTable table(folder / "index.csv");
  const auto category = table.find("category");
  std::vector<ObjectScene> scenes;
  std::set<std::string> seen;
  io::LeftOut leftOut;
  for (const io::CsvRow& row : table.rows()) {
    const std::string &split = table.get(row, "split"), &number = table.get(row, "n");
    if (!isPlain(split) || !isPlain(number))
      table.fail(row, "`split` and `n` may hold letters, digits, - and _");
    ObjectScene scene;
    scene.name = split + number;
    if (category) scene.category = io::printable(row.cells[*category]);
    if (!seen.insert(scene.name).second) table.fail(row, fmt::format("the scene {} is repeated", scene.name));
    const auto path = [&](const char* end) { return folder / split / (scene.name + end); };
    scene.image = path("_rgb.jpg");
    scene.depth = path("_depth.png");
    scene.mask = path("_label.png");
    const std::array<const fs::path*, 3> files = {&scene.image, &scene.depth, &scene.mask};
    const auto missing =
        std::ranges::find_if(files, [](const fs::path* f) { return !fs::is_regular_file(*f); });
    if (missing == files.end())
      scenes.push_back(std::move(scene));
    else
      leftOut.add(fmt::format("{} is missing", io::printable((*missing)->string())));
  }
  const std::string sentence = leftOut.none() ? "" : leftOut.sentence(seen.size(), "scenes");
  if (scenes.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: no scene{}", table.name(), sentence.empty() ? "" : "; " + sentence));
  if (problems != nullptr && !sentence.empty()) problems->push_back(sentence);
  return scenes;
}

cv::Mat readObjectMask(const fs::path& file) {
  constexpr int parts = 10, firstObject = 2;
  const cv::Mat labels = io::readLabelImage(file);
  cv::Mat objects(labels.size(), CV_32S);
  for (int v = 0; v < labels.rows; ++v)
    for (int u = 0; u < labels.cols; ++u) {
      const int object = labels.at<uchar>(v, u) / parts;
      objects.at<int>(v, u) = object < firstObject ? 0 : object;
    }
  return objects;
}

}  // namespace estancia::experiments
