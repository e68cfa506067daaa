// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/table_features.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "estancia/core/digest.hpp"

namespace estancia {
namespace {

constexpr std::string_view origin = "table ";  // begins the identity

PartKind kindOf(const FeatureTable& table, const FeaturePart& part) {
  constexpr double tolerance = 1e-3;
  double whole = 0;
  bool varies = false;
  const auto rowOf = [&](std::size_t i) { return table.values.row(i).subspan(part.first, part.size); };
  if (part.size < 2) return PartKind::energies;
  for (std::size_t i = 0; i < table.values.size(); ++i) {
    double sum = 0;
    for (const float value : rowOf(i)) {
      if (value < 0) return PartKind::energies;
      sum += value;
    }
    if (whole == 0) whole = sum;
    varies = varies || !std::ranges::equal(rowOf(i), rowOf(0));
    if (sum > 0 && std::abs(sum - whole) > tolerance * whole) return PartKind::energies;
  }
  return whole > 0 && varies ? PartKind::histogram : PartKind::energies;
}

}  // namespace

Features featuresOf(const FeatureTable& table) {
  Features features{{}, table.frames, table.values};
  for (const FeaturePart& part : table.parts) {
    DescriptorPart& described = features.parts.emplace_back();
    described.name = part.name;
    described.kind = kindOf(table, part);
    const auto first = table.columns.begin() + static_cast<std::ptrdiff_t>(part.first);
    described.columns.assign(first, first + static_cast<std::ptrdiff_t>(part.size));
    described.identity = std::string(origin) + sha256(fmt::format("{}", fmt::join(described.columns, "\n")));
  }
  return features;
}

bool isOfTable(const DescriptorPart& part) {
  return part.identity.starts_with(origin);
}

std::vector<std::string> binaryParts(const Features& features) {
  std::vector<std::string> names;
  std::size_t column = 0;
  for (const DescriptorPart& part : features.parts) {
    bool binary = part.size() == 1 && isOfTable(part);
    for (std::size_t i = 0; binary && i < features.values.size(); ++i) {
      const float value = features.values.row(i)[column];
      binary = value == 0 || value == 1;
    }
    if (binary) names.push_back(part.name);
    column += part.size();
  }
  return names;
}

}  // namespace estancia
