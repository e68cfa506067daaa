// FAB-MAP: places recognized by the visual words that images show, and by which words come together (Cummins
// and Newman, FAB-MAP: Probabilistic localization and mapping in the space of appearance, IJRR 27, 2008).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia::experiments {

/// How words depend on each other: each word on one other, its parent (Chow and Liu 1968).
struct ChowLiuTree {
  /// The root, word 0, is its own parent.
  std::vector<std::size_t> parent;
  /// p(z = 1): the probability that an image shows the word.
  std::vector<double> shown;
  /// p(z = 1 | z of the parent = 0), p(z = 1 | z of the parent = 1); of the root, p(z = 1) twice.
  std::vector<std::array<double, 2>> shownGivenParent;
};

/// The spanning tree with the largest sum of mutual information between its neighbors, which is the one that
/// makes the images most probable. `images` has a row an image: 1 for each word that it shows, else 0. Each
/// of the four cases of two words counts half an image more than there are, so that none is impossible.
/// O(words² · images). Throws Error (insufficientData) without words or images.
ChowLiuTree learnChowLiuTree(const DescriptorMatrix& images);

/// All four are those of the example that comes with the code of the paper's authors, for 11,000 words of
/// SURF, and of openFABMAP (Glover et al., ICRA 2012; OpenCV's of2); none was tuned here.
struct FabMapOptions {
  /// Detector: p(z = 1 | e = 1) and p(z = 1 | e = 0) of a word that is there (e = 1), or not.
  double hit = 0.39, falseAlarm = 0;
  /// Prior probability that an image shows a place that is not known yet. So have it openFABMAP and the
  /// authors' prior without motion; with motion, the authors give it only to the way that leads beyond the
  /// last place.
  double newPlace = 0.9;
  /// Weight of the posterior, the rest being evenly distributed: images that follow each other err together.
  /// So has it openFABMAP; the authors smooth the likelihoods, before the prior.
  double smoothing = 0.99;
};

/// Places that are known by one image each. All rows and images have 1 for a word that is shown, else 0.
class FabMap {
 public:
  /// `learned`: images of elsewhere, to learn the tree from, and to stand for new places ("sampling").
  explicit FabMap(DescriptorMatrix learned, const FabMapOptions& options = {});

  /// ln p(image | place) for each place.
  std::vector<double> logLikelihoods(DescriptorView image, const DescriptorMatrix& places) const;
  /// ln of the mean likelihood of the places that were learned.
  double logLikelihoodOfNew(DescriptorView image) const;

  struct Answer {
    /// The likeliest place by this image alone, and the most probable by all so far.
    std::size_t byImage = 0, byAll = 0;
    /// The probability of a new place, by all images so far.
    double unknown = 0;
  };
  /// Answers image by image, by the Bayes rule. The robot is next in the place itself, before or behind it in
  /// the order of `places` with a third each, or somewhere new. Throws Error (insufficientData) without
  /// places, (mismatch) for images of other words.
  std::vector<Answer> recognize(const DescriptorMatrix& images, const DescriptorMatrix& places) const;

 private:
  DescriptorMatrix learned_;
  FabMapOptions options_;
  ChowLiuTree tree_;
  /// ln p(z = s | z of the parent = t, a place whose image has z = b) of each word, at 4 s + 2 t + b.
  std::vector<std::array<double, 8>> terms_;
};

}  // namespace estancia::experiments
