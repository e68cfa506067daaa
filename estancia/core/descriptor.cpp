// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/descriptor.hpp"

#include <cmath>

#include "estancia/core/fail.hpp"

namespace estancia {

void DescriptorMatrix::append(DescriptorView row) {
  if (row.size() != labels_)
    fail(ErrorCode::mismatch, "a descriptor has {} labels; the matrix needs {}", row.size(), labels_);
  values_.insert(values_.end(), row.begin(), row.end());
}

void requireProbabilities(DescriptorView descriptor, std::size_t labels, const std::string& source) {
  if (descriptor.size() != labels)
    fail(ErrorCode::mismatch, "{} gave {} values for {} labels; use the label file that belongs to the model",
         source, descriptor.size(), labels);
  constexpr float slack = 1e-4F;  // softmax in float32 may exceed 1 by a few ulps
  for (std::size_t i = 0; i < labels; ++i) {
    const float p = descriptor[i];
    if (!std::isfinite(p))
      fail(ErrorCode::labelerFailure, "{} gave {} for label {}; check its preprocessing (mean, scale)",
           source, p, i);
    if (p < -slack || p > 1 + slack)
      fail(ErrorCode::labelerFailure,
           "{} gave {} for label {}, which is not a probability; does the model need softmax or sigmoid?",
           source, p, i);
  }
}

}  // namespace estancia
