// SPDX-License-Identifier: Apache-2.0
#include "places/localization_errors.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/localization/localizer.hpp"
#include "places/mapped_drive.hpp"
#include "runner/config_lists.hpp"

namespace estancia::experiments {
namespace {

// version of the code below: cells of another one are computed anew
constexpr int localizationErrorsVersion = 2;
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
                      LabeledDrives& labeled) {
  const ScratchMap file(labeled.of(drive.mapped.images).recording, labeled.run().folder / ".map.estancia");
  const auto map =
      std::make_shared<const LocalizerMap>(readLocalizerMap(file.path(), LocalizerOptions{}.maxImages));
  const DescriptorSequence& queries = labeled.of(drive.again).recording;
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

}  // namespace

LocalizationErrorsOptions::Drive readDrivePair(ConfigFile& config, const toml::table& table) {
  LocalizationErrorsOptions::Drive drive;
  const toml::table* again = nullptr;
  drive.mapped =
      readNamedDrive(config, table,
                     {{"truth", false, "CSV query,refs", [&](auto& n) { drive.truth = config.anywhere(n); }},
                      {"again", true, "the drive to find", [&](auto& n) { again = &config.subtable(n); }}});
  drive.again = drive.mapped.images;  // equal except for the labels
  config.read(*again, sourceKeys(config, drive.again, false));
  return drive;
}

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
  for (const toml::node& node : *drives)
    options.drives.push_back(readDrivePair(config, config.subtable(node)));
  return options;
}

GridColumns localizationErrorsColumns() {
  return {{"model", "drive"}, "answer", {"frames", "judged", "recall", "room", "node_room", "median_error"}};
}

Findings compareLocalization(const LocalizationErrorsOptions& options, Grid& grid, const ExperimentRun& run,
                             Progress& progress) {
  std::vector<NamedDrive> mapped;
  for (const auto& drive : options.drives) mapped.push_back(drive.mapped);
  const auto pairOf = [&](const NamedDrive& drive) -> const LocalizationErrorsOptions::Drive& {
    return *std::ranges::find(options.drives, drive.name, [](const auto& d) { return d.mapped.name; });
  };
  const auto inputs = [&](const NamedDrive& drive, std::size_t) {
    const auto& [itself, again, truth] = pairOf(drive);
    return fmt::format("{} {} {} {}", localizationErrorsVersion, digestOf(again),
                       truth.empty() ? "" : sha256OfFile(truth), fmt::join(options.lookaheads, " "));
  };
  const auto compute = [&](LabeledDrives& labeled, const NamedDrive& drive, std::size_t) {
    return findAgain(pairOf(drive), options, labeled);
  };
  return studyDrives({options.models, mapped, {""}, inputs, compute}, localizationFindings, grid, run,
                     progress);
}

Findings localizationFindings(const DriveResults& results) {
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
  results.each([&](std::size_t model, std::size_t drive) {
    std::vector<std::pair<std::string, CellResults>> rows;  // by answer
    std::vector<CellResults> cells;
    for (const CellResult& result : results.of(model, drive)) {
      if (rows.empty() || rows.back().first != result.at) rows.push_back({result.at, {}});
      rows.back().second.push_back({result.measure, "", result.value});
    }
    cells.reserve(rows.size());
    for (const auto& row : rows) cells.push_back(row.second);
    findings.sections.emplace_back(
        pivot(ResultTable{results.titleOf(model, drive),
                          "Recall@1: the share of the frames that have a near image in the map whose answer "
                          "is one. Right room: the share of all frames whose answer stands in their room.",
                          "answer",
                          {},
                          {}},
              rows, measuresIn(cells, columns)));
  });
  findings.summary =
      fmt::format("{} drives found in the maps of others with the defaults.", results.drives.size());
  return findings;
}

}  // namespace estancia::experiments
