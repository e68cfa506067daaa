// Confusion findings: the test of a room classifier as a page.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/classify/predict_rooms.hpp"
#include "estancia/findings/findings.hpp"

namespace estancia {

/// Accuracy, balanced accuracy, the rooms' own shares, and what was taken for what. `facts` describe the
/// circumstances. Throws Error when nothing was tested.
Findings findingsOf(const Confusion& confusion, const std::string& title,
                    std::vector<std::pair<std::string, std::string>> facts);

/// How many are right.
std::size_t rightOf(const Confusion& confusion);

}  // namespace estancia
