#include "estancia/objects/pseudo_labels.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>

#include "estancia/core/error.hpp"
#include "estancia/core/log_opinion_pool.hpp"
#include "estancia/objects/confident_learning.hpp"
#include "estancia/objects/learning.hpp"

namespace estancia {
namespace {

constexpr PseudoLabeling all[] = {PseudoLabeling::top, PseudoLabeling::voted, PseudoLabeling::confident};

/// −1 where nothing is said.
int likeliest(DescriptorView shares) {
  const auto best = std::ranges::max_element(shares);
  return best == shares.end() || !(*best > 0) ? -1 : static_cast<int>(best - shares.begin());
}

std::vector<int> likeliestOfEach(const DescriptorMatrix& shares) {
  std::vector<int> words;
  for (std::size_t i = 0; i < shares.size(); ++i) words.push_back(likeliest(shares.row(i)));
  return words;
}

void requireAsMany(const ClassProbabilities& shares, std::size_t others, const char* what) {
  if (shares.shares.size() != others)
    throw Error(fmt::format("{} samples have answers, but {} have {}; give one each", shares.shares.size(),
                            others, what));
}

/// The samples of each thing, the things in ascending order.
std::vector<std::vector<std::size_t>> samplesOf(std::span<const int> instances) {
  std::map<int, std::vector<std::size_t>> samples;
  for (std::size_t i = 0; i < instances.size(); ++i) samples[instances[i]].push_back(i);
  std::vector<std::vector<std::size_t>> lists;
  lists.reserve(samples.size());
  for (auto& [instance, list] : samples) lists.push_back(std::move(list));
  return lists;
}

/// The word of each thing, by all that is said of its samples; −1 where nothing is.
std::vector<int> poolOf(const ClassProbabilities& shares,
                        const std::vector<std::vector<std::size_t>>& things) {
  std::vector<int> words;
  for (const auto& samples : things) {
    LogOpinionPool pool(shares.shares.labels());
    for (const std::size_t i : samples) pool.add(shares.shares.row(i));
    const std::vector<double> pooled = pool.pooled();
    words.push_back(pooled.empty() ? -1
                                   : static_cast<int>(std::ranges::max_element(pooled) - pooled.begin()));
  }
  return words;
}

std::vector<int> voted(const ClassProbabilities& shares, std::span<const int> instances) {
  const auto things = samplesOf(instances);
  const std::vector<int> wordOf = poolOf(shares, things);
  std::vector<int> words(instances.size());
  for (std::size_t t = 0; t < things.size(); ++t)
    for (const std::size_t i : things[t]) words[i] = wordOf[t];
  return words;
}

std::vector<int> confident(const ClassProbabilities& shares, std::span<const int> instances,
                           const Features& shapes, const ClassifierOptions& options, Progress& progress) {
  requireAsMany(shares, shapes.values.size(), "a shape");
  std::vector<int> words = likeliestOfEach(shares.shares);
  std::vector<int> known = words;
  std::ranges::sort(known);
  if (known.empty() || std::max(known.front(), 0) >= known.back())
    return words;  // no two words to tell apart
  const NamedShapes named = namedShapes(shapes, words, instances, shares.shares.labels(), options.folds);
  for (const std::size_t i : likelyMisnamed(named.samples.classes, heldOut(named.samples, options, progress)))
    words[named.rows[i]] = -1;
  return words;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> pseudoLabelings() {
  return {{"top", "the likeliest word of each sample, as in the thesis"},
          {"voted", "one word an instance, of all that was said of its samples together"},
          {"confident", "as top, without the samples that the shapes of the others speak against"}};
}

PseudoLabeling getPseudoLabeling(const std::string& name) {
  std::vector<std::string> known;
  for (const auto& [known_, explanation] : pseudoLabelings()) known.push_back(known_);
  const auto found = std::ranges::find(known, name);
  if (found == known.end())
    throw Error(fmt::format("no way of naming is called \"{}\"; there are {}", name, fmt::join(known, ", ")));
  return all[found - known.begin()];
}

std::vector<int> assignPseudoLabels(PseudoLabeling naming, const ClassProbabilities& shares,
                                    std::span<const int> instances, const Features& shapes,
                                    const ClassifierOptions& options, Progress& progress) {
  requireAsMany(shares, instances.size(), "an instance");
  switch (naming) {
    case PseudoLabeling::top:
      return likeliestOfEach(shares.shares);
    case PseudoLabeling::voted:
      return voted(shares, instances);
    case PseudoLabeling::confident:
      return confident(shares, instances, shapes, options, progress);
  }
  throw Error("an unknown way of naming");
}

ClassProbabilities withNoise(const ClassProbabilities& shares, NoiseKind kind, double rate,
                             std::span<const int> instances, std::uint64_t seed) {
  if (!(rate >= 0 && rate <= 1)) throw Error(fmt::format("a share of noise is 0 to 1, not {}", rate));
  const std::size_t words = shares.shares.labels();
  std::vector<std::vector<std::size_t>> things;  // that are misnamed alike, and what they are called
  std::vector<int> names;
  if (kind == NoiseKind::instance) {
    requireAsMany(shares, instances.size(), "an instance");
    things = samplesOf(instances);
    names = poolOf(shares, things);
  } else {
    for (std::size_t i = 0; i < shares.shares.size(); ++i) things.push_back({i});
    names = likeliestOfEach(shares.shares);
  }
  std::vector<std::size_t> order;
  std::size_t named = 0;
  for (std::size_t t = 0; t < things.size(); ++t)
    if (names[t] >= 0) {
      order.push_back(t);
      named += things[t].size();
    }
  std::mt19937_64 random(seed);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);

  const double wanted = rate * static_cast<double>(named);
  std::vector<float> values = shares.shares.values();
  double done = 0;
  for (const std::size_t t : order) {
    const double half = static_cast<double>(things[t].size()) / 2;
    if (words < 2 || done + half > wanted) break;
    done += 2 * half;
    const auto name = static_cast<std::size_t>(names[t]);
    const std::size_t other = (name + (kind == NoiseKind::pair ? 1 : 1 + random() % (words - 1))) % words;
    for (const std::size_t i : things[t]) std::swap(values[i * words + name], values[i * words + other]);
  }
  ClassProbabilities noisy{DescriptorMatrix(words), shares.mass};
  for (std::size_t i = 0; i < shares.shares.size(); ++i)
    noisy.shares.append(std::span(values).subspan(i * words, words));
  return noisy;
}

}  // namespace estancia
