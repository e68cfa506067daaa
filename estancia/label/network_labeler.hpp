// Network labeler: what the engines that run networks share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/label/labeler.hpp"
#include "estancia/label/model_spec.hpp"
#include "estancia/label/scores.hpp"

namespace estancia {

class NetworkLabeler : public Labeler {
 public:
  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return identity_; }
  std::string cacheKey() const override { return identity_ + " " + engine_; }
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override;

 protected:
  /// `engine`: its name and version.
  NetworkLabeler(const ModelSpec& spec, std::string engine);

  const ModelSpec& spec() const { return spec_; }

  /// The output to read: the only one, or the one that model.toml names. Throws Error listing them.
  std::string chooseOutput(const std::vector<std::string>& outputs) const;

  /// Labels a gray image: what does not fit shows at once.
  void tryOut();

  /// The network's output as probabilities, see toProbabilities() in scores.hpp. Where the model has text
  /// embeddings, the output is an image's embedding: its cosines with the texts become logits, and these by
  /// softmax probabilities over the words.
  LexicalDescriptor toWords(std::span<const float> output) const;

  [[noreturn]] void failOnInput(const std::string& reason) const;

 private:
  ModelSpec spec_;
  Vocabulary vocabulary_;
  std::string identity_, engine_;
  std::optional<TextEmbeddings> texts_;
};

/// The image as float32 blob 1×3×height×width. Takes 1 (gray), 3 (BGR) or 4 (BGRA; alpha is dropped) channels
/// of 8 or 16 bits, any size. Throws Error on anything else.
cv::Mat preprocess(const cv::Mat& image, const Preprocessing& how);

}  // namespace estancia
