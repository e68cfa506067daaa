// Counts the cells that an experiment computed, and did not take from an earlier run.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"

namespace estancia::test {

class Counting final : public Progress {
 public:
  /// Counts works whose name holds one of `counted`.
  explicit Counting(std::vector<std::string> counted) : counted_(std::move(counted)) {}

  void begin(const std::string& what, std::size_t total, std::size_t done) override {
    if (std::ranges::any_of(counted_, [&](const auto& work) { return what.find(work) != std::string::npos; }))
      computed += total - done;
    ++works;
  }
  std::size_t computed = 0, works = 0;

 private:
  std::vector<std::string> counted_;
};

}  // namespace estancia::test
