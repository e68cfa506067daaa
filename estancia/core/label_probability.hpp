// Label probability: a label by its name, with its probability.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace estancia {

/// One answer of a labeler without a fixed vocabulary: a program, a service, a person.
struct LabelProbability {
  std::string label;
  /// In [0, 1].
  float probability = 0;
};

}  // namespace estancia
