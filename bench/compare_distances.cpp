// Which node distance is best? Maps and localizes with every distance on descriptors that are stored in map
// files, so that no image is labeled again. docs/measured/distances.md holds the table and the commands.
//   compare_distances TOUR.estancia SECOND_TOUR.estancia CORRIDOR.estancia SECOND_CORRIDOR.estancia
//   GROUND_TRUTH.csv [DISTANCE…]      without names all
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "estancia/localization/localizer.hpp"
#include "estancia/localization/localizer_map.hpp"
#include "estancia/query/accuracy.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/session/session.hpp"
#include "estancia/stats/clustering_agreement.hpp"

namespace {

using namespace estancia;
namespace fs = std::filesystem;

/// The frames and descriptors of an earlier run.
struct Run : DescriptorSequence {
  explicit Run(const fs::path& path) : DescriptorSequence(readMapDescriptors(path)) {
    std::map<std::string, int> numbers;
    for (const Frame& frame : frames)
      rooms.push_back(numbers.try_emplace(frame.room, static_cast<int>(numbers.size())).first->second);
  }
  std::vector<int> rooms;
};

struct Mapped {
  std::shared_ptr<const LocalizerMap> localizing;
  Thresholds thresholds;
  const TopologicalMap& map() const { return localizing->map; }
};

/// Maps the run's frames anew.
Mapped mapAgain(const Run& run, const MapperOptions& options, const fs::path& file) {
  fs::remove(file);
  auto session = MappingSession::create(file, run.vocabulary, run.model, options);
  for (std::size_t i = 0; i < run.descriptors.size(); ++i) session.add(run.frames[i], run.descriptors.row(i));
  session.finish();
  return {std::make_shared<const LocalizerMap>(readLocalizerMap(file, LocalizerOptions{}.maxImages)),
          session.mapper().thresholds()};
}

std::size_t distinct(const std::vector<int>& nodes) {
  return std::set<int>(nodes.begin(), nodes.end()).size();
}

std::vector<int> nodesOf(const TopologicalMap& map) {
  std::vector<int> nodes;
  for (const MappedFrame& frame : map.frames) nodes.push_back(frame.node);
  return nodes;
}

/// The best V-measure that any pair of thresholds reaches, truth in hand: what automatic thresholds compete
/// with.
std::pair<double, std::size_t> bestByHand(const Run& run, const std::string& distance, double tauJoin) {
  std::pair<double, std::size_t> best{0, 0};
  for (double join = 0.3; join <= 2.01; join += 0.1)
    for (const double ratio : {0.1, 0.25, 0.4, 0.6, 0.8, 1.0}) {
      MapperOptions options;
      options.distance = distance;
      options.tauJoin = join * tauJoin;
      options.tauRevisit = ratio * join * tauJoin;
      Mapper mapper(run.descriptors.labels(), options);
      for (std::size_t i = 0; i < run.descriptors.size(); ++i) mapper.add(run.descriptors.row(i));
      mapper.finish();
      std::vector<int> nodes(run.descriptors.size());
      for (const auto& event : mapper.takeChanges().events) {
        if (const auto* decision = std::get_if<Decision>(&event)) {
          nodes[decision->frame] = decision->node;
        } else {
          const auto& merge = std::get<Merge>(event);
          std::replace(nodes.begin(), nodes.end(), merge.absorbed, merge.kept);
        }
      }
      best = std::max(best, {measureAgreement(run.rooms, nodes).vMeasure, distinct(nodes)});
    }
  return best;
}

std::vector<Localization> localize(const Mapped& mapped, const Run& queries, std::size_t lookahead) {
  LocalizerOptions options;
  options.lookahead = lookahead;
  Localizer localizer(mapped.localizing, options);
  std::vector<Localization> answers;
  for (std::size_t i = 0; i < queries.descriptors.size(); ++i)
    for (const auto& answer : localizer.add(queries.descriptors.row(i))) answers.push_back(answer);
  for (const auto& answer : localizer.finish()) answers.push_back(answer);
  return answers;
}

void compareAll(char** paths, std::vector<std::string> names) {
  const Run tour(paths[1]), second(paths[2]), corridor(paths[3]), again(paths[4]);
  const auto truth = readAdmissibleImages(paths[5]);
  const fs::path scratch = fs::temp_directory_path() / "compare_distances.estancia";
  fmt::print(
      "| distance | tour: V, purity (nodes), automatic | best V by hand (nodes) | second tour: nearest "
      "image's place |"
      " corridor: one frame | filtered | smoothed |\n|---|---|---|---|---|---|---|\n");
  if (names.empty())
    for (const Distance& distance : baseDistances()) {
      names.push_back(distance.name);
      if (!distance.sigmaWeighted) names.push_back(distance.name + "-sigma");
    }
  for (const std::string& name : names) {
    MapperOptions options;
    options.distance = name;
    const Mapped mapped = mapAgain(tour, options, scratch);
    const std::vector<int> nodes = nodesOf(mapped.map());
    const Agreement automatic = measureAgreement(tour.rooms, nodes);
    const auto [bestV, bestNodes] = bestByHand(tour, name, mapped.thresholds.join);
    double place = 0;
    const auto views = localize(mapped, second, 0);
    for (std::size_t i = 0; i < views.size(); ++i)
      place += mapped.map().frames[views[i].nearestImage].room == second.frames[i].room;
    const Mapped corridorMap = mapAgain(corridor, options, scratch);
    const auto filtered = localize(corridorMap, again, 0), smoothed = localize(corridorMap, again, 20);
    double single = 0, filter = 0, smooth = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      single += truth[i].contains(filtered.at(i).nearestImage);
      filter += truth[i].contains(filtered.at(i).beliefImage);
      smooth += truth[i].contains(smoothed.at(i).beliefImage);
    }
    const double queries = static_cast<double>(truth.size());
    fmt::print("| {} | {:.3f}, {:.3f} ({}) | {:.3f} ({}) | {:.1f} % | {:.2f} | {:.2f} | {:.2f} |\n", name,
               automatic.vMeasure, automatic.purity, distinct(nodes), bestV, bestNodes,
               100 * place / static_cast<double>(views.size()), single / queries, filter / queries,
               smooth / queries);
    std::fflush(stdout);
  }
  fs::remove(scratch);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) {
    std::fputs(
        "usage: compare_distances TOUR SECOND_TOUR CORRIDOR SECOND_CORRIDOR GROUND_TRUTH.csv [DISTANCE...]\n",
        stderr);
    return 2;
  }
  try {
    compareAll(argv, {argv + 6, argv + argc});
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return 2;
  }
}
