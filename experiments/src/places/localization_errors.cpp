// SPDX-License-Identifier: Apache-2.0
#include "experiments/src/places/localization_errors.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/label/model.hpp"
#include "estancia/label/record.hpp"
#include "estancia/topology/localizer.hpp"
#include "experiments/src/findings/pivot.hpp"
#include "experiments/src/places/mapped_drive.hpp"
#include "experiments/src/runner/config_lists.hpp"

namespace estancia::experiments {
namespace {

constexpr int localizationErrorsVersion = 1;  // of what follows: cells of another one are computed anew
const std::string nearestImage = "nearest image", believedImage = "believed image";

std::string answerAfter(std::size_t lookahead) {
  return fmt::format("{}, {} frames later", believedImage, lookahead);
}

void add(CellResults& results, const std::string& answer, const LocalizationAccuracy& all,
         const Accuracy& accuracy, const std::optional<double>& nodeRoom) {
  results.push_back({"frames", answer, static_cast<double>(all.frames)});
  results.push_back({"judged", answer, static_cast<double>(all.judgedFrames)});
  for (const auto& [measure, value] : {std::pair{"recall", accuracy.recall},
                                       {"room", accuracy.room},
                                       {"node_room", nodeRoom},
                                       {"median_error", accuracy.medianError}})
    if (value) results.push_back({measure, answer, *value});
}

CellResults findAgain(const LocalizationErrorsOptions::Drive& drive, const LocalizationErrorsOptions& options,
                      Labeler& labeler, const std::string& model, const ExperimentRun& run,
                      Progress& progress) {
  const auto record = [&](const SequenceSource& source) {
    const auto images = openImages(source);
    return labelAll(*images, labeler, fmt::format("{}: labeling {}", model, images->name()),
                    {.cache = run.cache}, progress);
  };
  const ScratchMap file(record(drive.mapped.images), run.folder / ".map.estancia");
  const auto map =
      std::make_shared<const LocalizerMap>(readLocalizerMap(file.path(), LocalizerOptions{}.maxImages));
  const DescriptorSequence queries = record(drive.again);
  const AdmissibleImages truth = drive.truth.empty() ? AdmissibleImages{} : readAdmissibleImages(drive.truth);
  CellResults results;
  const LocalizationAccuracy causal = findDrive(queries, map, 0, truth);
  add(results, nearestImage, causal, causal.nearestImage, causal.nodeRoom);
  add(results, believedImage, causal, causal.belief, causal.beliefNodeRoom);
  for (const std::size_t lookahead : options.lookaheads) {
    const LocalizationAccuracy later = findDrive(queries, map, lookahead, truth);
    add(results, answerAfter(lookahead), later, later.belief, later.beliefNodeRoom);
  }
  return results;
}

LocalizationErrorsOptions::Drive readPair(ConfigFile& config, const toml::table& table) {
  LocalizationErrorsOptions::Drive drive;
  const toml::table* again = nullptr;
  drive.mapped =
      readNamedDrive(config, table,
                     {{"truth", false, "CSV query,refs", [&](auto& n) { drive.truth = config.anywhere(n); }},
                      {"again", true, "the drive to find", [&](auto& n) { again = &config.subtable(n); }}});
  drive.again = drive.mapped.images;  // the same but for its labels
  config.read(*again, sourceKeys(config, drive.again, false));
  return drive;
}

}  // namespace

LocalizationErrorsOptions readLocalizationErrors(ConfigFile& config) {
  LocalizationErrorsOptions options;
  const toml::array* drives = nullptr;
  config.read({{"type", true, "the kind of experiment", [](auto&) {}},
               {"models", false, "the models to compare",
                each(config, options.models, [&config](const toml::node& n) { return config.text(n); })},
               {"lookaheads", false, "frames that an answer waits for",
                each(config, options.lookaheads,
                     [&config](const toml::node& n) {
                       return static_cast<std::size_t>(config.integer(n, 1, 1'000'000));
                     })},
               {"drive", true, "[[drive]] names a drive to map, [drive.again] the one to find",
                [&](auto& n) { drives = &config.list(n); }}});
  for (const toml::node& node : *drives) options.drives.push_back(readPair(config, config.subtable(node)));
  return options;
}

GridColumns localizationErrorsColumns() {
  return {{"model", "drive"}, "answer", {"frames", "judged", "recall", "room", "node_room", "median_error"}};
}

Findings compareLocalization(const LocalizationErrorsOptions& options, Grid& grid, const ExperimentRun& run,
                             Progress& progress) {
  std::vector<std::string> notes;
  const auto models = modelsToCompare(options.models, run, notes);
  std::vector<NamedDrive> mapped;
  for (const auto& drive : options.drives) mapped.push_back(drive.mapped);
  LocalizationErrorsResults results;
  results.drives = namesIn(presentDrives(mapped, notes));
  results.models = namesIn(models);
  results.answers = {nearestImage, believedImage};
  for (const std::size_t lookahead : options.lookaheads) results.answers.push_back(answerAfter(lookahead));
  std::vector<const LocalizationErrorsOptions::Drive*> drives;
  std::vector<std::string> digests;
  for (const auto& drive : options.drives)
    if (std::ranges::count(results.drives, drive.mapped.name) > 0) {
      drives.push_back(&drive);
      digests.push_back(digestOf(drive.mapped.images) + digestOf(drive.again) +
                        (drive.truth.empty() ? "" : sha256OfFile(drive.truth)));
    }
  results.cells.resize(drives.size() * models.size());
  std::vector<std::pair<std::string, std::string>> identities;
  for (std::size_t m = 0; m < models.size(); ++m) {
    const auto labeler = loadModel(models[m].model, run.labeler);
    identities.emplace_back("Model", labeler->identity());
    std::vector<Cell> cells;
    for (std::size_t d = 0; d < drives.size(); ++d)
      cells.push_back({{models[m].name, results.drives[d]},
                       sha256(fmt::format("{} {} {} {}", localizationErrorsVersion, labeler->cacheKey(),
                                          digests[d], fmt::join(options.lookaheads, " ")))});
    const auto found = grid.run(
        cells,
        [&](std::size_t d) {
          return findAgain(*drives[d], options, *labeler, models[m].name, run, progress);
        },
        progress, models[m].name);
    for (std::size_t d = 0; d < drives.size(); ++d) results.cells[d * models.size() + m] = found[d];
  }
  Findings findings = findingsOf(results);
  findings.facts = std::move(identities);
  findings.notes = std::move(notes);
  return findings;
}

Findings findingsOf(const LocalizationErrorsResults& results) {
  constexpr auto largest = ResultTable::Best::largest;
  const std::vector<std::pair<std::string, ResultTable::Column>> columns{
      {"frames", {"frames", 0}},
      {"judged", {"with a near image", 0}},
      {"recall", {"recall@1", 3, largest}},
      {"room", {"right room", 3, largest}},
      {"node_room", {"right room, by place", 3, largest}},
      {"median_error", {"median error [m]", 2, ResultTable::Best::smallest}}};
  Findings findings;
  findings.title = "Drives found again";
  for (std::size_t d = 0; d < results.drives.size(); ++d)
    for (std::size_t m = 0; m < results.models.size(); ++m) {
      const CellResults& cell = results.cells[d * results.models.size() + m];
      std::vector<std::pair<std::string, std::string>> rows;
      for (const std::string& answer : results.answers) rows.emplace_back(answer, answer);
      std::vector<Measure<std::string>> measures;
      for (const auto& [name, column] : columns)
        if (std::ranges::any_of(cell, [&, name = name](const CellResult& r) { return r.measure == name; }))
          measures.push_back({column, [&cell, name = name](const std::string& answer) {
                                return valueOf(cell, name, answer);
                              }});
      findings.sections.emplace_back(pivot(
          ResultTable{
              results.models.size() == 1 ? results.drives[d] : results.drives[d] + ", " + results.models[m],
              "Recall@1: the share of the frames that have a near image in the map whose answer "
              "is one. Right room: the share of all frames whose answer stands in their room.",
              "answer",
              {},
              {}},
          rows, measures));
    }
  findings.summary =
      fmt::format("{} drives found in the maps of others with the defaults.", results.drives.size());
  return findings;
}

}  // namespace estancia::experiments
