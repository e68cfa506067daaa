#include <fmt/format.h>

#include <cmath>

#include "estancia/cloud/filter.hpp"
#include "estancia/core/config.hpp"
#include "estancia/recognition/descriptors.hpp"
#include "estancia/recognition/keypoints.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "experiments/src/recognition/recognition.hpp"
#include "experiments/src/runner/config_lists.hpp"

namespace estancia::experiments {
namespace {

using Options = RecognitionExperimentOptions;

constexpr std::int64_t mostPoints = 100'000'000, mostSeed = 1'000'000'000;

cv::Vec3d readVector(const ConfigFile& config, const toml::node& node) {
  const toml::array& list = config.list(node);
  if (list.size() != 3) config.fail(node, fmt::format("`{}` must be three numbers", config.key()));
  return {config.number(list[0], -1e9, 1e9), config.number(list[1], -1e9, 1e9),
          config.number(list[2], -1e9, 1e9)};
}

Options::Symmetry readSymmetry(ConfigFile& config, const toml::table& table) {
  Options::Symmetry symmetry;
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

void readAbsent(const ConfigFile& config, const toml::node& node, Options& options) {
  if (node.is_integer()) {
    options.absent = Options::Absent::some;
    options.absentCount = static_cast<std::size_t>(config.integer(node, 0, 1'000'000'000));
    return;
  }
  options.absent =
      config.choice(node, std::vector<std::pair<std::string, Options::Absent>>{
                              {"all", Options::Absent::all}, {"one an object", Options::Absent::object}});
}

}  // namespace

RecognitionExperimentOptions readRecognition(ConfigFile& config) {
  Options options;
  const auto text = [&config](std::string& to) { return [&config, &to](auto& n) { to = config.text(n); }; };
  const auto number = [&config](double least, double most) {
    return [&config, least, most](const toml::node& n) { return config.number(n, least, most); };
  };
  const toml::array* symmetries = nullptr;
  config.read(
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"pairs", true, "the CSV of models in scenes", [&](auto& n) { options.pairs = config.anywhere(n); }},
       {"model_column", false, "", text(options.columns.modelColumn)},
       {"pose_column", false, "", text(options.columns.poseColumn)},
       {"scene_files", false, "", text(options.columns.sceneFiles)},
       {"scenes", false, "",
        each(config, options.scenes, [&config](const toml::node& node) { return config.text(node); })},
       {"presets", false, "", each(config, options.presets, oneOf(config, RecognitionOptions::presets()))},
       {"model_filters", false, "", each(config, options.modelFilters, oneOf(config, filterMethods()))},
       {"model_points", false, "",
        [&](auto& n) { options.modelPoints = static_cast<std::size_t>(config.integer(n, 2, mostPoints)); }},
       {"scene_filters", false, "", each(config, options.sceneFilters, oneOf(config, filterMethods()))},
       {"sizes", false, "",
        each(config, options.sizes,
             [&](auto& n) { return static_cast<std::size_t>(config.integer(n, 2, mostPoints)); })},
       {"noises", false, "", each(config, options.noises, number(0, 1000))},
       {"seeds", false, "",
        each(config, options.seeds,
             [&](auto& n) { return static_cast<std::uint64_t>(config.integer(n, 0, mostSeed)); })},
       {"keypoints", false, "", each(config, options.keypoints, oneOf(config, keypointMethods()))},
       {"descriptors", false, "", each(config, options.descriptors, oneOf(config, descriptorMethods()))},
       {"absent", false, "", [&](auto& n) { readAbsent(config, n, options); }},
       {"absent_seed", false, "",
        [&](auto& n) { options.absentSeed = static_cast<std::uint64_t>(config.integer(n, 0, mostSeed)); }},
       {"most_translation", false, "", [&](auto& n) { options.translation = config.number(n, 0, 1000); }},
       {"most_rotation", false, "", [&](auto& n) { options.rotation = config.number(n, 0, 180); }},
       {"symmetry", false, "", [&](auto& n) { symmetries = &config.list(n); }},
       {"kept_mb", false, "", [&](auto& n) {
          options.keptMegabytes = static_cast<std::size_t>(config.integer(n, 0, 10'000'000));
        }}});
  if (symmetries != nullptr)
    for (const toml::node& one : *symmetries)
      options.symmetries.push_back(readSymmetry(config, config.subtable(one)));
  return options;
}

}  // namespace estancia::experiments
