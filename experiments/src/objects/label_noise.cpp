#include "experiments/src/objects/label_noise.hpp"

#include <fmt/format.h>

#include <map>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/objects/pseudo_labels.hpp"

namespace estancia {

ClassProbabilities withNoise(const ClassProbabilities& answers, NoiseKind kind, double rate,
                             std::span<const int> instances, std::uint64_t seed) {
  if (!(rate >= 0 && rate <= 1))
    throw Error(ErrorCode::invalidOption, fmt::format("the noise rate is {}; give 0 to 1", rate));
  const std::size_t classes = answers.probabilities.labels();
  // Objects whose samples change alike, in order, and their classes.
  const bool together = kind == NoiseKind::instance;
  std::vector<int> numbers(answers.probabilities.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  const std::span<const int> objectOf = together ? instances : numbers;
  const std::vector<int> classOf = assignPseudoLabels(together ? PseudoLabeling::voted : PseudoLabeling::top,
                                                      answers, objectOf, {{}, {}, DescriptorMatrix(0)}, {});
  std::map<int, std::vector<std::size_t>> samples;
  for (std::size_t i = 0; i < objectOf.size(); ++i) samples[objectOf[i]].push_back(i);
  std::vector<std::vector<std::size_t>> objects;
  std::vector<int> labels;
  for (auto& [object, list] : samples) {
    labels.push_back(classOf[list.front()]);
    objects.push_back(std::move(list));
  }
  std::vector<std::size_t> order;
  std::size_t labeled = 0;
  for (std::size_t t = 0; t < objects.size(); ++t)
    if (labels[t] >= 0) {
      order.push_back(t);
      labeled += objects[t].size();
    }
  std::mt19937_64 random(seed);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);

  const double wanted = rate * static_cast<double>(labeled);
  std::vector<float> values = answers.probabilities.values();
  double done = 0;
  for (const std::size_t t : order) {
    const double half = static_cast<double>(objects[t].size()) / 2;
    if (classes < 2 || done + half > wanted) break;
    done += 2 * half;
    const auto label = static_cast<std::size_t>(labels[t]);
    const std::size_t other =
        (label + (kind == NoiseKind::pair ? 1 : 1 + random() % (classes - 1))) % classes;
    for (const std::size_t i : objects[t])
      std::swap(values[i * classes + label], values[i * classes + other]);
  }
  ClassProbabilities noisy{DescriptorMatrix(classes), answers.coverage};
  for (std::size_t i = 0; i < answers.probabilities.size(); ++i)
    noisy.probabilities.append(std::span(values).subspan(i * classes, classes));
  return noisy;
}

}  // namespace estancia
