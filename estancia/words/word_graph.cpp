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
/// Edges ahead whose neighbors are fetched: they are anywhere in memory, and waiting for them is most of a
/// walk.
constexpr std::size_t edgesAhead = 24;

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
  std::vector<float> start(size(), 0), leaving(size());
  for (const Sense& sense : from) start[sense.synset] += sense.probability;
  std::vector<float> visits = start;
  for (int step = 0; step < walkSteps; ++step) {
    std::size_t edges = 0;  // that walkers may take
    for (std::size_t i = 0; i < size(); ++i) {
      leaving[i] = degrees[i] > 0 ? visits[i] / degrees[i] : 0;
      if (leaving[i] > 0) edges += edgeStarts[i + 1] - edgeStarts[i];
    }
    if (edges < edgeTargets.size() / 4)
      spread(leaving, visits);  // few have been reached: from them outward
    else
      gather(leaving, visits);
    for (std::size_t i = 0; i < size(); ++i)
      visits[i] = persistence * visits[i] + (1 - persistence) * start[i];
  }
  return visits;
}

void WordGraph::spread(const std::vector<float>& leaving, std::vector<float>& arrived) const {
  std::fill(arrived.begin(), arrived.end(), 0.0F);
  for (std::size_t i = 0; i < size(); ++i)
    if (leaving[i] > 0)
      for (std::uint32_t e = edgeStarts[i]; e < edgeStarts[i + 1]; ++e)
        arrived[edgeTargets[e]] += edgeWeights[e] * leaving[i];
}

void WordGraph::gather(const std::vector<float>& leaving, std::vector<float>& arrived) const {
  for (std::size_t i = 0; i < size(); ++i) {
    float sum = 0;
    for (std::uint32_t e = edgeStarts[i]; e < edgeStarts[i + 1]; ++e)
      sum += edgeWeights[e] * leaving[edgeTargets[e]];
    arrived[i] = sum;
  }
}

std::vector<float> WordGraph::walkTogether(std::span<const std::vector<Sense>> starts) const {
  if (starts.size() > together)
    fail(ErrorCode::invalidInput, "walkTogether: at most {} starts, not {}", together, starts.size());
  std::vector<float> start(size() * together, 0), leaving(start.size());
  for (std::size_t w = 0; w < starts.size(); ++w)
    for (const Sense& sense : starts[w]) start[sense.synset * together + w] += sense.probability;
  std::vector<float> visits = start;
  for (int step = 0; step < walkSteps; ++step) {
    std::size_t edges = 0;
    for (std::size_t i = 0; i < size(); ++i) {
      bool leaves = false;
      for (std::size_t at = i * together; at < (i + 1) * together; ++at) {
        leaving[at] = degrees[i] > 0 ? visits[at] / degrees[i] : 0;
        leaves |= leaving[at] > 0;
      }
      if (leaves) edges += edgeStarts[i + 1] - edgeStarts[i];
    }
    if (edges < edgeTargets.size() / 4)
      spreadTogether(leaving, visits);
    else
      gatherTogether(leaving, visits);
    for (std::size_t at = 0; at < visits.size(); ++at)
      visits[at] = persistence * visits[at] + (1 - persistence) * start[at];
  }
  return visits;
}

void WordGraph::spreadTogether(const std::vector<float>& leaving, std::vector<float>& arrived) const {
  std::fill(arrived.begin(), arrived.end(), 0.0F);
  for (std::size_t i = 0; i < size(); ++i) {
    const float* from = &leaving[i * together];
    if (std::all_of(from, from + together, [](float p) { return p == 0; })) continue;
    for (std::uint32_t e = edgeStarts[i]; e < edgeStarts[i + 1]; ++e) {
      float* to = &arrived[edgeTargets[e] * together];
      for (std::size_t w = 0; w < together; ++w) to[w] += edgeWeights[e] * from[w];
    }
  }
}

void WordGraph::gatherTogether(const std::vector<float>& leaving, std::vector<float>& arrived) const {
  for (std::size_t i = 0; i < size(); ++i) {
    std::array<float, together> sums{};
    for (std::uint32_t e = edgeStarts[i]; e < edgeStarts[i + 1]; ++e) {
      __builtin_prefetch(&leaving[edgeTargets[std::min(e + edgesAhead, edgeTargets.size() - 1)] * together]);
      const float* from = &leaving[edgeTargets[e] * together];
      for (std::size_t w = 0; w < together; ++w) sums[w] += edgeWeights[e] * from[w];
    }
    std::copy(sums.begin(), sums.end(), arrived.begin() + static_cast<std::ptrdiff_t>(i * together));
  }
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
