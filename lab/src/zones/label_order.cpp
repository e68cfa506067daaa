// SPDX-License-Identifier: Apache-2.0
#include "zones/label_order.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "estancia/core/digest.hpp"

namespace estancia::experiments {

Choices labelOrders() {
  return {{"network", "as the network has them: those of ImageNet by WordNet's numbers, like beside like"},
          {"name", "by the alphabet, as in the thesis author's program"},
          {"shuffled", "at random"}};
}

DescriptorSequence inLabelOrder(const DescriptorSequence& sequence, const std::string& order,
                                std::uint64_t seed) {
  requireChoice("label order", order, labelOrders());
  if (order == "network") return sequence;
  const std::vector<std::string>& labels = sequence.vocabulary.labels();
  std::vector<std::pair<std::string, std::size_t>> keys;
  for (std::size_t i = 0; i < labels.size(); ++i)
    keys.emplace_back(order == "name" ? labels[i] : sha256(fmt::format("{} {}", seed, labels[i])), i);
  auto part = keys.begin();
  for (const LabelPart& one : sequence.vocabulary.layout().parts) {
    std::sort(part, part + static_cast<std::ptrdiff_t>(one.size));
    part += static_cast<std::ptrdiff_t>(one.size);
  }
  std::vector<std::string> names;
  for (const auto& [key, from] : keys) names.push_back(labels[from]);
  DescriptorSequence ordered{Vocabulary(std::move(names), sequence.vocabulary.layout().parts), sequence.model,
                             sequence.frames, DescriptorMatrix(labels.size())};
  for (std::size_t row = 0; row < sequence.descriptors.size(); ++row) {
    LexicalDescriptor values;
    for (const auto& [key, from] : keys) values.push_back(sequence.descriptors.row(row)[from]);
    ordered.descriptors.append(values);
  }
  return ordered;
}

}  // namespace estancia::experiments
