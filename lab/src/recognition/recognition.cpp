// SPDX-License-Identifier: Apache-2.0
#include "recognition/recognition.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string_view>
#include <utility>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "recognition/recognition_findings.hpp"
#include "recognition/recognition_stages.hpp"
#include "runner/subjects.hpp"

namespace estancia::experiments {
namespace {

constexpr int recognitionVersion = 4;  // version of the code below: units of another one are computed anew

/// Moves `count` of them, drawn without putting back, to the front; the same on every machine.
template <class T>
void draw(std::vector<T>& from, std::size_t count, std::mt19937_64& random) {
  for (std::size_t i = 0; i < std::min(count, from.size()); ++i)
    std::swap(from[i], from[i + random() % (from.size() - i)]);
  from.resize(std::min(count, from.size()));
}

/// What a search leaves in a unit's cell.
std::string placeOf(const RecognitionExperimentOptions& options, const ModelPairs& pairs, std::size_t filter,
                    std::size_t model) {
  return options.modelFilters[filter] + " " + pairs.models[model].name;
}

/// Begins the measure that ends with why a search failed. Cells may be without: they had none once.
constexpr std::string_view reasonPrefix = "failed: ";

CellResults toResults(const RecognitionExperimentOptions& options, const ModelPairs& pairs,
                      const RecognitionFound& found) {
  CellResults results{{"filter_seconds", "", found.filterSeconds},
                      {"describe_seconds", "", found.describeSeconds}};
  for (const RecognitionSearch& search : found.searches) {
    const std::string at = placeOf(options, pairs, search.modelFilter, search.model);
    results.push_back({"verified", at, search.verified ? 1.0 : 0.0});
    results.push_back({"correct", at, search.correct ? 1.0 : 0.0});
    results.push_back({"extra", at, static_cast<double>(search.extra)});
    results.push_back({"failed", at, search.problem.empty() ? 0.0 : 1.0});
    if (!search.problem.empty()) results.push_back({std::string(reasonPrefix) + search.problem, at, 1});
    results.push_back({"seconds", at, search.seconds});
    results.push_back({"model_seconds", at, search.modelSeconds});
  }
  return results;
}

/// The numbers of one unit.
class UnitReader {
 public:
  explicit UnitReader(const CellResults& results) {
    for (const CellResult& result : results) {
      values_[{result.measure, result.at}] = result.value;
      if (result.measure.starts_with(reasonPrefix))
        reasons_[result.at] = result.measure.substr(reasonPrefix.size());
    }
  }
  double get(const std::string& measure, const std::string& at = "") const {
    const auto found = values_.find({measure, at});
    if (found == values_.end())
      throw Error(
          ErrorCode::corruptFile,
          fmt::format("a cell of the folder has no {} of {}; remove the folder's cells", measure, at));
    return found->second;
  }
  /// Why the search failed; "" where that is not known.
  std::string reason(const std::string& at) const {
    const auto found = reasons_.find(at);
    return found == reasons_.end() ? "" : found->second;
  }

 private:
  std::map<std::string, std::string> reasons_;
  std::map<std::pair<std::string, std::string>, double> values_;
};

/// The experiment's units, and what each adds to.
class Units {
 public:
  Units(const RecognitionExperimentOptions& options, const ModelPairs& pairs)
      : options_(options), pairs_(pairs) {
    results_.presets = options.presets;
    results_.keypoints = options.keypoints;
    results_.descriptors = options.descriptors;
    results_.modelFilters = options.modelFilters;
    results_.noises = options.noises;
    for (const std::string& filter : options.sceneFilters) {
      if (filter == "none")
        results_.sceneFilters.emplace_back(filter, 0);
      else
        for (const std::size_t size : options.sizes) results_.sceneFilters.emplace_back(filter, size);
    }
    const auto absent = absentModels(pairs, options);
    for (std::size_t s = 0; s < pairs.scenes.size(); ++s) {
      std::vector<std::size_t> models;
      for (const ModelPairs::Pair& pair : pairs.pairs)
        if (pair.scene == s) models.push_back(pair.model);
      present_.push_back(models.size());
      models.insert(models.end(), absent[s].begin(), absent[s].end());
      models_.push_back(std::move(models));
    }
    // Scenes innermost: each is filtered once, in the first round, and rounds of one description share
    // models.
    for (std::size_t p = 0; p < options.presets.size(); ++p)
      for (std::size_t k = 0; k < options.keypoints.size(); ++k)
        for (std::size_t d = 0; d < options.descriptors.size(); ++d)
          for (std::size_t f = 0; f < results_.sceneFilters.size(); ++f)
            for (std::size_t n = 0; n < options.noises.size(); ++n) addScenes(p, k, d, f, n);
  }

  const std::vector<RecognitionTask>& tasks() const { return tasks_; }

  std::vector<Cell> cells(const RecognitionWork& work) const {
    std::vector<Cell> cells;
    for (const RecognitionTask& task : tasks_) {
      const RecognitionUnit& u = task.unit;
      std::vector<std::string> names;
      for (const std::size_t model : task.models) names.push_back(pairs_.models[model].name);
      cells.push_back(
          {{u.preset, u.keypoint, u.descriptor, u.sceneFilter, sizeText(u.size), fmt::format("{}", u.noise),
            std::to_string(u.seed), pairs_.scenes[u.scene].name},
           sha256(fmt::format("{} {} {}", recognitionVersion, work.inputs(u), fmt::join(names, "\n")))});
    }
    return cells;
  }

  RecognitionResults aggregate(const std::vector<CellResults>& found) {
    results_.cells.assign(results_.indexOf(results_.presets.size(), 0, 0, 0, 0, 0), {});
    for (std::size_t t = 0; t < tasks_.size(); ++t) add(t, UnitReader(found[t]));
    for (RecognitionCell& cell : results_.cells) {
      const auto pairs = static_cast<double>(std::max<std::size_t>(cell.pairs, 1));
      cell.seconds /= pairs;
      cell.filterSeconds /= pairs;
      cell.modelSeconds /= pairs;
    }
    return results_;
  }

  void addRows(Grid& grid) const {
    for (std::size_t p = 0; p < results_.presets.size(); ++p)
      for (std::size_t k = 0; k < results_.keypoints.size(); ++k)
        for (std::size_t d = 0; d < results_.descriptors.size(); ++d)
          for (std::size_t m = 0; m < results_.modelFilters.size(); ++m)
            for (std::size_t f = 0; f < results_.sceneFilters.size(); ++f)
              for (std::size_t n = 0; n < results_.noises.size(); ++n)
                grid.add({results_.modelFilters[m], results_.sceneFilters[f].first,
                          sizeText(results_.sceneFilters[f].second), fmt::format("{}", results_.noises[n]),
                          results_.keypoints[k], results_.descriptors[d], results_.presets[p]},
                         results_.cells[results_.indexOf(p, k, d, m, n, f)].toResults());
  }

 private:
  struct Place {
    std::size_t preset, keypoint, descriptor, sceneFilter, noise, seed;
  };

  static std::string sizeText(std::size_t size) { return size == 0 ? "all" : std::to_string(size); }

  void addScenes(std::size_t p, std::size_t k, std::size_t d, std::size_t f, std::size_t n) {
    // Without noise all seeds are one.
    const std::size_t seeds = options_.noises[n] > 0 ? options_.seeds.size() : 1;
    for (std::size_t seed = 0; seed < seeds; ++seed)
      for (std::size_t s = 0; s < pairs_.scenes.size(); ++s) {
        tasks_.push_back({{options_.presets[p], options_.keypoints[k], options_.descriptors[d],
                           results_.sceneFilters[f].first, results_.sceneFilters[f].second,
                           options_.noises[n], options_.seeds[seed], s},
                          models_[s]});
        places_.push_back({p, k, d, f, n, seed});
      }
  }

  void add(std::size_t t, const UnitReader& unit) {
    const Place& place = places_[t];
    const RecognitionTask& task = tasks_[t];
    const double filter = unit.get("filter_seconds"), describe = unit.get("describe_seconds");
    for (std::size_t m = 0; m < options_.modelFilters.size(); ++m) {
      RecognitionCell& cell = results_.cells[results_.indexOf(place.preset, place.keypoint, place.descriptor,
                                                              m, place.noise, place.sceneFilter)];
      if (place.seed == cell.seeds) {
        ++cell.seeds;
        cell.correctBySeed.push_back(0);
      }
      for (std::size_t i = 0; i < task.models.size(); ++i) {
        const std::string at = placeOf(options_, pairs_, m, task.models[i]);
        const auto says = [&](const char* measure) { return unit.get(measure, at) != 0; };
        if (says("failed")) {
          ++cell.failed;
          addFailure(unit.reason(at), fmt::format("{} in {}", pairs_.models[task.models[i]].name,
                                                  pairs_.scenes[task.unit.scene].name));
        }
        if (i >= present_[task.unit.scene]) {
          ++cell.absent;
          cell.falsePositives += says("verified");
          continue;
        }
        ++cell.pairs;
        cell.verified += says("verified");
        cell.correct += says("correct");
        cell.extra += static_cast<std::size_t>(unit.get("extra", at));
        cell.correctBySeed.back() += says("correct");
        cell.filterSeconds += filter;
        cell.modelSeconds += unit.get("model_seconds", at);
        cell.seconds += filter + describe + unit.get("seconds", at);
      }
    }
  }

  void addFailure(const std::string& reason, const std::string& search) {
    if (reason.empty()) return;
    auto& all = results_.failures;
    auto known = std::find_if(all.begin(), all.end(), [&](const auto& f) { return f.reason == reason; });
    if (known == all.end()) known = all.insert(known, {reason, search, 0});
    ++known->count;
  }

  const RecognitionExperimentOptions& options_;
  const ModelPairs& pairs_;
  RecognitionResults results_;
  std::vector<std::size_t> present_;              // by scene: models that it holds …
  std::vector<std::vector<std::size_t>> models_;  // … which come first of those that are looked for
  std::vector<RecognitionTask> tasks_;
  std::vector<Place> places_;
};

}  // namespace

std::vector<std::vector<std::size_t>> absentModels(const ModelPairs& pairs,
                                                   const RecognitionExperimentOptions& options) {
  std::mt19937_64 random(options.absentSeed);
  std::vector<std::pair<std::size_t, std::size_t>> all;  // scene, model
  for (std::size_t s = 0; s < pairs.scenes.size(); ++s) {
    std::map<std::string, std::vector<std::size_t>> objects;
    for (std::size_t m = 0; m < pairs.models.size(); ++m)
      if (!pairs.holds(s, pairs.models[m].object)) objects[pairs.models[m].object].push_back(m);
    for (auto& [object, models] : objects) {
      if (options.absent == RecognitionExperimentOptions::Absent::object) draw(models, 1, random);
      for (const std::size_t model : models) all.emplace_back(s, model);
    }
  }
  if (options.absent == RecognitionExperimentOptions::Absent::some) draw(all, options.absentCount, random);
  std::sort(all.begin(), all.end());
  std::vector<std::vector<std::size_t>> byScene(pairs.scenes.size());
  for (const auto& [scene, model] : all) byScene[scene].push_back(model);
  return byScene;
}

GridColumns recognitionColumns() {
  GridColumns columns{{"model_filter", "scene_filter", "size", "noise", "keypoint", "descriptor", "preset"},
                      "",
                      RecognitionCell::measures(),
                      {"model_filter", "scene_filter", "size", "noise", "keypoint", "descriptor"}};
  columns.order.insert(columns.order.end(), columns.measures.begin(), columns.measures.end());
  columns.order.emplace_back("preset");
  return columns;
}

Findings compareRecognitionBy(const RecognitionExperimentOptions& options, const ModelPairs& pairs,
                              RecognitionWork& work, Grid& grid, const ExperimentRun& run,
                              Progress& progress) {
  Units units(options, pairs);
  Grid unitGrid(
      run.folder,
      {{"preset", "keypoint", "descriptor", "scene_filter", "size", "noise", "seed", "scene"}, "", {}},
      run.labeler.threads, run.distribution);
  const auto found = unitGrid.run(
      units.cells(work),
      [&](std::size_t t) { return toResults(options, pairs, work.recognize(units.tasks()[t])); }, progress,
      "recognizing");
  RecognitionResults results = units.aggregate(found);
  results.thesisTables = options.thesisTables;
  units.addRows(grid);

  Findings findings = findingsOf(results);
  std::set<std::string> objects;
  for (const ModelPairs::Model& model : pairs.models) objects.insert(model.object);
  std::size_t absent = 0;
  for (const auto& models : absentModels(pairs, options)) absent += models.size();
  findings.facts.insert(
      findings.facts.begin(),
      {{"Data", fmt::format("{}: {} models of {} objects in {} scenes, {} pairs", options.pairs.string(),
                            pairs.models.size(), objects.size(), pairs.scenes.size(), pairs.pairs.size())},
       {"Verified", "the verification says yes: what the thesis counts as a true positive"},
       {"Correct",
        fmt::format("the best instance lies within {} m and {}° of the true pose, at the model's center",
                    options.translation, options.rotation)},
       {"False positives",
        fmt::format("verified, of {} models looked for in scenes without their objects{}", absent,
                    options.absent == RecognitionExperimentOptions::Absent::all ? " (all there are)"
                    : options.absent == RecognitionExperimentOptions::Absent::object
                        ? fmt::format(" (one an object and scene, seed {})", options.absentSeed)
                        : fmt::format(" (drawn, seed {})", options.absentSeed))},
       {"Noise",
        fmt::format("{}, of standard deviation {} m{}, in the scenes; seeds {}",
                    options.depthNoise ? "of a depth camera" : "Gaussian", fmt::join(options.noises, ", "),
                    options.depthNoise ? " at 1 m" : "", fmt::join(options.seeds, ", "))},
       {"Seconds",
        "a pair on one thread, the scene's filter and description paid by every pair, the models ready"},
       {"Models", fmt::format("filters leave {} points of a model", options.modelPoints)}});
  if (pairs.leftOut > 0)
    findings.notes.push_back(fmt::format(
        "{} pairs were left out, as the list says that their scenes are not there", pairs.leftOut));
  return findings;
}

Findings compareRecognition(const RecognitionExperimentOptions& options, Grid& grid, const ExperimentRun& run,
                            Progress& progress) {
  refuseModels(run, "recognition");
  ModelPairs pairs = readModelPairs(options.pairs, options.columns);
  if (!options.scenes.empty()) pairs = onlyScenes(pairs, options.scenes);
  if (options.clutter.scenes > 0) pairs = withClutter(pairs, options.clutter, run.folder / "clutter");
  RecognitionStages stages(options, pairs, run.folder);
  return compareRecognitionBy(options, pairs, stages, grid, run, progress);
}

}  // namespace estancia::experiments
