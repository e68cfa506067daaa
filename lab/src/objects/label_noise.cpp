// SPDX-License-Identifier: Apache-2.0
#include "objects/label_noise.hpp"

#include <fmt/format.h>

#include <map>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/objects/pseudo_labels.hpp"

namespace estancia::experiments {
namespace {

/// Samples that change alike, and the class that they are taken for; −1: none.
struct Group {
  std::vector<std::size_t> samples;
  int label = -1;
};

/// By instance in ascending order, or each sample for itself.
std::vector<Group> groupsOf(const ClassProbabilities& answers, NoiseKind kind,
                            std::span<const int> instances) {
  std::vector<int> own(answers.probabilities.size());
  std::iota(own.begin(), own.end(), 0);
  if (kind != NoiseKind::instance) instances = own;
  const PseudoLabeling labeling = kind == NoiseKind::instance ? PseudoLabeling::voted : PseudoLabeling::top;
  const Features none{{}, {}, DescriptorMatrix(0)};
  const std::vector<int> labels = assignPseudoLabels(labeling, answers, instances, none, {});
  std::map<int, Group> byInstance;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    Group& group = byInstance[instances[i]];
    group.samples.push_back(i);
    group.label = labels[i];
  }
  std::vector<Group> groups;
  for (auto& [instance, group] : byInstance) groups.push_back(std::move(group));
  return groups;
}

}  // namespace

ClassProbabilities withNoise(const ClassProbabilities& answers, NoiseKind kind, double rate,
                             std::span<const int> instances, std::uint64_t seed) {
  if (!(rate >= 0 && rate <= 1))
    throw Error(ErrorCode::invalidOption, fmt::format("the noise rate is {}; give 0 to 1", rate));
  const std::size_t classes = answers.probabilities.labels();
  std::vector<Group> groups = groupsOf(answers, kind, instances);
  std::erase_if(groups, [](const Group& group) { return group.label < 0; });
  std::size_t labeled = 0;
  for (const Group& group : groups) labeled += group.samples.size();
  std::mt19937_64 random(seed);
  for (std::size_t i = groups.size(); i > 1; --i) std::swap(groups[i - 1], groups[random() % i]);

  const double wanted = rate * static_cast<double>(labeled);
  std::vector<float> values = answers.probabilities.values();
  double done = 0;
  for (const Group& group : groups) {
    const double half = static_cast<double>(group.samples.size()) / 2;
    if (classes < 2 || done + half > wanted) break;
    done += 2 * half;
    const auto label = static_cast<std::size_t>(group.label);
    const std::size_t other =
        (label + (kind == NoiseKind::pair ? 1 : 1 + random() % (classes - 1))) % classes;
    for (const std::size_t i : group.samples)
      std::swap(values[i * classes + label], values[i * classes + other]);
  }
  ClassProbabilities noisy{DescriptorMatrix(classes), answers.coverage};
  for (std::size_t i = 0; i < answers.probabilities.size(); ++i)
    noisy.probabilities.append(std::span(values).subspan(i * classes, classes));
  return noisy;
}

}  // namespace estancia::experiments
