// Localising a sequence in a map, as `localize` and `evaluate` both do.
#pragma once

#include <functional>
#include <string>

#include "common.hpp"
#include "estancia/topology/localizer.hpp"
#include "estancia/topology/session.hpp"
#include "labelling.hpp"

namespace estancia::apps {

struct LocalizationArguments {
  std::string map;
  ModelArguments model;
  LocalizerOptions localizer;
  void addTo(CLI::App& command);
};

/// Labels the frames and localises them; `use` gets the frame's number in the sequence and its answer, in
/// order.
void localize(const LocalizationArguments& arguments, const MapReader& reader, const Sequence& sequence,
              bool strict, const std::function<void(std::size_t, const Localization&)>& use);

}  // namespace estancia::apps
