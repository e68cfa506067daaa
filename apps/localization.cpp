// SPDX-License-Identifier: Apache-2.0
#include "localization.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <unordered_map>

#include "estancia/core/error.hpp"
#include "estancia/report/zone_summary.hpp"
#include "estancia/zones/overlay.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia::apps {

void LocalizationArguments::addTo(DeclaredOptions& declared) {
  declared.command().add_option("MAP", map, "The map file")->required();
  model.addTo(declared, "The model that the map was made with");
  declared.command()
      .add_option("--zones", zones,
                  "A file of zones or areas of the map's frames: answers tell the most probable one, too")
      ->check(CLI::ExistingFile);
  declared.add(declare(localizer), {"lookahead", "max-images"});
}

std::vector<int> zonesOfFrames(const std::string& zones, const TopologicalMap& map) {
  if (zones.empty()) return {};
  const Zones known = readZones(zones);
  std::unordered_map<std::string, int> zoneOf;
  for (std::size_t i = 0; i < known.frames.size(); ++i) zoneOf[known.frames[i].name] = known.zoneOf[i];
  std::vector<int> result;
  for (const MappedFrame& frame : map.frames) {
    const auto zone = zoneOf.find(frame.name);
    result.push_back(zone == zoneOf.end() ? -1 : zone->second);
  }
  if (std::ranges::all_of(result, [](int zone) { return zone < 0; }))
    throw Error(
        ErrorCode::mismatch,
        fmt::format("{} holds none of the map's frames; find the zones of the sequence that was mapped",
                    zones));
  if (!areOfSameRun(known, report::groupedRun(map)))
    throw Error(ErrorCode::mismatch,
                fmt::format("{} is of another drive: frames have the names of the map's, but other labels; "
                            "find the zones or areas of the sequence that was mapped",
                            zones));
  return result;
}

void localize(const LocalizationArguments& arguments, Localizer& localizer, const SequenceArguments& sequence,
              const std::string& work,
              const std::function<void(std::size_t, const Frame&, const Localization&)>& use) {
  const TopologicalMap& map = localizer.map();
  Labeling labeling(sequence, arguments.model, &map.vocabulary);
  requireSameVocabulary(map.vocabulary, labeling.vocabulary(), arguments.map);
  // Another network of the same vocabulary gives other probabilities: its answers would look right and mean
  // nothing.
  if (map.model != labeling.identity())
    throw Error(
        ErrorCode::mismatch,
        fmt::format(
            "{} was made with the model {}, not {}; give images and that model (--model, --precision, "
            "--reduced-images), or its labels (.labels, which name their model)",
            arguments.map, map.model, labeling.identity()));
  if (std::vector<int> zoneOf = zonesOfFrames(arguments.zones, map); !zoneOf.empty())
    localizer.setZones(std::move(zoneOf));
  std::deque<std::size_t> waiting;
  const auto give = [&](const std::vector<Localization>& answers) {
    for (const Localization& answer : answers) {
      use(waiting.front(), labeling.sequence().frame(waiting.front()), answer);
      waiting.pop_front();
    }
  };
  labeling.forEach(0, work, [&](const LabeledFrame& frame) {
    waiting.push_back(frame.index);
    give(localizer.add(frame.descriptor, labeling.sequence().frame(frame.index).pose));
  });
  give(localizer.finish());
}

}  // namespace estancia::apps
