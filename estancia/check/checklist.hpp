// Checklist: the findings of a sequence check, and the checks that make them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/check/check.hpp"

namespace estancia::check {

constexpr double synchronous = 0.02;  ///< largest time between an image and its depth [s]

class Checklist {
 public:
  void fine(std::string name, std::string what, std::string evidence) {
    items_.push_back({Severity::fine, std::move(name), std::move(what), std::move(evidence), ""});
  }
  void add(Severity severity, std::string name, std::string what, std::string evidence, std::string fix) {
    items_.push_back({severity, std::move(name), std::move(what), std::move(evidence), std::move(fix)});
  }
  /// Whether a fault has this name.
  bool has(const std::string& name) const {
    return std::ranges::any_of(items_,
                               [&](const CheckItem& item) { return isFault(item) && item.name == name; });
  }
  std::size_t faults() const { return static_cast<std::size_t>(std::ranges::count_if(items_, isFault)); }
  std::vector<CheckItem> take() { return std::move(items_); }

 private:
  static bool isFault(const CheckItem& item) { return item.severity != Severity::fine; }

  std::vector<CheckItem> items_;
};

/// "3 of 60 images"
std::string share(std::size_t count, std::size_t of, const char* what);

/// The severity of `missing` of `all`: a fifth is a problem.
inline Severity severityOfMissing(std::size_t missing, std::size_t all) {
  return 5 * missing >= all ? Severity::problem : Severity::warning;
}

/// The median (the upper one of an even number); `values` must not be empty.
double medianOf(std::vector<double> values);

/// The median time between frames [s], above 0; nothing without time stamps.
std::optional<double> frameInterval(const Sequence& sequence);

/// Indices of at most `count` of `size` frames, evenly spread, ascending.
std::vector<std::size_t> evenly(std::size_t size, std::size_t count);

/// Results of checking the images of a sequence.
struct DepthFacts {
  std::optional<double> median;  ///< [m], absent without depth
  cv::Size image, depth;         ///< sizes of the first readable ones
};

DepthFacts checkImages(const Sequence& sequence, const CheckOptions& options, Progress& progress,
                       Checklist& list);
void checkCamera(const Sequence& sequence, const DepthFacts& facts, Checklist& list);
void checkTimes(const Sequence& sequence, Checklist& list);
void checkTrajectory(const Sequence& sequence, Checklist& list);
void checkGeometry(const Sequence& sequence, const DepthFacts& facts, Progress& progress, Checklist& list);

}  // namespace estancia::check
