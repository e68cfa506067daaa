#include "estancia/odometry/check.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/odometry/check_parts.hpp"

namespace estancia {
namespace odometry {

std::string share(std::size_t count, std::size_t of, const char* what) {
  return fmt::format("{} of {} {}", count, of, what);
}

double medianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<double> frameInterval(const Sequence& sequence) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < sequence.size(); ++i)
    if (const auto from = sequence.frame(i - 1).timestamp, to = sequence.frame(i).timestamp;
        from && to && *to > *from)
      intervals.push_back(*to - *from);
  return intervals.empty() ? std::nullopt : std::optional(medianOf(std::move(intervals)));
}

std::vector<std::size_t> evenly(std::size_t size, std::size_t count) {
  count = std::min(count, size);
  std::vector<std::size_t> indices;
  for (std::size_t k = 0; k < count; ++k)  // from the first to the last
    indices.push_back(count == 1 ? 0 : k * (size - 1) / (count - 1));
  return indices;
}

}  // namespace odometry

std::size_t CheckReport::count(Severity severity) const {
  return static_cast<std::size_t>(std::ranges::count(items, severity, &CheckItem::severity));
}

CheckReport checkSequence(const Sequence& sequence, const CheckOptions& options, Progress& progress) {
  odometry::Checklist list;
  const odometry::DepthFacts facts = odometry::checkImages(sequence, options, progress, list);
  odometry::checkCamera(sequence, facts, list);
  odometry::checkTimes(sequence, list);
  odometry::checkTrajectory(sequence, list);
  odometry::checkGeometry(sequence, facts, progress, list);
  return {list.take(), sequence.size()};
}

}  // namespace estancia
