// Visual vocabulary: local features clustered into visual words, and images described by these.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace estancia::experiments {

/// Invariant: at least one word; one idf a word.
struct VisualVocabulary {
  /// Means of clusters of local features, one a row, CV_32F.
  cv::Mat words;
  /// Inverse document frequencies: ln(images / images with the word), ≥ 0.
  std::vector<float> idf;
};

struct VisualVocabularyOptions {
  std::size_t words = 1000;
  /// Local features that are clustered, evenly drawn from the images.
  std::size_t sampled = 30'000;
  std::uint64_t seed = 1;
};

/// Clusters the local features of images (localFeatures()) by k-means. The result does not depend on the
/// number of threads. Throws Error (insufficientData) when there are fewer features than words, (mismatch)
/// when they are not as long as each other.
VisualVocabulary learnVisualVocabulary(const std::vector<cv::Mat>& images,
                                       const VisualVocabularyOptions& options = {});

/// The word that each feature is nearest to. Throws Error (mismatch) for features of another length.
std::vector<std::size_t> wordsOf(const VisualVocabulary& vocabulary, const cv::Mat& features);

/// Bag of visual words: the share of each word, weighted by its idf (Sivic and Zisserman 2003). A
/// distribution over the words; all alike where an image has no features, or but words that all images have.
std::vector<float> bagOfWords(const VisualVocabulary& vocabulary, const cv::Mat& features);

/// Vector of locally aggregated descriptors: for each word the sum of its features' differences from it, then
/// the signed root of each value, and length 1 (Jégou et al. 2012). Words × dimensions; all 0 without
/// features.
std::vector<float> vlad(const VisualVocabulary& vocabulary, const cv::Mat& features);

}  // namespace estancia::experiments
