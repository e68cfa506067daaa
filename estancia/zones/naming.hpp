// Zone names: the labels that distinguish a zone from the rest of the run; zones as JSON with them. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/words/label_concepts.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

/// The `count` labels that distinguish a zone most, best first: those that contribute most to the relative
/// entropy of the zone against the whole run, p ln(p / p_run) (Kullback and Leibler 1951): likely in the zone
/// and likelier than elsewhere. Where nothing is (the zone is the run), the most probable labels. Labels of
/// probability 0 are left out; fewer than `count` may be returned.
std::vector<std::size_t> distinctiveLabels(DescriptorView zone, DescriptorView run, std::size_t count);

/// One name a zone: its three words with most evidence, "refrigerator, stove, microwave" (tellingWords();
/// where fewer have evidence, then the most probable labels). A zone whose words an earlier one has already
/// gets further words until the names differ, or its words are used up. Words that a vocabulary holds twice
/// are named once. `means` are the zones' mean probabilities.
std::vector<std::string> nameZones(const Vocabulary& vocabulary, const std::vector<std::vector<float>>& means,
                                   DescriptorView run, const LabelConcepts& concepts = {});

/// The room that a zone was taken for and its telling words, "kitchen: stove, refrigerator", or these alone.
inline std::string describedName(const Zone& zone) {
  return zone.predicted.empty() ? zone.name : zone.predicted.front().room + ": " + zone.name;
}

/// Short name: "kitchen", else the first of its words.
inline std::string shortName(const Zone& zone) {
  return zone.predicted.empty() ? zone.name.substr(0, zone.name.find(',')) : zone.predicted.front().room;
}

/// {"model", "distance", "linkage", "cut", "cut_reason", "zones": [{"id", "name", "images", "share",
/// "words": [{"label", "word", "p", "lift"}], "room", "room_share", "predicted_rooms": [{"room", "p"}],
/// "position", "spread"}], "rooms": toRoomsJson()}; unknown rooms and positions are null. `words` most
/// distinctive labels a zone; "word" is what people call it there (familiarWords()).
nlohmann::ordered_json toJson(const Zones& zones, std::size_t words = 10, const LabelConcepts& concepts = {});

/// {"kitchen": {"images": 137, "words": {"refrigerator": 0.31, …}}, …}: each true room where rooms are known,
/// else, where a classifier has named zones, each predicted room with all zones that are taken for it
/// ("predicted": its mean probability over their images, "zones": their ids), else each zone by its name, in
/// order of Zones::rooms or Zones::zones; rooms by their names alone stand before the zones that are none
/// surely. With its `words` most distinctive labels (distinctiveLabels()), best first, with their mean
/// probability. A name that stands there twice gets its zone's number behind it.
std::string toRoomsJson(const Zones& zones, std::size_t words = 10);

}  // namespace estancia
