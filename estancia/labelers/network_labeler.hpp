// Network labeler: what the engines that run networks share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/labelers/labeler.hpp"
#include "estancia/labelers/model_spec.hpp"
#include "estancia/labelers/scores.hpp"

namespace estancia {

class NetworkLabeler : public Labeler {
 public:
  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return identity_; }
  std::string cacheKey() const override { return identity_ + " " + engine_; }
  int imageSide() const override;
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override;
  std::vector<std::size_t> regionLabels() const override;

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

  /// Words of the default boxes that look at each region. Throws Error (invalidInput) where it is not known
  /// where they look, and (mismatch) when they are not those that model.toml names.
  std::vector<LexicalDescriptor> toWordsOfRegions(std::span<const float> output,
                                                  std::span<const cv::Rect2d> regions) const;

  [[noreturn]] void failOnInput(const std::string& reason) const;

 private:
  ModelSpec spec_;
  Vocabulary vocabulary_;
  std::string identity_, engine_;
  std::optional<TextEmbeddings> texts_;
  std::vector<cv::Rect2d> boxes_;  ///< boxes of the output's rows; empty if unknown
};

/// The image as float32 blob 1×3×height×width. Takes 1 (gray), 3 (BGR) or 4 (BGRA; alpha is dropped) channels
/// of 8 or 16 bits, any size. Throws Error on anything else.
cv::Mat preprocess(const cv::Mat& image, const Preprocessing& how);

}  // namespace estancia
