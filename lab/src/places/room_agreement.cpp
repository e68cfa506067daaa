// SPDX-License-Identifier: Apache-2.0
#include "places/room_agreement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "estancia/areas/areas.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/readers/home_truth.hpp"
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/zones/zones.hpp"
#include "places/mapped_drive.hpp"
#include "places/reference_areas.hpp"
#include "runner/config_lists.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

constexpr int roomAgreementVersion = 3;  // version of the code below: cells of another one are computed anew

/// A drive that one model has labeled, the rooms that its frames see, and where a map of it may be written.
struct ClusteredDrive {
  const Sequence& images;
  const DescriptorSequence& recording;
  const std::vector<std::string>& seen;
  fs::path scratch;
};

/// The number of a cluster for each frame of the recording.
using Clusters = std::vector<int>;

/// Numbers of names.
Clusters numbered(const std::vector<std::string>& names) {
  std::map<std::string, int> numbers;
  Clusters clusters;
  for (const std::string& name : names)
    clusters.push_back(numbers.emplace(name, static_cast<int>(numbers.size())).first->second);
  return clusters;
}

std::vector<std::string> roomsStoodIn(const DescriptorSequence& recording) {
  std::vector<std::string> rooms;
  for (const Frame& frame : recording.frames) rooms.push_back(frame.room);
  return rooms;
}

std::size_t countOf(std::vector<std::string> names) {
  std::set<std::string> different(names.begin(), names.end());
  different.erase("");
  return different.size();
}

Clusters placesIn(const DescriptorSequence& recording, const fs::path& scratch) {
  const ScratchMap file(recording, scratch);
  Clusters clusters;
  for (const MappedFrame& frame : readMap(file.path()).frames) clusters.push_back(frame.node);
  return clusters;
}

Clusters places(const ClusteredDrive& drive) {
  return placesIn(drive.recording, drive.scratch);
}

Clusters placesWithoutPoses(const ClusteredDrive& drive) {
  return placesIn(withoutPoses(drive.recording), drive.scratch);
}

Clusters zones(const ClusteredDrive& drive) {
  return findZones(drive.recording).zoneOf;
}

Clusters zonesOfRun(const DescriptorSequence& recording) {
  ZoneOptions options;
  options.reach = ZoneOptions::reachOfRun;
  return findZones(recording, options).zoneOf;
}

Clusters zonesOfPosedRun(const ClusteredDrive& drive) {
  return zonesOfRun(drive.recording);
}

Clusters zonesOfUnposedRun(const ClusteredDrive& drive) {
  return zonesOfRun(withoutPoses(drive.recording));
}

Clusters asManyZonesAsRooms(const ClusteredDrive& drive) {
  ZoneOptions options;
  options.count = std::max<std::size_t>(1, countOf(roomsStoodIn(drive.recording)));
  return findZones(drive.recording, options).zoneOf;
}

Clusters areas(const ClusteredDrive& drive) {
  return findAreas(drive.images, drive.recording).zones.zoneOf;
}

/// Voronoi segmentation before its parts are merged: split at all narrow passages.
Clusters areasOfNarrows(const ClusteredDrive& drive) {
  AreaOptions options;
  options.segmentation.mutualVisibility = 1;
  return findAreas(drive.images, drive.recording, options).zones.zoneOf;
}

Clusters morphologicalAreas(const ClusteredDrive& drive) {
  return referenceAreas(drive.images, drive.recording, morphologicalRooms);
}

Clusters distanceTransformAreas(const ClusteredDrive& drive) {
  return referenceAreas(drive.images, drive.recording, distanceTransformRooms);
}

Clusters rooms(const ClusteredDrive& drive) {
  return numbered(roomsStoodIn(drive.recording));
}

Clusters roomsSeen(const ClusteredDrive& drive) {
  return numbered(drive.seen);
}

struct Clustering {
  const char* name;
  const char* explanation;
  Clusters (*of)(const ClusteredDrive& drive);
  bool needsDepth = false;
};

constexpr Clustering clusteringTable[] = {
    {"places", "the places of a map", places},
    {"places-without-poses", "the places of a map of images alone", placesWithoutPoses},
    {"zones-of-run", "zones of a map: words, time and positions", zonesOfPosedRun},
    {"zones-of-run-without-poses", "zones of a map without poses: words and time", zonesOfUnposedRun},
    {"zones", "zones of images in any order", zones},
    {"zones-as-rooms", "zones of images in any order, as many as there are rooms", asManyZonesAsRooms},
    {"areas", "areas: space by depth and poses", areas, true},
    {"areas-critical-lines", "the parts that areas are merged from (Voronoi)", areasOfNarrows, true},
    {"areas-morphological", "space by erosion (Bormann et al. 2016)", morphologicalAreas, true},
    {"areas-distance-transform", "space by thresholds of its width (Bormann et al. 2016)",
     distanceTransformAreas, true},
    {"rooms", "the rooms stood in: what no clustering of the rooms seen can be blamed for", rooms},
    {"rooms-seen", "the rooms seen: what words could tell at best, image by image", roomsSeen},
};

Choices clusterings() {
  Choices choices;
  for (const Clustering& clustering : clusteringTable)
    choices.push_back({clustering.name, clustering.explanation});
  return choices;
}

const Clustering& getClustering(const std::string& name) {
  return *std::ranges::find(clusteringTable, name, [](const Clustering& c) { return std::string(c.name); });
}

/// The rooms that the recorded frames see; "" where unknown.
std::vector<std::string> seenIn(const NamedDrive& drive, const DescriptorSequence& recording) {
  std::vector<std::string> images;
  for (const Frame& frame : recording.frames) images.push_back(frame.name);
  if (!io::hasHomeTruth(drive.images.path)) return std::vector<std::string>(images.size());
  return io::roomsSeen(drive.images.path, images);
}

void add(CellResults& results, const std::string& prefix, const NamedAgreement& measured) {
  if (!measured.agreement) return;
  results.push_back({prefix + "v_measure", "", measured.agreement->vMeasure});
  results.push_back({prefix + "ari", "", measured.agreement->adjustedRandIndex});
  results.push_back({prefix + "purity", "", measured.agreement->purity});
}

CellResults measure(const Clusters& clusters, const std::vector<std::string>& stoodIn,
                    const std::vector<std::string>& seen) {
  std::size_t judged = 0, elsewhere = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i].empty() || stoodIn[i].empty()) continue;
    ++judged;
    elsewhere += seen[i] != stoodIn[i] ? 1 : 0;
  }
  const std::set<int> different(clusters.begin(), clusters.end());
  CellResults results{{"frames", "", static_cast<double>(clusters.size())},
                      {"rooms", "", static_cast<double>(countOf(stoodIn))},
                      {"clusters", "", static_cast<double>(different.size())}};
  if (judged > 0)
    results.push_back({"looks_elsewhere", "", static_cast<double>(elsewhere) / static_cast<double>(judged)});
  add(results, "", measureNamedAgreement(stoodIn, clusters));
  add(results, "seen_", measureNamedAgreement(seen, clusters));
  return results;
}

/// What the rooms seen depend on, beside the images.
std::string digestOfTruth(const fs::path& folder) {
  return io::hasHomeTruth(folder) ? sha256OfFile(folder / "home.json") : "";
}

}  // namespace

RoomAgreementOptions readRoomAgreement(ConfigFile& config) {
  RoomAgreementOptions options;
  const toml::array* drives = nullptr;
  config.read(
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"models", false, "the models to compare",
        each(config, options.models, [&config](const toml::node& n) { return config.text(n); })},
       {"methods", false, "how frames are clustered",
        each(config, options.methods, oneOf(config, clusterings()))},
       {"drive", true, "[[drive]] names images with rooms", [&](auto& n) { drives = &config.list(n); }}});
  for (const toml::node& node : *drives)
    options.drives.push_back(readNamedDrive(config, config.subtable(node)));
  return options;
}

GridColumns roomAgreementColumns() {
  return {{"model", "drive", "method"},
          "",
          {"frames", "rooms", "looks_elsewhere", "clusters", "v_measure", "ari", "purity", "seen_v_measure",
           "seen_ari", "seen_purity"}};
}

Findings compareWithRooms(const RoomAgreementOptions& options, Grid& grid, const ExperimentRun& run,
                          Progress& progress) {
  std::vector<std::string> methods = options.methods;
  if (methods.empty())
    for (const Clustering& clustering : clusteringTable)
      if (!clustering.needsDepth) methods.emplace_back(clustering.name);
  const auto inputs = [](const NamedDrive& drive, std::size_t) {
    return fmt::format("{} {}", roomAgreementVersion, digestOfTruth(drive.images.path));
  };
  const auto compute = [&](LabeledDrives& labeled, const NamedDrive& drive, std::size_t method) {
    const auto& [images, recording] = labeled.of(drive.images);
    const std::vector<std::string> seen = seenIn(drive, recording);
    return measure(
        getClustering(methods[method]).of({*images, recording, seen, run.folder / ".map.estancia"}),
        roomsStoodIn(recording), seen);
  };
  return studyDrives({options.models, options.drives, methods, inputs, compute}, roomAgreementFindings, grid,
                     run, progress);
}

Findings roomAgreementFindings(const DriveResults& results) {
  constexpr auto largest = ResultTable::Best::largest;
  const auto measures = measuresIn(results.cells, {{"frames", {"frames", 0}},
                                                   {"looks_elsewhere", {"see another room", 2}},
                                                   {"rooms", {"rooms", 0}},
                                                   {"clusters", {"clusters", 0}},
                                                   {"v_measure", {"V-measure", 3, largest}},
                                                   {"ari", {"adjusted Rand index", 3, largest}},
                                                   {"purity", {"purity", 3, largest}},
                                                   {"seen_v_measure", {"seen: V-measure", 3, largest}},
                                                   {"seen_ari", {"seen: adjusted Rand index", 3, largest}},
                                                   {"seen_purity", {"seen: purity", 3, largest}}});
  Findings findings;
  findings.title = "Rooms stood in, and rooms seen";
  for (std::size_t k = 0; k < results.variants.size(); ++k) {
    const std::string& method = results.variants[k];
    std::vector<std::pair<std::string, CellResults>> rows;
    results.each([&](std::size_t model, std::size_t drive) {
      rows.emplace_back(results.titleOf(model, drive), results.of(model, drive, k));
    });
    findings.sections.emplace_back(pivot(
        ResultTable{method,
                    fmt::format("Clusters: {}; against the rooms that the camera stood in, and against those "
                                "that most of what the frames see lies in.",
                                getClustering(method).explanation),
                    "drive",
                    {},
                    {}},
        rows, measures));
  }
  findings.summary = fmt::format("{} drives, clustered in {} ways with their defaults, beside their rooms.",
                                 results.drives.size(), results.variants.size());
  return findings;
}

}  // namespace estancia::experiments
