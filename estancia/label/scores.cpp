#include "estancia/label/scores.hpp"

#include <algorithm>
#include <cmath>

namespace estancia {
namespace {

/// Numerically safe: the largest exponent is 0. NaN stays NaN.
void softmaxInPlace(LexicalDescriptor& values) {
  const float largest = *std::max_element(values.begin(), values.end());
  double sum = 0;
  for (float& v : values) {
    v = std::exp(v - largest);
    sum += v;
  }
  for (float& v : values) v = static_cast<float>(v / sum);
}

}  // namespace

LexicalDescriptor toProbabilities(std::span<const float> output, const ModelSpec& spec, std::size_t labels) {
  LexicalDescriptor values(output.begin(), output.end());
  if (spec.softmax && !values.empty()) softmaxInPlace(values);
  requireProbabilities(values, labels, "model " + spec.name);
  return values;
}

Scores::Scores(const ModelSpec& spec, std::size_t labels) : spec_(spec), labels_(labels) {
  if (spec.embeddings.empty()) return;
  texts_.emplace(modelFile(spec, spec.embeddings), labels);
  spec_.softmax = true;
}

LexicalDescriptor Scores::operator()(std::span<const float> output) const {
  if (!texts_) return toProbabilities(output, spec_, labels_);
  return toProbabilities(texts_->logits(output, spec_.logitScale, spec_.name), spec_, labels_);
}

}  // namespace estancia
