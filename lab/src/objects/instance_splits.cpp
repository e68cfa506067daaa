// SPDX-License-Identifier: Apache-2.0
#include "objects/instance_splits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "estancia/core/error.hpp"

namespace estancia::experiments {
namespace {

/// The instances of each class that has two or more.
std::vector<std::vector<std::size_t>> choicesOf(std::span<const int> wordOf) {
  std::map<int, std::vector<std::size_t>> ofClass;
  for (std::size_t i = 0; i < wordOf.size(); ++i)
    if (wordOf[i] >= 0) ofClass[wordOf[i]].push_back(i);
  std::vector<std::vector<std::size_t>> choices;
  for (auto& [name, instances] : ofClass)
    if (instances.size() > 1) choices.push_back(std::move(instances));
  if (choices.empty())
    throw Error(
        ErrorCode::insufficientData,
        "no class has two instances, one to learn from and one to be asked about; collect more of them, or "
        "split the views of each");
  return choices;
}

/// `tested` of each class; the others of the study are learned from.
InstanceSplit splitOf(std::string name, std::span<const int> wordOf, const std::set<std::size_t>& tested) {
  InstanceSplit split{std::move(name), {}, {}};
  for (std::size_t i = 0; i < wordOf.size(); ++i)
    if (wordOf[i] >= 0) (tested.contains(i) ? split.test : split.train).push_back(i);
  return split;
}

}  // namespace

InstanceSplit baselineSplit(std::span<const int> wordOf, std::span<const double> labeled) {
  if (wordOf.size() != labeled.size())
    throw Error(ErrorCode::invalidInput,
                fmt::format("{} instances have {} shares of samples named rightly; give one each",
                            wordOf.size(), labeled.size()));
  std::set<std::size_t> tested;
  for (const std::vector<std::size_t>& instances : choicesOf(wordOf))
    tested.insert(*std::ranges::min_element(instances, {}, [&](std::size_t i) { return labeled[i]; }));
  return splitOf("baseline", wordOf, tested);
}

std::vector<InstanceSplit> randomSplits(std::span<const int> wordOf, std::size_t count, std::uint64_t seed) {
  const std::vector<std::vector<std::size_t>> choices = choicesOf(wordOf);
  std::size_t all = 1;  // or `count`, where there are more
  for (const auto& instances : choices)
    all = all > count / instances.size() ? std::max(count, all) : all * instances.size();
  std::mt19937_64 random(seed);
  std::set<std::set<std::size_t>> known;
  std::vector<InstanceSplit> splits;
  while (splits.size() < std::min(all, count)) {
    std::set<std::size_t> tested;
    for (const auto& instances : choices) tested.insert(instances[random() % instances.size()]);
    if (!known.insert(tested).second) continue;
    splits.push_back(splitOf(fmt::format("random {:02}", splits.size() + 1), wordOf, tested));
  }
  return splits;
}

}  // namespace estancia::experiments
