// SPDX-License-Identifier: Apache-2.0
#include "recognition/model_pairs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "estancia/core/error.hpp"
#include "estancia/files/files.hpp"
#include "findings/csv_table.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t maxPoseBytes = 1 << 16;

cv::Affine3d readRigid(const fs::path& file) {
  const auto fail = [&](const std::string& why) {
    throw Error(
        ErrorCode::malformedFile,
        fmt::format("{}: {}; give 16 numbers, the row-major 4×4 matrix of a rotation and a translation [m]",
                    io::printable(file.string()), why));
  };
  std::string text = io::readBytes(file, maxPoseBytes);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r' || c == ','; }, ' ');
  std::vector<double> numbers;
  for (const std::string_view word : io::wordsOf(text)) {
    const auto number = io::toNumber(word);
    if (!number || !std::isfinite(*number))
      fail(fmt::format("\"{}\" is not a finite number", io::printable(word.substr(0, 40))));
    numbers.push_back(*number);
  }
  if (numbers.size() != 16) fail(fmt::format("{} numbers", numbers.size()));
  const cv::Matx44d matrix(numbers.data());
  const cv::Matx33d rotation = matrix.get_minor<3, 3>(0, 0);
  constexpr double tolerance = 1e-3;  // files have few digits
  if (cv::norm(rotation * rotation.t() - cv::Matx33d::eye()) > tolerance || cv::determinant(rotation) < 0)
    fail("no rotation matrix");
  if (cv::norm(matrix.row(3) - cv::Matx14d(0, 0, 0, 1)) > tolerance) fail("the last row must be 0 0 0 1");
  return cv::Affine3d(matrix);
}

/// A file beside the list.
fs::path fileBeside(const CsvTable& list, const io::CsvRow& row, const std::string& name) {
  fs::path file = list.file().parent_path() / name;
  std::error_code problem;
  if (!fs::is_regular_file(file, problem))
    list.fail(row, fmt::format("no such file: {}", io::printable(file.string())));
  return file;
}

/// Models are named by their file names, or by their paths in the list where two files have the same name.
void nameModels(std::vector<ModelPairs::Model>& models) {
  std::map<std::string, std::size_t> uses;
  for (const auto& model : models) ++uses[fs::path(model.name).stem().string()];
  for (auto& model : models)
    if (const std::string stem = fs::path(model.name).stem().string(); uses[stem] == 1) model.name = stem;
}

}  // namespace

OptionGroup declare(ModelPairsOptions& o) {
  OptionGroup group("model-pairs", "How to read a list of object models in scenes.");
  group.add("model-column", &o.modelColumn, "Column with the files of models");
  group.add("pose-column", &o.poseColumn, "Column with the files of poses");
  group.add("scene-files", &o.sceneFiles, "File of a scene; {} is its name in the list");
  return group;
}

bool ModelPairs::holds(std::size_t scene, const std::string& object) const {
  return std::any_of(pairs.begin(), pairs.end(), [&](const Pair& pair) {
    return pair.scene == scene && models[pair.model].object == object;
  });
}

ModelPairs readModelPairs(const fs::path& list, const ModelPairsOptions& options) {
  const CsvTable table(list);
  const auto present = table.find("scene_present");
  ModelPairs found;
  std::map<std::string, std::size_t> scenes, models;
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> pairs;
  for (const io::CsvRow& row : table.rows()) {
    const std::string& scene = table.get(row, "scene");
    const std::string& object = table.get(row, "object");
    const std::string& model = table.get(row, options.modelColumn);
    const auto [known, isNew] = models.emplace(model, found.models.size());
    if (isNew) found.models.push_back({model, object, fileBeside(table, row, model)});
    if (found.models[known->second].object != object)
      table.fail(row,
                 fmt::format("{} is a model of \"{}\" and in a line above of \"{}\"", io::printable(model),
                             io::printable(object), io::printable(found.models[known->second].object)));
    if (present && row.cells[*present] == "0") {
      ++found.leftOut;
      continue;
    }
    const auto [place, isNewScene] = scenes.emplace(scene, found.scenes.size());
    if (isNewScene) {
      std::string file = options.sceneFiles;
      if (const auto at = file.find("{}"); at != std::string::npos) file.replace(at, 2, scene);
      found.scenes.push_back({scene, fileBeside(table, row, file)});
    }
    const cv::Affine3d pose = readRigid(fileBeside(table, row, table.get(row, options.poseColumn)));
    const auto [pair, isNewPair] = pairs.emplace(std::pair(place->second, known->second), found.pairs.size());
    if (isNewPair) found.pairs.push_back({place->second, known->second, {}});
    found.pairs[pair->second].poses.push_back(pose);
  }
  if (found.pairs.empty())
    throw Error(
        ErrorCode::insufficientData,
        found.leftOut > 0
            ? fmt::format("{}: all pairs have scene_present 0", table.name())
            : fmt::format("{}: no pairs; write one line per pair of a scene and a model", table.name()));
  nameModels(found.models);
  return found;
}

ModelPairs onlyScenes(const ModelPairs& pairs, const std::vector<std::string>& names) {
  ModelPairs chosen{.scenes = {}, .models = pairs.models, .pairs = {}, .leftOut = pairs.leftOut};
  for (const std::string& name : names) {
    const auto scene = std::find_if(pairs.scenes.begin(), pairs.scenes.end(),
                                    [&](const ModelPairs::Scene& s) { return s.name == name; });
    if (scene == pairs.scenes.end())
      throw Error(ErrorCode::unknownName, fmt::format("unknown scene \"{}\"", io::printable(name)));
    for (ModelPairs::Pair pair : pairs.pairs) {
      if (pair.scene != static_cast<std::size_t>(scene - pairs.scenes.begin())) continue;
      pair.scene = chosen.scenes.size();
      chosen.pairs.push_back(std::move(pair));
    }
    chosen.scenes.push_back(*scene);
  }
  return chosen;
}

}  // namespace estancia::experiments
