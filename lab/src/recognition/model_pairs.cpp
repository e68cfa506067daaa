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

/// A model in a scene, as a list has it.
struct PairRow {
  std::string scene, object, model;
  fs::path sceneFile = {}, modelFile = {}, poseFile = {};
  bool isPresent = true;
  std::string at;  ///< FILE:LINE, or a file
};

std::vector<PairRow> rowsOfTable(const fs::path& list, const ModelPairsOptions& options) {
  const CsvTable table(list);
  const auto present = table.find("scene_present");
  std::vector<PairRow> rows;
  for (const io::CsvRow& row : table.rows()) {
    PairRow pair{.scene = table.get(row, "scene"),
                 .object = table.get(row, "object"),
                 .model = table.get(row, options.modelColumn),
                 .isPresent = !present || row.cells[*present] != "0",
                 .at = fmt::format("{}:{}", table.name(), row.line)};
    pair.modelFile = fileBeside(table, row, pair.model);
    if (pair.isPresent) {
      std::string file = options.sceneFiles;
      if (const auto at = file.find("{}"); at != std::string::npos) file.replace(at, 2, pair.scene);
      pair.sceneFile = fileBeside(table, row, file);
      pair.poseFile = fileBeside(table, row, table.get(row, options.poseColumn));
    }
    rows.push_back(std::move(pair));
  }
  return rows;
}

/// A file that a configuration names by its path on the author's disk ("/3D models/…/mario000.ply"): the
/// longest end of the path that is there below a folder around the configuration.
fs::path fileOfConfig(const fs::path& config, const std::string& named) {
  const fs::path path = fs::path(named).relative_path().lexically_normal();
  std::error_code problem;
  for (auto begin = path.begin(); begin != path.end(); ++begin) {
    fs::path end;
    for (auto part = begin; part != path.end(); ++part) end /= *part;
    if (end.begin()->string() == "..") continue;
    for (fs::path around = fs::absolute(config).parent_path(); around.has_relative_path();
         around = around.parent_path())
      if (fs::is_regular_file(around / end, problem)) return around / end;
  }
  throw Error(ErrorCode::fileNotFound, fmt::format("{} names {}, which is in no folder around it",
                                                   io::printable(config.string()), io::printable(named)));
}

/// The pairing as the SHOT data set is published: a file Configscene*.ini a scene, with the models in it.
/// Models are of the object that their folder is named for.
std::vector<PairRow> rowsOfConfigs(const fs::path& folder) {
  std::vector<PairRow> rows;
  for (const fs::path& config : io::filesIn(folder, {".ini"})) {
    if (!config.filename().string().starts_with("Config")) continue;
    std::map<std::string, std::string> values;
    for (const std::string& line : io::readLines(config))
      if (const auto equals = line.find('='); equals != std::string::npos)
        values[std::string(io::trimmed(std::string_view(line).substr(0, equals), " \t"))] =
            io::trimmed(std::string_view(line).substr(equals + 1), " \t\"");
    const auto value = [&](const std::string& key) -> const std::string& {
      const auto found = values.find(key);
      if (found == values.end())
        throw Error(ErrorCode::malformedFile,
                    fmt::format("{} lacks {}", io::printable(config.string()), key));
      return found->second;
    };
    const fs::path scene = fileOfConfig(config, value("PATH"));
    for (std::size_t k = 0; values.contains(fmt::format("MODEL_{}", k)); ++k) {
      const fs::path model = fileOfConfig(config, value(fmt::format("MODEL_{}", k)));
      rows.push_back({.scene = scene.stem().string(),
                      .object = model.parent_path().filename().string(),
                      .model = model.string(),
                      .sceneFile = scene,
                      .modelFile = model,
                      .poseFile = fileOfConfig(config, value(fmt::format("MODEL_{}_GROUNDTRUTH", k))),
                      .at = io::printable(config.string())});
    }
  }
  return rows;
}

ModelPairs collect(const std::vector<PairRow>& rows, const std::string& name) {
  ModelPairs found;
  std::map<std::string, std::size_t> scenes, models;
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> pairs;
  for (const PairRow& row : rows) {
    const auto [known, isNew] = models.emplace(row.model, found.models.size());
    if (isNew) found.models.push_back({row.model, row.object, row.modelFile});
    if (found.models[known->second].object != row.object)
      throw Error(ErrorCode::malformedFile,
                  fmt::format("{}: {} is a model of \"{}\" and in a line above of \"{}\"", row.at,
                              io::printable(row.model), io::printable(row.object),
                              io::printable(found.models[known->second].object)));
    if (!row.isPresent) {
      ++found.leftOut;
      continue;
    }
    const auto [place, isNewScene] = scenes.emplace(row.scene, found.scenes.size());
    if (isNewScene) found.scenes.push_back({row.scene, row.sceneFile});
    const cv::Affine3d pose = readRigid(row.poseFile);
    const auto [pair, isNewPair] = pairs.emplace(std::pair(place->second, known->second), found.pairs.size());
    if (isNewPair) found.pairs.push_back({place->second, known->second, {}});
    found.pairs[pair->second].poses.push_back(pose);
  }
  if (found.pairs.empty())
    throw Error(ErrorCode::insufficientData,
                found.leftOut > 0
                    ? fmt::format("{}: all pairs have scene_present 0", name)
                    : fmt::format("{}: no pairs; write one line per pair of a scene and a model", name));
  nameModels(found.models);
  return found;
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
  std::error_code problem;
  return fs::is_directory(list, problem) ? collect(rowsOfConfigs(list), io::printable(list.string()))
                                         : collect(rowsOfTable(list, options), io::printable(list.string()));
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
