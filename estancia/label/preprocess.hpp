// Preprocessing: an image becomes a network's input tensor.
#pragma once

#include <opencv2/core/mat.hpp>

#include "estancia/label/model_spec.hpp"

namespace estancia {

/// The image as float32 blob 1×3×height×width. Takes 1 (gray), 3 (BGR) or 4 (BGRA; alpha is dropped) channels
/// of 8 or 16 bits, any size. Throws Error on anything else.
cv::Mat preprocess(const cv::Mat& image, const Preprocessing& how);

}  // namespace estancia
