// Grouped cross-validation (trainers.hpp).
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <map>
#include <random>

#include "estancia/classify/trainers.hpp"
#include "estancia/core/temporal_segments.hpp"

namespace estancia {
namespace {

/// Frames of a piece of a cut segment: neighbors are near-copies: single ones would give each other away.
constexpr std::size_t minPiece = 3;

/// Cuts segments into equal pieces, the longest first, until there are `minCount` or all are short.
std::vector<TemporalSegment> cut(const std::vector<TemporalSegment>& segments, std::size_t minCount) {
  std::vector<std::size_t> pieces(segments.size(), 1);
  const auto sizeIfCut = [&](std::size_t r) { return segments[r].size / (pieces[r] + 1); };
  for (std::size_t count = segments.size(); count < minCount; ++count) {
    std::size_t longest = 0;
    for (std::size_t r = 1; r < segments.size(); ++r)
      if (sizeIfCut(r) > sizeIfCut(longest)) longest = r;
    if (sizeIfCut(longest) < minPiece) break;
    ++pieces[longest];
  }
  std::vector<TemporalSegment> cut;
  for (std::size_t r = 0; r < segments.size(); ++r)
    for (std::size_t p = 0; p < pieces[r]; ++p) {
      const std::size_t begin = segments[r].size * p / pieces[r],
                        end = segments[r].size * (p + 1) / pieces[r];
      cut.push_back({segments[r].first + begin, end - begin});
    }
  return cut;
}

}  // namespace

std::vector<int> segmentGroups(const std::vector<Frame>& frames, int minSegments) {
  std::vector<std::string> rooms;
  for (const Frame& frame : frames) rooms.push_back(frame.room);
  std::map<std::string, std::vector<TemporalSegment>> segments;
  for (const TemporalSegment& segment : temporalSegments(frames, rooms))
    segments[rooms[segment.first]].push_back(segment);
  std::vector<int> groups(frames.size());
  int group = 0;
  for (const auto& [room, ofRoom] : segments) {
    for (const TemporalSegment& segment : cut(ofRoom, static_cast<std::size_t>(std::max(minSegments, 1)))) {
      const auto first = groups.begin() + static_cast<std::ptrdiff_t>(segment.first);
      std::fill(first, first + static_cast<std::ptrdiff_t>(segment.size), group++);
    }
  }
  return groups;
}

std::vector<int> instanceGroups(const std::vector<int>& classes, const std::vector<int>& instances,
                                int pieces) {
  std::map<int, std::vector<std::size_t>> members;  // samples of each instance
  for (std::size_t i = 0; i < instances.size(); ++i) members[instances[i]].push_back(i);
  std::map<int, int> mainClass, instancesOf;
  for (const auto& [instance, samples] : members) {
    std::map<int, int> counts;
    for (const std::size_t i : samples) ++counts[classes[i]];
    mainClass[instance] = std::ranges::max_element(counts, {}, [](const auto& c) { return c.second; })->first;
    ++instancesOf[mainClass[instance]];
  }
  std::vector<int> groups(instances.size());
  int group = 0;
  for (const auto& [instance, samples] : members) {
    const std::size_t minPieces = instancesOf[mainClass[instance]] > 1 ? 1 : std::max(pieces, 1);
    for (const TemporalSegment& piece : cut({{0, samples.size()}}, minPieces)) {
      for (std::size_t i = 0; i < piece.size; ++i) groups[samples[piece.first + i]] = group;
      ++group;
    }
  }
  return groups;
}

std::vector<int> groupedFolds(const std::vector<int>& classes, const std::vector<int>& groups, int folds,
                              std::uint64_t seed) {
  std::map<int, std::map<int, double>> counts;  // counts of the classes in each group
  std::map<int, double> totals;
  for (std::size_t i = 0; i < classes.size(); ++i) {
    ++counts[groups[i]][classes[i]];
    ++totals[classes[i]];
  }
  std::vector<int> order;
  for (const auto& [group, of] : counts) order.push_back(group);
  std::mt19937_64 random(seed);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  const auto size = [&](int group) {
    double sum = 0;
    for (const auto& [c, count] : counts[group]) sum += count;
    return sum;
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return size(a) > size(b); });

  // A class counts by its shares: `part` of it in a fold that holds `share` adds to the sum of squares.
  std::vector<std::map<int, double>> shares(static_cast<std::size_t>(folds));
  std::vector<double> sizes(shares.size());
  std::map<int, int> foldOf;
  for (const int group : order) {
    std::size_t best = 0;
    double minCost = std::numeric_limits<double>::infinity();
    for (std::size_t f = 0; f < shares.size(); ++f) {
      double cost = 0;
      for (const auto& [c, count] : counts[group]) {
        const double part = count / totals[c];
        cost += part * (part + 2 * shares[f][c]);
      }
      cost += 1e-9 * sizes[f];  // among equals the emptiest
      if (cost < minCost) {
        minCost = cost;
        best = f;
      }
    }
    for (const auto& [c, count] : counts[group]) shares[best][c] += count / totals[c];
    sizes[best] += size(group);
    foldOf[group] = static_cast<int>(best);
  }
  std::vector<int> result(groups.size());
  for (std::size_t i = 0; i < groups.size(); ++i) result[i] = foldOf[groups[i]];
  return result;
}

}  // namespace estancia
