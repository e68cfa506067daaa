// A thing in a cloud → the picture of it that labelers look at.
#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

struct PatchOptions {
  enum class Background {
    kept,  ///< as the picture has it: best for networks that learned from photographs
    grey,
    mean  ///< the mean colour of the thing
  };
  Background background = Background::kept;
  double margin = 0;  ///< added on every side, in shares of the longer side of the thing; 0 … 4
  double crop =
      0.875;  ///< what labelers look at of a picture's side, undone here so that they see the thing whole
};

/// The square around `box` (pixels of `bgr`) whose middle `crop` just holds it, and grey where that leaves
/// the picture. `mask` (CV_8U, the size of `bgr`, not 0 on the thing) is needed unless the background is
/// kept; else it may be empty. Throws Error on an empty picture or box, a box outside of the picture, a mask
/// that is missing or of another size, and on options out of range.
cv::Mat patchOf(const cv::Mat& bgr, const cv::Rect& box, const cv::Mat& mask = {},
                const PatchOptions& options = {});

/// A picture of a cloud without a camera: its points as discs on grey, seen from where most of it shows;
/// without colours shaded by depth. Square, `size` pixels. Throws Error when no point is finite.
cv::Mat renderPatch(const PointCloud& cloud, int size = 299, const PatchOptions& options = {});

}  // namespace estancia
