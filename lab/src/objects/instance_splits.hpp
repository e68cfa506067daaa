// Instance splits: training and test sets that share no instance (thesis 6.4).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace estancia::experiments {

struct InstanceSplit {
  /// "baseline", "random 01".
  std::string name;
  /// Instances, ascending; none in both.
  std::vector<std::size_t> train, test;
};

/// For each class the instance that the labeler names worst is tested, the others are learned from (thesis
/// 6.4.1). `classOf[i]` is the class of instance i, `labeled[i]` the share of its samples that the labeler
/// names rightly. Classes with one instance are learned from only; instances of class −1 stand on neither
/// side. Throws Error when no class has two.
InstanceSplit baselineSplit(std::span<const int> classOf, std::span<const double> labeled);

/// `count` different splits, of each class one instance, drawn at random, tested and the others learned from
/// (thesis 6.4.2); fewer, all that there are, where there are not so many. Throws Error when no class has
/// two.
std::vector<InstanceSplit> randomSplits(std::span<const int> classOf, std::size_t count, std::uint64_t seed);

}  // namespace estancia::experiments
