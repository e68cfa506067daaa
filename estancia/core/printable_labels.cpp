// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/printable_labels.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "estancia/core/printable.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

std::string printableLabel(std::string label) {
  std::replace(label.begin(), label.end(), '\t', ' ');
  return printable(label);
}

Vocabulary printableLabels(const Vocabulary& vocabulary) {
  std::vector<std::string> labels;
  for (const std::string& label : vocabulary.labels()) labels.push_back(printableLabel(label));
  if (labels == vocabulary.labels()) return vocabulary;
  return Vocabulary(std::move(labels), vocabulary.layout().parts);
}

}  // namespace estancia
