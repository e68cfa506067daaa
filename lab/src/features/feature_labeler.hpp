// Feature labeler: makes any image descriptor a labeler, so that it is mapped as words are.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/describe/descriptor.hpp"
#include "estancia/labelers/labeler.hpp"
#include "features/local_features.hpp"
#include "features/visual_vocabulary.hpp"

namespace estancia::experiments {

/// Its labels are NAME 0, NAME 1 …
class FeatureLabeler final : public Labeler {
 public:
  /// Returns one value in [0, 1] a label for a BGR image; safe to call from several threads.
  using Describe = std::function<std::vector<float>(const cv::Mat& image)>;

  /// `identity` identifies everything that the values depend on.
  FeatureLabeler(const std::string& name, std::size_t values, std::string identity, Describe describe);

  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return identity_; }
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override;
  LexicalDescriptor infer(const Prepared& prepared) override;

 private:
  std::string name_, identity_;
  Vocabulary vocabulary_;
  Describe describe_;
};

/// The local features of the images that visual vocabularies are learned from; called once, when the first
/// image is described.
struct VocabularyImages {
  /// Digest of the images.
  std::string digest;
  std::function<std::vector<cv::Mat>(LocalFeature feature)> features;
};

struct VocabularySizes {
  /// Words of bags of words: as many as the default network has labels.
  std::size_t words = 1000;
  /// Words of VLAD: with SIFT as many values as the default network's last inner layer.
  std::size_t vladWords = 16;
  std::uint64_t seed = 1;
};

/// orb-words, sift-words, orb-vlad, sift-vlad, phog, gist.
Choices featureTypes();
/// Whether it needs a vocabulary.
bool needsVocabulary(const std::string& type);
/// How its values are compared by classifiers.
PartKind kindOfFeature(const std::string& type);

/// One of featureTypes(). Values ≥ 0 become shares of their sum, VLAD's v becomes (1 + v) / 2: its distances
/// are half as long. Throws Error (unknownName).
std::unique_ptr<Labeler> makeFeatureLabeler(const std::string& type, const VocabularyImages& images,
                                            const VocabularySizes& sizes = {});

/// 1 for each visual word that an image shows, else 0.
std::unique_ptr<Labeler> makeShownWordLabeler(LocalFeature feature, const VocabularyImages& images,
                                              const VocabularySizes& sizes = {});

}  // namespace estancia::experiments
