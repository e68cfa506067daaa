// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/parameter_search.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/classify/folds.hpp"
#include "estancia/classify/trainers.hpp"
#include "estancia/stats/products.hpp"

namespace estancia {
namespace {

std::vector<std::size_t> searched(const Samples& samples, std::size_t maxSamples) {
  std::vector<std::vector<std::size_t>> ofClass(static_cast<std::size_t>(samples.classCount));
  for (std::size_t i = 0; i < samples.classes.size(); ++i)
    ofClass[static_cast<std::size_t>(samples.classes[i])].push_back(i);
  const double step =
      std::max(1.0, static_cast<double>(samples.classes.size()) / static_cast<double>(maxSamples));
  std::vector<std::size_t> rows;
  for (const auto& members : ofClass)
    for (double at = 0; at < static_cast<double>(members.size()); at += step)
      rows.push_back(members[static_cast<std::size_t>(at)]);
  std::sort(rows.begin(), rows.end());
  return rows;
}

}  // namespace

std::vector<float> productsOf(const DescriptorMatrix& x, int threads) {
  const std::size_t n = x.size();
  std::vector<float> products(n * n);
  rowProducts(x, PackedRows(x), threads, [&](std::size_t i, std::span<float> row) {
    std::copy(row.begin(), row.end(), products.begin() + static_cast<std::ptrdiff_t>(i * n));
  });
  return products;
}

std::vector<std::size_t> Search::trainingRows(const std::vector<int>& foldOf, int fold) const {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < size(); ++i)
    if (foldOf[i] != fold) rows.push_back(i);
  const auto isAlike = [&](std::size_t row) { return classes[row] == classes[rows.front()]; };
  return std::ranges::all_of(rows, isAlike) ? std::vector<std::size_t>() : rows;
}

Search searchOf(const Samples& samples, const ClassifierOptions& options, std::size_t maxSamples) {
  Search search;
  std::vector<int> groups;
  const std::vector<std::size_t> rows = searched(samples, maxSamples);
  search.x = rowsOf(samples.x, rows);
  for (const std::size_t row : rows) {
    search.classes.push_back(samples.classes[row]);
    groups.push_back(samples.groups[row]);
  }
  for (std::size_t r = 0; r < Search::repetitions; ++r)
    search.folds.push_back(groupedFolds(search.classes, groups, options.folds, options.seed + r));
  search.weights = classWeights(samples, options.balanced);
  return search;
}

std::string heldOutText(double share, const ClassifierOptions& options) {
  return fmt::format("{:.1f} % of held-out samples{}", 100 * share,
                     options.balanced ? ", with equal weights of the classes" : "");
}

}  // namespace estancia
