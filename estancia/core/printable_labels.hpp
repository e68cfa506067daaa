// Printable labels: labels of others without control characters.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/printable.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

/// A label: tabs become blanks, the rest is printable().
inline std::string printableLabel(std::string label) {
  std::replace(label.begin(), label.end(), '\t', ' ');
  return printable(label);
}

/// The vocabulary with printable labels.
inline Vocabulary printableLabels(const Vocabulary& vocabulary) {
  std::vector<std::string> labels;
  for (const std::string& label : vocabulary.labels()) labels.push_back(printableLabel(label));
  if (labels == vocabulary.labels()) return vocabulary;
  return Vocabulary(std::move(labels), vocabulary.layout().parts);
}

}  // namespace estancia
