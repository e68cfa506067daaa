// SPDX-License-Identifier: Apache-2.0
#include "recognition/color_recognition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <mutex>

#include "estancia/cloud/filter.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/recognition/descriptors.hpp"
#include "recognition/color_searches.hpp"
#include "runner/config_lists.hpp"
#include "runner/subjects.hpp"

namespace estancia::experiments {
namespace {

// version of the code below: cells of another one are computed anew
constexpr int colorRecognitionVersion = 1;

using Condition = ColorRecognitionOptions::Condition;

Condition readCondition(ConfigFile& config, const toml::table& table) {
  Condition condition;
  config.read(
      table,
      {{"name", true, "what to call it", [&](auto& n) { condition.name = config.text(n); }},
       {"descriptor", false, "",
        [&](auto& n) { condition.descriptor = oneOf(config, descriptorMethods())(n); }},
       {"scene_filter", false, "",
        [&](auto& n) { condition.sceneFilter = oneOf(config, filterMethods())(n); }},
       {"color_tolerance", false, "", [&](auto& n) { condition.colorTolerance = config.number(n, 0, 300); }},
       {"color_weight", false, "", [&](auto& n) { condition.colorWeight = config.number(n, 0, 1e6); }}});
  return condition;
}

ColorRecognitionOptions::Drive readDrive(ConfigFile& config, const toml::table& table) {
  ColorRecognitionOptions::Drive drive;
  DriveCasesOptions& cases = drive.cases;
  const auto count = [&config](const toml::node& n) {
    return static_cast<std::size_t>(config.integer(n, 1, 1'000'000));
  };
  config.read(table, {{"name", true, "what to call it", [&](auto& n) { drive.name = config.text(n); }},
                      {"path", true, "the folder", [&](auto& n) { cases.path = config.anywhere(n); }},
                      {"instances", false, "", [&](auto& n) { cases.instances = config.flag(n); }},
                      {"every", false, "", [&](auto& n) { cases.every = count(n); }},
                      {"least_pixels", false, "", [&](auto& n) { cases.minPixels = count(n); }},
                      {"models", false, "", [&](auto& n) { cases.models = count(n); }},
                      {"noise", false, "", [&](auto& n) { cases.noise = config.number(n, 0, 1); }}});
  return drive;
}

/// A set of cases, made when it is first needed.
struct Set {
  std::string name, inputs;
  std::function<ColorCases()> make;
  std::shared_ptr<std::once_flag> once = std::make_shared<std::once_flag>();
  std::shared_ptr<ColorCases> cases = std::make_shared<ColorCases>();

  const ColorCases& get() const {
    std::call_once(*once, [&] { *cases = make(); });
    return *cases;
  }
};

Set setOf(const ColorRecognitionOptions::Drive& drive) {
  const DriveCasesOptions& cases = drive.cases;
  return {drive.name,
          fmt::format("{} {} {} {} {} {} {}", digestOf({cases.path, {}}), cases.instances, cases.every,
                      cases.minPixels, cases.noise, cases.seed, cases.models),
          [cases] { return casesOfDrive(cases); }};
}

std::vector<Set> setsOf(const ColorRecognitionOptions& options) {
  std::vector<Set> sets;
  if (options.lookAlikes > 0)
    sets.push_back(
        {"look-alikes", fmt::format("made up {} {}", options.lookAlikes, options.seed),
         [count = options.lookAlikes, seed = options.seed] { return lookAlikeCases(count, seed); }});
  for (const auto& drive : options.drives) sets.push_back(setOf(drive));
  return sets;
}

/// A row a condition, the counts of one part.
ResultTable tableOf(const std::string& set, const std::string& part, const std::vector<Condition>& conditions,
                    const std::vector<CellResults>& found) {
  ResultTable table;
  table.title = set + ": " + part;
  table.caption =
      "Percent of the pairs: a pose within the limits, the right thing, another of the same shape. False "
      "positives: percent of the searches for what is not there.";
  table.rowsAre = "condition";
  using Best = ResultTable::Best;
  table.columns = {{"pairs", 0},
                   {"right pose", 0, Best::largest},
                   {"right thing", 0, Best::largest},
                   {"look-alike", 0, Best::smallest},
                   {"false positives", 0, Best::smallest},
                   {"refused", 0},
                   {"s", 2}};
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    const auto get = [&](const char* measure) { return valueOf(found[c], measure, part).value_or(0); };
    const auto percent = [](double count, double all) { return 100 * count / std::max(all, 1.0); };
    const double pairs = get("pairs"), absent = get("absent");
    table.rows.push_back({conditions[c].name,
                          {pairs, percent(get("correct"), pairs), percent(get("right"), pairs),
                           percent(get("look_alikes"), pairs), percent(get("false_positives"), absent),
                           percent(get("failed"), pairs + absent), get("seconds")}});
  }
  return table;
}

/// All parts of which there are results, in order.
std::vector<std::string> partsOf(const CellResults& results) {
  std::vector<std::string> parts;
  for (const CellResult& result : results)
    if (result.measure == "pairs") parts.push_back(result.at);
  return parts;
}

ResultTable gasTable(const std::string& name, const std::vector<double>& weights,
                     const std::vector<CellResults>& found) {
  ResultTable table;
  table.title = name + ": neural gas by the weight of color";
  table.caption =
      "Root mean squares: distance of the neurons from the surface without noise; difference of the color of "
      "each of its points to that of the nearest neuron (CIELAB).";
  table.rowsAre = "weight";
  table.columns = {
      {"offset [mm]", 2, ResultTable::Best::smallest}, {"color", 2, ResultTable::Best::smallest}, {"s", 2}};
  for (std::size_t w = 0; w < weights.size(); ++w)
    table.rows.push_back(
        {fmt::format("{}", weights[w]),
         {1000 * valueOf(found[w], "offset").value_or(0), valueOf(found[w], "color_difference").value_or(0),
          valueOf(found[w], "seconds").value_or(0)}});
  return table;
}

void compareGases(const ColorRecognitionOptions& options, const ColorRecognitionOptions::Drive& drive,
                  Grid& grid, Progress& progress, Findings& findings) {
  std::vector<Cell> cells;
  for (const double weight : options.colorWeights)
    cells.push_back({{drive.name, fmt::format("gng, color {}", weight)},
                     sha256(fmt::format("gas {} {} {} {}", colorRecognitionVersion, setOf(drive).inputs,
                                        weight, options.points))});
  const auto found = grid.run(
      cells,
      [&](std::size_t i) { return gasErrors(drive.cases, options.colorWeights[i], options.points / 10); },
      progress, "growing gases");
  findings.sections.emplace_back(gasTable(drive.name, options.colorWeights, found));
}

}  // namespace

ColorRecognitionOptions readColorRecognition(ConfigFile& config) {
  ColorRecognitionOptions options;
  OptionGroup group("color-recognition", "Recognition with color.");
  group.add("look-alikes", &options.lookAlikes, "Made-up scenes of each kind").range(0, 1000);
  group.add("points", &options.points, "Neurons of a filtered scene").range(2, 1e8);
  group.add("max-translation", &options.translation, "Largest translation error of a correct pose")
      .unit("m")
      .range(0, 1000);
  group.add("max-rotation", &options.rotation, "Largest rotation error of a correct pose")
      .unit("degrees")
      .range(0, 180);
  group.add("seed", &options.seed, "Seed of scenes and noise").range(0, 1e9);
  config.read(
      together(keysOf(config, std::move(group)),
               {{"type", true, "the kind of experiment", [](auto&) {}},
                {"color_weights", false, "weights of color in a neural gas",
                 each(config, options.colorWeights, [&](auto& n) { return config.number(n, 0, 1e6); })},
                {"condition", true, "what is compared",
                 [&](auto& n) {
                   for (const toml::node& one : config.list(n))
                     options.conditions.push_back(readCondition(config, config.subtable(one)));
                 }},
                {"drive", false, "drives that cases are cut out of", [&](auto& n) {
                   for (const toml::node& one : config.list(n))
                     options.drives.push_back(readDrive(config, config.subtable(one)));
                 }}}));
  for (auto& drive : options.drives) drive.cases.seed = options.seed;
  return options;
}

GridColumns colorRecognitionColumns() {
  return {{"set", "condition"},
          "part",
          {"pairs", "found", "right", "correct", "look_alikes", "absent", "false_positives", "failed",
           "seconds", "scene_seconds", "offset", "color_difference"}};
}

Findings compareColors(const ColorRecognitionOptions& options, Grid& grid, const ExperimentRun& run,
                       Progress& progress) {
  refuseModels(run, "recognition");
  Findings findings;
  findings.title = "Recognition with color";
  for (const Set& set : setsOf(options)) {
    std::vector<Cell> cells;
    for (const Condition& c : options.conditions)
      cells.push_back({{set.name, c.name},
                       sha256(fmt::format("{} {} {} {} {} {} {} {} {}", colorRecognitionVersion, set.inputs,
                                          c.descriptor, c.sceneFilter, c.colorTolerance, c.colorWeight,
                                          options.points, options.translation, options.rotation))});
    const auto found = grid.run(
        cells, [&](std::size_t i) { return searchWith(set.get(), options.conditions[i], options); }, progress,
        "looking for " + set.name);
    for (const std::string& part : partsOf(found.front()))
      findings.sections.emplace_back(tableOf(set.name, part, options.conditions, found));
  }
  for (const auto& drive : options.drives)
    if (drive.cases.noise > 0) compareGases(options, drive, grid, progress, findings);
  findings.summary = fmt::format("{} conditions beside each other.", options.conditions.size());
  findings.facts = {
      {"Halves", "even searches are for choosing, odd ones for reporting"},
      {"Poses", fmt::format("right within {} m and {}°", options.translation, options.rotation)}};
  return findings;
}

}  // namespace estancia::experiments
