// Printable labels: labels of others without control characters.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace estancia {

class Vocabulary;

/// A label: tabs become blanks, the rest is printable().
std::string printableLabel(std::string label);

/// The vocabulary with printable labels.
Vocabulary printableLabels(const Vocabulary& vocabulary);

}  // namespace estancia
