// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/word_graph.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

constexpr int walkSteps = 6;
constexpr float persistence = 0.9F;
/// Edges ahead whose neighbors are fetched: they are anywhere in memory; waiting for them is most of a walk.
constexpr std::size_t edgesAhead = 24;

/// Walkers that go side by side: row-major, one row of `lanes` values a synset. One step of all of them is
/// either from where they are (spread) or to each synset from its neighbors (gather), with the same sums.
template <std::size_t lanes>
class SideBySide {
 public:
  SideBySide(const WordGraph& graph, std::span<const std::vector<Sense>> starts)
      : graph_(graph), start_(graph.size() * lanes, 0), leaving_(start_.size()) {
    for (std::size_t w = 0; w < starts.size(); ++w)
      for (const Sense& sense : starts[w]) start_[sense.synset * lanes + w] += sense.probability;
  }

  std::vector<float> walk() {
    std::vector<float> visits = start_;
    for (int step = 0; step < walkSteps; ++step) {
      if (leave(visits) < graph_.edgeTargets.size() / 4)
        spread(visits);  // few synsets have been reached
      else
        gather(visits);
      for (std::size_t at = 0; at < visits.size(); ++at)
        visits[at] = persistence * visits[at] + (1 - persistence) * start_[at];
    }
    return visits;
  }

 private:
  /// Sets what leaves along each unit of an edge; how many edges walkers may take.
  std::size_t leave(const std::vector<float>& visits) {
    std::size_t edges = 0;
    for (std::size_t i = 0; i < graph_.size(); ++i) {
      bool leaves = false;
      for (std::size_t at = i * lanes; at < (i + 1) * lanes; ++at) {
        leaving_[at] = graph_.degrees[i] > 0 ? visits[at] / graph_.degrees[i] : 0;
        leaves |= leaving_[at] > 0;
      }
      if (leaves) edges += graph_.edgeStarts[i + 1] - graph_.edgeStarts[i];
    }
    return edges;
  }

  void spread(std::vector<float>& arrived) const {
    std::fill(arrived.begin(), arrived.end(), 0.0F);
    for (std::size_t i = 0; i < graph_.size(); ++i) {
      const float* from = &leaving_[i * lanes];
      if (std::all_of(from, from + lanes, [](float p) { return p == 0; })) continue;
      for (std::uint32_t e = graph_.edgeStarts[i]; e < graph_.edgeStarts[i + 1]; ++e) {
        float* to = &arrived[graph_.edgeTargets[e] * lanes];
        for (std::size_t w = 0; w < lanes; ++w) to[w] += graph_.edgeWeights[e] * from[w];
      }
    }
  }

  void gather(std::vector<float>& arrived) const {
    const std::size_t last = graph_.edgeTargets.size() - 1;
    for (std::size_t i = 0; i < graph_.size(); ++i) {
      std::array<float, lanes> sums{};
      for (std::uint32_t e = graph_.edgeStarts[i]; e < graph_.edgeStarts[i + 1]; ++e) {
        if constexpr (lanes > 2)
          __builtin_prefetch(&leaving_[graph_.edgeTargets[std::min(e + edgesAhead, last)] * lanes]);
        const float* from = &leaving_[graph_.edgeTargets[e] * lanes];
        for (std::size_t w = 0; w < lanes; ++w) sums[w] += graph_.edgeWeights[e] * from[w];
      }
      std::copy(sums.begin(), sums.end(), arrived.begin() + static_cast<std::ptrdiff_t>(i * lanes));
    }
  }

  const WordGraph& graph_;
  std::vector<float> start_, leaving_;
};

/// Appends the walks from up to `lanes` starts.
template <std::size_t lanes>
void appendWalks(const WordGraph& graph, std::span<const std::vector<Sense>> starts,
                 std::vector<std::vector<float>>& walks) {
  const std::vector<float> visits = SideBySide<lanes>(graph, starts).walk();
  for (std::size_t w = 0; w < starts.size(); ++w) {
    std::vector<float>& walk = walks.emplace_back(graph.size());
    for (std::size_t i = 0; i < walk.size(); ++i) walk[i] = visits[i * lanes + w];
  }
}

}  // namespace

std::string_view WordGraph::name(std::uint32_t synset) const {
  return std::string_view(nameText).substr(nameStarts[synset], nameStarts[synset + 1] - nameStarts[synset]);
}

PartOfSpeech WordGraph::pos(std::uint32_t synset) const {
  const auto& first = lexicon.firstSynset;
  return static_cast<PartOfSpeech>(std::upper_bound(first.begin(), first.end() - 1, synset) - first.begin() -
                                   1);
}

void WordGraph::sumDegrees() {
  degrees.assign(size(), 0);
  degreeSum = 0;
  for (std::size_t i = 0; i < size(); ++i) {
    for (std::uint32_t e = edgeStarts[i]; e < edgeStarts[i + 1]; ++e) degrees[i] += edgeWeights[e];
    degreeSum += static_cast<double>(degrees[i]);
  }
}

std::vector<float> WordGraph::walk(std::span<const Sense> from) const {
  const std::vector<Sense> start(from.begin(), from.end());
  return SideBySide<1>(*this, {&start, 1}).walk();
}

std::vector<float> WordGraph::walkTogether(std::span<const std::vector<Sense>> starts) const {
  if (starts.size() > together)
    fail(ErrorCode::invalidInput, "walkTogether: at most {} starts, not {}", together, starts.size());
  return SideBySide<together>(*this, starts).walk();
}

std::vector<std::vector<float>> WordGraph::walkEach(std::span<const std::vector<Sense>> starts) const {
  std::vector<std::vector<float>> walks;
  for (; starts.size() > 4; starts = starts.subspan(std::min(starts.size(), together)))
    appendWalks<together>(*this, starts.first(std::min(starts.size(), together)), walks);
  if (starts.size() > 2)
    appendWalks<4>(*this, starts, walks);
  else if (starts.size() == 2)
    appendWalks<2>(*this, starts, walks);
  else if (starts.size() == 1)
    walks.push_back(walk(starts.front()));
  return walks;
}

double WordGraph::lift(const std::vector<float>& visits, std::uint32_t synset) const {
  if (degrees[synset] <= 0) return minLift;
  const double ratio = static_cast<double>(visits[synset]) * degreeSum / static_cast<double>(degrees[synset]);
  return std::log(ratio + std::exp(minLift));
}

std::vector<std::pair<std::uint32_t, int>> WordGraph::hypernyms(std::uint32_t synset) const {
  std::vector<std::pair<std::uint32_t, int>> found{{synset, 0}};
  for (std::size_t next = 0; next < found.size(); ++next) {
    const auto [at, distance] = found[next];
    for (std::uint32_t e = edgeStarts[at]; e < edgeStarts[at + 1]; ++e) {
      if (static_cast<WordLink>(edgeLinks[e]) != WordLink::kindOf) continue;
      const std::uint32_t above = edgeTargets[e];
      if (std::none_of(found.begin(), found.end(), [&](const auto& known) { return known.first == above; }))
        found.emplace_back(above, distance + 1);
    }
  }
  return found;
}

}  // namespace estancia
