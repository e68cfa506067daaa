// Network scores: the output of a network, or its cosines with text embeddings (CLIP) → probabilities.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/labelers/model_spec.hpp"

namespace estancia {

/// `output` holds one row of numbers, or with spec.reduce several (R×outputs, row by row; a detector's
/// anchors): the softmax or sigmoid that `spec` asks for makes them probabilities, each output takes its
/// highest of all rows, and those in spec.unused are dropped. Values after a sigmoid do not add up to 1.
/// With spec.features they become shares of their sum. Throws Error naming the model unless this gives
/// `labels` probabilities.
LexicalDescriptor toProbabilities(std::span<const float> output, const ModelSpec& spec, std::size_t labels);

/// Where words stand in the space that an image encoder shares with a text encoder. Radford et al., Learning
/// transferable visual models from natural language supervision (CLIP), ICML 2021.
class TextEmbeddings {
 public:
  /// Reads a .npy file, `labels`×D, row i for label i, and brings the rows to length 1. Throws Error when it
  /// is damaged, has another number of rows, or a row that is not finite or nothing but 0.
  TextEmbeddings(const std::filesystem::path& file, std::size_t labels);

  /// `scale` times the cosine of the angle between the image and each text: one logit a label. Throws Error
  /// naming `model` unless the image has D values, finite and not all 0.
  std::vector<float> logits(std::span<const float> image, double scale, const std::string& model) const;

 private:
  std::size_t dimensions_ = 0;
  std::vector<float> rows_;
};

}  // namespace estancia
