// A thing in a cloud → the image of it that labelers look at.
#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

struct CropOptions {
  enum class Background {
    kept,  ///< as the image has it: best for networks that learned from photographs
    gray,
    mean  ///< the mean color of the thing
  };
  Background background = Background::kept;
  double margin = 0;  ///< added on every side, in shares of the longer side of the thing; 0 … 4
  /// What labelers look at of an image's side, undone here so that they see the thing whole; 0.25 … 1.
  double crop = 0.875;
};

/// The square around `box` (pixels of `bgr`, CV_8UC3) whose middle `crop` just holds it, not resized; beyond
/// the image it is as the background, or gray where that is kept. `mask` (CV_8U, the size of `bgr`, not 0
/// on the thing) is needed unless the background is kept; else it may be empty. Throws Error on another type
/// of image, a box that is empty or leaves the image, a mask that is missing or of another size, and on
/// options out of range.
cv::Mat cropObject(const cv::Mat& bgr, const cv::Rect& box, const cv::Mat& mask = {},
                   const CropOptions& options = {});

/// An image of a cloud without a camera, as wide in its square of `size` pixels (1 … 4096) as cropObject()
/// would have it: points are discs on gray, the nearest in front, shaded by depth where they have no colors.
/// Of 120 directions around and above (z is up) it is seen from the one that shows most of it. Throws Error
/// when no point is finite, on a cloud that is not whole, and on options out of range.
cv::Mat renderObject(const PointCloud& cloud, int size = 299, const CropOptions& options = {});

}  // namespace estancia
