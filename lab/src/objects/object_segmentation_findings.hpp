// Segmentation findings: tables and images of the segmentation experiment.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "estancia/findings/findings.hpp"
#include "objects/object_segmentation_score.hpp"
#include "objects/segmentation_measures.hpp"

namespace estancia::experiments {

/// What was found in one scene.
struct SegmentedScene {
  std::string name, category;
  SegmentationScore ours, euclidean;
  /// Sums over scenes where several are added.
  SegmentationMeasures measures, euclideanMeasures;
  std::size_t scenes = 1;
  /// Photographed objects that are reported as flat.
  std::size_t postersTold = 0;
  /// Objects that are.
  std::size_t takenForFlat = 0;
};

/// Score by category and over all, posters. The images are the caller's.
Findings findingsOf(const std::vector<SegmentedScene>& scenes);

/// Scenes from the best to the worst.
std::vector<std::size_t> bestFirst(const std::vector<SegmentedScene>& scenes);

/// The image, its objects and the clusters side by side, as a JPEG; each object in a color of its own.
std::vector<unsigned char> segmentationImage(const cv::Mat& bgr, const cv::Mat& truth,
                                             const std::vector<PixelSet>& clusters);

}  // namespace estancia::experiments
