// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/temporal_segments.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

/// "frame" and 123 of "frame000123.jpg"; nothing where the name ends otherwise, or in a fraction.
std::optional<std::pair<std::string, double>> numberedName(const std::string& name) {
  constexpr std::size_t maxDigits = 15;  // digits that a double distinguishes
  const std::string stem = std::filesystem::path(name).stem().string();
  std::size_t begin = stem.size();
  while (begin > 0 && std::isdigit(static_cast<unsigned char>(stem[begin - 1])) != 0) --begin;
  if (begin == stem.size() || stem.size() - begin > maxDigits || (begin > 0 && stem[begin - 1] == '.'))
    return std::nullopt;
  std::uint64_t number = 0;
  std::from_chars(stem.data() + begin, stem.data() + stem.size(), number);
  return std::pair{stem.substr(0, begin), static_cast<double>(number)};
}

std::vector<double> timesOf(const std::vector<Frame>& frames) {
  std::vector<double> times;
  for (const Frame& frame : frames) {
    if (!frame.timestamp) return {};
    times.push_back(*frame.timestamp);
  }
  return times;
}

std::vector<double> numbersOf(const std::vector<Frame>& frames) {
  std::vector<double> numbers;
  std::string prefix;
  for (const Frame& frame : frames) {
    const auto name = numberedName(frame.name);
    if (!name || (!numbers.empty() && name->first != prefix)) return {};
    prefix = name->first;
    numbers.push_back(name->second);
  }
  return numbers;
}

/// The largest step within a segment: `times` the median one.
double maxStep(const std::vector<double>& positions, const std::vector<std::string>& places, double times) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < positions.size(); ++i)
    if (places[i] == places[i - 1] && positions[i] > positions[i - 1])
      steps.push_back(positions[i] - positions[i - 1]);
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return times * *middle;
}

}  // namespace

std::vector<TemporalSegment> temporalSegments(const std::vector<Frame>& frames,
                                              const std::vector<std::string>& places) {
  if (places.size() != frames.size())
    fail(ErrorCode::mismatch, "{} places for {} frames; give one a frame", places.size(), frames.size());
  std::vector<double> positions = timesOf(frames);
  const double times = positions.empty() ? 1 : 2;  // clocks jitter, numbers do not
  if (positions.empty()) positions = numbersOf(frames);
  const double limit = maxStep(positions, places, times);
  const auto follows = [&](std::size_t i) {
    if (places[i] != places[i - 1]) return false;
    if (positions.empty()) return true;
    const double step = positions[i] - positions[i - 1];
    return step >= 0 && step <= limit;
  };
  std::vector<TemporalSegment> segments;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (i > 0 && follows(i))
      ++segments.back().size;
    else
      segments.push_back({i, 1});
  return segments;
}

}  // namespace estancia
