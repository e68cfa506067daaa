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

}  // namespace estancia
