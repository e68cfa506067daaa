// SPDX-License-Identifier: Apache-2.0
#include "words/average_precision.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/core/error.hpp"
#include "findings/pivot.hpp"

namespace estancia::experiments {

double averagePrecision(const std::vector<double>& scores, const std::vector<std::size_t>& answers) {
  if (answers.empty() || *std::ranges::max_element(answers) >= scores.size())
    throw Error(ErrorCode::invalidInput,
                fmt::format("average precision needs answers among the {} items", scores.size()));
  std::vector<bool> isAnswer(scores.size(), false);
  for (const std::size_t answer : answers) isAnswer[answer] = true;
  const std::vector<std::size_t> order = ascending(scores.size(), [&](std::size_t i) { return -scores[i]; });
  double sum = 0, found = 0;
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin;
    double tiedAnswers = 0;
    for (; end < order.size() && scores[order[end]] == scores[order[begin]]; ++end)
      tiedAnswers += isAnswer[order[end]] ? 1 : 0;
    const auto tied = static_cast<double>(end - begin);
    // An answer stands at each of the tied ranks as probably, and so do the others before it.
    for (std::size_t at = begin; at < end && tiedAnswers > 0; ++at) {
      const auto before = static_cast<double>(at - begin);
      const double others = tied > 1 ? before * (tiedAnswers - 1) / (tied - 1) : 0;
      sum += tiedAnswers / tied * (found + 1 + others) / static_cast<double>(at + 1);
    }
    found += tiedAnswers;
    begin = end;
  }
  return sum / static_cast<double>(answers.size());
}

}  // namespace estancia::experiments
