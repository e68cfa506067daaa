// SPDX-License-Identifier: Apache-2.0
#include "places/revisits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "places/mapped_drive.hpp"

namespace estancia::experiments {
namespace {

constexpr int revisitsVersion = 1;  // version of the code below: cells of another one are computed anew
const std::vector<std::string> knowledgeNames{"with poses", "words alone"};

void appendTo(DescriptorSequence& drive, const DescriptorSequence& more, bool isReversed) {
  for (std::size_t k = 0; k < more.frames.size(); ++k) {
    const std::size_t i = isReversed ? more.frames.size() - 1 - k : k;
    Frame frame = more.frames[i];
    frame.name = fmt::format("{} {}", drive.frames.size(), frame.name);  // another drive may have it, too
    frame.timestamp.reset();
    drive.frames.push_back(std::move(frame));
    drive.descriptors.append(more.descriptors.row(i));
  }
}

CellResults mapAgain(const RevisitsOptions::Drive& drive, bool withPoses, LabeledDrives& labeled) {
  const DescriptorSequence& first = labeled.of(drive.itself.images).recording;
  DescriptorSequence whole{first.vocabulary, first.model, {}, DescriptorMatrix(first.vocabulary.size())};
  appendTo(whole, first, drive.isReversed);
  if (drive.then) appendTo(whole, labeled.of(*drive.then).recording, false);
  const std::vector<Frame> truth = whole.frames;
  if (!withPoses)
    for (Frame& frame : whole.frames) frame.pose.reset();
  const ScratchMap file(whole, labeled.run().folder / ".map.estancia");
  const Revisits found = revisitsIn(truth, readMap(file.path()));
  const auto count = [](std::size_t number) { return static_cast<double>(number); };
  CellResults results{{"frames", "", count(truth.size())},
                      {"back", "", count(found.frames)},
                      {"found", "", count(found.found)},
                      {"decisions", "", count(found.decisions)},
                      {"wrong", "", count(found.wrong)}};
  if (found.frames > 0) results.push_back({"recall", "", count(found.found) / count(found.frames)});
  if (found.decisions > 0)
    results.push_back({"precision", "", 1 - count(found.wrong) / count(found.decisions)});
  if (found.first) results.push_back({"first", "", count(*found.first)});
  if (found.firstFound) results.push_back({"first_found", "", count(*found.firstFound)});
  return results;
}

RevisitsOptions::Drive readRoute(ConfigFile& config, const toml::table& table) {
  RevisitsOptions::Drive drive;
  const toml::table* then = nullptr;
  drive.itself =
      readNamedDrive(config, table,
                     {{"reversed", false, "whether it is driven from its end",
                       [&](auto& n) { drive.isReversed = config.flag(n); }},
                      {"then", false, "a drive that follows", [&](auto& n) { then = &config.subtable(n); }}});
  if (then == nullptr) return drive;
  drive.then = drive.itself.images;  // equal except for the labels
  config.read(*then, sourceKeys(config, *drive.then, true));
  return drive;
}

}  // namespace

bool isNear(const Frame& a, const Frame& b, double meters, double degrees) {
  const auto f = a.pose->forward(), g = b.pose->forward();
  const double cosine = std::clamp(f[0] * g[0] + f[1] * g[1] + f[2] * g[2], -1.0, 1.0);
  return distanceBetween(*a.pose, *b.pose) <= meters && std::acos(cosine) * 180 / std::numbers::pi <= degrees;
}

Revisits revisitsIn(const std::vector<Frame>& frames, const TopologicalMap& map) {
  if (map.frames.size() != frames.size())
    throw Error(ErrorCode::mismatch,
                fmt::format("{} of {} frames were mapped", map.frames.size(), frames.size()));
  for (const Frame& frame : frames)
    if (!frame.pose)
      throw Error(ErrorCode::insufficientData,
                  fmt::format("{}: no true pose to compare with; give one by `poses`", frame.name));
  Revisits result;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    bool wasAway = false, isBack = false, isFound = false, isRight = false;
    for (std::size_t j = i; j-- > 0;) {
      const bool isSame = map.frames[i].node == map.frames[j].node;
      wasAway = wasAway || !isNear(frames[i], frames[j], 1.4, 60);
      isRight = isRight || (isSame && isNear(frames[i], frames[j], 1, 45));
      if (!wasAway || !isNear(frames[i], frames[j], 0.7, 30)) continue;
      isBack = true;
      isFound = isFound || isSame;
    }
    if (map.decisions[i].kind == DecisionKind::revisit) {
      ++result.decisions;
      result.wrong += isRight ? 0 : 1;
    }
    if (!isBack) continue;
    ++result.frames;
    if (!result.first) result.first = i;
    if (!isFound) continue;
    ++result.found;
    if (!result.firstFound) result.firstFound = i;
  }
  return result;
}

RevisitsOptions readRevisits(ConfigFile& config) {
  RevisitsOptions options;
  readDrives(config, options.models, "images with poses",
             [&](const toml::table& table) { options.drives.push_back(readRoute(config, table)); });
  return options;
}

GridColumns revisitsColumns() {
  return {{"model", "drive", "variant"},
          "",
          {"frames", "back", "found", "recall", "decisions", "wrong", "precision", "first", "first_found"}};
}

Findings compareRevisits(const RevisitsOptions& options, Grid& grid, const ExperimentRun& run,
                         Progress& progress) {
  std::vector<NamedDrive> drives;
  for (const auto& drive : options.drives) drives.push_back(drive.itself);
  const auto driveOf = [&](const NamedDrive& named) -> const RevisitsOptions::Drive& {
    return *std::ranges::find(options.drives, named.name, [](const auto& d) { return d.itself.name; });
  };
  const auto inputs = [&](const NamedDrive& named, std::size_t) {
    const RevisitsOptions::Drive& drive = driveOf(named);
    return fmt::format("{} {} {}", revisitsVersion, drive.isReversed,
                       drive.then ? digestOf(*drive.then) : "");
  };
  const auto compute = [&](LabeledDrives& labeled, const NamedDrive& named, std::size_t knowledge) {
    return mapAgain(driveOf(named), knowledge == 0, labeled);
  };
  return studyDrives({options.models, drives, knowledgeNames, inputs, compute}, revisitsFindings, grid, run,
                     progress);
}

Findings revisitsFindings(const DriveResults& results) {
  constexpr auto largest = ResultTable::Best::largest;
  const auto measures = measuresIn(results.cells, {{"frames", {"frames", 0}},
                                                   {"back", {"back", 0}},
                                                   {"found", {"found", 0}},
                                                   {"recall", {"recall", 3, largest}},
                                                   {"decisions", {"said to return", 0}},
                                                   {"wrong", {"wrong", 0}},
                                                   {"precision", {"precision", 3, largest}},
                                                   {"first", {"first back", 0}},
                                                   {"first_found", {"first found", 0}}});
  Findings findings;
  findings.title = "Places known again";
  for (std::size_t v = 0; v < results.variants.size(); ++v) {
    std::vector<std::pair<std::string, CellResults>> rows;
    results.each([&](std::size_t model, std::size_t drive) {
      rows.emplace_back(results.titleOf(model, drive), results.of(model, drive, v));
    });
    findings.sections.emplace_back(
        pivot(ResultTable{results.variants[v],
                          "Back: frames within 0.7 m and 30° of one from before the robot was 1.4 m or 60° "
                          "away; found: their place holds such a one. Wrong: of the decisions to return to a "
                          "place, those where none of its images was taken within 1 m and 45°.",
                          "drive",
                          {},
                          {}},
              rows, measures));
  }
  findings.summary =
      fmt::format("{} drives, mapped with the defaults, and what they knew again.", results.drives.size());
  return findings;
}

}  // namespace estancia::experiments
