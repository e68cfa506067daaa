// Labels of a sequence: a descriptor sequence that Python shares, with what was wrong with its frames.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "estancia/sequences/descriptor_sequence.hpp"

namespace estancia::python {

struct SequenceLabels {
  std::shared_ptr<const DescriptorSequence> sequence;
  /// Sentences about frames that were left out.
  std::vector<std::string> problems = {};
};

}  // namespace estancia::python
