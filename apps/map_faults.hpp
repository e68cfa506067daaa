// Map faults: reports of `estancia map` about depth and poses that are wrong.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "estancia/world/world_mapper.hpp"

namespace estancia::apps {

void warnOfFaults(const DriveFaults& faults);

/// Empty where there were none.
nlohmann::ordered_json faultsOf(const DriveFaults& faults);

}  // namespace estancia::apps
