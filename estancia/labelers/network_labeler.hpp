// Network labeler: what the engines that run networks share; images → inputs, outputs → probabilities.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/labelers/model_spec.hpp"

namespace estancia {

/// `output` holds one row of numbers, or with spec.reduce several (R×outputs, row by row; a detector's
/// anchors): the softmax or sigmoid that `spec` asks for makes them probabilities, each output takes its
/// highest of all rows, and those in spec.unused are dropped. Values after a sigmoid do not add up to 1.
/// With spec.features they become shares of their sum. Throws Error unless this gives `labels` probabilities.
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

/// Base of the engines that run a neural network. Life cycle: the derived constructor opens the network,
/// chooses its output and calls tryOut(). Invariant afterwards: each row of an answer has one value a label
/// of the vocabulary.
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

  /// The network's output as probabilities, see toProbabilities(). With text embeddings, the output is an
  /// image's embedding: its cosines with the texts become logits, and these by softmax probabilities.
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

/// cv::resize() with INTER_AREA of an image CV_8UC3 to a size that is nowhere larger, three times as fast if
/// ratios are no integers; values within one of OpenCV's. Throws cv::Exception on other types and sizes.
cv::Mat resizeByArea(const cv::Mat& image, cv::Size size);

}  // namespace estancia
