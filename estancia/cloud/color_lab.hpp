// CIELAB: colors in which distances are about those that people see, and the noise of a cloud's colors.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/matx.hpp>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

class Neighbors;

/// L* in [0, 100], a* and b* within about ±110, of an sRGB color (BGR) under D65 (CIE 15:2004; IEC
/// 61966-2-1).
cv::Vec3f labOf(const cv::Vec3b& bgr);
/// One a color.
std::vector<cv::Vec3f> labOf(const std::vector<cv::Vec3b>& colors);

/// The standard deviation of each channel's noise [units of CIELAB]: from the differences between about 2,000
/// points and their nearest, whose median ignores texture and edges. At least the rounding of 8 bits.
/// `points` are those of the colors, one each.
double estimateColorNoise(const Neighbors& points, const std::vector<cv::Vec3f>& lab);

}  // namespace estancia
