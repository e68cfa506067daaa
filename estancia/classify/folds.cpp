#include "estancia/classify/folds.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <random>
#include <string>

namespace estancia {
namespace {

/// The last number in a name, its extension apart: 12 of "rgb/0012.png".
std::optional<long long> numberOf(const std::string& name) {
  const auto isDigit = [&](std::size_t i) { return std::isdigit(static_cast<unsigned char>(name[i])) != 0; };
  const std::size_t dot = name.find_last_of('.');
  std::size_t end = dot == std::string::npos || dot == 0 || dot + 5 < name.size() ? name.size() : dot;
  while (end > 0 && !isDigit(end - 1)) --end;
  std::size_t begin = end;
  while (begin > 0 && isDigit(begin - 1) && end - begin < 18) --begin;
  if (begin == end) return std::nullopt;
  return std::strtoll(name.substr(begin, end - begin).c_str(), nullptr, 10);
}

/// The median of the steps from frame to frame inside a room; nothing when names hold no rising numbers.
std::optional<long long> usualStep(const std::vector<Frame>& frames) {
  std::vector<long long> steps;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    if (frames[i].room != frames[i - 1].room) continue;
    const auto from = numberOf(frames[i - 1].name), to = numberOf(frames[i].name);
    if (from && to && *to > *from) steps.push_back(*to - *from);
  }
  if (steps.empty()) return std::nullopt;
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  return steps[steps.size() / 2];
}

struct Run {
  std::size_t first, size;
};

/// Halves the longest runs until there are `least`, or only single frames.
void cut(std::vector<Run>& runs, std::size_t least) {
  while (runs.size() < least) {
    const auto longest = std::max_element(runs.begin(), runs.end(),
                                          [](const Run& a, const Run& b) { return a.size < b.size; });
    if (longest->size < 2) return;
    const std::size_t half = longest->size / 2;
    const Run rest{longest->first + half, longest->size - half};
    longest->size = half;
    runs.push_back(rest);
  }
}

}  // namespace

std::vector<int> runsOfRooms(const std::vector<Frame>& frames, int least) {
  const std::optional<long long> step = usualStep(frames);
  const auto follows = [&](std::size_t i) {
    if (frames[i].room != frames[i - 1].room) return false;
    const auto from = numberOf(frames[i - 1].name), to = numberOf(frames[i].name);
    return !step || !from || !to || (*to >= *from && *to - *from <= 2 * *step);
  };
  std::map<std::string, std::vector<Run>> runs;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    auto& ofRoom = runs[frames[i].room];
    if (i > 0 && follows(i))
      ++ofRoom.back().size;
    else
      ofRoom.push_back({i, 1});
  }
  std::vector<int> groups(frames.size());
  int group = 0;
  for (auto& [room, ofRoom] : runs) {
    cut(ofRoom, static_cast<std::size_t>(std::max(least, 1)));
    for (const Run& run : ofRoom) {
      const auto first = groups.begin() + static_cast<std::ptrdiff_t>(run.first);
      std::fill(first, first + static_cast<std::ptrdiff_t>(run.size), group++);
    }
  }
  return groups;
}

std::vector<int> groupedFolds(const std::vector<int>& classes, const std::vector<int>& groups, int folds,
                              std::uint64_t seed) {
  std::map<int, std::map<int, double>> counts;  // of the classes in each group
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

  // A class counts by its shares: adding `part` of it to a fold that holds `share` adds to the sum of
  // squares.
  std::vector<std::map<int, double>> shares(static_cast<std::size_t>(folds));
  std::vector<double> sizes(shares.size());
  std::map<int, int> foldOf;
  for (const int group : order) {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t f = 0; f < shares.size(); ++f) {
      double cost = 0;
      for (const auto& [c, count] : counts[group]) {
        const double part = count / totals[c];
        cost += part * (part + 2 * shares[f][c]);
      }
      cost += 1e-9 * sizes[f];  // among equals the emptiest
      if (cost < least) {
        least = cost;
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
