// Localization filter choice: which one suits a map, with evidence from the map's own frames. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "estancia/localization/localization_filter.hpp"
#include "estancia/localization/localizer.hpp"
#include "estancia/localization/localizer_map.hpp"

namespace estancia {

/// A pose filter where at least half of the map's images have poses, else one over the order of the images.
/// `distance` compares two of them by their numbers.
std::unique_ptr<const LocalizationFilter> makeFilter(
    const LocalizerMap& source, const std::function<float(std::size_t, std::size_t)>& distance,
    const PlaceFilterOptions& options);

}  // namespace estancia
