// Object crop: the square image of one object that an image classifier gets, from an image or from points.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "estancia/core/options.hpp"
#include "estancia/core/point_cloud.hpp"

namespace estancia {

struct CropOptions {
  enum class Background {
    /// Background unchanged: best for networks that were trained on photographs.
    kept,
    gray,
    /// The mean color of the object.
    mean
  };
  Background background = Background::kept;
  /// Added on every side, as a share of the object's longer side.
  double margin = 0;
  /// The central part of an image's side that labelers use; undone here, so that they see the whole object.
  double crop = 0.875;
};
OptionGroup declare(CropOptions& options);

/// The square around `box` (pixels of `bgr`, CV_8UC3) whose central `crop` just contains it, not resized;
/// beyond the image it has the background, or gray where that is kept. `mask` (CV_8U, the size of `bgr`, not
/// 0 on the object) may be empty only when the background is kept. Throws Error (invalidInput, mismatch,
/// invalidOption) on another type of image, a box that is empty or leaves the image, a mask that is missing
/// or of another size, and on options out of range.
cv::Mat cropObject(const cv::Mat& bgr, const cv::Rect& box, const cv::Mat& mask = {},
                   const CropOptions& options = {});

/// Renders a cloud into a square of `size` pixels (1 to 4096), as large in it as cropObject() would show it:
/// points are discs on gray, the nearest in front, shaded by depth where they have no colors. The direction
/// is the one of 120 around and above (z is up) that shows the largest part. Throws Error (invalidInput,
/// invalidOption) when no point is finite, on a cloud that breaks its invariant, and on options out of range.
cv::Mat renderObject(const PointCloud& cloud, int size = 299, const CropOptions& options = {});

}  // namespace estancia
