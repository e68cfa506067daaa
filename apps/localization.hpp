// Localization of a sequence in a map: what `localize` and `evaluate` share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "common.hpp"
#include "estancia/topology/localizer.hpp"
#include "labeling.hpp"

namespace estancia::apps {

struct LocalizationArguments {
  std::string map;
  ModelArguments model;
  LocalizerOptions localizer;
  void addTo(DeclaredOptions& declared);
};

/// Labels the frames of `sequence` and localizes them; `use` gets each frame and its answer, in order, with
/// the frame's number in the sequence.
void localize(const LocalizationArguments& arguments, Localizer& localizer, const SequenceArguments& sequence,
              const std::function<void(std::size_t, const Frame&, const Localization&)>& use);

}  // namespace estancia::apps
