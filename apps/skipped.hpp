// Skipped input: a line for each of the first frames, clouds or views that are left out, then their number.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace estancia::apps {

class Skipped {
 public:
  /// Printed before each problem.
  explicit Skipped(std::string verb = "skipped") : verb_(std::move(verb)) {}
  /// Reports how many more there were.
  ~Skipped();
  Skipped(const Skipped&) = delete;
  Skipped& operator=(const Skipped&) = delete;

  void add(std::string_view problem);
  std::size_t count() const { return count_; }

  /// A folder of a hundred thousand broken images does not fill the terminal.
  static constexpr std::size_t maxReported = 20;

 private:
  std::string verb_;
  std::size_t count_ = 0;
};

}  // namespace estancia::apps
