// Label order: the same labels in another order, which changes cumulated distances alone.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "estancia/core/options.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"

namespace estancia::experiments {

/// network, name, shuffled.
Choices labelOrders();

/// One of labelOrders(), for the labels of each model alone. `seed` shuffles. Throws Error (unknownName).
DescriptorSequence inLabelOrder(const DescriptorSequence& sequence, const std::string& order,
                                std::uint64_t seed = 1);

}  // namespace estancia::experiments
