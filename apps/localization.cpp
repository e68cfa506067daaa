// SPDX-License-Identifier: Apache-2.0
#include "localization.hpp"

#include <fmt/format.h>

#include <deque>

#include "estancia/core/error.hpp"

namespace estancia::apps {

void LocalizationArguments::addTo(DeclaredOptions& declared) {
  declared.command().add_option("MAP", map, "The map file")->required();
  model.addTo(declared, "The model that the map was made with");
  declared.add(declare(localizer), {"lookahead", "max-images"});
}

void localize(const LocalizationArguments& arguments, Localizer& localizer, const SequenceArguments& sequence,
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
            "{} was made with the model {}, not {}; give images and that model by --model, or its labels "
            "(.labels, which name their model)",
            arguments.map, map.model, labeling.identity()));
  std::deque<std::size_t> waiting;
  const auto give = [&](const std::vector<Localization>& answers) {
    for (const Localization& answer : answers) {
      use(waiting.front(), labeling.sequence().frame(waiting.front()), answer);
      waiting.pop_front();
    }
  };
  labeling.forEach(0, "localizing", [&](const LabeledFrame& frame) {
    waiting.push_back(frame.index);
    give(localizer.add(frame.descriptor, labeling.sequence().frame(frame.index).pose));
  });
  give(localizer.finish());
}

}  // namespace estancia::apps
