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

/// Of each word the instance that the labeler names worst is tested, the others are learned from
/// (thesis 6.4.1). `wordOf[i]` is the word of instance i, `labeled[i]` the share of its samples that the
/// labeler names rightly. Words with one instance are learned from only; instances of word −1 stand on
/// neither side. Throws Error when no word has two.
InstanceSplit baselineSplit(std::span<const int> wordOf, std::span<const double> labeled);

/// `count` different splits, of each word one instance, drawn at random, tested and the others learned from
/// (thesis 6.4.2); fewer, all that there are, where there are not so many. Throws Error when no word has two.
std::vector<InstanceSplit> randomSplits(std::span<const int> wordOf, std::size_t count, std::uint64_t seed);

}  // namespace estancia::experiments
