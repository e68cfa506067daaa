// Segmentation measures: overlap and boundary precision, recall and F of clusters against objects, as
// published for learned segmentation (Dave, Tokmakov, Ramanan, ICCV Workshops 2019; Xie, Xiang, Mousavian,
// Fox, T-RO 2021).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "objects/object_segmentation_score.hpp"

namespace estancia::experiments {

struct PrecisionRecall {
  double precision = 0, recall = 0;
  /// Their harmonic mean.
  double f = 0;
};

/// Measures of one image.
struct SegmentationMeasures {
  /// Shares of the clusters' pixels, and of the objects', that lie in the assigned one of the other.
  PrecisionRecall overlap;
  /// Precision and recall of the boundary pixels, within 0.3 % of the image's diagonal, rounded up.
  PrecisionRecall boundary;
  /// Objects whose F with their cluster is above .75.
  double atThreeQuarters = 0;
};

/// Clusters and objects are assigned one to one for the greatest sum of F. No cluster has a precision of 1,
/// and no object a recall of 1, as in the published code. `truth` and errors: see scoreClusters().
SegmentationMeasures measureClusters(const cv::Mat& truth, const std::vector<PixelSet>& clusters);

}  // namespace estancia::experiments
