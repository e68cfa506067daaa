// Label bars: the most probable labels of a place or a zone.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/report/html.hpp"

namespace estancia::report {

/// An <ol> of at most `count` labels, best first; bars are relative to the best. With `sigma` (one value a
/// label, empty for none) each probability is given ± its standard deviation.
Markup labelBars(const Vocabulary& vocabulary, DescriptorView mean, DescriptorView sigma, std::size_t count);

}  // namespace estancia::report
