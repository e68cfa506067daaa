// Localization of a sequence in a map: what `localize` and `evaluate` share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common.hpp"
#include "estancia/localization/localizer.hpp"
#include "labeling.hpp"

namespace estancia::apps {

struct LocalizationArguments {
  std::string map, zones;
  ModelArguments model;
  LocalizerOptions localizer;
  void addTo(DeclaredOptions& declared);
};

/// The zone of each frame of the map by `zones`, a file; -1 for frames that it does not know. Empty without
/// one. Throws Error (mismatch) where it knows none.
std::vector<int> zonesOfFrames(const std::string& zones, const TopologicalMap& map);

/// Labels the frames of `sequence` and localizes them; `use` gets each frame and its answer, in order, with
/// the frame's number in the sequence. `work`: the name of the progress bar, "" for none.
void localize(const LocalizationArguments& arguments, Localizer& localizer, const SequenceArguments& sequence,
              const std::string& work,
              const std::function<void(std::size_t, const Frame&, const Localization&)>& use);

}  // namespace estancia::apps
