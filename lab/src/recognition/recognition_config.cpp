// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "estancia/cloud/filter.hpp"
#include "estancia/core/config.hpp"
#include "estancia/recognition/descriptors.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "estancia/recognition/surface.hpp"
#include "recognition/recognition.hpp"
#include "runner/config_lists.hpp"

namespace estancia::experiments {
namespace {

constexpr std::int64_t maxPoints = 100'000'000, maxSeed = 1'000'000'000;

cv::Vec3d readVector(const ConfigFile& config, const toml::node& node) {
  const toml::array& list = config.list(node);
  if (list.size() != 3) config.fail(node, fmt::format("`{}` must be three numbers", config.key()));
  return {config.number(list[0], -1e9, 1e9), config.number(list[1], -1e9, 1e9),
          config.number(list[2], -1e9, 1e9)};
}

RecognitionExperimentOptions::Symmetry readSymmetry(ConfigFile& config, const toml::table& table) {
  RecognitionExperimentOptions::Symmetry symmetry;
  config.read(table, {{"model", true, "which model looks the same when it is turned",
                       [&](auto& n) { symmetry.model = config.text(n); }},
                      {"axis", true, "around which axis",
                       [&](auto& n) {
                         symmetry.axis = readVector(config, n);
                         if (cv::norm(symmetry.axis) == 0) config.fail(n, "`axis` is no direction");
                       }},
                      {"point", false, "", [&](auto& n) { symmetry.point = readVector(config, n); }},
                      {"fold", false, "",
                       [&](auto& n) { symmetry.fold = static_cast<int>(config.integer(n, 2, 3600)); }}});
  return symmetry;
}

void readAbsent(const ConfigFile& config, const toml::node& node, RecognitionExperimentOptions& options) {
  if (node.is_integer()) {
    options.absent = RecognitionExperimentOptions::Absent::some;
    options.absentCount = static_cast<std::size_t>(config.integer(node, 0, 1'000'000'000));
    return;
  }
  options.absent =
      config.choice(node, std::vector<std::pair<std::string, RecognitionExperimentOptions::Absent>>{
                              {"all", RecognitionExperimentOptions::Absent::all},
                              {"one an object", RecognitionExperimentOptions::Absent::object}});
}

}  // namespace

OptionGroup declare(RecognitionExperimentOptions& options) {
  OptionGroup group("recognition", "Objects in noise.");
  group.add("model-column", &options.columns.modelColumn, "Column of the models' files");
  group.add("pose-column", &options.columns.poseColumn, "Column of the files of poses");
  group.add("scene-files", &options.columns.sceneFiles, "Files of the scenes, {} is the scene's name");
  group.add("model-points", &options.modelPoints, "Points that filters leave of a model").range(2, maxPoints);
  group.add("absent-seed", &options.absentSeed, "Seed of the choice of absent models").range(0, maxSeed);
  group.add("max-translation", &options.translation, "Largest translation error of a correct pose")
      .unit("m")
      .range(0, 1000);
  group.add("max-rotation", &options.rotation, "Largest rotation error of a correct pose")
      .unit("degrees")
      .range(0, 180);
  group.add("thesis-tables", &options.thesisTables, "The thesis' tables beside, where the pairs are its own");
  group.add("depth-noise", &options.depthNoise,
            "Noises are those of a depth camera [m at 1 m], and 0.8 pixels of a Kinect across");
  group.add("elsewhere", &options.elsewhere, "Move each scene into a frame without a known viewpoint");
  group.add("kept-mb", &options.keptMegabytes, "Size of the cache of filtered clouds")
      .unit("MB")
      .range(0, 1e7);
  return group;
}

RecognitionExperimentOptions readRecognition(ConfigFile& config) {
  RecognitionExperimentOptions options;
  const auto text = [&config](const toml::node& node) { return config.text(node); };
  const auto points = [&config](const toml::node& node) {
    return static_cast<std::size_t>(config.integer(node, 2, maxPoints));
  };
  const auto seed = [&config](const toml::node& node) {
    return static_cast<std::uint64_t>(config.integer(node, 0, maxSeed));
  };
  const auto noise = [&config](const toml::node& node) { return config.number(node, 0, 1000); };
  const toml::array* symmetries = nullptr;
  const toml::table* clutter = nullptr;
  config.read(together(
      keysOf(config, declare(options)),
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"pairs", true, "the CSV of models in scenes", [&](auto& n) { options.pairs = config.anywhere(n); }},
       {"scenes", false, "", each(config, options.scenes, text)},
       {"presets", false, "", each(config, options.presets, oneOf(config, RecognitionOptions::presets()))},
       {"model_filters", false, "", each(config, options.modelFilters, oneOf(config, filterMethods()))},
       {"scene_filters", false, "", each(config, options.sceneFilters, oneOf(config, filterMethods()))},
       {"sizes", false, "", each(config, options.sizes, points)},
       {"noises", false, "", each(config, options.noises, noise)},
       {"seeds", false, "", each(config, options.seeds, seed)},
       {"keypoints", false, "", each(config, options.keypoints, oneOf(config, keypointMethods()))},
       {"descriptors", false, "", each(config, options.descriptors, oneOf(config, descriptorMethods()))},
       {"absent", false, "", [&](auto& n) { readAbsent(config, n, options); }},
       {"clutter", false, "", [&](auto& n) { clutter = &config.subtable(n); }},
       {"symmetry", false, "", [&](auto& n) { symmetries = &config.list(n); }}}));
  if (clutter != nullptr) config.read(*clutter, keysOf(config, declare(options.clutter)));
  if (symmetries != nullptr)
    for (const toml::node& one : *symmetries)
      options.symmetries.push_back(readSymmetry(config, config.subtable(one)));
  return options;
}

}  // namespace estancia::experiments
