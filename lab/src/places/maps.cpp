// SPDX-License-Identifier: Apache-2.0
#include "places/maps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/query/quality.hpp"
#include "places/mapped_drive.hpp"
#include "places/maps_findings.hpp"
#include "runner/config_lists.hpp"
#include "runner/drive_grid.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

constexpr int mapsVersion = 1;  // version of the code below: cells of another one are computed anew

std::string thresholdName(const std::optional<double>& threshold) {
  return threshold ? fmt::format("{}", *threshold) : "auto";
}

LocalizerMap mappedBy(const DescriptorSequence& recording, const MapSetting& setting,
                      const fs::path& folder) {
  const ScratchMap file(recording, folder / ".map.estancia", setting.mapper);
  return readLocalizerMap(file.path(), /*maxImages=*/1);
}

/// What is measured, and what is drawn: nodes by id and room, links by ids.
CellResults measuresOf(const TopologicalMap& map, const std::optional<double>& scoreExtent) {
  const MapQuality quality = evaluate(map, {}, scoreExtent);
  const auto& score = quality.original;
  CellResults results{{"nodes", "", static_cast<double>(quality.nodes)},
                      {"links", "", static_cast<double>(quality.links)},
                      {"transitions", "", static_cast<double>(quality.transitions)}};
  const auto add = [&](const char* measure, const std::optional<double>& value) {
    if (value) results.push_back({measure, "", *value});
  };
  if (quality.rooms) {
    add("v_measure", quality.rooms->vMeasure);
    add("ari", quality.rooms->adjustedRandIndex);
    add("purity", quality.rooms->purity);
  }
  add("edge_precision", quality.edgePrecision);
  add("edge_recall", quality.edgeRecall);
  add("score_a", score.roomPurity);
  add("score_b", score.sparseness);
  add("score_c", score.linkCloseness);
  add("score_d", score.compactness);
  add("score_e", score.spread);
  add("score", score.total);
  const std::vector<Place> places = placesOf(map);
  for (std::size_t n = 0; n < places.size(); ++n) {
    if (!places[n].position) continue;
    const std::string at = fmt::format("{} {}", map.nodes[n].id, places[n].room);
    results.push_back({"node_x", at, (*places[n].position)[0]});
    results.push_back({"node_y", at, (*places[n].position)[1]});
    results.push_back({"node_z", at, (*places[n].position)[2]});
    results.push_back({"node_frames", at, static_cast<double>(map.nodes[n].frames)});
  }
  for (const auto& [a, b] : linksOf(map))
    results.push_back({"link", fmt::format("{} {}", map.nodes[a].id, map.nodes[b].id), 1});
  return results;
}

struct PlanePoint {
  double x = 0, y = 0;
};

/// The image nearest to the median of x and y, the upper one of an even number; `taken` is not empty.
PlanePoint typicalOf(const std::vector<PlanePoint>& taken) {
  const auto median = [&](double PlanePoint::*coordinate) {
    std::vector<double> values;
    for (const PlanePoint& each : taken) values.push_back(each.*coordinate);
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return *middle;
  };
  const double x = median(&PlanePoint::x), y = median(&PlanePoint::y);
  return *std::ranges::min_element(
      taken, {}, [&](const PlanePoint& each) { return std::hypot(each.x - x, each.y - y); });
}

/// The reference's map with each setting, made when it is first asked for.
class ReferenceMaps {
 public:
  explicit ReferenceMaps(const MapsOptions& options) : options_(options) {}

  const LocalizerMap& of(LabeledDrives& labeled, const SequenceSource& reference, std::size_t setting) {
    auto& known = maps_[{labeled.labeler().cacheKey(), setting}];
    if (!known)
      known = std::make_unique<LocalizerMap>(
          mappedBy(labeled.of(reference).recording, options_.settings[setting], labeled.run().folder));
    return *known;
  }

 private:
  const MapsOptions& options_;
  std::map<std::pair<std::string, std::size_t>, std::unique_ptr<LocalizerMap>> maps_;
};

OptionGroup declare(MapsOptions& options) {
  OptionGroup group("maps", "Sequences mapped with many thresholds.");
  group.add("reference", &options.reference, "The sequence in whose map the images of all are found");
  group
      .add("score-extent", &options.scoreExtent,
           "X of the original score; without, the extent of each sequence")
      .unit("m")
      .above(0)
      .automatic("extent of the poses");
  group.add("thesis-tables", &options.thesisTables, "The thesis author's own figures beside, of KTH-IDOL2");
  return group;
}

MapsOptions::Drive readSequence(ConfigFile& config, const toml::table& table) {
  MapsOptions::Drive drive;
  const auto readExtent = [&](const toml::node& node) {
    const toml::array& list = config.list(node);
    if (list.size() != 4) config.fail(node, "`extent` wants XMIN, YMIN, XMAX, YMAX [m]");
    drive.extent.emplace();
    for (std::size_t i = 0; i < 4; ++i) (*drive.extent)[i] = config.number(list[i], -1e6, 1e6);
  };
  drive.itself =
      readNamedDrive(config, table,
                     {{"floor_plan", false, "", [&](auto& n) { drive.floorPlan = config.anywhere(n); }},
                      {"extent", false, "", readExtent}});
  if (drive.extent && drive.floorPlan.empty())
    config.fail(*table.get("extent"), "`extent` of which image? name it by `floor_plan`");
  return drive;
}

/// The preset itself, then its sweep; those that are there already are left out.
void addSettings(ConfigFile& config, const toml::table& table, std::vector<MapSetting>& settings) {
  MapSetting own{"", {}, true};
  std::vector<double> joins, revisits;
  const auto threshold = [&config](const toml::node& n) { return config.number(n, 1e-9, 1e9); };
  config.read(table, {{"preset", true, "\"default\" or \"thesis\"",
                       [&](auto& n) {
                         own.preset = config.text(n);
                         own.mapper = config.choice<MapperOptions>(
                             n, {{"default", {}}, {"thesis", MapperOptions::thesis()}});
                       }},
                      {"tau_join", false, "", each(config, joins, threshold)},
                      {"tau_revisit", false, "", each(config, revisits, threshold)}});
  const auto add = [&settings](const MapSetting& setting) {
    if (std::ranges::none_of(settings,
                             [&](const auto& s) { return s.coordinates() == setting.coordinates(); }))
      settings.push_back(setting);
  };
  add(own);
  const std::size_t join = std::max<std::size_t>(1, joins.size());
  const std::size_t revisit = std::max<std::size_t>(1, revisits.size());
  for (std::size_t i = 0; i < join * revisit; ++i) {
    MapSetting setting{own.preset, own.mapper, false};
    if (!joins.empty()) setting.mapper.tauJoin = joins[i / revisit];
    if (!revisits.empty()) setting.mapper.tauRevisit = revisits[i % revisit];
    add(setting);
  }
}

}  // namespace

std::vector<std::string> MapSetting::coordinates() const {
  return {preset, thresholdName(mapper.tauJoin), thresholdName(mapper.tauRevisit)};
}

MapsOptions readMaps(ConfigFile& config) {
  MapsOptions options;
  const toml::array *sequences = nullptr, *parameters = nullptr;
  config.read(together(
      keysOf(config, declare(options)),
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"models", false, "the models to compare",
        each(config, options.models, [&config](const toml::node& n) { return config.text(n); })},
       {"parameters", true, "[[parameters]] names a `preset`, and thresholds to try",
        [&](auto& n) { parameters = &config.list(n); }},
       {"sequence", true, "[[sequence]] names images", [&](auto& n) { sequences = &config.list(n); }}}));
  for (const toml::node& node : *parameters) addSettings(config, config.subtable(node), options.settings);
  for (const toml::node& node : *sequences)
    options.sequences.push_back(readSequence(config, config.subtable(node)));
  if (!options.reference.empty() && std::ranges::none_of(options.sequences, [&](const auto& drive) {
        return drive.itself.name == options.reference;
      }))
    config.fail(*config.table().get("reference"),
                fmt::format("no [[sequence]] is called \"{}\"", options.reference));
  return options;
}

GridColumns mapsColumns() {
  return {{"model", "sequence", "preset", "tau_join", "tau_revisit"},
          "",
          {"nodes", "links", "transitions", "v_measure", "ari", "purity", "edge_precision", "edge_recall",
           "score_a", "score_b", "score_c", "score_d", "score_e", "score", "found"}};
}

std::optional<double> shareFound(const DescriptorSequence& images, const LocalizerMap& map) {
  std::map<int, std::vector<PlanePoint>> taken;
  for (const MappedFrame& frame : map.map.frames)
    if (frame.pose && map.map.findNode(frame.node) != nullptr)
      taken[frame.node].push_back({frame.pose->x, frame.pose->y});
  if (taken.empty()) return std::nullopt;
  std::vector<std::pair<int, PlanePoint>> nodes;
  for (const auto& [node, points] : taken) nodes.emplace_back(node, typicalOf(points));
  const DescriptorSequence queries = toVocabulary(images, map.map.vocabulary);
  const Distance distance = getDistance(map.map.distance, map.map.vocabulary.layout().parts);
  std::vector<float> embedded(map.map.vocabulary.size());
  std::size_t posed = 0, found = 0;
  for (std::size_t i = 0; i < queries.frames.size(); ++i) {
    if (!queries.frames[i].pose) continue;
    const PlanePoint at{queries.frames[i].pose->x, queries.frames[i].pose->y};
    embed(distance.embedding, queries.descriptors.row(i), embedded, distance.parts);
    const auto byWords = map.bank.nearest(map.bank.compared(embedded), /*except=*/map.bank.size());
    const auto byMeters = std::ranges::min_element(
        nodes, {}, [&](const auto& node) { return std::hypot(node.second.x - at.x, node.second.y - at.y); });
    ++posed;
    if (byWords && map.bank[byWords->slot].id == byMeters->first) ++found;
  }
  if (posed == 0) return std::nullopt;
  return static_cast<double>(found) / static_cast<double>(posed);
}

Findings compareMaps(const MapsOptions& options, Grid& grid, const ExperimentRun& run, Progress& progress) {
  std::vector<NamedDrive> drives;
  std::vector<std::string> variants;
  for (const auto& drive : options.sequences) drives.push_back(drive.itself);
  for (const MapSetting& setting : options.settings)
    variants.push_back(fmt::format("{}", fmt::join(setting.coordinates(), " ")));
  const auto found = std::ranges::find(drives, options.reference, &NamedDrive::name);
  const bool isThere = found != drives.end() && (!found->optional || fs::exists(found->images.path));
  const std::string reference = isThere ? digestOf(found->images) : "";
  const auto grounds = groundsOf(options);
  ReferenceMaps references(options);
  const auto inputs = [&](const NamedDrive&, std::size_t) {
    return fmt::format("{} {} {}", mapsVersion, reference, options.scoreExtent.value_or(0));
  };
  const auto compute = [&](LabeledDrives& labeled, const NamedDrive& drive, std::size_t setting) {
    const DescriptorSequence& recording = labeled.of(drive.images).recording;
    CellResults results =
        measuresOf(mappedBy(recording, options.settings[setting], run.folder).map, options.scoreExtent);
    if (isThere)
      if (const auto share = shareFound(recording, references.of(labeled, found->images, setting)))
        results.push_back({"found", "", *share});
    return results;
  };
  DriveStudy study{options.models, drives, variants, inputs, compute};
  study.coordinates = [&](std::size_t setting) { return options.settings[setting].coordinates(); };
  Findings findings = studyDrives(
      study, [&](const DriveResults& results) { return mapsFindings(options, results, grounds); }, grid, run,
      progress);
  if (!options.reference.empty() && !isThere)
    findings.notes.push_back(
        fmt::format("{}, in whose map the others would be found, is not there", found->images.path.string()));
  return findings;
}

}  // namespace estancia::experiments
